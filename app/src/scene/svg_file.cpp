#include "scene/svg_file.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>

#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/numbers.hpp"
#include "tendril/options.hpp"

namespace tendril::app {

namespace {

using Attributes = std::map<std::string, std::string, std::less<>>;

constexpr double inch = 0.0254;

/// x -> x first + y second + shift.
struct Transform {
  Vec2 first{1.0, 0.0}, second{0.0, 1.0}, shift{};
  Vec2 turn(Vec2 v) const { return v.x * first + v.y * second; }
  Vec2 operator()(Vec2 p) const { return turn(p) + shift; }
  Transform operator*(const Transform& inner) const {
    return {turn(inner.first), turn(inner.second), (*this)(inner.shift)};
  }
};

/// Numbers between blanks and commas; nothing: there is something else among them.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  std::size_t at = 0;
  const auto skip = [&] {
    while (at < text.size() && std::string_view(" \t\r\n,").find(text[at]) != std::string_view::npos) ++at;
  };
  for (skip(); at < text.size(); skip()) {
    if (text[at] == '+') ++at;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    at = static_cast<std::size_t>(end - text.data());
  }
  return numbers;
}

class SvgReader {
 public:
  SvgReader(std::filesystem::path path, std::string id, const std::optional<double>& unit)
      : path_(std::move(path)), id_(std::move(id)), unit_(unit), parser_(XML_ParserCreate(nullptr), XML_ParserFree) {}

  Drawing read() {
    const std::string text = read_input(path_, "obstacle.file");
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const XML_Char* name, const XML_Char** attributes) {
          static_cast<SvgReader*>(self)->guarded([&](SvgReader& reader) { reader.begin(name, attributes); });
        },
        [](void* self, const XML_Char*) { static_cast<SvgReader*>(self)->end(); });
    const auto size = static_cast<int>(text.size());
    const XML_Status status = XML_Parse(parser_.get(), text.data(), size, XML_TRUE);
    if (failure_) std::rethrow_exception(failure_);
    if (status != XML_STATUS_OK)
      fail(fmt::format("this is no SVG: {}", XML_ErrorString(XML_GetErrorCode(parser_.get()))));
    finish();
    return std::move(drawing_);
  }

 private:
  struct Level {
    Transform to_root;
    bool hidden = false;
    bool wanted = false;
  };

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(fmt::format("{}:{}:{}: {}", path_.string(), XML_GetCurrentLineNumber(parser_.get()),
                                 XML_GetCurrentColumnNumber(parser_.get()) + 1, message));
  }

  /// No exception may pass through the parser.
  template <class Act>
  void guarded(Act&& act) {
    if (failure_) return;
    try {
      act(*this);
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void begin(std::string name, const XML_Char** given) {
    if (const auto colon = name.find(':'); colon != std::string::npos) name = name.substr(colon + 1);
    Attributes attributes;
    for (; *given != nullptr; given += 2) attributes[given[0]] = given[1];
    if (levels_.empty()) {
      if (name != "svg") fail(fmt::format("found <{}>, expected <svg>", name));
      take_unit(attributes);
      levels_.push_back({{}, false, id_.empty()});
    }
    Level level = levels_.back();
    const std::string& own = text_of(attributes, "id");
    if (!own.empty()) ids_.push_back(own);
    if (!id_.empty() && own == id_) level.wanted = found_ = true;
    level.to_root = level.to_root * transform_of(attributes);
    static const std::set<std::string, std::less<>> never_drawn{"defs",   "symbol",  "clipPath", "mask",
                                                                "marker", "pattern", "metadata"};
    const std::string& style = text_of(attributes, "style");
    level.hidden = level.hidden || never_drawn.count(name) > 0 || text_of(attributes, "display") == "none" ||
                   style.find("display:none") != std::string::npos;
    levels_.push_back(level);
    if (level.wanted && !level.hidden) draw(name, attributes, style, level.to_root);
  }

  /// Of an element at which reading stopped the parser may tell the end all the same.
  void end() {
    if (!levels_.empty()) levels_.pop_back();
  }

  static const std::string& text_of(const Attributes& attributes, std::string_view name) {
    static const std::string nothing;
    const auto found = attributes.find(name);
    return found == attributes.end() ? nothing : found->second;
  }

  /// What a unit of the coordinates is long, from the width of the page and how many units that is.
  void take_unit(const Attributes& attributes) {
    if (unit_) return;
    const std::string& width = text_of(attributes, "width");
    const std::string& height = text_of(attributes, "height");
    const std::string& box = text_of(attributes, "viewBox");
    unit_ = inch / 96.0;
    if (box.empty()) return;
    const auto view = numbers_in(box);
    if (!view || view->size() != 4 || !((*view)[2] > 0.0) || !((*view)[3] > 0.0)) {
      fail(fmt::format("found viewBox = \"{}\", expected four numbers, the last two above 0", box));
    }
    if (width.empty() && height.empty()) return;
    double least = infinity;
    if (!width.empty()) least = std::min(least, length(width, "width") / (*view)[2]);
    if (!height.empty()) least = std::min(least, length(height, "height") / (*view)[3]);
    *unit_ *= least;
  }

  /// In units of 1/96 inch, which are those of coordinates without a viewBox.
  double length(const std::string& text, const std::string& name) const {
    double value = 0.0;
    const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    const std::string suffix(end, text.data() + text.size());
    static const std::map<std::string, double, std::less<>> sizes{
        {"", 1.0},           {"px", 1.0},         {"in", 96.0},       {"cm", 96.0 / 2.54},
        {"mm", 96.0 / 25.4}, {"pt", 96.0 / 72.0}, {"pc", 96.0 / 6.0}, {"Q", 96.0 / 101.6}};
    const auto size = sizes.find(suffix);
    if (error != std::errc{} || !std::isfinite(value) || size == sizes.end()) {
      fail(fmt::format("found {} = \"{}\", expected a length such as \"210 mm\" without the blank{}", name, text,
                       suffix == "%" ? ", or 'unit' in [obstacle.file]: a share of the page says no size" : ""));
    }
    return value * size->second;
  }

  double length_of(const Attributes& attributes, const std::string& name, double otherwise = 0.0) const {
    const std::string& text = text_of(attributes, name);
    return text.empty() ? otherwise : length(text, name);
  }

  Transform transform_of(const Attributes& attributes) const {
    std::string_view left = text_of(attributes, "transform");
    const auto wrong = [&] {
      fail(
          fmt::format("found transform = \"{}\", expected matrix, translate, scale, rotate, skewX or skewY with their "
                      "numbers",
                      text_of(attributes, "transform")));
    };
    Transform all;
    while (left.find_first_not_of(" \t\r\n,") != std::string_view::npos) {
      left.remove_prefix(left.find_first_not_of(" \t\r\n,"));
      const auto open = left.find('(');
      const auto close = left.find(')');
      if (open == std::string_view::npos || close == std::string_view::npos || close < open) wrong();
      std::string_view name = left.substr(0, open);
      while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
      const auto n = numbers_in(left.substr(open + 1, close - open - 1));
      const std::optional<Transform> one = n ? transform(name, *n) : std::nullopt;
      if (!one) wrong();
      all = all * *one;
      left.remove_prefix(close + 1);
    }
    return all;
  }

  static std::optional<Transform> transform(std::string_view name, const std::vector<double>& n) {
    const auto radians = [&](double degrees) { return degrees * std::numbers::pi / 180.0; };
    if (name == "matrix" && n.size() == 6) return Transform{{n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}};
    if (name == "translate" && (n.size() == 1 || n.size() == 2)) {
      return Transform{{1.0, 0.0}, {0.0, 1.0}, {n[0], n.size() > 1 ? n[1] : 0.0}};
    }
    if (name == "scale" && (n.size() == 1 || n.size() == 2)) return Transform{{n[0], 0.0}, {0.0, n.back()}, {}};
    if (name == "skewX" && n.size() == 1) return Transform{{1.0, 0.0}, {std::tan(radians(n[0])), 1.0}, {}};
    if (name == "skewY" && n.size() == 1) return Transform{{1.0, std::tan(radians(n[0]))}, {0.0, 1.0}, {}};
    if (name != "rotate" || (n.size() != 1 && n.size() != 3)) return std::nullopt;
    const Vec2 axis{std::cos(radians(n[0])), std::sin(radians(n[0]))};
    const Vec2 around = n.size() == 3 ? Vec2{n[1], n[2]} : Vec2{};
    const Transform turn{axis, turned(axis), {}};
    return Transform{axis, turned(axis), around - turn(around)};
  }

  void draw(const std::string& name, const Attributes& attributes, const std::string& style, const Transform& to_root) {
    std::vector<CurvedLine> lines;
    const auto number = [&](const std::string& key) { return length_of(attributes, key); };
    const auto size = [&](const std::string& key) {
      if (const double length = number(key); length >= 0.0) return length;
      fail(fmt::format("found {} = \"{}\", expected a length that is not negative", key, text_of(attributes, key)));
    };
    if (name == "path") {
      try {
        lines = lines_of_path(text_of(attributes, "d"));
      } catch (const Error& error) {
        fail(error.what());
      }
    } else if (name == "polygon" || name == "polyline") {
      lines.push_back(polygon(text_of(attributes, "points")));
    } else if (name == "rect") {
      lines.push_back(rectangle({number("x"), number("y")}, {size("width"), size("height")},
                                length_of(attributes, "rx", number("ry")), length_of(attributes, "ry", number("rx"))));
    } else if (name == "circle" || name == "ellipse") {
      const double rx = size(name == "circle" ? "r" : "rx");
      const double ry = size(name == "circle" ? "r" : "ry");
      lines.emplace_back();
      add_arc(lines.back(), {number("cx"), number("cy")}, {rx, 0.0}, {0.0, ry}, 0.0, 2.0 * std::numbers::pi);
      lines.back().back()[3] = lines.back().front()[0];
    } else {
      static const std::set<std::string, std::less<>> other{"text", "image", "use", "line", "foreignObject"};
      if (other.count(name) > 0) ++unread_[name];
      return;
    }
    const bool even_odd =
        text_of(attributes, "fill-rule") == "evenodd" || style.find("fill-rule:evenodd") != std::string::npos;
    // Upside down: y points up here.
    const Transform to_metres = Transform{{*unit_, 0.0}, {0.0, -*unit_}, {}} * to_root;
    for (CurvedLine& line : lines) {
      for (Cubic& c : line) {
        for (Vec2& p : c) p = to_metres(p);
      }
    }
    std::erase_if(lines, is_straight);
    fill(lines, even_odd);
  }

  /// All of it lies on one straight line. One that crosses itself may have no area either, and is to be refused.
  static bool is_straight(const CurvedLine& line) {
    Vec2 way{};
    for (const Cubic& c : line) {
      for (const Vec2 p : c) {
        if (norm(p - line.front()[0]) > norm(way)) way = p - line.front()[0];
      }
    }
    const double rounding = 1e-12 * dot(way, way);
    return std::all_of(line.begin(), line.end(), [&](const Cubic& c) {
      return std::all_of(c.begin(), c.end(),
                         [&](Vec2 p) { return std::abs(cross(way, p - line.front()[0])) <= rounding; });
    });
  }

  CurvedLine polygon(const std::string& points) const {
    const auto numbers = numbers_in(points);
    if (!numbers || numbers->size() % 2 != 0) {
      fail(fmt::format("found points = \"{}\", expected pairs of numbers", points.substr(0, 60)));
    }
    CurvedLine line;
    for (std::size_t i = 0; i + 1 < numbers->size(); i += 2) {
      const std::size_t k = i + 3 < numbers->size() ? i + 2 : 0;
      line.push_back(straight({(*numbers)[i], (*numbers)[i + 1]}, {(*numbers)[k], (*numbers)[k + 1]}));
    }
    return line;
  }

  static CurvedLine rectangle(Vec2 at, Vec2 size, double rx, double ry) {
    rx = std::min(rx, 0.5 * size.x);
    ry = std::min(ry, 0.5 * size.y);
    const Vec2 center = at + 0.5 * size;
    CurvedLine line;
    constexpr double quarter = 0.5 * std::numbers::pi;
    for (int corner = 0; corner < 4; ++corner) {
      const Vec2 towards{corner == 0 || corner == 3 ? 1.0 : -1.0, corner < 2 ? 1.0 : -1.0};
      const Vec2 middle = center + Vec2{towards.x * (0.5 * size.x - rx), towards.y * (0.5 * size.y - ry)};
      CurvedLine arc;
      if (rx > 0.0 && ry > 0.0) {
        add_arc(arc, middle, {rx, 0.0}, {0.0, ry}, corner * quarter, (corner + 1) * quarter);
      } else {
        arc.push_back(
            straight(middle + Vec2{towards.x * rx, towards.y * ry}, middle + Vec2{towards.x * rx, towards.y * ry}));
      }
      if (!line.empty()) line.push_back(straight(line.back()[3], arc.front()[0]));
      line.insert(line.end(), arc.begin(), arc.end());
    }
    line.push_back(straight(line.back()[3], line.front()[0]));
    return line;
  }

  /// Which lines of one element are outlines and which are holes, by its rule; lines with body on both sides are none.
  void fill(const std::vector<CurvedLine>& lines, bool even_odd) {
    std::vector<Outline> rough;
    for (const CurvedLine& line : lines) {
      Outline& points = rough.emplace_back();
      for (const Cubic& c : line) {
        for (int k = 0; k < 8; ++k) points.push_back(point_of(c, 0.125 * k));
      }
      for (std::size_t k = 0; k + 1 < rough.size(); ++k) {
        if (!cross_each_other(rough[k], points)) continue;
        fail(
            fmt::format("found lines {} and {} of one path that cross each other, expected a path for each: what lies "
                        "in any of several paths is the body",
                        k + 1, rough.size()));
      }
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const bool left = twice_area(lines[i]) > 0.0;
      int outside = 0;
      for (std::size_t k = 0; k < lines.size(); ++k) {
        if (k == i || !lies_inside(rough[k], rough[i][4])) continue;
        outside += even_odd || twice_area(lines[k]) > 0.0 ? 1 : -1;
      }
      const int inside = outside + (even_odd || left ? 1 : -1);
      const auto solid = [&](int count) { return even_odd ? count % 2 != 0 : count != 0; };
      if (solid(inside) == solid(outside)) continue;
      drawing_.lines.push_back(left == solid(inside) ? lines[i] : reversed(lines[i]));
    }
  }

  static Vec2 point_of(const Cubic& c, double t) {
    const double u = 1.0 - t;
    return u * u * (u * c[0] + 3.0 * t * c[1]) + t * t * (3.0 * u * c[2] + t * c[3]);
  }

  void finish() {
    for (const auto& [name, count] : unread_) drawing_.unread.push_back(fmt::format("{} <{}>", count, name));
    if (!id_.empty() && !found_) {
      throw InputError(fmt::format("{}: nothing has the id '{}'{}", path_.string(), id_, did_you_mean(id_, ids_)));
    }
    if (!drawing_.lines.empty()) return;
    std::string held;
    for (const std::string& what : drawing_.unread) held += (held.empty() ? "" : ", ") + what;
    throw InputError(fmt::format("{}: found {}, expected paths, polygons, rectangles, circles or ellipses with an area",
                                 path_.string(), held.empty() ? "no outline" : held + " and no outline"));
  }

  std::filesystem::path path_;
  std::string id_;
  std::optional<double> unit_;
  std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser_;
  std::exception_ptr failure_;
  std::vector<Level> levels_;
  std::vector<std::string> ids_;
  std::map<std::string, int> unread_;
  bool found_ = false;
  Drawing drawing_;
};

}  // namespace

Drawing read_svg(const std::filesystem::path& path, const std::string& id, const std::optional<double>& unit) {
  return SvgReader(path, id, unit).read();
}

}  // namespace tendril::app
