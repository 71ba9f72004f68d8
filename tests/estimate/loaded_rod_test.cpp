// Equilibria under normal forces and their exact derivatives.

#include "estimate/loaded_rod.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimate/truth.hpp"
#include "scene/make_rod.hpp"

namespace tendril {
namespace {

Rod rod_of(const test::Truth& truth) {
  const Scene scene = test::scene_of(truth, Eigen::VectorXd::Zero(2), 0.0, 1);
  return make_rod(scene, scale_of(scene));
}

std::vector<double> equal_arc_lengths(int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back((i + 1.0) / count);
  return out;
}

// The boundary-value problem's forces, given to the rod without any obstacle, must bend it to the same shape.
TEST(LoadedRod, AgreesWithTheBoundaryValueProblem) {
  for (const test::Truth& truth :
       {test::braced_arm(), test::held_from_above(), test::stepped_finger(), test::two_pegs(), test::close_pegs()}) {
    const Scene scene = test::scene_of(truth, Eigen::VectorXd::Zero(2), 0.0, 1);
    const Scale scale = scale_of(scene);
    const support::BvpSolution solution = truth.solve();
    const Eigen::VectorXd right = test::parameters(truth, solution);
    std::vector<NormalForce> forces;
    for (Eigen::Index i = 0; i < right.size(); i += 2) {
      forces.push_back({right[i] / scale.force(), right[i + 1] / scale.length});
    }
    std::vector<double> moments;
    for (const double m : truth.moments) moments.push_back(m / scale.moment());
    const LoadedRod rod(make_rod(scene, scale), moments, 20, 4.0);
    const LoadedRod::Shape shape = rod.solve(
        forces, [&](double s) { return scale.length * solution.at(std::min(s, 0.999999) * scale.length).curvature; });
    ASSERT_TRUE(shape.converged);
    const LoadedRod::Response response = rod.response(shape, equal_arc_lengths(20));
    const Eigen::VectorXd exact = test::exact_points(truth, solution, 20) / scale.length;
    // The program's data are rounded to 12 digits.
    EXPECT_LE((response.points - exact).lpNorm<Eigen::Infinity>(), 1e-10);
  }
}

// Central differences with step h leave h^2 and 1e-15/h: about 1e-9 here.
TEST(LoadedRod, DerivativesAreThoseOfCentralDifferences) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  const Rod plain = rod_of(test::braced_arm());
  const Rod stepped = rod_of(test::stepped_finger());
  Rod stretching = stepped;
  stretching.stretch_order = Rod::stretch_as_fine;
  for (Rod::Segment& s : stretching.segments) s.axial = 30.0;
  stretching.actuators.back().thrust = -2.0;
  const std::vector<double> places = equal_arc_lengths(13);
  for (int trial = 0; trial < 12; ++trial) {
    const bool two_spans = trial % 2 == 1;
    std::vector<double> moments{uniform(-2.0, 2.0)};
    if (two_spans) moments.push_back(uniform(-2.0, 2.0));
    const LoadedRod rod(trial % 4 == 3 ? stretching : two_spans ? stepped : plain, moments, 10, 4.0);
    std::vector<NormalForce> forces{{uniform(-4.0, 4.0), uniform(0.1, 0.45)}, {uniform(-2.0, 2.0), uniform(0.5, 0.95)}};
    if (trial % 3 == 0) forces.pop_back();
    const LoadedRod::Shape shape = rod.solve(forces, [](double) { return 0.3; });
    ASSERT_TRUE(shape.converged) << trial;
    const LoadedRod::Response response = rod.response(shape, places);
    constexpr double h = 1e-5;
    for (std::size_t k = 0; k < forces.size(); ++k) {
      for (int of_place = 0; of_place < 2; ++of_place) {
        Eigen::VectorXd side[2];
        for (int i = 0; i < 2; ++i) {
          std::vector<NormalForce> moved = forces;
          (of_place == 1 ? moved[k].arc_length : moved[k].force) += i == 0 ? -h : h;
          const LoadedRod::Shape other = rod.solve(moved, shape);
          ASSERT_TRUE(other.converged);
          side[i] = rod.response(other, places).points;
        }
        const Eigen::VectorXd difference = (side[1] - side[0]) / (2.0 * h);
        const Eigen::VectorXd rate = response.rates.col(2 * static_cast<Eigen::Index>(k) + of_place);
        EXPECT_LE((rate - difference).lpNorm<Eigen::Infinity>(), 1e-7 * (1.0 + rate.lpNorm<Eigen::Infinity>()))
            << "trial " << trial << ", force " << k << (of_place == 1 ? ", place" : ", force");
      }
    }
  }
}

// A further force of nothing is a knot more, which does not change the shape but its exactness.
TEST(LoadedRod, InfluenceOfAForceThatIsNotThereYet) {
  const LoadedRod rod(rod_of(test::braced_arm()), {0.5}, 30, 4.0);
  const std::vector<double> places = equal_arc_lengths(9);
  const LoadedRod::Shape one = rod.solve({{1.0, 0.6}}, [](double) { return 0.5; });
  ASSERT_TRUE(one.converged);
  const NormalForce further[] = {{1.0, 0.3}};
  const Eigen::MatrixXd influence = rod.influence(one, places, further);
  const LoadedRod::Shape two = rod.solve({{0.0, 0.3}, {1.0, 0.6}}, one);
  ASSERT_TRUE(two.converged);
  const Eigen::VectorXd exact = rod.response(two, places).rates.col(0);
  // Without the knot the kink is met to the order of the basis cubed.
  EXPECT_LE((influence.col(0) - exact).lpNorm<Eigen::Infinity>(), 1e-4 * exact.lpNorm<Eigen::Infinity>());
}

TEST(LoadedRod, KeepsForcesOffKnotsAndEnds) {
  const LoadedRod rod(rod_of(test::stepped_finger()), {0.5, 0.2}, 10, 4.0);
  const LoadedRod::Shape shape =
      rod.solve({{0.1, -0.5}, {0.1, 0.7}, {0.1, 0.7}, {0.1, 2.0}}, [](double) { return 0.4; });
  ASSERT_TRUE(shape.converged);
  double before = 0.0;
  for (const NormalForce& f : shape.forces) {
    EXPECT_GE(f.arc_length - before, 0.99 * LoadedRod::knot_clearance);
    EXPECT_GE(std::abs(f.arc_length - 0.7), 0.99 * LoadedRod::knot_clearance);
    before = f.arc_length;
  }
  EXPECT_LE(before, 1.0 - 0.99 * LoadedRod::knot_clearance);
}

}  // namespace
}  // namespace tendril
