#include "tendril/augmented_lagrangian.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <optional>

#include "nlp/multipliers.hpp"

namespace tendril {

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double first_penalty = 10.0;
constexpr double largest_penalty = 1e10;
constexpr double hopeless_penalty = 1e6;
constexpr double largest_multiplier = 1e9;
/// The proximal weight: small enough not to slow a well-posed program, large enough to keep linear costs from running
/// away.
constexpr double least_weight = 1e-6;
constexpr double first_weight = 1e-2;
constexpr double largest_weight = 1e12;

}  // namespace

AugmentedLagrangianSolver::~AugmentedLagrangianSolver() = default;
AugmentedLagrangianSolver::Subproblem::~Subproblem() = default;

SolverCapabilities AugmentedLagrangianSolver::capabilities() const {
  SolverCapabilities can;
  can.uses_hessian = true;
  return can;
}

/// The outer loop and everything that it knows.
class AugmentedLagrangianSolver::Loop {
 public:
  using Reduce = std::function<Reduction(Subproblem&, double*)>;
  struct End {
    SolveStatus status;
    std::string words;
  };

  Loop(Callbacks& callbacks, const Start& start, const SolveControl& control)
      : program_(callbacks),
        control_(control),
        warm_(start.has_multipliers()),
        x_(start.x),
        center_(start.x),
        multipliers_(Eigen::VectorXd::Zero(callbacks.program().row_count())),
        bound_multipliers_(Eigen::VectorXd::Zero(start.x.size())),
        rest_gradient_(Eigen::VectorXd::Zero(start.x.size())) {
    for (int i = 0; i < x_.size(); ++i) {
      if (callbacks.program().lower()[i] < callbacks.program().upper()[i]) free_.push_back(i);
    }
    rest_hessian_ = Eigen::MatrixXd::Zero(free_count(), free_count());
    if (start.multipliers.size() > 0) multipliers_ = start.multipliers;
    if (start.bound_multipliers.size() > 0) bound_multipliers_ = start.bound_multipliers;
  }

  End run(const Reduce& reduce);

  Outcome outcome(const End& end) const {
    Outcome outcome;
    outcome.status = end.status;
    outcome.native_status = end.words;
    outcome.x.assign(x_.begin(), x_.end());
    outcome.multipliers.assign(multipliers_.begin(), multipliers_.end());
    outcome.bound_multipliers.assign(bound_multipliers_.begin(), bound_multipliers_.end());
    outcome.iterations = std::min(used_, control_.max_iterations);
    outcome.effective_options["penalty"] = shown(penalty_);
    return outcome;
  }

 private:
  class Squares;
  struct Conditions {
    double violation = infinity;
    double slope = infinity;
    double worst() const { return std::max(violation, slope); }
  };

  Eigen::Index free_count() const { return static_cast<Eigen::Index>(free_.size()); }
  Eigen::VectorXd reduced(const Eigen::VectorXd& full) const {
    Eigen::VectorXd v(free_count());
    for (Eigen::Index k = 0; k < v.size(); ++k) v[k] = full[free_[static_cast<std::size_t>(k)]];
    return v;
  }
  void expand(const double* values, Eigen::VectorXd& full) const {
    for (std::size_t k = 0; k < free_.size(); ++k) full[free_[k]] = values[k];
  }

  /// s - clamp(s, l, u) with s = value + y/rho: zero where an inequality is not pressed.
  static double pressed(double value, double y, double rho, double lower, double upper) {
    const double s = value + y / rho;
    return s - std::clamp(s, lower, upper);
  }

  /// Calls f(value, multiplier, lower limit, upper limit) for every row and every variable that is not fixed.
  template <class F>
  void for_each_limit(const Eigen::VectorXd& at, F&& f) {
    const NonlinearProgram& p = program_.program();
    const VectorView c = program_.constraints(at);
    for (int i = 0; i < p.row_count(); ++i) f(c[i], multipliers_[i], p.row_lower()[i], p.row_upper()[i]);
    for (const int i : free_) f(at[i], bound_multipliers_[i], p.lower()[i], p.upper()[i]);
  }

  /// The augmented Lagrangian itself, with the true rest and without the proximal term.
  double merit(const Eigen::VectorXd& at) {
    double sum = program_.cost(at);
    for_each_limit(at, [&](double value, double y, double lower, double upper) {
      sum += 0.5 * penalty_ * std::pow(pressed(value, y, penalty_, lower, upper), 2);
    });
    return sum;
  }

  /// Moves the centre of the proximal term to x and takes the rest's derivatives there; with `curved` also the
  /// curvature of the rows, which Gauss and Newton leave out and without which a pressed row can make them crawl.
  void recenter() {
    const NonlinearProgram& p = program_.program();
    const VectorView rest_gradient = program_.rest_gradient(x_);
    // A rest need not be there at every point (a hinge is not): what counts is whether it is here. One whose gradient
    // stayed what it was over the last step is taken to be linear: the Hessian would only bring the residuals'
    // curvature.
    has_rest_ = program_.rest(x_) != 0.0 || !rest_gradient.isZero(0.0);
    if (x_ != center_) rest_curves_ = rest_gradient != rest_gradient_;
    center_ = x_;
    rest_gradient_ = rest_gradient;
    rest_hessian_.setZero();
    if (!curved_ && !(has_rest_ && rest_curves_)) return;
    Eigen::VectorXd pressure = Eigen::VectorXd::Zero(p.row_count());
    if (curved_) {
      const VectorView c = program_.constraints(x_);
      for (int i = 0; i < p.row_count(); ++i) {
        pressure[i] = penalty_ * pressed(c[i], multipliers_[i], penalty_, p.row_lower()[i], p.row_upper()[i]);
      }
    }
    // The cost's Hessian less what Gauss and Newton know of the squares is the rest's, but for the curvature of the
    // residuals.
    Eigen::MatrixXd h = program_.hessian(x_, 1.0, pressure);
    if (p.residual_count() > 0) {
      const MatrixView j = program_.residual_jacobian(x_);
      h -= 2.0 * j.transpose() * j;
    }
    for (Eigen::Index a = 0; a < free_count(); ++a) {
      for (Eigen::Index b = 0; b < free_count(); ++b) {
        rest_hessian_(a, b) = h(free_[static_cast<std::size_t>(a)], free_[static_cast<std::size_t>(b)]);
      }
    }
  }

  /// W^(1/2) and W^(-1/2) grad rest for the current weight.
  void factor() {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rest_hessian_);
    const Eigen::ArrayXd root = (eigen.eigenvalues().array().abs() + weight_).sqrt();
    proximal_root_ = root.matrix().asDiagonal() * eigen.eigenvectors().transpose();
    proximal_offset_ = (eigen.eigenvectors().transpose() * reduced(rest_gradient_)).array() / root;
  }

  /// First-order conditions at x with the multipliers as they are; violation includes complementarity.
  Conditions conditions() {
    const Eigen::VectorXd lagrangian =
        program_.gradient(x_) + program_.jacobian(x_).transpose() * multipliers_ + bound_multipliers_;
    Conditions now{violation(1.0), 0.0};
    for (const int i : free_) now.slope = std::max(now.slope, std::abs(lagrangian[i]));
    now.slope /= std::max(1.0, program_.gradient(x_).lpNorm<Eigen::Infinity>());
    return now;
  }

  /// Largest violation of rows and bounds, and of complementarity with the multipliers on trial.
  double violation(double penalty) {
    double worst = 0.0;
    for_each_limit(x_, [&](double value, double y, double lower, double upper) {
      worst = std::max(worst, std::abs(pressed(value, y, penalty, lower, upper) - y / penalty));
    });
    return worst;
  }

  void update_multipliers() {
    for_each_limit(x_, [&](double value, double& y, double lower, double upper) {
      y = std::clamp(penalty_ * pressed(value, y, penalty_, lower, upper), -largest_multiplier, largest_multiplier);
    });
  }

  bool sharpened();
  std::optional<End> advance(Squares& squares, const Reduce& reduce);
  Reduction reduce_squares(Squares& squares, const Reduce& reduce);
  bool shorten(const Eigen::VectorXd& from);

  Callbacks& program_;
  const SolveControl& control_;
  bool warm_;
  std::vector<int> free_;  ///< variables that are not fixed
  Eigen::VectorXd x_, center_, multipliers_, bound_multipliers_, rest_gradient_;
  Eigen::MatrixXd rest_hessian_, proximal_root_;
  Eigen::VectorXd proximal_offset_;
  double penalty_ = first_penalty;
  double weight_ = first_weight;
  bool has_rest_ = false;    ///< at the centre
  bool rest_curves_ = true;  ///< as far as the last step shows
  bool curved_ = false;
  Conditions now_;
  double near_enough_ = 1e-2;  ///< for the polish to be tried
  double last_violation_ = infinity;
  int unfallen_ = 0;
  int rejected_ = 0;
  int used_ = 0;  ///< iterations of the library
};

/// The augmented Lagrangian around the loop's centre as a sum of squares in the variables that are not fixed.
class AugmentedLagrangianSolver::Loop::Squares final : public Subproblem {
 public:
  explicit Squares(Loop& loop)
      : loop_(loop), full_(loop.x_), rows_(loop.multipliers_.size()), count_(loop.free_count()) {}

  int variable_count() const override { return static_cast<int>(count_); }
  int residual_count() const override {
    return loop_.program_.program().residual_count() + static_cast<int>(rows_ + 2 * count_);
  }
  double gradient_tolerance() const override { return tolerance; }
  int iteration_limit() const override {
    return std::max(1, std::min(50, loop_.control_.max_iterations - loop_.used_));
  }
  double seconds_left() const override { return loop_.program_.seconds_left(); }

  bool evaluate(const double* x, double* residuals, double* jacobian) override {
    if (failure || loop_.program_.has_exception()) return false;
    try {
      loop_.expand(x, full_);
      write(residuals, jacobian);
      return true;
    } catch (const NotFiniteError&) {
      not_finite = std::current_exception();
    } catch (...) {
      failure = std::current_exception();
    }
    return false;
  }

  double tolerance = 1e-3;
  std::exception_ptr not_finite;
  std::exception_ptr failure;

 private:
  void write(double* residuals, double* jacobian) {
    const NonlinearProgram& p = loop_.program_.program();
    const Eigen::Index squares = p.residual_count();
    Eigen::Map<Eigen::VectorXd> r(residuals, residual_count());
    // Derivatives first, so that values come with them in one evaluation.
    if (jacobian != nullptr) {
      Eigen::Map<RowMajor> j(jacobian, residual_count(), count_);
      j.setZero();
      if (squares > 0) copy_free(std::sqrt(2.0), loop_.program_.residual_jacobian(full_), jacobian);
      if (rows_ > 0) copy_free(std::sqrt(loop_.penalty_), loop_.program_.jacobian(full_), jacobian + squares * count_);
      j.bottomRows(count_) = loop_.proximal_root_;
    } else {
      loop_.program_.cost(full_);
    }
    if (squares > 0) r.head(squares) = std::sqrt(2.0) * loop_.program_.residuals(full_);
    if (rows_ > 0) press_rows(r.segment(squares, rows_), jacobian, squares);
    press_bounds(r.segment(squares + rows_, count_), jacobian, squares + rows_);
    r.tail(count_) = loop_.proximal_root_ * loop_.reduced(full_ - loop_.center_) + loop_.proximal_offset_;
  }

  void copy_free(double factor, const MatrixView& from, double* to) const {
    Eigen::Map<RowMajor> j(to, from.rows(), count_);
    for (Eigen::Index k = 0; k < count_; ++k) j.col(k) = factor * from.col(loop_.free_[static_cast<std::size_t>(k)]);
  }

  void press_rows(VectorRef r, double* jacobian, Eigen::Index first) {
    const NonlinearProgram& p = loop_.program_.program();
    const VectorView c = loop_.program_.constraints(full_);
    for (int i = 0; i < rows_; ++i) {
      const double v = pressed(c[i], loop_.multipliers_[i], loop_.penalty_, p.row_lower()[i], p.row_upper()[i]);
      r[i] = std::sqrt(loop_.penalty_) * v;
      if (v == 0.0 && !p.is_equality(i) && jacobian != nullptr)
        std::fill_n(jacobian + (first + i) * count_, count_, 0.0);
    }
  }

  void press_bounds(VectorRef r, double* jacobian, Eigen::Index first) {
    const NonlinearProgram& p = loop_.program_.program();
    for (Eigen::Index k = 0; k < count_; ++k) {
      const int i = loop_.free_[static_cast<std::size_t>(k)];
      const double v = pressed(full_[i], loop_.bound_multipliers_[i], loop_.penalty_, p.lower()[i], p.upper()[i]);
      r[k] = std::sqrt(loop_.penalty_) * v;
      if (v != 0.0 && jacobian != nullptr) jacobian[(first + k) * count_ + k] = std::sqrt(loop_.penalty_);
    }
  }

  Loop& loop_;
  Eigen::VectorXd full_;
  Eigen::Index rows_;
  Eigen::Index count_;
};

/// A polished point is taken if it is near and not worse: Newton may as well run to a saddle or a maximum.
bool AugmentedLagrangianSolver::Loop::sharpened() {
  if (now_.worst() > near_enough_) return false;
  near_enough_ = 0.1 * now_.worst();
  Eigen::VectorXd x = x_, multipliers = multipliers_, bound_multipliers = bound_multipliers_;
  const NonlinearProgram& p = program_.program();
  for (const int i : free_) {
    if (bound_multipliers[i] < 0.0 && x[i] - p.lower()[i] < 0.1) x[i] = p.lower()[i];
    if (bound_multipliers[i] > 0.0 && p.upper()[i] - x[i] < 0.1) x[i] = p.upper()[i];
  }
  if (!program_.polish(x, multipliers, bound_multipliers, std::max(1e-5, 10.0 * now_.violation))) return false;
  const double reach = 0.1 * (1.0 + x_.norm());
  const double slack = 10.0 * now_.worst() * (1.0 + std::abs(program_.cost(x_)));
  if ((x - x_).norm() > reach || program_.cost(x) > merit(x_) + slack) return false;
  x_ = x;
  multipliers_ = multipliers;
  bound_multipliers_ = bound_multipliers;
  return true;
}

AugmentedLagrangianSolver::Loop::End AugmentedLagrangianSolver::Loop::run(const Reduce& reduce) {
  if (free_.empty()) return {SolveStatus::converged, "every variable is fixed"};
  Squares squares(*this);
  now_ = conditions();
  if (warm_ && sharpened()) return {SolveStatus::converged, "polished"};
  last_violation_ = violation(penalty_);
  while (used_ < control_.max_iterations) {
    if (const std::optional<End> end = advance(squares, reduce)) return *end;
  }
  return {SolveStatus::iteration_limit, "iteration limit"};
}

/// One reduction from the centre; x moves to its end if that is usable.
AugmentedLagrangianSolver::Reduction AugmentedLagrangianSolver::Loop::reduce_squares(Squares& squares,
                                                                                     const Reduce& reduce) {
  squares.tolerance = std::clamp(0.1 * now_.worst(), 0.1 * control_.tolerance, 1e-1);
  squares.not_finite = nullptr;
  const Eigen::VectorXd before = reduced(x_);
  Eigen::VectorXd after = before;
  Reduction reduction = reduce(squares, after.data());
  used_ += std::max(1, reduction.iterations);
  if (squares.failure) std::rethrow_exception(squares.failure);
  if (squares.not_finite && !(reduction.usable && after != before)) std::rethrow_exception(squares.not_finite);
  if (reduction.usable) expand(after.data(), x_);
  return reduction;
}

/// Back, and a shorter step next; false: steps have become too short.
bool AugmentedLagrangianSolver::Loop::shorten(const Eigen::VectorXd& from) {
  x_ = from;
  weight_ = std::max(10.0 * weight_, 1e-2);
  return ++rejected_ <= 40 && weight_ <= largest_weight;
}

std::optional<AugmentedLagrangianSolver::Loop::End> AugmentedLagrangianSolver::Loop::advance(Squares& squares,
                                                                                             const Reduce& reduce) {
  recenter();
  factor();
  const Eigen::VectorXd from = x_;
  const double before = merit(from);
  const Reduction reduction = reduce_squares(squares, reduce);
  if (!reduction.usable) return End{SolveStatus::stalled, reduction.words};

  // The rest was taken as its model: if the true function does not follow, ask for a shorter step.
  const bool has_model = has_rest_ || program_.rest(x_) != 0.0;
  if (has_model && merit(x_) > before + 1e-10 * (1.0 + std::abs(before))) {
    if (shorten(from)) return std::nullopt;
    return End{SolveStatus::stalled, "no descent"};
  }
  rejected_ = 0;
  curved_ = curved_ || !reduction.finished;
  weight_ = std::max(least_weight, 0.2 * weight_);
  // Multipliers from an unfinished inner solve lead astray unless the rows came nearer all the same.
  const double violated = violation(penalty_);
  if (reduction.finished || violated <= 0.5 * last_violation_) update_multipliers();
  now_ = conditions();
  if (now_.worst() <= control_.tolerance) return End{SolveStatus::converged, reduction.words};
  if (sharpened()) return End{SolveStatus::converged, "polished"};
  const bool fell = violated <= 0.25 * last_violation_ || violated <= 0.1 * now_.slope;
  unfallen_ = violated <= 0.9 * last_violation_ ? 0 : unfallen_ + 1;
  if (!fell) penalty_ *= 5.0;
  // A violation that six larger penalties leave as it is will not fall any more.
  if (penalty_ > largest_penalty || (unfallen_ > 6 && penalty_ > hopeless_penalty && violated > control_.tolerance)) {
    return End{SolveStatus::stalled, "the violation does not fall"};
  }
  last_violation_ = violated;
  return std::nullopt;
}

AugmentedLagrangianSolver::Outcome AugmentedLagrangianSolver::do_solve(Callbacks& callbacks, const Start& start,
                                                                       const SolveControl& control) {
  Loop loop(callbacks, start, control);
  const Loop::End end = loop.run([this](Subproblem& squares, double* x) { return reduce(squares, x); });
  Outcome outcome = loop.outcome(end);
  outcome.effective_options.merge(effective_options());
  return outcome;
}

}  // namespace tendril
