#include "scene/rod_reader.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace tendril::app {

namespace {

/// A quantity in the unit of what an actuator is told.
template <class Set>
Key<ActuatorDraft> input_quantity(std::string name, Range range, std::string description, Set set) {
  Key<ActuatorDraft> key =
      quantity<ActuatorDraft>(std::move(name), dimension::moment, range, "no limit", std::move(description), set);
  key.read = [spec = key.spec, set](const Context& context, const Node& node, ActuatorDraft& draft) {
    KeySpec own = spec;
    own.dimension = ActuatorSpec{.kind = draft.kind}.input_dimension();
    set(draft, read_quantity(context, node, own));
  };
  return key;
}

Key<ActuatorDraft> offset_key() {
  Key<ActuatorDraft> key{{"offset", KeyType::offsets, dimension::length, "",
                          "Distance of a tendon from the backbone, positive to the left: the same all along, at from "
                          "and to with a straight line in between, or a table of arc lengths and distances."},
                         {}};
  key.read = [spec = key.spec](const Context& context, const Node& node, ActuatorDraft& draft) {
    const auto* list = std::get_if<Node::List>(&node.value);
    if (list == nullptr) {
      draft.offset = {read_quantity(context, node, spec)};
      return;
    }
    const std::string expected = "a length, two of them [at from, at to], or a table [[arc length, offset], ...]";
    if (list->size() < 2) context.fail(node, expected);
    const auto pair = [](const Node& item) { return std::get_if<Node::List>(&item.value); };
    if (pair(list->front()) == nullptr) {
      if (list->size() != 2) context.fail(node, expected);
      for (const Node& item : *list) draft.offset.push_back(read_quantity(context, item, spec));
      return;
    }
    for (const Node& item : *list) {
      const Node::List* entry = pair(item);
      if (entry == nullptr || entry->size() != 2) context.fail(item, "a pair [arc length, offset]");
      const double s = read_quantity(context, entry->front(), spec);
      draft.offset_table.push_back({s, read_quantity(context, entry->back(), spec)});
    }
  };
  return key;
}

Key<ActuatorDraft> kind_key() {
  Key<ActuatorDraft> key = text<ActuatorDraft>(
      "kind", "moment", "What it is told: a moment, the tension of a tendon beside the backbone, or a pressure.",
      [](ActuatorDraft& t, const std::string& word) {
        for (const ActuatorKind kind : {ActuatorKind::moment, ActuatorKind::tendon, ActuatorKind::pressure}) {
          if (word == to_string(kind)) t.kind = kind;
        }
      },
      {"moment", "tendon", "pressure"});
  key.first = true;
  return key;
}

Table<ActuatorDraft> actuator_table() {
  using T = ActuatorDraft;
  return {
      {kind_key(),
       quantity<T>("from", dimension::length, not_negative, "0", "Arc length at which the actuator begins.",
                   [](T& t, double v) { t.from = v; }),
       quantity<T>("to", dimension::length, not_negative, "the rod's length", "Arc length at which the actuator ends.",
                   [](T& t, double v) { t.to = v; }),
       input_quantity(
           "limit", not_negative,
           "Largest moment in either direction, or pressure, or the largest tension (N) of a tendon; instead of min "
           "and max. 0 removes the actuator.",
           [](T& t, double v) { t.limit = v; }),
       input_quantity("min", any,
                      "Smallest moment (positive moments bend to the left), pressure or tension; a tendon without one "
                      "may be slack.",
                      [](T& t, double v) { t.minimum = v; }),
       input_quantity("max", any, "Largest moment, pressure or tension.", [](T& t, double v) { t.maximum = v; }),
       offset_key(),
       quantity<T>("moment_per_pressure", dimension::moment_per_pressure, any, "",
                   "Moment that a unit of pressure gives; negative if pressure bends to the right.",
                   [](T& t, double v) { t.moment_per_pressure = v; }),
       quantity<T>("min_pressure", dimension::pressure, any, "no limit",
                   "Smallest pressure; with moment_per_pressure, instead of limits of the moment.",
                   [](T& t, double v) { t.smallest_pressure = v; }),
       quantity<T>("max_pressure", dimension::pressure, any, "no limit", "Largest pressure.",
                   [](T& t, double v) { t.largest_pressure = v; })}};
}

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
            [](T & t) -> auto& { return t.loads; })}) {
    keys.push_back(std::move(list));
  }
  return keys;
}

/// The limits in what the actuator is told, as they stand in the scene.
std::pair<double, double> written_limits(const Document& document, const std::string& path,
                                         const ActuatorDraft& actuator) {
  const bool tendon = actuator.kind == ActuatorKind::tendon;
  if (actuator.limit) {
    if (actuator.minimum || actuator.maximum) {
      document.fail(document.find(path + "limit"),
                    "found 'limit' beside 'min' or 'max', expected either limit or min and max");
    }
    return {tendon ? 0.0 : -*actuator.limit, *actuator.limit};
  }
  const std::pair limits{actuator.minimum.value_or(tendon ? 0.0 : -infinity), actuator.maximum.value_or(infinity)};
  const auto [low, high] = limits;
  if (tendon && low < 0.0) {
    document.fail(document.find(path + "min"),
                  fmt::format("found a tension of {} N, expected one that is not negative: a tendon only pulls", low));
  }
  if (low > high) {
    const std::string_view unit = ActuatorSpec{.kind = actuator.kind}.input_dimension().unit;
    document.fail(document.find(path + (actuator.minimum ? "min" : "max")),
                  fmt::format("found min {} {} above max {} {}, expected min <= max", low, unit, high, unit));
  }
  return limits;
}

/// The limits of an actuator of kind "moment" whose pressure is limited.
std::pair<double, double> pressure_limits(const Document& document, const std::string& path,
                                          const ActuatorDraft& actuator) {
  const std::string key = path + (actuator.smallest_pressure ? "min_pressure" : "max_pressure");
  if (actuator.kind != ActuatorKind::moment) {
    document.fail(document.find(key), "found a limit of the pressure beside 'kind', expected 'limit', 'min' or 'max'");
  }
  if (actuator.limit || actuator.minimum || actuator.maximum) {
    document.fail(document.find(key), "found a limit of the pressure beside one of the moment, expected one of them");
  }
  if (actuator.moment_per_pressure == 0.0) {
    document.fail(document.find(key), "found a limit of the pressure, expected 'moment_per_pressure' beside it");
  }
  const std::pair limits{actuator.smallest_pressure.value_or(-infinity), actuator.largest_pressure.value_or(infinity)};
  if (limits.first > limits.second) document.fail(document.find(key), "found min_pressure above max_pressure");
  return limits;
}

void finish_offset(const Document& document, const std::string& path, const ActuatorDraft& actuator,
                   ActuatorSpec& spec) {
  const bool given = !actuator.offset.empty() || !actuator.offset_table.empty();
  if (given != (spec.kind == ActuatorKind::tendon)) {
    document.fail(document.find(path + (given ? "offset" : "kind")),
                  given ? "found an 'offset', expected kind = \"tendon\" beside it"
                        : "found a tendon without an 'offset', expected its distance from the backbone, for instance "
                          "offset = \"8 mm\"");
  }
  for (std::size_t i = 0; i < actuator.offset.size(); ++i) {
    spec.offset.push_back({i == 0 ? spec.from : spec.to, actuator.offset[i]});
  }
  for (const Vec2& p : actuator.offset_table) spec.offset.push_back({p.x, p.y});
}

/// `path`: of its keys. `length`: of the rod.
ActuatorSpec finish_actuator(const Document& document, const std::string& path, const ActuatorDraft& actuator,
                             double length) {
  ActuatorSpec spec;
  spec.kind = actuator.kind;
  spec.from = actuator.from.value_or(0.0);
  spec.to = actuator.to.value_or(length);
  spec.moment_per_pressure = actuator.moment_per_pressure;
  if (spec.from >= spec.to) {
    document.fail(document.find(path + (actuator.from ? "from" : "to")),
                  fmt::format("found an actuator from {} m to {} m, expected from < to", spec.from, spec.to));
  }
  finish_offset(document, path, actuator, spec);
  if (spec.kind == ActuatorKind::pressure && spec.moment_per_pressure == 0.0) {
    document.fail(
        document.find(path + "kind"),
        "found an actuator of kind \"pressure\" without 'moment_per_pressure', expected the moment that a unit "
        "of pressure gives");
  }
  if (spec.kind == ActuatorKind::tendon && spec.moment_per_pressure != 0.0) {
    document.fail(document.find(path + "moment_per_pressure"),
                  "found 'moment_per_pressure' of a tendon, expected it with kind \"pressure\" or \"moment\"");
  }
  const bool pressures = actuator.smallest_pressure || actuator.largest_pressure;
  const auto [low, high] =
      pressures ? pressure_limits(document, path, actuator) : written_limits(document, path, actuator);
  // Limits of a moment stay moments, also where a pressure is known.
  const double size = pressures || spec.kind != ActuatorKind::moment ? spec.moment_per_input() : 1.0;
  if (size != 0.0) std::tie(spec.minimum, spec.maximum) = std::minmax({low * size, high * size});
  return spec;
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
  if (finger.segments.empty() && !any && !twist) whole.segments = rod.segments;
  if (whole.segments.empty()) {
    // Values that say the same thing in another way are no part of what this finger is made of.
    if (!finger.file) inherit(whole.length, rod.length);
    if (!finger.file) inherit(whole.rest_curvature, rod.rest_curvature);
    if (!round && !finger.file) {
      inherit(whole.bending_stiffness, rod.bending_stiffness);
      inherit(whole.linear_density, rod.linear_density);
      inherit(whole.thickness, rod.thickness);
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

}  // namespace

Table<RodDraft> rod_table() {
  using T = RodDraft;
  Table<RodDraft> base{
      {point<T>("position", dimension::length, "[0, 0]", "Where the rod is clamped.",
                [](T& t, Vec2 v) { t.base_position = v; }),
       quantity<T>("angle", dimension::angle, any, "0", "Direction of the rod at the clamp, from the x axis.",
                   [](T& t, double v) { t.base_angle = v; })}};
  Table<RodDraft> rod{rod_keys<T>("rod")};
  rod.keys.insert(rod.keys.end() - 3,
                  table<T>("base", "rod.base", "The clamp.", std::move(base), [](T& t) -> T& { return t; }));
  return rod;
}

Table<FingerDraft> finger_table() {
  using T = FingerDraft;
  Table<FingerDraft> finger{rod_keys<T>("finger", "as in [rod]")};
  finger.keys.push_back(quantity<T>("angle", dimension::angle, any, "finger_angle of [gripper]",
                                    "Angle of the finger's base against the axis.",
                                    [](T& t, double v) { t.angle = v; }));
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
  rod.base_position = draft.base_position;
  rod.base_angle = draft.base_angle;
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
  }
  for (std::size_t i = 0; i < draft.loads.size(); ++i) {
    rod.loads.push_back(finish_load(document, fmt::format("{}.load[{}].", table, i), draft.loads[i], length));
  }
  return rod;
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
