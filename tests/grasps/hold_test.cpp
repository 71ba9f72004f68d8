// What contacts with friction can hold, against the same sets made from their corners.

#include "grasp/hold.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "combination/support.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

struct Wrench {
  double x = 0.0, y = 0.0, moment = 0.0;
};

/// Of every choice of one corner of each contact's triangle of forces.
std::vector<Wrench> corner_wrenches(const std::vector<Pad>& pads, double friction, Vec2 load) {
  std::vector<Wrench> all{{load.x, load.y, 0.0}};
  for (const Pad& pad : pads) {
    std::vector<Wrench> next = all;
    for (const double side : {-1.0, 1.0}) {
      const double f = pad.limit;
      const double t = side * friction * f;
      // -(f n + t tau) at n, tau the normal turned to the left.
      const Wrench of{-f * pad.normal.x + t * pad.normal.y, -f * pad.normal.y - t * pad.normal.x, -t};
      for (const Wrench& w : all) next.push_back({w.x + of.x, w.y + of.y, w.moment + of.moment});
    }
    all = std::move(next);
  }
  return all;
}

std::vector<Vec2> hull(std::vector<Vec2> points) {
  if (points.size() < 3) return {};
  std::sort(points.begin(), points.end(), [](Vec2 a, Vec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<Vec2> line;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t begin = line.size();
    for (const Vec2 p : points) {
      while (line.size() >= begin + 2 && cross(line.back() - line[line.size() - 2], p - line.back()) <= 0.0)
        line.pop_back();
      line.push_back(p);
    }
    line.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return line;
}

/// The forces that contacts and load can leave beside a moment: of a convex set every cut is the hull of where lines
/// between its corners go through.
std::vector<Vec2> cut(const std::vector<Wrench>& corners, double moment) {
  std::vector<Vec2> points;
  for (const Wrench& a : corners) {
    for (const Wrench& b : corners) {
      if (!(a.moment <= moment && b.moment >= moment && b.moment > a.moment)) continue;
      const double share = (moment - a.moment) / (b.moment - a.moment);
      points.push_back({a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)});
    }
  }
  return hull(points);
}

/// How far a convex area reaches from 0 along a direction; negative: 0 lies outside.
double reach(const std::vector<Vec2>& area, Vec2 direction) {
  if (area.size() < 3) return -1.0;
  double most = infinity;
  for (std::size_t i = 0; i < area.size(); ++i) {
    const Vec2 out = turned_back(area[(i + 1) % area.size()] - area[i]);
    const double room = dot(out, area[i]);
    if (room < 0.0) return -1.0;
    if (dot(out, direction) > 0.0) most = std::min(most, room / dot(out, direction));
  }
  return most;
}

struct Drawn {
  std::vector<Pad> pads;
  double friction = 0.0;
  Vec2 load{};
};

Drawn drawn(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Drawn out;
  const int count = 2 + static_cast<int>(3.0 * share(random));
  for (int k = 0; k < count; ++k) {
    const double angle = 2.0 * std::numbers::pi * share(random);
    out.pads.push_back({{std::cos(angle), std::sin(angle)}, 0.3 + share(random)});
  }
  out.friction = std::pow(10.0, 1.5 * share(random) - 1.0);
  out.load = {0.3 * (share(random) - 0.5), 0.3 * (share(random) - 0.5)};
  return out;
}

TEST(GraspHold, IsWhatTheCornersOfTheConesGive) {
  std::mt19937 random(7);
  int held = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto [pads, friction, load] = drawn(random);
    const HeldDisturbances found(pads, friction, load);
    const std::vector<Wrench> corners = corner_wrenches(pads, friction, load);
    // A disturbance is held where contacts and load can leave its opposite.
    const std::vector<Vec2> forces = cut(corners, 0.0);
    const bool holds = reach(forces, {1.0, 0.0}) >= 0.0;
    ASSERT_EQ(found.holds_load(), holds) << trial;
    if (!holds) {
      EXPECT_EQ(found.along({1.0, 0.0}), 0.0);
      EXPECT_EQ(norm(found.breaking_force()), 0.0);
      EXPECT_TRUE(found.corners().empty());
      continue;
    }
    ++held;
    double least = infinity;
    for (int i = 0; i < 720; ++i) {
      const double angle = std::numbers::pi * i / 360.0;
      const Vec2 direction{std::cos(angle), std::sin(angle)};
      const double expected = reach(forces, -direction);
      ASSERT_NEAR(found.along(direction), expected, 1e-9) << trial << " at " << angle;
      least = std::min(least, expected);
    }
    const Vec2 breaking = found.breaking_force();
    EXPECT_LE(norm(breaking), least + 1e-12);
    EXPECT_GE(norm(breaking), least * std::cos(std::numbers::pi / 720.0) - 1e-9);
    if (norm(breaking) > 1e-6) {
      EXPECT_NEAR(found.along(1.0 / norm(breaking) * breaking), norm(breaking), 1e-9);
    }
    for (const Vec2 corner : found.corners()) {
      if (norm(corner) > 1e-6) {
        EXPECT_NEAR(found.along(1.0 / norm(corner) * corner), norm(corner), 1e-9);
      }
    }
    for (const double sign : {1.0, -1.0}) {
      double low = 0.0;
      double high = 10.0;
      while (high - low > 1e-10) {
        const double middle = 0.5 * (low + high);
        const std::vector<Vec2> area = cut(corners, -sign * middle);
        (reach(area, {1.0, 0.0}) >= 0.0 ? low : high) = middle;
      }
      EXPECT_NEAR(found.moment(sign), low, 1e-8) << trial;
    }
  }
  EXPECT_GT(held, 80);
}

TEST(GraspHold, ClosesAboveTheFrictionThatItTells) {
  std::mt19937 random(11);
  int bounded = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Drawn one = drawn(random);
    std::vector<Vec2> normals;
    for (const Pad& pad : one.pads) normals.push_back(pad.normal);
    const double least = closure_friction(normals);
    const auto closes = [&](double friction) {
      const HeldDisturbances held(one.pads, friction, {});
      return norm(held.breaking_force()) > 1e-9 && held.moment(1.0) > 1e-9 && held.moment(-1.0) > 1e-9;
    };
    if (least == 0.0) {
      EXPECT_TRUE(closes(0.05)) << trial;
      continue;
    }
    ++bounded;
    EXPECT_TRUE(closes(1.01 * least)) << trial << ": " << least;
    EXPECT_FALSE(closes(0.99 * least)) << trial << ": " << least;
  }
  EXPECT_GT(bounded, 100);
}

// Contacts straight across hold twice their friction along the line between their sides, and along their own line as
// much as one of them may press.
TEST(GraspHold, OfOppositeContactsIsAClosedForm) {
  const double mu = 0.3;
  const HeldDisturbances held({{{0.0, 1.0}, 1.0}, {{0.0, -1.0}, 1.0}}, mu, {});
  EXPECT_EQ(closure_friction({{0.0, 1.0}, {0.0, -1.0}}), 0.0);
  EXPECT_NEAR(held.along({1.0, 0.0}), 2.0 * mu, 1e-12);
  EXPECT_NEAR(held.along({0.0, 1.0}), 1.0, 1e-12);
  EXPECT_NEAR(held.moment(1.0), 2.0 * mu, 1e-12);
  EXPECT_NEAR(norm(held.breaking_force()), 2.0 * mu / std::sqrt(1.0 + 4.0 * mu * mu), 1e-12);
  const HeldDisturbances loaded({{{0.0, 1.0}, 1.0}, {{0.0, -1.0}, 1.0}}, mu, {0.5, 0.0});
  EXPECT_NEAR(loaded.along({1.0, 0.0}), 2.0 * mu - 0.5, 1e-12);
  EXPECT_NEAR(loaded.along({-1.0, 0.0}), 2.0 * mu + 0.5, 1e-12);
  EXPECT_FALSE(HeldDisturbances({{{0.0, 1.0}, 1.0}, {{0.0, -1.0}, 1.0}}, mu, {0.7, 0.0}).holds_load());
}

// By the definition: contacts of the plan hold the object with the force of its lift, or its weight in any direction.
TEST(GraspHold, TellsHowTheObjectMayBeLifted) {
  Scene scene = combination::scene("grasp_60mm");
  scene.contact.friction = 0.3;
  const Plan unloaded = combination::plan(scene);
  EXPECT_FALSE(lift_of(scene, *unloaded.grasp));
  scene.gravity = Vec2{3.0, -9.0};
  scene.gripper->object_mass = 0.05;
  scene.gripper->object_force = {0.1, 0.05};
  scene.contact.friction_state = FrictionState::any;
  const Plan plan = combination::plan(scene);
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  const std::optional<GraspLift> lift = lift_of(scene, *plan.grasp);
  ASSERT_TRUE(lift);
  std::vector<Pad> pads;
  for (const PlannedContact& c : plan.contacts) pads.push_back({c.normal, scene.contact.max_force});
  ASSERT_TRUE(plan.grasp->lower);
  for (const PlannedContact& c : plan.grasp->lower->contacts) pads.push_back({c.normal, scene.contact.max_force});
  const auto holds = [&](double mass, Vec2 gravity) {
    return HeldDisturbances(pads, 0.3, scene.gripper->object_force + mass * gravity).holds_load();
  };
  const double g = norm(*scene.gravity);
  for (const double share : {-1e-6, 1e-6}) {
    const Vec2 lifted = (1.0 + (1.0 + share) * lift->acceleration / g) * *scene.gravity;
    EXPECT_EQ(holds(scene.gripper->object_mass, lifted), share < 0.0);
    bool always = true;
    for (int i = 0; i < 7200; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 7200;
      always = always && holds((1.0 + share) * lift->heaviest_turned, {g * std::cos(angle), g * std::sin(angle)});
    }
    EXPECT_EQ(always, share < 0.0);
  }
}

TEST(GraspHold, IsToldOfAPlanWithFriction) {
  Scene scene = combination::scene("grasp_60mm");
  const Plan without = combination::plan(scene);
  scene.contact.friction = 0.3;
  const Plan plan = combination::plan(scene);
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  EXPECT_EQ(plan.moments, without.moments);
  EXPECT_FALSE(without.grasp->hold);
  ASSERT_TRUE(plan.grasp->hold);
  const GraspHold& hold = *plan.grasp->hold;
  EXPECT_TRUE(hold.closure);
  EXPECT_NEAR(hold.closure_friction, 0.0, 1e-6);
  const double force = scene.contact.max_force;
  EXPECT_NEAR(hold.largest_moment, 2.0 * 0.3 * force * plan.grasp->object_radius, 1e-6);
  EXPECT_NEAR(hold.least_moment, -hold.largest_moment, 1e-9);
  double right = 0.0;
  for (const Vec2 corner : hold.held_forces) right = std::max(right, corner.x);
  EXPECT_NEAR(right, 2.0 * 0.3 * force, 1e-6);
}

}  // namespace
}  // namespace tendril
