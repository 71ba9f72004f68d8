#include "calibrate/measured.hpp"

#include <cstdio>

#include "estimate/truth.hpp"

namespace tendril::test {

Scene MeasuredArm::scene() const {
  Scene scene;
  scene.problem = ProblemKind::execute;
  scene.rod.segments.push_back({length, 4.0e-4, 0.1});
  scene.rod.actuators.push_back({0.0, length});
  scene.gravity = Vec2{0.0, -9.81};
  return scene;
}

Recording MeasuredArm::recording(double moment, double payload, int points) const {
  return recording(moment, payload, points, {0.0, -9.81});
}

Recording MeasuredArm::recording(double moment, double payload, int points, Vec2 gravity) const {
  support::RodBvp rod;
  rod.sections = {{length, stiffness, density, rest_curvature}};
  rod.actuators = {{0.0, length}};
  rod.gravity = {gravity.x, gravity.y};
  rod.payload = payload;
  rod.base = {base.x, base.y};
  rod.base_angle = base_angle;
  support::BvpGuess guess;
  guess.curvature = 0.5 * moment / stiffness;
  const support::BvpSolution solution = support::solve(rod, {moment}, {}, guess);
  Recording out;
  out.name = "moment " + std::to_string(moment) + ", payload " + std::to_string(payload);
  out.inputs = {moment};
  out.input_kinds = {ActuatorKind::moment};
  out.gravity = gravity;
  out.tip_force = payload * gravity;
  for (int i = 1; i <= points; ++i) {
    const double s = length * i / points;
    const support::BvpState at = solution.at(s);
    CalibrationMarker marker;
    marker.arc_length = s;
    marker.position = Vec2{at.x, at.y};
    out.markers.push_back(marker);
  }
  return out;
}

void add_noise(std::vector<Recording>& recordings, double noise, std::uint64_t seed) {
  NormalNumbers normal(seed);
  for (Recording& r : recordings) {
    for (CalibrationMarker& m : r.markers) {
      if (!m.position) continue;
      m.position->x += noise * normal();
      m.position->y += noise * normal();
    }
  }
}

std::string calibration_file() {
  MeasuredArm arm;
  arm.stiffness = 5.2e-4;
  std::vector<Recording> recordings;
  for (int kilopascals = 20; kilopascals <= 160; kilopascals += 20) {
    recordings.push_back(arm.recording(1.3e-5 * kilopascals, 0.0, 5));
  }
  add_noise(recordings, 1e-4, 1);
  std::string text =
      "# Eight shapes of an arm under pressure, seen by a camera: tests/calibrate/measured.cpp makes them.\n"
      "case,pressure [kPa],s [mm],x [mm],y [mm]\n";
  int kilopascals = 0;
  for (const Recording& r : recordings) {
    kilopascals += 20;
    for (const CalibrationMarker& m : r.markers) {
      char row[100];
      std::snprintf(row, sizeof row, "%d kPa,%d,%.0f,%.3f,%.3f\n", kilopascals, kilopascals, 1e3 * m.arc_length,
                    1e3 * m.position->x, 1e3 * m.position->y);
      text += row;
    }
  }
  return text;
}

CalibrationUnknownSpec unknown(CalibrationUnknown kind) {
  CalibrationUnknownSpec spec;
  spec.kind = kind;
  return spec;
}

}  // namespace tendril::test
