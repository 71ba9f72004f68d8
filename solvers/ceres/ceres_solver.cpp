#include <ceres/ceres.h>
#include <glog/logging.h>

#include <cmath>
#include <mutex>

#include "tendril/augmented_lagrangian.hpp"
#include "tendril/plugin.hpp"

namespace tendril::ceres_plugin {

namespace {

/// Ceres reports through glog, which may be started once per process and would write files and to standard error.
void quiet_glog() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (google::IsGoogleLoggingInitialized()) return;
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_FATAL;
    google::InitGoogleLogging("tendril");
  });
}

class CeresSolver final : public AugmentedLagrangianSolver {
 public:
  explicit CeresSolver(const Options& options) {
    quiet_glog();
    native_.minimizer_type = ceres::TRUST_REGION;
    native_.logging_type = ceres::SILENT;
    native_.num_threads = 1;
    // Each NaN met shortens the step; the default of five gives up too early.
    native_.max_num_consecutive_invalid_steps = 40;
    native_.function_tolerance = options.real("function_tolerance");
    native_.parameter_tolerance = options.real("parameter_tolerance");
    native_.initial_trust_region_radius = options.real("initial_trust_region_radius");
    native_.use_nonmonotonic_steps = options.boolean("use_nonmonotonic_steps");
    native_.jacobi_scaling = options.boolean("jacobi_scaling");
    ceres::StringToLinearSolverType(options.text("linear_solver_type"), &native_.linear_solver_type);
    ceres::StringToTrustRegionStrategyType(options.text("trust_region_strategy_type"),
                                           &native_.trust_region_strategy_type);
  }

  std::string name() const override { return "ceres"; }

 private:
  /// The whole sum of squares is one cost of one block of parameters.
  class Cost final : public ceres::CostFunction {
   public:
    explicit Cost(Subproblem& subproblem) : subproblem_(subproblem) {
      set_num_residuals(subproblem.residual_count());
      mutable_parameter_block_sizes()->push_back(subproblem.variable_count());
    }
    bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
      return subproblem_.evaluate(x[0], residuals, jacobians == nullptr ? nullptr : jacobians[0]);
    }

   private:
    Subproblem& subproblem_;
  };

  Reduction reduce(Subproblem& subproblem, double* x) override {
    ceres::Solver::Options options = native_;
    options.gradient_tolerance = subproblem.gradient_tolerance();
    options.max_num_iterations = subproblem.iteration_limit();
    if (std::isfinite(subproblem.seconds_left()))
      options.max_solver_time_in_seconds = std::max(0.0, subproblem.seconds_left());
    Cost cost(subproblem);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    problem.AddResidualBlock(&cost, nullptr, x);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return {summary.IsSolutionUsable(), summary.termination_type == ceres::CONVERGENCE,
            summary.num_successful_steps + summary.num_unsuccessful_steps,
            ceres::TerminationTypeToString(summary.termination_type)};
  }

  std::map<std::string, std::string> effective_options() const override {
    return {{"linear_solver_type", ceres::LinearSolverTypeToString(native_.linear_solver_type)},
            {"trust_region_strategy_type", ceres::TrustRegionStrategyTypeToString(native_.trust_region_strategy_type)},
            {"function_tolerance", shown(native_.function_tolerance)},
            {"parameter_tolerance", shown(native_.parameter_tolerance)},
            {"initial_trust_region_radius", shown(native_.initial_trust_region_radius)},
            {"use_nonmonotonic_steps", native_.use_nonmonotonic_steps ? "true" : "false"},
            {"jacobi_scaling", native_.jacobi_scaling ? "true" : "false"}};
  }

  ceres::Solver::Options native_;
};

OptionSpec option(std::string name, OptionType type, OptionValue default_value, std::string description) {
  OptionSpec spec;
  spec.name = std::move(name);
  spec.type = type;
  spec.default_value = std::move(default_value);
  spec.description = std::move(description);
  return spec;
}

OptionSchema schema() {
  OptionSchema options{
      option("linear_solver_type", OptionType::text, std::string("DENSE_QR"), "how each step is solved"),
      option("trust_region_strategy_type", OptionType::text, std::string("LEVENBERG_MARQUARDT"),
             "how steps are shortened"),
      option("function_tolerance", OptionType::real, 1e-16,
             "an inner solve ends when the sum of squares changes less, relatively"),
      option("parameter_tolerance", OptionType::real, 1e-14,
             "an inner solve ends when the point moves less, relatively"),
      option("initial_trust_region_radius", OptionType::real, 1e4, "first radius of every inner solve"),
      option("use_nonmonotonic_steps", OptionType::boolean, false, "lets the sum of squares rise for a while"),
      option("jacobi_scaling", OptionType::boolean, true, "scales the columns of the Jacobian"),
  };
  options[0].choices = {"DENSE_QR", "DENSE_NORMAL_CHOLESKY"};
  options[1].choices = {"LEVENBERG_MARQUARDT", "DOGLEG"};
  options[2].minimum = options[3].minimum = options[4].minimum = 0.0;
  options[4].minimum_excluded = true;
  return options;
}

}  // namespace

}  // namespace tendril::ceres_plugin

TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  registrar.add(SolverComponent{"ceres", "Ceres Solver: least squares inside a proximal augmented Lagrangian",
                                ceres_plugin::schema(), [](const Options& options) -> std::unique_ptr<Solver> {
                                  return std::make_unique<ceres_plugin::CeresSolver>(options);
                                }});
}
