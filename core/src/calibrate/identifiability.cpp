#include "calibrate/identifiability.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace tendril {
namespace {

/// Eigenvalues of normal equations with a diagonal of 1 are 0 below this: the square of what double precision leaves
/// of a Jacobian.
constexpr double least_eigenvalue = 1e-13;
/// An unknown with less of an undetermined direction than this is not touched by it.
constexpr double least_share = 0.03;

}  // namespace

Identifiability identify(const Eigen::MatrixXd& normal, double variance, const std::vector<bool>& free,
                         double largest_error) {
  const Eigen::Index n = normal.rows();
  Identifiability out{Eigen::MatrixXd::Zero(n, n), {}, std::vector<bool>(static_cast<std::size_t>(n), true)};
  std::vector<Eigen::Index> index;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (free[static_cast<std::size_t>(i)]) index.push_back(i);
  }
  const Eigen::MatrixXd asked = normal(index, index);
  // Columns of the Jacobian of one length: units then do not count.
  const Eigen::VectorXd size = asked.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = size.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd even = inverse.asDiagonal() * asked * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(even);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(even.rows(), even.rows());
  const auto add = [&](Eigen::VectorXd direction) {
    direction.normalize();
    for (Eigen::Index i = 0; i < direction.size(); ++i) {
      if (std::abs(direction[i]) > least_share)
        out.determined[static_cast<std::size_t>(index[static_cast<std::size_t>(i)])] = false;
    }
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(n);
    whole(index) = direction;
    out.undetermined.push_back(std::move(whole));
  };
  for (Eigen::Index i = 0; i < size.size(); ++i) {
    if (size[i] == 0.0) add(Eigen::VectorXd::Unit(size.size(), i));
  }
  for (Eigen::Index k = 0; k < parts.eigenvalues().size(); ++k) {
    const Eigen::VectorXd direction = inverse.asDiagonal() * parts.eigenvectors().col(k);
    if (direction.isZero(0.0)) continue;
    const double value = parts.eigenvalues()[k];
    if (value <= least_eigenvalue) {
      add(direction);
    } else {
      covariance += variance / value * direction * direction.transpose();
    }
  }
  // What is determined in principle may still be known too badly to be used.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(covariance);
  for (Eigen::Index k = spread.eigenvalues().size() - 1; k >= 0; --k) {
    if (spread.eigenvalues()[k] > largest_error * largest_error) add(spread.eigenvectors().col(k));
  }
  out.covariance(index, index) = covariance;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (out.determined[static_cast<std::size_t>(i)]) continue;
    out.covariance.row(i).setZero();
    out.covariance.col(i).setZero();
  }
  return out;
}

}  // namespace tendril
