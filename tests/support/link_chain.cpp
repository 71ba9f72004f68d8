#include "support/link_chain.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "support/chain_surface.hpp"

namespace tendril::support {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A torsion spring between neighbouring unknowns, with the moments of the actuators that span it.
struct Spring {
  double stiffness = 0.0;
  double rest = 0.0;    ///< rest angle
  double moment = 0.0;  ///< mean actuator moment, weighted with the compliance
};

/// Unknowns: the angle of each link, which is that of the rod at the link's middle, and the tip's angle. Springs act
/// between neighbours and, at the base, against the clamp, so the first and the last are half as long.
class Chain {
 public:
  Chain(const RodBvp& rod, const std::vector<double>& moments, const std::vector<BvpContact>& obstacles, int links,
        const std::vector<PointForce>& forces)
      : rod_(rod), obstacles_(obstacles), n_(links), link_(rod.length() / links) {
    if (links < 2) throw BvpError("at least two links are needed");
    if (moments.size() != rod.actuators.size()) throw BvpError("one moment per actuator is needed");
    for (Index i = 0; i <= n_; ++i) springs_.push_back(spring(middle(i - 1), middle(i), moments));
    lay_loads(forces);
    multipliers_.assign(obstacles.size(), std::vector<double>(static_cast<std::size_t>(n_), 0.0));
  }

  Index size() const { return n_ + 1; }
  /// Arc length of unknown i; -1 is the clamp.
  double middle(Index i) const {
    if (i < 0) return 0.0;
    return i >= n_ ? rod_.length() : (static_cast<double>(i) + 0.5) * link_;
  }

  std::vector<Point> joints(const VectorXd& angle) const {
    std::vector<Point> out{rod_.base};
    for (Index i = 0; i < n_; ++i) {
      const Point t = direction(angle[i]);
      out.push_back({out.back().x + link_ * t.x, out.back().y + link_ * t.y});
    }
    return out;
  }

  /// Energy, augmented by the obstacles' multipliers and the penalty.
  double energy(const VectorXd& angle) const;
  void derivatives(const VectorXd& angle, bool with_obstacles, VectorXd& gradient, MatrixXd& hessian) const;
  MatrixXd bending_hessian() const;
  void minimize(VectorXd& angle) const;
  /// First-order update of the multipliers; returns the largest violation of gap >= 0 and of complementarity.
  double update_multipliers(const VectorXd& angle);
  void raise_penalty() { penalty_ *= 10.0; }
  double force(std::size_t obstacle, Index joint) const {
    return multipliers_[obstacle][static_cast<std::size_t>(joint - 1)];
  }

 private:
  Spring spring(double a, double b, const std::vector<double>& moments) const;
  void lay_loads(const std::vector<PointForce>& forces);
  double pressure(std::size_t k, Index joint, double gap) const { return force(k, joint) - penalty_ * gap; }

  RodBvp rod_;
  std::vector<BvpContact> obstacles_;
  Index n_;
  double link_;
  double penalty_ = 0.0;
  std::vector<Spring> springs_;
  std::vector<Point> pull_;  ///< per link: dead force that turns it, times the link's length
  std::vector<std::vector<double>> multipliers_;
};

Spring Chain::spring(double a, double b, const std::vector<double>& moments) const {
  double compliance = 0.0;
  double rest = 0.0;
  double turned_by_moment = 0.0;
  double begin = 0.0;
  for (const RodSection& s : rod_.sections) {
    const double lo = std::max(a, begin);
    const double hi = std::min(b, begin + s.length);
    if (hi > lo) {
      compliance += (hi - lo) / s.stiffness;
      rest += (hi - lo) * s.rest_curvature;
      for (std::size_t j = 0; j < moments.size(); ++j) {
        const double overlap = std::min(hi, rod_.actuators[j].to) - std::max(lo, rod_.actuators[j].from);
        if (overlap > 0.0) turned_by_moment += moments[j] * overlap / s.stiffness;
      }
    }
    begin += s.length;
  }
  return {1.0 / compliance, rest, turned_by_moment / compliance};
}

void Chain::lay_loads(const std::vector<PointForce>& forces) {
  pull_.assign(static_cast<std::size_t>(n_), Point{});
  // A force at arc length s turns every link before s fully and the link under it by the part before s.
  const auto add = [&](double s, Point f) {
    for (Index i = 0; i < n_; ++i) {
      const double part = std::clamp(s - static_cast<double>(i) * link_, 0.0, link_);
      pull_[static_cast<std::size_t>(i)].x += part * f.x;
      pull_[static_cast<std::size_t>(i)].y += part * f.y;
    }
  };
  add(rod_.length(),
      {rod_.tip_force.x + rod_.payload * rod_.gravity.x, rod_.tip_force.y + rod_.payload * rod_.gravity.y});
  for (const PointForce& f : forces) add(f.arc_length, f.force);
  double begin = 0.0;
  for (const RodSection& section : rod_.sections) {
    for (Index i = 0; i < n_; ++i) {
      const double lo = std::max(begin, static_cast<double>(i) * link_);
      const double hi = std::min(begin + section.length, static_cast<double>(i + 1) * link_);
      if (hi <= lo) continue;
      const double mass = section.density * (hi - lo);
      add(0.5 * (lo + hi), {mass * rod_.gravity.x, mass * rod_.gravity.y});
    }
    begin += section.length;
  }
  double stiffness = rod_.sections[0].stiffness;
  for (const RodSection& s : rod_.sections) stiffness = std::max(stiffness, s.stiffness);
  // Large against the rod's own stiffness at the tip, 3 EI / L^3, so that the multipliers settle in a few rounds.
  penalty_ = 1e4 * stiffness / std::pow(rod_.length(), 3);
}

double Chain::energy(const VectorXd& angle) const {
  double e = 0.0;
  for (Index i = 0; i < size(); ++i) {
    const Spring& s = springs_[static_cast<std::size_t>(i)];
    const double turn = angle[i] - (i > 0 ? angle[i - 1] : rod_.base_angle);
    e += 0.5 * s.stiffness * (turn - s.rest) * (turn - s.rest) - s.moment * turn;
  }
  for (Index i = 0; i < n_; ++i) e -= dot(pull_[static_cast<std::size_t>(i)], direction(angle[i]));
  if (obstacles_.empty()) return e;
  const std::vector<Point> p = joints(angle);
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    for (Index j = 1; j <= n_; ++j) {
      const double f = pressure(k, j, surface(obstacles_[k], p[static_cast<std::size_t>(j)]).gap);
      if (f > 0.0) e += 0.5 * f * f / penalty_;
    }
  }
  return e;
}

void Chain::derivatives(const VectorXd& angle, bool with_obstacles, VectorXd& gradient, MatrixXd& hessian) const {
  gradient.setZero(size());
  hessian = bending_hessian();
  for (Index i = 0; i < size(); ++i) {
    const Spring& s = springs_[static_cast<std::size_t>(i)];
    const double turn = angle[i] - (i > 0 ? angle[i - 1] : rod_.base_angle);
    const double moment = s.stiffness * (turn - s.rest) - s.moment;
    gradient[i] += moment;
    if (i > 0) gradient[i - 1] -= moment;
  }
  for (Index i = 0; i < n_; ++i) {
    const Point t = direction(angle[i]);
    gradient[i] -= dot(pull_[static_cast<std::size_t>(i)], turned(t));
    hessian(i, i) += dot(pull_[static_cast<std::size_t>(i)], t);
  }
  if (!with_obstacles || obstacles_.empty()) return;
  const std::vector<Point> p = joints(angle);
  VectorXd along_normal(n_), along_tangent(n_);
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    for (Index j = 1; j <= n_; ++j) {
      const ChainSurface o = surface(obstacles_[k], p[static_cast<std::size_t>(j)]);
      const double f = pressure(k, j, o.gap);
      if (f <= 0.0) continue;
      for (Index i = 0; i < j; ++i) {
        const Point t = direction(angle[i]);
        along_normal[i] = link_ * dot(o.normal, turned(t));
        along_tangent[i] = link_ * dot(turned(o.normal), turned(t));
        hessian(i, i) += f * link_ * dot(o.normal, t);
      }
      gradient.head(j) -= f * along_normal.head(j);
      hessian.topLeftCorner(j, j) += penalty_ * along_normal.head(j) * along_normal.head(j).transpose() -
                                     f * o.curvature * along_tangent.head(j) * along_tangent.head(j).transpose();
    }
  }
}

MatrixXd Chain::bending_hessian() const {
  MatrixXd k = MatrixXd::Zero(size(), size());
  for (Index i = 0; i < size(); ++i) {
    const double c = springs_[static_cast<std::size_t>(i)].stiffness;
    k(i, i) += c;
    if (i == 0) continue;
    k(i - 1, i - 1) += c;
    k(i, i - 1) -= c;
    k(i - 1, i) -= c;
  }
  return k;
}

void Chain::minimize(VectorXd& angle) const {
  VectorXd gradient;
  MatrixXd hessian;
  const MatrixXd bending = bending_hessian();
  const double unit = rod_.sections[0].stiffness / rod_.length();
  for (int iteration = 0; iteration < 300; ++iteration) {
    derivatives(angle, true, gradient, hessian);
    // Rounding of the springs' moments, EI/h each, sets this floor.
    if (gradient.cwiseAbs().maxCoeff() <= 1e-11 * unit * static_cast<double>(n_)) return;
    Eigen::LLT<MatrixXd> llt(hessian);
    for (double shift = 0.03; llt.info() != Eigen::Success; shift *= 3.0) llt.compute(hessian + shift * bending);
    VectorXd step = -llt.solve(gradient);
    const double longest = step.cwiseAbs().maxCoeff();
    if (longest > 0.5) step *= 0.5 / longest;
    const double before = energy(angle);
    const double slope = gradient.dot(step);
    double fraction = 1.0;
    // The last steps change the energy by less than its rounding.
    const double rounding = 1e-13 * (std::abs(before) + unit);
    while (energy(angle + fraction * step) > before + 1e-4 * fraction * slope + rounding) {
      fraction *= 0.5;
      if (fraction < 1e-8) throw BvpError("the link chain's line search failed");
    }
    angle += fraction * step;
  }
  throw BvpError("the link chain did not settle");
}

double Chain::update_multipliers(const VectorXd& angle) {
  const std::vector<Point> p = joints(angle);
  double violation = 0.0;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    for (Index j = 1; j <= n_; ++j) {
      const double gap = surface(obstacles_[k], p[static_cast<std::size_t>(j)]).gap;
      const double f = std::max(0.0, pressure(k, j, gap));
      violation = std::max({violation, -gap, f > 0.0 ? std::abs(gap) : 0.0});
      multipliers_[k][static_cast<std::size_t>(j - 1)] = f;
    }
  }
  return violation;
}

}  // namespace

LinkChainSolution settle(const RodBvp& rod, const std::vector<double>& moments,
                         const std::vector<BvpContact>& obstacles, const LinkChainOptions& options) {
  Chain chain(rod, moments, obstacles, options.links, options.forces);
  VectorXd angle(chain.size());
  for (Index i = 0; i < chain.size(); ++i) {
    const double s = chain.middle(i);
    angle[i] = options.angle ? options.angle(s) : rod.base_angle + options.curvature * s;
  }
  chain.minimize(angle);
  // Far below the chain's own error of about 1e-5 L.
  const double tolerance = 1e-9 * rod.length();
  double violation = chain.update_multipliers(angle);
  for (int round = 0; violation > tolerance; ++round) {
    if (round == 60) throw BvpError("the link chain's contact forces did not settle");
    chain.minimize(angle);
    const double next = chain.update_multipliers(angle);
    if (next > 0.25 * violation && round % 4 == 3 && round < 16) chain.raise_penalty();
    violation = next;
  }

  LinkChainSolution out;
  out.joints = chain.joints(angle);
  out.tip_x = out.joints.back().x;
  out.tip_y = out.joints.back().y;
  out.tip_angle = angle[chain.size() - 1];
  out.angles.assign(angle.data(), angle.data() + chain.size() - 1);
  VectorXd gradient;
  MatrixXd hessian;
  chain.derivatives(angle, true, gradient, hessian);
  out.gradient = gradient.cwiseAbs().maxCoeff();
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    ChainContact c;
    Point sum{};
    double total = 0.0;
    for (std::size_t j = 1; j < out.joints.size(); ++j) {
      const ChainSurface o = surface(obstacles[k], out.joints[j]);
      out.penetration = std::max(out.penetration, -o.gap);
      const double f = chain.force(k, static_cast<Index>(j));
      if (f <= 0.0) continue;
      ++c.joints;
      total += f;
      sum.x += f * o.normal.x;
      sum.y += f * o.normal.y;
      c.arc_length += f * static_cast<double>(j) * rod.length() / options.links;
    }
    c.force = std::hypot(sum.x, sum.y);
    if (c.joints > 0) {
      c.direction = {sum.x / c.force, sum.y / c.force};
      c.arc_length /= total;
    }
    out.contacts.push_back(c);
  }
  return out;
}

double stability_margin(const RodBvp& rod, const std::vector<double>& moments, const LinkChainSolution& at) {
  const Chain chain(rod, moments, {}, static_cast<int>(at.angles.size()), {});
  VectorXd angle(chain.size());
  std::copy(at.angles.begin(), at.angles.end(), angle.data());
  angle[chain.size() - 1] = at.tip_angle;
  VectorXd gradient;
  MatrixXd hessian;
  chain.derivatives(angle, false, gradient, hessian);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(hessian, chain.bending_hessian(),
                                                                 Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0];
}

}  // namespace tendril::support
