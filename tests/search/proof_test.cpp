// "Infeasible" only where everything was looked at: what was left out, cut or searched by halves is no proof.

#include <atomic>

#include "combination/grasp_support.hpp"
#include "scripted_solver.hpp"

namespace tendril::search {
namespace {

using combination::scene;

Scene with_circle(Scene made, Vec2 center, double radius) {
  ObstacleSpec& peg = made.obstacles.at(0);
  peg.options["center"] = {RawValue::List{{center.x}, {center.y}}, {}};
  peg.options["radius"] = {radius, {}};
  return made;
}

/// Required contact with a peg in reach of nothing.
Scene out_of_reach() {
  return with_circle(scene("brace", {"contact.mode=require", "contact.min_force=\"10 mN\""}), {0.5, 0.0}, 0.008);
}

TEST(SearchProof, AnImpossibleSceneIsInfeasibleFromFiveStartsOfEveryMode) {
  for (const Scene& made : {impossible_brace(), weak_grasp(false), weak_grasp(true)}) {
    SCOPED_TRACE(to_string(made.problem));
    const Plan found = combination::plan(made);
    EXPECT_TRUE(ended_as(found, PlanStatus::infeasible));
    EXPECT_TRUE(holds(found.message, "from 5 starts per "));
    EXPECT_TRUE(holds(found.message, "; the nearest ("));
    for (const ModeRecord& mode : found.modes) {
      EXPECT_FALSE(mode.certified);
      EXPECT_TRUE(holds(mode.outcome, "stationary")) << mode.mode;
    }
  }
}

TEST(SearchProof, AModeLeftOutOnRequestIsNoProof) {
  for (const Scene& made : {impossible_brace(), weak_grasp(false), weak_grasp(true)}) {
    SCOPED_TRACE(to_string(made.problem));
    const std::vector<Description::Mode> modes = combination::problem(made).describe().modes;
    for (const std::size_t which : {std::size_t{0}, modes.size() - 1}) {
      SCOPED_TRACE(modes[which].name);
      PlanControl control;
      control.without = {modes[which].name};
      const Plan found = combination::plan(made, control);
      EXPECT_TRUE(ended_as(found, PlanStatus::not_converged));
      const ModeRecord left_out = record_of(found, modes[which].name);
      EXPECT_EQ(left_out.outcome, "not tried: left out on request");
      EXPECT_EQ(left_out.solves + left_out.polishes, 0);
    }
    // With all of them left out there is nothing to say, least of all by a bound.
    PlanControl control;
    for (const Description::Mode& mode : modes) control.without.push_back(mode.name);
    const Plan found = combination::plan(made, control);
    EXPECT_TRUE(ended_as(found, PlanStatus::not_converged));
    EXPECT_EQ(found.message.find("bound"), std::string::npos) << found.message;
  }
}

TEST(SearchProof, NoWayThatWasLeftOutIsTriedFromWhereTheRodRests) {
  // The arm leans on the peg: without that contact, and without the tip, nothing holds it clear.
  const Scene made = scene("brace");
  const Plan whole = combination::plan(made);
  ASSERT_TRUE(combination::certified(whole));
  PlanControl control;
  for (const ModeRecord& mode : whole.modes) {
    if (mode.certified) control.without.push_back(mode.mode);
  }
  ASSERT_FALSE(control.without.empty());
  for (const bool warm : {false, true}) {
    control.start = warm ? &whole : nullptr;
    control.follow = warm;
    const Plan found = combination::plan(made, control);
    for (const std::string& name : control.without) {
      const ModeRecord left_out = record_of(found, name);
      EXPECT_EQ(left_out.outcome, "not tried: left out on request") << name;
      EXPECT_EQ(left_out.solves + left_out.polishes, 0) << name;
      EXPECT_FALSE(left_out.certified) << name;
    }
    EXPECT_FALSE(found.status == PlanStatus::infeasible) << found.message;
  }
}

TEST(SearchProof, ABoundIsAProofBesideWhatWasLeftOut) {
  const Scene made = out_of_reach();
  const Plan found = combination::plan(made);
  EXPECT_TRUE(ended_as(found, PlanStatus::infeasible));
  EXPECT_TRUE(holds(found.message, "infeasible by a bound: out of reach"));
  PlanControl control;
  control.without = {found.modes.front().mode};
  EXPECT_TRUE(ended_as(combination::plan(made, control), PlanStatus::infeasible));
}

TEST(SearchProof, ABoundForSomeModesIsNoneForTheOthers) {
  // The tip reaches a peg that the first of two segments cannot.
  Scene made = with_circle(impossible_brace(), {0.07, 0.0}, 0.008);
  made.rod.segments.assign(2, made.rod.segments.front());
  for (SegmentSpec& segment : made.rod.segments) segment.length = 0.05;
  const Plan found = combination::plan(made);
  EXPECT_TRUE(ended_as(found, PlanStatus::infeasible));
  EXPECT_TRUE(holds(found.message, "from 5 starts per mode"));
  int skipped = 0;
  for (const ModeRecord& mode : found.modes) skipped += mode.outcome.find("skipped: out of reach") == 0 ? 1 : 0;
  EXPECT_EQ(skipped, 1);
}

TEST(SearchProof, ASearchThatIsStoppedHalfwayProvesNothing) {
  // After each mode had four starts: one short of a proof.
  for (const Scene& made : {impossible_brace(), weak_grasp(false), weak_grasp(true)}) {
    SCOPED_TRACE(to_string(made.problem));
    int solves = 0;
    ASSERT_TRUE(ended_as(plan_with(made, newton([&] { ++solves; })), PlanStatus::infeasible));
    std::atomic<bool> stop{false};
    PlanControl control;
    control.stop = &stop;
    int left = solves;
    EXPECT_TRUE(ended_as(plan_with(made, newton([&] { stop = --left <= 0; }), control), PlanStatus::interrupted));
  }
}

/// Many pegs that the arm cannot reach with enough force, so that their assignments are too many to be all tried.
Scene many_pegs(double x, int count) {
  Scene made = impossible_brace();
  made.obstacles.clear();
  for (int i = 0; i < 24; ++i) {
    ObstacleSpec peg;
    peg.shape = "circle";
    peg.options["center"] = {RawValue::List{{x}, {0.004 * (i - 12)}}, {}};
    peg.options["radius"] = {0.001, {}};
    made.obstacles.push_back(peg);
  }
  made.contact.count = count;
  return made;
}

TEST(SearchProof, OfTooManyAssignmentsOnlyABoundIsAProof) {
  const Plan found = combination::plan(many_pegs(0.2, 3));
  EXPECT_TRUE(ended_as(found, PlanStatus::infeasible));
  EXPECT_TRUE(holds(found.message, "infeasible by a bound"));
}

}  // namespace
}  // namespace tendril::search
