// What a calibration looks for, and what no measured shape can tell.

#include <algorithm>
#include <cmath>

#include "estimate/estimate_fit.hpp"
#include "problem/calibrate_input.hpp"
#include "tendril/error.hpp"

namespace tendril {

namespace {

/// Where other starts lie, about the first one: factors between a quarter and four times it, and differences.
constexpr double curvature_spread = 1.0;     // 1/L
constexpr double moment_spread = 1.0;        // EI/L, at the largest input
constexpr double strain_spread = 0.05;       // of an axial force, at the largest input
constexpr double angle_spread = 0.2;         // rad
constexpr double place_spread = 0.02;        // L
constexpr double higher_power_spread = 0.3;  // of a law, against its first power

/// One of the two stiffnesses that a modulus is.
bool is_part(CalibrationUnknown of_modulus, CalibrationUnknown part) {
  return of_modulus == CalibrationUnknown::modulus &&
         (part == CalibrationUnknown::stiffness || part == CalibrationUnknown::axial_stiffness);
}

}  // namespace

void CalibrationInput::require_stretch(const CalibrationUnknownSpec& u) const {
  if (problem.rod.stretches()) return;
  throw SceneError(at_ + ".name", "found \"" + std::string(to_string(u.kind)) +
                                      "\" of a rod that does not stretch, expected [coordinates] stretch_order");
}

/// What a number belongs to, and how its scene has it.
CalibrationInput::Subject CalibrationInput::subject_of(const Scene& scene, const CalibrationSpec& spec,
                                                       const CalibrationUnknownSpec& u) const {
  const auto number_between = [this](int value, int least, std::size_t most, const std::string& key) {
    if (value >= least && value <= static_cast<int>(most)) return value;
    throw SceneError(at_ + '.' + key, "found " + key + " " + std::to_string(value) + ", expected " +
                                          (most == 1 ? "1" : "1 to " + std::to_string(most)));
  };
  const std::size_t segments = problem.rod.segments.size();
  switch (u.kind) {
    case CalibrationUnknown::stiffness:
    case CalibrationUnknown::axial_stiffness:
    case CalibrationUnknown::modulus: {
      const int segment = number_between(u.segment, 0, segments, "segment");
      if (u.kind == CalibrationUnknown::axial_stiffness) require_stretch(u);
      const std::string name =
          u.kind == CalibrationUnknown::axial_stiffness ? "axial stiffness" : std::string(to_string(u.kind));
      return {segment == 0 ? name : name + " of segment " + std::to_string(segment), "", segment - 1};
    }
    case CalibrationUnknown::density:
      return {"density", "", -1};
    case CalibrationUnknown::rest_curvature: {
      const int segment = number_between(u.segment == 0 && segments == 1 ? 1 : u.segment, 1, segments, "segment");
      return {"rest curvature of segment " + std::to_string(segment),
              "1/m",
              segment - 1,
              1.0 / scale.length,
              scene.rod.segments[static_cast<std::size_t>(segment - 1)].rest_curvature,
              curvature_spread};
    }
    case CalibrationUnknown::moment:
    case CalibrationUnknown::force: {
      const int actuator = number_between(u.actuator, 1, problem.rod.actuators.size(), "actuator");
      number_between(u.degree, 1, 6, "degree");
      const auto a = static_cast<std::size_t>(actuator - 1);
      if (!(input_sizes_[a] > 0.0)) {
        throw SceneError(at_ + ".actuator", "no recording tells actuator " + std::to_string(actuator) +
                                                " anything, so that its moment cannot be found");
      }
      if (u.kind == CalibrationUnknown::force) {
        require_stretch(u);
        return {"axial force of actuator " + std::to_string(actuator), "", actuator - 1, scale.force(), 0.0,
                strain_spread * problem.rod.segments.front().axial};
      }
      const ActuatorSpec& of = scene.rod.actuators[a];
      const bool same = spec.recordings.front().input_kinds[a] == of.input();
      const double per_input = of.has_law()                         ? of.moment_per_pressure
                               : of.input() == ActuatorKind::tendon ? of.largest_offset()
                                                                    : 1.0;
      return {"moment of actuator " + std::to_string(actuator),
              "",
              actuator - 1,
              scale.moment(),
              same ? per_input : 0.0,
              moment_spread};
    }
    case CalibrationUnknown::base_angle:
      return {"base angle", "rad", -1, 1.0, scene.rod.base_angle, angle_spread};
    case CalibrationUnknown::base_x:
      return {"base x", "m", -1, scale.length, scene.rod.base_position.x, place_spread};
    case CalibrationUnknown::base_y:
      return {"base y", "m", -1, scale.length, scene.rod.base_position.y, place_spread};
  }
  throw SceneError(at_, "found no such number");
}

void CalibrationInput::add_unknown(const Scene& scene, const CalibrationSpec& spec, const CalibrationUnknownSpec& u,
                                   int group, const std::string& whose) {
  const Subject subject = subject_of(scene, spec, u);
  const bool line =
      std::any_of(problem.rod.loads.begin(), problem.rod.loads.end(), [](const Rod::Load& l) { return !l.at_point(); });
  if (u.kind == CalibrationUnknown::base_angle && line) {
    throw SceneError(at_ + ".name",
                     "the base's angle cannot be looked for while a force acts along the "
                     "rod, expected loads at points");
  }
  const bool law = is_law(u.kind);
  for (int power = 1; power <= (law ? u.degree : 1); ++power) {
    Sought one{u.kind, subject.index, power, group};
    CalibratedNumber number{u, power, subject.name + whose, subject.unit};
    double unit = subject.size;
    one.spread = group < 0 ? subject.spread : 0.0;
    if (law) {
      const ActuatorKind input = spec.recordings.front().input_kinds[static_cast<std::size_t>(one.index)];
      unit /= std::pow(input_sizes_[static_cast<std::size_t>(one.index)], power);
      number.unit = law_unit(u.kind, input, power);
      number.name +=
          power == 1 ? " per " + input_name(input) : " per " + input_name(input) + "^" + std::to_string(power);
      if (power > 1) one.spread *= higher_power_spread;
    }
    if (power == 1) {
      one.lower = u.minimum / unit;
      one.upper = u.maximum / unit;
      one.start = u.start.value_or(subject.known) / unit;
      if (u.prior) {
        one.prior = *u.prior / unit;
        one.prior_error = u.prior_error / unit;
      }
    }
    require_sensible(u, one, number);
    one.start = std::clamp(one.start, one.lower, one.upper);
    problem.unknowns.push_back(one);
    numbers.push_back(std::move(number));
    units.push_back(unit);
  }
}

void CalibrationInput::require_sensible(const CalibrationUnknownSpec& u, const Sought& one,
                                        const CalibratedNumber& number) const {
  if (u.prior && !(u.prior_error > 0.0)) {
    throw SceneError(at_ + ".prior", "a prior needs its standard deviation 'prior_error'");
  }
  if (!u.prior && u.prior_error != 0.0) {
    throw SceneError(at_ + ".prior_error", "found a 'prior_error' without the 'prior' that it belongs to");
  }
  if (!(one.lower <= one.upper)) throw SceneError(at_ + ".min", "found a minimum above the maximum");
  const bool factor = is_factor(one.kind);
  if (factor && !(one.start > 0.0 && one.upper > 0.0)) {
    throw SceneError(at_, number.name + " is a factor, expected a start and a maximum above 0");
  }
  for (std::size_t i = 0; i < problem.unknowns.size(); ++i) {
    const Sought& other = problem.unknowns[i];
    const bool whole = factor && (other.index < 0 || one.index < 0);
    const bool same_base = other.group == one.group || other.group < 0 || one.group < 0;
    const bool same_kind = other.kind == one.kind || is_part(other.kind, one.kind) || is_part(one.kind, other.kind);
    if (same_kind && other.power == one.power && same_base && (other.index == one.index || whole)) {
      throw SceneError(at_, "found \"" + number.name + "\" beside \"" + numbers[i].name +
                                "\", expected each number to be looked for once");
    }
  }
}

/// Shapes tell ratios of stiffness, moments and forces alone: where all of them are free, nothing sets their size.
void CalibrationInput::require_one_known_load() const {
  const auto free = [&](CalibrationUnknown kind, int index) {
    return std::any_of(problem.unknowns.begin(), problem.unknowns.end(), [&](const Sought& u) {
      return u.kind == kind && (u.index == index || u.index < 0 || kind == CalibrationUnknown::density) &&
             !std::isfinite(u.prior_error);
    });
  };
  for (int s = 0; s < static_cast<int>(problem.rod.segments.size()); ++s) {
    const bool modulus = free(CalibrationUnknown::modulus, s);
    if (!modulus && !free(CalibrationUnknown::stiffness, s)) return;
    // A known axial stiffness sets the size of whatever stretches the rod.
    if (problem.rod.stretches() && !modulus && !free(CalibrationUnknown::axial_stiffness, s)) return;
  }
  const bool density = is_sought(CalibrationUnknown::density);
  const auto pulls = [](const Push& push) { return push.force != Vec2{} || push.moment != 0.0; };
  bool weight = false;
  bool actuated = false;
  for (const int s : fitted) {
    const SeenShape& shape = problem.shapes[static_cast<std::size_t>(s)];
    const bool heavy = std::any_of(problem.rod.segments.begin(), problem.rod.segments.end(),
                                   [](const Rod::Segment& g) { return g.weight != 0.0 || !g.weighs_evenly(); });
    weight = weight || (heavy && shape.loads.gravity != Vec2{});
    if (pulls(shape.loads.tip) || std::any_of(shape.loads.at.begin(), shape.loads.at.end(), pulls)) return;
    if (!shape.moments.isZero(0.0)) return;
    actuated = actuated || !shape.inputs.isZero(0.0);
  }
  if (problem.rod.has_dead_loads() || (weight && !free(CalibrationUnknown::density, 0))) return;
  std::string names = is_sought(CalibrationUnknown::modulus) ? "the modulus" : "the stiffness";
  for (const Sought& u : problem.unknowns) {
    if (!is_law(u.kind) || u.power > 1) continue;
    if (std::isfinite(u.prior_error)) return;
    names += u.kind == CalibrationUnknown::moment ? ", the moment" : ", the axial force";
    names += " of actuator " + std::to_string(u.index + 1);
  }
  if (weight && density) names += ", the density";
  if (!weight && !actuated) {
    throw SceneError("calibrate.unknown", names +
                                              " is free, and nothing bends the rod in any recording: expected a "
                                              "known weight, force or moment");
  }
  throw SceneError("calibrate.unknown",
                   names +
                       " are all free, and nothing that acts is known: shapes tell only their ratios. Expected one "
                       "known load: a weight at the tip, a density, a moment; or a prior on one of them");
}

}  // namespace tendril
