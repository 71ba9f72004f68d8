// Contacts that push off their normals, seen through the rod's shape alone: made by executions with given ratios of
// friction, and by dead forces, which know nothing of contacts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "estimate/loaded_rod.hpp"
#include "execute_support.hpp"
#include "scene/make_rod.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/estimate.hpp"

namespace tendril::support {
namespace {

/// An estimate from every fifth point of a shape, without noise; `noise`: what is stated, in m, 0: nothing.
Estimate seen(const Scene& scene, const Plan& plan, double friction, double noise) {
  Scene out = scene;
  out.problem = ProblemKind::estimate;
  out.obstacles.clear();
  out.rod.loads.clear();
  out.contact.friction = friction;
  out.measurement.noise = noise;
  out.measurement.moments = plan.moments;
  for (std::size_t i = 5; i < plan.backbone.size(); i += 5) {
    out.measurement.points.push_back({plan.backbone[i].s, {plan.backbone[i].x, plan.backbone[i].y}});
  }
  return estimate(out);
}

/// The arm on its circle under 2.5 N mm, with a given ratio of friction.
Plan rubbed(ForwardScene& s, double ratio) {
  const Execution without = s.run({2.5e-3});
  EXPECT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
  ExecuteControl control;
  control.start = &without.result;
  control.friction = {ratio};
  Execution with = execute(s.scene, s.obstacles, {2.5e-3}, control);
  EXPECT_EQ(with.result.status, PlanStatus::solved) << with.result.message;
  return std::move(with.result);
}

void expect_holds(Interval interval, double value, double within) {
  EXPECT_LE(interval.low, value + within);
  EXPECT_GE(interval.high, value - within);
}

// Noise of a thousandth of the length hides the state of friction: the whole cone stays, and the truth is one end of
// it.
TEST(EstimateFriction, RangeEndsAtTheTruthWhereItSlips) {
  for (const double thickness : {0.0, 6e-3}) {
    for (const double ratio : {-0.6, -0.3, 0.3, 0.6}) {
      SCOPED_TRACE(testing::Message() << "thickness " << thickness << ", ratio " << ratio);
      ForwardScene s = braced_arm();
      s.scene.rod.segments[0].thickness = thickness;
      const Plan truth = rubbed(s, ratio);
      const PlannedContact& contact = truth.contacts.at(0);
      const Estimate found = seen(s.scene, truth, std::abs(ratio), 1e-4);
      ASSERT_EQ(found.contacts.size(), 1U) << found.message;
      ASSERT_TRUE(found.contacts[0].friction);
      const EstimatedFriction& f = *found.contacts[0].friction;
      EXPECT_TRUE(f.whole);
      EXPECT_DOUBLE_EQ(f.ratio.low, -std::abs(ratio));
      EXPECT_DOUBLE_EQ(f.ratio.high, std::abs(ratio));
      EXPECT_TRUE(contains_text(found.assumed, "unknown state"));
      const auto end = [](Interval i, double value) {
        return std::min(std::abs(i.low - value), std::abs(i.high - value));
      };
      EXPECT_LE(end(f.force, contact.force), 1e-5 * contact.force);
      EXPECT_LE(end(f.arc_length, contact.arc_length), 1e-6 * 0.1);
      EXPECT_LE(end(f.tangential_force, contact.tangential), 1e-5 * contact.force);
    }
  }
}

// What the points carry is found: exact ones tell the tangential force itself.
TEST(EstimateFriction, ExactPointsTellTheTangentialForce) {
  for (const double ratio : {-0.45, 0.2}) {
    SCOPED_TRACE(testing::Message() << "ratio " << ratio);
    ForwardScene s = braced_arm();
    const Plan truth = rubbed(s, ratio);
    const PlannedContact& contact = truth.contacts.at(0);
    const Estimate found = seen(s.scene, truth, 0.5, 0.0);
    ASSERT_EQ(found.status, EstimateStatus::solved) << found.message;
    ASSERT_EQ(found.contacts.size(), 1U) << found.message;
    EXPECT_NEAR(found.contacts[0].force, contact.force, 1e-4 * contact.force);
    EXPECT_NEAR(found.contacts[0].tangential_force, contact.tangential, 1e-4 * contact.force);
    EXPECT_NEAR(found.contacts[0].arc_length, contact.arc_length, 1e-5 * 0.1);
    const EstimatedFriction& f = found.contacts[0].friction.value();
    expect_holds(f.ratio, ratio, 1e-3);
    EXPECT_LT(f.ratio.high - f.ratio.low, 0.5);
  }
}

// 93 mN along the normal and 150 mN along the rod look like 147 mN without friction, some 20 mm away. With the
// coefficient stated the range holds the truth; without it the report says what it took for granted.
TEST(EstimateFriction, RangeHoldsWhatAFrictionlessContactHides) {
  for (const double side : {1.0, -1.0}) {
    ForwardScene s;
    s.scene.rod.segments = {{0.6, 0.02, 0.0, 0.0}};
    s.scene.rod.actuators[0].to = 0.6;
    // The rod turns by about half a radian up to there: along its normal and tangent later.
    double turn = 0.3;
    Plan truth;
    for (int i = 0; i < 60; ++i) {
      const Vec2 t{std::cos(turn), std::sin(turn)};
      const Vec2 pulled = 0.093 * turned(t) + 0.150 * t;
      s.scene.rod.loads = {{0.3, 0.3, {pulled.x, side * pulled.y}, 0.0}};
      truth = s.run({0.0}).result;
      ASSERT_EQ(truth.status, PlanStatus::solved) << truth.message;
      turn = side * angle_of(truth)(0.3);
    }
    const Estimate plain = seen(s.scene, truth, 0.0, 3e-4);
    ASSERT_EQ(plain.status, EstimateStatus::solved) << plain.message;
    EXPECT_FALSE(plain.contacts.at(0).friction);
    EXPECT_TRUE(contains_text(plain.assumed, "no friction"));
    const Estimate found = seen(s.scene, truth, 2.0, 3e-4);
    ASSERT_EQ(found.contacts.size(), 1U) << found.message;
    const EstimatedFriction& f = found.contacts[0].friction.value();
    expect_holds(f.force, 0.093, 1e-4);
    expect_holds(f.tangential_force, 0.150, 1e-4);
    expect_holds(f.arc_length, 0.3, 1e-5);
    expect_holds(f.ratio, 0.150 / 0.093, 1e-3);
  }
}

// Central differences with step h leave h^2 and 1e-15/h: about 1e-9 here.
TEST(EstimateFriction, RatesAreThoseOfCentralDifferences) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (const double thickness : {0.0, 0.012}) {
    ForwardScene s = braced_arm();
    s.scene.rod.segments[0].thickness = thickness;
    const Scale scale = scale_of(s.scene);
    const LoadedRod rod(make_rod(s.scene, scale), {uniform(-1.0, 1.0)}, 10, 4.0);
    const std::vector<double> places{0.2, 0.35, 0.5, 0.8, 1.0};
    for (int trial = 0; trial < 4; ++trial) {
      const std::vector<NormalForce> forces{{uniform(-3.0, 3.0), uniform(0.1, 0.45), uniform(-0.9, 0.9)},
                                            {uniform(-2.0, 2.0), uniform(0.5, 0.95), uniform(-0.9, 0.9)}};
      const LoadedRod::Shape shape = rod.solve(forces, [](double) { return 0.2; });
      ASSERT_TRUE(shape.converged);
      const Eigen::MatrixXd rates = rod.response(shape, places).rates;
      const Eigen::MatrixXd lean_rates = rod.lean_rates(shape, places);
      const auto difference = [&](auto change) {
        constexpr double h = 1e-5;
        Eigen::VectorXd side[2];
        for (const int i : {0, 1}) {
          std::vector<NormalForce> moved = forces;
          change(moved, i == 0 ? -h : h);
          const LoadedRod::Shape other = rod.solve(moved, shape);
          EXPECT_TRUE(other.converged);
          side[i] = rod.response(other, places).points;
        }
        return Eigen::VectorXd((side[1] - side[0]) / (2.0 * h));
      };
      for (const Eigen::Index k : {0, 1}) {
        const auto at = static_cast<std::size_t>(k);
        const auto expect_near = [&](const Eigen::VectorXd& rate, const Eigen::VectorXd& exact, const char* what) {
          EXPECT_LE((rate - exact).lpNorm<Eigen::Infinity>(), 1e-7 * (1.0 + rate.lpNorm<Eigen::Infinity>()))
              << "thickness " << thickness << ", trial " << trial << ", " << what << " of contact " << k;
        };
        expect_near(rates.col(2 * k), difference([&](auto& f, double h) { f[at].force += h; }), "force");
        expect_near(rates.col(2 * k + 1), difference([&](auto& f, double h) { f[at].arc_length += h; }), "place");
        expect_near(lean_rates.col(k), difference([&](auto& f, double h) { f[at].lean += h; }), "lean");
      }
    }
  }
}

TEST(EstimateFriction, IsLeftOutOnRequest) {
  ForwardScene s = braced_arm();
  const Plan truth = rubbed(s, 0.3);
  s.scene.contact.friction_state = FrictionState::none;
  const Estimate found = seen(s.scene, truth, 0.3, 1e-4);
  ASSERT_EQ(found.contacts.size(), 1U);
  EXPECT_FALSE(found.contacts[0].friction);
}

}  // namespace
}  // namespace tendril::support
