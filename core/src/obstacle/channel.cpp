#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "obstacle/part.hpp"
#include "obstacle/room.hpp"
#include "obstacle/shape_options.hpp"
#include "tendril/numbers.hpp"

namespace tendril {
namespace {

constexpr double pi = std::numbers::pi;
/// Where the centre line turns by more (rad), its strip goes around the outside of the corner instead of to its tip.
constexpr double mitred = pi / 6.0;
/// Corners on the way around, rad.
constexpr double step = pi / 12.0;
constexpr double farthest_turn = pi - 0.02;

struct CenterLine {
  std::vector<Vec2> points;
  std::vector<double> widths;

  std::size_t sides() const { return points.size() - 1; }
  Vec2 along(std::size_t side) const {
    const Vec2 way = points[side + 1] - points[side];
    return (1.0 / norm(way)) * way;
  }
  /// Of the way at a point, to the left; 0 at the ends.
  double turn(std::size_t point) const {
    if (point == 0 || point == sides()) return 0.0;
    return std::atan2(cross(along(point - 1), along(point)), dot(along(point - 1), along(point)));
  }
};

/// What lies within half of the width and `more` of the line, up to `beyond` its ends: a quadrangle for each side, and
/// what is missing at the outside of corners. Seen from the line it is nowhere narrower than that.
std::vector<ClosedLine> strip(const CenterLine& line, double more, double beyond_start, double beyond_end) {
  std::vector<ClosedLine> all;
  const auto half = [&](std::size_t point) { return 0.5 * line.widths[point] + more; };
  /// Across the line at the beginning or end of a side, to its left.
  const auto across = [&](std::size_t side, std::size_t point) {
    const double turn = line.turn(point);
    if (turn == 0.0 || std::abs(turn) > mitred) return half(point) * turned(line.along(side));
    const Vec2 before = turned(line.along(point - 1));
    const Vec2 after = turned(line.along(point));
    return (half(point) / (1.0 + dot(before, after))) * (before + after);
  };
  for (std::size_t i = 0; i < line.sides(); ++i) {
    // Beyond its ends the strip goes on as it ends, but never to a point.
    const double back = i == 0 ? beyond_start : 0.0;
    const double on = i + 1 == line.sides() ? beyond_end : 0.0;
    const double widening = (half(i + 1) - half(i)) / norm(line.points[i + 1] - line.points[i]);
    const Vec2 from = line.points[i] - back * line.along(i);
    const Vec2 to = line.points[i + 1] + on * line.along(i);
    const Vec2 first = std::max(0.1, 1.0 - back * widening / half(i)) * across(i, i);
    const Vec2 last = std::max(0.1, 1.0 + on * widening / half(i + 1)) * across(i, i + 1);
    all.push_back({from + first, from - first, to - last, to + last});
  }
  for (std::size_t i = 1; i < line.sides(); ++i) {
    const double turn = line.turn(i);
    if (std::abs(turn) <= mitred) continue;
    const Vec2 center = line.points[i];
    const Vec2 out = (turn > 0.0 ? -half(i) : half(i)) * turned(line.along(i - 1));
    const auto at = [&](double angle) { return center + std::cos(angle) * out + std::sin(angle) * turned(out); };
    const int corners = static_cast<int>(std::ceil(std::abs(turn) / step));
    ClosedLine fan{center, at(0.0)};
    for (int k = 0; k < corners; ++k) {
      const double reach = 1.0 / std::cos(0.5 * turn / corners);
      fan.push_back(center + reach * (at((k + 0.5) * turn / corners) - center));
    }
    // The same point as that of the next side, to the last digit.
    fan.push_back(center + (turn > 0.0 ? -half(i) : half(i)) * turned(line.along(i)));
    all.push_back(std::move(fan));
  }
  return all;
}

CenterLine line_of(const Options& options) {
  CenterLine line;
  const NumberTable& table = options.table("points");
  for (int i = 0; i < table.rows; ++i) line.points.push_back({table(i, 0), table(i, 1)});
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    if (!(norm(line.points[i + 1] - line.points[i]) > 0.0)) {
      refuse_option("channel", "points", "point " + std::to_string(i + 1) + " twice in a row", "points that differ");
    }
  }
  for (std::size_t i = 1; i < line.sides(); ++i) {
    if (std::abs(line.turn(i)) > farthest_turn) {
      refuse_option("channel", "points", "point " + std::to_string(i + 1) + ", at which the line turns back on itself",
                    "a line with room for both directions");
    }
  }
  if (options.has("width") == options.has("widths")) {
    throw Error(options.has("width") ? "found 'width' and 'widths' of a channel; expected one of them"
                                     : "found neither 'width' nor 'widths' of a channel; expected one of them");
  }
  if (options.has("width")) {
    line.widths.assign(line.points.size(), options.real("width"));
  } else {
    line.widths = options.table("widths").values;
    if (line.widths.size() != line.points.size()) {
      refuse_option("channel", "widths", std::to_string(line.widths.size()) + " entries",
                    "one for each of the " + std::to_string(line.points.size()) + " points");
    }
    const auto narrow = std::find_if(line.widths.begin(), line.widths.end(), [](double w) { return !(w > 0.0); });
    if (narrow != line.widths.end()) {
      refuse_option("channel", "widths", "no width at point " + std::to_string(narrow - line.widths.begin() + 1),
                    "widths above 0");
    }
  }
  return line;
}

/// The walls, which know what room they keep.
class Channel : public Part, public Room {
 public:
  /// `mouths`: the middle of each open end.
  Channel(const std::vector<ClosedLine>& walls, double rounding, std::vector<ClosedLine> room, std::vector<Vec2> mouths)
      : Part(walls, rounding), room_(std::move(room)), mouths_(std::move(mouths)) {}
  ~Channel() override;

  double outside_room(Vec2 point) const override {
    Vec2 nearest{infinity, infinity};
    for (const ClosedLine& part : room_) {
      if (lies_inside(part, point)) return 0.0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        const Vec2 side = part[(i + 1) % part.size()] - part[i];
        const double t = std::clamp(dot(point - part[i], side) / dot(side, side), 0.0, 1.0);
        const Vec2 there = part[i] + t * side;
        if (norm(there - point) < norm(nearest - point)) nearest = there;
      }
    }
    const auto open = [&](Vec2 there) { return !separates(point, there); };
    return open(nearest) || std::any_of(mouths_.begin(), mouths_.end(), open) ? 0.0 : norm(nearest - point);
  }

 private:
  std::vector<ClosedLine> room_;
  std::vector<Vec2> mouths_;
};

Channel::~Channel() = default;

std::unique_ptr<Obstacle> make_channel(const Options& options) {
  const CenterLine line = line_of(options);
  const auto [narrowest, widest] = std::minmax_element(line.widths.begin(), line.widths.end());
  const double rounding = options.has("rounding") ? options.real("rounding") : 0.1 * *narrowest;
  const double wall = options.has("wall") ? options.real("wall") : *widest;
  if (!(wall > 2.0 * rounding)) {
    refuse_option("channel", "wall", "a wall of " + shown(wall / rounding) + " times its rounding",
                  "more than twice the rounding");
  }
  const std::string& closed = options.text("closed");
  const double shut = wall - rounding;
  const double start = closed == "start" || closed == "both" ? shut : 0.0;
  const double end = closed == "end" || closed == "both" ? shut : 0.0;
  std::vector<Vec2> mouths;
  if (start == 0.0) mouths.push_back(line.points.front());
  if (end == 0.0) mouths.push_back(line.points.back());
  // The core of the walls stands back by the rounding, with which they reach the width again.
  return std::make_unique<Channel>(
      boundary_of(strip(line, wall - rounding, start, end), strip(line, rounding, rounding, rounding)), rounding,
      strip(line, 0.0, 0.0, 0.0), std::move(mouths));
}

OptionSpec length_option(std::string name, std::string description) {
  OptionSpec option = positive_length_option(std::move(name), std::move(description));
  option.required = false;
  return option;
}

}  // namespace

Component<Obstacle> channel_component() {
  OptionSpec widths;
  widths.name = "widths";
  widths.type = OptionType::list;
  widths.dimension = dimension::length;
  widths.description = "instead of the width: one for each point, with straight walls in between";
  OptionSpec closed;
  closed.name = "closed";
  closed.type = OptionType::text;
  closed.choices = {"none", "start", "end", "both"};
  closed.default_value = std::string("none");
  closed.description = "ends that have a wall";
  return {
      "channel",
      "the walls of a channel or a pipe along a line, inside of which a rod can be",
      {points_option("points", 2, "the middle of the channel, from its start to its end"),
       length_option("width", "free room between the walls"), widths,
       length_option("wall",
                     "thickness of the walls; the largest width unless given. Where the channel comes back to "
                     "itself, its room is cut out of the wall"),
       length_option("rounding", "radius of the walls' corners; a tenth of the smallest width unless given"), closed},
      make_channel};
}

}  // namespace tendril
