// From one plan to the next: Newton alone where the active set stays, everything where it may not.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "scripted_solver.hpp"
#include "tendril/tolerances.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

const char* const followed = "followed from the earlier plan; certified, objective ";

/// Counts the solves of what is planned with it.
struct Counted {
  explicit Counted(const Scene& made) : problem(problem_with(made, newton([this] { ++solves; }))) {}
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  int solves = 0;
  Problem problem;
};

Plan follow(Counted& with, const Plan& earlier) {
  PlanControl control;
  control.start = &earlier;
  control.follow = true;
  with.solves = 0;
  return with.problem.plan(control);
}

TEST(SearchFollow, AnUnchangedSetOfContactsNeedsNoSolver) {
  for (const char* name : {"free", "brace", "two_pegs"}) {
    SCOPED_TRACE(name);
    const Plan first = combination::plan(scene(name));
    ASSERT_TRUE(certified(first));
    Counted with(scene(name));
    const Plan again = follow(with, first);
    ASSERT_TRUE(certified(again));
    EXPECT_EQ(with.solves, 0);
    EXPECT_NEAR(again.objective, first.objective, 1e-10);
    int times = 0;
    for (const ModeRecord& mode : again.modes) {
      EXPECT_EQ(mode.solves, 0) << mode.mode;
      EXPECT_EQ(mode.certified, mode.outcome.find(followed) == 0) << mode.outcome;
      times += mode.certified ? 1 : 0;
      if (!mode.certified) {
        EXPECT_TRUE(mode.outcome == "not tried: the earlier plan could be followed" ||
                    mode.outcome.find("skipped: ") == 0)
            << mode.outcome;
        EXPECT_FALSE(std::isfinite(mode.objective)) << mode.mode;
      }
    }
    EXPECT_EQ(times, 1);
  }
}

TEST(SearchFollow, WhatWasSaidOfTheEarlierPlanIsNotSaidOfTheNext) {
  Plan first = combination::plan(scene("brace"));
  ASSERT_TRUE(certified(first));
  first.scan = PlanScan{{0.1}, 10, 0, 0, true};
  first.minima.resize(2);
  first.notes = {"the tip misses the target by much"};
  Counted with(scene("brace"));
  Plan again = follow(with, first);
  EXPECT_EQ(with.solves, 0);
  EXPECT_FALSE(again.scan.has_value());
  EXPECT_TRUE(again.minima.empty());
  EXPECT_TRUE(again.notes.empty());
  // Nor is what holds of this one told twice.
  TargetSpec beyond = scene("brace").target;
  beyond.position = Vec2{beyond.position->x + 0.02, beyond.position->y};
  with.problem.set_target(beyond);
  for (int i = 0; i < 2; ++i) {
    again = follow(with, again);
    ASSERT_TRUE(certified(again));
    EXPECT_EQ(std::count_if(again.notes.begin(), again.notes.end(),
                            [](const std::string& note) { return note.find("misses the target") != note.npos; }),
              1);
  }
}

/// What a plan must not be followed for, and how it was made so.
struct NotFollowed {
  const char* why;
  std::function<void(Scene& made, Plan& earlier)> change;
};

TEST(SearchFollow, WhatTheEarlierPlanDoesNotKnowIsPlannedAnew) {
  const Plan brace = combination::plan(scene("brace"));
  ASSERT_TRUE(certified(brace));
  ASSERT_EQ(brace.contacts.size(), 1U);
  const std::vector<NotFollowed> all{
      {"it was not solved", [](Scene&, Plan& p) { p.status = PlanStatus::not_converged; }},
      {"it has other coordinates", [](Scene&, Plan& p) { p.coordinates_name = "pcc"; }},
      {"it is of another order", [](Scene&, Plan& p) { p.order += 1; }},
      {"it has no knot at its contact", [](Scene&, Plan& p) { p.split_at_contact = false; }},
      {"it is of a rod with more actuators", [](Scene&, Plan& p) { p.moments.push_back(0.0); }},
      {"it has coordinates too few", [](Scene&, Plan& p) { p.coordinates.pop_back(); }},
      {"its contact is with something unknown", [](Scene&, Plan& p) { p.contacts[0].obstacle_name = "table"; }},
      {"it has a contact that does not press",
       [](Scene&, Plan& p) {
         p.contacts.push_back(p.contacts[0]);
         p.contacts.back().force = 0.0;
       }},
      {"it has more contacts than there may be",
       [](Scene&, Plan& p) {
         p.contacts.push_back(p.contacts[0]);
         p.contacts.back().at_tip = true;
       }},
      {"the rod has to keep off", [](Scene& s, Plan&) { s.contact.mode = ContactModeName::avoid; }},
      {"its contact presses with less than is asked for",
       [](Scene& s, Plan& p) {
         s.contact.mode = ContactModeName::require;
         s.contact.min_force = 1.2 * p.contacts[0].force;
         s.rod.actuators[0].minimum = -0.01;
         s.rod.actuators[0].maximum = 0.01;
       }},
  };
  for (const NotFollowed& one : all) {
    SCOPED_TRACE(one.why);
    Scene made = scene("brace");
    Plan earlier = brace;
    one.change(made, earlier);
    Counted with(made);
    const Plan found = follow(with, earlier);
    EXPECT_TRUE(certified(found));
    EXPECT_GT(with.solves, 0);
    for (const ModeRecord& mode : found.modes) EXPECT_NE(mode.outcome.find(followed), 0U) << mode.outcome;
  }
}

// Where the limit on the moment is far the arm lifts itself off the peg: the followed plan would press with no force.
TEST(SearchFollow, AContactThatLetsGoIsPlannedAnew) {
  Scene made = scene("brace", {"rod.actuator.0.limit=\"10 N mm\"", "target.position=[\"98 mm\", \"12 mm\"]"});
  Problem problem = combination::problem(made);
  Plan plan = problem.plan();
  ASSERT_TRUE(certified(plan));
  int lost = 0;
  for (int step = 1; step <= 20; ++step) {
    const double y = 0.012 + 0.0012 * step;
    TargetSpec target;
    target.position = Vec2{std::sqrt(0.0985 * 0.0985 - y * y), y};
    const bool touched = !plan.contacts.empty() && plan.contacts[0].force > 0.0;
    problem.follow(target, plan);
    ASSERT_TRUE(certified(plan));
    const bool touches = !plan.contacts.empty() && plan.contacts[0].force > 0.0;
    for (const PlannedContact& c : plan.contacts) EXPECT_GE(c.force, 0.0);
    if (touched && !touches) ++lost;
    EXPECT_NEAR(*plan.target_error, std::hypot(plan.tip_x - target.position->x, plan.tip_y - target.position->y),
                1e-12);
  }
  EXPECT_EQ(lost, 1);
}

// The followed plan is the planned one, with a report of its own.
TEST(SearchFollow, EndsWhereAPlanFromTheStartDoes) {
  const Scene made = scene("brace");
  Problem problem = combination::problem(made);
  Plan plan = problem.plan();
  ASSERT_TRUE(certified(plan));
  for (int step = 1; step <= 3; ++step) {
    TargetSpec target = made.target;
    target.position = Vec2{0.097, 0.020 + 1e-4 * step};
    problem.follow(target, plan);
    ASSERT_TRUE(certified(plan));
    Scene moved = made;
    moved.target = target;
    const Plan alone = combination::plan(moved);
    ASSERT_TRUE(certified(alone));
    EXPECT_NEAR(plan.objective, alone.objective, 1e-9);
    EXPECT_NEAR(plan.tip_x, alone.tip_x, 1e-8);
    EXPECT_NEAR(plan.moments[0], alone.moments[0], 1e-9);
    EXPECT_NEAR(plan.contacts[0].force, alone.contacts[0].force, 1e-7);
    ASSERT_EQ(plan.terms.size(), 2U);
    EXPECT_NEAR(plan.terms[0].second + plan.terms[1].second, plan.objective, 1e-12);
    EXPECT_EQ(effort_of(plan).solver_calls, 0);
    EXPECT_EQ(effort_of(plan).polishes, 1);
  }
}

TEST(SearchStart, TheContactsOfTheEarlierPlanAreTriedFirst) {
  const Scene made = scene("brace");
  // Below the peg nothing is touched. From the scene's own start the ways come first whose tip can be at the target.
  const Plan first = combination::plan(scene("brace", {"target.position=[\"90 mm\", \"-35 mm\"]"}));
  ASSERT_TRUE(certified(first));
  ASSERT_TRUE(first.contacts.empty());
  // Stopped at the first solve, nothing but the mode that was tried first has any.
  std::atomic<bool> stop{false};
  PlanControl control;
  control.stop = &stop;
  for (const bool warm : {false, true}) {
    control.start = warm ? &first : nullptr;
    stop = false;
    const Plan found = plan_with(made, newton([&stop] { stop = true; }), control);
    for (const ModeRecord& mode : found.modes) {
      const bool is_first = warm ? mode.mode == "no contact" : mode.mode.find("interior contact") == 0;
      EXPECT_EQ(mode.solves > 0, is_first) << mode.mode << (warm ? ", warm" : ", cold");
    }
  }
}

}  // namespace
}  // namespace tendril::search
