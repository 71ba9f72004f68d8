#include "scene/measurement_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "scene/table_file.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// A length, or a number of pixels if the scene says how long one is.
MeasuredLength read_measured(const Context& context, const Node& node, const KeySpec& key) {
  return {read_quantity(context, node, key), !std::holds_alternative<std::string>(node.value)};
}

/// Rows of lengths, all of two or all of three entries.
void read_measured_points(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const std::string expected = "a list of points, each [s, x, y] or [x, y]";
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr || list->empty()) {
    context.fail(node, expected);
  }
  if (list->size() > most_measured_points) {
    context.document.fail(node.position,
                          fmt::format("found {} points, expected at most {}", list->size(), most_measured_points));
  }
  for (const Node& item : *list) {
    const auto* entries = std::get_if<Node::List>(&item.value);
    if (entries == nullptr || (entries->size() != 2 && entries->size() != 3)) {
      context.fail(item, "a point [s, x, y] or [x, y]");
    }
    if (!draft.rows.empty() && entries->size() != draft.rows.front().size()) {
      context.document.fail(item.position,
                            fmt::format("found a point of {} entries, expected {} as in the points before",
                                        entries->size(), draft.rows.front().size()));
    }
    std::vector<MeasuredLength> row;
    row.reserve(entries->size());
    for (const Node& entry : *entries) row.push_back(read_measured(context, entry, key));
    draft.rows.push_back(std::move(row));
  }
}

void read_origin(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr || list->size() != 2) {
    context.fail(node, "a list of two entries [x, y], each " + expected_quantity(key.dimension));
  }
  draft.origin = {read_measured(context, (*list)[0], key), read_measured(context, (*list)[1], key)};
}

void read_known_moments(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr) {
    context.fail(node, "a list of moments, one for each actuator");
  }
  for (const Node& item : *list) draft.moments.push_back(read_quantity(context, item, key));
}

/// Points as they were measured, one after the other: s, x, y or x, y each; NaN where nothing was seen.
struct Readings {
  std::vector<std::vector<double>> rows;
  std::vector<bool> blank;
};

Readings read_file(const Context& context, const MeasurementDraft& draft, Scene& scene) {
  TableFileSpec spec;
  spec.what = "measurement";
  spec.columns = {{"s", dimension::length, {"arc_length", "arc length", "arclength"}},
                  {"x", dimension::length},
                  {"y", dimension::length}};
  spec.forms = {{1, 2}, {0, 1, 2}};
  spec.most_rows = most_measured_points;
  spec.pixel = draft.scale.value_or(0.0);
  const std::filesystem::path path = std::filesystem::path(context.document.file()).parent_path() / draft.file;
  TableFile file = read_table_file(path, spec, context.units);
  for (const std::string& name : file.unread) {
    scene.left_out.push_back({"column \"" + name + "\" of " + draft.file, "an estimate reads s, x and y"});
  }
  return {std::move(file.rows), std::move(file.blank)};
}

Readings readings_of(const Context& context, const MeasurementDraft& draft, Scene& scene) {
  if (!draft.file.empty()) return read_file(context, draft, scene);
  Readings out;
  for (const std::vector<MeasuredLength>& row : draft.rows) {
    std::vector<double> lengths;
    lengths.reserve(row.size());
    for (const MeasuredLength& value : row) lengths.push_back(value.in_metres(draft.scale));
    out.rows.push_back(std::move(lengths));
  }
  out.blank.assign(out.rows.size(), false);
  return out;
}

bool is_complete(const std::vector<double>& row) {
  return std::none_of(row.begin(), row.end(), [](double v) { return std::isnan(v); });
}

/// Points [x, y] stand at equal distances: from the base or from the tip on, with one at the base or without.
struct Spacing {
  bool from_tip = false;
  bool with_base = false;
};

/// Arc length of place `i` of `count`.
double equal_arc_length(const Spacing& spacing, std::size_t i, std::size_t count, double length) {
  const std::size_t place = spacing.from_tip ? count - 1 - i : i;
  const auto steps = static_cast<double>(spacing.with_base ? std::max<std::size_t>(count, 2) - 1 : count);
  return length * static_cast<double>(place + (spacing.with_base ? 0 : 1)) / steps;
}

/// Where the points say that the base is. A point at arc length s near it is close to s along the base's tangent.
Spacing spacing_of(const std::vector<std::vector<double>>& rows, const RodSpec& rod) {
  const Vec2 tangent{std::cos(rod.base_angle), std::sin(rod.base_angle)};
  // Distance of the seen point that lies first from where it would be.
  const auto error = [&](const Spacing& spacing) {
    double least = std::numeric_limits<double>::infinity();
    double found = least;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double s = equal_arc_length(spacing, i, rows.size(), rod.length());
      if (!is_complete(rows[i]) || s >= least) continue;
      least = s;
      found = norm(Vec2{rows[i][0], rows[i][1]} - rod.base_position - s * tangent);
    }
    return found;
  };
  Spacing best;
  // Few points are too far apart to tell.
  if (rows.size() < 3) return best;
  const auto nearest = [&](bool from_tip) { return std::min(error({from_tip, false}), error({from_tip, true})); };
  best.from_tip = nearest(true) < 0.25 * nearest(false);
  best.with_base = error({best.from_tip, true}) < 0.25 * error({best.from_tip, false});
  return best;
}

/// The points that were seen, along the rod; what else stands there is told.
void take_points(const MeasurementDraft& draft, Readings readings, Scene& scene, MeasurementSpec& spec) {
  const std::size_t written = readings.rows.size();
  // Empty rows at the end are no places along the rod, between points they are.
  while (!readings.rows.empty() && readings.blank[readings.rows.size() - 1]) readings.rows.pop_back();
  spec.equal_spacing = !readings.rows.empty() && readings.rows.front().size() == 2;
  const Spacing spacing = spec.equal_spacing ? spacing_of(readings.rows, scene.rod) : Spacing{};
  for (std::size_t i = 0; i < readings.rows.size(); ++i) {
    const std::vector<double>& row = readings.rows[i];
    if (!is_complete(row)) continue;
    const double s = row.size() == 3 ? row[0] : equal_arc_length(spacing, i, readings.rows.size(), scene.rod.length());
    const Vec2 origin{draft.origin[0].in_metres(draft.scale), draft.origin[1].in_metres(draft.scale)};
    const Vec2 p = Vec2{row[row.size() - 2], row[row.size() - 1]} - origin;
    spec.points.push_back({s, {p.x, draft.y_down ? -p.y : p.y}});
  }
  const std::size_t lost = written - spec.points.size();
  if (lost > 0) {
    scene.left_out.push_back({fmt::format("{} of the {} rows of {}", lost, written, draft.file),
                              "they hold no point: a value is empty or not a number"});
  }
  if (spacing.from_tip) scene.warnings.push_back("the measured points are read from the tip to the base");
}

}  // namespace

Table<MeasurementDraft> measurement_table() {
  using T = MeasurementDraft;
  const auto list = [](std::string name, KeyType type, const Dimension& dimension, std::string description, auto read) {
    KeySpec spec{std::move(name), type, dimension, "", std::move(description)};
    return Key<T>{spec, [spec, read](const Context& context, const Node& node, T& t) { read(context, node, spec, t); }};
  };
  return {{list("points", KeyType::points, dimension::length,
                "Measured backbone points: [s, x, y] each, or [x, y] at equal distances along the rod, the last one at "
                "the tip.",
                read_measured_points),
           text<T>("file", "", "CSV file with the points instead, beside the scene; columns x, y or s, x, y.",
                   [](T& t, const std::string& v) { t.file = v; }),
           quantity<T>("scale", dimension::length, positive, "none: numbers are in m",
                       "Length of one pixel; lengths without a unit in 'points', 'file' and 'origin' are pixels then.",
                       [](T& t, double v) { t.scale = v; }),
           list("origin", KeyType::point, dimension::length,
                "Where in the picture the scene's point (0, 0) is, in the coordinates of the points.", read_origin),
           boolean<T>("y_down", "false", "The points' y axis points down, as in a picture.",
                      [](T& t, bool v) { t.y_down = v; }),
           quantity<T>("noise", dimension::length, positive, "estimated from the residuals",
                       "Standard deviation of each measured coordinate.", [](T& t, double v) { t.noise = v; }),
           list("moments", KeyType::quantities, dimension::moment,
                "Moment of each actuator while the points were measured; not needed where min and max are equal.",
                read_known_moments)}};
}

MeasurementSpec finish_measurement(const Context& context, const MeasurementDraft& draft, Scene& scene) {
  const Document& document = context.document;
  MeasurementSpec spec;
  if (scene.problem != ProblemKind::estimate) {
    if (document.root().find("measurement") != nullptr) {
      document.fail(document.find("measurement"), "found [measurement] in a scene with problem = \"" +
                                                      std::string(to_string(scene.problem)) +
                                                      "\", expected problem = \"estimate\"");
    }
    return spec;
  }
  if (!draft.file.empty() && !draft.rows.empty()) {
    document.fail(document.find("measurement.file"), "found 'file' beside 'points', expected either of them");
  }
  take_points(draft, readings_of(context, draft, scene), scene, spec);
  spec.noise = draft.noise.value_or(0.0);
  spec.moments = draft.moments;
  return spec;
}

}  // namespace tendril::app
