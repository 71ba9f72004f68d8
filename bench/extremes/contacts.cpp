// Contacts that become two, spread, graze, press hard, come and go.

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "common/scene_text.hpp"
#include "extremes/groups.hpp"

namespace tendril::bench {

namespace {

using namespace scene_text;

constexpr const char* contacts = "contact";

/// The first reference circle, until one contact becomes two.
void add_reference_circle(CaseList& list) {
  CaseNumbers& number = list.number;
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
    ExtremeCase& executed = list.execution(contacts, fmt::format("first reference circle, moment {}", moment), first,
                                           {moment}, "exact table");
    executed.known = known;
    executed.contacts = 1;
    ExtremeCase& planned = list.plan(contacts, fmt::format("first reference circle, moment {}", moment),
                                     held(moment, "allow", 1), "exact table");
    planned.known = known;
    planned.contacts = 1;
  }
  // Above 1/r the rod is bent more than the circle: beyond a single point it would run into it. It stands on a second
  // one, its tip.
  const double wrapping = 1.1 / radius;
  const char* beyond = "above 1/r no single point holds the rod: its tip is the second one (boundary-value problem)";
  ExtremeCase& wrapped = list.execution(contacts, "first reference circle, bent beyond 1/r", first, {wrapping}, beyond);
  wrapped.contacts = 2;
  wrapped.quick = true;
  ExtremeCase& paired = list.plan(contacts, "first reference circle, bent beyond 1/r, two contacts",
                                  held(wrapping, "require", 2), beyond);
  paired.contacts = 2;
  paired.against_execution = true;
  ExtremeCase& forced =
      list.plan(contacts, "first reference circle, bent beyond 1/r, one contact", held(wrapping, "require", 1), beyond);
  forced.verdict = "extended";
  forced.quick = true;
  // Bent back, the two contacts become one at the moment 1/r, where the free end has the circle's curvature.
  ExtremeCase& merged =
      list.execution(contacts, "two contacts on one circle become one", first, {number(4.0)}, "boundary-value problem");
  merged.before = {wrapping};
  merged.contacts_before = 2;
  merged.contacts = 1;
}

/// Rods that lie along an obstacle.
void add_lying(CaseList& list) {
  CaseNumbers& number = list.number;
  // Linear beam theory: the rod touches down at a = (72 h / w)^(1/4), and the wall carries all weight but what hangs in
  // between, of which the clamp has 2/3.
  const double height = number(1e-3);
  const double weight = number(100.0);
  const double touches = std::pow(72.0 * height / weight, 0.25);
  const StretchAnswer lies{touches, weight * (1.0 - 2.0 / 3.0 * touches)};
  ExtremeCase& lying =
      list.execution(contacts, "heavy rod on a wall", gravity_of(1.0) + unit_rod(weight) + wall(-height, 1.0), {},
                     "beam theory: it touches down at (72 h / w)^(1/4)");
  lying.verdict = "extended";
  lying.stretch = lies;
  ExtremeCase& flat = list.execution(contacts, "heavy rod on a circle of radius 1e4 L",
                                     gravity_of(1.0) + unit_rod(weight) + circle(0.5, -height - 1e4, 1e4), {},
                                     "as on a wall, up to 1e-5 L of height");
  flat.verdict = "extended";
  flat.stretch = lies;
  ExtremeCase& planned_flat = list.plan(contacts, "heavy rod on a wall, one contact",
                                        gravity_of(1.0) + unit_rod(weight) + wall(-height, 1.0) + contact("require") +
                                            "min_force = 0.1\n" + target(0.9, 0.0) + weighted(1.0, 0.0),
                                        "beam theory: no point carries it");
  planned_flat.verdict = "extended";
}

/// A contact without force.
void add_grazing(CaseList& list) {
  CaseNumbers& number = list.number;
  const double arc = number(1.0);
  const Vec2 half = 0.5 * arc_tip(0.5 * arc);
  const double turn = 0.5 * arc;
  const Vec2 below{half.x + 0.1 * std::sin(turn), half.y - 0.1 * std::cos(turn)};
  const KnownAnswer grazed{arc_tip(arc), {}, 0.0, 1e-9};
  ExtremeCase& grazing = list.plan(contacts, "circle grazed, force exactly 0",
                                   unit_rod() + actuator(arc, arc) + start(1.0) + circle(below.x, below.y, 0.1) +
                                       contact("allow") + target(0.8, 0.4) + weighted(1.0, 1e-6),
                                   "circular arc");
  grazing.known = grazed;
  grazing.quick = true;
  ExtremeCase& graze = list.execution(contacts, "circle grazed, force exactly 0",
                                      unit_rod() + actuator(-5.0, 5.0) + start(1.0) + circle(below.x, below.y, 0.1),
                                      {arc}, "circular arc");
  graze.known = grazed;
}

/// Forces of up to 1e4.
void add_strong(CaseList& list) {
  CaseNumbers& number = list.number;
  // The rod itself carries 3 y EI / L^3 of the force.
  const double strong_force = number(1e4);
  const double low = number(1e-4);
  const KnownAnswer strong{Vec2{1.0, -low}, 1.0, strong_force - 3.0 * low, 1e-7};
  const std::string press = unit_rod() + tip_force(0.0, -strong_force) + wall(-low, 1.0);
  ExtremeCase& pressed = list.execution(contacts, "force of 1e4 at the tip", press, {}, "linear beam theory");
  pressed.known = strong;
  ExtremeCase& planned =
      list.plan(contacts, "force of 1e4 at the tip", press + contact("allow") + target(1.0, 0.0) + weighted(1.0, 0.0),
                "linear beam theory");
  planned.known = strong;
  planned.quick = true;
  // An actuator of 0.04 L turns the rod about a peg beside the clamp: the force is some 3 m / (2 a).
  const double peg_radius = 2e-3;
  const double lever = number(0.02);
  const double turned_by = number(133.0);
  const std::string levered = unit_rod() + circle(lever, -peg_radius, peg_radius);
  ExtremeCase& levered_run =
      list.execution(contacts, "force of 1e4 at an inner contact", levered + actuator(-500.0, 500.0, 0.0, 0.04),
                     {-turned_by}, "boundary-value problem");
  levered_run.contacts = 1;
  ExtremeCase& levered_plan = list.plan(contacts, "force of 1e4 at an inner contact",
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
    ExtremeCase& drawn = list.execution(contacts, fmt::format("tip force of {:.3g} over an inner contact", force), over,
                                        {}, "boundary-value problem");
    drawn.contacts = 1;
    if (table_force > 1e3) continue;
    ExtremeCase& drawn_plan =
        list.plan(contacts, fmt::format("tip force of {:.3g} over an inner contact", force),
                  over + contact("require") + "min_force = 1\n" + target(0.7, -0.4) + weighted(1.0, 0.0),
                  "boundary-value problem");
    drawn_plan.contacts = 1;
    drawn_plan.against_execution = true;
  }
}

/// Contacts that are lost, or close to each other.
void add_passing(CaseList& list) {
  CaseNumbers& number = list.number;
  const double upward = number(1.0);
  ExtremeCase& lost =
      list.execution(contacts, "contact lost on the way", unit_rod() + actuator(-5.0, 5.0) + circle(0.6, -0.15, 0.14),
                     {upward}, "circular arc");
  lost.before = {-upward};
  lost.known = {arc_tip(upward), {}, {}, 1e-9};
  lost.contacts_before = 1;
  lost.contacts = 0;
  for (const double apart : {1e-2, 1e-3, 1e-4}) {
    (void)list.execution(
        contacts, fmt::format("two circles {} L apart", apart),
        gravity_of(1.0) + unit_rod(number(5.0)) + circle(0.6, -0.07, 0.02) + circle(0.6 + apart, -0.07, 0.02), {},
        "boundary-value problem");
  }
}

}  // namespace

void add_contacts(CaseList& list) {
  add_reference_circle(list);
  add_lying(list);
  add_grazing(list);
  add_strong(list);
  add_passing(list);
}

/// Tips led along a row of targets, each plan from the one before.
void add_trajectories(CaseList& list) {
  const char* group = "trajectory";
  CaseNumbers& number = list.number;
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

}  // namespace tendril::bench
