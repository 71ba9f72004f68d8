#include "tendril/feasibility.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tendril/multipliers.hpp"

namespace tendril {
namespace {

/// A step that leaves more than this of the squared violation is slow: the violation itself is curved.
constexpr double slow = 0.5;
constexpr double most_damping = 1e12;
/// Rounds in which a step finds out which rows it would violate and which bounds it would meet.
constexpr int most_guesses = 6;

/// So many steps that reduce the squared violation by less than this share of it lie on the floor of a valley, with a
/// kink along it that keeps the slope up: a corner of an obstacle, a row that comes and goes.
constexpr int floor_steps = 20;
constexpr double floor_share = 1e-5;

/// Least squares of the violation of all rows, within bounds, by damped Newton steps.
class Restoration {
 public:
  Restoration(NonlinearProgram& program, ConstVectorRef start)
      : program_(program), x_(start.cwiseMax(program.lower()).cwiseMin(program.upper())) {
    look(x_, rows_, violation_);
    merit_ = violation_.squaredNorm();
  }

  FeasibilityReport run(double tolerance, int max_iterations, const std::function<bool()>& stop) {
    FeasibilityReport report;
    double earlier = infinity;
    for (; report.iterations < max_iterations && std::isfinite(merit_); ++report.iterations) {
      if (violation_.size() == 0 || violation_.cwiseAbs().maxCoeff() <= tolerance || (stop && stop())) break;
      bool floor = false;
      if (report.iterations % floor_steps == 0) {
        floor = merit_ > earlier * (1.0 - floor_share);
        earlier = merit_;
      }
      if (floor || stationary() || !advance()) {
        report.stationary_violation = true;
        break;
      }
    }
    report.x = x_;
    report.infeasibility = infeasibility(program_, x_);
    report.feasible = report.infeasibility <= tolerance;
    if (report.feasible) report.stationary_violation = false;
    return report;
  }

 private:
  double excess(double value, int row) const {
    return std::max(0.0, value - program_.row_upper()[row]) - std::max(0.0, program_.row_lower()[row] - value);
  }

  /// Rows at x and their signed violation.
  void look(const Eigen::VectorXd& x, Eigen::VectorXd& rows, Eigen::VectorXd& violation) const {
    rows = program_.constraints(x);
    violation.resize(rows.size());
    for (int i = 0; i < rows.size(); ++i) violation[i] = excess(rows[i], i);
  }

  /// Relative to the violation: its square has no descent direction left within the bounds.
  bool stationary() {
    const Eigen::VectorXd slope = program_.jacobian(x_).transpose() * violation_;
    double largest = 0.0;
    for (int i = 0; i < slope.size(); ++i) {
      const bool held =
          (slope[i] > 0.0 && x_[i] <= program_.lower()[i]) || (slope[i] < 0.0 && x_[i] >= program_.upper()[i]);
      if (!held) largest = std::max(largest, std::abs(slope[i]));
    }
    return largest <= 1e-8 * std::sqrt(merit_);
  }

  /// False: no step reduces the violation, or the last one hardly did.
  bool advance() {
    jacobian_ = program_.jacobian(x_);
    // Where the violation cannot vanish, its own second derivatives count as much as the products of first ones:
    // without them the way to its stationary point never ends.
    if (curved_) curvature_ = program_.hessian(x_, 0.0, violation_);
    while (damping_ < most_damping) {
      Eigen::VectorXd next, next_rows, next_violation;
      if (propose(next)) {
        look(next, next_rows, next_violation);
        const double merit = next_violation.squaredNorm();
        if (std::isfinite(merit) && merit < merit_) {
          // Almost no progress over a full step: the valley floor of an infeasible program.
          const bool floor = curved_ && merit > merit_ * (1.0 - 1e-7) && damping_ < 1.0;
          curved_ = merit > slow * merit_;
          x_ = next;
          rows_ = next_rows;
          violation_ = next_violation;
          merit_ = merit;
          damping_ = std::max(1e-12, 0.2 * damping_);
          return !floor;
        }
      }
      damping_ *= 5.0;
    }
    return false;
  }

  /// The least violation of the linearized rows under the damping, within the bounds. Which rows will be violated and
  /// which bounds met is guessed from what is so now, then from the step itself. False: the model has no least value.
  bool propose(Eigen::VectorXd& next) const {
    const Eigen::Index n = x_.size();
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    Eigen::VectorXd predicted = rows_;
    std::vector<char> pinned(static_cast<std::size_t>(n), 0);
    std::vector<char> counted, before;
    for (int guess = 0; guess < most_guesses; ++guess) {
      counted.assign(static_cast<std::size_t>(rows_.size()), 0);
      Eigen::MatrixXd normal = curved_ ? curvature_ : Eigen::MatrixXd::Zero(n, n);
      Eigen::VectorXd slope = Eigen::VectorXd::Zero(n);
      for (int i = 0; i < rows_.size(); ++i) {
        const double side = excess(predicted[i], i);
        if (side == 0.0) continue;
        counted[static_cast<std::size_t>(i)] = side > 0.0 ? 1 : 2;
        const double off = rows_[i] - (side > 0.0 ? program_.row_upper()[i] : program_.row_lower()[i]);
        normal.noalias() += jacobian_.row(i).transpose() * jacobian_.row(i);
        slope += off * jacobian_.row(i).transpose();
      }
      bool more_pinned = false;
      for (Eigen::Index i = 0; i < n; ++i) {
        const double wanted = guess == 0 ? x_[i] - slope[i] : x_[i] + step[i];
        const bool at_bound = guess > 0 || x_[i] <= program_.lower()[i] || x_[i] >= program_.upper()[i];
        if (!at_bound || pinned[static_cast<std::size_t>(i)] != 0) continue;
        if (wanted < program_.lower()[i]) pinned[static_cast<std::size_t>(i)] = 1;
        if (wanted > program_.upper()[i]) pinned[static_cast<std::size_t>(i)] = 2;
        more_pinned = more_pinned || pinned[static_cast<std::size_t>(i)] != 0;
      }
      if (guess > 0 && counted == before && !more_pinned) break;
      before = counted;
      normal.diagonal().array() += damping_ * (1.0 + normal.diagonal().array().abs());
      for (Eigen::Index i = 0; i < n; ++i) {
        const char pin = pinned[static_cast<std::size_t>(i)];
        if (pin == 0) continue;
        const double moved = (pin == 1 ? program_.lower()[i] : program_.upper()[i]) - x_[i];
        slope += moved * normal.col(i);
        normal.row(i).setZero();
        normal.col(i).setZero();
        normal(i, i) = 1.0;
        slope[i] = -moved;
      }
      const Eigen::LDLT<Eigen::MatrixXd> factors(normal);
      if (curved_ && !(factors.info() == Eigen::Success && factors.isPositive())) return false;
      step = -factors.solve(slope);
      predicted = rows_;
      predicted.noalias() += jacobian_ * step;
    }
    next = (x_ + step).cwiseMax(program_.lower()).cwiseMin(program_.upper());
    return true;
  }

  NonlinearProgram& program_;
  Eigen::VectorXd x_;
  Eigen::VectorXd rows_, violation_;
  Eigen::MatrixXd jacobian_, curvature_;
  double merit_ = 0.0;
  double damping_ = 1e-3;
  bool curved_ = false;  ///< the last step was slow
};

}  // namespace

FeasibilityReport restore_feasibility(NonlinearProgram& program, ConstVectorRef start, double tolerance,
                                      int max_iterations, const std::function<bool()>& stop) {
  return Restoration(program, start).run(tolerance, max_iterations, stop);
}

}  // namespace tendril
