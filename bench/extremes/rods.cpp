// Rods without obstacles, and one arm at every scale: units, softness, large angles.

#include <fmt/format.h>

#include <cmath>

#include "common/scene_text.hpp"
#include "extremes/groups.hpp"

namespace tendril::bench {

namespace {

using namespace scene_text;

/// Two halves with curvatures of their own.
Vec2 two_arcs(double first, double second) {
  const Vec2 a = 0.5 * arc_tip(0.5 * first);
  const Vec2 b = 0.5 * arc_tip(0.5 * second);
  const double c = std::cos(0.5 * first);
  const double s = std::sin(0.5 * first);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y};
}

/// The braced arm of the exact table, in any units.
std::string braced_arm(double length, double stiffness) {
  return arm_over(circle(0.6 * length, 0.0, 0.08 * length), length, stiffness) + target(0.97 * length, 0.26 * length);
}

void both(CaseList& list, const char* group, const std::string& name, const std::string& text,
          const std::string& source, const KnownAnswer& known, bool quick = false) {
  // Heavy rods have several stable equilibria: the one that is asked for is the one that the source knows.
  const Vec2 there = known.tip.value_or(Vec2{0.5, 0.0});
  ExtremeCase& planned = list.plan(group, name, text + target(there.x, there.y) + weighted(1.0, 0.0), source);
  planned.known = known;
  planned.quick = quick;
  ExtremeCase& executed = list.execution(group, name, text, {}, source);
  executed.known = known;
  executed.quick = quick;
}

}  // namespace

void add_scales(CaseList& list) {
  const char* group = "scale";
  const char* source = "exact table of the braced arm; the same dimensionless plan at every scale";
  const double scales[][2] = {{0.1, 4.9e-4}, {1e-3, 1e-12}, {100.0, 1e-12}, {1.0, 1.0}, {1e-3, 1e6}, {100.0, 1e6}};
  for (const auto& [table_length, table_stiffness] : scales) {
    const double length = list.number(table_length);
    const double stiffness = list.number(table_stiffness);
    ExtremeCase& c = list.plan(group, fmt::format("braced arm, L = {} m, EI = {} N m^2", length, stiffness),
                               braced_arm(length, stiffness), source);
    c.known = braced;
    c.same_as = "braced arm";
    c.quick = table_length != 1.0;
  }
  constexpr double inch = 0.0254;
  constexpr double pound = 0.45359237;
  constexpr double pound_force = pound * 9.80665;
  std::string text = fmt::format(
      "gravity = [\"0 m/s^2\", \"{} inch/s^2\"]\n[rod]\nlength = \"{} inch\"\nbending_stiffness = \"{} lbf inch^2\"\n"
      "linear_density = \"{} lb/inch\"\n[[rod.actuator]]\nlimit = \"{} lbf inch\"\n",
      -9.81 / inch, 0.1 / inch, 4.9e-4 / (pound_force * inch * inch), 0.084 / pound * inch,
      0.0025 / (pound_force * inch));
  text += start(0.5) +
          fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [\"{} inch\", \"0 inch\"]\nradius = \"{} inch\"\n",
                      0.06 / inch, 0.008 / inch) +
          contact("allow") + fmt::format("max_force = \"{} lbf\"\n", 1.0 / pound_force) +
          fmt::format("[target]\nposition = [\"{} inch\", \"{} inch\"]\n", 0.097 / inch, 0.026 / inch) +
          weighted(100.0, 1e-4);
  ExtremeCase& c = list.plan(group, "braced arm in inches and pounds", text, source);
  c.known = braced;
  c.same_as = "braced arm";
}

void add_softness(CaseList& list) {
  const char* group = "softness";
  both(list, group, "self-weight 0", gravity_of(1.0) + unit_rod(), "straight", {Vec2{1.0, 0.0}, {}, {}, 1e-12});
  const double light = list.number(1e-6);
  both(list, group, fmt::format("self-weight {}", light), gravity_of(1.0) + unit_rod(light), "linear beam theory: -w/8",
       {Vec2{1.0, -light / 8.0}, {}, {}, 1e-12});
  const double exact[][3] = {
      {1.0, 0.9912463953, -0.1234714020}, {5.0, 0.8466571800, -0.4959050446}, {10.0, 0.6563537612, -0.7001997155}};
  for (const auto& [table_weight, x, y] : exact) {
    const double weight = list.number(table_weight);
    both(list, group, fmt::format("self-weight {}", weight), gravity_of(1.0) + unit_rod(weight), "exact table",
         list.number.table({Vec2{x, y}, {}, {}, 1e-9}), table_weight == 10.0);
  }
  // Under its own tension the rod turns down within l = w^(-1/2): x = sqrt(2) l, y = -1 + (2 - sqrt(2)) l + O(l^2).
  for (const double table_weight : {1e2, 1e3, 1e4}) {
    const double weight = list.number(table_weight);
    const double layer = 1.0 / std::sqrt(weight);
    both(list, group, fmt::format("self-weight {}", weight), gravity_of(1.0) + unit_rod(weight),
         "boundary layer of width w^(-1/2), to its second order",
         {Vec2{std::sqrt(2.0) * layer, -1.0 + (2.0 - std::sqrt(2.0)) * layer}, {}, {}, 2.0 / weight},
         table_weight == 1e4);
  }
  const double forces[][3] = {{1.0, 0.0564332362834, 0.3017207738}, {10.0, 0.554995597754, 0.81060902488}};
  for (const auto& [table_force, shortening, drop] : forces) {
    const double force = list.number(table_force);
    both(list, group, fmt::format("tip force {}", force), unit_rod() + tip_force(0.0, -force), "elliptic integrals",
         list.number.table({Vec2{1.0 - shortening, -drop}, {}, {}, 1e-9}));
  }
  // The layer is exact up to exp(-sqrt(alpha)), since the tension does not change along the rod.
  for (const double table_force : {1e2, 1e3}) {
    const double force = list.number(table_force);
    const double layer = 1.0 / std::sqrt(force);
    both(list, group, fmt::format("tip force {}", force), unit_rod() + tip_force(0.0, -force),
         "closed form of the long rod, exact to exp(-sqrt(alpha))",
         {Vec2{std::sqrt(2.0) * layer, -1.0 + (2.0 - std::sqrt(2.0)) * layer},
          {},
          {},
          4.0 * std::exp(-std::sqrt(force)) + 1e-9},
         table_force == 1e3);
  }
  for (const bool soft_first : {true, false}) {
    const double first = soft_first ? 1.0 : 1e6;
    const double second = soft_first ? 1e6 : 1.0;
    const double moment = list.number(2.0);
    const std::string text = rod({{0.5, first, 0.0, 0.0}, {0.5, second, 0.0, 0.0}});
    const std::string name = fmt::format("stiffness jumps by 1e6, {} half soft", soft_first ? "first" : "second");
    ExtremeCase& planned =
        list.plan(group, name, text + actuator(moment, moment) + start(0.5) + target(0.5, 0.5) + weighted(1.0, 1e-6),
                  "two circular arcs");
    // Moments are in units of the first half's stiffness, and so are the curvatures.
    planned.known = {two_arcs(moment / first, moment / second), {}, {}, 1e-9};
    ExtremeCase& executed = list.execution(group, name, text + actuator(-5.0, 5.0), {moment}, "two circular arcs");
    executed.known = planned.known;
  }
  both(list, group, "density jumps by 1e6", gravity_of(1.0) + rod({{0.5, 1.0, 1e-10, 0.0}, {0.5, 1.0, 1e-4, 0.0}}),
       "linear beam theory", {Vec2{1.0, -0.1067708333e-4}, {}, {}, 1e-9});
  const double curvature = list.number(7.0 * pi);
  ExtremeCase& coiled = list.plan(
      group, "rest curvature of 3.5 turns",
      rod({{1.0, 1.0, 0.0, curvature}}) + start(curvature) + target(0.5, 0.0) + weighted(1.0, 0.0), "circular arc");
  coiled.known = {arc_tip(curvature), {}, {}, 1e-9};
  coiled.overlaps = true;
  ExtremeCase& executed =
      list.execution(group, "rest curvature of 3.5 turns", rod({{1.0, 1.0, 0.0, curvature}}), {}, "circular arc");
  executed.known = coiled.known;
  executed.overlaps = true;
  executed.quick = true;
}

void add_large_angles(CaseList& list) {
  const char* group = "large angle";
  for (const double table_turns : {0.5, 2.0, 10.0}) {
    const double turns = list.number(table_turns);
    const double angle = 2.0 * pi * turns;
    const std::string name = fmt::format("tip angle of {} turns", turns);
    ExtremeCase& planned = list.plan(
        group, name, unit_rod() + actuator(angle, angle) + start(angle) + target(0.5, 0.5) + weighted(1.0, 1e-6),
        "circular arc");
    planned.known = {arc_tip(angle), {}, {}, 1e-9};
    planned.overlaps = turns >= 1.0;
    planned.quick = table_turns == 10.0;
    ExtremeCase& executed = list.execution(group, name, unit_rod() + actuator(-100.0, 100.0), {angle}, "circular arc");
    executed.known = planned.known;
    executed.overlaps = planned.overlaps;
    executed.quick = table_turns == 10.0;
  }
  const double coil = list.number(4.0 * pi);
  ExtremeCase& reversed = list.execution(group, "moment reversed from 2 turns to -2 turns",
                                         unit_rod() + actuator(-100.0, 100.0), {-coil}, "circular arc");
  reversed.before = {coil};
  reversed.known = {arc_tip(-coil), {}, {}, 1e-9};
  reversed.overlaps = true;
}

}  // namespace tendril::bench
