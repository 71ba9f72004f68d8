#pragma once

#include <nlopt.h>

#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "algorithms.hpp"
#include "tendril/options.hpp"
#include "tendril/solver.hpp"

namespace tendril::nlopt_plugin {

class NloptSolver final : public Solver {
 public:
  explicit NloptSolver(const Options& options);

  std::string name() const override { return "nlopt " + std::string(algorithm_.name); }
  SolverCapabilities capabilities() const override;

 private:
  struct Run;

  struct Destroy {
    void operator()(nlopt_opt opt) const { nlopt_destroy(opt); }
  };
  using Handle = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, Destroy>;

  std::string refusal(const NonlinearProgram& program) const override;
  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) override;

  /// The option, or `otherwise` where it is not given.
  double chosen(const char* option, double otherwise) const;
  void set_tests(nlopt_opt opt, const SolveControl& control) const;
  /// NLopt's object for a run, which it keeps a pointer to.
  Handle create(Run& run, const SolveControl& control) const;
  /// The options that `opt` has, by their native names.
  std::map<std::string, std::string> effective(nlopt_opt opt, const SolveControl& control) const;

  /// How good a point is.
  struct Verdict {
    bool feasible = false;
    bool good = false;
    double defect = infinity;
  };
  static Verdict judge(Callbacks& callbacks, const SolveControl& control, const VectorView& x);
  static Verdict better_end(Run& run, const SolveControl& control, std::vector<double>& x);
  static void restore(Callbacks& callbacks, const SolveControl& control, std::vector<double>& point);
  static Eigen::VectorXd violations(Callbacks& callbacks, const Eigen::VectorXd& x);
  static bool improves(Callbacks& callbacks, const Eigen::VectorXd& x, double squared_violation);

  Options options_;
  const Algorithm& algorithm_;
  const Algorithm* inner_;  ///< the local algorithm inside, where there is one
};

}  // namespace tendril::nlopt_plugin
