#include "nlp/feasibility.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "nlp/multipliers.hpp"

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

/// How a step of the restoration sees the violation.
enum class View {
  here,  ///< the rows that are violated now, linearly: small steps that mostly stay on their side of an obstacle
  ahead  ///< rows and bounds that the step itself would meet, and curvature: ends where the other one creeps
};

/// Least squares of the violation of all rows, within bounds, by damped Newton steps.
class Restoration {
 public:
  Restoration(NonlinearProgram& program, ConstVectorRef start, View view)
      : program_(program), view_(view), x_(start.cwiseMax(program.lower()).cwiseMin(program.upper())) {
    evaluate_at(x_, rows_, violation_);
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
  void evaluate_at(const Eigen::VectorXd& x, Eigen::VectorXd& rows, Eigen::VectorXd& violation) const {
    (void)program_.jacobian(x);  // brings the values along; most steps are taken, and need it next
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
    start_model();
    bool refused = false;
    while (damping_ < most_damping) {
      if (propose(next_)) {
        evaluate_at(next_, next_rows_, next_violation_);
        const double merit = next_violation_.squaredNorm();
        if (std::isfinite(merit) && merit < merit_) {
          // Almost no progress over a full step: the valley floor of an infeasible program.
          const bool floor = (curved_ || view_ == View::here) && merit > merit_ * (1.0 - 1e-7) && damping_ < 1.0;
          curved_ = view_ == View::ahead && merit > slow * merit_;
          x_.swap(next_);
          rows_.swap(next_rows_);
          violation_.swap(next_violation_);
          merit_ = merit;
          // Less than what was just refused would be refused again.
          if (!refused) damping_ = std::max(1e-12, 0.2 * damping_);
          return !floor;
        }
      }
      refused = true;
      damping_ *= 5.0;
    }
    return false;
  }

  /// Side of its limits that a row at this value is beyond.
  enum class Side : signed char { inside = 0, above = 1, below = -1 };
  Side side(double value, int row) const {
    const double off = excess(value, row);
    return off > 0.0 ? Side::above : off < 0.0 ? Side::below : Side::inside;
  }

  /// A quadratic model of half the squared violation, whose counted rows are violated linearly.
  struct Model {
    std::vector<Side> counted;  ///< per row
    Eigen::MatrixXd normal;
    Eigen::VectorXd slope;
  };

  void build(Model& model) {
    const auto count = static_cast<Eigen::Index>(
        std::count_if(model.counted.begin(), model.counted.end(), [](Side s) { return s != Side::inside; }));
    active_.resize(x_.size(), count);
    off_.resize(count);
    Eigen::Index column = 0;
    for (int i = 0; i < rows_.size(); ++i) {
      const Side s = model.counted[static_cast<std::size_t>(i)];
      if (s == Side::inside) continue;
      active_.col(column) = jacobian_.row(i).transpose();
      off_[column++] = rows_[i] - (s == Side::above ? program_.row_upper()[i] : program_.row_lower()[i]);
    }
    model.slope.noalias() = active_ * off_;
    model.normal.setZero(x_.size(), x_.size());
    model.normal.selfadjointView<Eigen::Lower>().rankUpdate(active_);
    model.normal.triangularView<Eigen::StrictlyUpper>() = model.normal.transpose();
    if (curved_) model.normal += curvature_;
  }

  /// The model of what is violated at x, for all dampings.
  void start_model() {
    now_.counted.resize(static_cast<std::size_t>(rows_.size()));
    for (int i = 0; i < rows_.size(); ++i) now_.counted[static_cast<std::size_t>(i)] = side(rows_[i], i);
    build(now_);
  }

  /// The least violation of the linearized rows under the damping, within the bounds. Which rows will be violated and
  /// which bounds met is guessed from what is so now, then from the step itself. False: the model has no least value.
  bool propose(Eigen::VectorXd& next) {
    const Eigen::Index n = x_.size();
    pinned_.assign(static_cast<std::size_t>(n), Side::inside);
    for (Eigen::Index i = 0; i < n; ++i) {
      Side& pin = pinned_[static_cast<std::size_t>(i)];
      if (x_[i] <= program_.lower()[i] && now_.slope[i] > 0.0) pin = Side::below;
      if (x_[i] >= program_.upper()[i] && now_.slope[i] < 0.0) pin = Side::above;
    }
    const Model* model = &now_;
    for (int guess = 0; guess < most_guesses; ++guess) {
      if (!minimize(*model)) return false;
      if (view_ == View::here) break;
      if (guess == 0) guessed_.counted = now_.counted;
      const Eigen::VectorXd predicted = rows_ + jacobian_ * step_;
      bool same = true;
      for (int i = 0; i < rows_.size(); ++i) {
        Side& own = guessed_.counted[static_cast<std::size_t>(i)];
        const Side then = side(predicted[i], i);
        // A row that the step just satisfies stays: equations always count.
        const bool leaves = then == Side::inside && program_.is_equality(i);
        if (then == own || leaves) continue;
        own = then;
        same = false;
      }
      for (Eigen::Index i = 0; i < n; ++i) {
        Side& pin = pinned_[static_cast<std::size_t>(i)];
        if (pin != Side::inside) continue;
        if (x_[i] + step_[i] < program_.lower()[i]) pin = Side::below;
        if (x_[i] + step_[i] > program_.upper()[i]) pin = Side::above;
        same = same && pin == Side::inside;
      }
      if (same) break;
      build(guessed_);
      model = &guessed_;
    }
    next = (x_ + step_).cwiseMax(program_.lower()).cwiseMin(program_.upper());
    return true;
  }

  /// The damped step to the model's least value with pinned variables at their bounds. False: it has none.
  bool minimize(const Model& model) {
    damped_ = model.normal;
    step_ = model.slope;
    damped_.diagonal().array() += damping_ * (1.0 + damped_.diagonal().array().abs());
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      const Side pin = pinned_[static_cast<std::size_t>(i)];
      if (pin == Side::inside) continue;
      const double moved = (pin == Side::below ? program_.lower()[i] : program_.upper()[i]) - x_[i];
      step_ += moved * damped_.col(i);
      damped_.row(i).setZero();
      damped_.col(i).setZero();
      damped_(i, i) = 1.0;
      step_[i] = -moved;
    }
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(damped_);
    if (factors.info() != Eigen::Success) return false;
    factors.solveInPlace(step_);
    step_ = -step_;
    return true;
  }

  NonlinearProgram& program_;
  View view_;
  Eigen::VectorXd x_;
  Eigen::VectorXd rows_, violation_;
  Eigen::MatrixXd jacobian_, curvature_;
  Model now_, guessed_;
  std::vector<Side> pinned_;  ///< variables that the step holds at a bound
  Eigen::VectorXd step_;
  // Memory that is used again.
  Eigen::MatrixXd active_, damped_;
  Eigen::VectorXd off_, next_, next_rows_, next_violation_;
  double merit_ = 0.0;
  double damping_ = 1e-3;
  bool curved_ = false;  ///< the last step was slow
};

}  // namespace

FeasibilityReport restore_feasibility(NonlinearProgram& program, ConstVectorRef start, double tolerance,
                                      int max_iterations, const std::function<bool()>& stop) {
  FeasibilityReport near = Restoration(program, start, View::here).run(tolerance, max_iterations, stop);
  if (near.feasible || (stop && stop())) return near;
  // One stationary point of the violation is not the last word: the other way of looking may come around it.
  FeasibilityReport far = Restoration(program, start, View::ahead).run(tolerance, max_iterations, stop);
  far.iterations += near.iterations;
  if (!far.feasible && near.stationary_violation && near.infeasibility < far.infeasibility) {
    near.iterations = far.iterations;
    return near;
  }
  return far;
}

}  // namespace tendril
