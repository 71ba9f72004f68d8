#include "nlopt_solver.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "nlopt_run.hpp"
#include "nlopt_status.hpp"

namespace tendril::nlopt_plugin {

namespace {

/// NLopt's random numbers are one per process.
std::mutex random_lock;

}  // namespace

NloptSolver::NloptSolver(const Options& options)
    : options_(options),
      algorithm_(*find_algorithm(options.text("algorithm"))),
      inner_(find_algorithm(options.has("local_algorithm") ? options.text("local_algorithm")
                                                           : (algorithm_.gradient ? "LD_SLSQP" : "LN_SBPLX"))) {}

SolverCapabilities NloptSolver::capabilities() const {
  SolverCapabilities can;
  can.equalities = algorithm_.equalities;
  can.inequalities = algorithm_.inequalities;
  can.needs_finite_bounds = algorithm_.finite_bounds;
  can.uses_gradient = algorithm_.gradient;
  return can;
}

std::string NloptSolver::refusal(const NonlinearProgram& program) const {
  if (std::string why = Solver::refusal(program); !why.empty()) return why;
  const int n = program.variable_count();
  int equality_count = 0;
  for (int i = 0; i < program.row_count(); ++i) equality_count += program.is_equality(i) ? 1 : 0;
  if (n < algorithm_.least_variables) {
    return name() + " needs at least " + std::to_string(algorithm_.least_variables) + " variables, found " +
           std::to_string(n);
  }
  if (equality_count > n) {
    return name() + " cannot take more equality constraints than variables: " + std::to_string(equality_count) +
           " rows, " + std::to_string(n) + " variables";
  }
  if (!algorithm_.bounds) {
    for (int i = 0; i < n; ++i) {
      if (std::isfinite(program.lower()[i]) || std::isfinite(program.upper()[i])) {
        return name() + " cannot take bounds: " + program.variable_name(i) + " has one";
      }
    }
  }
  if (!algorithm_.has_inner) return "";
  const std::string inner = "local_algorithm " + std::string(inner_->name) + " of " + name();
  if (inner_->has_inner) return inner + " needs a local algorithm itself";
  if (inner_->gradient && !algorithm_.gradient)
    return inner + " needs gradients, which an N algorithm does not hand on";
  const bool keeps_inequalities = algorithm_.name.ends_with("_EQ");
  if (keeps_inequalities && equality_count < program.row_count() && !inner_->inequalities) {
    return inner + " cannot take inequality constraints, which stay with it";
  }
  if (inner_->finite_bounds && !algorithm_.finite_bounds) return inner + " needs finite bounds";
  return "";
}

NloptSolver::Outcome NloptSolver::do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) {
  Run run{callbacks};
  run.take_rows();
  run.uses_gradient = algorithm_.gradient;
  run.halves_step = algorithm_.halves_step;
  run.iteration_limit = control.max_iterations;

  std::unique_lock<std::mutex> one_seed(random_lock, std::defer_lock);
  if (algorithm_.random) {
    one_seed.lock();
    nlopt_srand(static_cast<unsigned long>(options_.integer("seed")));
  }

  run.last = start.x;
  Outcome outcome;
  outcome.x.assign(start.x.begin(), start.x.end());
  const Handle opt = create(run, control);
  // A run can end at a point that is neither feasible nor stationary; a fresh one from there, which forgets the
  // curvature collected so far, often goes on.
  const bool sqp = algorithm_.name == "LD_SLSQP";
  Verdict best;
  for (int round = 0; round < 4; ++round) {
    double cost = 0.0;
    run.stuck = false;
    run.searched = 0;
    const nlopt_result result = nlopt_optimize(opt.get(), outcome.x.data(), &cost);
    outcome.native_status = words(result);
    outcome.status = run.status_of(result);
    if (const char* detail = nlopt_get_errmsg(opt.get()); result == NLOPT_INVALID_ARGS && detail != nullptr) {
      outcome.native_status += std::string(" (") + detail + ")";
    }
    const bool ended_by_itself = outcome.status == SolveStatus::converged || outcome.status == SolveStatus::stalled;
    if (!sqp || callbacks.has_exception() || !ended_by_itself) break;
    Verdict now = better_end(run, control, outcome.x);
    if (!now.feasible) {
      restore(callbacks, control, outcome.x);
      now = judge(callbacks, control, VectorView(outcome.x.data(), static_cast<Eigen::Index>(outcome.x.size())));
    }
    outcome.status = now.good ? SolveStatus::converged : SolveStatus::stalled;
    const bool progress = now.feasible && now.defect < 0.5 * best.defect;
    best = now;
    if (now.good || !progress) break;
  }
  if (run.limit_met) outcome.x.clear();
  outcome.iterations = std::clamp(run.iterations(), 0, control.max_iterations);
  outcome.effective_options = effective(opt.get(), control);
  return outcome;
}

}  // namespace tendril::nlopt_plugin
