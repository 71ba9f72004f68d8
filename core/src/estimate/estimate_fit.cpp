#include "estimate/estimate_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nlp/levenberg.hpp"
#include "rod/quadrature.hpp"

namespace tendril {
namespace {

/// Steps that move the points by less than this are rounding: a norm of points, in L.
constexpr double step_floor = 1e-13;
constexpr int most_search_steps = 40;
constexpr double longest_shift = 0.1;  // of a place in one step, in L

/// Whether a place may not follow its gradient any further.
bool blocked(const std::vector<NormalForce>& forces, std::size_t k, double direction) {
  const double s = forces[k].arc_length;
  const double low = k == 0 ? 0.0 : forces[k - 1].arc_length;
  const double high = k + 1 == forces.size() ? 1.0 : forces[k + 1].arc_length;
  constexpr double room = 1.5 * LoadedRod::knot_clearance;
  return (direction < 0.0 && s - low < room) || (direction > 0.0 && high - s < room);
}

/// Keeps order and room of places that a step has moved.
void keep_order(std::vector<NormalForce>& forces) {
  std::sort(forces.begin(), forces.end(),
            [](const NormalForce& a, const NormalForce& b) { return a.arc_length < b.arc_length; });
  for (NormalForce& f : forces) f.arc_length = std::clamp(f.arc_length, 0.0, 1.0);
}

}  // namespace

double MeasuredShape::variance(double sum, int contacts) const {
  if (noise > 0.0) return noise * noise;
  const int degrees = std::max(1, degrees_of_freedom(contacts));
  return std::max(sum / degrees, least_noise * least_noise);
}

namespace {

ShapeFit judged(const LoadedRod& rod, const MeasuredShape& measured, LoadedRod::Shape shape) {
  ShapeFit fit;
  fit.shape = std::move(shape);
  fit.response = rod.response(fit.shape, measured.arc_lengths);
  fit.residual = fit.response.points - measured.points;
  if (const Belief& before = measured.before; before.root.rows() > 0) {
    const Eigen::Index points = fit.residual.size();
    Eigen::VectorXd off = -before.mean;
    for (Eigen::Index k = 0; k < fit.contacts(); ++k) {
      const NormalForce& f = fit.shape.forces[static_cast<std::size_t>(k)];
      off.segment<2>(2 * k) += Eigen::Vector2d(f.force, f.arc_length);
    }
    fit.residual.conservativeResize(points + before.root.rows());
    fit.residual.tail(before.root.rows()).noalias() = before.root * off;
    fit.response.rates.conservativeResize(fit.residual.size(), Eigen::NoChange);
    fit.response.rates.bottomRows(before.root.rows()) = before.root;
  }
  fit.sum = fit.residual.squaredNorm();
  return fit;
}

/// What a step in the places, and in leans that are free, asks for: how the points move with each of them when every
/// force follows at its best.
struct PlaceStep {
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  double remaining = 0.0;  ///< norm of what a full step would move the points by
};

/// `by_lean`: how the points move with the leans within plus and minus `friction`; no columns: they stay.
PlaceStep place_step(const ShapeFit& fit, const Eigen::MatrixXd& by_lean, double friction) {
  const Eigen::Index contacts = fit.contacts();
  Eigen::MatrixXd by_force(fit.residual.size(), contacts);
  Eigen::MatrixXd by_place(fit.residual.size(), contacts + by_lean.cols());
  for (Eigen::Index k = 0; k < contacts; ++k) {
    by_force.col(k) = fit.response.rates.col(2 * k);
    by_place.col(k) = fit.response.rates.col(2 * k + 1);
  }
  by_place.rightCols(by_lean.cols()) = by_lean;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(by_force);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(by_force.rows(), contacts);
  const Eigen::VectorXd explained = q.transpose() * fit.residual;
  by_place -= q * (q.transpose() * by_place);
  PlaceStep out{by_place.transpose() * by_place, by_place.transpose() * fit.residual};
  for (Eigen::Index i = 0; i < out.gradient.size(); ++i) {
    const auto k = static_cast<std::size_t>(i % contacts);
    const double direction = -out.gradient[i];
    const bool held =
        i < contacts ? blocked(fit.shape.forces, k, direction)
                     : direction * fit.shape.forces[k].lean > 0.0 && std::abs(fit.shape.forces[k].lean) >= friction;
    if (!held) continue;
    out.normal.row(i).setZero();
    out.normal.col(i).setZero();
    out.normal(i, i) = 1.0;
    out.gradient[i] = 0.0;
  }
  const double by_places = out.gradient.dot(Eigen::LDLT<Eigen::MatrixXd>(out.normal).solve(out.gradient));
  out.remaining = std::sqrt(explained.squaredNorm() + std::max(0.0, by_places));
  return out;
}

/// The forces that explain the points best once the places have moved, as far as the present shape answers linearly.
void set_best_forces(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit,
                     std::vector<NormalForce>& forces) {
  const auto contacts = static_cast<Eigen::Index>(forces.size());
  std::vector<NormalForce> places = fit.shape.forces;
  places.insert(places.end(), forces.begin(), forces.end());
  // Columns between knots are less exact than those at them; their differences vanish as the steps do.
  const Eigen::MatrixXd influence = influence_of(rod, measured, fit, places);
  Eigen::MatrixXd columns = influence.rightCols(contacts) - influence.leftCols(contacts);
  Eigen::VectorXd target = -fit.residual;
  for (Eigen::Index k = 0; k < contacts; ++k) {
    columns.col(k) += fit.response.rates.col(2 * k);
    target += fit.shape.forces[static_cast<std::size_t>(k)].force * fit.response.rates.col(2 * k);
    if (measured.before.root.rows() == 0) continue;
    const auto i = static_cast<std::size_t>(k);
    target.tail(measured.before.root.rows()) -=
        (forces[i].arc_length - fit.shape.forces[i].arc_length) * measured.before.root.col(2 * k + 1);
  }
  const Eigen::VectorXd best = columns.householderQr().solve(target);
  for (Eigen::Index k = 0; k < contacts; ++k) forces[static_cast<std::size_t>(k)].force = best[k];
}

}  // namespace

ShapeFit fit_shape(const LoadedRod& rod, const MeasuredShape& measured, const LoadedRod::Shape& start, double accuracy,
                   int most_steps, const Deadline& deadline, double friction) {
  ShapeFit fit;
  fit.shape = start;
  fit.sum = infinity;
  if (!start.converged) return fit;
  fit = judged(rod, measured, start);
  const int contacts = fit.contacts();
  fit.converged = contacts == 0;
  if (fit.converged) return fit;
  PlaceStep wanted;
  double error = 0.0;
  const auto here = [&](NormalEquations& at) {
    const Eigen::MatrixXd by_lean =
        friction > 0.0 ? rod.lean_rates(fit.shape, measured.arc_lengths) : Eigen::MatrixXd(fit.residual.size(), 0);
    wanted = place_step(fit, by_lean, friction);
    error = std::sqrt(measured.variance(fit.sum, contacts));
    at = {wanted.normal, wanted.gradient};
    return wanted.remaining <= std::max(accuracy * error, step_floor);
  };
  const auto attempt = [&](const Eigen::VectorXd& shift) {
    if (!(shift.lpNorm<Eigen::Infinity>() <= longest_shift)) return StepTried::too_long;
    std::vector<NormalForce> moved = fit.shape.forces;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      moved[k].arc_length += shift[i];
      if (friction > 0.0) moved[k].lean = std::clamp(moved[k].lean + shift[contacts + i], -friction, friction);
    }
    keep_order(moved);
    set_best_forces(rod, measured, fit, moved);
    // The predictor lets Newton start from where the shape will be.
    LoadedRod::Shape guess = fit.shape;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(2 * k);
      guess.coordinates +=
          (moved[k].force - fit.shape.forces[k].force) * fit.response.coordinate_rates.col(i) +
          (moved[k].arc_length - fit.shape.forces[k].arc_length) * fit.response.coordinate_rates.col(i + 1);
    }
    const LoadedRod::Shape next = rod.solve(moved, guess);
    if (!next.converged) return StepTried::worse;
    ShapeFit trial = judged(rod, measured, next);
    if (!(trial.sum < fit.sum)) return StepTried::worse;
    fit = std::move(trial);
    return StepTried::moved;
  };
  const FitEnd end = levenberg(most_steps, here, attempt, [&] { return deadline.over(); });
  // Where no step helps any more that is rounding, if what remains is far below the errors.
  fit.converged = end == FitEnd::converged || (end == FitEnd::stuck && wanted.remaining <= 1e-3 * error);
  return fit;
}

namespace {

/// Directions of chords between points that lie far enough apart, without jumps of a full turn.
struct Chord {
  double from = 0.0, to = 0.0;  // arc lengths
  double angle = 0.0;
};

std::vector<Chord> chords(const Rod& rod, const MeasuredShape& measured) {
  // Closer points tell their noise and not the rod's direction.
  constexpr double least = 0.04;
  std::vector<Chord> out;
  double s = 0.0;
  Vec2 p = rod.base;
  double angle = rod.base_angle;
  for (std::size_t m = 0; m < measured.arc_lengths.size(); ++m) {
    const auto i = 2 * static_cast<Eigen::Index>(m);
    const Vec2 next{measured.points[i], measured.points[i + 1]};
    const Vec2 d = next - p;
    if (measured.arc_lengths[m] < s + least || norm(d) == 0.0) continue;
    const double here = std::atan2(d.y, d.x);
    angle += std::remainder(here - angle, 2.0 * std::numbers::pi);
    out.push_back({s, measured.arc_lengths[m], angle});
    s = measured.arc_lengths[m];
    p = next;
  }
  return out;
}

}  // namespace

double measured_turn(const Rod& rod, const MeasuredShape& measured) {
  double low = rod.base_angle;
  double high = rod.base_angle;
  for (const Chord& c : chords(rod, measured)) {
    low = std::min(low, c.angle);
    high = std::max(high, c.angle);
  }
  return high - low;
}

LoadedRod::Curvature measured_curvature(const Rod& rod, const MeasuredShape& measured) {
  constexpr int order = 8;
  const LegendreBasis basis(order);
  const std::vector<Chord> all = chords(rod, measured);
  // Bending is penalized lightly, so that few or noisy chords give a smooth rod instead of none.
  constexpr double smoothing = 1e-3;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(order, order);
  for (int i = 0; i < order; ++i) normal(i, i) = smoothing / (2 * i + 1) * (1.0 + i * i);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(order);
  Eigen::MatrixXd value(1, order);
  Eigen::MatrixXd first(1, order);
  Eigen::MatrixXd second(1, order);
  for (const Chord& c : all) {
    const double middle[1] = {0.5 * (c.from + c.to)};
    basis.evaluate(middle, value, first, second);
    const double weight = c.to - c.from;
    normal += weight * value.transpose() * value;
    rhs += weight * (c.angle - rod.base_angle) * value.transpose();
  }
  const Eigen::VectorXd q = normal.ldlt().solve(rhs);
  return [q](double s) {
    std::vector<double> legendre(order);
    legendre_polynomials(2.0 * s - 1.0, legendre);
    return q.dot(Eigen::Map<const Eigen::VectorXd>(legendre.data(), order));
  };
}

std::vector<NormalForce> spread_places(int count) {
  std::vector<NormalForce> places(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < places.size(); ++i) places[i].arc_length = (static_cast<double>(i) + 0.5) / count;
  return places;
}

namespace {

void keep_best(std::vector<Candidate>& candidates, std::size_t count) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.improvement > b.improvement; });
  if (candidates.size() > count) candidates.resize(count);
}

/// Places at which one force along a column explains more of `target` than at the neighbouring places.
std::vector<Candidate> single_candidates(const Eigen::VectorXd& target, const Eigen::MatrixXd& columns,
                                         const std::vector<NormalForce>& places) {
  const Eigen::Index n = columns.cols();
  Eigen::VectorXd force(n);
  Eigen::VectorXd improvement(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double square = columns.col(i).squaredNorm();
    force[i] = square > 0.0 ? columns.col(i).dot(target) / square : 0.0;
    improvement[i] = force[i] * force[i] * square;
  }
  std::vector<Candidate> out;
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool top =
        (i == 0 || improvement[i] >= improvement[i - 1]) && (i + 1 == n || improvement[i] > improvement[i + 1]);
    if (top) out.push_back({{{force[i], places[static_cast<std::size_t>(i)].arc_length}}, improvement[i]});
  }
  return out;
}

/// The same for two forces at a time.
std::vector<Candidate> pair_candidates(const Eigen::VectorXd& target, const Eigen::MatrixXd& columns,
                                       const std::vector<NormalForce>& places) {
  const Eigen::Index n = columns.cols();
  const Eigen::MatrixXd gram = columns.transpose() * columns;
  const Eigen::VectorXd right = columns.transpose() * target;
  // Neighbours act almost alike: huge opposite forces there are no start.
  constexpr Eigen::Index apart = 2;
  Eigen::MatrixXd improvement = Eigen::MatrixXd::Constant(n, n, -1.0);
  std::vector<std::vector<Eigen::Vector2d>> force(static_cast<std::size_t>(n),
                                                  std::vector<Eigen::Vector2d>(static_cast<std::size_t>(n)));
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = i + apart; k < n; ++k) {
      Eigen::Matrix2d a;
      a << gram(i, i), gram(i, k), gram(i, k), gram(k, k);
      const Eigen::Vector2d b(right[i], right[k]);
      const Eigen::Vector2d f = a.ldlt().solve(b);
      force[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] = f;
      improvement(i, k) = f.dot(b);
    }
  }
  std::vector<Candidate> out;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = i + apart; k < n; ++k) {
      bool top = std::isfinite(improvement(i, k));
      for (Eigen::Index di = -1; di <= 1; ++di) {
        for (Eigen::Index dk = -1; dk <= 1; ++dk) {
          if (i + di < 0 || i + di >= n || k + dk < 0 || k + dk >= n) continue;
          top = top && improvement(i, k) >= improvement(i + di, k + dk);
        }
      }
      if (!top) continue;
      const Eigen::Vector2d& f = force[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
      out.push_back({{{f[0], places[static_cast<std::size_t>(i)].arc_length},
                      {f[1], places[static_cast<std::size_t>(k)].arc_length}},
                     improvement(i, k)});
    }
  }
  return out;
}

std::vector<Candidate> candidates(int contacts, const Eigen::VectorXd& target, const Eigen::MatrixXd& columns,
                                  const std::vector<NormalForce>& places, std::size_t count) {
  std::vector<Candidate> all =
      contacts == 1 ? single_candidates(target, columns, places) : pair_candidates(target, columns, places);
  keep_best(all, count);
  return all;
}

}  // namespace

Eigen::MatrixXd influence_of(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit,
                             std::span<const NormalForce> places) {
  Eigen::MatrixXd out = rod.influence(fit.shape, measured.arc_lengths, places);
  const Eigen::Index more = measured.before.root.rows();
  if (more == 0) return out;
  out.conservativeResize(out.rows() + more, Eigen::NoChange);
  out.bottomRows(more).setZero();
  return out;
}

std::vector<Candidate> one_more(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit,
                                std::size_t count) {
  const std::vector<NormalForce> places = spread_places(40);
  Eigen::MatrixXd columns = influence_of(rod, measured, fit, places);
  if (fit.contacts() > 0) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(fit.response.rates);
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), fit.response.rates.cols());
    columns -= q * (q.transpose() * columns);
  }
  return candidates(1, -fit.residual, columns, places, count);
}

std::vector<ShapeFit> search(const LoadedRod& rod, const MeasuredShape& measured, const LoadedRod::Curvature& curvature,
                             int contacts, const ShapeFit& fewer, const Deadline& deadline, int& starts) {
  const std::vector<NormalForce> places = spread_places(contacts == 1 ? 40 : 24);
  std::vector<ShapeFit> found;
  const auto try_from = [&](const LoadedRod::Shape& start) {
    ++starts;
    ShapeFit fit = fit_shape(rod, measured, start, search_accuracy, most_search_steps, deadline);
    if (std::isfinite(fit.sum)) found.push_back(std::move(fit));
  };

  // Where forces would have to act on the shape fitted with fewer, as far as it answers linearly.
  if (fewer.converged) {
    Eigen::VectorXd target = -fewer.residual;
    for (int k = 0; k < fewer.contacts(); ++k) {
      target += fewer.shape.forces[static_cast<std::size_t>(k)].force * fewer.response.rates.col(2 * k);
    }
    const Eigen::MatrixXd columns = rod.influence(fewer.shape, measured.arc_lengths, places);
    for (const Candidate& c : candidates(contacts, target, columns, places, 4)) {
      if (deadline.over()) break;
      try_from(rod.solve(c.forces, fewer.shape));
    }
    // One force more at a quiet place, beside those that are there.
    if (contacts > 1) {
      Eigen::VectorXd rest = -fewer.residual;
      for (Candidate& c : candidates(1, rest, columns, places, 2)) {
        if (deadline.over()) break;
        std::vector<NormalForce> forces = fewer.shape.forces;
        forces.push_back(c.forces.front());
        std::sort(forces.begin(), forces.end(),
                  [](const NormalForce& a, const NormalForce& b) { return a.arc_length < b.arc_length; });
        try_from(rod.solve(forces, fewer.shape));
      }
    }
  }
  // What the measured shape itself says is missing for equilibrium: it needs no shape that is near.
  const LoadedRod::Imbalance imbalance = rod.imbalance(curvature, places);
  for (const Candidate& c : candidates(contacts, imbalance.missing, imbalance.per_force, places, 3)) {
    if (deadline.over()) break;
    try_from(rod.solve(c.forces, curvature));
  }
  std::stable_sort(found.begin(), found.end(), [](const ShapeFit& a, const ShapeFit& b) { return a.sum < b.sum; });
  return found;
}

}  // namespace tendril
