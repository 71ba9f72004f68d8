#include "study_case.hpp"

#include <algorithm>
#include <cmath>

#include "result_object.hpp"
#include "trajectory_result.hpp"

namespace tendril::app {

namespace {

/// Lines of a figure have this many points.
constexpr std::size_t line_points = 41;

Json line_json(const std::vector<BackbonePoint>& backbone) {
  Json line = Json::array();
  const std::size_t count = std::min(line_points, backbone.size());
  for (std::size_t i = 0; i < count; ++i) {
    const BackbonePoint& p = backbone[count > 1 ? i * (backbone.size() - 1) / (count - 1) : 0];
    line.push_back(numbers({p[1], p[2]}));
  }
  return line;
}

Json head_of(const StudyCase& one) {
  Json json;
  json["index"] = one.index;
  json["limit"] = one.limit ? number(*one.limit) : Json(nullptr);
  json["mode"] = one.mode ? Json(to_string(*one.mode)) : Json(nullptr);
  json["target"] = one.target ? numbers({one.target->x, one.target->y}) : Json(nullptr);
  return json;
}

/// Removes what differs from run to run.
void drop_times(Json& json) {
  if (json.is_object()) {
    // A solver's options hold the time that was left to it.
    for (const char* key : {"seconds", "seconds_evaluating", "options"}) json.erase(key);
    // The file's name may be written in several ways.
    json.erase("scene");
  }
  if (!json.is_structured()) return;
  for (Json& part : json) drop_times(part);
}

std::string one_line(Json json) {
  drop_times(json);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// What counts in tables and figures: where the tip came to and what it took.
void add_outcome(Json& json, const Plan& reached, const Scene& scene) {
  const bool has_shape = !reached.backbone.empty();
  double force = 0.0;
  Json contacts = Json::array();
  for (const PlannedContact& contact : reached.contacts) {
    if (contact.force <= 0.0) continue;
    force += contact.force;
    contacts.push_back(numbers({contact.point.x, contact.point.y}));
  }
  json["tip"] = has_shape ? numbers({reached.tip_x, reached.tip_y}) : Json(nullptr);
  json["tip_error"] =
      has_shape && scene.target.position
          ? number(std::hypot(reached.tip_x - scene.target.position->x, reached.tip_y - scene.target.position->y))
          : Json(nullptr);
  json["contact_force"] = has_shape ? number(force) : Json(nullptr);
  json["contact_points"] = std::move(contacts);
  json["lines"] = Json::array({line_json(reached.backbone)});
}

class CaseRunner {
 public:
  CaseRunner(Session& session, const Scene& scene, const StudySpec& study)
      : session_(session), scene_(scene), study_(study) {}

  Json run(const StudyCase& one) {
    Json json = head_of(one);
    if (scene_.problem == ProblemKind::trajectory) return run_steps(one, std::move(json));
    const Outcome outcome = carry_through(one, true);
    json["status"] = to_string(outcome.plan.status);
    json["message"] = outcome.plan.message;
    json["moments"] = numbers(outcome.plan.moments);
    add_outcome(json, outcome.reached, session_.scene());
    json["plan"] = plan_object(session_.scene(), outcome.plan);
    return json;
  }

 private:
  struct Outcome {
    Plan plan;
    Plan reached;  ///< what the rod does; the plan itself where nothing else is known
  };

  Outcome carry_through(const StudyCase& one, bool with_starts) {
    std::vector<Plan> starts;
    const bool plans_contact = one.mode == StudyMode::allow || one.mode == StudyMode::require;
    if (with_starts && plans_contact) {
      for (const StudyMode mode : study_.starts) {
        StudyCase other = one;
        other.mode = mode;
        starts.push_back(carry_through(other, false).reached);
      }
    }
    session_.use(scene_of(scene_, one));
    Outcome outcome;
    outcome.plan = session_.plan_from(nullptr);
    for (const Plan& start : starts) {
      if (start.backbone.empty()) continue;
      Plan other = session_.plan_from(&start);
      const bool better = other.status == PlanStatus::solved &&
                          (outcome.plan.status != PlanStatus::solved || other.objective < outcome.plan.objective);
      if (better) outcome.plan = std::move(other);
    }
    outcome.reached = outcome.plan;
    return outcome;
  }

  Json run_steps(const StudyCase& one, Json json) {
    session_.use(scene_of(scene_, one));
    const Trajectory trajectory = session_.plan_trajectory();
    json.update(trajectory_object(session_.scene(), trajectory));
    Json lines = Json::array();
    Json contacts = Json::array();
    Json targets = Json::array();
    double moment = 0.0;
    double error = 0.0;
    double force = 0.0;
    for (const TrajectoryStep& step : trajectory.steps) {
      lines.push_back(line_json(step.plan.backbone));
      if (step.target.position) targets.push_back(numbers({step.target.position->x, step.target.position->y}));
      for (const PlannedContact& contact : step.plan.contacts) {
        if (contact.force > 0.0) contacts.push_back(numbers({contact.point.x, contact.point.y}));
        force += contact.force;
      }
      error += step.plan.target_error.value_or(0.0);
      for (const double m : step.plan.moments) moment = std::max(moment, std::abs(m));
    }
    const double count = std::max<double>(1.0, static_cast<double>(trajectory.steps.size()));
    json["moments"] = numbers({moment});
    json["tip_error"] = number(error / count);
    json["contact_force"] = number(force / count);
    json["contact_points"] = std::move(contacts);
    json["path"] = std::move(targets);
    json["lines"] = std::move(lines);
    return json;
  }

  Session& session_;
  const Scene& scene_;
  const StudySpec& study_;
};

}  // namespace

std::string run_case(Session& session, const Scene& scene, const StudySpec& study, const StudyCase& one) {
  try {
    return one_line(CaseRunner(session, scene, study).run(one));
  } catch (const Error& error) {
    return failed_case(one, error.what());
  }
}

std::string failed_case(const StudyCase& one, const std::string& message) {
  Json json = head_of(one);
  json["status"] = to_string(PlanStatus::failed);
  json["message"] = message;
  json["lines"] = Json::array();
  return one_line(std::move(json));
}

}  // namespace tendril::app
