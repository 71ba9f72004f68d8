#include "search/rubbing.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/plan_report.hpp"
#include "search/completion.hpp"
#include "search/follower.hpp"
#include "search/report.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

// Newton's method with the factors of an earlier point. Changes of unknowns are relative to 1 + themselves.
constexpr double farthest = 0.1;      ///< the equations change more than factors are good for
constexpr double most_of_way = 0.5;   ///< what the first correction may be of the way that slopes point
constexpr double start_error = 1e-7;  ///< ... and besides: the state before is known to this
constexpr double slow = 0.05;         ///< corrections that shrink less need new factors
constexpr double converges = 0.5;     ///< what shrinks less does not converge
constexpr double settled_to = 1e-13;
constexpr int most_corrections = 12;

/// Of an equilibrium at given moments: nothing was chosen there. Limits are not looked at, except that each contact is
/// on its stretch.
void certify_equilibrium(Certifier& certifier, PoseProgram& program, ConstVectorRef x, Certificate& c) {
  certifier.judge(program, x, c);
  const PoseProgram::Layout& at = program.layout();
  c.bounds = 0.0;
  for (int i = at.first_arc_length; i < at.first_force; ++i) {
    c.bounds = std::max({c.bounds, program.lower()[i] - x[i], x[i] - program.upper()[i]});
  }
  c.balance = c.stationarity = 0.0;
  c.stationarity_kind = "S";
  list_failures(c);
}

Eigen::VectorXd without_ratios(const PoseProgram::Layout& at, const Eigen::VectorXd& x) {
  Eigen::VectorXd rest(x.size() - at.leans);
  rest << x.head(at.first_lean), x.tail(x.size() - at.first_lean - at.leans);
  return rest;
}

}  // namespace

std::vector<double> coefficients_of_friction(const Task& task) {
  std::vector<double> all;
  bool any = false;
  for (std::size_t o = 0; o < task.scene.obstacles.size(); ++o) {
    all.push_back(friction_of(task.scene, o));
    any = any || all.back() > 0.0;
  }
  return any ? all : std::vector<double>{};
}

std::optional<RubbingPoint> rubbing_point(const Task& task, const Plan& plan, bool with_checks) {
  std::optional<FollowedPoint> from = followed_point(task, plan, with_checks);
  if (!from || from->mode.contacts.empty() || !task.scene.coordinates.split_at_contact) return std::nullopt;
  RubbingPoint point{std::move(*from), {}};
  point.spec = task.spec(point.from.mode, point.from.regions, task.nodes);
  point.spec.checks = point.from.checks;
  point.spec.friction = coefficients_of_friction(task);
  // Ratios come last, but for the distance of a palm.
  const auto contacts = static_cast<Eigen::Index>(point.from.mode.contacts.size());
  const Eigen::Index behind = task.palm && task.palm->minimum != task.palm->maximum ? 1 : 0;
  if (task.friction.empty()) {
    const Eigen::VectorXd x = point.from.x;
    point.from.x.resize(x.size() + contacts);
    point.from.x << x.head(x.size() - behind), Eigen::VectorXd::Zero(contacts), x.tail(behind);
  }
  return point;
}

std::unique_ptr<PoseProgram> touching(const PoseProgramSpec& spec) {
  auto program = std::make_unique<PoseProgram>(spec);
  for (int k = 0; k < program->layout().forces; ++k) program->set_branch(k, Branch::touching);
  return program;
}

std::unique_ptr<RubbingStates> RubbingStates::from(const Task& task, const Plan& plan) {
  std::optional<RubbingPoint> point = rubbing_point(task, plan, false);
  if (!point) return nullptr;
  std::unique_ptr<PoseProgram> program = touching(point->spec);
  if (!ReducedProgram::applies(*program)) return nullptr;
  return std::unique_ptr<RubbingStates>(new RubbingStates(task, std::move(*point), std::move(program)));
}

RubbingStates::RubbingStates(const Task& task, RubbingPoint point, std::unique_ptr<PoseProgram> program)
    : task_(task),
      point_(std::move(point)),
      program_(std::move(program)),
      certifier_(*program_),
      equations_(Equations::of_contacts(*program_)),
      plan_(point_.from.x) {
  const PoseProgram::Layout& at = program_->layout();
  limits_ = program_->upper().segment(at.first_lean, at.leans);
  std::vector<bool> decided(static_cast<std::size_t>(program_->variable_count()), false);
  for (int i = 0; i < equations_.size(); ++i) decided[static_cast<std::size_t>(equations_.unknown(i))] = true;
  for (int i = 0; i < at.leans; ++i) decided[static_cast<std::size_t>(at.first_lean + i)] = true;
  for (int i = 0; i < program_->variable_count(); ++i) {
    if (!decided[static_cast<std::size_t>(i)]) chosen_.push_back(i);
  }
}

FrictionStates RubbingStates::of(const Plan& plan, ConstVectorRef x) {
  const PoseProgram::Layout& at = program_->layout();
  if (x.size() == program_->variable_count()) {
    plan_ = x;
  } else {
    plan_ << x.head(at.first_lean), Eigen::VectorXd::Zero(at.leans), x.tail(x.size() - at.first_lean);
  }
  from_plan_.reset();
  return follow_states(
      limits_, [&](const Eigen::VectorXd& ratios) { return this->at(plan, ratios); }, true);
}

std::optional<SeenState> RubbingStates::at(const Plan& plan, const Eigen::VectorXd& ratios) {
  const PoseProgram::Layout& layout = program_->layout();
  // The certificate of a grasp is one of its object, too, and its fingers are told in another frame.
  if (!task_.grip && ratios == plan_.segment(layout.first_lean, layout.leans) && ratios.isZero(0.0)) {
    return as_planned(plan);
  }
  const auto known =
      std::find_if(known_.begin(), known_.end(), [&](const Known& state) { return state.ratios == ratios; });
  if (known != known_.end()) {
    std::optional<SeenState> seen = reach(*known) ? certified() : std::nullopt;
    if (seen) known->x = x_;
    if (seen) return seen;
    known_.erase(known);
  }
  if (!reach(ratios)) return std::nullopt;
  std::optional<SeenState> seen = certified();
  if (seen) known_.push_back({ratios, x_});
  return seen;
}

bool RubbingStates::reach(const Eigen::VectorXd& ratios) {
  if (!from_plan_) from_plan_ = std::make_unique<ReducedProgram>(*program_, plan_);
  Eigen::VectorXd u = from_plan_->start();
  u.tail(ratios.size()) = ratios;
  x_ = from_plan_->full(u);
  return x_.allFinite();
}

void RubbingStates::linearize(Known& known, const Eigen::VectorXd& at) {
  equations_.evaluate(at);
  known.factors = equations_.factor();
  equations_.find_rates(at, chosen_, known.slope);
}

bool RubbingStates::reach(Known& known) {
  if (known.slope.size() == 0) linearize(known, known.x);
  const int unknowns = equations_.size();
  x_ = known.x;
  for (std::size_t j = 0; j < chosen_.size(); ++j) {
    const double way = plan_[chosen_[j]] - known.x[chosen_[j]];
    x_[chosen_[j]] = plan_[chosen_[j]];
    for (int i = 0; i < unknowns; ++i) x_[equations_.unknown(i)] += known.slope(i, static_cast<Eigen::Index>(j)) * way;
  }
  const auto relative = [&](int i, double change) { return std::abs(change) / (1.0 + std::abs(x_[i])); };
  double pointed = 0.0;
  for (int i = 0; i < unknowns; ++i) {
    const int v = equations_.unknown(i);
    pointed = std::max(pointed, relative(v, x_[v] - known.x[v]));
  }
  if (!(pointed <= farthest)) return false;
  double before = infinity;
  for (int n = 0; n < most_corrections; ++n) {
    correction_ = known.factors.solve(equations_.residual_at(x_));
    double size = 0.0;
    for (int i = 0; i < unknowns; ++i) {
      const int v = equations_.unknown(i);
      size = std::max(size, relative(v, correction_[i]));
      x_[v] -= correction_[i];
    }
    if (!x_.allFinite()) return false;
    const double rate = n == 0 ? 1.0 : size / before;
    if (size * rate <= settled_to) return true;
    if (!(size <= (n == 0 ? most_of_way * pointed + start_error : converges * before))) return false;
    if (n > 0 && rate > slow) linearize(known, x_);
    before = size;
  }
  return false;
}

std::optional<SeenState> RubbingStates::certified() {
  certify_equilibrium(certifier_, *program_, x_, certificate_);
  if (!certificate_.valid()) return std::nullopt;
  tell_point(task_, *program_, x_, told_);
  if (task_.grip) {
    told_.backbone = sampled_backbone(*program_, task_.scale.length);
    task_.grip->finish(task_, *program_, x_, told_);
  }
  SeenState seen{
      {{}, told_.tip_x, told_.tip_y, told_.tip_angle, told_.target_error, certificate_.stability, told_.contacts},
      told_.backbone,
      without_ratios(program_->layout(), x_)};
  for (std::size_t k = 0; k < told_.contacts.size(); ++k) {
    const double side = dot(told_.contacts[k].tangent, turned(told_.contacts[k].normal));
    seen.range.ratios.push_back(std::copysign(1.0, side) * program_->contacts()[k].lean + 0.0);
  }
  return seen;
}

SeenState RubbingStates::as_planned(const Plan& plan) const {
  SeenState seen{{std::vector<double>(plan.contacts.size(), 0.0), plan.tip_x, plan.tip_y, plan.tip_angle,
                  plan.target_error, plan.certificate.stability, plan.contacts},
                 {},
                 without_ratios(program_->layout(), plan_)};
  // Inside of their cones.
  for (std::size_t k = 0; k < seen.range.contacts.size(); ++k) {
    seen.range.contacts[k].sticks = limits_[static_cast<Eigen::Index>(k)] > tolerance::bounds;
  }
  return seen;
}

std::optional<FrictionStates> friction_states(const Task& task, const Plan& plan) {
  if (task.follower && task.follower->stands_at(plan)) return task.follower->friction_states(plan);
  const std::unique_ptr<RubbingStates> states = RubbingStates::from(task, plan);
  return states ? std::optional(states->of(plan)) : std::nullopt;
}

}  // namespace tendril
