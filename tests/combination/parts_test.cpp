// Obstacles of any outline: parts of one body are one obstacle, and a rod may touch one body in several places.

#include <algorithm>
#include <cmath>

#include "support.hpp"

namespace tendril::combination {
namespace {

using List = RawValue::List;

class PartsWithEverySolver : public testing::TestWithParam<std::string> {
 protected:
  Plan planned(Scene made) const {
    made.solver.plugin = GetParam();
    return plan(made);
  }
};

/// Replaces a convex polygon by the triangles between its middle and its sides.
void cut_by_hand(ObstacleSpec& obstacle) {
  const List corners = std::get<List>(obstacle.options.at("vertices").value);
  const auto millimetres = [&](std::size_t corner, std::size_t axis) {
    return std::stod(std::get<std::string>(std::get<List>(corners[corner].value)[axis].value));
  };
  double x = 0.0;
  double y = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    x += millimetres(i, 0) / static_cast<double>(corners.size());
    y += millimetres(i, 1) / static_cast<double>(corners.size());
  }
  const RawValue middle{List{{std::to_string(x) + " mm"}, {std::to_string(y) + " mm"}}};
  List vertices;
  List sizes;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    vertices.push_back(middle);
    vertices.push_back(corners[i]);
    vertices.push_back(corners[(i + 1) % corners.size()]);
    sizes.push_back({std::int64_t{3}});
  }
  obstacle.options["vertices"] = {vertices};
  obstacle.options["outlines"] = {sizes};
}

TEST_P(PartsWithEverySolver, AConvexBodyCutByHandGivesTheSamePlan) {
  const Scene whole = scene("ledge");
  Scene cut = whole;
  ASSERT_EQ(cut.obstacles[0].shape, "polygon");
  cut_by_hand(cut.obstacles[0]);
  const Plan a = planned(whole);
  const Plan b = planned(cut);
  ASSERT_TRUE(certified(a));
  ASSERT_TRUE(certified(b));
  const double length = whole.rod.length();
  EXPECT_NEAR(a.tip_x / length, b.tip_x / length, 1e-10);
  EXPECT_NEAR(a.tip_y / length, b.tip_y / length, 1e-10);
  EXPECT_NEAR(a.tip_angle, b.tip_angle, 1e-10);
  EXPECT_NEAR(a.objective, b.objective, 1e-10 * std::abs(a.objective));
  EXPECT_NEAR(a.moments[0], b.moments[0], 1e-10 * std::abs(a.moments[0]));
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(b.contacts[i].obstacle_name, a.contacts[i].obstacle_name);
    EXPECT_NEAR(a.contacts[i].arc_length / length, b.contacts[i].arc_length / length, 1e-10);
    EXPECT_NEAR(a.contacts[i].force, b.contacts[i].force, 1e-10 * std::max(1.0, a.contacts[i].force));
  }
}

/// Squares of 6 mm, grown by 5 mm, around points in mm; as one polygon.
ObstacleSpec squares(const std::string& name, const std::vector<Vec2>& centers) {
  List vertices;
  List sizes;
  for (const Vec2 c : centers) {
    for (const Vec2 corner : {Vec2{-3, -3}, Vec2{3, -3}, Vec2{3, 3}, Vec2{-3, 3}}) {
      vertices.push_back({List{{1e-3 * (c.x + corner.x)}, {1e-3 * (c.y + corner.y)}}});
    }
    sizes.push_back({std::int64_t{4}});
  }
  return {name, "polygon", {{"vertices", {vertices}}, {"outlines", {sizes}}, {"rounding", {5e-3}}}};
}

TEST_P(PartsWithEverySolver, TwoPlacesOfOneBodyHoldAnArmAsTwoBodiesDo) {
  Scene apart = scene("two_pegs");
  Scene together = apart;
  apart.obstacles = {squares("lower", {{60.0, 0.0}}), squares("upper", {{80.0, 26.0}})};
  together.obstacles = {squares("both", {{60.0, 0.0}, {80.0, 26.0}})};
  const Plan a = planned(apart);
  const Plan b = planned(together);
  ASSERT_TRUE(certified(a));
  ASSERT_TRUE(certified(b));
  EXPECT_NEAR(a.objective, b.objective, 1e-8 * std::abs(a.objective));
  ASSERT_EQ(a.contacts.size(), 2U);
  ASSERT_EQ(b.contacts.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(b.contacts[i].at_tip);
    EXPECT_EQ(b.contacts[i].obstacle_name, "both");
    EXPECT_GT(b.contacts[i].force, 1e-3);
    EXPECT_NEAR(a.contacts[i].arc_length, b.contacts[i].arc_length, 1e-7 * apart.rod.length());
    EXPECT_NEAR(a.contacts[i].force, b.contacts[i].force, 1e-6 * a.contacts[i].force);
  }
}

/// An arm that reaches through the window of a frame, which is one body with the outline of a C.
std::string window(double side) {
  const auto point = [&](double x, double y) {
    return "[\"" + std::to_string(x) + " mm\", \"" + std::to_string(side * y) + " mm\"]";
  };
  return R"(
[rod]
length = "200 mm"
bending_stiffness = "5e-4 N m^2"
[[rod.actuator]]
to = "100 mm"
limit = "20 N mm"
[[rod.actuator]]
from = "100 mm"
limit = "20 N mm"
[[obstacle]]
name = "frame"
shape = "polygon"
rounding = "1 mm"
vertices = [)" +
         point(90, 36) + ", " + point(110, 36) + ", " + point(110, 80) + ", " + point(-40, 80) + ", " +
         point(-40, -80) + ", " + point(110, -80) + ", " + point(110, 28) + ", " + point(90, 28) + ", " +
         point(90, -60) + ", " + point(-20, -60) + ", " + point(-20, 60) + ", " + point(90, 60) + R"(]
[contact]
max_force = "2 N"
[target]
position = ["175 mm", ")" +
         std::to_string(20.0 * side) + R"( mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
)";
}

TEST_P(PartsWithEverySolver, AnArmReachesThroughAWindowAndItsMirrorImageToo) {
  const Plan a = planned(scene_from_text(window(1.0)));
  const Plan b = planned(scene_from_text(window(-1.0)));
  ASSERT_TRUE(certified(a));
  ASSERT_TRUE(certified(b));
  // As through two separate walls: a local search from the straight start ends far above.
  EXPECT_LT(a.objective, 0.55);
  EXPECT_NEAR(a.objective, b.objective, 1e-8 * a.objective);
  EXPECT_NEAR(a.tip_x, b.tip_x, 1e-8);
  EXPECT_NEAR(a.tip_y, -b.tip_y, 1e-8);
  for (const PlannedContact& c : a.contacts) EXPECT_EQ(c.obstacle_name, "frame");
}

// Executed, 12 N mm hold the rod on two sides of the pipe with its tip at the target. From the start the other wall is
// nearer, 15 mm away; which wall is touched is no way of its own.
TEST_P(PartsWithEverySolver, TheOtherWallOfAPipeIsFound) {
  const Scene pipe = scene("pipe");
  const Plan found = planned(pipe);
  ASSERT_TRUE(certified(found));
  EXPECT_LT(*found.target_error, 0.01 * pipe.rod.length());
}

INSTANTIATE_TEST_SUITE_P(Solvers, PartsWithEverySolver, testing::ValuesIn(registry().names(ComponentKind::solver)),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace tendril::combination
