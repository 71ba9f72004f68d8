#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "checks.hpp"
#include "difference.hpp"

namespace tendril::kit {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string shown(Vec2 p) { return "(" + kit::shown(p.x) + ", " + kit::shown(p.y) + ")"; }

/// Where points are tried: the shape's box and as much around it; for shapes without end, around the reference point.
struct Region {
  Vec2 middle{};
  double reach = 1.0;

  explicit Region(const Obstacle& shape) {
    Vec2 low, high;
    shape.bounding_box(low, high);
    middle = shape.reference_point();
    if (std::isfinite(low.x + low.y + high.x + high.y)) {
      middle = 0.5 * (low + high);
      reach = 1.5 * std::max(high.x - low.x, high.y - low.y);
    }
  }
  Vec2 random(std::mt19937& engine) const {
    std::uniform_real_distribution<double> d(-reach, reach);
    return middle + Vec2{d(engine), d(engine)};
  }
};

void check_distance(const Obstacle& shape, const Region& region, Findings& findings) {
  std::mt19937 random(2);
  // Shapes found by iteration are good to some digits less than those of a formula.
  const double accuracy = 1e-9 * region.reach;
  int inside = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 p = region.random(random);
    const Vec2 q = region.random(random);
    const SurfacePoint here = shape.at(p);
    const SurfacePoint there = shape.at(q);
    inside += here.distance < 0.0 ? 1 : 0;
    findings.expect(std::isfinite(here.distance) && std::isfinite(here.curvature) && std::isfinite(here.curvature_rate),
                    "finite",
                    "at " + shown(p) + " the distance is " + kit::shown(here.distance) + " and the curvature " +
                        kit::shown(here.curvature) + "; expected numbers");
    findings.expect(std::abs(norm(here.normal) - 1.0) <= 1e-12, "unit normal",
                    "at " + shown(p) + " the normal has length " + kit::shown(norm(here.normal)) + "; expected 1");
    findings.expect(std::abs(here.distance - there.distance) <= norm(p - q) + accuracy, "distance",
                    "between " + shown(p) + " and " + shown(q) + ", which are " + kit::shown(norm(p - q)) +
                        " apart, it changes by " + kit::shown(std::abs(here.distance - there.distance)) +
                        "; expected no more than they are apart. A formula that is zero on the boundary is not a "
                        "distance yet: return the way to the nearest boundary point");
    if (shape.core_distance(p) <= 0.0) continue;  // inside the core the nearest point may not be the only one
    const Vec2 foot = p - here.distance * here.normal;
    const SurfacePoint landed = shape.at(foot);
    findings.expect(std::abs(landed.distance) <= accuracy, "nearest point",
                    "from " + shown(p) + " the distance " + kit::shown(here.distance) +
                        " back along the normal leads to " + shown(foot) + ", which is " + kit::shown(landed.distance) +
                        " from the boundary; expected a point of the boundary");
    findings.expect(!shape.convex() || there.distance >= here.distance + dot(here.normal, q - p) - accuracy,
                    "convex shape",
                    "the distance at " + shown(q) + " is below the tangent from " + shown(p) +
                        "; expected a convex shape, or convex() to say that it is none");
  }
  findings.expect(inside > 0 || !std::isfinite(shape.smallest_radius()), "inside",
                  "none of 2000 points in and around bounding_box() has a negative distance; expected a body");
}

void check_derivatives(const Obstacle& shape, const Region& region, Findings& findings) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 400; ++trial) {
    const Vec2 p = region.random(random);
    // Level sets bend more the nearer they are to the core.
    const double h = std::min(1e-3 * region.reach, 0.02 * shape.core_distance(p));
    if (h < 1e-5 * region.reach) continue;
    const int patch = shape.patch_at(p);
    const auto at = [&](Vec2 q) { return shape.on_patch(patch, q); };
    const SurfacePoint s = at(p);
    const Vec2 tau = turned(s.normal);
    const auto along = [&](Vec2 direction, auto&& f) {
      return difference([&](double t) { return f(at(p + t * direction)); }, 0.0, h);
    };
    const auto distance = [](const SurfacePoint& q) { return q.distance; };
    const auto turn = [&](const SurfacePoint& q) { return dot(q.normal, tau); };
    const auto say = [&](const char* what, double stated, const Difference& found, const char* of) {
      return "at " + shown(p) + " " + what + " is stated as " + kit::shown(stated) + ", but differences of the " + of +
             " give " + kit::shown(found.value);
    };
    const Difference outward = along(s.normal, distance);
    findings.expect(agrees(1.0, outward, 1.0), "normal", say("the slope along the normal", 1.0, outward, "distance"));
    const Difference sideways = along(tau, distance);
    findings.expect(agrees(0.0, sideways, 1.0), "normal",
                    say("the slope across the normal", 0.0, sideways, "distance"));
    const Difference bend = along(tau, turn);
    const double unit = 1.0 / shape.core_distance(p);
    findings.expect(agrees(s.curvature, bend, unit), "curvature", say("the curvature", s.curvature, bend, "normal"));
    const Difference rate = along(tau, [](const SurfacePoint& q) { return q.curvature; });
    findings.expect(agrees(s.curvature_rate, rate, unit * unit), "curvature_rate",
                    say("the rate of curvature along turned(normal)", s.curvature_rate, rate, "curvature"));
  }
}

void check_core(const Obstacle& shape, const Region& region, Findings& findings) {
  std::mt19937 random(4);
  const double accuracy = 1e-9 * region.reach;
  const double rounding = shape.rounding();
  const bool finite = std::isfinite(shape.smallest_radius());
  findings.expect(shape.smallest_radius() > 0.0, "smallest_radius",
                  "found " + kit::shown(shape.smallest_radius()) + "; expected more than 0: round the corners");
  findings.expect(
      rounding >= 0.0 && rounding <= shape.smallest_radius() + accuracy, "rounding",
      "found " + kit::shown(rounding) + "; expected 0 to smallest_radius() = " + kit::shown(shape.smallest_radius()));
  for (int trial = 0; trial < 1000; ++trial) {
    const Vec2 p = region.random(random);
    const SurfacePoint s = shape.at(p);
    const double core = shape.core_distance(p);
    const double expected = finite ? std::max(0.0, s.distance + rounding) : s.distance;
    findings.expect(std::abs(core - expected) <= accuracy, "core_distance",
                    "at " + shown(p) + " found " + kit::shown(core) + "; expected " + kit::shown(expected) +
                        (finite ? ": the distance plus rounding(), not below 0" : ": the distance itself"));
    if (!(core > 0.0)) continue;
    const double on_boundary = shape.at(p - s.distance * s.normal).curvature;
    findings.expect(on_boundary * shape.smallest_radius() <= 1.0 + 1e-6 || !finite, "smallest_radius",
                    "the boundary near " + shown(p) + " has the radius " + kit::shown(1.0 / on_boundary) +
                        "; expected none below smallest_radius() = " + kit::shown(shape.smallest_radius()));
  }
}

void check_figures(const Obstacle& shape, const Region& region, Findings& findings) {
  const Vec2 reference = shape.reference_point();
  findings.expect(shape.at(reference).distance <= 1e-9 * region.reach, "reference_point",
                  shown(reference) + " lies " + kit::shown(shape.at(reference).distance) +
                      " outside; expected a point in the body or on its boundary");
  Vec2 low, high;
  shape.bounding_box(low, high);
  std::mt19937 random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 p = region.random(random);
    if (shape.at(p).distance > 0.0) continue;
    findings.expect(p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y, "bounding_box",
                    shown(p) + " lies in the body but outside of the box " + shown(low) + " to " + shown(high));
  }
  const Vec2 reach{region.reach, region.reach};
  const Vec2 view_low = region.middle - reach;
  const Vec2 view_high = region.middle + reach;
  std::vector<Vec2> points(400);
  shape.outline(points, view_low, view_high);
  for (const Vec2 p : points) {
    // A shape without end is drawn along the edge of the view too.
    const bool at_edge = std::min({p.x - view_low.x, view_high.x - p.x, p.y - view_low.y, view_high.y - p.y}) < 1e-9;
    if (at_edge && !std::isfinite(low.x + low.y + high.x + high.y)) continue;
    // A chord of the drawing may cut a corner.
    findings.expect(
        std::abs(shape.at(p).distance) <= 5e-3 * region.reach, "outline",
        shown(p) + " is " + kit::shown(shape.at(p).distance) + " from the boundary; expected a point of it");
  }
}

}  // namespace

void check_obstacle(const Obstacle& shape, Findings& findings) {
  const Region region(shape);
  check_distance(shape, region, findings);
  check_derivatives(shape, region, findings);
  check_core(shape, region, findings);
  check_figures(shape, region, findings);
}

}  // namespace tendril::kit
