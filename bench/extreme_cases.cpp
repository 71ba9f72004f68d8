#include "extreme_cases.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "scenes.hpp"

namespace tendril::bench {

namespace {

constexpr double pi = std::numbers::pi;

std::string gravity_of(double size) { return fmt::format("gravity = [0, {}]\n", -size); }

struct SegmentText {
  double length, stiffness, density, rest_curvature;
};

/// A rod in SI units; most have L = 1 m and EI = 1 N m^2, so that all numbers are dimensionless.
std::string rod(const std::vector<SegmentText>& segments) {
  std::string text = "[rod]\n";
  for (const SegmentText& s : segments) {
    text +=
        fmt::format("[[rod.segment]]\nlength = {}\nbending_stiffness = {}\nlinear_density = {}\nrest_curvature = {}\n",
                    s.length, s.stiffness, s.density, s.rest_curvature);
  }
  return text;
}
std::string unit_rod(double weight = 0.0) { return rod({{1.0, 1.0, weight, 0.0}}); }

std::string actuator(double low, double high, double from = 0.0, double to = 1.0) {
  return fmt::format("[[rod.actuator]]\nfrom = {}\nto = {}\nmin = {}\nmax = {}\n", from, to, low, high);
}
std::string tip_force(double x, double y) { return fmt::format("[tip_load]\nforce = [{}, {}]\n", x, y); }
std::string start(double angle) { return fmt::format("[start]\ntip_angle = {}\n", angle); }
std::string target(double x, double y) { return fmt::format("[target]\nposition = [{}, {}]\n", x, y); }
std::string circle(double x, double y, double radius) {
  return fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [{}, {}]\nradius = {}\n", x, y, radius);
}
std::string wall(double y, double up) {
  return fmt::format("[[obstacle]]\nshape = \"wall\"\npoint = [0, {}]\nangle = {}\n", y, up > 0.0 ? 0.0 : pi);
}
std::string contact(const char* mode, int count = 1) {
  return fmt::format("[contact]\nmode = \"{}\"\ncount = {}\n", mode, count);
}
std::string weighted(double tip, double effort) {
  return fmt::format(
      "[[objective]]\nplugin = \"tip_pose\"\nweight = {}\n[[objective]]\nplugin = \"actuation_effort\"\nweight = {}\n",
      tip, effort);
}

Vec2 arc_tip(double angle) {
  if (angle == 0.0) return {1.0, 0.0};
  return {std::sin(angle) / angle, (1.0 - std::cos(angle)) / angle};
}

/// Two halves with curvatures of their own.
Vec2 two_arcs(double first, double second) {
  const Vec2 a = 0.5 * arc_tip(0.5 * first);
  const Vec2 b = 0.5 * arc_tip(0.5 * second);
  const double c = std::cos(0.5 * first);
  const double s = std::sin(0.5 * first);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y};
}

class List {
 public:
  ExtremeCase& plan(const char* group, std::string name, std::string text, std::string source) {
    all_.push_back({group, std::move(name), std::move(text), false, {}, "solved", std::move(source)});
    return all_.back();
  }
  ExtremeCase& execution(const char* group, std::string name, std::string text, std::vector<double> moments,
                         std::string source) {
    all_.push_back({group, std::move(name), std::move(text), true, std::move(moments), "solved", std::move(source)});
    return all_.back();
  }
  std::vector<ExtremeCase> take() { return std::move(all_); }

 private:
  std::vector<ExtremeCase> all_;
};

/// The braced arm of the exact table, in any units.
std::string braced_arm(double length, double stiffness) {
  const double moment = stiffness / length;
  const double force = moment / length;
  const double weight = 0.084 * 9.81 * 1e-3 / 4.9e-4;
  return gravity_of(1.0) + rod({{length, stiffness, weight * force / length, 0.0}}) +
         actuator(-0.0025 * 0.1 / 4.9e-4 * moment, 0.0025 * 0.1 / 4.9e-4 * moment, 0.0, length) + start(0.5) +
         circle(0.6 * length, 0.0, 0.08 * length) + contact("allow") +
         fmt::format("max_force = {}\n", 1.0 * 0.01 / 4.9e-4 * force) + target(0.97 * length, 0.26 * length) +
         weighted(100.0, 1e-4);
}

const KnownAnswer braced{Vec2{0.9670319442, 0.2200183222}, 0.5862167146, 0.06178404562 * 0.01 / 4.9e-4, 1e-9};

void add_scales(List& list) {
  const char* group = "scale";
  const char* source = "exact table of the braced arm; the same dimensionless plan at every scale";
  const double scales[][2] = {{0.1, 4.9e-4}, {1e-3, 1e-12}, {100.0, 1e-12}, {1.0, 1.0}, {1e-3, 1e6}, {100.0, 1e6}};
  for (const auto& [length, stiffness] : scales) {
    ExtremeCase& c = list.plan(group, fmt::format("braced arm, L = {} m, EI = {} N m^2", length, stiffness),
                               braced_arm(length, stiffness), source);
    c.known = braced;
    c.same_as = "braced arm";
    c.quick = length != 1.0;
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

void both(List& list, const char* group, const std::string& name, const std::string& text, const std::string& source,
          const KnownAnswer& known, bool quick = false, double least = 1.0) {
  ExtremeCase& planned = list.plan(group, name, text + target(0.5, 0.0) + weighted(1.0, 0.0), source);
  planned.known = known;
  planned.quick = quick;
  planned.stiffness_least = least;
  ExtremeCase& executed = list.execution(group, name, text, {}, source);
  executed.known = known;
  executed.quick = quick;
}

void add_softness(List& list) {
  const char* group = "softness";
  both(list, group, "self-weight 0", gravity_of(1.0) + unit_rod(), "straight", {Vec2{1.0, 0.0}, {}, {}, 1e-12});
  both(list, group, "self-weight 1e-6", gravity_of(1.0) + unit_rod(1e-6), "linear beam theory: -w/8",
       {Vec2{1.0, -1e-6 / 8.0}, {}, {}, 1e-12});
  const double exact[][3] = {
      {1.0, 0.9912463953, -0.1234714020}, {5.0, 0.8466571800, -0.4959050446}, {10.0, 0.6563537612, -0.7001997155}};
  for (const auto& [weight, x, y] : exact) {
    both(list, group, fmt::format("self-weight {}", weight), gravity_of(1.0) + unit_rod(weight), "exact table",
         {Vec2{x, y}, {}, {}, 1e-9}, weight == 10.0);
  }
  // Under its own tension the rod turns down within l = w^(-1/2): x = sqrt(2) l, y = -1 + (2 - sqrt(2)) l + O(l^2).
  for (const double weight : {1e2, 1e3, 1e4}) {
    const double layer = 1.0 / std::sqrt(weight);
    both(list, group, fmt::format("self-weight {}", weight), gravity_of(1.0) + unit_rod(weight),
         "boundary layer of width w^(-1/2), to its second order",
         {Vec2{std::sqrt(2.0) * layer, -1.0 + (2.0 - std::sqrt(2.0)) * layer}, {}, {}, 2.0 / weight}, weight == 1e4);
  }
  both(list, group, "tip force 1", unit_rod() + tip_force(0.0, -1.0), "elliptic integrals",
       {Vec2{1.0 - 0.0564332362834, -0.3017207738}, {}, {}, 1e-9});
  both(list, group, "tip force 10", unit_rod() + tip_force(0.0, -10.0), "elliptic integrals",
       {Vec2{1.0 - 0.554995597754, -0.81060902488}, {}, {}, 1e-9});
  // The layer is exact up to exp(-sqrt(alpha)), since the tension does not change along the rod.
  for (const double force : {1e2, 1e3}) {
    const double layer = 1.0 / std::sqrt(force);
    both(list, group, fmt::format("tip force {}", force), unit_rod() + tip_force(0.0, -force),
         "closed form of the long rod, exact to exp(-sqrt(alpha))",
         {Vec2{std::sqrt(2.0) * layer, -1.0 + (2.0 - std::sqrt(2.0)) * layer},
          {},
          {},
          4.0 * std::exp(-std::sqrt(force)) + 1e-9},
         force == 1e3);
  }
  for (const bool soft_first : {true, false}) {
    const double first = soft_first ? 1.0 : 1e6;
    const double second = soft_first ? 1e6 : 1.0;
    const std::string text = rod({{0.5, first, 0.0, 0.0}, {0.5, second, 0.0, 0.0}});
    const std::string name = fmt::format("stiffness jumps by 1e6, {} half soft", soft_first ? "first" : "second");
    ExtremeCase& planned =
        list.plan(group, name, text + actuator(2.0, 2.0) + start(0.5) + target(0.5, 0.5) + weighted(1.0, 1e-6),
                  "two circular arcs");
    planned.known = {two_arcs(2.0 / first, 2.0 / second), {}, {}, 1e-9};
    planned.stiffness_least = std::min(1.0, second / first);
    ExtremeCase& executed = list.execution(group, name, text + actuator(-5.0, 5.0), {2.0}, "two circular arcs");
    executed.known = planned.known;
  }
  both(list, group, "density jumps by 1e6", gravity_of(1.0) + rod({{0.5, 1.0, 1e-10, 0.0}, {0.5, 1.0, 1e-4, 0.0}}),
       "linear beam theory", {Vec2{1.0, -0.1067708333e-4}, {}, {}, 1e-9});
  const double curvature = 7.0 * pi;
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

void add_large_angles(List& list) {
  const char* group = "large angle";
  for (const double turns : {0.5, 2.0, 10.0}) {
    const double angle = 2.0 * pi * turns;
    const std::string name = fmt::format("tip angle of {} turns", turns);
    ExtremeCase& planned = list.plan(
        group, name, unit_rod() + actuator(angle, angle) + start(angle) + target(0.5, 0.5) + weighted(1.0, 1e-6),
        "circular arc");
    planned.known = {arc_tip(angle), {}, {}, 1e-9};
    planned.overlaps = turns >= 1.0;
    planned.quick = turns == 10.0;
    ExtremeCase& executed = list.execution(group, name, unit_rod() + actuator(-100.0, 100.0), {angle}, "circular arc");
    executed.known = planned.known;
    executed.overlaps = planned.overlaps;
    executed.quick = turns == 10.0;
  }
  ExtremeCase& reversed = list.execution(group, "moment reversed from 2 turns to -2 turns",
                                         unit_rod() + actuator(-100.0, 100.0), {-4.0 * pi}, "circular arc");
  reversed.before = {4.0 * pi};
  reversed.known = {arc_tip(-4.0 * pi), {}, {}, 1e-9};
  reversed.overlaps = true;
}

void add_obstacles(List& list) {
  const char* group = "obstacles";
  const char* source = "the fine basis under the same loads, which finds the contacts by itself";
  const auto heavy = [](double weight) { return gravity_of(1.0) + unit_rod(weight); };
  for (const double radius : {1e-6, 1e-4, 1e-2}) {
    ExtremeCase& c = list.plan(group, fmt::format("heavy rod on a circle of radius {} L", radius),
                               heavy(5.0) + circle(0.6, -0.05 - radius, radius) + contact("require") +
                                   "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0),
                               source);
    c.against_execution = true;
    c.quick = radius == 1e-6;
  }
  for (const double radius : {1.0, 1e2, 1e4}) {
    ExtremeCase& c = list.plan(
        group, fmt::format("tip on a circle of radius {} L", radius),
        heavy(1.0) + circle(1.0, -0.05 - radius, radius) + contact("allow") + target(1.0, -0.05) + weighted(1.0, 0.0),
        source);
    c.against_execution = true;
    c.quick = radius == 1e4;
  }
  for (const double radius : {1e-6, 1e4}) {
    const double x = radius < 1.0 ? 0.3 : 0.6;
    ExtremeCase& c = list.plan(group, fmt::format("avoiding a circle of radius {} L", radius),
                               unit_rod() + actuator(-2.0, 2.0) + start(0.2) + circle(x, -0.05 - radius, radius) +
                                   contact("avoid") + target(0.8, -0.5) + weighted(1.0, 1e-6),
                               "certified clearance");
    c.quick = radius == 1e-6;
  }
  ExtremeCase& base = list.plan(group, "circle touches the base",
                                unit_rod() + actuator(0.5, 0.5) + start(0.5) + circle(0.0, -0.1, 0.1) +
                                    contact("allow") + target(0.9, 0.2) + weighted(1.0, 1e-6),
                                "circular arc, which bends away");
  base.known = {arc_tip(0.5), {}, {}, 1e-9};
  ExtremeCase& based =
      list.execution(group, "circle touches the base", unit_rod() + actuator(-5.0, 5.0) + circle(0.0, -0.1, 0.1), {0.5},
                     "circular arc, which bends away");
  based.known = base.known;
  ExtremeCase& rest = list.plan(group, "circle touches the rest shape",
                                unit_rod() + actuator(0.0, 0.0) + circle(0.6, -0.1, 0.1) + contact("allow") +
                                    target(1.0, 0.0) + weighted(1.0, 1e-6),
                                "straight, force exactly 0");
  rest.known = {Vec2{1.0, 0.0}, {}, 0.0, 1e-9};
  rest.quick = true;
  ExtremeCase& rested =
      list.execution(group, "circle touches the rest shape", unit_rod() + actuator(-5.0, 5.0) + circle(0.6, -0.1, 0.1),
                     {0.0}, "straight, force exactly 0");
  rested.known = rest.known;
  (void)list.execution(group, "two circles overlap", heavy(5.0) + circle(0.57, -0.12, 0.07) + circle(0.63, -0.12, 0.07),
                       {}, "certificate of the fine basis");
  ExtremeCase& overlapped =
      list.plan(group, "two circles overlap",
                heavy(5.0) + circle(0.57, -0.12, 0.07) + circle(0.63, -0.12, 0.07) + contact("require", 2) +
                    "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0),
                source);
  overlapped.against_execution = true;
  (void)list.execution(group, "start inside a circle", unit_rod() + actuator(-5.0, 5.0) + circle(0.6, 0.05, 0.08),
                       {0.0}, "certificate of the fine basis");
  ExtremeCase& centre =
      list.execution(group, "start through a circle's centre",
                     unit_rod() + actuator(-5.0, 5.0) + circle(0.6, 0.0, 0.08), {0.0}, "neither side is meant");
  centre.verdict = "refused";
  const std::string gap = wall(-5e-4, 1.0) + wall(5e-4, -1.0);
  ExtremeCase& enclosed =
      list.plan(group, "gap of 1e-3 L, avoiding its walls",
                unit_rod() + actuator(-5.0, 5.0) + gap + contact("avoid") + target(0.9, 0.3) + weighted(1.0, 1e-6),
                "certified clearance");
  enclosed.quick = true;
  ExtremeCase& pressed =
      list.execution(group, "gap of 1e-3 L, moment 1", unit_rod() + actuator(-5.0, 5.0) + gap, {1.0},
                     "linear beam theory: the tip on one wall, a point 0.0772 L before it on the other");
  pressed.known = {std::nullopt, std::nullopt, 12.90973, 1e-3};
  ExtremeCase& into_tip = list.plan(
      group, "contact slides into the tip",
      heavy(2.0) + circle(0.985, -0.1, 0.03) + contact("allow") + target(1.0, -0.1) + weighted(1.0, 0.0), source);
  into_tip.against_execution = true;
  // Both halves bend alike: the contact passes the actuators' common end while the loads grow, or stops beside it.
  for (const double x : {0.49, 0.495, 0.4975, 0.5}) {
    (void)list.execution(
        group, fmt::format("contact at an actuator's end, circle at {} L", x),
        heavy(5.0) + actuator(-5.0, 5.0, 0.0, 0.5) + actuator(-5.0, 5.0, 0.5, 1.0) + circle(x, -0.06, 0.02), {0.0, 0.0},
        "certificate of the fine basis");
  }
  (void)list.execution(group, "contact slides into the base", heavy(5.0) + circle(0.02, -0.0201, 0.02), {},
                       "certificate of the fine basis");
}

void add_contacts(List& list) {
  const char* group = "contact";
  const std::string first = unit_rod() + actuator(-10.0, 10.0) + circle(0.6, 0.3, 0.15);
  const double table[][5] = {{1.0, 0.655901506, 0.708646714, 0.901317076, 0.357903200},
                             {3.0, 5.363198514, 0.790855638, 0.779270480, 0.416794223}};
  for (const auto& [moment, force, place, x, y] : table) {
    const KnownAnswer known{Vec2{x, y}, place, force, 2e-9};
    ExtremeCase& executed =
        list.execution(group, fmt::format("first reference circle, moment {}", moment), first, {moment}, "exact table");
    executed.known = known;
    ExtremeCase& planned = list.plan(group, fmt::format("first reference circle, moment {}", moment),
                                     unit_rod() + actuator(moment, moment) + circle(0.6, 0.3, 0.15) + contact("allow") +
                                         start(0.5) + target(0.8, 0.4) + weighted(1.0, 1e-6),
                                     "exact table");
    planned.known = known;
  }
  ExtremeCase& wrapped = list.execution(group, "first reference circle, moment 7", first, {7.0},
                                        "above 6.667 no single point holds the rod");
  wrapped.spread = true;
  wrapped.quick = true;
  ExtremeCase& forced = list.plan(group, "first reference circle, moment 7, one contact",
                                  unit_rod() + actuator(7.0, 7.0) + circle(0.6, 0.3, 0.15) + contact("require") +
                                      "min_force = 1\n" + start(0.5) + target(0.8, 0.4) + weighted(1.0, 1e-6),
                                  "above 6.667 no single point holds the rod");
  forced.spread = true;
  ExtremeCase& lying =
      list.execution(group, "heavy rod on a wall", gravity_of(1.0) + unit_rod(100.0) + wall(-1e-3, 1.0), {},
                     "beam theory: it touches down at (72 h / w)^(1/4) = 0.164 L");
  lying.verdict = "extended";
  ExtremeCase& flat =
      list.execution(group, "heavy rod on a circle of radius 1e4 L",
                     gravity_of(1.0) + unit_rod(100.0) + circle(0.5, -1e-3 - 1e4, 1e4), {}, "as on a wall");
  flat.verdict = "extended";
  const Vec2 half = 0.5 * arc_tip(0.5);
  const double turn = 0.5;
  const Vec2 below{half.x + 0.1 * std::sin(turn), half.y - 0.1 * std::cos(turn)};
  const KnownAnswer grazed{arc_tip(1.0), {}, 0.0, 1e-9};
  ExtremeCase& grazing = list.plan(group, "circle grazed, force exactly 0",
                                   unit_rod() + actuator(1.0, 1.0) + start(1.0) + circle(below.x, below.y, 0.1) +
                                       contact("allow") + target(0.8, 0.4) + weighted(1.0, 1e-6),
                                   "circular arc");
  grazing.known = grazed;
  grazing.quick = true;
  ExtremeCase& graze = list.execution(group, "circle grazed, force exactly 0",
                                      unit_rod() + actuator(-5.0, 5.0) + start(1.0) + circle(below.x, below.y, 0.1),
                                      {1.0}, "circular arc");
  graze.known = grazed;
  // The rod itself carries 3 y EI / L^3 of the force.
  const KnownAnswer strong{Vec2{1.0, -1e-4}, 1.0, 1e4 - 3e-4, 1e-7};
  const std::string press = unit_rod() + tip_force(0.0, -1e4) + wall(-1e-4, 1.0);
  ExtremeCase& pressed = list.execution(group, "force of 1e4 at the tip", press, {}, "linear beam theory");
  pressed.known = strong;
  ExtremeCase& planned =
      list.plan(group, "force of 1e4 at the tip", press + contact("allow") + target(1.0, 0.0) + weighted(1.0, 0.0),
                "linear beam theory");
  planned.known = strong;
  planned.quick = true;
  ExtremeCase& lost =
      list.execution(group, "contact lost on the way", unit_rod() + actuator(-5.0, 5.0) + circle(0.6, -0.15, 0.14),
                     {1.0}, "circular arc");
  lost.before = {-1.0};
  lost.known = {arc_tip(1.0), {}, {}, 1e-9};
  for (const double apart : {1e-2, 1e-3, 1e-4}) {
    (void)list.execution(group, fmt::format("two circles {} L apart", apart),
                         gravity_of(1.0) + unit_rod(5.0) + circle(0.6, -0.07, 0.02) + circle(0.6 + apart, -0.07, 0.02),
                         {}, "certificate of the fine basis");
  }
}

void add_programs(List& list) {
  const char* group = "programs";
  const std::string heavy = gravity_of(1.0) + unit_rod(1.0);
  ExtremeCase& none = list.plan(group, "torque limit 0",
                                heavy + actuator(0.0, 0.0) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  none.known = {Vec2{0.9912463953, -0.1234714020}, {}, {}, 1e-9};
  none.quick = true;
  ExtremeCase& equal = list.plan(group, "equal bounds",
                                 heavy + actuator(1.0, 1.0) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  equal.known = {Vec2{0.898317039, 0.363091933}, {}, {}, 1e-9};
  ExtremeCase& contradictory =
      list.plan(group, "contradictory bounds", heavy + actuator(1.0, -1.0) + target(0.9, 0.3) + weighted(1.0, 1e-6),
                "no such moment");
  contradictory.verdict = "refused";
  contradictory.quick = true;
  const std::string reach = heavy + actuator(-2.0, 2.0) + target(0.9, 0.3);
  for (const double weight : {1.0, 1e-12, 1e-6, 1e6, 1e12}) {
    ExtremeCase& c = list.plan(group, fmt::format("all weights times {}", weight),
                               reach + weighted(weight, 1e-3 * weight), "only ratios of weights matter");
    c.same_as = "weights";
    c.quick = weight == 1.0 || weight == 1e-12 || weight == 1e12;
  }
  (void)list.plan(group, "weights 1e12 and 1e-12", reach + weighted(1e12, 1e-12), "certificate");
  (void)list.plan(group, "weights 1e-12 and 1e12", reach + weighted(1e-12, 1e12), "certificate");
  ExtremeCase& far =
      list.plan(group, "target 1e3 L away",
                unit_rod() + actuator(-2.0, 2.0) + start(0.5) + target(1000.0, 0.0) + weighted(1.0, 0.0), "straight");
  far.known = {Vec2{1.0, 0.0}, {}, {}, 1e-6};
  far.quick = true;
  (void)list.plan(group, "all weights 0", reach + weighted(0.0, 0.0), "certificate");
  ExtremeCase& twice = list.plan(group, "duplicate terms", reach + weighted(0.5, 0.5e-3) + weighted(0.5, 0.5e-3),
                                 "one term of twice the weight");
  twice.same_as = "weights";
}

}  // namespace

std::vector<ExtremeCase> extreme_cases() {
  List list;
  add_scales(list);
  add_softness(list);
  add_large_angles(list);
  add_obstacles(list);
  add_contacts(list);
  add_programs(list);
  return list.take();
}

}  // namespace tendril::bench
