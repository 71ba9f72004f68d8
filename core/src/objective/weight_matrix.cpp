#include "tendril/weight_matrix.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

#include "tendril/error.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

namespace {

[[noreturn]] void refuse(std::string_view name, const std::string& found, const std::string& expected) {
  throw Error("option '" + std::string(name) + "': found " + found + "; expected " + expected);
}

Eigen::MatrixXd square_matrix(const NumberTable& table, int size, std::string_view name) {
  if (table.rows == 1 && table.columns == 1) return Eigen::MatrixXd::Identity(size, size) * table(0, 0);
  if (table.rows != size || table.columns != size) {
    refuse(name, "a matrix of " + std::to_string(table.rows) + " x " + std::to_string(table.columns),
           std::to_string(size) + " x " + std::to_string(size) + ", its diagonal of " + std::to_string(size) +
               " numbers, or one number");
  }
  Eigen::MatrixXd q(size, size);
  for (int i = 0; i < size; ++i) {
    for (int k = 0; k < size; ++k) q(i, k) = table(i, k);
  }
  return q;
}

NumberTable as_table(const Eigen::MatrixXd& matrix) {
  NumberTable table{static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols()), {}};
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) table.values.push_back(matrix(i, k));
  }
  return table;
}

}  // namespace

NumberTable weight_root(const NumberTable& table, int size, std::string_view name) {
  // Numbers arrive rounded to 12 digits, so that much may be missing from symmetry and from the eigenvalue 0.
  constexpr double tolerance = 1e-11;
  const Eigen::MatrixXd q = square_matrix(table, size, name);
  const double largest = q.cwiseAbs().maxCoeff();
  for (int i = 0; i < size; ++i) {
    for (int k = 0; k < i; ++k) {
      if (std::abs(q(i, k) - q(k, i)) <= tolerance * largest) continue;
      refuse(name,
             "a matrix that is not symmetric: entry (" + std::to_string(k + 1) + "," + std::to_string(i + 1) + ") is " +
                 shown(q(k, i)) + ", entry (" + std::to_string(i + 1) + "," + std::to_string(k + 1) + ") is " +
                 shown(q(i, k)),
             "a symmetric matrix");
    }
  }
  if (q.isDiagonal(0.0)) {
    if (q.diagonal().minCoeff() < 0.0) {
      refuse(name, "the weight " + shown(q.diagonal().minCoeff()), "weights >= 0");
    }
    return as_table(q.cwiseSqrt());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(q);
  const double smallest = eigen.eigenvalues()[0];
  if (smallest < -tolerance * largest) {
    refuse(name, "a matrix with the eigenvalue " + shown(smallest), "a positive semidefinite matrix");
  }
  return as_table(eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose());
}

}  // namespace tendril
