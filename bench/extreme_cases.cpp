#include "extreme_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes.hpp"
#include "workload.hpp"

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

/// The numbers of the cases: those of the table, or held-out ones, each up to a tenth larger or smaller.
class Numbers {
 public:
  explicit Numbers(std::uint64_t held_out) : held_out_(held_out), uniform_(held_out) {}
  double operator()(double value) { return held_out_ == 0 ? value : value * uniform_(0.9, 1.1); }
  /// What is known only for the numbers of the table.
  KnownAnswer table(const KnownAnswer& known) const { return held_out_ == 0 ? known : KnownAnswer{}; }

 private:
  std::uint64_t held_out_;
  Uniform uniform_;
};

class List {
 public:
  explicit List(std::uint64_t held_out) : number(held_out) {}
  Numbers number;
  ExtremeCase& plan(const char* group, std::string name, std::string text, std::string source) {
    all_.push_back({group, std::move(name), std::move(text), {}, "solved", std::move(source)});
    return all_.back();
  }
  ExtremeCase& execution(const char* group, std::string name, std::string text, std::vector<double> moments,
                         std::string source) {
    all_.push_back({group, std::move(name), std::move(text), std::move(moments), "solved", std::move(source)});
    all_.back().executed = true;
    return all_.back();
  }
  std::vector<ExtremeCase> take() { return std::move(all_); }

 private:
  std::vector<ExtremeCase> all_;
};

/// An arm over a peg in any units, and what it is to reach.
std::string arm_over(const std::string& peg, double length, double stiffness, double limit = 0.0025) {
  const double moment = stiffness / length;
  const double force = moment / length;
  const double weight = 0.084 * 9.81 * 1e-3 / 4.9e-4;
  const double most = limit * 0.1 / 4.9e-4 * moment;
  return gravity_of(1.0) + rod({{length, stiffness, weight * force / length, 0.0}}) +
         actuator(-most, most, 0.0, length) + start(0.5) + peg + contact("allow") +
         fmt::format("max_force = {}\n", 1.0 * 0.01 / 4.9e-4 * force) + weighted(100.0, 1e-4);
}

/// The braced arm of the exact table, in any units.
std::string braced_arm(double length, double stiffness) {
  return arm_over(circle(0.6 * length, 0.0, 0.08 * length), length, stiffness) + target(0.97 * length, 0.26 * length);
}

const KnownAnswer braced{Vec2{0.9670319442, 0.2200183222}, 0.5862167146, 0.06178404562 * 0.01 / 4.9e-4, 1e-9};

void add_scales(List& list) {
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

void both(List& list, const char* group, const std::string& name, const std::string& text, const std::string& source,
          const KnownAnswer& known, bool quick = false) {
  ExtremeCase& planned = list.plan(group, name, text + target(0.5, 0.0) + weighted(1.0, 0.0), source);
  planned.known = known;
  planned.quick = quick;
  ExtremeCase& executed = list.execution(group, name, text, {}, source);
  executed.known = known;
  executed.quick = quick;
}

void add_softness(List& list) {
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

void add_large_angles(List& list) {
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

void add_obstacles(List& list) {
  const char* group = "obstacles";
  const char* source = "the fine basis under the same loads, which finds the contacts by itself";
  Numbers& number = list.number;
  const auto heavy = [](double weight) { return gravity_of(1.0) + unit_rod(weight); };
  for (const double table_radius : {1e-6, 1e-4, 1e-2}) {
    const double radius = number(table_radius);
    ExtremeCase& c = list.plan(group, fmt::format("heavy rod on a circle of radius {} L", radius),
                               heavy(number(5.0)) + circle(number(0.6), -0.05 - radius, radius) + contact("require") +
                                   "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0),
                               source);
    c.against_execution = true;
    c.contacts = 1;
    c.quick = table_radius == 1e-6;
  }
  for (const double table_radius : {1.0, 1e2, 1e4}) {
    const double radius = number(table_radius);
    ExtremeCase& c = list.plan(group, fmt::format("tip on a circle of radius {} L", radius),
                               heavy(number(1.0)) + circle(1.0, -0.05 - radius, radius) + contact("allow") +
                                   target(1.0, -0.05) + weighted(1.0, 0.0),
                               source);
    c.against_execution = true;
    c.contacts = 1;
    c.quick = table_radius == 1e4;
  }
  for (const double table_radius : {1e-6, 1e4}) {
    const double radius = number(table_radius);
    const double x = number(table_radius < 1.0 ? 0.3 : 0.6);
    ExtremeCase& c = list.plan(group, fmt::format("avoiding a circle of radius {} L", radius),
                               unit_rod() + actuator(-2.0, 2.0) + start(0.2) + circle(x, -0.05 - radius, radius) +
                                   contact("avoid") + target(0.8, -0.5) + weighted(1.0, 1e-6),
                               "certified clearance");
    c.quick = table_radius == 1e-6;
  }
  const double bend = number(0.5);
  const double beside = number(0.1);
  ExtremeCase& base = list.plan(group, "circle touches the base",
                                unit_rod() + actuator(bend, bend) + start(0.5) + circle(0.0, -beside, beside) +
                                    contact("allow") + target(0.9, 0.2) + weighted(1.0, 1e-6),
                                "circular arc, which bends away");
  base.known = {arc_tip(bend), {}, {}, 1e-9};
  ExtremeCase& based =
      list.execution(group, "circle touches the base", unit_rod() + actuator(-5.0, 5.0) + circle(0.0, -beside, beside),
                     {bend}, "circular arc, which bends away");
  based.known = base.known;
  const std::string touching = circle(number(0.6), -beside, beside);
  ExtremeCase& rest =
      list.plan(group, "circle touches the rest shape",
                unit_rod() + actuator(0.0, 0.0) + touching + contact("allow") + target(1.0, 0.0) + weighted(1.0, 1e-6),
                "straight, force exactly 0");
  rest.known = {Vec2{1.0, 0.0}, {}, 0.0, 1e-9};
  rest.quick = true;
  ExtremeCase& rested = list.execution(group, "circle touches the rest shape",
                                       unit_rod() + actuator(-5.0, 5.0) + touching, {0.0}, "straight, force exactly 0");
  rested.known = rest.known;
  const std::string overlapping =
      heavy(number(5.0)) + circle(0.57, -0.12, number(0.07)) + circle(0.63, -0.12, number(0.07));
  (void)list.execution(group, "two circles overlap", overlapping, {}, "boundary-value problem");
  ExtremeCase& overlapped = list.plan(
      group, "two circles overlap",
      overlapping + contact("require", 2) + "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0), source);
  overlapped.against_execution = true;
  (void)list.execution(group, "start inside a circle",
                       unit_rod() + actuator(-5.0, 5.0) + circle(number(0.6), number(0.05), 0.08), {0.0},
                       "boundary-value problem");
  ExtremeCase& centre =
      list.execution(group, "start through a circle's centre",
                     unit_rod() + actuator(-5.0, 5.0) + circle(number(0.6), 0.0, 0.08), {0.0}, "neither side is meant");
  centre.verdict = "refused";
  const double half = number(5e-4);
  const std::string gap = wall(-half, 1.0) + wall(half, -1.0);
  ExtremeCase& enclosed =
      list.plan(group, "gap of 1e-3 L, avoiding its walls",
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
      group, "gap of 1e-3 L, with a moment", unit_rod() + actuator(-5.0, 5.0) + gap, {bent},
      fmt::format("linear beam theory: the tip on one wall, a point {:.4g} L before it on the other", beyond));
  pressed.known = {std::nullopt, 1.0, (bent - at_contact) / beyond, 2e-3};
  pressed.contacts = 2;
  ExtremeCase& pressed_plan =
      list.plan(group, "gap of 1e-3 L, with a moment",
                unit_rod() + actuator(bent, bent) + gap + contact("allow", 2) + target(0.9, 0.3) + weighted(1.0, 1e-6),
                pressed.source);
  pressed_plan.known = pressed.known;
  pressed_plan.contacts = 2;
  pressed_plan.against_execution = true;
  ExtremeCase& into_tip = list.plan(group, "contact slides into the tip",
                                    heavy(number(2.0)) + circle(0.985, number(-0.1), 0.03) + contact("allow") +
                                        target(1.0, -0.1) + weighted(1.0, 0.0),
                                    source);
  into_tip.against_execution = true;
  // Both halves bend alike: the contact passes the actuators' common end while the loads grow, or stops beside it.
  for (const double table_x : {0.49, 0.495, 0.4975, 0.5}) {
    const double x = 0.5 - number(0.5 - table_x);
    (void)list.execution(
        group, fmt::format("contact at an actuator's end, circle at {} L", x),
        heavy(number(5.0)) + actuator(-5.0, 5.0, 0.0, 0.5) + actuator(-5.0, 5.0, 0.5, 1.0) + circle(x, -0.06, 0.02),
        {0.0, 0.0}, "boundary-value problem");
  }
  (void)list.execution(group, "contact slides into the base", heavy(number(5.0)) + circle(0.02, -0.0201, 0.02), {},
                       "boundary-value problem");
}

void add_contacts(List& list) {
  const char* group = "contact";
  Numbers& number = list.number;
  const double radius = number(0.15);
  const std::string peg = circle(0.6, 0.3, radius);
  const std::string first = unit_rod() + actuator(-10.0, 10.0) + peg;
  const auto held = [&](double moment, const char* mode, int count) {
    return unit_rod() + actuator(moment, moment) + peg + contact(mode, count) +
           (std::string(mode) == "require" ? "min_force = 0.1\n" : "") + start(0.5) + target(0.8, 0.4) +
           weighted(1.0, 1e-6);
  };
  const double table[][5] = {{1.0, 0.655901506, 0.708646714, 0.901317076, 0.357903200},
                             {3.0, 5.363198514, 0.790855638, 0.779270480, 0.416794223}};
  for (const auto& [table_moment, force, place, x, y] : table) {
    const double moment = number(table_moment);
    const KnownAnswer known = number.table({Vec2{x, y}, place, force, 2e-9});
    ExtremeCase& executed =
        list.execution(group, fmt::format("first reference circle, moment {}", moment), first, {moment}, "exact table");
    executed.known = known;
    executed.contacts = 1;
    ExtremeCase& planned = list.plan(group, fmt::format("first reference circle, moment {}", moment),
                                     held(moment, "allow", 1), "exact table");
    planned.known = known;
    planned.contacts = 1;
  }
  // Above 1/r the rod is bent more than the circle: beyond a single point it would run into it. It stands on a second
  // one, its tip.
  const double wrapping = 1.1 / radius;
  const char* beyond = "above 1/r no single point holds the rod: its tip is the second one (boundary-value problem)";
  ExtremeCase& wrapped = list.execution(group, "first reference circle, bent beyond 1/r", first, {wrapping}, beyond);
  wrapped.contacts = 2;
  wrapped.quick = true;
  ExtremeCase& paired =
      list.plan(group, "first reference circle, bent beyond 1/r, two contacts", held(wrapping, "require", 2), beyond);
  paired.contacts = 2;
  paired.against_execution = true;
  ExtremeCase& forced =
      list.plan(group, "first reference circle, bent beyond 1/r, one contact", held(wrapping, "require", 1), beyond);
  forced.verdict = "extended";
  forced.quick = true;
  // Bent back, the two contacts become one at the moment 1/r, where the free end has the circle's curvature.
  ExtremeCase& merged =
      list.execution(group, "two contacts on one circle become one", first, {number(4.0)}, "boundary-value problem");
  merged.before = {wrapping};
  merged.contacts_before = 2;
  merged.contacts = 1;
  // Linear beam theory: the rod touches down at a = (72 h / w)^(1/4), and the wall carries all weight but what hangs in
  // between, of which the clamp has 2/3.
  const double height = number(1e-3);
  const double weight = number(100.0);
  const double touches = std::pow(72.0 * height / weight, 0.25);
  const StretchAnswer lies{touches, weight * (1.0 - 2.0 / 3.0 * touches)};
  ExtremeCase& lying =
      list.execution(group, "heavy rod on a wall", gravity_of(1.0) + unit_rod(weight) + wall(-height, 1.0), {},
                     "beam theory: it touches down at (72 h / w)^(1/4)");
  lying.verdict = "extended";
  lying.stretch = lies;
  ExtremeCase& flat = list.execution(group, "heavy rod on a circle of radius 1e4 L",
                                     gravity_of(1.0) + unit_rod(weight) + circle(0.5, -height - 1e4, 1e4), {},
                                     "as on a wall, up to 1e-5 L of height");
  flat.verdict = "extended";
  flat.stretch = lies;
  ExtremeCase& planned_flat = list.plan(group, "heavy rod on a wall, one contact",
                                        gravity_of(1.0) + unit_rod(weight) + wall(-height, 1.0) + contact("require") +
                                            "min_force = 0.1\n" + target(0.9, 0.0) + weighted(1.0, 0.0),
                                        "beam theory: no point carries it");
  planned_flat.verdict = "extended";
  const double arc = number(1.0);
  const Vec2 half = 0.5 * arc_tip(0.5 * arc);
  const double turn = 0.5 * arc;
  const Vec2 below{half.x + 0.1 * std::sin(turn), half.y - 0.1 * std::cos(turn)};
  const KnownAnswer grazed{arc_tip(arc), {}, 0.0, 1e-9};
  ExtremeCase& grazing = list.plan(group, "circle grazed, force exactly 0",
                                   unit_rod() + actuator(arc, arc) + start(1.0) + circle(below.x, below.y, 0.1) +
                                       contact("allow") + target(0.8, 0.4) + weighted(1.0, 1e-6),
                                   "circular arc");
  grazing.known = grazed;
  grazing.quick = true;
  ExtremeCase& graze = list.execution(group, "circle grazed, force exactly 0",
                                      unit_rod() + actuator(-5.0, 5.0) + start(1.0) + circle(below.x, below.y, 0.1),
                                      {arc}, "circular arc");
  graze.known = grazed;
  // The rod itself carries 3 y EI / L^3 of the force.
  const double strong_force = number(1e4);
  const double low = number(1e-4);
  const KnownAnswer strong{Vec2{1.0, -low}, 1.0, strong_force - 3.0 * low, 1e-7};
  const std::string press = unit_rod() + tip_force(0.0, -strong_force) + wall(-low, 1.0);
  ExtremeCase& pressed = list.execution(group, "force of 1e4 at the tip", press, {}, "linear beam theory");
  pressed.known = strong;
  ExtremeCase& planned =
      list.plan(group, "force of 1e4 at the tip", press + contact("allow") + target(1.0, 0.0) + weighted(1.0, 0.0),
                "linear beam theory");
  planned.known = strong;
  planned.quick = true;
  // An actuator of 0.04 L turns the rod about a peg beside the clamp: the force is some 3 m / (2 a).
  const double peg_radius = 2e-3;
  const double lever = number(0.02);
  const double turned_by = number(133.0);
  const std::string levered = unit_rod() + circle(lever, -peg_radius, peg_radius);
  ExtremeCase& levered_run =
      list.execution(group, "force of 1e4 at an inner contact", levered + actuator(-500.0, 500.0, 0.0, 0.04),
                     {-turned_by}, "boundary-value problem");
  levered_run.contacts = 1;
  ExtremeCase& levered_plan = list.plan(group, "force of 1e4 at an inner contact",
                                        levered + actuator(-turned_by, -turned_by, 0.0, 0.04) + contact("require") +
                                            "min_force = 1\n" + target(-0.94, -0.045) + weighted(1.0, 1e-9),
                                        "boundary-value problem");
  levered_plan.contacts = 1;
  levered_plan.quick = true;
  levered_plan.against_execution = true;
  // A rod under tension over a peg: it turns there within some 1/sqrt(force).
  for (const double table_force : {1e2, 1e4}) {
    const double force = number(table_force);
    const std::string over =
        unit_rod() + tip_force(0.0, -force) + circle(number(0.6), number(-0.05), 1e-3) + start(0.1);
    ExtremeCase& drawn = list.execution(group, fmt::format("tip force of {:.3g} over an inner contact", force), over,
                                        {}, "boundary-value problem");
    drawn.contacts = 1;
    if (table_force > 1e3) continue;
    ExtremeCase& drawn_plan =
        list.plan(group, fmt::format("tip force of {:.3g} over an inner contact", force),
                  over + contact("require") + "min_force = 1\n" + target(0.7, -0.4) + weighted(1.0, 0.0),
                  "boundary-value problem");
    drawn_plan.contacts = 1;
    drawn_plan.against_execution = true;
  }
  const double upward = number(1.0);
  ExtremeCase& lost =
      list.execution(group, "contact lost on the way", unit_rod() + actuator(-5.0, 5.0) + circle(0.6, -0.15, 0.14),
                     {upward}, "circular arc");
  lost.before = {-upward};
  lost.known = {arc_tip(upward), {}, {}, 1e-9};
  lost.contacts_before = 1;
  lost.contacts = 0;
  for (const double apart : {1e-2, 1e-3, 1e-4}) {
    (void)list.execution(
        group, fmt::format("two circles {} L apart", apart),
        gravity_of(1.0) + unit_rod(number(5.0)) + circle(0.6, -0.07, 0.02) + circle(0.6 + apart, -0.07, 0.02), {},
        "boundary-value problem");
  }
}

std::string capsule(Vec2 from, Vec2 to, double radius) {
  return fmt::format("[[obstacle]]\nshape = \"capsule\"\nfrom = [{}, {}]\nto = [{}, {}]\nradius = {}\n", from.x, from.y,
                     to.x, to.y, radius);
}

/// How far below its clamp a rod is at most under a moment and its weight, by linear beam theory.
double deepest_sag(double moment, double weight) {
  double deepest = 0.0;
  for (int i = 1; i <= 1000; ++i) {
    const double x = 1e-3 * i;
    deepest = std::max(deepest, x * x * (weight * (6.0 - 4.0 * x + x * x) / 24.0 - 0.5 * moment));
  }
  return deepest;
}

/// The same contact on every shape, split and not.
void add_shapes(List& list) {
  const char* group = "shapes";
  Numbers& number = list.number;
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

/// Tips led along a row of targets, each plan from the one before.
void add_trajectories(List& list) {
  const char* group = "trajectory";
  Numbers& number = list.number;
  const double radius = number(0.08);
  ExtremeCase& lost = list.plan(group, "contact lost on the way",
                                arm_over(circle(0.6, 0.0, radius), 1.0, 1.0, 0.01) + target(0.98, 0.10),
                                "boundary-value problem, step by step");
  for (int i = 0; i <= 12; ++i) lost.targets.push_back({0.98 - 0.010 * i, 0.10 + 0.025 * i});
  lost.contacts_before = 1;
  lost.contacts = 0;
  ExtremeCase& made = list.plan(group, "contact made on the way",
                                arm_over(circle(0.6, 0.0, radius), 1.0, 1.0, 0.01) + target(0.86, 0.40),
                                "boundary-value problem, step by step");
  made.targets.assign(lost.targets.rbegin(), lost.targets.rend());
  made.contacts_before = 0;
  made.contacts = 1;
}

void add_programs(List& list) {
  const char* group = "programs";
  const std::string heavy = gravity_of(1.0) + unit_rod(list.number(1.0));
  ExtremeCase& none = list.plan(group, "torque limit 0",
                                heavy + actuator(0.0, 0.0) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  none.known = list.number.table({Vec2{0.9912463953, -0.1234714020}, {}, {}, 1e-9});
  none.quick = true;
  const double moment = list.number(1.0);
  ExtremeCase& equal = list.plan(
      group, "equal bounds", heavy + actuator(moment, moment) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  equal.known = list.number.table({Vec2{0.898317039, 0.363091933}, {}, {}, 1e-9});
  ExtremeCase& contradictory =
      list.plan(group, "contradictory bounds", heavy + actuator(1.0, -1.0) + target(0.9, 0.3) + weighted(1.0, 1e-6),
                "no such moment");
  contradictory.verdict = "refused";
  contradictory.quick = true;
  const double effort = list.number(1e-3);
  const std::string reach = heavy + actuator(-2.0, 2.0) + target(list.number(0.9), list.number(0.3));
  for (const double weight : {1.0, 1e-12, 1e-6, 1e6, 1e12}) {
    ExtremeCase& c = list.plan(group, fmt::format("all weights times {}", weight),
                               reach + weighted(weight, effort * weight), "only ratios of weights matter");
    c.same_as = "weights";
    c.quick = weight == 1.0 || weight == 1e-12 || weight == 1e12;
  }
  (void)list.plan(group, "weights 1e12 and 1e-12", reach + weighted(1e12, 1e-12), "certificate");
  (void)list.plan(group, "weights 1e-12 and 1e12", reach + weighted(1e-12, 1e12), "certificate");
  ExtremeCase& far =
      list.plan(group, "target 1e3 L away",
                unit_rod() + actuator(-2.0, 2.0) + start(0.5) + target(list.number(1000.0), 0.0) + weighted(1.0, 0.0),
                "straight");
  far.known = {Vec2{1.0, 0.0}, {}, {}, 1e-6};
  far.quick = true;
  (void)list.plan(group, "all weights 0", reach + weighted(0.0, 0.0), "certificate");
  ExtremeCase& twice =
      list.plan(group, "duplicate terms", reach + weighted(0.5, 0.5 * effort) + weighted(0.5, 0.5 * effort),
                "one term of twice the weight");
  twice.same_as = "weights";
}

}  // namespace

std::vector<ExtremeCase> extreme_cases(std::uint64_t held_out) {
  List list(held_out);
  add_scales(list);
  add_softness(list);
  add_large_angles(list);
  add_obstacles(list);
  add_contacts(list);
  add_shapes(list);
  add_trajectories(list);
  add_programs(list);
  return list.take();
}

}  // namespace tendril::bench
