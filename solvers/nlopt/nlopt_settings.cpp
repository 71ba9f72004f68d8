// What NLopt is told before it runs, and what it made of that.

#include <algorithm>
#include <cmath>

#include "nlopt_run.hpp"
#include "nlopt_status.hpp"

namespace tendril::nlopt_plugin {

namespace {}  // namespace

double NloptSolver::chosen(const char* option, double otherwise) const {
  return options_.has(option) ? options_.real(option) : otherwise;
}

/// The tests that end a run. A step below xtol_abs is the last one of a superlinear sequence; the relative ftol
/// catches the stagnation by rounding that otherwise ends in a dozen useless line searches.
void NloptSolver::set_tests(nlopt_opt opt, const SolveControl& control) const {
  const double local_xtol = algorithm_.name == "LD_SLSQP" ? 10.0 * control.tolerance : control.tolerance;
  nlopt_set_xtol_abs1(opt, chosen("xtol_abs", local_xtol));
  nlopt_set_xtol_rel(opt, chosen("xtol_rel", 0.0));
  nlopt_set_ftol_rel(opt, chosen("ftol_rel", 1e-15));
  nlopt_set_ftol_abs(opt, chosen("ftol_abs", 1e-18));
}

NloptSolver::Handle NloptSolver::create(Run& run, const SolveControl& control) const {
  const NonlinearProgram& program = run.callbacks.program();
  const auto n = static_cast<unsigned>(program.variable_count());
  Handle opt(nlopt_create(algorithm_.id, n));
  if (!opt) throw Error("nlopt cannot make a " + std::string(algorithm_.name));
  run.opt = opt.get();
  const auto require = [&](nlopt_result result, const char* what) {
    if (result >= 0) return;
    const char* detail = nlopt_get_errmsg(opt.get());
    throw Error(name() + " refuses " + what + ": " + (detail != nullptr ? detail : std::string(words(result))));
  };
  require(nlopt_set_min_objective(opt.get(), Run::objective, &run), "the objective");
  require(nlopt_set_lower_bounds(opt.get(), program.lower().data()), "the lower bounds");
  require(nlopt_set_upper_bounds(opt.get(), program.upper().data()), "the upper bounds");
  const double row_tolerance = chosen("constraint_tolerance", control.tolerance);
  const std::vector<double> tolerances(std::max(run.equalities.size(), run.inequalities.size()), row_tolerance);
  if (!run.equalities.empty()) {
    require(nlopt_add_equality_mconstraint(opt.get(), static_cast<unsigned>(run.equalities.size()), Run::equality_rows,
                                           &run, tolerances.data()),
            "the equality constraints");
  }
  if (!run.inequalities.empty()) {
    require(nlopt_add_inequality_mconstraint(opt.get(), static_cast<unsigned>(run.inequalities.size()),
                                             Run::inequality_rows, &run, tolerances.data()),
            "the inequality constraints");
  }
  set_tests(opt.get(), control);
  if (options_.has("stopval")) nlopt_set_stopval(opt.get(), options_.real("stopval"));
  if (options_.has("maxeval")) nlopt_set_maxeval(opt.get(), static_cast<int>(options_.integer("maxeval")));
  if (options_.has("population"))
    nlopt_set_population(opt.get(), static_cast<unsigned>(options_.integer("population")));
  if (options_.has("vector_storage")) {
    nlopt_set_vector_storage(opt.get(), static_cast<unsigned>(options_.integer("vector_storage")));
  }
  if (options_.has("initial_step")) nlopt_set_initial_step1(opt.get(), options_.real("initial_step"));
  if (options_.has("inner_maxeval"))
    nlopt_set_param(opt.get(), "inner_maxeval", static_cast<double>(options_.integer("inner_maxeval")));
  if (std::isfinite(control.time_limit)) nlopt_set_maxtime(opt.get(), std::max(1e-9, run.callbacks.seconds_left()));
  if (algorithm_.has_inner) {
    const Handle inner(nlopt_create(inner_->id, n));
    // LD_AUGLAG reads the inner xtol_abs without asking whether it was ever set.
    set_tests(inner.get(), control);
    require(nlopt_set_local_optimizer(opt.get(), inner.get()), "the local algorithm");
  }
  return opt;
}

std::map<std::string, std::string> NloptSolver::effective(nlopt_opt opt, const SolveControl& control) const {
  std::map<std::string, std::string> list{
      {"algorithm", std::string(algorithm_.name)},
      {"xtol_abs", shown(chosen("xtol_abs", 0.0))},
      {"xtol_rel", shown(nlopt_get_xtol_rel(opt))},
      {"ftol_abs", shown(nlopt_get_ftol_abs(opt))},
      {"ftol_rel", shown(nlopt_get_ftol_rel(opt))},
      {"constraint_tolerance", shown(chosen("constraint_tolerance", control.tolerance))},
      {"maxtime", shown(nlopt_get_maxtime(opt))}};
  double xtol = 0.0;
  if (nlopt_get_dimension(opt) > 0) {
    std::vector<double> all(nlopt_get_dimension(opt));
    nlopt_get_xtol_abs(opt, all.data());
    xtol = all.front();
  }
  list["xtol_abs"] = shown(xtol);
  if (algorithm_.has_inner) list["local_algorithm"] = std::string(inner_->name);
  if (algorithm_.random) list["seed"] = std::to_string(options_.integer("seed"));
  return list;
}

}  // namespace tendril::nlopt_plugin
