// Several obstacles of several shapes: which contact belongs to which obstacle is found, and the plan is the
// equilibrium that the boundary-value problem has.

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "support.hpp"
#include "support/rod_bvp.hpp"

namespace tendril::combination {
namespace {

constexpr double stiffness = 4.9e-4;  // N m^2, of the shipped scenes

/// The plan against the exact rod, held at the plan's moment by `contacts`: per contact of the plan a circle or a wall
/// that its obstacle is near the contact, in metres.
void expect_exact(const Scene& scene, const Plan& found, const std::map<std::string, support::BvpContact>& shapes) {
  const double length = scene.rod.length();
  const double force_unit = stiffness / (length * length);
  support::RodBvp rod;
  rod.sections[0].density = 0.084 * 9.81 * length * length * length / stiffness;
  rod.gravity = {0.0, -1.0};
  support::BvpGuess guess;
  guess.angle = [&](double s) {
    for (const BackbonePoint& p : found.backbone) {
      if (p.s >= s * length) return p.angle;
    }
    return found.tip_angle;
  };
  std::vector<support::BvpContact> contacts;
  for (const PlannedContact& c : found.contacts) {
    support::BvpContact shape = shapes.at(c.obstacle_name);
    shape.center = {shape.center.x / length, shape.center.y / length};
    shape.radius /= length;
    shape.at_tip = c.at_tip;
    contacts.push_back(shape);
    EXPECT_GT(c.force, 0.01 * force_unit) << c.obstacle_name;
    guess.arc_lengths.push_back(c.arc_length / length);
    guess.forces.push_back(c.force / force_unit);
  }
  const support::BvpSolution exact = solve(rod, {found.moments[0] * length / stiffness}, contacts, guess);
  // Six functions on each smooth stretch of a rod that turns by less than a radian on it: 1e-6 of the length where a
  // long end hangs free under its weight.
  EXPECT_LT(std::hypot(found.tip_x / length - exact.tip_x, found.tip_y / length - exact.tip_y), 1e-6);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    EXPECT_NEAR(found.contacts[i].arc_length / length, exact.arc_lengths[i], 1e-6);
    EXPECT_NEAR(found.contacts[i].force / force_unit, exact.forces[i], 1e-5 * exact.forces[i]);
  }
}

support::BvpContact circle(double x, double y, double radius) { return {{x, y}, radius}; }

class EverySolver : public testing::TestWithParam<std::string> {
 protected:
  Scene with_solver(const std::string& name) const {
    Scene made = scene(name);
    made.solver.plugin = GetParam();
    return made;
  }
};

TEST_P(EverySolver, ThreadsTheArmThroughThePegs) {
  const Scene clutter = with_solver("clutter");
  ASSERT_GE(clutter.obstacles.size(), 8u);
  const Plan found = plan(clutter);
  ASSERT_TRUE(certified(found));
  ASSERT_EQ(found.contacts.size(), 3u);
  std::map<std::string, support::BvpContact> pegs;
  for (std::size_t i = 0; i < clutter.obstacles.size(); ++i) {
    const auto& center = std::get<RawValue::List>(clutter.obstacles[i].options.at("center").value);
    const auto metres = [&](std::size_t k) {
      return clutter.read_quantity(std::get<std::string>(center[k].value), dimension::length);
    };
    pegs["obstacle " + std::to_string(i + 1)] = circle(metres(0), metres(1), 0.006);
  }
  expect_exact(clutter, found, pegs);
  // The report names each assignment that was tried once, and says what was not tried.
  std::set<std::string> names;
  for (const ModeRecord& mode : found.modes) names.insert(mode.mode);
  EXPECT_EQ(names.size(), found.modes.size());
  EXPECT_LE(found.modes.size(), 1u + 20u + 2u * 4u * 6u);
  EXPECT_TRUE(std::any_of(found.left_out.begin(), found.left_out.end(), [](const LeftOut& left) {
    // 20 single contacts; 10 * 9 + 10 * 10 pairs; 10 * 9 * 8 + 10 * 9 * 10 triples.
    return left.what == "other contact assignments" && left.why.find("1830 ways") != std::string::npos;
  }));
  for (const PlannedContact& c : found.contacts) EXPECT_LT(c.gap, 1e-11);
}

TEST_P(EverySolver, LaysTheArmOnATable) {
  const Scene table = with_solver("table");
  const Plan found = plan(table);
  ASSERT_TRUE(certified(found));
  ASSERT_EQ(found.contacts.size(), 1u);
  EXPECT_NEAR(found.contacts[0].point.y, -0.02, 1e-12);
  expect_exact(table, found, {{"table", {.center = {0.0, -0.02}, .wall_normal = {0.0, 1.0}}}});
}

TEST_P(EverySolver, HoldsTheArmBetweenALedgeAndABar) {
  const Scene ledge = with_solver("ledge");
  const Plan found = plan(ledge);
  ASSERT_TRUE(certified(found));
  ASSERT_EQ(found.contacts.size(), 2u);
  // It touches a corner of the polygon and the end of the capsule, which are arcs.
  expect_exact(ledge, found, {{"ledge", circle(0.05, 0.003, 0.004)}, {"bar", circle(0.078, 0.022, 0.005)}});
}

TEST_P(EverySolver, NeedsNoKnotAtAContactWithAnyShape) {
  for (const char* name : {"table", "ledge"}) {
    Scene whole = with_solver(name);
    whole.coordinates.split_at_contact = false;
    EXPECT_TRUE(certified(plan(whole))) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, EverySolver, testing::ValuesIn(registry().names(ComponentKind::solver)),
                         [](const auto& each) { return each.param; });

TEST(Clutter, AWarmStartBeginsWithTheContactsThatHeld) {
  const Scene clutter = scene("clutter");
  const Plan first = plan(clutter);
  ASSERT_TRUE(certified(first));
  PlanControl control;
  control.start = &first;
  const Plan again = plan(clutter, control);
  ASSERT_TRUE(certified(again));
  EXPECT_LE(again.objective, first.objective + 1e-9);
}

// A flat side of a shape is a wall, its round end a circle: the same plan whichever of them it is called.
TEST(Clutter, ALongCapsuleIsAWallWhereTheArmLies) {
  const Plan on_wall = plan(scene("table"));
  Scene capsule = scene("table");
  capsule.obstacles[0].shape = "capsule";
  capsule.obstacles[0].options = {{"from", {RawValue::List{{-1.0}, {-0.12}}, {}}},
                                  {"to", {RawValue::List{{1.0}, {-0.12}}, {}}},
                                  {"radius", {0.1, {}}}};
  const Plan on_capsule = plan(capsule);
  ASSERT_TRUE(certified(on_wall));
  ASSERT_TRUE(certified(on_capsule));
  EXPECT_NEAR(on_capsule.objective, on_wall.objective, 1e-10);
  EXPECT_NEAR(on_capsule.contacts[0].force, on_wall.contacts[0].force, 1e-9);
}

TEST(Clutter, DescribeShowsSinglesAndOneProgramOfTheLargestSize) {
  const Description d = problem(scene("clutter")).describe();
  EXPECT_EQ(d.modes.size(), 1u + 20u + 1u);
  int forces = 0;
  for (const Description::Count& c : d.variables) forces += c.name == "contact_force" ? c.count : 0;
  EXPECT_EQ(forces, 3);
}

}  // namespace
}  // namespace tendril::combination
