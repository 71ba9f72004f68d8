#include "scene/rod_reader.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace tendril::app {

namespace {

Table<SegmentSpec> segment_table() {
  using T = SegmentSpec;
  return {{quantity<T>(
               "length", dimension::length, positive, "", "Length of the segment.",
               [](T& t, double v) { t.length = v; }, Need::required),
           quantity<T>(
               "bending_stiffness", dimension::stiffness, positive, "", "Bending stiffness EI of the segment.",
               [](T& t, double v) { t.bending_stiffness = v; }, Need::required),
           quantity<T>("linear_density", dimension::linear_density, not_negative, "0",
                       "Mass per length; without it gravity does not act on the segment.",
                       [](T& t, double v) { t.linear_density = v; }),
           quantity<T>("rest_curvature", dimension::curvature, any, "0", "Curvature of the unloaded segment.",
                       [](T& t, double v) { t.rest_curvature = v; })}};
}

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
  const std::string zero = unstated.empty() ? "0" : unstated;
  return {
      quantity<T>("length", dimension::length, positive, unstated, "Length of a uniform rod.",
                  [](T& t, double v) { t.length = v; }),
      quantity<T>("bending_stiffness", dimension::stiffness, positive, unstated,
                  "Bending stiffness EI of a uniform rod.", [](T& t, double v) { t.bending_stiffness = v; }),
      quantity<T>("linear_density", dimension::linear_density, not_negative, zero, "Mass per length of a uniform rod.",
                  [](T& t, double v) { t.linear_density = v; }),
      quantity<T>("rest_curvature", dimension::curvature, any, zero, "Curvature of an unloaded uniform rod.",
                  [](T& t, double v) { t.rest_curvature = v; }),
      tables<T>(
          "segment", path + ".segment", "A rod of several segments, from the base on; instead of the uniform values.",
          segment_table(), [](T & t) -> auto& { return t.segments; }),
      tables<T>(
          "actuator", path + ".actuator", "What bends the rod between two arc lengths.", actuator_table(),
          [](T & t) -> auto& { return t.actuators; })};
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
  const bool uniform = finger.length || finger.bending_stiffness || finger.linear_density || finger.rest_curvature;
  if (finger.segments.empty() && !uniform) whole.segments = rod.segments;
  if (whole.segments.empty()) {
    const auto inherit = [](std::optional<double>& own, const std::optional<double>& from) {
      if (!own) own = from;
    };
    inherit(whole.length, rod.length);
    inherit(whole.bending_stiffness, rod.bending_stiffness);
    inherit(whole.linear_density, rod.linear_density);
    inherit(whole.rest_curvature, rod.rest_curvature);
  }
  if (finger.actuators.empty()) whole.actuators = rod.actuators;
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
  rod.keys.insert(rod.keys.begin() + 4,
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

RodSpec finish_rod(const Document& document, const std::string& table, const RodDraft& draft) {
  const std::string name = table == "rod" ? "[rod]" : "[[finger]]";
  RodSpec rod;
  rod.base_position = draft.base_position;
  rod.base_angle = draft.base_angle;
  if (!draft.segments.empty()) {
    const auto refuse = [&](const char* key, const std::optional<double>& value) {
      if (!value) return;
      document.fail(document.find(table + '.' + key),
                    fmt::format("found '{}' beside [[{}.segment]], expected either uniform values or segments", key,
                                table.substr(0, table.find('['))));
    };
    refuse("length", draft.length);
    refuse("bending_stiffness", draft.bending_stiffness);
    refuse("linear_density", draft.linear_density);
    refuse("rest_curvature", draft.rest_curvature);
    rod.segments = draft.segments;
  } else {
    if (!draft.length)
      document.fail(document.find(table), name + " has no 'length' and no [[" + table.substr(0, table.find('[')) +
                                              ".segment]], expected " + expected_quantity(dimension::length));
    if (!draft.bending_stiffness)
      document.fail(document.find(table),
                    name + " has no 'bending_stiffness', expected " + expected_quantity(dimension::stiffness));
    rod.segments = {{*draft.length, *draft.bending_stiffness, draft.linear_density.value_or(0.0),
                     draft.rest_curvature.value_or(0.0)}};
  }
  double length = 0.0;
  for (const SegmentSpec& segment : rod.segments) length += segment.length;
  for (std::size_t i = 0; i < draft.actuators.size(); ++i) {
    rod.actuators.push_back(
        finish_actuator(document, fmt::format("{}.actuator[{}].", table, i), draft.actuators[i], length));
  }
  return rod;
}

std::vector<FingerSpec> finish_fingers(const Document& document, const RodDraft& rod,
                                       const std::vector<FingerDraft>& drafts, const Scene& scene) {
  std::vector<FingerSpec> fingers;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const FingerDraft& own = drafts[i];
    const std::string table = fmt::format("finger[{}]", i);
    FingerSpec finger;
    finger.rod = finish_rod(document, table, with_inherited(rod, own));
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
