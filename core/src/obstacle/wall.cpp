#include "obstacle/wall.hpp"

#include <cmath>
#include <vector>

#include "obstacle/outline.hpp"
#include "obstacle/shape_options.hpp"
#include "tendril/error.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

Wall::Wall(Vec2 point, Vec2 normal) : point_(point), normal_((1.0 / norm(normal)) * normal) {
  if (!std::isfinite(normal_.x) || !std::isfinite(normal_.y)) throw Error("a wall needs a normal that is not zero");
  if (!std::isfinite(point.x) || !std::isfinite(point.y)) throw Error("a wall needs a finite point");
}

Wall::~Wall() = default;

double Wall::smallest_radius() const { return infinity; }

void Wall::bounding_box(Vec2& low, Vec2& high) const {
  // Along an axis the half-plane has an end only if it is square to that axis.
  low = {-infinity, -infinity};
  high = {infinity, infinity};
  if (normal_.y == 0.0) (normal_.x > 0.0 ? high.x : low.x) = point_.x;
  if (normal_.x == 0.0) (normal_.y > 0.0 ? high.y : low.y) = point_.y;
}

void Wall::outline(std::span<Vec2> points, Vec2 low, Vec2 high) const {
  const Vec2 box[] = {low, {high.x, low.y}, high, {low.x, high.y}};
  std::vector<Vec2> inside;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 a = box[i];
    const Vec2 b = box[(i + 1) % 4];
    const double from = at(a).distance;
    const double to = at(b).distance;
    if (from <= 0.0) inside.push_back(a);
    if ((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0)) inside.push_back(a + (from / (from - to)) * (b - a));
  }
  spread_outline(inside, points);
}

Component<Obstacle> wall_component() {
  OptionSpec normal = point_option("normal", "direction out of the wall; its length does not matter");
  normal.required = false;
  normal.dimension = dimension::none;
  OptionSpec angle;
  angle.name = "angle";
  angle.dimension = dimension::angle;
  angle.description = "instead of the normal: direction of the surface, free space on its left; 0 is a table";
  return {"wall",
          "a half-plane",
          {point_option("point", "a point of the surface"), normal, angle},
          [](const Options& options) {
            if (options.has("normal") == options.has("angle")) {
              throw Error(options.has("angle") ? "found 'normal' and 'angle' of a wall; expected one of them"
                                               : "found neither 'normal' nor 'angle' of a wall; expected one of them");
            }
            if (options.has("angle")) {
              const double turn = options.real("angle");
              return std::make_unique<Wall>(point_of(options, "point"), Vec2{-std::sin(turn), std::cos(turn)});
            }
            const Vec2 out = point_of(options, "normal");
            // Numbers whose square under- or overflows are no directions either.
            const double length = norm(out);
            if (!(length > 1e-150 && length < 1e150)) {
              throw OptionError(
                  "normal", {},
                  "option 'normal' of a wall: found a vector of length " + shown(length) + "; expected a direction");
            }
            return std::make_unique<Wall>(point_of(options, "point"), out);
          }};
}

}  // namespace tendril
