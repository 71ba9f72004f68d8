#include "scene/obstacle_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>

#include "scene/stl_section.hpp"
#include "scene/svg_file.hpp"
#include "scene/table_file.hpp"
#include "system/delimited_text.hpp"

namespace tendril::app {

namespace {

constexpr std::size_t most_points = 20'000;  ///< of one obstacle

Table<OutlineFileDraft> file_table() {
  using T = OutlineFileDraft;
  return {
      {text<T>(
           "name", "",
           "SVG, STL or CSV file beside the scene. CSV: x, y on each line, for a polygon with several outlines also "
           "the "
           "number of the outline, for a channel perhaps its width.",
           [](T& t, const std::string& v) { t.name = v; }, {}, Need::required),
       text<T>("id", "all that it draws", "Of an SVG: the path, the shape or the group that is meant.",
               [](T& t, const std::string& v) { t.id = v; }),
       text<T>("plane", "z", "Of an STL: the axis across which its section is taken; the other two are x and y here.",
               [](T& t, const std::string& v) { t.plane = v; }, {"x", "y", "z"}),
       quantity<T>("height", dimension::length, any, "0", "Of an STL: where on that axis.",
                   [](T& t, double v) { t.height = v; }),
       quantity<T>("unit", dimension::length, positive, "what the width of an SVG's page says; 1 mm in an STL",
                   "The length of a unit of the coordinates of an SVG or an STL.", [](T& t, double v) { t.unit = v; }),
       quantity<T>("tolerance", dimension::length, not_negative, "0 for CSV; else a thousandth of the outline's size",
                   "How far the polygon may reach beyond the outline in the file, to have few corners. It contains it "
                   "all the same.",
                   [](T& t, double v) { t.tolerance = v; }),
       point<T>("position", dimension::length, "[0, 0]", "Where the origin of the file lies.",
                [](T& t, Vec2 v) { t.position = v; }),
       quantity<T>("angle", dimension::angle, any, "0", "Direction of the first axis of the file.",
                   [](T& t, double v) { t.angle = v; })}};
}

RawValue list_of(const std::vector<double>& values, SourcePosition position) {
  RawValue::List list;
  list.reserve(values.size());
  for (const double value : values) list.push_back({value, position});
  return {std::move(list), position};
}

RawValue points_of(const std::vector<Vec2>& points, SourcePosition position) {
  RawValue::List list;
  list.reserve(points.size());
  for (const Vec2 p : points) list.push_back(list_of({p.x, p.y}, position));
  return {std::move(list), position};
}

class FileReader {
 public:
  FileReader(const Context& context, const OutlineFileDraft& draft, std::string key, Scene& scene)
      : context_(context), draft_(draft), key_(std::move(key)), at_(context.document.find(key_)), scene_(scene) {}

  void read_into(ObstacleSpec& spec) {
    if (spec.shape == "channel") return read_channel(spec);
    if (spec.shape != "polygon") {
      fail("found a file for the shape '" + spec.shape + "', expected one for a polygon or a channel");
    }
    refuse_beside(spec, {"vertices", "outlines"});
    refuse_foreign_keys();
    const std::string kind = lower_case(path().extension().string());
    const std::vector<Outline> lines = kind == ".svg"   ? read_drawing()
                                       : kind == ".stl" ? read_section()
                                                        : read_points();
    std::vector<Vec2> all;
    std::vector<double> sizes;
    for (const Outline& line : lines) {
      for (const Vec2 p : line) all.push_back(placed(p));
      sizes.push_back(static_cast<double>(line.size()));
    }
    spec.options["vertices"] = points_of(all, at_);
    if (sizes.size() > 1) spec.options["outlines"] = list_of(sizes, at_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { context_.document.fail(at_, message); }

  /// What says nothing of a file of this kind was meant for another one.
  void refuse_foreign_keys() const {
    const std::string kind = lower_case(path().extension().string());
    const auto only = [&](const char* key, bool given, std::initializer_list<std::string_view> kinds) {
      if (!given || std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) return;
      std::string names;
      for (const std::string_view name : kinds) names += (names.empty() ? "" : " or ") + std::string(name);
      context_.document.fail(context_.document.find(key_ + '.' + key),
                             fmt::format("found '{}' for {}, expected it with a file {}", key, draft_.name, names));
    };
    only("id", !draft_.id.empty(), {".svg"});
    only("plane", !draft_.plane.empty(), {".stl"});
    only("height", draft_.height.has_value(), {".stl"});
    only("unit", draft_.unit.has_value(), {".svg", ".stl"});
  }

  void refuse_beside(const ObstacleSpec& spec, const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      const auto given = spec.options.find(name);
      if (given == spec.options.end()) continue;
      context_.document.fail(given->second.position, "found '" + name + "' beside 'file', expected either of them");
    }
  }

  Vec2 placed(Vec2 p) const {
    const Vec2 along{std::cos(draft_.angle), std::sin(draft_.angle)};
    return draft_.position + p.x * along + p.y * turned(along);
  }

  /// Bodies of one part may overlap, but seldom are meant to.
  void tell_crossings(const std::vector<Outline>& lines) {
    std::string first;
    int more = -1;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (!cross_each_other(lines[k], lines[i])) continue;
        if (++more == 0) first = fmt::format("{} and {}", k + 1, i + 1);
      }
    }
    if (first.empty()) return;
    scene_.left_out.push_back({fmt::format("crossings of outlines of {}: {}{}", draft_.name, first,
                                           more > 0 ? fmt::format(", {} more", more) : ""),
                               "what lies in any of them, less their holes, is one body"});
  }

  /// Unless it is given: a thousandth of the outline.
  double tolerance_for(Vec2 low, Vec2 high) const { return draft_.tolerance.value_or(1e-3 * norm(high - low)); }

  std::vector<Outline> read_section() {
    std::vector<Outline> lines = read_stl_section(path(), draft_.plane.empty() ? 'z' : draft_.plane[0],
                                                  draft_.height.value_or(0.0), draft_.unit.value_or(1e-3));
    Vec2 low = lines[0][0];
    Vec2 high = low;
    for (const Outline& line : lines) {
      for (const Vec2 p : line) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    }
    tell_crossings(lines);
    return simplified(lines, tolerance_for(low, high));
  }

  std::vector<Outline> read_drawing() {
    const Drawing drawing = read_svg(path(), draft_.id, draft_.unit);
    for (const std::string& what : drawing.unread) {
      scene_.left_out.push_back({what + " of " + draft_.name, "an obstacle reads outlines"});
    }
    Vec2 low = drawing.lines[0][0][0];
    Vec2 high = low;
    for (const CurvedLine& line : drawing.lines) {
      for (const Cubic& c : line) {
        low = {std::min(low.x, c[3].x), std::min(low.y, c[3].y)};
        high = {std::max(high.x, c[3].x), std::max(high.y, c[3].y)};
      }
    }
    const double tolerance = tolerance_for(low, high);
    if (!(tolerance > 0.0)) fail("found a tolerance of 0, expected one above 0: curves become straight sides");
    // A quarter for the curves, the rest to have fewer sides.
    std::vector<Outline> lines;
    std::size_t corners = 0;
    for (const CurvedLine& line : drawing.lines) {
      Outline straight = flattened(line, 0.25 * tolerance);
      corners += straight.size();
      if (straight.size() > 2) lines.push_back(std::move(straight));
    }
    if (corners > most_points) {
      fail(fmt::format("found {} corners at a tolerance of {} m, expected at most {}: a larger tolerance needs fewer",
                       corners, tolerance, most_points));
    }
    tell_crossings(lines);
    return simplified(lines, 0.75 * tolerance);
  }

  TableFile read_rows(const std::vector<ColumnSpec>& third) {
    TableFileSpec spec;
    spec.what = "obstacle.file";
    spec.columns = {{"x", dimension::length}, {"y", dimension::length}};
    spec.forms = {{0, 1}, {0, 1, 2}};
    spec.columns.insert(spec.columns.end(), third.begin(), third.end());
    spec.most_rows = most_points;
    TableFile file = read_table_file(path(), spec, context_.units);
    for (const std::string& column : file.unread) {
      scene_.left_out.push_back(
          {"column \"" + column + "\" of " + draft_.name, "an obstacle reads x, y and " + third[0].name});
    }
    for (std::size_t i = 0; i < file.rows.size(); ++i) {
      if (std::none_of(file.rows[i].begin(), file.rows[i].end(), [](double v) { return std::isnan(v); })) continue;
      throw InputError(
          fmt::format("{}: point {} of {} has an empty value or no number, expected a number in each column",
                      path().string(), i + 1, file.rows.size()));
    }
    return file;
  }

  std::vector<Outline> read_points() {
    const TableFile file = read_rows({{"outline", none, {"part", "loop"}}});
    std::vector<Outline> lines;
    for (std::size_t i = 0; i < file.rows.size(); ++i) {
      const std::vector<double>& row = file.rows[i];
      if (i == 0 || (row.size() > 2 && row[2] != file.rows[i - 1][2])) lines.emplace_back();
      lines.back().push_back({row[0], row[1]});
    }
    for (Outline& line : lines) {
      if (line.size() > 1 && line.front() == line.back()) line.pop_back();
    }
    // A single outline may run either way.
    if (lines.size() == 1 && twice_area(lines[0]) < 0.0) std::reverse(lines[0].begin(), lines[0].end());
    tell_crossings(lines);
    return simplified(lines, draft_.tolerance.value_or(0.0));
  }

  void read_channel(ObstacleSpec& spec) {
    refuse_beside(spec, {"points"});
    refuse_foreign_keys();
    if (draft_.tolerance) fail("found a 'tolerance' of a channel, expected one of a polygon");
    const TableFile file = read_rows({{"width", dimension::length, {"w", "diameter"}}});
    std::vector<Vec2> line;
    std::vector<double> widths;
    for (const std::vector<double>& row : file.rows) {
      line.push_back(placed({row[0], row[1]}));
      if (row.size() > 2) widths.push_back(row[2]);
    }
    spec.options["points"] = points_of(line, at_);
    if (widths.empty()) return;
    refuse_beside(spec, {"width", "widths"});
    spec.options["widths"] = list_of(widths, at_);
  }

  std::filesystem::path path() const {
    return std::filesystem::path(context_.document.file()).parent_path() / draft_.name;
  }

  const Context& context_;
  const OutlineFileDraft& draft_;
  std::string key_;
  SourcePosition at_;
  Scene& scene_;
};

}  // namespace

Table<ObstacleDraft> obstacle_table() {
  using T = ObstacleDraft;
  return {{text<T>("name", "obstacle 1, ...", "Name in reports.", [](T& t, const std::string& v) { t.spec.name = v; }),
           text<T>(
               "shape", "", "the name of an obstacle shape, such as \"circle\"",
               [](T& t, const std::string& v) { t.spec.shape = v; }, {}, Need::required),
           quantity<T>("friction", none, not_negative, "that of [contact]", "Coefficient of friction of its contacts.",
                       [](T& t, double v) { t.spec.friction = v; }),
           quantity<T>("turn", dimension::angle, any, "0",
                       "Turned so far, about the point that stands for it: the centre of a circle, the point of a "
                       "wall, the middle of others.",
                       [](T& t, double v) { t.spec.place.turn = v; }),
           point<T>("pivot", dimension::length, "that point", "What it is turned about instead, before any shift.",
                    [](T& t, Vec2 v) {
                      t.spec.options["pivot"] = list_of({v.x, v.y}, {});
                    }),
           point<T>("shift", dimension::length, "[0, 0]", "Moved so far from where its shape has it, after the turn.",
                    [](T& t, Vec2 v) { t.spec.place.shift = v; }),
           table<T>(
               "file", "obstacle.file", "Instead of the points of a polygon or a channel: a file that holds them.",
               file_table(), [](T & t) -> auto& { return t.file.emplace(); })},
          [](T& t, const std::string& name, RawValue value) { t.spec.options[name] = std::move(value); }};
}

void name_obstacles(std::vector<ObstacleSpec>& obstacles) {
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (obstacles[i].name.empty()) obstacles[i].name = fmt::format("obstacle {}", i + 1);
  }
}

std::vector<ObstacleSpec> finish_obstacles(const Context& context, std::vector<ObstacleDraft> drafts, Scene& scene) {
  std::vector<ObstacleSpec> obstacles;
  obstacles.reserve(drafts.size());
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    ObstacleSpec& spec = drafts[i].spec;
    if (drafts[i].file)
      FileReader(context, *drafts[i].file, fmt::format("obstacle[{}].file", i), scene).read_into(spec);
    obstacles.push_back(std::move(spec));
  }
  name_obstacles(obstacles);
  return obstacles;
}

}  // namespace tendril::app
