#pragma once

#include <memory>

#include "certificate/certifier.hpp"
#include "nlp/polish.hpp"
#include "scene/plan_report.hpp"
#include "search/earlier_plan.hpp"
#include "search/rubbing.hpp"

namespace tendril {

/// How the records of ways of being in contact read where the earlier plan was followed.
inline constexpr const char* followed_outcome = "followed from the earlier plan; ";
inline constexpr const char* not_tried_outcome = "not tried: the earlier plan could be followed";

/// Goes from one plan of a pose to the next by Newton on one active set, with one program and one certificate that are
/// kept: a step that succeeds allocates nothing once the plan that it writes into has been written before, as long as
/// the active set stays. `problem` must outlive it.
class Follower {
 public:
  /// Null: this plan cannot be followed.
  static std::unique_ptr<Follower> from(Task& problem, const Plan& plan);

  /// Whether the last step ended at this plan.
  bool stands_at(const Plan& plan) const;
  /// To the problem's target. False: Newton did not get there, or the point is not certified, or a contact may come or
  /// go; `plan` is then as it was.
  bool step(Plan& plan);
  /// After a step that failed because a contact comes or goes: goes to the target with other contacts, those that still
  /// press, or one more where the rod comes to an obstacle. Null: Newton leads to no certified plan there, and `plan`
  /// is as it was.
  std::unique_ptr<Follower> step_with_other_contacts(Plan& plan) const;
  /// The states of friction of the plan that the last step ended at. Nothing: they cannot be followed to.
  std::optional<FrictionStates> friction_states(const Plan& plan);

 private:
  Follower(Task& problem, FollowedPoint point, const PoseProgramSpec& spec);
  static std::unique_ptr<Follower> at(Task& problem, const std::vector<ContactSetup>& contacts,
                                      const StartShape& start);
  void write(Plan& plan, double begin, double certifying, const EvaluationCounts& before);

  Task& problem_;
  FollowedPoint point_;
  PoseProgram program_;
  Certifier certifier_;
  Polisher polisher_;
  BackboneSampler sampler_;
  Certificate certificate_;
  Eigen::VectorXd multipliers_;
  std::unique_ptr<RubbingStates> rubbing_;  ///< null: not asked for yet, or they cannot be followed to
  const Eigen::VectorXd* ended_ = nullptr;  ///< where Newton ended in the last step; null: nowhere
};

}  // namespace tendril
