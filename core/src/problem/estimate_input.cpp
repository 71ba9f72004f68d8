#include "problem/estimate_input.hpp"

#include <algorithm>
#include <cmath>

#include "scene/make_rod.hpp"

namespace tendril {
namespace {

/// Errors of points beyond this many standard deviations are none.
constexpr double most_deviations = 10.0;

/// Refuses points that no shape of the rod has, whatever holds it: a point further from the base than the rod is long,
/// one at the base that is not there, neighbours further apart than the rod between them.
void require_reachable(const RodSpec& rod, const MeasurementSpec& measurement) {
  const double length = rod.length();
  const double errors = most_deviations * measurement.noise;
  double farthest = 0.0;
  for (const MeasuredPoint& p : measurement.points) {
    const double distance = norm(p.position - rod.base_position);
    farthest = std::max(farthest, distance);
    if (p.arc_length == 0.0 && distance > std::max(0.02 * length, errors)) {
      throw SceneError("measurement",
                       "the measured point at arc length 0 lies " + shown(distance, 3) +
                           " m from the rod's base, expected it there: are the points' origin and the rod's base "
                           "right, and the arc lengths counted from the base?");
    }
  }
  if (farthest > 1.5 * length + errors) {
    const bool thousandth = 1e-3 * farthest <= 1.05 * length && 1e-3 * farthest >= 0.05 * length;
    throw SceneError("measurement", "the points lie up to " + shown(farthest, 3) + " m from the base of a rod of " +
                                        shown(length, 3) + " m, expected them within its length: " +
                                        (thousandth ? "are they in mm? A plain number is in m"
                                                    : "are their unit and origin right? A plain number is in m"));
  }
  if (!measurement.equal_spacing || measurement.points.size() < 3) return;
  std::vector<MeasuredPoint> points = measurement.points;
  std::stable_sort(points.begin(), points.end(),
                   [](const MeasuredPoint& a, const MeasuredPoint& b) { return a.arc_length < b.arc_length; });
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double chord = norm(points[i].position - points[i - 1].position);
    const double arc = points[i].arc_length - points[i - 1].arc_length;
    if (chord > 1.5 * arc + errors) {
      throw SceneError("measurement", "two neighbouring points lie " + shown(chord, 3) +
                                          " m apart where points without arc lengths are taken to be " + shown(arc, 3) +
                                          " m apart along the rod: expected equal distances with the last one at the "
                                          "tip, or arc lengths (s, x, y)");
    }
  }
}

}  // namespace

std::vector<double> known_moments(const Scene& scene) {
  const std::vector<ActuatorSpec>& actuators = scene.rod.actuators;
  if (!scene.measurement.moments.empty()) {
    if (scene.measurement.moments.size() != actuators.size()) {
      throw SceneError("measurement.moments", "found " + std::to_string(scene.measurement.moments.size()) +
                                                  " moments, expected one for each of the rod's " +
                                                  std::to_string(actuators.size()) + " actuators");
    }
    return scene.measurement.moments;
  }
  std::vector<double> moments;
  for (std::size_t a = 0; a < actuators.size(); ++a) {
    if (actuators[a].minimum != actuators[a].maximum) {
      throw SceneError("measurement", "the moment of actuator " + std::to_string(a + 1) +
                                          " while the points were measured is not known, expected moments = [...] in "
                                          "[measurement], or an actuator whose min and max are equal");
    }
    moments.push_back(actuators[a].minimum);
  }
  return moments;
}

EstimateInput::EstimateInput(const Scene& scene) {
  validate(scene);
  scale = scale_of(scene);
  rod = make_rod(scene, scale);
  moments = dimensionless(known_moments(scene));
  take_contacts(scene);
  measured = shape_of(scene);
}

void EstimateInput::take_contacts(const Scene& scene) {
  most_contacts = scene.contact.count;
  if (scene.contact.friction_state != FrictionState::none) friction = scene.contact.friction;
  if (most_contacts > 2) {
    throw SceneError("contact.count",
                     "found " + std::to_string(most_contacts) + " contacts to be estimated, expected 1 or 2");
  }
}

std::vector<double> EstimateInput::dimensionless(const std::vector<double>& si) const {
  std::vector<double> out;
  for (const double m : si) {
    if (!std::isfinite(m)) throw SceneError("measurement.moments", "a known moment must be finite");
    out.push_back(scale.to_dimensionless(m, dimension::moment));
  }
  return out;
}

MeasuredShape EstimateInput::shape_of(const Scene& scene) {
  const MeasurementSpec& measurement = scene.measurement;
  if (measurement.points.empty()) {
    throw SceneError("measurement",
                     "there are no measured points, expected points = [...] or file = \"...\" in "
                     "[measurement]");
  }
  MeasuredShape shape;
  std::vector<MeasuredPoint> points = measurement.points;
  equal_spacing = measurement.equal_spacing;
  at_base = static_cast<int>(std::erase_if(points, [](const MeasuredPoint& p) { return p.arc_length == 0.0; }));
  std::stable_sort(points.begin(), points.end(),
                   [](const MeasuredPoint& a, const MeasuredPoint& b) { return a.arc_length < b.arc_length; });
  shape.points.resize(2 * static_cast<Eigen::Index>(points.size()));
  Eigen::Index i = 0;
  for (const MeasuredPoint& p : points) {
    const double s = p.arc_length / scale.length;
    if (!(s > 0.0 && s <= 1.0 + beyond_tip)) {
      throw SceneError("measurement", "a measured point is at arc length " + shown(p.arc_length, 6) +
                                          " m, expected at least 0 and at most the rod's length, " +
                                          shown(scale.length, 6) + " m: " +
                                          (s > 1.0 && points.back().arc_length > 10.0 * scale.length &&
                                                   1e-3 * points.back().arc_length <= 1.05 * scale.length
                                               ? "are the points in mm? A plain number is in m"
                                               : "are its unit and the rod's length right?"));
    }
    shape.arc_lengths.push_back(std::min(1.0, s));
    for (const double coordinate : {p.position.x, p.position.y}) {
      if (!std::isfinite(coordinate)) throw SceneError("measurement", "a measured coordinate is not finite");
      shape.points[i++] = scale.to_dimensionless(coordinate, dimension::length);
    }
  }
  if (std::isnan(measurement.noise) || measurement.noise < 0.0 || !std::isfinite(measurement.noise)) {
    throw SceneError("measurement.noise", "the noise must be a positive length");
  }
  require_reachable(scene.rod, measurement);
  shape.noise = measurement.noise / scale.length;
  // The noise itself needs residuals to be estimated from.
  const int least = 2 * most_contacts + (measurement.noise > 0.0 ? 0 : 2);
  if (shape.points.size() < least) {
    throw SceneError(
        "measurement",
        "found " + std::to_string(points.size()) + (points.size() == 1 ? " measured point" : " measured points") +
            ", expected at least " + std::to_string((least + 1) / 2) + " for " + std::to_string(most_contacts) +
            (most_contacts == 1 ? " contact" : " contacts") + (measurement.noise > 0.0 ? "" : " and unknown noise"));
  }
  return shape;
}

EstimateInput::EstimateInput(const Scene& scene, const SequenceSpec& spec) {
  validate(scene);
  scale = scale_of(scene);
  rod = make_rod(scene, scale);
  take_contacts(scene);
  if (spec.frames.empty()) throw SceneError("measurement", "there is no frame, expected at least one");
  const auto require_rate = [](const std::string& key, const std::optional<double>& rate) {
    if (rate && !(*rate > 0.0 && std::isfinite(*rate))) throw SceneError(key, "a rate must be greater than 0");
  };
  require_rate("measurement.force_rate", spec.force_rate);
  require_rate("measurement.place_rate", spec.place_rate);
  const auto name = [&](double time) { return spec.timed ? "time " + shown(time) + " s" : "frame " + shown(time); };
  Scene one = scene;
  int at_bases = 0;
  for (const MeasuredFrame& frame : spec.frames) {
    if (!std::isfinite(frame.time)) throw SceneError("measurement", "the time of a frame must be finite");
    if (!frames.empty() && !(frame.time > frames.back().time)) {
      throw SceneError("measurement", name(frame.time) + " follows " + name(frames.back().time) +
                                          ", expected frames in ascending order, each of them once");
    }
    one.measurement = scene.measurement;
    one.measurement.points = frame.points;
    one.measurement.equal_spacing = frame.equal_spacing;
    if (!frame.moments.empty()) one.measurement.moments = frame.moments;
    try {
      frames.push_back({frame.time, dimensionless(known_moments(one)), shape_of(one)});
    } catch (const SceneError& error) {
      throw SceneError(error.path(), name(frame.time) + ": " + error.what());
    }
    at_bases += at_base;
  }
  at_base = at_bases;
}

}  // namespace tendril
