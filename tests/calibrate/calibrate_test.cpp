// Calibrations of shapes that the boundary-value problem made.

#include "tendril/calibrate.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <sstream>

#include "calibrate/measured.hpp"
#include "estimate/truth.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "support/repetitions.hpp"

namespace tendril {
namespace {

using test::MeasuredArm;
using test::unknown;

/// Moments and payloads of ten recordings.
std::vector<Recording> recordings_of(const MeasuredArm& arm, int points) {
  std::vector<Recording> out;
  for (const double payload : {0.0, 0.002}) {
    for (const double moment : {-0.002, 0.0, 0.002, 0.004, 0.006}) {
      out.push_back(arm.recording(moment, payload, points));
    }
  }
  return out;
}

double value(const Calibration& calibration, std::size_t i) { return calibration.numbers.at(i).value; }

// Without noise the points carry the answer to their rounding.
TEST(ExactShapes, GiveBackStiffnessDensityAndRestCurvature) {
  MeasuredArm arm;
  arm.rest_curvature = 3.0;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 8);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density),
                   unknown(CalibrationUnknown::rest_curvature)};
  const Calibration result = calibrate(arm.scene(), spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 4.9 / 4.0, 1e-8);
  EXPECT_NEAR(value(result, 1), 0.84, 1e-8);
  EXPECT_NEAR(value(result, 2), 3.0, 1e-7);
  EXPECT_LE(result.residual_rms, 1e-10 * arm.length);
}

TEST(ExactShapes, GiveBackTheBase) {
  MeasuredArm arm;
  arm.base = {0.003, -0.002};
  arm.base_angle = 0.15;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 5);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::base_angle),
                   unknown(CalibrationUnknown::base_x), unknown(CalibrationUnknown::base_y)};
  Scene scene = arm.scene();
  scene.rod.segments[0].linear_density = arm.density;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 4.9 / 4.0, 1e-8);
  EXPECT_NEAR(value(result, 1), 0.15, 1e-8);
  EXPECT_NEAR(value(result, 2), 0.003, 1e-9);
  EXPECT_NEAR(value(result, 3), -0.002, 1e-9);
}

// Each group stands on a clamp of its own.
TEST(ExactShapes, GiveBackABaseForEachGroup) {
  CalibrationSpec spec;
  for (const double angle : {0.0, 0.05, -0.04}) {
    MeasuredArm arm;
    arm.base_angle = angle;
    for (Recording r : recordings_of(arm, 4)) {
      r.group = "session " + std::to_string(angle);
      r.name += " of " + r.group;
      spec.recordings.push_back(r);
    }
  }
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::base_angle)};
  spec.unknowns[1].per = CalibrationScope::group;
  Scene scene = MeasuredArm{}.scene();
  scene.rod.segments[0].linear_density = MeasuredArm{}.density;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  ASSERT_EQ(result.numbers.size(), 4U);
  EXPECT_NEAR(value(result, 1), 0.0, 1e-8);
  EXPECT_NEAR(value(result, 2), 0.05, 1e-8);
  EXPECT_NEAR(value(result, 3), -0.04, 1e-8);
}

/// The same arm told pressures, whose moment is 2e-8 p + 3e-14 p^2 N m.
std::vector<Recording> pressurized(const MeasuredArm& arm, int points) {
  std::vector<Recording> out;
  for (const double payload : {0.0, 0.002}) {
    for (const double pressure : {0.5e5, 1e5, 1.5e5, 2e5}) {
      Recording r = arm.recording(2e-8 * pressure + 3e-14 * pressure * pressure, payload, points);
      r.inputs = {pressure};
      r.input_kinds = {ActuatorKind::pressure};
      out.push_back(r);
    }
  }
  return out;
}

TEST(ExactTips, AloneGiveBackALawOfPressure) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  spec.recordings = pressurized(arm, 1);
  spec.unknowns = {unknown(CalibrationUnknown::moment), unknown(CalibrationUnknown::stiffness)};
  spec.unknowns[0].degree = 2;
  Scene scene = arm.scene();
  scene.rod.segments[0].linear_density = arm.density;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 2e-8, 1e-15);
  EXPECT_NEAR(value(result, 1), 3e-14, 1e-21);
  EXPECT_NEAR(value(result, 2), 4.9 / 4.0, 1e-7);
  EXPECT_EQ(result.numbers[0].unit, "N m/Pa");
  EXPECT_EQ(result.numbers[1].unit, "N m/Pa^2");
}

/// The arm as one that stretches, of 40 N, weightless.
Scene stretching() {
  Scene scene = MeasuredArm{}.scene();
  scene.coordinates.stretch_order = 1;
  scene.rod.segments[0].axial_stiffness = 40.0;
  scene.rod.segments[0].linear_density = 0.0;
  return scene;
}

// A chamber alone makes an arc of a circle: the moment turns its tip by u L/EI, the axial force N makes it N/EA longer.
TEST(ExactTips, AloneGiveBackMomentAndForceOfAChamber) {
  const Scene scene = stretching();
  const RodSpec& rod = scene.rod;
  CalibrationSpec spec;
  for (const double pressure : {0.5e5, 1e5, 1.5e5, 2e5}) {
    const double turn =
        (2e-8 * pressure + 3e-14 * pressure * pressure) * rod.length() / rod.segments[0].bending_stiffness;
    const double radius = rod.length() * (1.0 + 2e-5 * pressure / 40.0) / turn;
    Recording r;
    r.name = std::to_string(pressure);
    r.inputs = {pressure};
    r.input_kinds = {ActuatorKind::pressure};
    r.markers = {{rod.length(), Vec2{radius * std::sin(turn), radius * (1.0 - std::cos(turn))}, {}}};
    spec.recordings.push_back(r);
  }
  spec.unknowns = {unknown(CalibrationUnknown::moment), unknown(CalibrationUnknown::force)};
  spec.unknowns[0].degree = 2;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 2e-8, 1e-16);
  EXPECT_NEAR(value(result, 1), 3e-14, 1e-21);
  EXPECT_NEAR(value(result, 2), 2e-5, 1e-13);
  EXPECT_EQ(result.numbers[2].unit, "N/Pa");
}

// Hanging straight down a rod gets longer by what hangs on it and by half its own weight, over EA.
TEST(ExactTips, AloneGiveBackAnAxialStiffness) {
  Scene scene = stretching();
  scene.rod.segments[0].linear_density = 0.1;
  scene.rod.base_angle = -0.5 * std::acos(-1.0);
  CalibrationSpec spec;
  for (const double mass : {0.0, 0.05, 0.1}) {
    const double strain = 9.81 * (0.5 * 0.1 * scene.rod.length() + mass) / 50.0;
    Recording r;
    r.name = std::to_string(mass);
    r.inputs = {0.0};
    r.input_kinds = {ActuatorKind::moment};
    r.tip_force = {0.0, -9.81 * mass};
    r.markers = {{scene.rod.length(), Vec2{0.0, -scene.rod.length() * (1.0 + strain)}, {}}};
    spec.recordings.push_back(r);
  }
  spec.unknowns = {unknown(CalibrationUnknown::axial_stiffness)};
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 50.0 / 40.0, 1e-9);
}

// A marker on a stalk that turns with its section, and angles instead of positions.
TEST(ExactShapes, AreSeenOnStalksAndByTheirAngles) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 4);
  for (Recording& r : spec.recordings) {
    for (std::size_t i = 0; i < r.markers.size(); ++i) {
      CalibrationMarker& m = r.markers[i];
      support::RodBvp rod;
      rod.sections = {{arm.length, arm.stiffness, arm.density}};
      rod.actuators = {{0.0, arm.length}};
      rod.gravity = {0.0, -9.81};
      rod.tip_force = {r.tip_force.x, r.tip_force.y};
      support::BvpGuess guess;
      guess.curvature = 0.5 * r.inputs[0] / arm.stiffness;
      const double angle = support::solve(rod, r.inputs, {}, guess).at(m.arc_length).angle;
      const Vec2 t{std::cos(angle), std::sin(angle)};
      if (i % 2 == 0) {
        m.along_normal = 0.01;
        m.along_tangent = -0.002;
        *m.position += 0.01 * turned(t) + -0.002 * t;
      } else {
        m.position.reset();
        m.angle = angle;
      }
    }
  }
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  const Calibration result = calibrate(arm.scene(), spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 4.9 / 4.0, 1e-8);
  EXPECT_NEAR(value(result, 1), 0.84, 1e-8);
}

/// Shares of many noisy calibrations whose truth lies within 1 and 1.96 of the reported errors, and how the errors
/// scatter against the reported ones.
struct Coverage {
  double within_1 = 0.0, within_2 = 0.0, scatter = 0.0;
};

// Of n seeds a share of 0.683 has a standard error of 0.465 / sqrt(n), one of 0.95 of 0.218 / sqrt(n), a deviation one
// of 1 / sqrt(2 n). Bounds of three.
TEST(ErrorBars, HoldTheTruthAsOftenAsTheySay) {
  const MeasuredArm arm;
  const std::vector<Recording> exact = recordings_of(arm, 4);
  CalibrationSpec spec;
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density),
                   unknown(CalibrationUnknown::base_angle)};
  spec.folds = 0;
  spec.starts = 1;
  const double truth[] = {4.9 / 4.0, 0.84, 0.0};
  Coverage seen[3];
  const int runs = repetitions(300);
  for (int seed = 0; seed < runs; ++seed) {
    spec.recordings = exact;
    test::add_noise(spec.recordings, 3e-4, static_cast<std::uint64_t>(seed));
    const Calibration result = calibrate(arm.scene(), spec);
    ASSERT_EQ(result.status, CalibrationStatus::solved) << seed << ": " << result.message;
    for (std::size_t i = 0; i < 3; ++i) {
      const double off = (value(result, i) - truth[i]) / result.numbers[i].error;
      seen[i].within_1 += (std::abs(off) < 1.0 ? 1.0 : 0.0) / runs;
      seen[i].within_2 += (std::abs(off) < 1.96 ? 1.0 : 0.0) / runs;
      seen[i].scatter += off * off / runs;
    }
  }
  const double error = 3.0 / std::sqrt(runs);
  for (int i = 0; i < 3; ++i) {
    const Coverage& c = seen[i];
    EXPECT_NEAR(c.within_1, 0.683, 0.465 * error);
    EXPECT_NEAR(c.within_2, 0.95, 0.218 * error);
    EXPECT_NEAR(std::sqrt(c.scatter), 1.0, 0.71 * error);
    RecordProperty("number " + std::to_string(i + 1), std::to_string(c.within_1) + ", " + std::to_string(c.within_2) +
                                                          ", scatter " + std::to_string(std::sqrt(c.scatter)));
  }
}

// The bound: shapes of the boundary-value problem, differentiated by central differences.
TEST(ErrorBars, AreThoseOfCramerAndRao) {
  const MeasuredArm arm;
  constexpr double noise = 1e-4;
  const auto points = [](const MeasuredArm& of) {
    std::vector<double> out;
    for (const Recording& r : recordings_of(of, 4)) {
      for (const CalibrationMarker& m : r.markers) out.insert(out.end(), {m.position->x, m.position->y});
    }
    return out;
  };
  MeasuredArm stiffer = arm, softer = arm, heavier = arm, lighter = arm;
  constexpr double step = 1e-4;  // of a factor on the scene's numbers
  stiffer.stiffness += 4.0e-4 * step;
  softer.stiffness -= 4.0e-4 * step;
  heavier.density += 0.1 * step;
  lighter.density -= 0.1 * step;
  const std::vector<double> a = points(stiffer), b = points(softer), c = points(heavier), d = points(lighter);
  Eigen::MatrixXd rates(static_cast<Eigen::Index>(a.size()), 2);
  for (std::size_t i = 0; i < a.size(); ++i) {
    rates(static_cast<Eigen::Index>(i), 0) = (a[i] - b[i]) / (2.0 * step);
    rates(static_cast<Eigen::Index>(i), 1) = (c[i] - d[i]) / (2.0 * step);
  }
  const Eigen::Matrix2d bound = noise * noise * (rates.transpose() * rates).inverse();
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 4);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  spec.noise = noise;
  const Calibration result = calibrate(arm.scene(), spec);
  EXPECT_NEAR(result.numbers[0].error, std::sqrt(bound(0, 0)), 1e-4 * result.numbers[0].error);
  EXPECT_NEAR(result.numbers[1].error, std::sqrt(bound(1, 1)), 1e-4 * result.numbers[1].error);
  EXPECT_NEAR(result.covariance(0, 1), bound(0, 1), 1e-4 * std::abs(bound(0, 1)));
}

// Without a weight that is known shapes tell u/EI and m/EI alone; with gravity as weak as here, next to nothing.
TEST(NotIdentifiable, NumbersAreNamedAndNotReported) {
  MeasuredArm arm;
  arm.density = 1e-4;
  CalibrationSpec spec;
  for (Recording& r : spec.recordings = pressurized(arm, 4)) r.tip_force = {};
  spec.recordings.resize(4);
  test::add_noise(spec.recordings, 2e-4, 1);
  spec.unknowns = {unknown(CalibrationUnknown::moment), unknown(CalibrationUnknown::stiffness)};
  Scene scene = arm.scene();
  scene.rod.segments[0].linear_density = arm.density;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::not_identifiable) << result.message;
  EXPECT_FALSE(result.numbers[0].identifiable);
  EXPECT_FALSE(result.numbers[1].identifiable);
  EXPECT_TRUE(contains_text(result.numbers[1].reason, "moment of actuator 1 per pressure")) << result.numbers[1].reason;
  EXPECT_TRUE(contains_text(result.numbers[1].reason, "stiffness")) << result.numbers[1].reason;
  EXPECT_EQ(result.covariance.norm(), 0.0);
}

// The same with a belief in the stiffness: then the moment is known as well as that.
TEST(NotIdentifiable, NumbersAreDeterminedByAPrior) {
  MeasuredArm arm;
  arm.density = 0.0;
  CalibrationSpec spec;
  spec.recordings = pressurized(arm, 4);
  for (Recording& r : spec.recordings) r.tip_force = {};
  spec.recordings.resize(4);
  spec.unknowns = {unknown(CalibrationUnknown::moment), unknown(CalibrationUnknown::stiffness)};
  spec.unknowns[0].degree = 2;
  spec.unknowns[1].prior = 4.9 / 4.0;
  spec.unknowns[1].prior_error = 0.02;
  spec.noise = 1e-5;
  Scene scene = arm.scene();
  scene.rod.segments[0].linear_density = 0.0;
  const Calibration result = calibrate(scene, spec);
  EXPECT_EQ(result.status, CalibrationStatus::solved) << result.message;
  EXPECT_NEAR(value(result, 0), 2e-8, 1e-12);
  EXPECT_NEAR(result.numbers[2].error, 0.02, 1e-6);
  EXPECT_NEAR(result.numbers[0].error / 2e-8, 0.02 / (4.9 / 4.0), 0.02 * 0.02);
}

// One point in ten is 5 mm off: squares are led astray, Huber's loss stays within its errors.
TEST(RobustLoss, LeavesOutliersWhereTheyAre) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 6);
  test::add_noise(spec.recordings, 1e-4, 3);
  int i = 0;
  for (Recording& r : spec.recordings) {
    for (CalibrationMarker& m : r.markers) {
      if (++i % 10 == 0) m.position->y += 5e-3;
    }
  }
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  const Calibration squares = calibrate(arm.scene(), spec);
  spec.robust = true;
  const Calibration robust = calibrate(arm.scene(), spec);
  EXPECT_EQ(robust.status, CalibrationStatus::solved) << robust.message;
  const double astray = std::abs(value(squares, 0) - 4.9 / 4.0);
  const double kept = std::abs(value(robust, 0) - 4.9 / 4.0);
  EXPECT_LT(kept, 0.2 * astray);
  EXPECT_LT(kept, 4.0 * robust.numbers[0].error);
}

TEST(Predictions, BeyondTheLoadsThatWereFittedAreTold) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 4);
  spec.recordings.push_back(arm.recording(0.003, 0.001, 4));
  spec.recordings.push_back(arm.recording(0.008, 0.001, 4));
  for (std::size_t i = 10; i < 12; ++i) spec.recordings[i].check_only = true;
  test::add_noise(spec.recordings, 1e-4, 5);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  const Calibration result = calibrate(arm.scene(), spec);
  EXPECT_EQ(result.checked.count, 1);
  EXPECT_EQ(result.checked_beyond.count, 1);
  EXPECT_EQ(result.shapes[10].beyond, "");
  EXPECT_EQ(result.shapes[11].beyond, "moment of actuator 1 0.008 N m (fitted -0.002 to 0.006)");
  EXPECT_TRUE(contains_text(result.warnings.back(), "beyond the loads that were fitted"));
  // Every recording was left out once; the ends of the range were then beyond those of the others at most twice.
  EXPECT_EQ(result.folds, 5);
  EXPECT_EQ(result.left_out.count + result.left_out_beyond.count, 10);
  EXPECT_LT(result.left_out.mean, 5e-4);
}

// Two recordings under each load, 1 mm noise between them.
TEST(Repetitions, TellTheNoise) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  for (int i = 0; i < 4; ++i) {
    for (Recording r : recordings_of(arm, 6)) {
      r.name += " again " + std::to_string(i);
      spec.recordings.push_back(r);
    }
  }
  test::add_noise(spec.recordings, 1e-3, 7);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  const Calibration result = calibrate(arm.scene(), spec);
  // 360 degrees of freedom: 3.7 %.
  EXPECT_NEAR(result.repeatability, 1e-3, 1.2e-4);
  EXPECT_NEAR(result.noise, 1e-3, 1.2e-4);
}

TEST(TheExample, IsWhatTheBoundaryValueProblemGives) {
  std::ifstream file(std::string(TENDRIL_SCENES) + "/calibrate.csv");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), test::calibration_file());
}

TEST(Bounds, HoldAndAreTold) {
  const MeasuredArm arm;
  CalibrationSpec spec;
  spec.recordings = recordings_of(arm, 4);
  spec.unknowns = {unknown(CalibrationUnknown::stiffness), unknown(CalibrationUnknown::density)};
  spec.unknowns[0].maximum = 1.1;
  const Calibration result = calibrate(arm.scene(), spec);
  EXPECT_EQ(value(result, 0), 1.1);
  EXPECT_TRUE(result.numbers[0].at_bound);
  EXPECT_FALSE(result.numbers[1].at_bound);
}

}  // namespace
}  // namespace tendril
