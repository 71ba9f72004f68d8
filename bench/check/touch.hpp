#pragma once

#include <Eigen/Core>

#include "check/body.hpp"
#include "check/rod.hpp"
#include "tendril/geometry.hpp"

namespace tendril::bench {

/// A contact that the plan says it has.
struct Touch {
  std::size_t body = 0;
  bool at_tip = false;
  double s = 0.0, force = 0.0;
  double lean = 0.0;    ///< force along the turned normal, for each unit of `force`
  bool sticks = false;  ///< it holds the rod along its surface, too
  /// Beside a tiny obstacle: its flat side, or its round part, along which the rod's contact is followed.
  bool flat = false, followed = false;
  Vec2 normal{};           ///< of the flat side
  Vec2 core{};             ///< what the round part is round about
  double side = 1.0;       ///< 1 where the rod has it on its right, else -1
  double curvature = 0.0;  ///< of the rod, on the side with less sliding
  double convexity = 1.0;  ///< change of tangent . (point - core) along the rod
};

/// Where a contact holds the rod, and along what.
struct Hold {
  Vec2 at{}, normal{};
};

/// Finds out what is beside a contact of the shape at q, where the obstacle is tiny.
void look_beside(const Body& body, const RodShape& shape, const Eigen::VectorXd& q, Touch& touch);

/// The normal of the obstacle beside the contact, at a point near.
Vec2 normal_of(const Body& body, const Touch& touch, Vec2 at);

/// Where the contact is that is followed, once the rod's point at its arc length is `p`: it slides to the closest
/// point.
Hold followed_hold(const Touch& touch, const RodShape::Point& p);

}  // namespace tendril::bench
