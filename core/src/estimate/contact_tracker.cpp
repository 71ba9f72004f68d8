#include "estimate/contact_tracker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimate/significance.hpp"

namespace tendril {
namespace {

constexpr int most_steps_of_a_fit = 60;
/// Places at which a new contact is tried.
constexpr std::size_t most_tried = 3;

/// What is known of contacts of which some are those of `ahead`, in units of the points' deviation.
Belief belief_of(const ContactState& ahead, const std::vector<int>& before, double deviation) {
  const auto size = 2 * static_cast<Eigen::Index>(before.size());
  Belief out{Eigen::VectorXd::Zero(size), Eigen::MatrixXd::Zero(ahead.mean.size(), size)};
  const Eigen::LLT<Eigen::MatrixXd> factor(ahead.covariance);
  const Eigen::MatrixXd root =
      deviation * factor.matrixL().solve(Eigen::MatrixXd::Identity(ahead.mean.size(), ahead.mean.size()));
  Eigen::Index from = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (before[k] < 0) continue;
    const auto to = 2 * static_cast<Eigen::Index>(k);
    out.mean.segment<2>(to) = ahead.mean.segment<2>(from);
    out.root.middleCols<2>(to) = root.middleCols<2>(from);
    from += 2;
  }
  return out;
}

/// Makes room for a contact of which nothing is known.
Belief with_room(const Belief& before, std::size_t at) {
  if (before.root.rows() == 0) return before;
  const auto column = 2 * static_cast<Eigen::Index>(at);
  const Eigen::Index rest = before.mean.size() - column;
  Belief out{Eigen::VectorXd::Zero(before.mean.size() + 2),
             Eigen::MatrixXd::Zero(before.root.rows(), before.mean.size() + 2)};
  out.mean << before.mean.head(column), 0.0, 0.0, before.mean.tail(rest);
  out.root.leftCols(column) = before.root.leftCols(column);
  out.root.rightCols(rest) = before.root.rightCols(rest);
  return out;
}

/// Every choice of so many of the numbers below `count`.
std::vector<std::vector<int>> choices(int count, int size) {
  std::vector<std::vector<int>> out;
  for (unsigned mask = 0; mask < 1U << static_cast<unsigned>(count); ++mask) {
    std::vector<int> one;
    for (int i = 0; i < count; ++i) {
      if ((mask >> static_cast<unsigned>(i) & 1U) != 0U) one.push_back(i);
    }
    if (static_cast<int>(one.size()) == size) out.push_back(std::move(one));
  }
  return out;
}

/// The part of `vector` that columns explain, squared.
double explained_by(const Eigen::MatrixXd& columns, const Eigen::VectorXd& vector) {
  if (columns.cols() == 0) return 0.0;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::VectorXd turned = qr.householderQ().adjoint() * vector;
  return turned.head(std::min(columns.cols(), columns.rows())).squaredNorm();
}

}  // namespace

FrameEvidence evidence_of(const TrackedFrame& frame, Eigen::Index coordinates, double step, double variance) {
  const Eigen::MatrixXd rates = frame.fit.response.rates.topRows(coordinates);
  Eigen::VectorXd x(rates.cols());
  for (Eigen::Index k = 0; 2 * k < x.size(); ++k) {
    const NormalForce& f = frame.fit.shape.forces[static_cast<std::size_t>(k)];
    x.segment<2>(2 * k) << f.force, f.arc_length;
  }
  FrameEvidence out{step, frame.before, rates.transpose() * rates / variance, {}};
  out.weighted = out.information * x - rates.transpose() * frame.fit.residual.head(coordinates) / variance;
  return out;
}

const TrackedFrame& ContactTracker::follow(const SequenceFrame& frame, const TrackedFrame* near) {
  rod_.set_moments(frame.moments);
  near_ = near;
  TrackedFrame next = explain(frame);
  for (const int b : next.before)
    next.contacts.push_back(b < 0 ? ++made_ : last_.contacts[static_cast<std::size_t>(b)]);
  if (next.found) {
    state_.mean.resize(static_cast<Eigen::Index>(2 * next.contacts.size()));
    for (Eigen::Index k = 0; 2 * k < state_.mean.size(); ++k) {
      const NormalForce& f = next.fit.shape.forces[static_cast<std::size_t>(k)];
      state_.mean.segment<2>(2 * k) << f.force, f.arc_length;
    }
    state_.covariance = covariance_of(next.fit, variance(frame, next));
    squares_ += next.squares;
    degrees_ += next.degrees;
  }
  time_ = frame.time;
  last_ = std::move(next);
  return last_;
}

TrackedFrame ContactTracker::explain(const SequenceFrame& frame) {
  if (!last_.found) return alone(frame);
  const int had = last_.fit.contacts();
  TrackedFrame best;
  for (int size = had; size >= 0 && !best.found; --size) {
    for (const std::vector<int>& stay : choices(had, size)) {
      TrackedFrame one = keep(frame, stay);
      if (one.found && !contradicts(frame, one) && (!best.found || one.fit.sum < best.fit.sum)) best = std::move(one);
    }
  }
  if (!best.found) return alone(frame);
  const std::vector<int> stay = lasting(frame, best);
  const auto kept = std::count_if(best.before.begin(), best.before.end(), [](int b) { return b >= 0; });
  if (static_cast<std::ptrdiff_t>(stay.size()) == kept) return best;
  // What is broken is not there any more: the points are explained without it.
  TrackedFrame without = keep(frame, stay);
  return without.found ? without : alone(frame);
}

/// With contacts that stay, and with those that the points show beside them.
TrackedFrame ContactTracker::keep(const SequenceFrame& frame, std::span<const int> stay) const {
  MeasuredShape measured = frame.shape;
  std::vector<int> before(stay.begin(), stay.end());
  if (settings_.rates && !stay.empty()) {
    measured.before = belief_of(predicted(state_, stay, frame.time - time_, *settings_.rates), before, measured.noise);
  }
  LoadedRod::Shape start;
  if (near_ != nullptr && near_->found && near_->fit.shape.forces.size() == stay.size()) {
    start = near_->fit.shape;
  } else {
    std::vector<NormalForce> forces;
    for (const int k : stay) forces.push_back(last_.fit.shape.forces[static_cast<std::size_t>(k)]);
    start = rod_.solve(std::move(forces), last_.fit.shape);
  }
  ShapeFit fit = fit_shape(rod_, measured, start, settings_.accuracy, most_steps_of_a_fit, deadline_);
  if (fit.converged) fit = add_contacts(measured, std::move(fit), before);
  return judged(frame, std::move(fit), std::move(before));
}

ShapeFit ContactTracker::add_contacts(const MeasuredShape& shown, ShapeFit fit, std::vector<int>& before) const {
  MeasuredShape measured = shown;
  while (fit.contacts() < settings_.most_contacts && !deadline_.over()) {
    const std::vector<Candidate> places = one_more(rod_, measured, fit, most_tried);
    if (places.empty()) return fit;
    // No curve of places makes noise less likely to do as well than a single place does.
    const double most = places.front().improvement;
    const int degrees = measured.degrees_of_freedom(fit.contacts() + 1);
    if (improvement_probability(most / measured.variance(fit.sum - most, fit.contacts() + 1), 0.0,
                                measured.noise > 0.0 ? 0 : std::max(1, degrees)) >= settings_.most_chance) {
      return fit;
    }
    ShapeFit best;
    best.sum = infinity;
    std::size_t place = 0;
    for (const Candidate& c : places) {
      std::vector<NormalForce> forces = fit.shape.forces;
      const auto at = std::find_if(forces.begin(), forces.end(),
                                   [&](const NormalForce& f) { return f.arc_length > c.forces.front().arc_length; });
      const auto index = static_cast<std::size_t>(at - forces.begin());
      forces.insert(at, c.forces.front());
      MeasuredShape with = measured;
      with.before = with_room(measured.before, index);
      ShapeFit next = fit_shape(rod_, with, rod_.solve(std::move(forces), fit.shape), settings_.accuracy,
                                most_steps_of_a_fit, deadline_);
      if (!next.converged || next.sum >= best.sum) continue;
      best = std::move(next);
      place = index;
    }
    if (!best.converged || chance_of_improvement(rod_, measured, fit, best) >= settings_.most_chance) return fit;
    measured.before = with_room(measured.before, place);
    before.insert(before.begin() + static_cast<std::ptrdiff_t>(place), -1);
    fit = std::move(best);
  }
  return fit;
}

/// As a single shape, whatever was before.
TrackedFrame ContactTracker::alone(const SequenceFrame& frame) {
  const std::vector<Level> levels =
      fit_levels(rod_, frame.shape, settings_.most_contacts, 0.0, settings_.most_chance, deadline_, starts_);
  const Level* level = deadline_.over() ? nullptr : supported_level(levels);
  if (level == nullptr) return {};
  ShapeFit fit = fit_shape(rod_, frame.shape, level->best.shape, settings_.accuracy, most_steps_of_a_fit, deadline_);
  const auto contacts = static_cast<std::size_t>(fit.contacts());
  return judged(frame, std::move(fit), std::vector<int>(contacts, -1));
}

TrackedFrame ContactTracker::judged(const SequenceFrame& frame, ShapeFit fit, std::vector<int> before) const {
  TrackedFrame out;
  out.found = fit.converged;
  out.fit = std::move(fit);
  if (!out.found) return out;
  out.before = std::move(before);
  const Eigen::Index points = frame.shape.points.size();
  const Eigen::Index known = out.fit.residual.size() - points;
  const double seen = out.fit.residual.head(points).squaredNorm();
  const double against = explained_by(out.fit.response.rates.topRows(points), out.fit.residual.head(points));
  out.squares = std::max(0.0, seen - against);
  out.degrees = std::max(0, frame.shape.degrees_of_freedom(out.fit.contacts()));
  out.conflict = against + out.fit.residual.tail(known).squaredNorm();
  out.conflict_degrees = static_cast<int>(known);
  out.explained = chi_square_probability(out.squares / variance(frame, out), out.degrees) >= settings_.most_chance;
  return out;
}

/// Of a coordinate, as far as it is known.
double ContactTracker::variance(const SequenceFrame& frame, const TrackedFrame& tracked) const {
  if (frame.shape.noise > 0.0 || degrees_ == 0) {
    return frame.shape.variance(tracked.fit.sum, tracked.fit.contacts());
  }
  return std::max(squares_ / degrees_, frame.shape.least_noise * frame.shape.least_noise);
}

/// Whether points are not what contacts that stay would have them be. Where nothing explained the frame before either
/// that the points do not look like the shape tells nothing of its contacts.
bool ContactTracker::contradicts(const SequenceFrame& frame, const TrackedFrame& tracked) const {
  if (last_.explained && !tracked.explained) return true;
  const double conflict = tracked.conflict / variance(frame, tracked);
  return chi_square_probability(conflict, tracked.conflict_degrees) < settings_.most_chance;
}

/// Those of the last frame whose forces are there, and on the side on which they were.
std::vector<int> ContactTracker::lasting(const SequenceFrame& frame, const TrackedFrame& tracked) const {
  std::vector<int> out;
  const Eigen::MatrixXd covariance = covariance_of(tracked.fit, variance(frame, tracked));
  for (std::size_t k = 0; k < tracked.before.size(); ++k) {
    if (tracked.before[k] < 0) continue;
    const auto i = 2 * static_cast<Eigen::Index>(k);
    const double force = tracked.fit.shape.forces[k].force;
    const double past = last_.fit.shape.forces[static_cast<std::size_t>(tracked.before[k])].force;
    const double chance = std::erfc(std::abs(force) / std::sqrt(2.0 * covariance(i, i)));
    if (force * past > 0.0 && chance < significance) out.push_back(tracked.before[k]);
  }
  return out;
}

}  // namespace tendril
