#include "scene/rod_reader.hpp"

#include <cmath>

namespace tendril::app {

namespace {

/// What a rod is made of, in the table at `path`. `unstated`: where values come from that are not given; empty:
/// defaults.
template <class T>
std::vector<Key<T>> rod_keys(const std::string& path, const std::string& unstated = "") {
  std::vector<Key<T>> keys = section_keys<T>(unstated);
  for (Key<T> list :
       {tables<T>(
            "segment", path + ".segment", "A rod of several segments, from the base on; instead of the uniform values.",
            Table<SectionDraft>{section_keys<SectionDraft>("")}, [](T & t) -> auto& { return t.segments; }),
        tables<T>(
            "actuator", path + ".actuator", "What bends the rod between two arc lengths.", actuator_table(),
            [](T & t) -> auto& { return t.actuators; }),
        tables<T>(
            "load", path + ".load", "A dead load at one place along the rod, or spread along it.", load_table(),
            [](T & t) -> auto& { return t.loads; }),
        load_range<T>("calibrated_gravity", dimension::acceleration, "The gravity", &T::calibrated_gravity),
        load_range<T>("calibrated_tip_force", dimension::force, "The force at the tip, weights included,",
                      &T::calibrated_tip_force)}) {
    keys.push_back(std::move(list));
  }
  return keys;
}

/// What a finger does not state is taken from `rod`.
RodDraft with_inherited(const RodDraft& rod, const RodDraft& finger) {
  RodDraft whole = finger;
  const auto inherit = [](auto& own, const auto& from) {
    if (!own) own = from;
  };
  const bool numbers = finger.bending_stiffness || finger.linear_density || finger.thickness;
  const bool round = finger.youngs_modulus || finger.density || finger.diameter || finger.inner_diameter;
  const bool twist = finger.poisson_ratio || finger.torsional_stiffness || finger.out_of_plane_stiffness;
  const bool any = numbers || round || finger.file || finger.length || finger.rest_curvature;
  if (finger.segments.empty() && !any && !twist) {
    whole.segments = rod.segments;
    inherit(whole.calibrated_gravity, rod.calibrated_gravity);
    inherit(whole.calibrated_tip_force, rod.calibrated_tip_force);
  }
  if (whole.segments.empty()) {
    // Values that say the same thing in another way are no part of what this finger is made of.
    if (!finger.file) inherit(whole.length, rod.length);
    if (!finger.file) inherit(whole.rest_curvature, rod.rest_curvature);
    if (!round && !finger.file) {
      inherit(whole.bending_stiffness, rod.bending_stiffness);
      inherit(whole.linear_density, rod.linear_density);
      inherit(whole.thickness, rod.thickness);
      inherit(whole.axial_stiffness, rod.axial_stiffness);
    }
    if (!numbers && !finger.file) {
      inherit(whole.youngs_modulus, rod.youngs_modulus);
      inherit(whole.density, rod.density);
      inherit(whole.diameter, rod.diameter);
      inherit(whole.inner_diameter, rod.inner_diameter);
    }
    if (!any) inherit(whole.file, rod.file);
    if (!finger.torsional_stiffness) inherit(whole.poisson_ratio, rod.poisson_ratio);
    if (!numbers && !round && !finger.file) {
      if (!finger.poisson_ratio) inherit(whole.torsional_stiffness, rod.torsional_stiffness);
      inherit(whole.out_of_plane_stiffness, rod.out_of_plane_stiffness);
    }
  }
  if (finger.actuators.empty()) whole.actuators = rod.actuators;
  if (finger.loads.empty()) whole.loads = rod.loads;
  return whole;
}

double offset_at(const std::vector<OffsetPoint>& offset, double s) {
  std::size_t i = 1;
  while (i + 1 < offset.size() && offset[i].arc_length < s) ++i;
  if (offset.size() == 1) return offset.front().offset;
  const OffsetPoint& a = offset[i - 1];
  const OffsetPoint& b = offset[i];
  return a.offset + (s - a.arc_length) / (b.arc_length - a.arc_length) * (b.offset - a.offset);
}

/// Asks about a tendon that runs outside the body of its rod. `path`: of its offset.
void warn_of_outside(const Context& context, const std::string& path, const RodSpec& rod, const ActuatorSpec& tendon) {
  const BodyRadius radius = rod.body();
  if (!radius || tendon.offset.empty()) return;
  std::vector<double> places{tendon.from, tendon.to};
  for (const OffsetPoint& p : tendon.offset) places.push_back(p.arc_length);
  double end = 0.0;
  for (const SegmentSpec& segment : rod.segments) {
    end += segment.length;
    if (end > tendon.from && end < tendon.to) places.push_back(end);
  }
  for (const double s : places) {
    const double offset = std::abs(offset_at(tendon.offset, s));
    const double inside = radius(s);
    if (offset <= inside * (1.0 + 1e-9)) continue;
    context.warnings.push_back(context.document.describe(context.document.find(path)) +
                               fmt::format(": found a tendon {:.6g} m from the backbone at {:.6g} m, outside the body, "
                                           "whose radius is {:.6g} m there",
                                           offset, s, inside));
    return;
  }
}

/// `path`: of its table, with a dot.
void place_base(const Document& document, const std::string& path, const RodDraft& draft, RodSpec& rod) {
  const auto two = [&](const auto& range, const char* key, const char* what) {
    if (range.size() != 2)
      document.fail(document.find(path + key),
                    fmt::format("found a list of {} {}, expected two {}: the least and the largest", range.size(),
                                range.size() == 1 ? "entry" : "entries", what));
  };
  if (!draft.base_position_range.empty()) {
    two(draft.base_position_range, "position_range", "points");
    rod.base_position_range = {draft.base_position_range[0], draft.base_position_range[1]};
    rod.base_position = 0.5 * (draft.base_position_range[0] + draft.base_position_range[1]);
  }
  if (!draft.base_angle_range.empty()) {
    two(draft.base_angle_range, "angle_range", "angles");
    rod.base_angle_range = {draft.base_angle_range[0], draft.base_angle_range[1]};
    rod.base_angle = 0.5 * (draft.base_angle_range[0] + draft.base_angle_range[1]);
  }
  rod.base_position = draft.base_position.value_or(rod.base_position);
  rod.base_angle = draft.base_angle.value_or(rod.base_angle);
}

/// What is out of the rod's port at most. `path`: of the table that says so.
RodSpec draw_in(const Document& document, const std::string& path, const RodDraft& draft, const RodSpec& whole) {
  if (!draft.insertion && !draft.least_insertion && !draft.most_insertion) return whole;
  if (draft.least_insertion.has_value() != draft.most_insertion.has_value()) {
    document.fail(document.find(path), fmt::format("found '{}' alone, expected 'min' and 'max', or 'value' alone",
                                                   draft.least_insertion ? "min" : "max"));
  }
  const double most = draft.most_insertion.value_or(draft.insertion.value_or(0.0));
  const double least = draft.least_insertion.value_or(most);
  if (least > most) {
    document.fail(document.find(path + ".min"),
                  fmt::format("found min {} m above max {} m, expected min <= max", least, most));
  }
  const double begins = draft.insertion.value_or(0.5 * (least + most));
  if (begins < least || begins > most) {
    document.fail(document.find(path + ".value"),
                  fmt::format("found {} m, expected at least min ({} m) and at most max ({} m)", begins, least, most));
  }
  RodSpec rod;
  try {
    rod = out_of_port(whole, most);
  } catch (const SceneError& error) {
    const bool too_long = error.path() == "rod.insertion";
    document.fail(document.find(too_long ? path + (draft.most_insertion ? ".max" : ".value") : error.path()),
                  error.what());
  }
  rod.most_drawn_in = most - least;
  rod.drawn_in = most - begins;
  return rod;
}

}  // namespace

Table<RodDraft> rod_table() {
  using T = RodDraft;
  Table<RodDraft> base{
      {point<T>("position", dimension::length, "[0, 0]", "Where the rod is clamped.",
                [](T& t, Vec2 v) { t.base_position = v; }),
       quantity<T>("angle", dimension::angle, any, "0", "Direction of the rod at the clamp, from the x axis.",
                   [](T& t, double v) { t.base_angle = v; }),
       points<T>(
           "position_range", KeyType::points, dimension::length,
           "Where a plan may move the clamp to: the least coordinates and the largest ones. `position` is then where "
           "it begins, the middle where that is not given.",
           [](T& t, std::vector<Vec2> v) { t.base_position_range = std::move(v); }),
       quantities<T>("angle_range", dimension::angle, any,
                     "How a plan may turn the clamp: the least angle and the largest one; `angle` likewise.",
                     [](T& t, const std::vector<double>& v) { t.base_angle_range = std::move(v); })}};
  Table<RodDraft> insertion{
      {quantity<T>("value", dimension::length, positive, "all of it, or the middle between min and max",
                   "Length of the rod that is out of its port; beside `min` and `max` where a plan begins.",
                   [](T& t, double v) { t.insertion = v; }),
       quantity<T>("min", dimension::length, positive, "", "A plan may draw the rod in until so much of it is out.",
                   [](T& t, double v) { t.least_insertion = v; }),
       quantity<T>("max", dimension::length, positive, "", "A plan may push it out until so much of it is out.",
                   [](T& t, double v) { t.most_insertion = v; })}};
  Table<RodDraft> rod{rod_keys<T>("rod")};
  rod.keys.insert(rod.keys.end() - 5,
                  table<T>("base", "rod.base", "The clamp.", std::move(base), [](T& t) -> T& { return t; }));
  rod.keys.insert(
      rod.keys.end() - 5,
      table<T>("insertion", "rod.insertion",
               "A rod that is pushed in through a port at its base: what is not out of it is straight and "
               "without effect. Arc lengths in this file are those of the whole rod, in results those of what "
               "is out at most.",
               std::move(insertion), [](T& t) -> T& { return t; }));
  return rod;
}

Table<FingerDraft> finger_table() {
  using T = FingerDraft;
  Table<FingerDraft> finger{rod_keys<T>("finger", "as in [rod]")};
  finger.keys.push_back(quantity<T>("angle", dimension::angle, any, "finger_angle of [gripper]",
                                    "Angle of the finger's base against the axis.",
                                    [](T& t, double v) { t.angle = v; }));
  finger.keys.push_back(quantities<T>("angle_range", dimension::angle, any,
                                      "Between which a plan may turn it; without it finger_angle_range of [gripper].",
                                      [](T& t, const std::vector<double>& v) { t.angle_range = two_of(v); }));
  finger.keys.push_back(quantity<T>("min_force", dimension::force, not_negative, "as in [contact]",
                                    "Smallest force of its contact.", [](T& t, double v) { t.min_force = v; }));
  finger.keys.push_back(quantity<T>("max_force", dimension::force, not_negative, "as in [contact]",
                                    "Largest force of its contact.", [](T& t, double v) { t.max_force = v; }));
  return finger;
}

RodSpec finish_rod(const Context& context, const std::string& table, const RodDraft& draft) {
  const Document& document = context.document;
  const std::string kind = table.substr(0, table.find('['));
  RodSpec rod;
  place_base(document, table + ".base.", draft, rod);
  if (!draft.segments.empty()) {
    const auto refuse = [&](const char* key, bool given) {
      if (!given) return;
      document.fail(
          document.find(table + '.' + key),
          fmt::format("found '{}' beside [[{}.segment]], expected either uniform values or segments", key, kind));
    };
    refuse("length", draft.length.has_value());
    refuse("bending_stiffness", draft.bending_stiffness.has_value());
    refuse("linear_density", draft.linear_density.has_value());
    refuse("rest_curvature", draft.rest_curvature.has_value());
    refuse("youngs_modulus", draft.youngs_modulus.has_value());
    refuse("density", draft.density.has_value());
    refuse("diameter", draft.diameter.has_value());
    refuse("inner_diameter", draft.inner_diameter.has_value());
    refuse("thickness", draft.thickness.has_value());
    refuse("file", draft.file.has_value());
    refuse("poisson_ratio", draft.poisson_ratio.has_value());
    refuse("torsional_stiffness", draft.torsional_stiffness.has_value());
    refuse("out_of_plane_stiffness", draft.out_of_plane_stiffness.has_value());
    refuse("axial_stiffness", draft.axial_stiffness.has_value());
    for (std::size_t i = 0; i < draft.segments.size(); ++i) {
      const std::vector<SegmentSpec> made =
          finish_section(context, fmt::format("{}.segment[{}]", table, i), '[' + kind + ".segment]", draft.segments[i]);
      if (i > 0 && (made.front().torsional_stiffness > 0.0) != (rod.segments.front().torsional_stiffness > 0.0)) {
        document.fail(document.find(fmt::format("{}.segment[{}]", table, i)),
                      "the torsion of some segments is known and of others not, expected 'poisson_ratio' or "
                      "'torsional_stiffness' in all of them or in none");
      }
      rod.segments.insert(rod.segments.end(), made.begin(), made.end());
    }
  } else {
    if (!draft.length && !draft.file) {
      document.fail(document.find(table), (kind == "rod" ? "[rod]" : "[[finger]]") +
                                              std::string(" has no 'length' and no [[") + kind +
                                              ".segment]], expected " + expected_quantity(dimension::length));
    }
    rod.segments = finish_section(context, table, kind == "rod" ? "[rod]" : "[[finger]]", draft);
  }
  double length = 0.0;
  for (const SegmentSpec& segment : rod.segments) length += segment.length;
  for (std::size_t i = 0; i < draft.actuators.size(); ++i) {
    rod.actuators.push_back(
        finish_actuator(document, fmt::format("{}.actuator[{}].", table, i), draft.actuators[i], length));
    warn_of_outside(context, fmt::format("{}.actuator[{}].offset", table, i), rod, rod.actuators.back());
  }
  for (std::size_t i = 0; i < draft.loads.size(); ++i) {
    rod.loads.push_back(finish_load(document, fmt::format("{}.load[{}].", table, i), draft.loads[i], length));
  }
  rod.calibrated_gravity = draft.calibrated_gravity;
  rod.calibrated_tip_force = draft.calibrated_tip_force;
  return draw_in(document, table + ".insertion", draft, rod);
}

std::vector<FingerSpec> finish_fingers(const Context& context, const RodDraft& rod,
                                       const std::vector<FingerDraft>& drafts, const Scene& scene) {
  const Document& document = context.document;
  std::vector<FingerSpec> fingers;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const FingerDraft& own = drafts[i];
    const std::string table = fmt::format("finger[{}]", i);
    FingerSpec finger;
    finger.rod = finish_rod(context, table, with_inherited(rod, own));
    finger.finger_angle = own.angle.value_or(scene.gripper ? scene.gripper->finger_angle : 0.0);
    finger.finger_angle_range = own.angle_range;
    if (!own.angle_range && scene.gripper) finger.finger_angle_range = scene.gripper->finger_angle_range;
    finger.min_force = own.min_force.value_or(scene.contact.min_force);
    finger.max_force = own.max_force.value_or(scene.contact.max_force);
    if (finger.min_force > finger.max_force) {
      document.fail(document.find(table + (own.min_force ? ".min_force" : ".max_force")),
                    fmt::format("found min_force {} N above max_force {} N, expected min_force <= max_force",
                                finger.min_force, finger.max_force));
    }
    fingers.push_back(std::move(finger));
  }
  return fingers;
}

}  // namespace tendril::app
