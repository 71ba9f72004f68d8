// What a plan says of each way of being in contact, which of them need not be tried, and which one wins.

#include <algorithm>
#include <atomic>
#include <cmath>

#include "combination/grasp_support.hpp"
#include "scripted_solver.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

TEST(SearchModes, ThePlanIsTheBestOfTheCertifiedOnesAndTheSumsAreThoseOfTheModes) {
  for (const Scene& made : {scene("brace"), scene("avoid"), scene("two_pegs"), scene("grasp_60mm"),
                            combination::grasp_of_diameter(0.02, 3.33), scene("grasp_unequal")}) {
    SCOPED_TRACE(made.title);
    const Plan found = combination::plan(made);
    ASSERT_TRUE(certified(found));
    double best = infinity;
    int iterations = 0;
    std::int64_t evaluations = 0;
    for (const ModeRecord& mode : found.modes) {
      SCOPED_TRACE(mode.mode);
      iterations += mode.iterations;
      evaluations += mode.evaluations;
      if (mode.certified) best = std::min(best, mode.objective);
      EXPECT_EQ(mode.certified, mode.outcome.find("certified, objective ") != std::string::npos &&
                                    mode.outcome.find("not certified") == std::string::npos)
          << mode.outcome;
      EXPECT_EQ(std::isfinite(mode.objective), mode.outcome.find("objective ") != std::string::npos &&
                                                   mode.outcome.find("skipped") == std::string::npos)
          << mode.outcome;
    }
    // A mode beats another by a certain amount or not at all.
    EXPECT_NEAR(found.objective, best, 1e-11);
    EXPECT_EQ(found.solver.iterations, iterations);
    EXPECT_EQ(found.solver.evaluations.values, evaluations);
    EXPECT_GE(found.evaluations.values, evaluations);
    double terms = 0.0;
    for (const auto& [name, value] : found.terms) terms += value;
    EXPECT_NEAR(terms, found.objective, 1e-12 * (1.0 + std::abs(found.objective)));
  }
}

// A strip that a tip force of 3 EI/L^2 has buckled comes to rest on either side. Where no moment is to be chosen every
// start is tried, and later ones end on the side that is farther from the target.
TEST(SearchModes, ALaterPlanThatCostsMoreDoesNotReplaceABetterOne) {
  for (const double side : {1.0, -1.0}) {
    for (const double start : {0.5, -0.5}) {
      SCOPED_TRACE(std::to_string(side) + " from " + std::to_string(start));
      Scene strip =
          scene("free", {"tip_load.force=[\"-0.147 N\", \"0 N\"]", "rod.linear_density=0", "rod.actuator.0.limit=0"});
      strip.target.position = Vec2{0.05, 0.05 * side};
      strip.start_tip_angle = start;
      const Plan found = combination::plan(strip);
      ASSERT_TRUE(certified(found));
      EXPECT_GT(found.tip_y * side, 0.01);
    }
  }
}

// Of the valleys of these two fingers' effort the best one is at -5.99368, and the one that a later start ends in at
// -5.99226.
TEST(SearchModes, ALaterGraspThatCostsMoreDoesNotReplaceABetterOne) {
  const Plan found = combination::plan(scene("grasp_unequal", {"gripper.object_diameter=\"40 mm\""}));
  ASSERT_TRUE(certified(found));
  EXPECT_NEAR(found.objective, -5.99368, 1e-5);
}

// Without the mode that won the next best one does, as it said it would.
TEST(SearchModes, TheNextBestWinsWhereTheBestIsLeftOut) {
  for (const Scene& made : {scene("two_pegs"), scene("grasp_60mm")}) {
    SCOPED_TRACE(made.title);
    PlanControl control;
    double last = -infinity;
    for (int round = 0; round < 2; ++round) {
      const Plan found = combination::plan(made, control);
      if (!certified(found)) break;
      EXPECT_GE(found.objective, last - 1e-9);
      last = found.objective;
      for (const ModeRecord& mode : found.modes) {
        if (mode.certified && mode.objective == found.objective) control.without.push_back(mode.mode);
      }
    }
    EXPECT_FALSE(control.without.empty());
  }
}

/// The moments' squares, on top of a number that they never go below.
class Raised : public ObjectiveBase<Raised> {
 public:
  Raised(double base, double bound) : base_(base), bound_(bound) {}
  Reads reads() const override { return {.moments = true}; }
  double lower_bound() const override { return bound_; }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.smooth(T(base_));
    for (const T& u : x.moments) out.residual(u);
  }

 private:
  double base_, bound_;
};

/// The brace without weight, whose best plan costs nothing but `base`: no moment, and no contact.
Plan raised_brace(double base, double bound, double weight, double other_weight) {
  Scene made = scene("brace", {"rod.linear_density=0", "obstacle.0.center=[\"60 mm\", \"20 mm\"]"});
  made.objectives[0].weight = weight;
  made.objectives[1].weight = other_weight;
  Components components = plugins::make_components(combination::registry(), made);
  components.terms[0] = std::make_unique<Raised>(base, bound);
  components.terms[1] = std::make_unique<Raised>(base, bound);
  return Problem(made, std::move(components)).plan();
}

TEST(SearchModes, WhatCannotCostLessThanThePlanFoundIsSkipped) {
  struct Known {
    double base, bound, weight, other_weight;
    bool skipped;
  };
  for (const Known& known : {Known{0.0, 0.0, 1.0, 1.0, true}, Known{0.7, 0.7, 1.0, 1.0, true},
                             Known{0.7, 0.7, 30.0, 0.5, true}, Known{-2.0, -2.0, 3.0, 1.0, true},
                             // Nothing is known that is near enough.
                             Known{0.7, 0.6, 1.0, 1.0, false}, Known{0.0, -infinity, 1.0, 1.0, false},
                             Known{0.7, 0.7 - 1e-9, 30.0, 0.5, false}}) {
    SCOPED_TRACE(std::to_string(known.base) + ", at least " + std::to_string(known.bound));
    const Plan found = raised_brace(known.base, known.bound, known.weight, known.other_weight);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(found.objective, known.base * (known.weight + known.other_weight), 1e-9);
    ASSERT_EQ(found.modes.size(), 3U);
    EXPECT_TRUE(found.modes[0].certified);
    for (const std::size_t other : {1, 2}) {
      const ModeRecord& mode = found.modes[other];
      EXPECT_EQ(mode.outcome.find("skipped: cannot win: it costs at least ") == 0, known.skipped) << mode.outcome;
      // Without a feasible point near any start no solver is asked either.
      const bool out_of_reach = mode.outcome.find("no feasible point near") != std::string::npos;
      EXPECT_EQ(mode.solves == 0, known.skipped || out_of_reach) << mode.mode << ": " << mode.outcome;
    }
  }
}

// Without all ways but a skipped one the plan costs as much as was said, or there is none.
TEST(SearchModes, WhatIsSkippedByWhereItsTipCanBeCostsAsMuchAsIsSaid) {
  int skipped = 0;
  for (const double limit : {2.5, 10.0}) {
    for (const auto& [x, y] : {std::pair(97, 20), std::pair(99, 6), std::pair(91, 26), std::pair(98, 12)}) {
      const Scene made =
          scene("brace", {"rod.actuator.0.limit=\"" + std::to_string(limit) + " N mm\"",
                          "target.position=[\"" + std::to_string(x) + " mm\", \"" + std::to_string(y) + " mm\"]"});
      const Plan found = combination::plan(made);
      ASSERT_TRUE(certified(found));
      const std::string said = "skipped: cannot win: it costs at least ";
      for (const ModeRecord& mode : found.modes) {
        if (mode.outcome.find(said) != 0) continue;
        SCOPED_TRACE(made.title + ": " + mode.mode);
        ++skipped;
        const double least = std::stod(mode.outcome.substr(said.size()));
        EXPECT_GE(least, found.objective - 1e-9);
        PlanControl control;
        for (const ModeRecord& other : found.modes) {
          if (other.mode != mode.mode) control.without.push_back(other.mode);
        }
        const Plan alone = combination::plan(made, control);
        // Where nothing presses the plan belongs to another way.
        const bool presses = mode.mode == "no contact" || (!alone.contacts.empty() && alone.contacts[0].force > 1e-9);
        if (alone.status == PlanStatus::solved && presses) {
          EXPECT_GE(alone.objective, least * (1.0 - 1e-9));
        }
      }
    }
  }
  EXPECT_GE(skipped, 8);
}

Scene two_segments(double x, double radius) {
  Scene made = scene("brace", {"rod.linear_density=0"});
  made.rod.segments.assign(2, made.rod.segments.front());
  for (SegmentSpec& segment : made.rod.segments) segment.length = 0.05;
  made.obstacles[0].name = "peg";
  made.obstacles[0].options["center"] = {RawValue::List{{x}, {0.0}}, {}};
  made.obstacles[0].options["radius"] = {radius, {}};
  return made;
}

// A point of the rod is at most its arc length away from the base.
TEST(SearchModes, AnObstacleOutOfReachOfAPartOfTheRodIsSkippedThere) {
  constexpr double radius = 0.008;
  const std::string skipped =
      "skipped: out of reach: the obstacle is farther from the base than this part of the rod is long";
  for (const double part : {0.05, 0.1}) {
    for (const double factor : {0.999, 1.001}) {
      SCOPED_TRACE(std::to_string(part) + " m, " + std::to_string(factor));
      const double distance = part * factor;
      // Stopped at once: what is skipped is known before anything is tried.
      const std::atomic<bool> stop{true};
      PlanControl control;
      control.stop = &stop;
      const Plan found = combination::plan(two_segments(distance + radius, radius), control);
      for (const auto& [mode, reach] :
           {std::pair("interior contact with 'peg' on segment 1", 0.05),
            std::pair("interior contact with 'peg' on segment 2", 0.1), std::pair("tip contact with 'peg'", 0.1)}) {
        EXPECT_EQ(record_of(found, mode).outcome, distance > reach ? skipped : "not tried: stopped before") << mode;
      }
      EXPECT_EQ(record_of(found, "no contact").outcome, "not tried: stopped before");
    }
  }
}

TEST(SearchModes, ATermThatReadsTheContactPointNeedsOne) {
  Scene made = scene("brace");
  ObjectiveSpec near;
  near.plugin = "contact_proximity";
  made.objectives.push_back(near);
  const Plan found = combination::plan(made);
  ASSERT_TRUE(certified(found));
  EXPECT_EQ(record_of(found, "no contact").outcome,
            "skipped: objective 'contact_proximity' reads the contact point, which this mode has not");
  EXPECT_FALSE(found.contacts.empty());
  // The force alone is 0 where nothing touches.
  made.objectives.back().plugin = "contact_force";
  EXPECT_NE(record_of(combination::plan(made), "no contact").outcome.find("objective"), std::string::npos);
}

TEST(SearchModes, OfAGraspOutOfReachSaysHowFarAway) {
  const Plan found = combination::plan(combination::grasp_of_diameter(0.2, 3.33));
  EXPECT_TRUE(ended_as(found, PlanStatus::infeasible));
  // Palm distance and half palm: the contact is at (0.1, 0.1) m, the base at (0, 0.02) m.
  char away[32];
  std::snprintf(away, sizeof away, "%.6g m", std::hypot(0.1, 0.08));
  for (const ModeRecord& mode : found.modes) {
    EXPECT_TRUE(holds(mode.outcome, "skipped: out of reach: the object is too large")) << mode.mode;
    EXPECT_TRUE(holds(mode.outcome, away)) << mode.mode;
  }
  Scene both = combination::grasp_of_diameter(0.2, 3.33);
  both.gripper->fingers = Fingers::both;
  const Plan pairs = combination::plan(both);
  EXPECT_TRUE(ended_as(pairs, PlanStatus::infeasible));
  EXPECT_EQ(pairs.modes.size(), 9U);
  for (const ModeRecord& mode : pairs.modes) EXPECT_TRUE(holds(mode.outcome, away)) << mode.mode;
}

/// Just within reach, and just out of it: the bound is that of a straight finger.
TEST(SearchModes, TheReachOfAGraspIsThatOfItsStraightFinger) {
  const std::atomic<bool> stop{true};
  PlanControl control;
  control.stop = &stop;
  for (const bool both : {false, true}) {
    // The contact at the height of the radius, 0.01 m above the base at 0.02 m.
    const double farthest = std::sqrt(0.1 * 0.1 - 0.01 * 0.01);
    for (const double factor : {0.999, 1.001}) {
      SCOPED_TRACE(std::string(both ? "both, " : "mirrored, ") + std::to_string(factor));
      Scene made = scene("grasp_60mm");
      made.gripper->palm_distance = factor * farthest;
      if (both) made.gripper->fingers = Fingers::both;
      const Plan found = combination::plan(made, control);
      int skipped = 0;
      for (const ModeRecord& mode : found.modes) {
        const bool far = mode.outcome.find("out of reach: the object is too far away") != std::string::npos;
        skipped += far ? 1 : 0;
        EXPECT_EQ(mode.outcome.find("the smallest allowed") != std::string::npos, far) << mode.outcome;
      }
      // The proximal segment ends at 70 mm: too far for either finger.
      const int proximal = both ? 5 : 1;
      EXPECT_EQ(skipped, factor > 1.0 ? static_cast<int>(found.modes.size()) : proximal);
    }
  }
}

TEST(SearchRequire, EveryContactPressesAtLeastAsAskedAndTheTableSaysSo) {
  // The arm would press with less.
  const Plan allowed = combination::plan(scene("brace"));
  ASSERT_TRUE(certified(allowed));
  ASSERT_EQ(allowed.contacts.size(), 1U);
  Scene made = scene("brace", {"rod.actuator.0.limit=\"10 N mm\""});
  made.contact.mode = ContactModeName::require;
  made.contact.min_force = 1.5 * allowed.contacts[0].force;
  const Plan found = combination::plan(made);
  ASSERT_TRUE(certified(found));
  // No way of being in contact is without one.
  EXPECT_EQ(found.modes.size(), 2U);
  for (const ModeRecord& mode : found.modes) EXPECT_EQ(mode.mode.find("no contact"), std::string::npos) << mode.mode;
  ASSERT_EQ(found.contacts.size(), 1U);
  EXPECT_GE(found.contacts[0].force, made.contact.min_force * (1.0 - 1e-8));
}

}  // namespace
}  // namespace tendril::search
