// What a plan says of itself, where the answer is known beforehand.

#include <atomic>
#include <cmath>
#include <numbers>

#include "support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::combination {
namespace {

void move(RawValue& center, const auto& map) {
  auto& list = std::get<RawValue::List>(center.value);
  const Vec2 moved = map(Vec2{std::get<double>(list[0].value), std::get<double>(list[1].value)});
  list[0].value = moved.x;
  list[1].value = moved.y;
}

/// The brace in numbers instead of text, so that a test can move it.
Scene movable_brace() {
  Scene brace = scene("brace");
  brace.obstacles[0].options["center"] = {RawValue::List{{0.06}, {0.0}}, {}};
  brace.obstacles[0].options["radius"] = {0.008, {}};
  return brace;
}

TEST(Verdict, ATargetOutOfReachIsAPlanWithItsError) {
  const Plan found = plan(scene("brace", {"target.position=[\"200 mm\", \"20 mm\"]"}));
  EXPECT_TRUE(certified(found));
  ASSERT_TRUE(found.target_error);
  // The rod is 100 mm long.
  EXPECT_GE(*found.target_error, std::hypot(0.2, 0.02) - 0.1);
  EXPECT_LT(*found.target_error, 0.12);
  EXPECT_NEAR(*found.target_error, std::hypot(0.2 - found.tip_x, 0.02 - found.tip_y), 1e-15);
}

TEST(Verdict, AnArmThatCannotClearAPegIsInfeasible) {
  const std::vector<std::string> limp{"rod.actuator.0.limit=0", "rod.linear_density=\"200 g/m\""};
  // Where the arm sags to, a peg is put.
  Scene free = scene("free", limp);
  const Plan sagging = plan(free);
  ASSERT_TRUE(certified(sagging));
  const BackbonePoint& middle = sagging.backbone[sagging.backbone.size() / 2];
  ASSERT_LT(middle.y, 0.0);
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene blocked = scene("avoid", limp);
    blocked.solver.plugin = solver;
    blocked.obstacles[0].options["center"] = {RawValue::List{{middle.x}, {middle.y}}, {}};
    const Plan found = plan(blocked);
    EXPECT_EQ(found.status, PlanStatus::infeasible) << to_string(found.status);
    EXPECT_TRUE(contains_text(found.message, "infeasible"));
    for (const ModeRecord& mode : found.modes) EXPECT_TRUE(contains_text(mode.outcome, "not solved"));
  }
}

TEST(Verdict, RequiredContactPressesAtLeastAsAsked) {
  const Plan allowed = plan(scene("brace"));
  ASSERT_TRUE(certified(allowed));
  ASSERT_EQ(allowed.contacts.size(), 1u);
  // More than the arm would choose, so that the bound is what decides, and less, so that it does not.
  for (const double factor : {0.5, 1.3}) {
    const double least = factor * allowed.contacts[0].force;
    Scene scene = combination::scene("brace", {"rod.actuator.0.limit=\"10 N mm\""});
    const Plan unasked = plan(scene);
    scene.contact.mode = ContactModeName::require;
    scene.contact.min_force = least;
    const Plan found = plan(scene);
    ASSERT_TRUE(certified(found)) << least;
    ASSERT_FALSE(found.contacts.empty());
    // Force unit times the tolerance on bounds.
    const double slack = 0.049 * tolerance::bounds;
    for (const PlannedContact& c : found.contacts) EXPECT_GE(c.force, least - slack);
    // A tighter scene cannot do better.
    EXPECT_GE(found.objective, unasked.objective - 1e-9);
  }
}

TEST(Verdict, RequiredContactOutOfReachIsInfeasible) {
  Scene far = movable_brace();
  far.obstacles[0].options["center"] = {RawValue::List{{0.5}, {0.0}}, {}};
  far.contact.mode = ContactModeName::require;
  far.contact.min_force = 0.01;
  const Plan found = plan(far);
  EXPECT_EQ(found.status, PlanStatus::infeasible);
  EXPECT_TRUE(contains_text(found.message, "out of reach"));
  for (const ModeRecord& mode : found.modes) {
    EXPECT_EQ(mode.solves, 0) << mode.mode;
    EXPECT_TRUE(contains_text(mode.outcome, "skipped"));
  }
}

TEST(Verdict, ARodThatCannotStandFallsAndIsPlannedWhereItComesToRest) {
  // Twice the weight under which a rod held upright buckles (7.84 EI/L^3), and motors too weak to matter: the upright
  // equilibrium meets the target best, but no rod stays there.
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene heavy = scene(
        "free", {"rod.base.angle=\"90 deg\"", "rod.bending_stiffness=\"1 N mm^2\"", "rod.linear_density=\"1.6 mg/mm\"",
                 "rod.actuator.0.limit=\"1e-6 N mm\"", "target.position=[\"0 mm\", \"100 mm\"]"});
    heavy.solver.plugin = solver;
    const Plan found = plan(heavy);
    EXPECT_TRUE(certified(found)) << to_string(found.status) << ": " << found.message;
    EXPECT_GT(found.certificate.stability, 0.0);
    EXPECT_LT(found.tip_y, 0.0);
  }
}

TEST(Verdict, AStopFlagInterrupts) {
  const std::atomic<bool> stop{true};
  PlanControl control;
  control.stop = &stop;
  const Plan found = plan(scene("brace"), control);
  EXPECT_EQ(found.status, PlanStatus::interrupted);
  EXPECT_NE(found.message, "");
}

TEST(Verdict, NoTimeIsATimeLimit) {
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene hurried = scene("brace");
    hurried.solver.plugin = solver;
    hurried.solver.time_limit = 1e-6;
    const Plan found = plan(hurried);
    EXPECT_EQ(found.status, PlanStatus::time_limit) << to_string(found.status);
    EXPECT_TRUE(contains_text(found.message, "time limit"));
  }
}

/// Maps a scene by a turn, a shift and, before both, a mirror at the x axis.
struct Motion {
  double angle = 0.0;
  Vec2 shift{};
  bool mirror = false;

  Vec2 turn(Vec2 v) const {
    if (mirror) v.y = -v.y;
    return {std::cos(angle) * v.x - std::sin(angle) * v.y, std::sin(angle) * v.x + std::cos(angle) * v.y};
  }
  Vec2 point(Vec2 p) const { return turn(p) + shift; }
  double sign() const { return mirror ? -1.0 : 1.0; }

  Scene of(Scene s) const {
    s.rod.base_position = point(s.rod.base_position);
    s.rod.base_angle = sign() * s.rod.base_angle + angle;
    s.gravity = turn(*s.gravity);
    s.target.position = point(*s.target.position);
    s.start_tip_angle *= sign();
    for (ObstacleSpec& o : s.obstacles) move(o.options["center"], [this](Vec2 p) { return point(p); });
    return s;
  }
};

/// Both plans agree to `tolerance` in units of L = 0.1 m and of the plan's own numbers.
void expect_moved(const Plan& a, const Plan& b, const Motion& motion, double tolerance) {
  ASSERT_TRUE(certified(a));
  ASSERT_TRUE(certified(b));
  const double length = 0.1;
  const Vec2 tip = motion.point({a.tip_x, a.tip_y});
  EXPECT_NEAR(b.tip_x, tip.x, tolerance * length);
  EXPECT_NEAR(b.tip_y, tip.y, tolerance * length);
  EXPECT_NEAR(b.tip_angle, motion.sign() * a.tip_angle + motion.angle, tolerance);
  EXPECT_NEAR(b.objective, a.objective, tolerance);
  ASSERT_EQ(b.moments.size(), a.moments.size());
  for (std::size_t i = 0; i < a.moments.size(); ++i) {
    EXPECT_NEAR(b.moments[i], motion.sign() * a.moments[i], tolerance * 4.9e-3);
  }
  ASSERT_EQ(b.contacts.size(), a.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    const Vec2 point = motion.point(a.contacts[i].point);
    const Vec2 normal = motion.turn(a.contacts[i].normal);
    EXPECT_NEAR(b.contacts[i].arc_length, a.contacts[i].arc_length, tolerance * length);
    // The force unit, and forces above one unit: relative.
    EXPECT_NEAR(b.contacts[i].force, a.contacts[i].force, tolerance * std::max(0.049, a.contacts[i].force));
    EXPECT_NEAR(b.contacts[i].point.x, point.x, tolerance * length);
    EXPECT_NEAR(b.contacts[i].point.y, point.y, tolerance * length);
    EXPECT_NEAR(b.contacts[i].normal.x, normal.x, tolerance * 10.0);
    EXPECT_NEAR(b.contacts[i].normal.y, normal.y, tolerance * 10.0);
  }
  ASSERT_EQ(b.backbone.size(), a.backbone.size());
  for (std::size_t i = 0; i < a.backbone.size(); ++i) {
    const Vec2 point = motion.point(a.backbone[i].position());
    EXPECT_NEAR(b.backbone[i].x, point.x, tolerance * length);
    EXPECT_NEAR(b.backbone[i].y, point.y, tolerance * length);
  }
}

// Scenes are rounded to 12 digits and plans polished to 1e-11; a plan on a bound amplifies that by less than 1e3.
constexpr double moved = 1e-8;

TEST(Symmetry, AMirroredSceneGivesTheMirroredPlan) {
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene brace = movable_brace();
    brace.solver.plugin = solver;
    const Motion mirror{.mirror = true};
    expect_moved(plan(brace), plan(mirror.of(brace)), mirror, moved);
  }
}

TEST(Symmetry, ATurnedAndShiftedSceneGivesTheTurnedAndShiftedPlan) {
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene brace = movable_brace();
    brace.solver.plugin = solver;
    const Plan own = plan(brace);
    for (const double angle : {0.7, -2.4, std::numbers::pi / 2}) {
      SCOPED_TRACE(angle);
      const Motion motion{.angle = angle, .shift = {0.03, -0.41}};
      expect_moved(own, plan(motion.of(brace)), motion, moved);
    }
  }
}

TEST(WarmStart, EndsAtThePlanThatItStartsFrom) {
  for (const char* name : {"free", "brace", "avoid", "two_pegs"}) {
    for (const bool split : {true, false}) {
      SCOPED_TRACE(std::string(name) + (split ? ", split" : ", not split"));
      Scene s = scene(name);
      s.coordinates.split_at_contact = split;
      const Plan first = plan(s);
      ASSERT_TRUE(certified(first));
      PlanControl control;
      control.start = &first;
      const Plan again = plan(s, control);
      expect_moved(first, again, {}, moved);
    }
  }
}

}  // namespace
}  // namespace tendril::combination
