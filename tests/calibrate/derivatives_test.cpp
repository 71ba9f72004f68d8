// Rates of fitted shapes by every kind of unknown, against central differences.

#include <gtest/gtest.h>

#include "calibrate/fit.hpp"

namespace tendril {
namespace {

/// Two segments, one of them tapered and bent at rest; a tendon that comes nearer to the backbone; loads at a point and
/// at the tip; a base that is turned and moved. Where it stretches the tendon pulls along it, too.
SoughtNumbers everything(bool stretches) {
  SoughtNumbers problem;
  Rod::Segment first{0.0, 0.4, 1.0, 3.0, 0.2};
  Rod::Segment second{0.4, 1.0, 0.7, 2.0, -0.3};
  second.more_stiffness = {-0.2, -0.1};
  second.more_weight = {-0.5};
  problem.rod.segments = {first, second};
  problem.rod.actuators = {{0.0, 0.9}};
  problem.rod.actuators[0].profile = {{0.0, 0.9, {1.0, -0.4}}};
  if (stretches) {
    problem.rod.stretch_order = Rod::stretch_as_fine;
    problem.rod.segments[0].axial = 20.0;
    problem.rod.segments[1].axial = 15.0;
    problem.rod.segments[1].more_axial = {-3.0};
    problem.rod.actuators[0].thrust = -2.0;
  }
  problem.rod.loads = {{0.6, 0.6}};
  problem.rod.base = {0.1, -0.2};
  problem.rod.base_angle = 0.3;
  problem.angle_weight = 0.5;
  for (const double input : {0.4, 1.0}) {
    SeenShape shape;
    shape.inputs = Eigen::VectorXd::Constant(1, input);
    shape.moments = Eigen::VectorXd::Constant(1, 0.1);
    shape.loads.gravity = {0.3, -0.8};
    shape.loads.at = {{{0.2, 0.3}, 0.1}};
    shape.loads.tip = {{-0.1, 0.4}, -0.2};
    for (const double s : {0.2, 0.6, 1.0}) {
      SeenMarker marker{s, 0.05, -0.03, true, true, {s, 0.1}, 0.2};
      shape.markers.push_back(marker);
    }
    problem.shapes.push_back(shape);
  }
  using U = CalibrationUnknown;
  problem.unknowns = {{U::stiffness, 0},      {U::stiffness, 1}, {U::density, -1},  {U::rest_curvature, 0},
                      {U::rest_curvature, 1}, {U::moment, 0, 1}, {U::moment, 0, 3}, {U::base_angle, -1},
                      {U::base_x, -1},        {U::base_y, -1}};
  if (stretches) {
    // A modulus of one segment, and of the other the two stiffnesses that it is.
    problem.unknowns[0].kind = U::modulus;
    problem.unknowns.insert(problem.unknowns.end(), {{U::axial_stiffness, 1}, {U::force, 0, 1}, {U::force, 0, 2}});
  }
  return problem;
}

class RatesOfShapes : public testing::TestWithParam<bool> {};

TEST_P(RatesOfShapes, AreThoseOfDifferences) {
  const SoughtNumbers problem = everything(GetParam());
  const Deadline deadline(nullptr, 60.0);
  CalibrationFit fit(problem, 10, 3.0, deadline);
  Eigen::VectorXd values(13);
  values << 1.1, 0.9, 1.2, 0.25, -0.2, 0.5, 0.3, 0.35, 0.12, -0.18, 1.3, 0.8, -0.6;
  values.conservativeResize(static_cast<Eigen::Index>(problem.unknowns.size()));
  const std::vector<int> both{0, 1};
  const FittedPoint point = fit.at(values, both, nullptr);
  ASSERT_TRUE(point.found);
  constexpr double step = 1e-5;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    Eigen::VectorXd more = values, less = values;
    more[i] += step;
    less[i] -= step;
    const FittedPoint ahead = fit.at(more, both, &point);
    const FittedPoint behind = fit.at(less, both, &point);
    for (std::size_t s = 0; s < 2; ++s) {
      const Eigen::VectorXd difference = (ahead.residuals[s] - behind.residuals[s]) / (2.0 * step);
      EXPECT_LE((point.jacobians[s].col(i) - difference).lpNorm<Eigen::Infinity>(), 1e-9) << "unknown " << i;
      // A column of zeros would agree with itself.
      EXPECT_GE(difference.lpNorm<Eigen::Infinity>(), 1e-3) << "unknown " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfFixedLengthAndStretching, RatesOfShapes, testing::Bool());

}  // namespace
}  // namespace tendril
