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
  const int n = program.variable_count();
  const int m = program.row_count();
  const auto require_size = [](const Eigen::VectorXd& v, int size, bool may_be_empty, const char* what) {
    if (v.size() == size || (may_be_empty && v.size() == 0)) return;
    throw Error(std::string(what) + " of the start has " + std::to_string(v.size()) + " entries, expected " +
                std::to_string(size));
  };
  require_size(start.x, n, false, "x");
  require_size(start.multipliers, m, true, "the vector of multipliers");
  require_size(start.bound_multipliers, n, true, "the vector of bound multipliers");

  const EvaluationCounts before = program.counts();
  Callbacks callbacks(program, control);
  OptimalityReport report;
  report.x = start.x;
  report.multipliers.setZero(m);
  report.bound_multipliers.setZero(n);
  report.cost = report.infeasibility = report.stationarity = infinity;
  const auto end_with = [&](SolveStatus status, std::string message) {
    report.status = status;
    report.message = std::move(message);
  };
  const auto explain_exception = [&] {
    try {
      std::rethrow_exception(callbacks.exception_);
    } catch (const StopSolve& e) {
      end_with(e.status, e.what());
    } catch (const NotFiniteError& e) {
      end_with(SolveStatus::not_finite, e.what());
    } catch (const std::exception& e) {
      end_with(SolveStatus::failed, e.what());
    } catch (...) {
      end_with(SolveStatus::failed, "an exception of unknown type");
    }
  };

  bool started = false;
  Outcome outcome;
  try {
    if (std::string why = refusal(program); !why.empty()) {
      end_with(SolveStatus::unsupported, std::move(why));
    } else if (std::string clash = contradiction(program); !clash.empty()) {
      end_with(SolveStatus::infeasible, std::move(clash));
    } else {
      for (int i = 0; i < n; ++i) {
        if (!std::isfinite(start.x[i])) throw_not_finite("the start of " + program.variable_name(i), start.x[i]);
        report.x[i] = std::clamp(start.x[i], program.lower()[i], program.upper()[i]);
      }
      callbacks.best_x_ = report.x;
      callbacks.gradient(report.x);
      callbacks.jacobian(report.x);
      callbacks.cost(report.x);
      callbacks.constraints(report.x);
      started = true;
      outcome = do_solve(callbacks, {view(report.x), view(start.multipliers), view(start.bound_multipliers)}, control);
      report.status = outcome.status;
      report.message = outcome.message;
    }
  } catch (...) {
    callbacks.record_exception();
  }
  report.native_status = std::move(outcome.native_status);
  report.iterations = outcome.iterations;
  report.effective_options = std::move(outcome.effective_options);

  if (callbacks.has_exception()) {
    explain_exception();
    if (started && callbacks.best_x_.size() == n) report.x = callbacks.best_x_;
  } else if (started) {
    const bool usable = outcome.x.size() == static_cast<std::size_t>(n) && to_eigen(outcome.x).allFinite();
    if (usable) {
      report.x = to_eigen(outcome.x);
    } else {
      report.x = callbacks.best_x_;
      if (!outcome.x.empty()) end_with(SolveStatus::not_finite, "the backend returned a point that is not finite");
    }
    if (report.status != SolveStatus::converged && control.stop != nullptr && control.stop->load()) {
      end_with(SolveStatus::interrupted, "stop was asked for");
    }
  }

  if (started) {
    try {
      const bool known = callbacks.judged_x_.size() == n && callbacks.judged_x_ == report.x;
      judge(program, control, outcome.multipliers, outcome.bound_multipliers, known ? &callbacks.verdict_ : nullptr,
            report);
      weigh(program, control, report);
    } catch (...) {
      callbacks.exception_ = std::current_exception();
      explain_exception();
    }
    if (!std::isfinite(report.cost) && report.status == SolveStatus::converged) {
      end_with(SolveStatus::not_finite, "the cost at the end is not finite");
    }
  }
  report.evaluations.values = program.counts().values - before.values;
  report.evaluations.first_derivatives = program.counts().first_derivatives - before.first_derivatives;
  report.evaluations.hessians = program.counts().hessians - before.hessians;
  report.evaluations.seconds = report.seconds_evaluating = program.counts().seconds - before.seconds;
  report.seconds = now() - callbacks.start_time_;
  return report;
}

}  // namespace tendril
