#include "scene/actuator_reader.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace tendril::app {

namespace {

/// The dimension of what an actuator of this kind is told.
Dimension told_dimension(const ActuatorDraft& draft) {
  return ActuatorSpec{.kind = draft.kind, .by_length = draft.by_length}.input_dimension();
}

/// A quantity in the unit of what an actuator is told.
template <class Set>
Key<ActuatorDraft> input_quantity(std::string name, Range range, std::string description, Set set) {
  Key<ActuatorDraft> key =
      quantity<ActuatorDraft>(std::move(name), dimension::moment, range, "no limit", std::move(description), set);
  key.read = [spec = key.spec, set](const Context& context, const Node& node, ActuatorDraft& draft) {
    KeySpec own = spec;
    own.dimension = told_dimension(draft);
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

Key<ActuatorDraft> calibrated_key() {
  Key<ActuatorDraft> key{{"calibrated", KeyType::quantities, dimension::moment, "not known",
                          "From where to where it was calibrated, [least, largest] of what its kind is told: results "
                          "beyond that say so."},
                         {}};
  key.read = [spec = key.spec](const Context& context, const Node& node, ActuatorDraft& draft) {
    const auto* list = std::get_if<Node::List>(&node.value);
    const std::string expected = "the least and the largest value, [least, largest]";
    if (list == nullptr) context.fail(node, expected);
    KeySpec own = spec;
    own.dimension = told_dimension(draft);
    std::vector<double> values;
    for (const Node& item : *list) values.push_back(read_quantity(context, item, own));
    if (values.size() != 2) context.fail(node, expected);
    draft.calibrated = {values.front(), values.back()};
  };
  return key;
}

/// The coefficients of a law of pressure or tension. `unit`: of what it gives, "N m" or "N"; `by`: of what it is told.
Key<ActuatorDraft> law_key(const std::string& name, const Dimension& dimension, const std::string& unit,
                           const std::string& by, const std::string& description,
                           std::vector<double> ActuatorDraft::*law) {
  Key<ActuatorDraft> key{{name, KeyType::law, dimension, "", description}, {}};
  key.read = [spec = key.spec, unit, by, law](const Context& context, const Node& node, ActuatorDraft& draft) {
    std::vector<double>& coefficients = draft.*law;
    const auto* list = std::get_if<Node::List>(&node.value);
    if (list == nullptr) {
      coefficients = {read_quantity(context, node, spec)};
      return;
    }
    if (list->empty() || list->size() > most_coefficients) {
      context.fail(node, fmt::format("{0} per {1}, or a list of 1 to {2} coefficients of the {1}, its square, ...",
                                     unit == "N" ? "a force" : "a moment", by == "N" ? "tension" : "pressure",
                                     most_coefficients));
    }
    for (std::size_t i = 0; i < list->size(); ++i) {
      KeySpec own = spec;
      const std::string of_power = unit + '/' + by + (i == 0 ? "" : fmt::format("^{}", i + 1));
      own.dimension = {0, 0, of_power};
      coefficients.push_back(read_quantity(context, (*list)[i], own));
    }
    while (coefficients.size() > 1 && coefficients.back() == 0.0) coefficients.pop_back();
  };
  return key;
}

Key<ActuatorDraft> control_key() {
  Key<ActuatorDraft> key = text<ActuatorDraft>(
      "control", "tension",
      "What a tendon is told: its tension, or its length, by which it is shorter than along the straight rod; the "
      "tension then follows, and is 0 where the tendon is slack.",
      [](ActuatorDraft& t, const std::string& word) { t.by_length = word == "length"; }, {"tension", "length"});
  key.first = true;
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

/// The limits in what the actuator is told, as they stand in the scene.
std::pair<double, double> written_limits(const Document& document, const std::string& path,
                                         const ActuatorDraft& actuator) {
  const bool pulls = actuator.kind == ActuatorKind::tendon && !actuator.by_length;
  if (actuator.limit) {
    if (actuator.minimum || actuator.maximum) {
      document.fail(document.find(path + "limit"),
                    "found 'limit' beside 'min' or 'max', expected either limit or min and max");
    }
    return {pulls ? 0.0 : -*actuator.limit, *actuator.limit};
  }
  const std::pair limits{actuator.minimum.value_or(pulls ? 0.0 : -infinity), actuator.maximum.value_or(infinity)};
  const auto [low, high] = limits;
  if (pulls && low < 0.0) {
    document.fail(document.find(path + "min"),
                  fmt::format("found a tension of {} N, expected one that is not negative: a tendon only pulls", low));
  }
  if (low > high) {
    const std::string_view unit =
        ActuatorSpec{.kind = actuator.kind, .by_length = actuator.by_length}.input_dimension().unit;
    document.fail(document.find(path + (actuator.minimum ? "min" : "max")),
                  fmt::format("found min {} {} above max {} {}, expected min <= max", low, unit, high, unit));
  }
  return limits;
}

bool is_law(const std::vector<double>& coefficients) {
  return std::any_of(coefficients.begin(), coefficients.end(), [](double c) { return c != 0.0; });
}

bool knows_pressure(const ActuatorDraft& actuator) { return is_law(actuator.moment_per_pressure); }

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
  if (!knows_pressure(actuator)) {
    document.fail(document.find(key), "found a limit of the pressure, expected 'moment_per_pressure' beside it");
  }
  const std::pair limits{actuator.smallest_pressure.value_or(-infinity), actuator.largest_pressure.value_or(infinity)};
  if (limits.first > limits.second) document.fail(document.find(key), "found min_pressure above max_pressure");
  return limits;
}

/// `low` and `high`: limits of the actuator, of the pressure or the tension if `of_effort`.
void finish_law(const Document& document, const std::string& path, const ActuatorDraft& actuator, double low,
                double high, bool of_effort, ActuatorSpec& spec) {
  const bool tendon = actuator.kind == ActuatorKind::tendon;
  const std::vector<double>& law = tendon ? actuator.moment_per_tension : actuator.moment_per_pressure;
  if (!is_law(law)) return;
  spec.moment_per_pressure = law.front();
  spec.more_moment_per_pressure.assign(law.begin() + 1, law.end());
  if (law.size() == 1) return;
  const SourcePosition at = document.find(path + (tendon ? "moment_per_tension" : "moment_per_pressure"));
  if (!of_effort || !std::isfinite(low) || !std::isfinite(high)) {
    document.fail(at, fmt::format("found a law of several coefficients, expected limits of the {} on both sides beside "
                                  "it",
                                  tendon ? "tension" : "pressure"));
  }
  spec.least_pressure = low;
  spec.most_pressure = high;
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

/// What only tendons that are told their length have.
void check_control(const Document& document, const std::string& path, const ActuatorDraft& actuator) {
  const bool tendon = actuator.kind == ActuatorKind::tendon;
  if (!tendon && actuator.by_length) {
    document.fail(document.find(path + "control"), "found a control by length, expected kind = \"tendon\" beside it");
  }
  if (actuator.largest_tension && !(tendon && actuator.by_length)) {
    document.fail(document.find(path + "max_tension"),
                  "found 'max_tension', expected control = \"length\" of a tendon beside it, or 'limit' or 'max'");
  }
}

void finish_force(const Document& document, const std::string& path, const ActuatorDraft& actuator,
                  ActuatorSpec& spec) {
  if (actuator.force_per_pressure.empty()) return;
  if (!knows_pressure(actuator)) {
    document.fail(document.find(path + "force_per_pressure"),
                  "found 'force_per_pressure', expected 'moment_per_pressure' beside it");
  }
  spec.force_per_pressure = actuator.force_per_pressure;
}

}  // namespace

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
           "Largest moment in either direction, or pressure, or the largest tension (N) of a tendon, or, of one told "
           "its length, what it is shorter or longer by (m); instead of min and max. 0 removes the actuator.",
           [](T& t, double v) { t.limit = v; }),
       input_quantity("min", any,
                      "Smallest moment (positive moments bend to the left), pressure, tension or shortening; a tendon "
                      "without one may be slack.",
                      [](T& t, double v) { t.minimum = v; }),
       input_quantity("max", any, "Largest moment, pressure, tension or shortening.",
                      [](T& t, double v) { t.maximum = v; }),
       offset_key(), control_key(),
       quantity<T>("max_tension", dimension::force, positive, "no limit",
                   "Largest tension of a tendon told its length.", [](T& t, double v) { t.largest_tension = v; }),
       law_key("moment_per_pressure", dimension::moment_per_pressure, "N m", "Pa",
               "Moment that a unit of pressure gives; negative if pressure bends to the right. Or coefficients of the "
               "pressure, its square, and so on, which need limits of the pressure.",
               &T::moment_per_pressure),
       law_key("moment_per_tension", {1, 0, "N m/N"}, "N m", "N",
               "Moment that a unit of tension gives where the tendon's offset is largest, as measured: instead of that "
               "offset. Or coefficients of the tension, its square, and so on, which need limits of the tension.",
               &T::moment_per_tension),
       law_key("force_per_pressure", dimension::force_per_pressure, "N", "Pa",
               "Axial force that comes with a unit of pressure on a rod that stretches; positive if pressure makes it "
               "longer. Or coefficients, likewise.",
               &T::force_per_pressure),
       quantity<T>("min_pressure", dimension::pressure, any, "no limit",
                   "Smallest pressure; with moment_per_pressure, instead of limits of the moment.",
                   [](T& t, double v) { t.smallest_pressure = v; }),
       quantity<T>("max_pressure", dimension::pressure, any, "no limit", "Largest pressure.",
                   [](T& t, double v) { t.largest_pressure = v; }),
       calibrated_key()}};
}

ActuatorSpec finish_actuator(const Document& document, const std::string& path, const ActuatorDraft& actuator,
                             double length) {
  ActuatorSpec spec;
  spec.kind = actuator.kind;
  spec.from = actuator.from.value_or(0.0);
  spec.to = actuator.to.value_or(length);
  if (spec.from >= spec.to) {
    document.fail(document.find(path + (actuator.from ? "from" : "to")),
                  fmt::format("found an actuator from {} m to {} m, expected from < to", spec.from, spec.to));
  }
  if (actuator.calibrated) std::tie(spec.calibrated_from, spec.calibrated_to) = *actuator.calibrated;
  finish_offset(document, path, actuator, spec);
  check_control(document, path, actuator);
  if (spec.kind == ActuatorKind::pressure && !knows_pressure(actuator)) {
    document.fail(
        document.find(path + "kind"),
        "found an actuator of kind \"pressure\" without 'moment_per_pressure', expected the moment that a unit "
        "of pressure gives");
  }
  if (spec.kind == ActuatorKind::tendon && knows_pressure(actuator)) {
    document.fail(document.find(path + "moment_per_pressure"),
                  "found 'moment_per_pressure' of a tendon, expected it with kind \"pressure\" or \"moment\"");
  }
  if (spec.kind != ActuatorKind::tendon && is_law(actuator.moment_per_tension)) {
    document.fail(document.find(path + "moment_per_tension"),
                  "found 'moment_per_tension', expected kind = \"tendon\" beside it");
  }
  const bool pressures = actuator.smallest_pressure || actuator.largest_pressure;
  const auto [low, high] =
      pressures ? pressure_limits(document, path, actuator) : written_limits(document, path, actuator);
  const auto [least, most] =
      actuator.by_length ? std::pair(0.0, actuator.largest_tension.value_or(infinity)) : std::pair(low, high);
  finish_law(document, path, actuator, least, most, pressures || spec.kind != ActuatorKind::moment, spec);
  finish_force(document, path, actuator, spec);
  // Limits of a moment stay moments, also where a pressure is known.
  const bool inputs = pressures || spec.kind != ActuatorKind::moment;
  if (spec.kind == ActuatorKind::tendon && spec.largest_offset() == 0.0) return spec;  // core tells it
  const auto moment = [&](double limit) { return inputs ? spec.moment_of(limit) : limit; };
  if (actuator.by_length) {
    spec.by_length = true;
    std::tie(spec.least_shortening, spec.most_shortening) = std::pair(low, high);
    std::tie(spec.minimum, spec.maximum) = std::minmax({0.0, moment(most)});
    if (actuator.limit && *actuator.limit == 0.0) spec.minimum = spec.maximum = 0.0;
    return spec;
  }
  std::tie(spec.minimum, spec.maximum) = std::minmax({moment(low), moment(high)});
  return spec;
}

}  // namespace tendril::app
