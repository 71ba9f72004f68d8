#pragma once

#include <Eigen/LU>
#include <memory>
#include <optional>
#include <vector>

#include "certificate/certifier.hpp"
#include "program/reduced_program.hpp"
#include "search/earlier_plan.hpp"
#include "search/friction_states.hpp"

/// The contacts of a plan as ones that rub, and the states that friction allows them (model.md section 11).
namespace tendril {

/// Coefficients of friction of the obstacles that a task respects; empty: all are 0.
std::vector<double> coefficients_of_friction(const Task& task);

/// The contacts of a plan in a program whose tangential ratios are variables, and the plan's own point there.
struct RubbingPoint {
  FollowedPoint from{};
  PoseProgramSpec spec{};
};
std::optional<RubbingPoint> rubbing_point(const Task& task, const Plan& plan, bool with_checks);

/// A program all of whose contacts touch.
std::unique_ptr<PoseProgram> touching(const PoseProgramSpec& spec);

/// The states of friction of plans that follow one another with the same contacts, at the moments of each: without
/// friction, then with every contact about to slip either way. They are followed to in the plan's own coordinates,
/// touching what it touches, or from the same state of the plan before, while it lies near; an object that is held
/// stays where it is. Limits of forces and of the target are not looked at.
class RubbingStates {
 public:
  /// For this plan and those that follow from it. Null: its states cannot be followed to. `task` must outlive it.
  static std::unique_ptr<RubbingStates> from(const Task& task, const Plan& plan);

  /// Of a certified plan; `x`: its point, which may lack the ratios where they are 0.
  FrictionStates of(const Plan& plan, ConstVectorRef x);
  /// Of the plan that this began with.
  FrictionStates of(const Plan& plan) { return of(plan, plan_); }

 private:
  /// A state and, where plans follow, how the equations are solved near it.
  struct Known {
    Eigen::VectorXd ratios, x;
    Eigen::MatrixXd slope{};  ///< unknowns x chosen; empty: not known yet, nor are the factors
    Eigen::PartialPivLU<Eigen::MatrixXd> factors{};
  };

  RubbingStates(const Task& task, RubbingPoint point, std::unique_ptr<PoseProgram> program);
  std::optional<SeenState> at(const Plan& plan, const Eigen::VectorXd& ratios);
  /// From the state of an earlier plan: x_ is then the point. False: it does not lie near.
  bool reach(Known& known);
  /// From the plan.
  bool reach(const Eigen::VectorXd& ratios);
  void linearize(Known& known, const Eigen::VectorXd& at);
  /// Nothing: the point is none that the rod can be in.
  std::optional<SeenState> certified();
  SeenState as_planned(const Plan& plan) const;

  const Task& task_;
  RubbingPoint point_;
  std::unique_ptr<PoseProgram> program_;
  Certifier certifier_;
  Equations equations_;
  std::vector<int> chosen_;  ///< variables that are as planned
  Eigen::VectorXd limits_, plan_, x_, predicted_, correction_;
  std::unique_ptr<ReducedProgram> from_plan_;  ///< null: not asked for yet
  std::vector<Known> known_;
  Certificate certificate_;
  Plan told_;
};

/// The states of a solved plan. Nothing: they cannot be followed to.
std::optional<FrictionStates> friction_states(const Task& task, const Plan& plan);

}  // namespace tendril
