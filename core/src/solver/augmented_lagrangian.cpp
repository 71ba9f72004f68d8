#include "tendril/augmented_lagrangian.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <exception>

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

namespace {

/// Everything that the outer loop knows; `Program` is Solver::Callbacks, which only solvers may name.
template <class Program>
struct State {
  State(Program& callbacks, const VectorView& start)
      : program(callbacks),
        x(start),
        center(start),
        multipliers(Eigen::VectorXd::Zero(callbacks.program().row_count())),
        bound_multipliers(Eigen::VectorXd::Zero(start.size())),
        rest_gradient(Eigen::VectorXd::Zero(start.size())) {
    for (int i = 0; i < start.size(); ++i) {
      if (callbacks.program().lower()[i] < callbacks.program().upper()[i]) free.push_back(i);
    }
    rest_hessian = Eigen::MatrixXd::Zero(free_count(), free_count());
  }

  Eigen::Index free_count() const { return static_cast<Eigen::Index>(free.size()); }
  Eigen::VectorXd reduced(const Eigen::VectorXd& full) const {
    Eigen::VectorXd v(free_count());
    for (Eigen::Index k = 0; k < v.size(); ++k) v[k] = full[free[static_cast<std::size_t>(k)]];
    return v;
  }
  void expand(const double* values, Eigen::VectorXd& full) const {
    for (std::size_t k = 0; k < free.size(); ++k) full[free[k]] = values[k];
  }

  /// s - clamp(s, l, u) with s = value + y/rho: zero where an inequality is not pressed.
  static double pressed(double value, double y, double rho, double lower, double upper) {
    const double s = value + y / rho;
    return s - std::clamp(s, lower, upper);
  }

  /// The augmented Lagrangian itself, with the true rest and without the proximal term.
  double merit(const Eigen::VectorXd& at) {
    const NonlinearProgram& p = program.program();
    double sum = program.cost(at);
    const VectorView c = program.constraints(at);
    for (int i = 0; i < p.row_count(); ++i) {
      sum += 0.5 * penalty * std::pow(pressed(c[i], multipliers[i], penalty, p.row_lower()[i], p.row_upper()[i]), 2);
    }
    for (const int i : free) {
      sum += 0.5 * penalty * std::pow(pressed(at[i], bound_multipliers[i], penalty, p.lower()[i], p.upper()[i]), 2);
    }
    return sum;
  }

  /// Moves the centre of the proximal term to x and takes the rest's derivatives there; with `curved` also the
  /// curvature of the rows, which Gauss and Newton leave out and without which a pressed row can make them crawl.
  void recenter() {
    const NonlinearProgram& p = program.program();
    center = x;
    rest_gradient = program.rest_gradient(x);
    // A rest need not be there at every point (a hinge is not): what counts is whether it is here.
    has_rest = program.rest(x) != 0.0 || !rest_gradient.isZero(0.0);
    rest_hessian.setZero();
    if (!curved && !has_rest) return;
    Eigen::VectorXd pressure = Eigen::VectorXd::Zero(p.row_count());
    if (curved) {
      const VectorView c = program.constraints(x);
      for (int i = 0; i < p.row_count(); ++i) {
        pressure[i] = penalty * pressed(c[i], multipliers[i], penalty, p.row_lower()[i], p.row_upper()[i]);
      }
    }
    // The cost's Hessian less what Gauss and Newton know of the squares is the rest's, but for the curvature of the
    // residuals.
    Eigen::MatrixXd h = program.hessian(x, 1.0, pressure);
    if (p.residual_count() > 0) {
      const MatrixView j = program.residual_jacobian(x);
      h -= 2.0 * j.transpose() * j;
    }
    for (Eigen::Index a = 0; a < free_count(); ++a) {
      for (Eigen::Index b = 0; b < free_count(); ++b) {
        rest_hessian(a, b) = h(free[static_cast<std::size_t>(a)], free[static_cast<std::size_t>(b)]);
      }
    }
  }

  /// W^(1/2) and W^(-1/2) grad rest for the current weight.
  void factor() {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rest_hessian);
    const Eigen::ArrayXd root = (eigen.eigenvalues().array().abs() + weight).sqrt();
    proximal_root = root.matrix().asDiagonal() * eigen.eigenvectors().transpose();
    proximal_offset = (eigen.eigenvectors().transpose() * reduced(rest_gradient)).array() / root;
  }

  struct Conditions {
    double violation = infinity;
    double slope = infinity;
    double worst() const { return std::max(violation, slope); }
  };

  /// First-order conditions at x with the multipliers as they are; violation includes complementarity.
  Conditions conditions() {
    const NonlinearProgram& p = program.program();
    const Eigen::VectorXd lagrangian =
        program.gradient(x) + program.jacobian(x).transpose() * multipliers + bound_multipliers;
    const VectorView c = program.constraints(x);
    Conditions now{0.0, 0.0};
    for (const int i : free) {
      now.slope = std::max(now.slope, std::abs(lagrangian[i]));
      now.violation = std::max(
          now.violation,
          std::abs(pressed(x[i], bound_multipliers[i], 1.0, p.lower()[i], p.upper()[i]) - bound_multipliers[i]));
    }
    for (int i = 0; i < p.row_count(); ++i) {
      now.violation =
          std::max(now.violation,
                   std::abs(pressed(c[i], multipliers[i], 1.0, p.row_lower()[i], p.row_upper()[i]) - multipliers[i]));
    }
    now.slope /= std::max(1.0, program.gradient(x).template lpNorm<Eigen::Infinity>());
    return now;
  }

  /// Largest violation of rows and bounds, and of complementarity with the multipliers on trial.
  double violation() {
    const NonlinearProgram& p = program.program();
    const VectorView c = program.constraints(x);
    const auto measure = [&](double value, double y, double lower, double upper) {
      return std::abs(pressed(value, y, penalty, lower, upper) - y / penalty);
    };
    double worst = 0.0;
    for (int i = 0; i < p.row_count(); ++i)
      worst = std::max(worst, measure(c[i], multipliers[i], p.row_lower()[i], p.row_upper()[i]));
    for (const int i : free) worst = std::max(worst, measure(x[i], bound_multipliers[i], p.lower()[i], p.upper()[i]));
    return worst;
  }

  void update_multipliers() {
    const NonlinearProgram& p = program.program();
    const VectorView c = program.constraints(x);
    const auto next = [&](double value, double y, double lower, double upper) {
      return std::clamp(penalty * pressed(value, y, penalty, lower, upper), -largest_multiplier, largest_multiplier);
    };
    for (int i = 0; i < p.row_count(); ++i)
      multipliers[i] = next(c[i], multipliers[i], p.row_lower()[i], p.row_upper()[i]);
    for (const int i : free) bound_multipliers[i] = next(x[i], bound_multipliers[i], p.lower()[i], p.upper()[i]);
  }

  Program& program;
  std::vector<int> free;  ///< variables that are not fixed
  Eigen::VectorXd x, center, multipliers, bound_multipliers, rest_gradient;
  Eigen::MatrixXd rest_hessian, proximal_root;
  Eigen::VectorXd proximal_offset;
  double penalty = first_penalty;
  double weight = first_weight;
  bool has_rest = false;  ///< at the centre
  bool curved = false;
};

}  // namespace

AugmentedLagrangianSolver::Outcome AugmentedLagrangianSolver::do_solve(Callbacks& callbacks, const Start& start,
                                                                       const SolveControl& control) {
  using Loop = State<Callbacks>;

  class Squares final : public Subproblem {
   public:
    Squares(Loop& loop, const SolveControl& limits)
        : loop_(loop), limits_(limits), full_(loop.x), rows_(loop.multipliers.size()), count_(loop.free_count()) {}

    int variable_count() const override { return static_cast<int>(count_); }
    int residual_count() const override {
      return loop_.program.program().residual_count() + static_cast<int>(rows_ + 2 * count_);
    }
    double gradient_tolerance() const override { return tolerance; }
    int iteration_limit() const override { return std::max(1, std::min(50, limits_.max_iterations - used)); }
    double seconds_left() const override { return loop_.program.seconds_left(); }

    bool evaluate(const double* x, double* residuals, double* jacobian) override {
      if (failure || loop_.program.has_exception()) return false;
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
    int used = 0;
    std::exception_ptr not_finite;
    std::exception_ptr failure;

   private:
    void write(double* residuals, double* jacobian) {
      const NonlinearProgram& p = loop_.program.program();
      const Eigen::Index squares = p.residual_count();
      Eigen::Map<Eigen::VectorXd> r(residuals, residual_count());
      // Derivatives first, so that values come with them in one evaluation.
      if (jacobian != nullptr) {
        Eigen::Map<RowMajor> j(jacobian, residual_count(), count_);
        j.setZero();
        if (squares > 0) copy_free(std::sqrt(2.0), loop_.program.residual_jacobian(full_), jacobian);
        if (rows_ > 0) copy_free(std::sqrt(loop_.penalty), loop_.program.jacobian(full_), jacobian + squares * count_);
        j.bottomRows(count_) = loop_.proximal_root;
      } else {
        loop_.program.cost(full_);
      }
      if (squares > 0) r.head(squares) = std::sqrt(2.0) * loop_.program.residuals(full_);
      if (rows_ > 0) press_rows(r.segment(squares, rows_), jacobian, squares);
      press_bounds(r.segment(squares + rows_, count_), jacobian, squares + rows_);
      r.tail(count_) = loop_.proximal_root * loop_.reduced(full_ - loop_.center) + loop_.proximal_offset;
    }

    void copy_free(double factor, const MatrixView& from, double* to) const {
      Eigen::Map<RowMajor> j(to, from.rows(), count_);
      for (Eigen::Index k = 0; k < count_; ++k) j.col(k) = factor * from.col(loop_.free[static_cast<std::size_t>(k)]);
    }

    void press_rows(VectorRef r, double* jacobian, Eigen::Index first) {
      const NonlinearProgram& p = loop_.program.program();
      const VectorView c = loop_.program.constraints(full_);
      for (int i = 0; i < rows_; ++i) {
        const double v = Loop::pressed(c[i], loop_.multipliers[i], loop_.penalty, p.row_lower()[i], p.row_upper()[i]);
        r[i] = std::sqrt(loop_.penalty) * v;
        if (v == 0.0 && !p.is_equality(i) && jacobian != nullptr)
          std::fill_n(jacobian + (first + i) * count_, count_, 0.0);
      }
    }

    void press_bounds(VectorRef r, double* jacobian, Eigen::Index first) {
      const NonlinearProgram& p = loop_.program.program();
      for (Eigen::Index k = 0; k < count_; ++k) {
        const int i = loop_.free[static_cast<std::size_t>(k)];
        const double v = Loop::pressed(full_[i], loop_.bound_multipliers[i], loop_.penalty, p.lower()[i], p.upper()[i]);
        r[k] = std::sqrt(loop_.penalty) * v;
        if (v != 0.0 && jacobian != nullptr) jacobian[(first + k) * count_ + k] = std::sqrt(loop_.penalty);
      }
    }

    Loop& loop_;
    const SolveControl& limits_;
    Eigen::VectorXd full_;
    Eigen::Index rows_;
    Eigen::Index count_;
  };

  Outcome outcome;
  Loop loop(callbacks, start.x);
  if (start.multipliers.size() > 0) loop.multipliers = start.multipliers;
  if (start.bound_multipliers.size() > 0) loop.bound_multipliers = start.bound_multipliers;
  outcome.effective_options = effective_options();
  const auto end = [&](SolveStatus status, const std::string& words) {
    outcome.status = status;
    outcome.native_status = words;
    outcome.x.assign(loop.x.begin(), loop.x.end());
    outcome.multipliers.assign(loop.multipliers.begin(), loop.multipliers.end());
    outcome.bound_multipliers.assign(loop.bound_multipliers.begin(), loop.bound_multipliers.end());
    outcome.effective_options["penalty"] = shown(loop.penalty);
    return outcome;
  };

  // A polished point is taken if it is near and not worse: Newton may as well run to a saddle or a maximum.
  double near_enough = 1e-2;
  const auto sharpened = [&](const typename Loop::Conditions& now) {
    if (now.worst() > near_enough) return false;
    near_enough = 0.1 * now.worst();
    Loop trial = loop;
    for (const int i : trial.free) {
      const NonlinearProgram& p = callbacks.program();
      if (trial.bound_multipliers[i] < 0.0 && trial.x[i] - p.lower()[i] < 0.1) trial.x[i] = p.lower()[i];
      if (trial.bound_multipliers[i] > 0.0 && p.upper()[i] - trial.x[i] < 0.1) trial.x[i] = p.upper()[i];
    }
    if (!callbacks.polish(trial.x, trial.multipliers, trial.bound_multipliers, std::max(1e-5, 10.0 * now.violation)))
      return false;
    const double reach = 0.1 * (1.0 + loop.x.norm());
    const double slack = 10.0 * now.worst() * (1.0 + std::abs(callbacks.cost(loop.x)));
    if ((trial.x - loop.x).norm() > reach || callbacks.cost(trial.x) > loop.merit(loop.x) + slack) return false;
    loop.x = trial.x;
    loop.multipliers = trial.multipliers;
    loop.bound_multipliers = trial.bound_multipliers;
    return true;
  };

  if (loop.free.empty()) return end(SolveStatus::converged, "every variable is fixed");
  Squares squares(loop, control);
  typename Loop::Conditions now = loop.conditions();
  if (start.has_multipliers() && sharpened(now)) return end(SolveStatus::converged, "polished");
  double last_violation = loop.violation();
  int unfallen = 0;
  int rejected = 0;
  while (squares.used < control.max_iterations) {
    loop.recenter();
    loop.factor();
    squares.tolerance = std::clamp(0.1 * now.worst(), 0.1 * control.tolerance, 1e-1);
    const double before = loop.merit(loop.x);
    Eigen::VectorXd reduced = loop.reduced(loop.x);
    squares.not_finite = nullptr;
    const Reduction reduction = reduce(squares, reduced.data());
    squares.used += std::max(1, reduction.iterations);
    outcome.iterations = std::min(squares.used, control.max_iterations);
    if (squares.failure) std::rethrow_exception(squares.failure);
    const bool moved = reduced != loop.reduced(loop.x);
    if (squares.not_finite && !(reduction.usable && moved)) std::rethrow_exception(squares.not_finite);
    if (!reduction.usable) {
      return end(SolveStatus::stalled, reduction.words);
    }
    const Eigen::VectorXd from = loop.x;
    loop.expand(reduced.data(), loop.x);

    // The rest was taken as its model: if the true function does not follow, ask for a shorter step.
    const bool has_model = loop.has_rest || callbacks.rest(loop.x) != 0.0;
    if (has_model && loop.merit(loop.x) > before + 1e-10 * (1.0 + std::abs(before))) {
      loop.x = from;
      loop.weight = std::max(10.0 * loop.weight, 1e-2);
      if (++rejected > 40 || loop.weight > largest_weight) return end(SolveStatus::stalled, "no descent");
      continue;
    }
    rejected = 0;
    loop.curved = loop.curved || !reduction.finished;
    loop.weight = std::max(least_weight, 0.2 * loop.weight);
    // Multipliers from an unfinished inner solve lead astray unless the rows came nearer all the same.
    const double violation = loop.violation();
    if (reduction.finished || violation <= 0.5 * last_violation) loop.update_multipliers();
    now = loop.conditions();
    if (now.worst() <= control.tolerance) return end(SolveStatus::converged, reduction.words);
    if (sharpened(now)) return end(SolveStatus::converged, "polished");
    const bool fell = violation <= 0.25 * last_violation || violation <= 0.1 * now.slope;
    unfallen = violation <= 0.9 * last_violation ? 0 : unfallen + 1;
    if (!fell) loop.penalty *= 5.0;
    // A violation that six larger penalties leave as it is will not fall any more.
    if (loop.penalty > largest_penalty ||
        (unfallen > 6 && loop.penalty > hopeless_penalty && violation > control.tolerance)) {
      return end(SolveStatus::stalled, "the violation does not fall");
    }
    last_violation = violation;
  }
  return end(SolveStatus::iteration_limit, "iteration limit");
}

}  // namespace tendril
