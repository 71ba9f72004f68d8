#include "search/steps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "search/parameters.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
constexpr double at_limit = 1e-9;  ///< a variable this near to its limit stands at it, in reports

/// Of many variables the linear algebra costs most.
constexpr double cheap_algebra = 60.0;

double work_of(double evaluations, double n) {
  return evaluations * n * (1.0 + n * n / (cheap_algebra * cheap_algebra));
}

double work_of(const NonlinearProgram& program, const EvaluationCounts& asked) {
  const auto evaluations = static_cast<double>(asked.values + asked.first_derivatives + 2 * asked.hessians);
  return work_of(evaluations, program.variable_count());
}

/// The variables that are at a limit at x.
std::string limits_at(const NonlinearProgram& program, ConstVectorRef x) {
  std::string text;
  for (int i = 0; i < program.variable_count(); ++i) {
    if (program.lower()[i] == program.upper()[i]) continue;
    const bool low = x[i] <= program.lower()[i] + at_limit;
    if (!low && x[i] < program.upper()[i] - at_limit) continue;
    text += (text.empty() ? "" : ", ") + program.variable_name(i) + (low ? " at its smallest" : " at its largest");
  }
  return text;
}

}  // namespace

void Tally::add_inside(const NonlinearProgram& program, const EvaluationCounts& asked) {
  evaluations += asked;
  work += work_of(program, asked);
}

void Tally::add_outside(const NonlinearProgram& program, const EvaluationCounts& before) {
  const EvaluationCounts after = program.counts();
  const EvaluationCounts asked{after.values - before.values, after.first_derivatives - before.first_derivatives,
                               after.hessians - before.hessians, after.seconds - before.seconds};
  outside_solver += asked;
  work += work_of(program, asked);
}

void Tally::add_looks(int looks, int coordinates) {
  // Each has its derivatives, a Hessian among them, and a value to see what it brought.
  constexpr double evaluations_of_a_look = 5.0;
  work += work_of(evaluations_of_a_look * looks, coordinates);
}

std::string refusal_message(const std::string& solver, const OptimalityReport& last) {
  const std::string reason = last.message.empty() ? last.native_status : last.message;
  return (reason.empty() ? "" : reason + "; ") + "solver '" + solver + "' ended every solve as " +
         std::string(to_string(last.status));
}

void report_tally(const Tally& tally, Plan& plan) {
  plan.solver.iterations = tally.iterations;
  plan.solver.evaluations = tally.evaluations;
  plan.evaluations = tally.evaluations;
  plan.evaluations += tally.outside_solver;
  plan.solver.seconds = tally.seconds;
  plan.solver.seconds_evaluating = tally.seconds_evaluating;
  plan.seconds_certify = tally.seconds_certifying;
}

OptimalityReport ProgramSearch::solve(Attempt& attempt, NonlinearProgram& program, const Eigen::VectorXd& x,
                                      const OptimalityReport* warm) {
  SolverStart start;
  start.x = x;
  if (warm != nullptr) {
    start.multipliers = warm->multipliers;
    start.bound_multipliers = warm->bound_multipliers;
  }
  SolveControl limits;
  limits.tolerance = spec_.tolerance;
  limits.max_iterations = spec_.max_iterations;
  if (limited_)
    limits.max_iterations = std::min(limits.max_iterations, search_parameters().patience * slowest_converged_);
  limits.time_limit = std::max(1e-3, deadline_.seconds_left());
  limits.stop = deadline_.stop();
  OptimalityReport report = solver_.solve(program, start, limits);
  ++attempt.record.solves;
  attempt.record.iterations += report.iterations;
  attempt.record.evaluations += report.evaluations.values;
  attempt.record.seconds_evaluating += report.seconds_evaluating;
  attempt.last = report;
  ++tally.solves;
  if (is_useless(report)) ++tally.useless_solves;
  if (report.status == SolveStatus::converged) slowest_converged_ = std::max(slowest_converged_, report.iterations);
  tally.iterations += report.iterations;
  tally.seconds += report.seconds;
  tally.seconds_evaluating += report.seconds_evaluating;
  tally.add_inside(program, report.evaluations);
  if (progress_) progress_();
  return report;
}

bool ProgramSearch::sharpen(Attempt& attempt, NonlinearProgram& program, Eigen::VectorXd& x, bool solver_allowed) {
  PolishOptions options;
  options.stop = [this] { return must_stop(); };
  const auto polishes = [&](const Eigen::VectorXd& from) {
    ++attempt.record.polishes;
    const EvaluationCounts before = program.counts();
    polished_ = &polisher_.run(program, from, {}, options);
    tally.add_outside(program, before);
    if (!polished_->converged || !(polished_->infeasibility <= tolerance::equilibrium)) return false;
    x = polished_->x;
    return true;
  };
  if (polishes(x)) return true;
  polished_ = nullptr;
  if (!solver_allowed || must_stop()) return false;
  // On a decided branch the program is an ordinary one.
  const OptimalityReport r = solve(attempt, program, x);
  if (!r.x.allFinite() || r.x.size() != x.size()) return false;
  if (polishes(r.x)) return true;
  // Where second derivatives are learned, full steps may lead away from what they are to refine.
  options.descends = true;
  options.max_iterations = search_parameters().most_descents;
  if (polishes(r.x)) return true;
  // The solver's own point may already be good enough for the certificate.
  if (r.infeasibility <= restored) x = r.x;
  attempt.trouble = "the polish did not converge (" + std::string(std::exchange(polished_, nullptr)->reason) +
                    "); solver: " + std::string(to_string(r.status)) + (r.message.empty() ? "" : ", " + r.message);
  return r.infeasibility <= restored;
}

bool ProgramSearch::descend(Attempt& attempt, NonlinearProgram& program, Eigen::VectorXd& x) {
  PolishOptions options;
  options.descends = true;
  options.max_iterations = search_parameters().most_descents;
  options.stop = [this] { return must_stop(); };
  ++attempt.record.polishes;
  const EvaluationCounts before = program.counts();
  const double cost = program.cost(x);
  polished_ = &polisher_.run(program, x, {}, options);
  const bool reached = polished_->converged && polished_->infeasibility <= tolerance::equilibrium &&
                       program.cost(polished_->x) <= cost + search_parameters().dearer;
  tally.add_outside(program, before);
  if (progress_) progress_();
  if (!reached) {
    polished_ = nullptr;
    return false;
  }
  x = polished_->x;
  attempt.last = {};
  attempt.last.status = SolveStatus::converged;
  attempt.last.native_status = "not asked: Newton's method converged from a feasible point";
  return true;
}

FeasibilityReport ProgramSearch::restoration(NonlinearProgram& program, const Eigen::VectorXd& x, bool patiently) {
  const EvaluationCounts before = program.counts();
  FeasibilityReport report =
      restore_feasibility(program, x, restored,
                          patiently ? search_parameters().patient_restorations : search_parameters().most_restorations,
                          [this] { return must_stop(); });
  tally.add_outside(program, before);
  return report;
}

FeasibilityReport ProgramSearch::restore(Attempt& attempt, NonlinearProgram& program, const Eigen::VectorXd& x) {
  FeasibilityReport f = restoration(program, x);
  if (f.feasible) return f;
  record_violation(attempt, program, f);
  return f;
}

void ProgramSearch::record_violation(Attempt& attempt, const NonlinearProgram& program, const FeasibilityReport& f) {
  if (f.stationary_violation) ++attempt.stationary_violations;
  if (f.x.allFinite() && f.infeasibility < attempt.violation) {
    attempt.violation = f.infeasibility;
    attempt.limits = limits_at(program, f.x);
  }
  attempt.trouble = "no feasible point near: violation " + shown_with_exponent(f.infeasibility) +
                    (f.stationary_violation ? ", stationary" : "");
}

}  // namespace tendril
