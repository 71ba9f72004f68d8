#include "scene/measurement_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// A cell of a line of comma-separated values, and the column of its first character.
struct Cell {
  std::string text;
  std::size_t column = 1;
};

std::vector<Cell> cells_of(const std::string& line) {
  std::vector<Cell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::string raw = line.substr(begin, end - begin);
    const auto blank = raw.find_first_not_of(" \t\r");
    cells.push_back({trimmed(raw), begin + (blank == std::string::npos ? 0 : blank) + 1});
    begin = end + 1;
  }
  return cells;
}

/// A file of points: an optional line of names (s, x, y, in any order, each with an optional unit in brackets), then
/// one point per line. Empty lines and lines that begin with # are skipped.
class PointFile {
 public:
  PointFile(std::filesystem::path path, const Units& units) : path_(std::move(path)), units_(units) {}

  std::vector<std::vector<double>> read() {
    const std::string text = read_input(path_, "measurement");
    require_text(text, path_);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      ++line_;
      const std::string line = text.substr(begin, end - begin);
      begin = end + 1;
      const std::string content = trimmed(line);
      if (content.empty() || content.front() == '#') continue;
      take(cells_of(line));
    }
    if (rows_.empty()) throw InputError(path_.string() + ": found no points, expected lines with x, y or s, x, y");
    return std::move(rows_);
  }

 private:
  [[noreturn]] void fail(const Cell& cell, const std::string& message) const {
    throw InputError(fmt::format("{}:{}:{}: {}", path_.string(), line_, cell.column, message));
  }

  void take(const std::vector<Cell>& cells) {
    if (columns_.empty()) {
      const bool names =
          !cells.front().text.empty() && std::string("sxy").find(cells.front().text[0]) != std::string::npos;
      if (names) return take_names(cells);
      if (cells.size() != 2 && cells.size() != 3) {
        fail(cells.front(), fmt::format("found {} values, expected two (x, y) or three (s, x, y)", cells.size()));
      }
      for (std::size_t i = 0; i < cells.size(); ++i) columns_.push_back(i);
      units_of_.resize(cells.size());
    }
    if (cells.size() != columns_.size()) {
      fail(cells.back(),
           fmt::format("found {} values, expected {} as in the lines before", cells.size(), columns_.size()));
    }
    if (rows_.size() == most_measured_points) {
      fail(cells.front(), fmt::format("found more than {} points, expected at most as many", most_measured_points));
    }
    std::vector<double> row(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) row[columns_[i]] = value(cells[i], units_of_[i]);
    rows_.push_back(std::move(row));
  }

  void take_names(const std::vector<Cell>& cells) {
    const std::string expected = "x, y or s, x, y, each with its unit in brackets if it is not m, such as x [mm]";
    std::vector<std::string> names;
    for (const Cell& cell : cells) {
      const auto bracket = cell.text.find_first_of("[(");
      names.push_back(trimmed(cell.text.substr(0, bracket)));
      std::string unit;
      if (bracket != std::string::npos) {
        const char closing = cell.text[bracket] == '[' ? ']' : ')';
        if (cell.text.back() != closing) fail(cell, "found the column \"" + cell.text + "\", expected " + expected);
        unit = trimmed(cell.text.substr(bracket + 1, cell.text.size() - bracket - 2));
        value({"1", cell.column}, unit);
      }
      units_of_.push_back(unit);
    }
    const std::vector<std::string> order =
        names.size() == 3 ? std::vector<std::string>{"s", "x", "y"} : std::vector<std::string>{"x", "y"};
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto at = std::find(order.begin(), order.end(), names[i]);
      const auto column = static_cast<std::size_t>(at - order.begin());
      const bool again = std::find(columns_.begin(), columns_.end(), column) != columns_.end();
      if (names.size() != order.size() || at == order.end() || again) {
        fail(cells[i], "found the column \"" + cells[i].text + "\", expected " + expected);
      }
      columns_.push_back(column);
    }
    if (names.size() < 2) fail(cells.front(), "found one column, expected " + expected);
  }

  double value(const Cell& cell, const std::string& unit) const {
    // A plain number is in m, as everywhere in a scene.
    double plain = 0.0;
    const char* end = cell.text.data() + cell.text.size();
    const auto [rest, error_code] = std::from_chars(cell.text.data(), end, plain);
    if (unit.empty() && error_code == std::errc() && rest == end) {
      if (!std::isfinite(plain)) {
        fail(cell, "found \"" + cell.text + "\", expected " + expected_quantity(dimension::length, " that is finite"));
      }
      return plain;
    }
    try {
      return units_.read(unit.empty() ? cell.text : cell.text + ' ' + unit, dimension::length);
    } catch (const Error& error) {
      fail(cell, error.what());
    }
  }

  std::filesystem::path path_;
  const Units& units_;
  std::size_t line_ = 0;
  std::vector<std::size_t> columns_;  // which of s, x, y or x, y each column is
  std::vector<std::string> units_of_;
  std::vector<std::vector<double>> rows_;
};

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
    std::vector<double> row;
    for (const Node& entry : *entries) row.push_back(read_quantity(context, entry, key));
    draft.rows.push_back(std::move(row));
  }
}

void read_known_moments(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr) {
    context.fail(node, "a list of moments, one for each actuator");
  }
  for (const Node& item : *list) draft.moments.push_back(read_quantity(context, item, key));
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
           quantity<T>("noise", dimension::length, positive, "estimated from the residuals",
                       "Standard deviation of each measured coordinate.", [](T& t, double v) { t.noise = v; }),
           list("moments", KeyType::quantities, dimension::moment,
                "Moment of each actuator while the points were measured; not needed where min and max are equal.",
                read_known_moments)}};
}

MeasurementSpec finish_measurement(const Context& context, const MeasurementDraft& draft, const Scene& scene) {
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
  std::vector<std::vector<double>> rows = draft.rows;
  if (!draft.file.empty()) {
    if (!rows.empty()) {
      document.fail(document.find("measurement.file"), "found 'file' beside 'points', expected either of them");
    }
    rows = PointFile(std::filesystem::path(document.file()).parent_path() / draft.file, context.units).read();
  }
  const double length = scene.rod.length();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& row = rows[i];
    const bool given = row.size() == 3;
    const double s = given ? row[0] : length * static_cast<double>(i + 1) / static_cast<double>(rows.size());
    spec.points.push_back({s, {row[row.size() - 2], row[row.size() - 1]}});
  }
  spec.noise = draft.noise.value_or(0.0);
  spec.moments = draft.moments;
  return spec;
}

}  // namespace tendril::app
