// What a calibration refuses, and what it asks about.

#include <gtest/gtest.h>

#include "calibrate/measured.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/calibrate.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

using test::MeasuredArm;
using test::unknown;

CalibrationSpec good() {
  const MeasuredArm arm;
  CalibrationSpec spec;
  for (const double moment : {0.001, 0.002, 0.004}) spec.recordings.push_back(arm.recording(moment, 0.001, 4));
  spec.unknowns = {unknown(CalibrationUnknown::stiffness)};
  return spec;
}

void expect_refused(const CalibrationSpec& spec, const std::string& part, const Scene& scene = MeasuredArm{}.scene()) {
  try {
    calibrate(scene, spec);
    ADD_FAILURE() << "not refused, expected: " << part;
  } catch (const SceneError& error) {
    EXPECT_TRUE(contains_text(error.what(), part)) << error.what();
  }
}

TEST(Refused, AreGainStiffnessAndDensityThatAreAllFree) {
  CalibrationSpec spec = good();
  spec.unknowns.push_back(unknown(CalibrationUnknown::moment));
  for (Recording& r : spec.recordings) r.tip_force = {};
  Scene weightless = MeasuredArm{}.scene();
  weightless.rod.segments[0].linear_density = 0.0;
  expect_refused(
      spec,
      "the stiffness, the moment of actuator 1 are all free, and nothing that acts is known: shapes tell only "
      "their ratios. Expected one known load",
      weightless);
  spec.unknowns.push_back(unknown(CalibrationUnknown::density));
  expect_refused(spec, "the stiffness, the moment of actuator 1, the density are all free");
}

TEST(Refused, IsAStiffnessThatNothingBends) {
  CalibrationSpec spec = good();
  for (Recording& r : spec.recordings) {
    r.tip_force = {};
    r.inputs = {0.0};
  }
  Scene weightless = MeasuredArm{}.scene();
  weightless.rod.segments[0].linear_density = 0.0;
  expect_refused(spec, "nothing bends the rod in any recording", weightless);
}

TEST(Refused, AreStretchesOfRodsOfFixedLength) {
  CalibrationSpec spec = good();
  spec.unknowns.push_back(unknown(CalibrationUnknown::axial_stiffness));
  expect_refused(spec,
                 "found \"axial_stiffness\" of a rod that does not stretch, expected [coordinates] stretch_order");
  spec.unknowns[1].kind = CalibrationUnknown::force;
  expect_refused(spec, "found \"force\" of a rod that does not stretch");
  spec.unknowns[1].kind = CalibrationUnknown::modulus;
  expect_refused(spec, "found \"modulus\" beside \"stiffness\", expected each number to be looked for once");
}

TEST(Refused, AreShapesThatLeaveTheirPlane) {
  CalibrationSpec spec = good();
  spec.recordings[1].markers[2].out_of_plane = -0.006;
  expect_refused(spec, "found a point -0.006 m out of the plane, 6 % of the rod's length, expected a planar shape");
  spec.recordings[1].markers[2].out_of_plane = 0.002;
  EXPECT_TRUE(
      contains_text(calibrate(MeasuredArm{}.scene(), spec).warnings.at(0), "points lie up to 2 % of the length"));
}

TEST(Refused, AreMoreUnknownsThanMeasurements) {
  CalibrationSpec spec = good();
  spec.recordings.resize(1);
  spec.recordings[0].markers.resize(1);
  spec.unknowns.push_back(unknown(CalibrationUnknown::density));
  expect_refused(spec, "found 2 unknowns and 2 measured numbers, expected at least 3, as the noise is not known");
}

TEST(Refused, ArePointsInOtherUnits) {
  CalibrationSpec spec = good();
  for (CalibrationMarker& m : spec.recordings[1].markers) *m.position = 1000.0 * *m.position;
  expect_refused(spec, "further than the rod reaches there: is it in mm? A plain number is in m");
  spec = good();
  for (CalibrationMarker& m : spec.recordings[1].markers) m.arc_length *= 1000.0;
  expect_refused(spec, "expected at least 0 and at most the rod's length, 0.1 m: is it in mm? A plain number is in m");
}

TEST(Accepted, IsATipWhoseArcLengthWasRoundedInInches) {
  CalibrationSpec spec = good();
  for (Recording& r : spec.recordings) r.markers.back().arc_length = 3.93701 * 0.0254;
  const Calibration found = calibrate(MeasuredArm{}.scene(), spec);
  ASSERT_EQ(found.numbers.size(), 1u);
  EXPECT_EQ(found.status, CalibrationStatus::solved) << found.message;
  EXPECT_DOUBLE_EQ(found.numbers[0].value, calibrate(MeasuredArm{}.scene(), good()).numbers[0].value);
  for (Recording& r : spec.recordings) r.markers.back().arc_length = 1.001 * 0.1;
  expect_refused(spec, "expected at least 0 and at most the rod's length");
}

TEST(Refused, ArePointsOutOfOrder) {
  CalibrationSpec spec = good();
  std::swap(spec.recordings[0].markers[1].arc_length, spec.recordings[0].markers[2].arc_length);
  expect_refused(spec, "expected ascending arc lengths: is one twice there, or out of order?");
  spec = good();
  std::swap(spec.recordings[0].markers[0].position, spec.recordings[0].markers[3].position);
  expect_refused(spec, "are unit, origin and arc length right, and the arc lengths counted from the base?");
}

TEST(Refused, IsAnInputOfAnotherKind) {
  CalibrationSpec spec = good();
  spec.recordings[2].input_kinds = {ActuatorKind::pressure};
  expect_refused(spec, "found a pressure of actuator 1, expected a moment as in the recordings before");
  for (Recording& r : spec.recordings) r.input_kinds = {ActuatorKind::pressure};
  expect_refused(spec, "found a pressure of actuator 1, whose moment is not known: expected 'moment' of that actuator");
  spec = good();
  spec.recordings[0].inputs.clear();
  spec.recordings[0].input_kinds.clear();
  expect_refused(spec, "found what 0 actuators was told");
}

TEST(Refused, AreUnknownsThatDoNotExistOrTwice) {
  CalibrationSpec spec = good();
  spec.unknowns[0].segment = 2;
  expect_refused(spec, "found segment 2, expected 1");
  spec = good();
  spec.unknowns.push_back(spec.unknowns[0]);
  spec.unknowns[1].segment = 1;
  expect_refused(spec,
                 "found \"stiffness of segment 1\" beside \"stiffness\", expected each number to be looked for once");
  spec = good();
  spec.unknowns[0].prior = 1.0;
  expect_refused(spec, "a prior needs its standard deviation");
}

TEST(AskedAbout, AreAxesThatAreSwapped) {
  CalibrationSpec spec = good();
  for (Recording& r : spec.recordings) {
    for (CalibrationMarker& m : r.markers) m.position = Vec2{m.position->y, m.position->x};
  }
  const Calibration result = calibrate(MeasuredArm{}.scene(), spec);
  EXPECT_TRUE(contains_text(result.message, "as if x and y are swapped")) << result.message;
  EXPECT_NE(result.message.front(), ';');
}

TEST(AskedAbout, AreRecordingsThatAreTheSame) {
  CalibrationSpec spec = good();
  spec.recordings.push_back(spec.recordings[0]);
  spec.recordings.back().name = "copy";
  const Calibration result = calibrate(MeasuredArm{}.scene(), spec);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_TRUE(contains_text(result.warnings.front(), "\"copy\" are the same number by number"))
      << result.warnings.front();
}

}  // namespace
}  // namespace tendril
