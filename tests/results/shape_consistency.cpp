// The shape of a rod and what touches it.

#include <algorithm>
#include <cmath>

#include "check/body.hpp"
#include "consistency.hpp"
#include "curve.hpp"

namespace tendril::results {
namespace {

/// Rounding: of 17 digits, and of the scene's data to 12 digits before they are used, relative to the length.
constexpr double rounding = 1e-11;
/// (rad; L) What polynomials through six rows leave: at most 4e-11 on the shapes of scenes/, the snap of a heavy rod.
constexpr double between_rows = 1e-9;
/// (rad) The same for a state on the way to the loads: pieces in which it was settled end at places that do not stand
/// in the result, and curvature bends there.
constexpr double between_rows_on_the_way = 1e-6;
/// The certificate's limits (tolerances.hpp) on gaps and forces and on closest points, doubled since it rounds
/// otherwise.
constexpr double complementarity = 2e-9;
constexpr double closest_point = 2e-8;
/// Beside an obstacle of 1 % of the length a point that is 1e-9 L off turns its normal by 1e-7.
constexpr double same_normal = 1e-7;
/// Contacts close to each other or to an end leave a stretch with too few rows; on most of the rod there are enough.
constexpr double most_unchecked = 0.15;

Vec2 direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

Curve curve_of(const Json& state, const ShownRod& shown) {
  std::vector<double> breaks;
  double end = 0.0;
  for (const SegmentSpec& segment : shown.rod.segments) breaks.push_back(end += segment.length);
  for (const ActuatorSpec& actuator : shown.rod.actuators) breaks.insert(breaks.end(), {actuator.from, actuator.to});
  for (const Json& contact : state.at("contacts")) {
    if (contact.at("arc_length").is_number()) breaks.push_back(contact.at("arc_length").get<double>());
  }
  // The ends of the rod are none: what is smooth goes up to them.
  std::erase_if(breaks, [&](double b) { return b <= rounding * end || b >= (1.0 - rounding) * end; });
  return {state.at("backbone"), breaks};
}

}  // namespace

double force_unit(const RodSpec& rod) {
  const double length = rod.length();
  return rod.segments.front().bending_stiffness / (length * length);
}

void check_shape(const Json& state, const ShownRod& shown, bool certified, Findings& found) {
  const Curve curve = curve_of(state, shown);
  const auto& rows = curve.rows();
  const double length = shown.rod.length();
  found.near("arc length of the first row", rows.front().s, 0.0, 0.0);
  found.near("x of the base", rows.front().x, shown.base.x, rounding * length);
  found.near("y of the base", rows.front().y, shown.base.y, rounding * length);
  found.near("angle of the base", rows.front().angle, shown.base_angle, rounding);
  found.near("arc length of the last row", rows.back().s, length, rounding * length);
  found.that(std::is_sorted(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.s <= b.s; }),
             "arc lengths of the backbone do not ascend");
  found.near("curvature against the slope of the angle (rad between two rows)", curve.slope_error(), 0.0,
             certified ? between_rows : between_rows_on_the_way);
  found.near("points against the integral of the angle (L between two rows)", curve.step_error() / length, 0.0,
             between_rows);
  found.near("share of the rod between rows that could not be looked at", curve.unchecked_share(), 0.0, most_unchecked);
  const Json& tip = state.at("tip");
  found.near("x of the tip", tip.at("x").get<double>(), rows.back().x, rounding * length);
  found.near("y of the tip", tip.at("y").get<double>(), rows.back().y, rounding * length);
  found.near("angle of the tip", tip.at("angle").get<double>(), rows.back().angle, rounding);
}

void check_contacts(const Json& state, const ShownRod& shown, const Scene& scene, const Json& result, bool certified,
                    Findings& found) {
  const Curve curve = curve_of(state, shown);
  const double length = shown.rod.length();
  for (const Json& contact : state.at("contacts")) {
    const Findings::Place place(found, "contact with " + contact.at("obstacle").get<std::string>());
    const auto index = contact.at("obstacle_index").get<std::size_t>();
    const double s = contact.at("arc_length").get<double>();
    const double force = contact.at("force").get<double>();
    const double gap = contact.at("gap").get<double>();
    const Vec2 point = pair_of(contact.at("point"));
    const Vec2 normal = pair_of(contact.at("normal"));
    bench::Body body;
    std::string name = "object";
    if (result.contains("grasp") && index == 0) {
      const Json& object = result.at("grasp").at("object");
      body.lines = {{pair_of(object.at("center"))}};
      body.radius = object.at("radius").get<double>();
    } else {
      found.that(index < scene.obstacles.size(), "the index of the obstacle is none of the scene's");
      if (index >= scene.obstacles.size()) continue;
      body = bench::body_of(scene.obstacles[index], scene.read_quantity, 1.0);
      name = scene.obstacles[index].name;
    }
    found.that(contact.at("obstacle") == name, "the obstacle of that index is '" + name + "'");
    found.that(s > 0.0 && s <= length * (1.0 + rounding), "the arc length is not on the rod");
    if (contact.at("at_tip").get<bool>()) found.near("arc length at the tip", s, length, rounding * length);
    const Vec2 on_rod = curve.at(s);
    found.near("x of the point on the backbone", point.x, on_rod.x, between_rows * length);
    found.near("y of the point on the backbone", point.y, on_rod.y, between_rows * length);
    Vec2 outward{};
    const double distance = body.distance(point, outward) - body.radius;
    found.near("gap (m)", gap, distance, rounding * std::max(length, std::abs(distance)));
    found.near("x of the normal", normal.x, outward.x, same_normal);
    found.near("y of the normal", normal.y, outward.y, same_normal);
    if (!certified) continue;
    found.that(force >= 0.0, "the force pulls");
    found.near("min(gap, force)", std::min(gap / length, force / force_unit(shown.rod)), 0.0, complementarity);
    const double slope = dot(direction(curve.angle(s)), normal);
    if (force > 0.0 && s < length * (1.0 - rounding)) found.near("tangent . normal", slope, 0.0, closest_point);
  }
}

}  // namespace tendril::results
