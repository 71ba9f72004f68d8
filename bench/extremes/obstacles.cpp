// Obstacles of every size, place and shape.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/scene_text.hpp"
#include "extremes/groups.hpp"

namespace tendril::bench {

namespace {

using namespace scene_text;

/// How far below its clamp a rod is at most under a moment and its weight, by linear beam theory.
double deepest_sag(double moment, double weight) {
  double deepest = 0.0;
  for (int i = 1; i <= 1000; ++i) {
    const double x = 1e-3 * i;
    deepest = std::max(deepest, x * x * (weight * (6.0 - 4.0 * x + x * x) / 24.0 - 0.5 * moment));
  }
  return deepest;
}

constexpr const char* obstacles = "obstacles";
constexpr const char* by_execution = "the fine basis under the same loads, which finds the contacts by itself";

std::string heavy(double weight) { return gravity_of(1.0) + unit_rod(weight); }

/// Circles from far smaller to far larger than the rod.
void add_sizes(CaseList& list) {
  CaseNumbers& number = list.number;
  for (const double table_radius : {1e-6, 1e-4, 1e-2}) {
    const double radius = number(table_radius);
    ExtremeCase& c = list.plan(obstacles, fmt::format("heavy rod on a circle of radius {} L", radius),
                               heavy(number(5.0)) + circle(number(0.6), -0.05 - radius, radius) + contact("require") +
                                   "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0),
                               by_execution);
    c.against_execution = true;
    c.contacts = 1;
    c.quick = table_radius == 1e-6;
  }
  for (const double table_radius : {1.0, 1e2, 1e4}) {
    const double radius = number(table_radius);
    ExtremeCase& c = list.plan(obstacles, fmt::format("tip on a circle of radius {} L", radius),
                               heavy(number(1.0)) + circle(1.0, -0.05 - radius, radius) + contact("allow") +
                                   target(1.0, -0.05) + weighted(1.0, 0.0),
                               by_execution);
    c.against_execution = true;
    c.contacts = 1;
    c.quick = table_radius == 1e4;
  }
  for (const double table_radius : {1e-6, 1e4}) {
    const double radius = number(table_radius);
    const double x = number(table_radius < 1.0 ? 0.3 : 0.6);
    ExtremeCase& c = list.plan(obstacles, fmt::format("avoiding a circle of radius {} L", radius),
                               unit_rod() + actuator(-2.0, 2.0) + start(0.2) + circle(x, -0.05 - radius, radius) +
                                   contact("avoid") + target(0.8, -0.5) + weighted(1.0, 1e-6),
                               "certified clearance");
    c.quick = table_radius == 1e-6;
  }
}

/// Obstacles that touch the rod, each other, or hold the start inside.
void add_touching(CaseList& list) {
  CaseNumbers& number = list.number;
  const double bend = number(0.5);
  const double beside = number(0.1);
  ExtremeCase& base = list.plan(obstacles, "circle touches the base",
                                unit_rod() + actuator(bend, bend) + start(0.5) + circle(0.0, -beside, beside) +
                                    contact("allow") + target(0.9, 0.2) + weighted(1.0, 1e-6),
                                "circular arc, which bends away");
  base.known = {arc_tip(bend), {}, {}, 1e-9};
  ExtremeCase& based = list.execution(obstacles, "circle touches the base",
                                      unit_rod() + actuator(-5.0, 5.0) + circle(0.0, -beside, beside), {bend},
                                      "circular arc, which bends away");
  based.known = base.known;
  const std::string touching = circle(number(0.6), -beside, beside);
  ExtremeCase& rest =
      list.plan(obstacles, "circle touches the rest shape",
                unit_rod() + actuator(0.0, 0.0) + touching + contact("allow") + target(1.0, 0.0) + weighted(1.0, 1e-6),
                "straight, force exactly 0");
  rest.known = {Vec2{1.0, 0.0}, {}, 0.0, 1e-9};
  rest.quick = true;
  ExtremeCase& rested = list.execution(obstacles, "circle touches the rest shape",
                                       unit_rod() + actuator(-5.0, 5.0) + touching, {0.0}, "straight, force exactly 0");
  rested.known = rest.known;
  const std::string overlapping =
      heavy(number(5.0)) + circle(0.57, -0.12, number(0.07)) + circle(0.63, -0.12, number(0.07));
  (void)list.execution(obstacles, "two circles overlap", overlapping, {}, "boundary-value problem");
  ExtremeCase& overlapped = list.plan(
      obstacles, "two circles overlap",
      overlapping + contact("require", 2) + "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0), by_execution);
  overlapped.against_execution = true;
  (void)list.execution(obstacles, "start inside a circle",
                       unit_rod() + actuator(-5.0, 5.0) + circle(number(0.6), number(0.05), 0.08), {0.0},
                       "boundary-value problem");
  ExtremeCase& centre =
      list.execution(obstacles, "start through a circle's centre",
                     unit_rod() + actuator(-5.0, 5.0) + circle(number(0.6), 0.0, 0.08), {0.0}, "neither side is meant");
  centre.verdict = "refused";
}

/// Between two walls.
void add_gaps(CaseList& list) {
  CaseNumbers& number = list.number;
  const double half = number(5e-4);
  const std::string gap = wall(-half, 1.0) + wall(half, -1.0);
  ExtremeCase& enclosed =
      list.plan(obstacles, "gap of 1e-3 L, avoiding its walls",
                unit_rod() + actuator(-5.0, 5.0) + gap + contact("avoid") + target(0.9, 0.3) + weighted(1.0, 1e-6),
                "certified clearance");
  enclosed.quick = true;
  // Linear beam theory: the moment M_c at the inner contact bends the part from the base there, the rest bends from one
  // wall to the other. The slopes stay below 0.04, and their squares are left out.
  const double bent = number(1.0);
  double at_contact = 0.0;
  double beyond = 0.0;
  for (int i = 0; i < 60; ++i) {
    beyond = std::sqrt(12.0 * half / (bent + 2.0 * at_contact));
    at_contact = 6.0 * half / ((1.0 - beyond) * (1.0 - beyond));
  }
  ExtremeCase& pressed = list.execution(
      obstacles, "gap of 1e-3 L, with a moment", unit_rod() + actuator(-5.0, 5.0) + gap, {bent},
      fmt::format("linear beam theory: the tip on one wall, a point {:.4g} L before it on the other", beyond));
  pressed.known = {std::nullopt, 1.0, (bent - at_contact) / beyond, 2e-3};
  pressed.contacts = 2;
  ExtremeCase& pressed_plan =
      list.plan(obstacles, "gap of 1e-3 L, with a moment",
                unit_rod() + actuator(bent, bent) + gap + contact("allow", 2) + target(0.9, 0.3) + weighted(1.0, 1e-6),
                pressed.source);
  pressed_plan.known = pressed.known;
  pressed_plan.contacts = 2;
  pressed_plan.against_execution = true;
}

/// Contacts that slide into an end of the rod or of an actuator.
void add_sliding(CaseList& list) {
  CaseNumbers& number = list.number;
  ExtremeCase& into_tip = list.plan(obstacles, "contact slides into the tip",
                                    heavy(number(2.0)) + circle(0.985, number(-0.1), 0.03) + contact("allow") +
                                        target(1.0, -0.1) + weighted(1.0, 0.0),
                                    by_execution);
  into_tip.against_execution = true;
  // Both halves bend alike: the contact passes the actuators' common end while the loads grow, or stops beside it.
  for (const double table_x : {0.49, 0.495, 0.4975, 0.5}) {
    const double x = 0.5 - number(0.5 - table_x);
    (void)list.execution(
        obstacles, fmt::format("contact at an actuator's end, circle at {} L", x),
        heavy(number(5.0)) + actuator(-5.0, 5.0, 0.0, 0.5) + actuator(-5.0, 5.0, 0.5, 1.0) + circle(x, -0.06, 0.02),
        {0.0, 0.0}, "boundary-value problem");
  }
  (void)list.execution(obstacles, "contact slides into the base", heavy(number(5.0)) + circle(0.02, -0.0201, 0.02), {},
                       "boundary-value problem");
}

}  // namespace

void add_obstacles(CaseList& list) {
  add_sizes(list);
  add_touching(list);
  add_gaps(list);
  add_sliding(list);
}

/// The same contact on every shape, split and not.
void add_shapes(CaseList& list) {
  const char* group = "shapes";
  CaseNumbers& number = list.number;
  const double radius = number(0.08);
  const auto both_ways = [&](const std::string& name, const std::string& text, const std::string& source,
                             const KnownAnswer& known, bool quick) {
    for (const bool split : {true, false}) {
      ExtremeCase& c = list.plan(group, name + (split ? "" : ", not split"), text, source);
      c.known = known;
      c.split = split;
      c.contacts = 1;
      c.quick = quick && !split;
    }
  };
  // An end of the capsule and a corner of the polygon are the circle of the exact table.
  const std::string polygon = fmt::format(
      "[[obstacle]]\nshape = \"polygon\"\nvertices = [[0.6, 0], [0.5, -0.3], [0.7, -0.3]]\nrounding = {}\n", radius);
  const std::string aim = target(0.97, 0.26);
  const KnownAnswer known = number.table(braced);
  both_ways("braced on a circle", arm_over(circle(0.6, 0.0, radius), 1.0, 1.0) + aim, "exact table", known, true);
  both_ways("braced on a capsule's end", arm_over(capsule({0.6, 0.0}, {0.6, -0.3}, radius), 1.0, 1.0) + aim,
            "exact table", known, false);
  both_ways("braced on a polygon's corner", arm_over(polygon, 1.0, 1.0) + aim, "exact table", known, false);
  const double moment = number(1.5);
  const double weight = number(5.0);
  // As deep below the clamp, against where the free rod sags to, for all numbers.
  const double top = -0.02 * deepest_sag(moment, weight) / deepest_sag(1.5, 5.0);
  const std::string sagging = gravity_of(1.0) + unit_rod(weight) + actuator(moment, moment) + start(0.2) +
                              contact("require") + "min_force = 0.01\n" + target(1.0, 0.1) + weighted(1.0, 1e-6);
  both_ways("on a wall", sagging + wall(top, 1.0), "boundary-value problem", {}, false);
  both_ways("on a capsule's side", sagging + capsule({0.3, top - 0.1}, {0.8, top - 0.1}, 0.1), "boundary-value problem",
            {}, false);
  both_ways("on a polygon's side",
            sagging + fmt::format("[[obstacle]]\nshape = \"polygon\"\nvertices = [[0.2, {0}], [0.2, -0.3], [0.9, "
                                  "-0.3], [0.9, {0}]]\nrounding = 0.05\n",
                                  top - 0.05),
            "boundary-value problem", {}, false);
}

}  // namespace tendril::bench
