// Plans whose objective falls up to where equilibria stop to be stable, or a contact stops to be a point.

#include <algorithm>
#include <cmath>
#include <optional>

#include "support.hpp"
#include "support/print.hpp"
#include "tendril/execute.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::combination {
namespace {

bool leaves_out(const Plan& plan, const char* what) {
  return std::any_of(plan.left_out.begin(), plan.left_out.end(), [&](const LeftOut& l) { return l.what == what; });
}

/// A strip that a tip force of 3 EI/L^2 has buckled (pi^2/4 is enough), to be pushed back to where it was straight. Its
/// moment can straighten it only up to a fold.
Scene buckled(const std::string& solver) {
  Scene strip = scene(
      "free", {"tip_load.force=[\"-0.147 N\", \"0 N\"]", "rod.linear_density=0", "rod.actuator.0.limit=\"20 N mm\"",
               "start.tip_angle=\"0.5 rad\"", "target.position=[\"100 mm\", \"0 mm\"]"});
  strip.solver.plugin = solver;
  return strip;
}

TEST(LimitOfStability, ABuckledStripIsHeldShortOfItsFold) {
  std::optional<double> objective;
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene strip = buckled(solver);
    const Plan found = plan(strip);
    ASSERT_EQ(found.status, PlanStatus::solved) << found.message;
    EXPECT_TRUE(certified(found));
    // The row of the program stands on another rule than the certificate.
    EXPECT_NEAR(found.certificate.stability, tolerance::held_margin, 1e-7);
    EXPECT_TRUE(leaves_out(found, "plans that cost less"));

    // Of a plan and its mirror image one is as good as the other.
    EXPECT_NEAR(found.objective, objective.value_or(found.objective), 1e-6 * found.objective);
    objective = found.objective;
    if (found.tip_y < 0.0) strip.start_tip_angle = -strip.start_tip_angle;

    // What the rod does, found by following the load from where it rests without moment: it comes to rest where the
    // plan has it, and snaps when the moment goes on by 1e-4 EI/L. The margin falls as the root of the distance to the
    // fold.
    ASSERT_EQ(found.moments.size(), 1u);
    const Execution without = execute(strip, {}, {0.0});
    ASSERT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
    ASSERT_GT(without.result.tip_y * found.tip_y, 0.0);
    ExecuteControl control;
    control.start = &without.result;
    const Execution held = execute(strip, {}, found.moments, control);
    ASSERT_EQ(held.result.status, PlanStatus::solved) << held.result.message;
    EXPECT_TRUE(held.snaps.empty());
    // What order 6 leaves of the rod moves its fold.
    EXPECT_NEAR(held.result.tip_x, found.tip_x, 1e-5);
    EXPECT_NEAR(held.result.tip_y, found.tip_y, 1e-5);
    const double beyond = found.moments[0] + std::copysign(1e-4 * 4.9e-4 / 0.1, found.moments[0]);
    EXPECT_FALSE(execute(strip, {}, {beyond}, control).snaps.empty());
  }
}

TEST(LimitOfStability, HasNoPartInPlansThatAreStable) {
  const Plan found = plan(scene("brace"));
  ASSERT_TRUE(certified(found));
  EXPECT_FALSE(leaves_out(found, "plans that cost less"));
  EXPECT_FALSE(leaves_out(found, "contact along a stretch"));
}

/// The rod has to press against a slanting ceiling and to reach along it: best would be to lie along it.
TEST(LimitOfContact, ARodUnderACeilingKeepsAPointContact) {
  Scene ceiling = scene("brace", {"rod.linear_density=0", "rod.actuator.0.limit=\"4 N mm\"", "start.tip_angle=0",
                                  "target.position=[\"93.85 mm\", \"-18.2 mm\"]"});
  ceiling.obstacles[0].shape = "wall";
  ceiling.obstacles[0].options.clear();
  ceiling.obstacles[0].options["point"] = {RawValue::List{{0.00938}, {0.00626}}, {}};
  ceiling.obstacles[0].options["normal"] = {RawValue::List{{-0.52689}, {-0.84993}}, {}};
  ceiling.contact.mode = ContactModeName::require;
  ceiling.contact.min_force = 0.06;
  const Plan found = plan(ceiling);
  ASSERT_EQ(found.status, PlanStatus::solved) << found.message;
  EXPECT_TRUE(leaves_out(found, "contact along a stretch"));
  EXPECT_LE(found.certificate.penetration, tolerance::penetration);
  EXPECT_GE(found.certificate.contact_convexity, tolerance::held_convexity - tolerance::bounds);
}

}  // namespace
}  // namespace tendril::combination
