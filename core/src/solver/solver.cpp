#include "tendril/solver.hpp"

#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "solver/refusal.hpp"
#include "solver/stop.hpp"
#include "solver/verdict.hpp"

namespace tendril {

namespace {

Eigen::VectorXd to_eigen(const std::vector<double>& v) {
  return VectorView(v.data(), static_cast<Eigen::Index>(v.size()));
}

VectorView view(const Eigen::VectorXd& v) { return {v.data(), v.size()}; }

void require_sizes(const NonlinearProgram& program, const SolverStart& start) {
  const auto require_size = [](const Eigen::VectorXd& v, int size, bool may_be_empty, const char* what) {
    if (v.size() == size || (may_be_empty && v.size() == 0)) return;
    throw Error(std::string(what) + " of the start has " + std::to_string(v.size()) + " entries, expected " +
                std::to_string(size));
  };
  require_size(start.x, program.variable_count(), false, "x");
  require_size(start.multipliers, program.row_count(), true, "the vector of multipliers");
  require_size(start.bound_multipliers, program.variable_count(), true, "the vector of bound multipliers");
}

void end_with(OptimalityReport& report, SolveStatus status, std::string message) {
  report.status = status;
  report.message = std::move(message);
}

void end_with(OptimalityReport& report, const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const StopSolve& e) {
    end_with(report, e.status, e.what());
  } catch (const NotFiniteError& e) {
    end_with(report, SolveStatus::not_finite, e.what());
  } catch (const std::exception& e) {
    end_with(report, SolveStatus::failed, e.what());
  } catch (...) {
    end_with(report, SolveStatus::failed, "an exception of unknown type");
  }
}

/// The start inside the bounds.
Eigen::VectorXd inside(const NonlinearProgram& program, const Eigen::VectorXd& start) {
  Eigen::VectorXd x = start;
  for (int i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) throw_not_finite("the start of " + program.variable_name(i), x[i]);
    x[i] = std::clamp(x[i], program.lower()[i], program.upper()[i]);
  }
  return x;
}

EvaluationCounts difference(const EvaluationCounts& after, const EvaluationCounts& before) {
  return {after.values - before.values, after.first_derivatives - before.first_derivatives,
          after.hessians - before.hessians, after.seconds - before.seconds};
}

}  // namespace

Solver::~Solver() = default;

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::converged:
      return "converged";
    case SolveStatus::iteration_limit:
      return "iteration_limit";
    case SolveStatus::time_limit:
      return "time_limit";
    case SolveStatus::interrupted:
      return "interrupted";
    case SolveStatus::infeasible:
      return "infeasible";
    case SolveStatus::diverged:
      return "diverged";
    case SolveStatus::stalled:
      return "stalled";
    case SolveStatus::not_finite:
      return "not_finite";
    case SolveStatus::unsupported:
      return "unsupported";
    case SolveStatus::failed:
      return "failed";
  }
  return "unknown";
}

OptimalityReport Solver::solve(NonlinearProgram& program, const SolverStart& start, const SolveControl& control) {
  require_sizes(program, start);
  const int n = program.variable_count();
  const EvaluationCounts before = program.counts();
  Callbacks callbacks(program, control);
  OptimalityReport report;
  report.x = start.x;
  report.multipliers.setZero(program.row_count());
  report.bound_multipliers.setZero(n);
  report.cost = report.infeasibility = report.stationarity = infinity;

  bool started = false;
  Outcome outcome;
  try {
    if (std::string why = refusal(program); !why.empty()) {
      end_with(report, SolveStatus::unsupported, std::move(why));
    } else if (std::string clash = contradiction(program); !clash.empty()) {
      end_with(report, SolveStatus::infeasible, std::move(clash));
    } else {
      callbacks.best_x_ = report.x = inside(program, start.x);
      callbacks.gradient(report.x);
      callbacks.jacobian(report.x);
      callbacks.cost(report.x);
      callbacks.constraints(report.x);
      started = true;
      outcome = do_solve(callbacks, {view(report.x), view(start.multipliers), view(start.bound_multipliers)}, control);
      end_with(report, outcome.status, outcome.message);
    }
  } catch (...) {
    callbacks.record_exception();
  }
  report.native_status = std::move(outcome.native_status);
  report.iterations = outcome.iterations;
  report.effective_options = std::move(outcome.effective_options);

  if (callbacks.has_exception()) {
    end_with(report, callbacks.exception_);
    if (started && callbacks.best_x_.size() == n) report.x = callbacks.best_x_;
  } else if (started) {
    const bool usable = outcome.x.size() == static_cast<std::size_t>(n) && to_eigen(outcome.x).allFinite();
    report.x = usable ? to_eigen(outcome.x) : callbacks.best_x_;
    if (!usable && !outcome.x.empty()) {
      end_with(report, SolveStatus::not_finite, "the backend returned a point that is not finite");
    }
    if (report.status != SolveStatus::converged && control.stop != nullptr && control.stop->load()) {
      end_with(report, SolveStatus::interrupted, "stop was asked for");
    }
  }

  if (started) {
    try {
      const bool known = callbacks.judged_x_.size() == n && callbacks.judged_x_ == report.x;
      judge(program, control, outcome.multipliers, outcome.bound_multipliers, known ? &callbacks.verdict_ : nullptr,
            report);
      weigh(program, control, report);
    } catch (...) {
      end_with(report, std::current_exception());
    }
    if (!std::isfinite(report.cost) && report.status == SolveStatus::converged) {
      end_with(report, SolveStatus::not_finite, "the cost at the end is not finite");
    }
  }
  report.evaluations = difference(program.counts(), before);
  report.seconds_evaluating = report.evaluations.seconds;
  report.seconds = now() - callbacks.start_time_;
  return report;
}

}  // namespace tendril
