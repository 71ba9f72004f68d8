#include "search/follower.hpp"

#include <algorithm>
#include <cstdio>

#include "base/clock.hpp"
#include "certificate/check_points.hpp"
#include "rod/self_overlap.hpp"
#include "search/contacts.hpp"
#include "search/report.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Longer than any outcome that is written here, so that none allocates after the first.
constexpr std::size_t outcome_size = 120;
/// A rod that is so far (units of L) from an obstacle may touch it in the next step.
constexpr double near = 0.01;

void set_outcome(std::string& to, const char* text) {
  to.reserve(outcome_size);
  to = text;
}

}  // namespace

std::unique_ptr<Follower> Follower::from(Task& problem, const Plan& plan) {
  if (problem.palm) return nullptr;
  std::optional<FollowedPoint> point = followed_point(problem, plan);
  if (!point) return nullptr;
  PoseProgramSpec spec = problem.spec(point->mode, point->regions, problem.nodes);
  spec.checks = point->checks;
  return std::unique_ptr<Follower>(new Follower(problem, std::move(*point), spec));
}

Follower::Follower(Task& problem, FollowedPoint point, const PoseProgramSpec& spec)
    : problem_(problem),
      point_(std::move(point)),
      program_(spec),
      certifier_(program_),
      sampler_(certifier_.finer(point_.x).chain()) {
  polisher_.keep_factorization();
  for (int k = 0; k < program_.layout().forces; ++k) program_.set_branch(k, Branch::touching);
}

bool Follower::stands_at(const Plan& plan) const {
  const auto n = static_cast<std::size_t>(program_.layout().coordinates);
  return plan.status == PlanStatus::solved && plan.coordinates.size() == n &&
         std::equal(plan.coordinates.begin(), plan.coordinates.end(), point_.x.data()) &&
         std::count_if(plan.contacts.begin(), plan.contacts.end(),
                       [](const PlannedContact& c) { return c.force > 0.0; }) == program_.layout().forces;
}

bool Follower::step(Plan& plan) {
  const double begin = now();
  ended_ = nullptr;
  program_.set_target(problem_.target);
  certifier_.set_target(problem_.target);
  const EvaluationCounts before = program_.counts();
  const PolishReport& polished = polisher_.run(program_, point_.x, multipliers_);
  if (!polished.converged || !(polished.infeasibility <= tolerance::equilibrium)) return false;
  ended_ = &polished.x;
  const double polishing = now();
  certifier_.certify(program_, polished.x, certificate_, &polished.multipliers, &polished.bound_multipliers);
  if (!certificate_.valid() || certificate_.quadrature > tolerance::quadrature) return false;
  // Only what the certificate sees near can be so near that a check point has to move.
  if (certificate_.penetration >= -violation_level && certifier_.approached(polished.x, violation_level)) return false;
  if (!contacts_unchanged(problem_, program_, polished.x)) return false;
  point_.x = polished.x;
  multipliers_ = polished.multipliers;
  write(plan, begin, now() - polishing, before);
  return true;
}

std::unique_ptr<Follower> Follower::at(Task& problem, const std::vector<ContactSetup>& contacts,
                                       const StartShape& start) {
  FollowedPoint point;
  point.mode = contacts.empty() ? problem.modes.front() : problem.mode(contacts);
  if (!point.mode.skip.empty()) return nullptr;
  for (const ContactSetup& c : contacts) point.regions.push_back(c.region);
  PoseProgramSpec spec = problem.spec(point.mode, point.regions, problem.nodes);
  const PoseProgram bare(spec);
  point.x = bare.start_from(start);
  point.checks = spec.checks = problem.first_checks(bare, point.x, start);
  return std::unique_ptr<Follower>(new Follower(problem, std::move(point), spec));
}

std::unique_ptr<Follower> Follower::step_with_other_contacts(Plan& plan) const {
  const Task& d = problem_;
  const bool plain = d.scene.coordinates.split_at_contact && d.min_force == 0.0 && d.friction.empty();
  if (ended_ == nullptr || !d.contact_planned() || !plain) return nullptr;
  const auto succeeds = [&](const std::vector<ContactSetup>& contacts, const StartShape& start) {
    std::unique_ptr<Follower> next = at(problem_, contacts, start);
    if (next && !next->step(plan)) next.reset();
    return next;
  };
  const Eigen::VectorXd& x = *ended_;
  const std::vector<ContactSetup>& before = point_.mode.contacts;
  const StartShape shape = program_.shape_of(x);
  std::vector<ContactSetup> pressing;
  StartShape held = shape;
  held.arc_lengths.clear();
  held.forces.clear();
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (!(shape.forces[k] > tolerance::force)) continue;
    pressing.push_back(before[k]);
    held.arc_lengths.push_back(shape.arc_lengths[k]);
    held.forces.push_back(shape.forces[k]);
  }
  if (pressing.size() < before.size()) {
    const bool may_be_free = !pressing.empty() || d.modes.front().contacts.empty();
    return may_be_free ? succeeds(pressing, held) : nullptr;
  }
  if (static_cast<int>(before.size()) >= d.scene.contact.count) return nullptr;
  for (const Extension& extension : extensions(d, before, shape)) {
    if (extension.distance > near) break;
    if (std::unique_ptr<Follower> next = succeeds(extension.contacts, extension.start)) return next;
  }
  return nullptr;
}

std::optional<FrictionStates> Follower::friction_states(const Plan& plan) {
  if (!rubbing_) rubbing_ = RubbingStates::from(problem_, plan);
  return rubbing_ ? std::optional(rubbing_->of(plan, point_.x)) : std::nullopt;
}

void Follower::write(Plan& plan, double begin, double certifying, const EvaluationCounts& before) {
  const Task& d = problem_;
  plan.status = PlanStatus::solved;
  plan.message.clear();
  plan.verification.clear();
  plan.model_error.reset();
  plan.local_model_error.reset();
  tell_point(d, program_, point_.x, plan);
  sampler_.sample(certifier_.finer(point_.x), certifier_.curve(), d.scale.length, plan.backbone);
  plan.self_overlap = self_overlap(plan.backbone, d.scene.rod.body());
  plan.certificate = certificate_;

  plan.solver_name = d.scene.solver.plugin;
  plan.search_cut = false;
  plan.solver = OptimalityReport{};
  plan.evaluations = program_.counts();
  plan.evaluations.values -= before.values;
  plan.evaluations.first_derivatives -= before.first_derivatives;
  plan.evaluations.hessians -= before.hessians;
  plan.evaluations.seconds -= before.seconds;
  plan.seconds_assemble = d.seconds_assemble;
  plan.seconds_certify = certifying;
  plan.seconds_solve = now() - begin - certifying;

  const auto own = [&](const ModeRecord& record) { return record.mode == point_.mode.name; };
  if (std::none_of(plan.modes.begin(), plan.modes.end(), own)) {
    plan.modes.clear();
    for (const Mode& mode : d.modes) {
      ModeRecord record;
      record.mode = mode.name;
      if (!mode.skip.empty()) record.outcome = "skipped: " + mode.skip;
      plan.modes.push_back(std::move(record));
    }
    if (std::none_of(plan.modes.begin(), plan.modes.end(), own)) {
      plan.modes.emplace_back();
      plan.modes.back().mode = point_.mode.name;
    }
  }
  for (ModeRecord& record : plan.modes) {
    const bool followed = own(record);
    if (!followed && record.outcome.rfind("skipped: ", 0) != 0) set_outcome(record.outcome, not_tried_outcome);
    if (followed) {
      char text[outcome_size];
      std::snprintf(text, sizeof text, "%scertified, objective %s", followed_outcome, shown(plan.objective).c_str());
      set_outcome(record.outcome, text);
    }
    record.solves = record.iterations = 0;
    record.evaluations = 0;
    record.seconds_evaluating = 0.0;
    record.polishes = followed ? 1 : 0;
    record.seconds = followed ? now() - begin : 0.0;
    record.certified = followed;
    record.objective = followed ? plan.objective : infinity;
  }
}

}  // namespace tendril
