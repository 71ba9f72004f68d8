#include <nlopt.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>

#include "algorithms.hpp"
#include "tendril/plugin.hpp"
#include "tendril/solver.hpp"

namespace tendril::nlopt_plugin {

namespace {

/// NLopt's random numbers are one per process.
std::mutex random_lock;

struct Destroy {
  void operator()(nlopt_opt opt) const { nlopt_destroy(opt); }
};
using Handle = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, Destroy>;

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string_view words(nlopt_result result) {
  switch (result) {
    case NLOPT_SUCCESS:
      return "SUCCESS";
    case NLOPT_STOPVAL_REACHED:
      return "STOPVAL_REACHED";
    case NLOPT_FTOL_REACHED:
      return "FTOL_REACHED";
    case NLOPT_XTOL_REACHED:
      return "XTOL_REACHED";
    case NLOPT_MAXEVAL_REACHED:
      return "MAXEVAL_REACHED";
    case NLOPT_MAXTIME_REACHED:
      return "MAXTIME_REACHED";
    case NLOPT_FAILURE:
      return "FAILURE";
    case NLOPT_INVALID_ARGS:
      return "INVALID_ARGS";
    case NLOPT_OUT_OF_MEMORY:
      return "OUT_OF_MEMORY";
    case NLOPT_ROUNDOFF_LIMITED:
      return "ROUNDOFF_LIMITED";
    case NLOPT_FORCED_STOP:
      return "FORCED_STOP";
    default:
      return "unknown result";
  }
}

/// One side of a row as NLopt sees it: sign * (c - bound), <= 0 or = 0.
struct Side {
  int row;
  double sign;
  double bound;
};

class NloptSolver final : public Solver {
 public:
  explicit NloptSolver(const Options& options)
      : options_(options),
        algorithm_(*find_algorithm(options.text("algorithm"))),
        inner_(find_algorithm(options.has("local_algorithm") ? options.text("local_algorithm")
                                                             : (algorithm_.gradient ? "LD_SLSQP" : "LN_SBPLX"))) {}

  std::string name() const override { return "nlopt " + std::string(algorithm_.name); }

  SolverCapabilities capabilities() const override {
    SolverCapabilities can;
    can.equalities = algorithm_.equalities;
    can.inequalities = algorithm_.inequalities;
    can.needs_finite_bounds = algorithm_.finite_bounds;
    can.uses_gradient = algorithm_.gradient;
    return can;
  }

 private:
  /// What the C callbacks reach through their data pointer.
  struct Run {
    Callbacks& callbacks;
    nlopt_opt opt = nullptr;
    std::vector<Side> equalities{};
    std::vector<Side> inequalities{};
    int iteration_limit = 0;
    int evaluations = 0;
    int gradients = 0;
    int not_finite = 0;
    Eigen::VectorXd last{};  ///< the last point with finite values
    bool uses_gradient = true;
    bool halves_step = false;
    bool limit_met = false;
    int searched = 0;    ///< values since the last gradient
    bool stuck = false;  ///< the last search went on for ever
  };

  /// After so many shortened steps in a row there is nothing finite to step to.
  static constexpr int shortenings = 30;
  /// Where rounding hides all progress, or badly scaled rows overflow its merit, SLSQP shortens its step for ever, at
  /// last by nothing at all. A step halved so often is far below the rounding of any point.
  static constexpr int longest_search = 100;

  static void stop(Run& run) {
    run.callbacks.record_exception();
    nlopt_force_stop(run.opt);
  }

  static double objective(unsigned n, const double* x, double* gradient, void* data) {
    Run& run = *static_cast<Run*>(data);
    const VectorView point(x, static_cast<Eigen::Index>(n));
    try {
      ++run.evaluations;
      if (gradient != nullptr) ++run.gradients;
      const int iterations = run.uses_gradient ? run.gradients - 1 : run.evaluations / (static_cast<int>(n) + 1);
      if (iterations > run.iteration_limit) {
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
      if (!run.halves_step || ++run.not_finite > shortenings) stop(run);
    } catch (...) {
      stop(run);
    }
    return HUGE_VAL;
  }

  static void write_sides(const Run& run, const std::vector<Side>& sides, unsigned n, const double* x, double* result,
                          double* gradient) {
    const VectorView point(x, static_cast<Eigen::Index>(n));
    if (gradient != nullptr) {
      const MatrixView jacobian = run.callbacks.jacobian(point);
      for (std::size_t k = 0; k < sides.size(); ++k) {
        Eigen::Map<Eigen::RowVectorXd>(gradient + k * n, point.size()) = sides[k].sign * jacobian.row(sides[k].row);
      }
    }
    const VectorView c = run.callbacks.constraints(point);
    for (std::size_t k = 0; k < sides.size(); ++k) result[k] = sides[k].sign * (c[sides[k].row] - sides[k].bound);
  }

  static void equalities(unsigned, double* result, unsigned n, const double* x, double* gradient, void* data) {
    Run& run = *static_cast<Run*>(data);
    try {
      write_sides(run, run.equalities, n, x, result, gradient);
    } catch (...) {
      stop(run);
    }
  }

  static void inequalities(unsigned, double* result, unsigned n, const double* x, double* gradient, void* data) {
    Run& run = *static_cast<Run*>(data);
    try {
      write_sides(run, run.inequalities, n, x, result, gradient);
    } catch (...) {
      stop(run);
    }
  }

  std::string refusal(const NonlinearProgram& program) const override {
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

  double chosen(const char* option, double otherwise) const {
    return options_.has(option) ? options_.real(option) : otherwise;
  }

  /// The tests that end a run. A step below xtol_abs is the last one of a superlinear sequence; the relative ftol
  /// catches the stagnation by rounding that otherwise ends in a dozen useless line searches.
  void set_tests(nlopt_opt opt, const SolveControl& control) const {
    const double local_xtol = algorithm_.name == "LD_SLSQP" ? 10.0 * control.tolerance : control.tolerance;
    nlopt_set_xtol_abs1(opt, chosen("xtol_abs", local_xtol));
    nlopt_set_xtol_rel(opt, chosen("xtol_rel", 0.0));
    nlopt_set_ftol_rel(opt, chosen("ftol_rel", 1e-15));
    nlopt_set_ftol_abs(opt, chosen("ftol_abs", 1e-18));
  }

  Handle create(Run& run, const SolveControl& control) const {
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
    require(nlopt_set_min_objective(opt.get(), objective, &run), "the objective");
    require(nlopt_set_lower_bounds(opt.get(), program.lower().data()), "the lower bounds");
    require(nlopt_set_upper_bounds(opt.get(), program.upper().data()), "the upper bounds");
    const double row_tolerance = chosen("constraint_tolerance", control.tolerance);
    const std::vector<double> tolerances(std::max(run.equalities.size(), run.inequalities.size()), row_tolerance);
    if (!run.equalities.empty()) {
      require(nlopt_add_equality_mconstraint(opt.get(), static_cast<unsigned>(run.equalities.size()), equalities, &run,
                                             tolerances.data()),
              "the equality constraints");
    }
    if (!run.inequalities.empty()) {
      require(nlopt_add_inequality_mconstraint(opt.get(), static_cast<unsigned>(run.inequalities.size()), inequalities,
                                               &run, tolerances.data()),
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

  std::map<std::string, std::string> effective(nlopt_opt opt, const SolveControl& control) const {
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

  SolveStatus status_of(nlopt_result result, const Run& run) const {
    if (run.limit_met) return SolveStatus::iteration_limit;
    if (run.stuck) return SolveStatus::stalled;
    switch (result) {
      case NLOPT_SUCCESS:
      case NLOPT_STOPVAL_REACHED:
      case NLOPT_FTOL_REACHED:
      case NLOPT_XTOL_REACHED:
        return SolveStatus::converged;
      case NLOPT_MAXEVAL_REACHED:
        return SolveStatus::iteration_limit;
      case NLOPT_MAXTIME_REACHED:
        return SolveStatus::time_limit;
      case NLOPT_ROUNDOFF_LIMITED:
      case NLOPT_FAILURE:
        return SolveStatus::stalled;
      default:
        return SolveStatus::failed;
    }
  }

  struct Verdict {
    bool feasible = false;
    bool good = false;
    double defect = infinity;
  };

  static Verdict judge(Callbacks& callbacks, const SolveControl& control, const VectorView& x) {
    if (!x.allFinite()) return {};
    const Callbacks::Judgement verdict = callbacks.judge(x);
    const double stationarity = verdict.stationarity / verdict.gradient_scale;
    const bool feasible = verdict.infeasibility <= 10.0 * control.tolerance;
    return {feasible, feasible && stationarity <= std::max(1e-6, 10.0 * control.tolerance),
            std::max(verdict.infeasibility, stationarity)};
  }

  /// NLopt returns the cheapest point among those within the tolerance of feasible, which may be off by the root of
  /// that tolerance along the rows; the last iterate is normally far better. Leaves the better of both in x.
  static Verdict better_end(Run& run, const SolveControl& control, std::vector<double>& x) {
    const VectorView last(run.last.data(), run.last.size());
    const Verdict of_last = judge(run.callbacks, control, last);
    if (!of_last.good) {
      const Verdict of_best = judge(run.callbacks, control, {x.data(), static_cast<Eigen::Index>(x.size())});
      if (of_best.defect < of_last.defect) return of_best;
    }
    x.assign(last.begin(), last.end());
    return of_last;
  }

  /// Signed violation of each row at x.
  static Eigen::VectorXd violations(Callbacks& callbacks, const Eigen::VectorXd& x) {
    const NonlinearProgram& program = callbacks.program();
    const VectorView c = callbacks.constraints(x);
    return (c - program.row_upper()).cwiseMax(0.0) - (program.row_lower() - c).cwiseMax(0.0);
  }

  /// Levenberg-Marquardt on the violation within the bounds. SLSQP leaves rows violated by 1e-8 where its inner least
  /// squares lose digits, and gives up where the linearized rows contradict each other; both end here, near x, at a
  /// feasible point or at one where the violation is least.
  static void restore(Callbacks& callbacks, const SolveControl& control, std::vector<double>& point) {
    const NonlinearProgram& program = callbacks.program();
    Eigen::VectorXd x = VectorView(point.data(), static_cast<Eigen::Index>(point.size()))
                            .cwiseMax(program.lower())
                            .cwiseMin(program.upper());
    double damping = 1e-14;
    for (int step = 0; step < 100; ++step) {
      Eigen::MatrixXd violated = callbacks.jacobian(x);
      const Eigen::VectorXd v = violations(callbacks, x);
      if (v.lpNorm<Eigen::Infinity>() <= 0.1 * control.tolerance) break;
      for (int i = 0; i < v.size(); ++i) {
        if (v[i] == 0.0) violated.row(i).setZero();
      }
      for (int j = 0; j < x.size(); ++j) {
        const double slope = violated.col(j).dot(v);
        if ((slope > 0.0 && x[j] <= program.lower()[j]) || (slope < 0.0 && x[j] >= program.upper()[j]))
          violated.col(j).setZero();
      }
      const Eigen::VectorXd slope = violated.transpose() * v;
      if (slope.norm() <= 1e-12 * v.norm() * std::max(1.0, violated.norm())) break;
      Eigen::MatrixXd normal = violated.transpose() * violated;
      const double size = std::max(1e-300, normal.diagonal().maxCoeff());
      bool accepted = false;
      while (!accepted && damping < 1e8) {
        normal.diagonal().array() += damping * size;
        const Eigen::VectorXd trial =
            (x - normal.ldlt().solve(slope)).cwiseMax(program.lower()).cwiseMin(program.upper());
        normal.diagonal().array() -= damping * size;
        accepted = trial.allFinite() && improves(callbacks, trial, v.squaredNorm());
        if (accepted) x = trial;
        damping *= accepted ? 0.1 : 10.0;
      }
      if (!accepted) break;
      damping = std::max(damping, 1e-14);
    }
    point.assign(x.begin(), x.end());
  }

  static bool improves(Callbacks& callbacks, const Eigen::VectorXd& x, double squared_violation) {
    try {
      return violations(callbacks, x).squaredNorm() < squared_violation;
    } catch (const NotFiniteError&) {
      return false;
    }
  }

  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) override {
    Run run{callbacks};
    const NonlinearProgram& program = callbacks.program();
    for (int i = 0; i < program.row_count(); ++i) {
      const double lower = program.row_lower()[i];
      const double upper = program.row_upper()[i];
      if (lower == upper) {
        run.equalities.push_back({i, 1.0, upper});
        continue;
      }
      if (std::isfinite(upper)) run.inequalities.push_back({i, 1.0, upper});
      if (std::isfinite(lower)) run.inequalities.push_back({i, -1.0, lower});
    }
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
      outcome.status = status_of(result, run);
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
    outcome.iterations =
        run.uses_gradient ? std::max(0, run.gradients - 1) : run.evaluations / (program.variable_count() + 1);
    outcome.iterations = std::min(outcome.iterations, control.max_iterations);
    outcome.effective_options = effective(opt.get(), control);
    return outcome;
  }

  Options options_;
  const Algorithm& algorithm_;
  const Algorithm* inner_;
};

OptionSpec real(std::string name, std::string description, double minimum = 0.0) {
  OptionSpec spec;
  spec.name = std::move(name);
  spec.type = OptionType::real;
  spec.description = std::move(description);
  spec.minimum = minimum;
  return spec;
}

OptionSpec integer(std::string name, std::string description, double minimum) {
  OptionSpec spec = real(std::move(name), std::move(description), minimum);
  spec.type = OptionType::integer;
  return spec;
}

OptionSpec algorithm(std::string name, std::string description) {
  OptionSpec spec;
  spec.name = std::move(name);
  spec.type = OptionType::text;
  spec.description = std::move(description);
  spec.choices = algorithm_names();
  return spec;
}

OptionSchema schema() {
  OptionSchema options;
  options.push_back(algorithm("algorithm", "NLopt's name of the algorithm, without NLOPT_"));
  options.back().default_value = std::string("LD_SLSQP");
  options.push_back(
      algorithm("local_algorithm", "the algorithm inside AUGLAG and MLSL; LD_SLSQP or LN_SBPLX if not given"));
  options.push_back(real("xtol_abs", "ends when no variable moves more; from the tolerance if not given"));
  options.push_back(real("xtol_rel", "ends when the point moves less, relative to its size; 0 if not given"));
  options.push_back(real("ftol_abs", "ends when the cost changes less; 1e-18 if not given"));
  options.push_back(real("ftol_rel", "ends when the cost changes less, relative to its size; 1e-15 if not given"));
  options.push_back(real("stopval", "ends at a feasible point of this cost", -infinity));
  options.push_back(real("constraint_tolerance", "violation that counts as feasible; the tolerance if not given"));
  options.push_back(integer("maxeval", "most evaluations of the cost; max_iterations holds besides", 0.0));
  options.push_back(integer("seed", "start of the random numbers of GN algorithms", 0.0));
  options.back().default_value = std::int64_t{1};
  options.push_back(
      integer("population", "points that a global algorithm carries along; its own choice if not given", 1.0));
  options.push_back(
      integer("vector_storage", "gradients that a limited-memory algorithm keeps; its own choice if not given", 1.0));
  options.push_back(real("initial_step", "first step of algorithms without gradients; their own choice if not given"));
  options.back().minimum_excluded = true;
  options.push_back(integer("inner_maxeval", "inner iterations of MMA and CCSAQ; no limit if not given", 0.0));
  return options;
}

}  // namespace

}  // namespace tendril::nlopt_plugin

TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  registrar.add(SolverComponent{"nlopt", "NLopt: SLSQP by default, any of its other algorithms by `algorithm`",
                                nlopt_plugin::schema(), [](const Options& options) -> std::unique_ptr<Solver> {
                                  return std::make_unique<nlopt_plugin::NloptSolver>(options);
                                }});
}
