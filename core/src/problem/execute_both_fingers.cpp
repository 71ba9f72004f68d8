#include <algorithm>
#include <array>
#include <optional>

#include "certificate/certifier.hpp"
#include "rod/self_overlap.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

constexpr std::array<FingerName, 2> both{FingerName::upper, FingerName::lower};

std::string named(FingerName finger, const std::string& message) {
  return message.empty() ? "" : std::string(to_string(finger)) + " finger: " + message;
}

/// The start of one finger; a plan without a lower finger is that of both, seen in their own worlds.
std::optional<Plan> start_of(const Scene& scene, const Plan* start, FingerName finger) {
  if (start == nullptr) return std::nullopt;
  return start->grasp && start->grasp->lower ? plan_of_finger(scene, *start, finger) : *start;
}

void add_snaps(const Scene& scene, const Execution& lower, Execution& whole) {
  const auto seen = [&](std::vector<BackbonePoint>& shape, std::vector<PlannedContact>& contacts) {
    Plan state;
    state.backbone = shape;
    state.contacts = contacts;
    const FingerPlan there = lower_in_world(scene, state);
    shape = there.backbone;
    contacts = there.contacts;
  };
  for (Snap snap : lower.snaps) {
    seen(snap.before, snap.contacts_before);
    seen(snap.after, snap.contacts_after);
    whole.snaps.push_back(std::move(snap));
  }
}

/// Both fingers' states as one.
Execution joined(const Scene& scene, double palm_distance, const Execution& upper, const Execution& lower) {
  Execution whole = upper;
  Plan& result = whole.result;
  result.message = named(FingerName::upper, upper.result.message);
  if (upper.result.status == PlanStatus::solved) {
    result.status = lower.result.status;
    result.message = named(FingerName::lower, lower.result.message);
  }
  for (std::string& note : result.notes) note = named(FingerName::upper, note);
  for (const std::string& note : lower.result.notes) result.notes.push_back(named(FingerName::lower, note));
  result.certificate = worse_of(upper.result.certificate, lower.result.certificate);
  result.seconds_solve += lower.result.seconds_solve;
  result.seconds_certify += lower.result.seconds_certify;
  whole.load = std::min(upper.load, lower.load);
  whole.steps += lower.steps;
  whole.contact_changes += lower.contact_changes;
  whole.tendon_changes += lower.tendon_changes;
  whole.pieces += lower.pieces;
  add_snaps(scene, lower, whole);
  FingerPlan below = lower_in_world(scene, lower.result);
  const auto sides = [&](const std::vector<BackbonePoint>& backbone, FingerName name) {
    const Scene finger = finger_of(scene, name);
    const BodyRadius body = finger.rod.body();
    return body ? body_outline(backbone, body) : backbone;
  };
  if (result.status == PlanStatus::solved &&
      meeting_of(sides(result.backbone, FingerName::upper), sides(below.backbone, FingerName::lower))) {
    result.status = PlanStatus::not_converged;
    result.message = "the fingers cross each other: contact between them is not computed";
  }
  result.grasp = grasp_of(scene, palm_distance, result.contacts, below.contacts);
  result.grasp->lower = std::move(below);
  return whole;
}

}  // namespace

Execution execute_both_fingers(const Scene& scene, double palm_distance, const std::vector<double>& held,
                               const ExecuteControl& control) {
  std::array<Execution, 2> done;
  std::array<Scene, 2> scenes{finger_of(scene, FingerName::upper), finger_of(scene, FingerName::lower)};
  const std::size_t first = scenes[0].rod.actuators.size();
  const std::size_t all = first + scenes[1].rod.actuators.size();
  if (held.size() != all) {
    throw Error("found " + std::to_string(held.size()) + " moments, expected one for each of the fingers' " +
                std::to_string(all) + " actuators");
  }
  // The lower finger's own world is the mirror image.
  Plan lower;
  lower.place = control.lower_place;
  const std::array<RodPlace, 2> places{control.place, lower_in_world(scene, lower).place};
  for (std::size_t which = 0; which < 2; ++which) {
    const std::optional<Plan> start = start_of(scene, control.start, both[which]);
    ExecuteControl own = control;
    own.start = start ? &*start : nullptr;
    own.place = places[which];
    const auto begin = held.begin() + static_cast<std::ptrdiff_t>(which == 0 ? 0 : first);
    const std::vector<double> part(begin, which == 0 ? held.begin() + static_cast<std::ptrdiff_t>(first) : held.end());
    done[which] = execute(finger_in_world(scenes[which]), obstacles_of_finger(scenes[which], palm_distance), part, own);
  }
  return joined(scene, palm_distance, done[0], done[1]);
}

Execution verify_both_fingers(const Scene& scene, Plan& plan, const ExecuteControl& control) {
  if (!plan.grasp || !plan.grasp->lower) throw Error("the plan has no lower finger to be carried out");
  const double palm_distance = plan.grasp->palm_distance;
  std::array<Execution, 2> done;
  std::array<Plan, 2> fingers{plan_of_finger(scene, plan, FingerName::upper),
                              plan_of_finger(scene, plan, FingerName::lower)};
  const bool from_itself = control.start == nullptr || control.start == &plan;
  plan.verification.clear();
  plan.model_error.reset();
  plan.local_model_error.reset();
  bool complete = true;
  bool local_complete = true;
  for (std::size_t which = 0; which < 2; ++which) {
    Plan& one = fingers[which];
    const Scene own_scene = finger_of(scene, both[which]);
    const std::optional<Plan> start = start_of(scene, control.start, both[which]);
    ExecuteControl own = control;
    own.start = from_itself ? &one : &*start;
    done[which] = verify(finger_in_world(own_scene), obstacles_of_finger(own_scene, palm_distance), one, own);
    const auto take_larger = [](std::optional<double>& kept, const std::optional<double>& value, bool& every) {
      every = every && value.has_value();
      if (value) kept = std::max(kept.value_or(0.0), *value);
    };
    take_larger(plan.model_error, one.model_error, complete);
    take_larger(plan.local_model_error, one.local_model_error, local_complete);
    plan.verification += (which == 0 ? "" : "; ") + named(both[which], one.verification);
    if (plan.status == PlanStatus::solved && one.status != PlanStatus::solved) {
      plan.status = one.status;
      plan.message = named(both[which], one.message);
    }
  }
  if (!complete) plan.model_error.reset();
  if (!local_complete) plan.local_model_error.reset();
  Execution whole = joined(scene, palm_distance, done[0], done[1]);
  if (plan.status == PlanStatus::solved && whole.result.status != PlanStatus::solved) {
    plan.status = PlanStatus::not_converged;
    plan.message = "execution does not confirm the plan: " + whole.result.message;
  }
  return whole;
}

}  // namespace tendril
