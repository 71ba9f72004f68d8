// A start that is given by points along it.

#include <cmath>

#include "combination/support.hpp"
#include "support/contains.hpp"
#include "tendril/error.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

Scene along(const std::vector<Vec2>& points) {
  Scene made = scene("brace", {"start.tip_angle=0"});
  made.effort = SearchEffort::fast;
  made.start_points = points;
  return made;
}

/// A circular arc from the scene's base, which points along x.
std::vector<Vec2> arc(double length, double turn, int count) {
  std::vector<Vec2> points;
  for (int i = 1; i <= count; ++i) {
    const double angle = turn * i / count;
    points.push_back({length / turn * std::sin(angle), length / turn * (1.0 - std::cos(angle))});
  }
  return points;
}

TEST(StartPoints, LeadTheSearchToTheirSideOfTheObstacle) {
  const Plan above = combination::plan(along(arc(0.1, 0.8, 9)));
  const Plan below = combination::plan(along(arc(0.1, -0.8, 9)));
  ASSERT_TRUE(certified(above));
  ASSERT_TRUE(certified(below));
  EXPECT_LT(above.objective, 0.01);
  EXPECT_GT(below.objective, 1.0);
}

TEST(StartPoints, AreFollowedByTheStart) {
  const std::vector<Vec2> points = arc(0.1, 1.2, 12);
  const Plan plan = combination::plan(along(points));
  ASSERT_FALSE(plan.start_backbone.empty());
  const BackbonePoint& tip = plan.start_backbone.back();
  EXPECT_NEAR(tip.x, points.back().x, 2e-3);
  EXPECT_NEAR(tip.y, points.back().y, 2e-3);
  EXPECT_NEAR(tip.angle, 1.2, 0.05);
}

// A picture's polygon is shorter than the rod that it shows.
TEST(StartPoints, NeedNotBeAsFarApartAsTheRodIsLong) {
  const Plan few = combination::plan(along(arc(0.1, 0.8, 3)));
  const Plan larger = combination::plan(along(arc(0.2, 0.8, 9)));
  for (const Plan& plan : {few, larger}) {
    ASSERT_TRUE(certified(plan));
    EXPECT_LT(plan.objective, 0.01);
  }
}

TEST(StartPoints, AreRefusedWhereTheySayNothing) {
  const auto refused = [](const std::vector<Vec2>& points) {
    try {
      (void)combination::plan(along(points));
    } catch (const SceneError& e) {
      return e.path() + ": " + e.what();
    }
    return std::string("planned");
  };
  EXPECT_TRUE(contains_text(refused({{NAN, 0.0}}), "start.points"));
  const Vec2 base = scene("brace").rod.base_position;
  EXPECT_TRUE(contains_text(refused({base, base}), "start.points"));
}

}  // namespace
}  // namespace tendril::search
