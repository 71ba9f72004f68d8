#include "nlopt_run.hpp"

#include <cmath>

#include "nlopt_status.hpp"

namespace tendril::nlopt_plugin {

namespace {

/// After so many shortened steps in a row there is nothing finite to step to.
constexpr int shortenings = 30;
/// Where rounding hides all progress, or badly scaled rows overflow its merit, SLSQP shortens its step for ever, at
/// last by nothing at all. A step halved so often is far below the rounding of any point.
constexpr int longest_search = 100;

}  // namespace

void NloptSolver::Run::take_rows() {
  const NonlinearProgram& program = callbacks.program();
  for (int i = 0; i < program.row_count(); ++i) {
    const double lower = program.row_lower()[i];
    const double upper = program.row_upper()[i];
    if (lower == upper) {
      equalities.push_back({i, 1.0, upper});
      continue;
    }
    if (std::isfinite(upper)) inequalities.push_back({i, 1.0, upper});
    if (std::isfinite(lower)) inequalities.push_back({i, -1.0, lower});
  }
}

SolveStatus NloptSolver::Run::status_of(nlopt_result result) const {
  if (limit_met) return SolveStatus::iteration_limit;
  if (stuck) return SolveStatus::stalled;
  return nlopt_plugin::status_of(result);
}

int NloptSolver::Run::iterations() const {
  return uses_gradient ? gradients - 1 : evaluations / (callbacks.program().variable_count() + 1);
}

void NloptSolver::Run::stop() {
  callbacks.record_exception();
  nlopt_force_stop(opt);
}

double NloptSolver::Run::objective(unsigned n, const double* x, double* gradient, void* data) {
  Run& run = *static_cast<Run*>(data);
  const VectorView point(x, static_cast<Eigen::Index>(n));
  try {
    ++run.evaluations;
    if (gradient != nullptr) ++run.gradients;
    if (run.iterations() > run.iteration_limit) {
      run.limit_met = true;
      nlopt_force_stop(run.opt);
      return HUGE_VAL;
    }
    run.searched = gradient != nullptr ? 0 : run.searched + 1;
    if (run.halves_step && run.searched > longest_search) {
      run.stuck = true;
      nlopt_force_stop(run.opt);
      return HUGE_VAL;
    }
    if (gradient != nullptr) {
      Eigen::Map<Eigen::VectorXd>(gradient, point.size()) = run.callbacks.gradient(point);
      run.callbacks.jacobian(point);
    }
    const double cost = run.callbacks.cost(point);
    run.callbacks.constraints(point);
    // Coming back to where it was is no progress.
    if (point != run.last) {
      run.last = point;
      run.not_finite = 0;
    }
    return cost;
  } catch (const NotFiniteError&) {
    if (!run.halves_step || ++run.not_finite > shortenings) run.stop();
  } catch (...) {
    run.stop();
  }
  return HUGE_VAL;
}

void NloptSolver::Run::write_sides(const std::vector<Side>& sides, unsigned n, const double* x, double* result,
                                   double* gradient) {
  const VectorView point(x, static_cast<Eigen::Index>(n));
  if (gradient != nullptr) {
    const MatrixView jacobian = callbacks.jacobian(point);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      Eigen::Map<Eigen::RowVectorXd>(gradient + k * n, point.size()) = sides[k].sign * jacobian.row(sides[k].row);
    }
  }
  const VectorView c = callbacks.constraints(point);
  for (std::size_t k = 0; k < sides.size(); ++k) result[k] = sides[k].sign * (c[sides[k].row] - sides[k].bound);
}

void NloptSolver::Run::equality_rows(unsigned, double* result, unsigned n, const double* x, double* gradient,
                                     void* data) {
  Run& run = *static_cast<Run*>(data);
  try {
    run.write_sides(run.equalities, n, x, result, gradient);
  } catch (...) {
    run.stop();
  }
}

void NloptSolver::Run::inequality_rows(unsigned, double* result, unsigned n, const double* x, double* gradient,
                                       void* data) {
  Run& run = *static_cast<Run*>(data);
  try {
    run.write_sides(run.inequalities, n, x, result, gradient);
  } catch (...) {
    run.stop();
  }
}

}  // namespace tendril::nlopt_plugin
