// The unknowns of the shooting and where they begin.

#include <algorithm>
#include <cmath>

#include "support/rod_shooting.hpp"

namespace tendril::support {

void Shooting::check(const BvpGuess& guess) const {
  if (moments_.size() != rod_.actuators.size()) throw BvpError("one moment per actuator is needed");
  if (guess.arc_lengths.size() != contacts_.size() || guess.forces.size() != contacts_.size()) {
    throw BvpError("one guessed arc length and force per contact are needed");
  }
  if (free_actuator_ && *free_actuator_ >= moments_.size()) throw BvpError("there is no such actuator");
  for (const RodSection& s : rod_.sections) {
    if (!(s.length > 0.0) || !(s.stiffness > 0.0)) throw BvpError("section lengths and stiffnesses must be positive");
  }
  for (const BvpContact& c : contacts_) {
    if (!is_wall(c) && !(c.radius > 0.0)) throw BvpError("radii must be positive");
  }
}

void Shooting::lay_out(const BvpGuess& guess) {
  const double length = rod_.length();
  std::vector<double> fixed{0.0, length};
  double end = 0.0;
  for (const RodSection& s : rod_.sections) fixed.push_back(std::min(end += s.length, length));
  for (const MomentSpan& a : rod_.actuators) {
    for (double p : {a.from, a.to}) {
      if (!(p >= 0.0) || p > length * (1.0 + 1e-12)) throw BvpError("an actuator ends outside the rod");
      fixed.push_back(std::min(p, length));
    }
  }
  std::sort(fixed.begin(), fixed.end());
  for (double p : fixed) {
    if (knots_.empty() || p - knots_.back().place > 1e-12 * length) knots_.push_back({p, {}});
  }
  arc_index_.assign(contacts_.size(), -1);
  force_index_.assign(contacts_.size(), -1);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].at_tip) continue;
    const double s = guess.arc_lengths[k];
    if (!(s > 0.0 && s < length)) throw BvpError("a guessed arc length lies outside the rod");
    for (const Knot& knot : knots_) {
      if (std::abs(knot.place - s) < 1e-9 * length) throw BvpError("a guessed arc length lies on another knot");
    }
    knots_.push_back({s, k});
    std::sort(knots_.begin(), knots_.end(), [](const Knot& a, const Knot& b) { return a.place < b.place; });
  }
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    const double a = knots_[k].place;
    const double b = knots_[k + 1].place;
    const double middle = 0.5 * (a + b);
    std::size_t section = 0;
    double section_end = rod_.sections[0].length;
    while (section_end < middle && section + 1 < rod_.sections.size()) section_end += rod_.sections[++section].length;
    Piece p;
    p.left = k;
    p.right = k + 1;
    p.count = static_cast<std::size_t>(std::max(1.0, std::ceil((b - a) / length * options_.intervals - 1e-9)));
    p.first = interval_count_;
    p.section = rod_.sections[section];
    for (const MomentSpan& span : rod_.actuators) p.spanned.push_back(span.from < middle && middle < span.to);
    interval_count_ += p.count;
    pieces_.push_back(p);
  }
  auto next = static_cast<Eigen::Index>(kStates * interval_count_);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!contacts_[k].at_tip) arc_index_[k] = next++;
    force_index_[k] = next++;
  }
  if (free_actuator_) moment_index_ = next++;
  unknowns_ = Eigen::VectorXd::Zero(next);
}

/// Every node gets the guessed angle, the point that follows from it, and the loads that follow from statics.
/// Integrating the moment from the tip keeps the start sensible where shooting from the base would run away.
void Shooting::start(const BvpGuess& guess) {
  const double length = rod_.length();
  const auto angle = [&](double s) { return guess.angle ? guess.angle(s) : rod_.base_angle + guess.curvature * s; };
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (arc_index_[k] >= 0) unknowns_[arc_index_[k]] = guess.arc_lengths[k];
    unknowns_[force_index_[k]] = guess.forces[k];
  }
  if (free_actuator_) unknowns_[moment_index_] = moments_[*free_actuator_];

  constexpr int kCuts = 8;
  double x = rod_.base.x;
  double y = rod_.base.y;
  for (const Piece& p : pieces_) {
    const double h = interval_length(p, unknowns_);
    for (std::size_t i = 0; i < p.count; ++i) {
      const double begin = place(p.left, unknowns_) + static_cast<double>(i) * h;
      const auto at = static_cast<Eigen::Index>(kStates * (p.first + i));
      unknowns_[at + kAngle] = angle(begin);
      unknowns_[at + kX] = x;
      unknowns_[at + kY] = y;
      for (int g = 0; g < kCuts; ++g) {
        const double a = angle(std::min(begin + (g + 0.5) * h / kCuts, length));
        x += std::cos(a) * h / kCuts;
        y += std::sin(a) * h / kCuts;
      }
    }
  }

  Point force{rod_.tip_force.x + rod_.payload * rod_.gravity.x, rod_.tip_force.y + rod_.payload * rod_.gravity.y};
  const auto add_contact = [&](std::size_t k, double px, double py) {
    const Surface<double> o = surface(contacts_[k], px, py);
    if (!std::isfinite(o.nx)) throw BvpError("the guessed rod passes through an obstacle's centre");
    force.x += unknowns_[force_index_[k]] * o.nx;
    force.y += unknowns_[force_index_[k]] * o.ny;
  };
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].at_tip) add_contact(k, x, y);
  }
  double moment = 0.0;
  for (std::size_t j = pieces_.size(); j-- > 0;) {
    const Piece& p = pieces_[j];
    const double h = interval_length(p, unknowns_);
    const Point weight = field(p, unknowns_).weight;
    for (std::size_t i = p.count; i-- > 0;) {
      const double begin = place(p.left, unknowns_) + static_cast<double>(i) * h;
      for (int g = kCuts - 1; g >= 0; --g) {
        const double a = angle(begin + (g + 0.5) * h / kCuts);
        const double fx = force.x + 0.5 * weight.x * h / kCuts;
        const double fy = force.y + 0.5 * weight.y * h / kCuts;
        moment += (std::cos(a) * fy - std::sin(a) * fx) * h / kCuts;
        force.x += weight.x * h / kCuts;
        force.y += weight.y * h / kCuts;
      }
      const auto at = static_cast<Eigen::Index>(kStates * (p.first + i));
      unknowns_[at + kMoment] = moment;
      unknowns_[at + kForceX] = force.x;
      unknowns_[at + kForceY] = force.y;
    }
    if (const auto k = knots_[p.left].contact) {
      const auto at = static_cast<Eigen::Index>(kStates * p.first);
      add_contact(*k, unknowns_[at + kX], unknowns_[at + kY]);
    }
  }
}

}  // namespace tendril::support
