// Rods that lean on 200 random bodies, seldom convex: gaps and forces of the contacts against what dense points of the
// rod and the sides of the outline say by themselves.

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "execute_support.hpp"
#include "obstacle/part.hpp"
#include "support/random_outline.hpp"

namespace tendril::support {
namespace {

constexpr double rounding = 0.03;

/// A point of the plane seen from a rounded outline.
struct Seen {
  double distance = infinity;
  Vec2 normal{};
};

Seen seen_from(const std::vector<Vec2>& outline, Vec2 p) {
  Seen seen;
  double winding = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 a = outline[i] - p;
    const Vec2 b = outline[(i + 1) % outline.size()] - p;
    const Vec2 side = b - a;
    const Vec2 away = -(a + std::clamp(-dot(a, side) / dot(side, side), 0.0, 1.0) * side);
    if (norm(away) < seen.distance) seen = {norm(away), (1.0 / norm(away)) * away};
    winding += std::atan2(cross(a, b), dot(a, b));
  }
  if (std::abs(winding) > 3.0) seen = {-seen.distance, -seen.normal};
  seen.distance -= rounding;
  return seen;
}

/// Of the backbone between two of its samples, which tell points and directions.
Vec2 between(const BackbonePoint& a, const BackbonePoint& b, double share) {
  const double h = b.s - a.s;
  const double t = share;
  const Vec2 from{std::cos(a.angle), std::sin(a.angle)};
  const Vec2 to{std::cos(b.angle), std::sin(b.angle)};
  return (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t) * a.position() + h * t * (1.0 - t) * (1.0 - t) * from +
         t * t * (3.0 - 2.0 * t) * b.position() + h * t * t * (t - 1.0) * to;
}

double least_gap(const std::vector<Vec2>& outline, const Plan& plan) {
  double least = infinity;
  for (std::size_t i = 0; i + 1 < plan.backbone.size(); ++i) {
    for (int k = 0; k < 40; ++k) {
      const Vec2 p = between(plan.backbone[i], plan.backbone[i + 1], k / 40.0);
      least = std::min(least, seen_from(outline, p).distance);
    }
  }
  return std::min(least, seen_from(outline, plan.backbone.back().position()).distance);
}

/// The forces at the contacts' places that bend the rod as it is bent: at every point, the moment of all beyond it.
std::vector<Vec2> forces_by_bending(const Plan& plan, double moment) {
  const auto count = static_cast<Eigen::Index>(plan.contacts.size());
  const auto points = static_cast<Eigen::Index>(plan.backbone.size());
  Eigen::MatrixXd levers = Eigen::MatrixXd::Zero(points, 2 * count);
  Eigen::VectorXd bending(points);
  for (Eigen::Index i = 0; i < points; ++i) {
    const BackbonePoint& p = plan.backbone[static_cast<std::size_t>(i)];
    bending[i] = p.curvature - moment;
    for (Eigen::Index k = 0; k < count; ++k) {
      const PlannedContact& c = plan.contacts[static_cast<std::size_t>(k)];
      if (c.arc_length <= p.s) continue;
      const Vec2 lever = c.point - p.position();
      levers(i, 2 * k) = -lever.y;
      levers(i, 2 * k + 1) = lever.x;
    }
  }
  const Eigen::VectorXd solved = levers.colPivHouseholderQr().solve(bending);
  EXPECT_LT((levers * solved - bending).lpNorm<Eigen::Infinity>(), 1e-7);
  std::vector<Vec2> forces;
  for (Eigen::Index k = 0; k < count; ++k) forces.push_back({solved[2 * k], solved[2 * k + 1]});
  return forces;
}

TEST(ExecuteParts, GapsAndForcesAgreeWithDensePointsAndWithTheBending) {
  std::mt19937 random(24);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int touched = 0;
  int tried = 0;
  int several = 0;
  for (; touched < 200 && tried < 400; ++tried) {
    const double side = unit(random) < 0.5 ? 1.0 : -1.0;
    const std::vector<Vec2> outline =
        random_outline(random, {0.35 + 0.5 * unit(random), side * (0.2 + 0.2 * unit(random))}, 0.2);
    const double moment = side * (1.0 + 3.0 * unit(random));
    double free = infinity;
    for (int i = 0; i <= 200; ++i) free = std::min(free, seen_from(outline, {i / 200.0, 0.0}).distance);
    if (free < 0.01) continue;
    ForwardScene s;
    s.scene.obstacles.push_back({"part", "polygon"});
    s.obstacles.push_back(std::make_unique<Part>(std::vector<ClosedLine>{outline}, rounding));
    const Execution reached = s.run({moment});
    if (reached.result.status != PlanStatus::solved) continue;
    const Plan& plan = reached.result;
    SCOPED_TRACE(tried);
    EXPECT_NEAR(plan.certificate.penetration, 0.0, 1e-9);
    const double gap = least_gap(outline, plan);
    EXPECT_GT(gap, -1e-7);
    if (plan.contacts.empty()) continue;
    EXPECT_LT(gap, 1e-6);
    const std::vector<Vec2> forces = forces_by_bending(plan, moment);
    for (std::size_t k = 0; k < forces.size(); ++k) {
      const PlannedContact& c = plan.contacts[k];
      const Seen seen = seen_from(outline, c.point);
      EXPECT_NEAR(seen.distance, 0.0, 1e-9);
      EXPECT_NEAR(norm(seen.normal - c.normal), 0.0, 1e-8);
      EXPECT_NEAR(norm(forces[k] - c.force * seen.normal), 0.0, 1e-5 * (1.0 + c.force));
    }
    ++touched;
    if (forces.size() > 1) ++several;
  }
  EXPECT_EQ(touched, 200);
  EXPECT_GT(several, 5);
}

}  // namespace
}  // namespace tendril::support
