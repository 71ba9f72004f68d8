// The plugin: its options and how it is made.

#include <memory>

#include "nlopt_solver.hpp"
#include "tendril/plugin.hpp"

namespace tendril::nlopt_plugin {

namespace {

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
