// Every status that a plan can have, from what the search met.

#include <atomic>
#include <cmath>

#include "combination/grasp_support.hpp"
#include "scripted_solver.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

/// One of each kind that is searched in its own way.
std::vector<Scene> solvable() { return {scene("brace"), scene("grasp_60mm"), scene("grasp_unequal")}; }
std::vector<Scene> impossible() { return {impossible_brace(), weak_grasp(false), weak_grasp(true)}; }

TEST(SearchStatus, ASolverThatRefusesEverythingIsAFailureWhateverNewtonMakesOfTheStart) {
  for (const SolveStatus status : {SolveStatus::unsupported, SolveStatus::failed, SolveStatus::not_finite}) {
    for (const Scene& made : solvable()) {
      SCOPED_TRACE(std::string(to_string(made.problem)) + ", " + std::string(to_string(status)));
      const Plan found = plan_with(made, solver_that_ends_as(status, "not today"));
      EXPECT_TRUE(ended_as(found, PlanStatus::failed));
      EXPECT_EQ(found.message, "not today; solver '" + made.solver.plugin + "' ended every solve as " +
                                   std::string(to_string(status)));
    }
  }
}

TEST(SearchStatus, OneThatSaysOnlyThatItStalledLeavesThePlanToNewton) {
  for (const Scene& made : {scene("brace"), scene("grasp_unequal")}) {
    SCOPED_TRACE(to_string(made.problem));
    EXPECT_TRUE(certified(plan_with(made, solver_that_ends_as(SolveStatus::stalled, "tired"))));
  }
}

TEST(SearchStatus, AStopBeforeTheSearchInterrupts) {
  const std::atomic<bool> stop{true};
  PlanControl control;
  control.stop = &stop;
  for (const std::vector<Scene>& scenes : {solvable(), impossible()}) {
    for (const Scene& made : scenes) {
      SCOPED_TRACE(to_string(made.problem));
      const Plan found = combination::plan(made, control);
      EXPECT_TRUE(ended_as(found, PlanStatus::interrupted));
      EXPECT_EQ(found.message, "interrupted before a plan was certified");
      for (const ModeRecord& mode : found.modes) {
        EXPECT_EQ(mode.outcome, "not tried: stopped before") << mode.mode;
        EXPECT_EQ(mode.solves, 0) << mode.mode;
      }
    }
  }
}

TEST(SearchStatus, AStopWithinTheSearchInterrupts) {
  for (const Scene& made :
       {scene("brace"), scene("grasp_60mm"), impossible_brace(), weak_grasp(false), weak_grasp(true)}) {
    SCOPED_TRACE(to_string(made.problem));
    std::atomic<bool> stop{false};
    PlanControl control;
    control.stop = &stop;
    const Plan found =
        plan_with(made, solver_that_ends_as(SolveStatus::stalled, "", [&stop] { stop = true; }), control);
    EXPECT_TRUE(ended_as(found, PlanStatus::interrupted));
    EXPECT_EQ(found.message, "interrupted before a plan was certified");
  }
}

TEST(SearchStatus, NoTimeIsATimeLimitAndProvesNothing) {
  for (const std::vector<Scene>& scenes : {solvable(), impossible()}) {
    for (Scene made : scenes) {
      SCOPED_TRACE(to_string(made.problem));
      made.solver.time_limit = 1e-9;
      const Plan found = combination::plan(made);
      EXPECT_TRUE(ended_as(found, PlanStatus::time_limit));
      EXPECT_TRUE(holds(found.message, "was reached before a plan was certified"));
      for (const ModeRecord& mode : found.modes) EXPECT_EQ(mode.outcome, "not tried: stopped before") << mode.mode;
    }
  }
}

TEST(SearchStatus, APlanThatIsThereWhenTheSearchIsStoppedIsSolved) {
  // Stopped at the first solve after one that ended at a plan.
  const Scene made = scene("grasp_60mm");
  const Plan whole = combination::plan(made);
  ASSERT_TRUE(certified(whole));
  std::atomic<bool> stop{false};
  PlanControl control;
  control.stop = &stop;
  control.start = &whole;
  int solves = 0;
  const Plan found = plan_with(made, newton([&] { stop = ++solves > 2; }), control);
  ASSERT_GT(solves, 2);
  EXPECT_TRUE(certified(found));
  EXPECT_NEAR(found.objective, whole.objective, 1e-9);
}

TEST(SearchStatus, WhereNothingIsProvenItIsTheSolversWordThatCounts) {
  // With one way of being in contact left out nothing is proven, whatever becomes of the others.
  struct Said {
    SolveStatus status;
    PlanStatus expected;
  };
  for (const bool grasp : {false, true}) {
    for (const Said& said :
         {Said{SolveStatus::diverged, PlanStatus::diverged}, Said{SolveStatus::stalled, PlanStatus::not_converged},
          Said{SolveStatus::infeasible, PlanStatus::not_converged},
          Said{SolveStatus::iteration_limit, PlanStatus::not_converged}}) {
      SCOPED_TRACE(std::string(grasp ? "both fingers, " : "brace, ") + std::string(to_string(said.status)));
      const Scene made = grasp ? weak_grasp(true) : impossible_brace();
      PlanControl control;
      control.without = {problem_with(made, newton()).describe().modes.front().name};
      const Plan found = plan_with(made, solver_that_ends_as(said.status, "so be it"), control);
      EXPECT_TRUE(ended_as(found, said.expected));
      EXPECT_FALSE(found.message.empty());
    }
  }
}

/// Reads the moments, and gives no number.
class NoNumber : public ObjectiveBase<NoNumber> {
 public:
  Reads reads() const override { return {.moments = true}; }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    for (const T& u : x.moments) out.smooth(u * std::nan(""));
  }
};

TEST(SearchStatus, AnObjectiveThatGivesNoNumberIsNamed) {
  Scene made = scene("free");
  Components components = plugins::make_components(combination::registry(), made);
  components.terms[1] = std::make_unique<NoNumber>();
  const Plan found = Problem(made, std::move(components)).plan();
  EXPECT_TRUE(ended_as(found, PlanStatus::failed));
  EXPECT_EQ(found.message, "objective 'actuation_effort': it is nan with moment 1 = 0.5 EI/L");
}

TEST(SearchStatus, AGraspWhoseOnlyDefectIsItsMarginIsHeldOrUnstable) {
  // The limit of 10 N at 15 mm asks for tips that are pulled apart: chambers that only close hold less, and that at the
  // limit of stability.
  for (const bool both : {false, true}) {
    SCOPED_TRACE(both ? "both fingers" : "mirrored");
    Scene made = combination::grasp_of_diameter(0.015, 10.0);
    for (ActuatorSpec& a : made.rod.actuators) a.maximum = 0.0;
    if (both) made.gripper->fingers = Fingers::both;
    const Plan found = combination::plan(made);
    if (found.status == PlanStatus::unstable) {
      ASSERT_EQ(found.certificate.failures.size(), 1U);
      EXPECT_LE(found.certificate.stability, tolerance::stability);
      EXPECT_TRUE(holds(found.message, "unstable: the stability margin is"));
    } else {
      ASSERT_TRUE(ended_as(found, both ? PlanStatus::infeasible : PlanStatus::solved));
      if (both) continue;
      EXPECT_GE(found.certificate.stability, tolerance::held_margin - tolerance::bounds);
      EXPECT_LT(found.contacts.front().force, 10.0);
    }
  }
}

}  // namespace
}  // namespace tendril::search
