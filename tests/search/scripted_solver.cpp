#include "scripted_solver.hpp"

#include "tendril/plugins/components.hpp"

namespace tendril::search {
namespace {

class Scripted : public Solver {
 public:
  Scripted(SolveStatus status, std::string message, std::function<void()> before)
      : status_(status), message_(std::move(message)), before_(std::move(before)) {}
  std::string name() const override { return "scripted"; }
  SolverCapabilities capabilities() const override { return {}; }

 protected:
  Outcome do_solve(Callbacks&, const Start& start, const SolveControl&) override {
    if (before_) before_();
    Outcome outcome;
    outcome.status = status_;
    outcome.message = message_;
    outcome.x.assign(start.x.begin(), start.x.end());
    return outcome;
  }

 private:
  SolveStatus status_;
  std::string message_;
  std::function<void()> before_;
};

class Newton : public Solver {
 public:
  explicit Newton(std::function<void()> before) : before_(std::move(before)) {}
  std::string name() const override { return "newton"; }
  SolverCapabilities capabilities() const override { return {.uses_hessian = true}; }

 protected:
  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl&) override {
    if (before_) before_();
    Eigen::VectorXd x = start.x;
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(callbacks.program().row_count());
    Eigen::VectorXd bounds = Eigen::VectorXd::Zero(x.size());
    Outcome outcome;
    outcome.status = callbacks.polish(x, multipliers, bounds, 1e-5) ? SolveStatus::converged : SolveStatus::stalled;
    outcome.x.assign(x.begin(), x.end());
    outcome.iterations = 1;
    return outcome;
  }

 private:
  std::function<void()> before_;
};

}  // namespace

std::unique_ptr<Solver> solver_that_ends_as(SolveStatus status, const std::string& message,
                                            std::function<void()> before) {
  return std::make_unique<Scripted>(status, message, std::move(before));
}

std::unique_ptr<Solver> newton(std::function<void()> before) { return std::make_unique<Newton>(std::move(before)); }

Problem problem_with(const Scene& scene, std::unique_ptr<Solver> solver) {
  Components components = plugins::make_components(combination::registry(), scene);
  components.solver = std::move(solver);
  return {scene, std::move(components)};
}

Plan plan_with(const Scene& scene, std::unique_ptr<Solver> solver, const PlanControl& control) {
  return problem_with(scene, std::move(solver)).plan(control);
}

ModeRecord record_of(const Plan& plan, const std::string& mode) {
  for (const ModeRecord& record : plan.modes) {
    if (record.mode == mode) return record;
  }
  ADD_FAILURE() << "no way of being in contact is called '" << mode << "'";
  return {};
}

testing::AssertionResult holds(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "expected '" << part << "' in: " << text;
}

testing::AssertionResult ended_as(const Plan& plan, PlanStatus status) {
  if (plan.status == status) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  failure << "expected " << to_string(status) << ", found " << to_string(plan.status) << ": " << plan.message;
  for (const ModeRecord& mode : plan.modes) failure << "\n  " << mode.mode << ": " << mode.outcome;
  return failure;
}

Scene weak_grasp(bool both) {
  Scene made = combination::scene("grasp_60mm", {"rod.actuator.0.limit=\"10 N mm\"", "rod.actuator.1.limit=\"10 N mm\"",
                                                 "gripper.object_diameter=\"75 mm\""});
  if (both) made.gripper->fingers = Fingers::both;
  return made;
}

Scene impossible_brace() {
  return combination::scene("brace", {"rod.actuator.0.limit=\"0.1 N mm\"", "contact.mode=require",
                                      "contact.min_force=\"0.9 N\"", "rod.linear_density=0"});
}

}  // namespace tendril::search
