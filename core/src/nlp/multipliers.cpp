#include "nlp/multipliers.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tendril/error.hpp"

namespace tendril {

namespace {

/// The active-set method of Lawson and Hanson with free columns, on columns turned so that every bounded multiplier is
/// >= 0.
class BoundedLeastSquares {
 public:
  BoundedLeastSquares(ConstVectorRef gradient, ConstMatrixRef active, std::span<const MultiplierSign> signs)
      : gradient_(gradient),
        columns_(active),
        y_(Eigen::VectorXd::Zero(active.cols())),
        free_(signs.size()),
        turned_(signs.size()) {
    for (std::size_t j = 0; j < signs.size(); ++j) {
      free_[j] = signs[j] == MultiplierSign::free;
      turned_[j] = signs[j] == MultiplierSign::non_positive;
      if (turned_[j]) columns_.col(static_cast<Eigen::Index>(j)) *= -1.0;
    }
  }

  MultiplierFit solve() {
    bool proven = true;
    if (!all_passive_is_right()) proven = iterate();
    for (std::size_t j = 0; j < turned_.size(); ++j) {
      if (turned_[j]) y_[static_cast<Eigen::Index>(j)] *= -1.0;
    }
    return {y_, residual_, proven};
  }

 private:
  /// With strict complementarity every active multiplier has its sign and one factorization answers.
  bool all_passive_is_right() {
    passive_.clear();
    for (int j = 0; j < columns_.cols(); ++j) passive_.push_back(j);
    const Eigen::VectorXd s = passive_solution();
    for (int j = 0; j < columns_.cols(); ++j) {
      if (!free_[static_cast<std::size_t>(j)] && s[j] < 0.0) return false;
    }
    y_ = s;
    update_residual();
    return true;
  }

  bool iterate() {
    passive_.clear();
    y_.setZero();
    std::vector<char> barred(free_.size(), 0);
    for (int j = 0; j < columns_.cols(); ++j) {
      if (free_[static_cast<std::size_t>(j)]) passive_.push_back(j);
    }
    accept(passive_solution());
    const double scale = std::max(1e-300, gradient_.norm());
    const int limit = 10 + 5 * static_cast<int>(columns_.cols());
    for (int round = 0; round < limit; ++round) {
      const int entering = steepest(scale, barred);
      if (entering < 0) return true;
      passive_.push_back(entering);
      Eigen::VectorXd s = passive_solution();
      // Rounding can let a column enter that at once wants to leave: bar it until something else has moved.
      if (s[static_cast<Eigen::Index>(passive_.size()) - 1] <= 0.0) {
        passive_.pop_back();
        barred[static_cast<std::size_t>(entering)] = 1;
        continue;
      }
      while (!step_towards(s)) s = passive_solution();
      std::fill(barred.begin(), barred.end(), 0);
    }
    return false;
  }

  int steepest(double scale, const std::vector<char>& barred) const {
    int best = -1;
    double best_slope = 1e-13 * scale;
    for (int j = 0; j < columns_.cols(); ++j) {
      if (barred[static_cast<std::size_t>(j)] || std::find(passive_.begin(), passive_.end(), j) != passive_.end())
        continue;
      const double length = columns_.col(j).norm();
      if (length <= 0.0) continue;
      const double slope = -columns_.col(j).dot(residual_) / length;
      if (slope > best_slope) {
        best_slope = slope;
        best = j;
      }
    }
    return best;
  }

  /// Least-squares multipliers of the passive columns, in their order.
  Eigen::VectorXd passive_solution() const {
    const auto count = static_cast<Eigen::Index>(passive_.size());
    if (count == 0) return Eigen::VectorXd(0);
    Eigen::MatrixXd m(columns_.rows(), count);
    for (Eigen::Index k = 0; k < count; ++k) m.col(k) = columns_.col(passive_[static_cast<std::size_t>(k)]);
    return m.completeOrthogonalDecomposition().solve(-gradient_);
  }

  /// Goes from y as far towards s as signs allow; true if s was reached, else the column that stopped it has left.
  bool step_towards(const Eigen::VectorXd& s) {
    double step = 1.0;
    int leaving = -1;
    for (std::size_t k = 0; k < passive_.size(); ++k) {
      const int j = passive_[k];
      const double target = s[static_cast<Eigen::Index>(k)];
      if (free_[static_cast<std::size_t>(j)] || target > 0.0) continue;
      const double gap = y_[j] - target;
      const double ratio = gap > 0.0 ? y_[j] / gap : 0.0;
      if (leaving < 0 || ratio < step) {
        step = std::min(1.0, ratio);
        leaving = static_cast<int>(k);
      }
    }
    if (leaving < 0) {
      accept(s);
      return true;
    }
    for (std::size_t k = 0; k < passive_.size(); ++k) {
      double& y = y_[passive_[k]];
      y += step * (s[static_cast<Eigen::Index>(k)] - y);
    }
    y_[passive_[static_cast<std::size_t>(leaving)]] = 0.0;
    passive_.erase(passive_.begin() + leaving);
    return false;
  }

  void accept(const Eigen::VectorXd& s) {
    y_.setZero();
    for (std::size_t k = 0; k < passive_.size(); ++k) y_[passive_[k]] = s[static_cast<Eigen::Index>(k)];
    update_residual();
  }

  void update_residual() { residual_ = gradient_ + columns_ * y_; }

  Eigen::VectorXd gradient_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd y_;
  Eigen::VectorXd residual_;
  std::vector<char> free_;
  std::vector<char> turned_;
  std::vector<int> passive_;
};

double violation(double value, double lower, double upper) { return std::max({lower - value, value - upper, 0.0}); }

/// Zero unless the multiplier pushes from a side that is active.
double admissible(double multiplier, const Activity& a) {
  if (multiplier < 0.0) return a.at_lower ? multiplier : 0.0;
  return a.at_upper ? multiplier : 0.0;
}

double infeasibility_at(const NonlinearProgram& program, const ConstVectorRef& x, const VectorView& c) {
  double worst = 0.0;
  for (int i = 0; i < program.row_count(); ++i) {
    worst = std::max(worst, violation(c[i], program.row_lower()[i], program.row_upper()[i]));
  }
  for (int i = 0; i < program.variable_count(); ++i) {
    worst = std::max(worst, violation(x[i], program.lower()[i], program.upper()[i]));
  }
  return worst;
}

void recover(NonlinearProgram& program, const ConstVectorRef& x, double tolerance, KktJudgement& out) {
  const int n = program.variable_count();
  const int m = program.row_count();
  const VectorView c = program.constraints(x);
  const MatrixView jacobian = program.jacobian(x);
  std::vector<int> index;
  std::vector<MultiplierSign> signs;
  index.reserve(static_cast<std::size_t>(n + m));
  signs.reserve(static_cast<std::size_t>(n + m));
  const auto add = [&](int i, double value, double lower, double upper) {
    const Activity a = activity(value, lower, upper, tolerance);
    if (!a.any()) return;
    index.push_back(i);
    signs.push_back(a.sign());
  };
  for (int i = 0; i < m; ++i) add(i, c[i], program.row_lower()[i], program.row_upper()[i]);
  for (int i = 0; i < n; ++i) add(m + i, x[i], program.lower()[i], program.upper()[i]);

  Eigen::MatrixXd active = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(index.size()));
  for (std::size_t k = 0; k < index.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (index[k] < m) {
      active.col(column) = jacobian.row(index[k]).transpose();
    } else {
      active(index[k] - m, column) = 1.0;
    }
  }
  const MultiplierFit fit = recover_multipliers(program.gradient(x), active, signs);
  for (std::size_t k = 0; k < index.size(); ++k) {
    const double y = fit.multipliers[static_cast<Eigen::Index>(k)];
    (index[k] < m ? out.multipliers[index[k]] : out.bound_multipliers[index[k] - m]) = y;
  }
  out.stationarity = n == 0 ? 0.0 : fit.residual.lpNorm<Eigen::Infinity>();
}

}  // namespace

MultiplierFit recover_multipliers(ConstVectorRef gradient, ConstMatrixRef active,
                                  std::span<const MultiplierSign> signs) {
  if (active.rows() != gradient.size() || active.cols() != static_cast<Eigen::Index>(signs.size())) {
    throw Error("recover_multipliers: a matrix of " + std::to_string(active.rows()) + " x " +
                std::to_string(active.cols()) + " does not fit a gradient of " + std::to_string(gradient.size()) +
                " and " + std::to_string(signs.size()) + " signs");
  }
  if (signs.empty()) return {Eigen::VectorXd(0), gradient, true};
  return BoundedLeastSquares(gradient, active, signs).solve();
}

Activity activity(double value, double lower, double upper, double tolerance) {
  if (lower == upper) return {true, true};
  return {value - lower <= tolerance, upper - value <= tolerance};
}

double infeasibility(NonlinearProgram& program, ConstVectorRef x) {
  return infeasibility_at(program, x, program.constraints(x));
}

KktJudgement judge_kkt(NonlinearProgram& program, ConstVectorRef x, double active_tolerance,
                       const Eigen::VectorXd* multipliers, const Eigen::VectorXd* bound_multipliers) {
  KktJudgement out;
  if (multipliers != nullptr && bound_multipliers != nullptr) {
    judge_kkt(program, x, active_tolerance, *multipliers, *bound_multipliers, out);
    return out;
  }
  out.multipliers.setZero(program.row_count());
  out.bound_multipliers.setZero(program.variable_count());
  // Derivatives first: they bring the values along, while the other order could compute the values twice.
  (void)program.gradient(x);
  out.infeasibility = infeasibility_at(program, x, program.constraints(x));
  out.cost = program.cost(x);
  recover(program, x, active_tolerance, out);
  return out;
}

void judge_kkt(NonlinearProgram& program, ConstVectorRef x, double active_tolerance, const Eigen::VectorXd& multipliers,
               const Eigen::VectorXd& bound_multipliers, KktJudgement& out) {
  const int n = program.variable_count();
  const int m = program.row_count();
  out.slope = program.gradient(x);
  const VectorView c = program.constraints(x);
  out.cost = program.cost(x);
  out.infeasibility = infeasibility_at(program, x, c);
  out.multipliers.resize(m);
  out.bound_multipliers.resize(n);
  for (int i = 0; i < m; ++i) {
    out.multipliers[i] =
        admissible(multipliers[i], activity(c[i], program.row_lower()[i], program.row_upper()[i], active_tolerance));
  }
  for (int i = 0; i < n; ++i) {
    out.bound_multipliers[i] =
        admissible(bound_multipliers[i], activity(x[i], program.lower()[i], program.upper()[i], active_tolerance));
  }
  out.slope.noalias() += program.jacobian(x).transpose() * out.multipliers;
  out.slope += out.bound_multipliers;
  out.stationarity = n == 0 ? 0.0 : out.slope.lpNorm<Eigen::Infinity>();
}

}  // namespace tendril
