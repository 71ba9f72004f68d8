// Each objective plugin by its formula, and the coordinate plugins beside the formulas of Table I.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "raw_values.hpp"
#include "support/contains.hpp"
#include "tendril/bounded_off_target.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::plugins {

namespace {

using List = RawValue::List;

Registry& registry() {
  static Registry built(Catalog(search_places({})));
  return built;
}

RawValue matrix(const std::vector<std::vector<double>>& rows) {
  List list;
  for (const auto& row : rows) list.push_back(numbers(row));
  return {list};
}

/// A finger with two contacts and two moments.
struct TwoContacts {
  std::vector<ContactQuantities<double>> contacts{
      {.x = 0.3, .y = -0.2, .normal_x = 0.6, .normal_y = 0.8, .force = 1.5, .reference_x = 0.5, .reference_y = 0.1},
      {.x = 0.7, .y = 0.4, .normal_x = -0.8, .normal_y = 0.6, .force = 0.5, .reference_x = 0.4, .reference_y = 0.9}};
  std::vector<double> moments{1.2, -0.7};
  Target target{{0.9, 0.3}, 0.25, true, true};
};

/// What a term adds up to, and in which form.
struct Sums {
  double squares = 0.0;
  double smooth = 0.0;
  std::size_t residuals = 0;
};

Sums sums(const std::string& plugin, const RawOptions& options = {}, const TwoContacts& world = {}) {
  const auto term = make(registry().objective(plugin), options);
  Quantities<double> x;
  x.tip = {0.8, 0.35, 0.55, 0.0};
  x.contacts = world.contacts;
  x.moments = world.moments;
  x.target = world.target;
  std::vector<double> residuals(16);
  Contribution<double> out(residuals);
  term->evaluate(x, out);
  Sums found{0.0, out.smooth_part(), out.residual_count()};
  for (std::size_t i = 0; i < found.residuals; ++i) found.squares += residuals[i] * residuals[i];
  return found;
}

/// Sums of a few products of numbers of order one.
constexpr double rounding = 1e-14;

void expect_squares(const Sums& found, double expected, std::size_t residuals) {
  EXPECT_NEAR(found.squares, expected, rounding);
  EXPECT_EQ(found.residuals, residuals);
  EXPECT_EQ(found.smooth, 0.0);
}

TEST(TipPoseValue, IsTheQuadraticFormOfTheError) {
  const Eigen::Vector3d e(0.8 - 0.9, 0.35 - 0.3, 0.55 - 0.25);
  expect_squares(sums("tip_pose"), e.squaredNorm(), 3);
  const Eigen::Matrix3d q{{2.0, 0.5, 0.1}, {0.5, 1.0, -0.2}, {0.1, -0.2, 3.0}};
  expect_squares(sums("tip_pose", {{"weights", matrix({{2.0, 0.5, 0.1}, {0.5, 1.0, -0.2}, {0.1, -0.2, 3.0}})}}),
                 e.dot(q * e), 3);
  // A matrix for the position alone leaves the angle to its own weight.
  expect_squares(sums("tip_pose", {{"weights", matrix({{2.0, 0.5}, {0.5, 1.0}})}, {"angle_weight", {7.0}}}),
                 e.head<2>().dot(q.topLeftCorner<2, 2>() * e.head<2>()) + 7.0 * e[2] * e[2], 3);
  expect_squares(sums("tip_pose", {{"weights", {4.0}}, {"angle_weight", {0.0}}}), 4.0 * e.head<2>().squaredNorm(), 3);
}

TEST(TipPoseValue, CountsWhatTheTargetLacksAsMet) {
  TwoContacts world;
  world.target.has_angle = false;
  expect_squares(sums("tip_pose", {}, world), 0.01 + 0.0025, 3);
  world.target.has_position = false;
  expect_squares(sums("tip_pose", {}, world), 0.0, 3);
}

TEST(ActuationEffortValue, IsTheQuadraticFormOfTheMoments) {
  expect_squares(sums("actuation_effort"), 1.44 + 0.49, 2);
  expect_squares(sums("actuation_effort", {{"weights", {3.0}}}), 3.0 * (1.44 + 0.49), 2);
  expect_squares(sums("actuation_effort", {{"weights", numbers({2.0, 5.0})}}), 2.0 * 1.44 + 5.0 * 0.49, 2);
  expect_squares(sums("actuation_effort", {{"weights", matrix({{2.0, 0.5}, {0.5, 5.0}})}}),
                 2.0 * 1.44 + 5.0 * 0.49 - 2.0 * 0.5 * 1.2 * 0.7, 2);
}

TEST(ContactProximityValue, IsTheQuadraticFormOfTheWayToTheReferencePoint) {
  // (0.2, 0.3) and (-0.3, 0.5).
  expect_squares(sums("contact_proximity"), 0.04 + 0.09 + 0.09 + 0.25, 4);
  expect_squares(sums("contact_proximity", {{"weights", matrix({{2.0, 0.5}, {0.5, 3.0}})}}),
                 2.0 * 0.04 + 3.0 * 0.09 + 2.0 * 0.5 * 0.06 + 2.0 * 0.09 + 3.0 * 0.25 - 2.0 * 0.5 * 0.15, 4);
}

TEST(ContactForceValue, IsMinusTheSumOfForces) {
  const Sums found = sums("contact_force");
  EXPECT_NEAR(found.smooth, -2.0, rounding);
  EXPECT_EQ(found.residuals, 0U);
}

TEST(GraspBalanceValue, IsTheForceAlongTheAxisSquaredOrAsItIs) {
  // -(1.5 * 0.6 - 0.5 * 0.8)
  const double force = -0.5;
  expect_squares(sums("grasp_balance"), force * force, 1);
  const Sums linear = sums("grasp_balance", {{"form", {std::string("linear")}}});
  EXPECT_NEAR(linear.smooth, force, rounding);
  EXPECT_EQ(linear.residuals, 0U);
}

TEST(ObjectiveBounds, AreThoseOfTheForm) {
  const auto bound = [](const char* plugin, const RawOptions& options = {}) {
    return make(registry().objective(plugin), options)->lower_bound();
  };
  EXPECT_EQ(bound("tip_pose"), 0.0);
  EXPECT_EQ(bound("actuation_effort"), 0.0);
  EXPECT_EQ(bound("contact_proximity"), 0.0);
  EXPECT_EQ(bound("grasp_balance"), 0.0);
  EXPECT_EQ(bound("grasp_balance", {{"form", {std::string("linear")}}}), -infinity);
  EXPECT_EQ(bound("contact_force"), -infinity);
}

TEST(ObjectiveBounds, OffTheTargetIsThatOfTheLeastWeightOfThePosition) {
  const auto bound = [](const RawOptions& options) {
    const auto term = make(registry().objective("tip_pose"), options);
    return dynamic_cast<const BoundedOffTarget&>(*term).lower_bound_off_target(0.3);
  };
  EXPECT_NEAR(bound({}), 0.09, rounding);
  EXPECT_NEAR(bound({{"weights", numbers({2.0, 0.5})}}), 0.045, rounding);
  EXPECT_EQ(bound({{"weights", numbers({2.0, 0.0, 1.0})}}), 0.0);
}

TEST(ObjectiveReads, AreWhatTheFormulaNeeds) {
  const auto reads = [](const char* plugin, const RawOptions& options = {}) {
    return make(registry().objective(plugin), options)->reads();
  };
  EXPECT_TRUE(reads("tip_pose").tip_position);
  EXPECT_TRUE(reads("actuation_effort").moments);
  EXPECT_TRUE(reads("contact_proximity").contact_point);
  EXPECT_TRUE(reads("contact_force").contact_force);
  const Reads balance = reads("grasp_balance");
  EXPECT_TRUE(balance.contact_normal);
  EXPECT_TRUE(balance.contact_force);
  for (const char* plugin : {"actuation_effort", "contact_proximity", "contact_force", "grasp_balance"}) {
    EXPECT_FALSE(reads(plugin).target) << plugin;
  }
  // An angle without weight of its own still counts where the matrix couples it.
  EXPECT_TRUE(reads("tip_pose", {{"weights", numbers({1.0, 1.0, 0.5})}}).tip_angle);
  EXPECT_FALSE(reads("tip_pose", {{"weights", numbers({1.0, 1.0, 0.0})}, {"angle_weight", {2.0}}}).tip_angle);
}

std::string refusal(const char* plugin, const RawOptions& options) {
  try {
    make(registry().objective(plugin), options);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(ObjectiveOptions, ThatMakeNoSenseAreRefused) {
  EXPECT_TRUE(contains_text(refusal("tip_pose", {{"angle_weight", {-1.0}}}), "angle_weight"));
  EXPECT_TRUE(contains_text(refusal("grasp_balance", {{"form", {std::string("cubic")}}}), "'square', 'linear'"));
  EXPECT_TRUE(contains_text(refusal("actuation_effort", {{"weights", numbers({1.0, -2.0})}}), "the weight -2"));
  EXPECT_TRUE(contains_text(refusal("actuation_effort", {{"weights", matrix({{1.0, 3.0}, {3.0, 1.0}})}}),
                            "a matrix with the eigenvalue -2"));
  EXPECT_TRUE(contains_text(refusal("actuation_effort", {{"weights", matrix({{1.0, 0.5}, {0.4, 1.0}})}}),
                            "entry (1,2) is 0.5, entry (2,1) is 0.4"));
  EXPECT_TRUE(contains_text(refusal("contact_force", {{"weights", {1.0}}}), "has no option 'weights'"));
}

struct Functions {
  Eigen::MatrixXd value, first, second;
};

Functions basis(const std::string& plugin, const std::vector<double>& sigma, const RawOptions& options = {}) {
  const auto model = make(registry().coordinates(plugin), options);
  const Eigen::MatrixXd empty(static_cast<Eigen::Index>(sigma.size()), model->function_count());
  Functions found{empty, empty, empty};
  model->evaluate(sigma, found.value, found.first, found.second);
  return found;
}

const std::vector<double> places{0.0, 0.3, 0.7, 1.0};

TEST(CoordinateValues, OfConstantCurvatureAreAStraightLine) {
  const Functions found = basis("pcc", places);
  EXPECT_EQ(found.value, Eigen::Vector4d(0.0, 0.3, 0.7, 1.0));
  EXPECT_EQ(found.first, Eigen::Vector4d::Ones());
  EXPECT_EQ(found.second, Eigen::Vector4d::Zero());
}

TEST(CoordinateValues, OfSmoothCurvatureAreTheThreeFunctionsOfTableOne) {
  const Functions found = basis("psc", places);
  ASSERT_EQ(found.value.cols(), 3);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double s = places[static_cast<std::size_t>(i)];
    // The integrals of P_0, P_1 and P_2 at 2 s - 1 from 0 to s.
    EXPECT_NEAR(found.value(i, 0), s, 1e-15);
    EXPECT_NEAR(found.value(i, 1), s * s - s, 1e-15);
    EXPECT_NEAR(found.value(i, 2), 2.0 * s * s * s - 3.0 * s * s + s, 1e-15);
    EXPECT_NEAR(found.second(i, 2), 12.0 * s - 6.0, 1e-14);
  }
  const Functions legendre = basis("legendre", places, {{"order", {std::int64_t{3}}}});
  EXPECT_EQ(found.value, legendre.value);
  EXPECT_EQ(found.first, legendre.first);
  EXPECT_EQ(found.second, legendre.second);
}

TEST(CoordinateNames, SayWhatEachIs) {
  EXPECT_EQ(make(registry().coordinates("pcc"), {})->coordinate_name(0), "curvature times length of the piece [rad]");
  EXPECT_EQ(make(registry().coordinates("psc"), {})->coordinate_name(2), "q_3 [rad]");
  EXPECT_TRUE(make(registry().coordinates("pcc"), {})->breaks().empty());
}

TEST(CoordinateOptions, HaveTheirRange) {
  const auto message = [](const char* plugin, const char* option, std::int64_t value) -> std::string {
    try {
      make(registry().coordinates(plugin), {{option, {value}}});
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  for (const std::int64_t value : {std::int64_t{0}, std::int64_t{LegendreBasis::maximum_order} + 1}) {
    EXPECT_TRUE(contains_text(message("legendre", "order", value), "from 1 to")) << value;
  }
  for (const std::int64_t value : {std::int64_t{0}, std::int64_t{65}}) {
    EXPECT_TRUE(contains_text(message("legendre", "pieces", value), "from 1 to 64")) << value;
    EXPECT_TRUE(contains_text(message("pcc", "pieces", value), "from 1 to 64")) << value;
  }
  EXPECT_EQ(message("legendre", "order", LegendreBasis::maximum_order), "nothing was refused");
  EXPECT_TRUE(contains_text(message("psc", "order", 3), "has no option 'order'"));
}

}  // namespace

}  // namespace tendril::plugins
