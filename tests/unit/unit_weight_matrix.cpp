#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <string>

#include "support/contains.hpp"
#include "tendril/error.hpp"
#include "tendril/weight_matrix.hpp"

namespace tendril {
namespace {

NumberTable square_table(int n, std::vector<double> values) { return {n, n, std::move(values)}; }

Eigen::MatrixXd root_of(const NumberTable& table, int size) {
  const NumberTable root = weight_root(table, size, "weights");
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      root.values.data(), root.rows, root.columns);
}

std::string refusal(const NumberTable& table, int size) {
  try {
    weight_root(table, size, "weights");
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(WeightRoot, SquaresToTheMatrix) {
  const NumberTable q = square_table(3, {4, 1, 0.5, 1, 3, -0.2, 0.5, -0.2, 2});
  const Eigen::MatrixXd root = root_of(q, 3);
  const Eigen::MatrixXd again = root.transpose() * root;
  for (int i = 0; i < 3; ++i) {
    // A few roundings of numbers of size 4.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(again(i, k), q(i, k), 1e-14);
  }
}

TEST(WeightRoot, ADiagonalGivesItsRootsExactly) {
  const Eigen::MatrixXd root = root_of(square_table(2, {4, 0, 0, 9}), 2);
  EXPECT_EQ(root, (Eigen::MatrixXd(2, 2) << 2, 0, 0, 3).finished());
}

TEST(WeightRoot, ANumberIsAMultipleOfTheIdentity) {
  EXPECT_EQ(root_of({1, 1, {4.0}}, 3), Eigen::MatrixXd(2.0 * Eigen::MatrixXd::Identity(3, 3)));
}

TEST(WeightRoot, ASingularMatrixIsTaken) {
  const Eigen::MatrixXd root = root_of(square_table(2, {1, 1, 1, 1}), 2);
  // (1, -1) costs nothing; rounding of an eigenvalue 1e-16 under the root.
  EXPECT_NEAR((root * Eigen::Vector2d(1, -1)).norm(), 0.0, 1e-7);
  EXPECT_NEAR((root * Eigen::Vector2d(1, 1)).squaredNorm(), 4.0, 1e-14);
}

TEST(AddWeighted, GivesOneResidualForEachRow) {
  std::array<double, 2> residuals{};
  Contribution<double> out(residuals);
  const std::array<double, 2> x{3.0, 5.0};
  add_weighted<double>({2, 2, {1, 2, 0, -1}}, x, out);
  EXPECT_EQ(out.residual_count(), 2U);
  EXPECT_EQ(residuals, (std::array<double, 2>{13.0, -5.0}));
}

TEST(WeightRoot, WrongSizesAreRefused) {
  EXPECT_TRUE(contains_text(refusal(square_table(2, {1, 0, 0, 1}), 3), "found a matrix of 2 x 2; expected 3 x 3"));
  EXPECT_TRUE(contains_text(refusal({1, 3, {1, 2, 3}}, 3), "found a matrix of 1 x 3"));
}

TEST(WeightRoot, AsymmetryIsRefusedWithTheEntries) {
  EXPECT_TRUE(contains_text(refusal(square_table(2, {1, 0.5, 0.25, 1}), 2), "entry (1,2) is 0.5, entry (2,1) is 0.25"));
}

TEST(WeightRoot, NegativeDirectionsAreRefused) {
  EXPECT_TRUE(contains_text(refusal(square_table(2, {1, 2, 2, 1}), 2), "eigenvalue -1"));
  EXPECT_TRUE(contains_text(refusal(square_table(2, {1, 0, 0, -3}), 2), "weight -3"));
  EXPECT_TRUE(contains_text(refusal({1, 1, {-1.0}}, 2), "weight -1"));
}

}  // namespace
}  // namespace tendril
