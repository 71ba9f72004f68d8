#include "support/rubbing_chain.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "support/chain_surface.hpp"

namespace tendril::support {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

RubbingChain::RubbingChain(std::vector<double> links, double curvature, double base_angle,
                           std::vector<RoughObstacle> obstacles)
    : n_(static_cast<Index>(links.size())),
      links_(std::move(links)),
      ends_{0.0},
      base_angle_(base_angle),
      obstacles_(std::move(obstacles)),
      angle_(n_ + 1) {
  for (const double length : links_) ends_.push_back(ends_.back() + length);
  for (Index i = 0; i <= n_; ++i) angle_[i] = base_angle + curvature * middle(i);
  before_ = joints();
}

/// Arc length of unknown i: the middle of a link, or the tip.
double RubbingChain::middle(Index i) const { return i < n_ ? ends_[static_cast<std::size_t>(i)] + 0.5 * link(i) : 1.0; }

std::vector<Point> RubbingChain::joints() const {
  std::vector<Point> out{Point{}};
  for (Index i = 0; i < n_; ++i) {
    const Point t = direction(angle_[i]);
    out.push_back({out.back().x + link(i) * t.x, out.back().y + link(i) * t.y});
  }
  return out;
}

Point RubbingChain::tip() const { return joints().back(); }

double RubbingChain::slid(const Touch& t, const std::vector<Point>& now) const {
  const RoughObstacle& o = obstacles_[t.obstacle];
  const Point a = t.from;
  const Point b = now[static_cast<std::size_t>(t.joint)];
  const Point normal = surface(o.shape, a).normal;
  if (o.shape.radius == 0.0) return dot({b.x - a.x, b.y - a.y}, turned(normal));
  const Point there = surface(o.shape, b).normal;
  return o.shape.radius * std::atan2(normal.x * there.y - normal.y * there.x, dot(normal, there));
}

/// Newton's method on the balance of moments of all links with the gaps and, where joints stick, what they slide.
void RubbingChain::solve(double moment, double weight) {
  std::vector<Index> sticking;
  for (std::size_t c = 0; c < touches_.size(); ++c) {
    if (!leads(c)) touches_[c].shear = 0.0;
    if (leads(c) && touches_[c].slips == 0) sticking.push_back(static_cast<Index>(c));
  }
  const Index angles = n_ + 1;
  const auto count = static_cast<Index>(touches_.size());
  const Index size = angles + count + static_cast<Index>(sticking.size());
  for (int iteration = 0; iteration < 60; ++iteration) {
    VectorXd residual = VectorXd::Zero(size);
    MatrixXd matrix = MatrixXd::Zero(size, size);
    for (Index i = 0; i < angles; ++i) {
      const double stiffness = 1.0 / (middle(i) - (i > 0 ? middle(i - 1) : 0.0));
      const double turn = angle_[i] - (i > 0 ? angle_[i - 1] : base_angle_);
      residual[i] += stiffness * turn - moment;
      matrix(i, i) += stiffness;
      if (i == 0) continue;
      residual[i - 1] -= stiffness * turn - moment;
      matrix(i - 1, i - 1) += stiffness;
      matrix(i, i - 1) -= stiffness;
      matrix(i - 1, i) -= stiffness;
    }
    for (Index i = 0; i < n_; ++i) {
      const Point t = direction(angle_[i]);
      const Point pull{0.0, -weight * link(i) * (1.0 - middle(i))};
      residual[i] -= dot(pull, turned(t));
      matrix(i, i) += dot(pull, t);
    }
    const std::vector<Point> p = joints();
    Index next = angles + count;
    for (Index c = 0; c < count; ++c) {
      const Touch& touch = touches_[static_cast<std::size_t>(c)];
      const RoughObstacle& o = obstacles_[touch.obstacle];
      const ChainSurface s = surface(o.shape, p[static_cast<std::size_t>(touch.joint)]);
      const Point tau = turned(s.normal);
      const double ratio = touch.slips * o.friction;
      const double shear = touch.slips != 0 ? ratio * touch.force : touch.shear;
      VectorXd along_normal = VectorXd::Zero(angles);
      VectorXd along_tangent = VectorXd::Zero(angles);
      for (Index i = 0; i < touch.joint; ++i) {
        const Point t = direction(angle_[i]);
        along_normal[i] = link(i) * dot(s.normal, turned(t));
        along_tangent[i] = link(i) * dot(tau, turned(t));
        matrix(i, i) += link(i) * (touch.force * dot(s.normal, t) + shear * dot(tau, t));
      }
      residual.head(angles) -= touch.force * along_normal + shear * along_tangent;
      matrix.topLeftCorner(angles, angles) +=
          s.curvature * (shear * along_normal - touch.force * along_tangent) * along_tangent.transpose();
      matrix.col(angles + c).head(angles) = -(along_normal + ratio * along_tangent);
      residual[angles + c] = s.gap;
      matrix.row(angles + c).head(angles) = along_normal.transpose();
      if (touch.slips != 0 || !leads(static_cast<std::size_t>(c))) continue;
      matrix.col(next).head(angles) = -along_tangent;
      residual[next] = slid(touch, p);
      matrix.row(next++).head(angles) = (1.0 - s.gap * s.curvature) * along_tangent.transpose();
    }
    const VectorXd step = -matrix.partialPivLu().solve(residual);
    if (!step.allFinite()) throw BvpError("the rubbing chain is singular");
    angle_ += step.head(angles);
    for (Index c = 0; c < count; ++c) touches_[static_cast<std::size_t>(c)].force += step[angles + c];
    for (std::size_t i = 0; i < sticking.size(); ++i) {
      touches_[static_cast<std::size_t>(sticking[i])].shear += step[angles + count + static_cast<Index>(i)];
    }
    if (step.head(angles).cwiseAbs().maxCoeff() < 1e-10) return;
  }
  throw BvpError("the rubbing chain did not settle");
}

bool RubbingChain::leads(std::size_t touch) const {
  if (touch == 0) return true;
  const Touch& before = touches_[touch - 1];
  return before.obstacle != touches_[touch].obstacle || before.joint + 1 != touches_[touch].joint;
}

bool RubbingChain::change_friction(std::size_t leader) {
  std::size_t end = leader + 1;
  while (end < touches_.size() && !leads(end)) ++end;
  double most = 0.0;
  for (std::size_t c = leader; c < end; ++c) most += obstacles_[touches_[c].obstacle].friction * touches_[c].force;
  Touch& first = touches_[leader];
  const bool gives = first.slips == 0 && std::abs(first.shear) > most + 1e-11;
  const bool holds = first.slips != 0 && first.slips * slid(first, joints()) > 1e-13;
  if (!gives && !holds) return false;
  if (holds) first.shear = first.slips * most;
  const int slips = holds ? 0 : first.shear > 0.0 ? 1 : -1;
  for (std::size_t c = leader; c < end; ++c) touches_[c].slips = slips;
  return true;
}

bool RubbingChain::change_touches() {
  const std::vector<Point> p = joints();
  for (std::size_t c = 0; c < touches_.size(); ++c) {
    if (!(touches_[c].force < -1e-12)) continue;
    touches_.erase(touches_.begin() + static_cast<std::ptrdiff_t>(c));
    return true;
  }
  double deepest = -1e-11;
  Touch made;
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    for (Index j = 1; j <= n_; ++j) {
      const double gap = surface(obstacles_[o].shape, p[static_cast<std::size_t>(j)]).gap;
      if (!(gap < deepest)) continue;
      deepest = gap;
      const Point a = before_[static_cast<std::size_t>(j)];
      const Point b = p[static_cast<std::size_t>(j)];
      const double above = std::max(0.0, surface(obstacles_[o].shape, a).gap);
      const double share = above / (above - gap);
      made = {j, o, {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)}};
    }
  }
  if (made.joint > 0) {
    const auto behind = std::find_if(touches_.begin(), touches_.end(), [&](const Touch& t) {
      return t.obstacle > made.obstacle || (t.obstacle == made.obstacle && t.joint > made.joint);
    });
    for (const Touch& t : touches_) {
      if (t.obstacle == made.obstacle && std::abs(t.joint - made.joint) == 1) made.slips = t.slips;
    }
    touches_.insert(behind, made);
    return true;
  }
  for (std::size_t c = 0; c < touches_.size(); ++c) {
    if (leads(c) && change_friction(c)) return true;
  }
  return false;
}

void RubbingChain::step(double moment, double weight) {
  before_ = joints();
  for (Touch& t : touches_) t.from = before_[static_cast<std::size_t>(t.joint)];
  solve(moment, weight);
  for (int change = 0; change_touches(); ++change) {
    if (change == 60) throw BvpError("what sticks and slips could not be found");
    solve(moment, weight);
  }
}

RubbingChain::Contact RubbingChain::contact(std::size_t obstacle) const {
  const std::vector<Point> p = joints();
  Contact c;
  c.slips = true;
  for (const Touch& t : touches_) {
    if (t.obstacle != obstacle) continue;
    const RoughObstacle& o = obstacles_[obstacle];
    const Point normal = surface(o.shape, p[static_cast<std::size_t>(t.joint)]).normal;
    const double along = dot(turned(normal), direction(angle_[t.joint])) < 0.0 ? -1.0 : 1.0;
    c.force += t.force;
    c.tangential += along * (t.slips != 0 ? t.slips * o.friction * t.force : t.shear);
    c.arc_length += t.force * ends_[static_cast<std::size_t>(t.joint)];
    c.slips = c.slips && t.slips != 0;
  }
  if (c.force > 0.0) c.arc_length /= c.force;
  return c;
}

}  // namespace tendril::support
