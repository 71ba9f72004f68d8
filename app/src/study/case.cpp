#include "study/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "result/result_object.hpp"
#include "result/trajectory_result.hpp"
#include "study/grasp.hpp"
#include "study/result.hpp"
#include "tendril/execute.hpp"
#include "tendril/scale.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::app {

namespace {

/// Lines of a figure have this many points.
constexpr std::size_t line_points = 41;

/// Tips (L) of two equilibria on the fine basis: one state to rounding and to the tolerance of its contacts' places, or
/// two that are well apart.
constexpr double same_state = 1e-6;

Json line_json(const std::vector<BackbonePoint>& backbone) {
  Json line = Json::array();
  const std::size_t count = std::min(line_points, backbone.size());
  for (std::size_t i = 0; i < count; ++i) {
    const BackbonePoint& p = backbone[count > 1 ? i * (backbone.size() - 1) / (count - 1) : 0];
    line.push_back(numbers({p.x, p.y}));
  }
  return line;
}

Json head_of(const StudyCase& one) {
  Json json;
  json["index"] = one.index;
  json["limit"] = one.limit ? number(*one.limit) : Json(nullptr);
  if (one.limit) json["limit_unit"] = one.limited.unit;
  json["mode"] = one.mode ? Json(to_string(*one.mode)) : Json(nullptr);
  json["target"] = one.target ? numbers({one.target->x, one.target->y}) : Json(nullptr);
  if (one.insertion) json["insertion"] = number(*one.insertion);
  if (one.base_position) json["base_position"] = numbers({one.base_position->x, one.base_position->y});
  if (one.base_angle) json["base_angle"] = number(*one.base_angle);
  if (one.shift || one.turn) {
    Json moved{{"obstacle", one.obstacle}};
    if (one.shift) moved["shift"] = numbers({one.shift->x, one.shift->y});
    if (one.turn) moved["turn"] = number(*one.turn);
    json["moved_obstacles"].push_back(std::move(moved));
  }
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

double grazing(const Scene& scene) { return grazing_force * scale_of(scene).force(); }

double total_force(const Plan& plan) {
  double force = 0.0;
  for (const PlannedContact& contact : plan.contacts) force += contact.force;
  return force;
}

/// Where an obstacle bears the rod, not where it is only grazed.
void add_points(Json& list, const Plan& plan, const Scene& scene) {
  for (const PlannedContact& contact : plan.contacts) {
    if (contact.force > grazing(scene)) list.push_back(numbers({contact.point.x, contact.point.y}));
  }
}

/// What counts in tables and figures: where the tip came to and what it took.
void add_outcome(Json& json, const Plan& reached, const Scene& scene) {
  const bool has_shape = !reached.backbone.empty();
  Json contacts = Json::array();
  add_points(contacts, reached, scene);
  json["tip"] = has_shape ? numbers({reached.tip_x, reached.tip_y}) : Json(nullptr);
  json["tip_error"] =
      has_shape && scene.target.position
          ? number(std::hypot(reached.tip_x - scene.target.position->x, reached.tip_y - scene.target.position->y))
          : Json(nullptr);
  json["contact_force"] = has_shape ? number(total_force(reached)) : Json(nullptr);
  json["contact_points"] = std::move(contacts);
  json["lines"] = Json::array({line_json(reached.backbone)});
}

std::string message_of(const Plan& plan) {
  const bool cut = plan.search_cut && plan.status == PlanStatus::solved;
  return cut ? "time ended the search before it was done: a better plan may exist" : plan.message;
}

class CaseRunner {
 public:
  CaseRunner(Session& session, const Scene& scene, const StudySpec& study)
      : session_(session), scene_(scene), study_(study) {}

  Json run(const StudyCase& one) {
    Json json = head_of(one);
    if (scene_.problem == ProblemKind::trajectory) return run_steps(one, std::move(json));
    if (scene_.problem == ProblemKind::grasp) {
      session_.use(scene_of(scene_, one));
      run_grasp_case(session_, one, json);
      return json;
    }
    const Outcome outcome = carry_through(one, true);
    json["status"] = to_string(outcome.plan.status);
    json["message"] = message_of(outcome.plan);
    json["moments"] = numbers(outcome.plan.moments);
    add_outcome(json, outcome.reached, session_.scene());
    json["model_error"] = outcome.model_error ? number(*outcome.model_error) : Json(nullptr);
    json["plan"] = plan_object(session_.scene(), outcome.plan);
    json["execution"] = outcome.execution;
    return json;
  }

 private:
  struct Outcome {
    Plan plan;
    Plan reached;  ///< what the rod does under the plan's moments; the plan itself if it could not be executed
    std::optional<double> model_error;  ///< m
    Json execution = nullptr;
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
    execute_plan(one, outcome);
    return outcome;
  }

  /// Carries out a plan: from its own shape, which shows what its coordinates leave out, and from the scene's start,
  /// which shows whether the loads lead there. A plan that ignores obstacles is judged without them; what the rod then
  /// does among them is what it does from the start.
  void execute_plan(const StudyCase& one, Outcome& outcome) {
    outcome.reached = outcome.plan;
    if (outcome.plan.status != PlanStatus::solved) return;
    const Scene& scene = session_.scene();
    const std::vector<std::unique_ptr<Obstacle>> obstacles = session_.make_obstacles();
    const bool meets = one.mode == StudyMode::ignore_then_execute;
    ExecuteControl own;
    own.with_friction = false;  // as it is planned
    own.friction = ratios_of(outcome.plan, obstacles.size());
    own.start = &outcome.plan;
    own.with_obstacles = scene.contact.mode != ContactModeName::ignore;
    const Execution settled = execute(scene, obstacles, outcome.plan, own);
    if (settled.result.status == PlanStatus::solved) {
      outcome.model_error = distance(settled.result, outcome.plan);
      if (*outcome.model_error > tolerance::model_error * scene.rod.length()) {
        refuse(outcome, "the rod settles elsewhere");
      } else if ((total_force(settled.result) > grazing(scene)) != (total_force(outcome.plan) > grazing(scene))) {
        refuse(outcome, "the rod settles with other contacts");
      }
    } else {
      refuse(outcome, settled.result.message);
    }

    ExecuteControl from_start;
    from_start.with_friction = false;
    from_start.friction = own.friction;
    from_start.with_obstacles = own.with_obstacles || meets;
    Json loaded;
    Json same = nullptr;
    if (!meets && settled.result.status == PlanStatus::solved) same = false;
    try {
      const Execution e = execute(scene, obstacles, outcome.plan, from_start);
      loaded = execution_object(scene, e);
      if (e.result.status == PlanStatus::solved) {
        if (!same.is_null()) same = distance(e.result, settled.result) <= same_state * scene.rod.length();
        if (meets) outcome.reached = e.result;
      }
      if (meets && e.result.status != PlanStatus::solved) refuse(outcome, e.result.message);
    } catch (const Error& error) {
      // A start that runs through an obstacle has no side to pass on; the plan itself may still be good.
      if (meets) throw;
      same = nullptr;
      loaded = {{"status", "refused"}, {"message", error.what()}};
    }
    if (!meets && settled.result.status == PlanStatus::solved) outcome.reached = settled.result;
    outcome.execution = {{"from_plan", execution_object(scene, settled)}, {"from_start", std::move(loaded)}};
    outcome.execution["start_leads_to_plan"] = std::move(same);
  }

  static double distance(const Plan& a, const Plan& b) { return std::hypot(a.tip_x - b.tip_x, a.tip_y - b.tip_y); }

  static void refuse(Outcome& outcome, const std::string& why) {
    outcome.plan.status = PlanStatus::not_converged;
    outcome.plan.message = "execution does not confirm the plan: " + why;
  }

  /// An execution without its shape, which the lines hold, and without what only a plan has.
  static Json execution_object(const Scene& scene, const Execution& execution) {
    Json json = plan_object(scene, execution.result);
    for (const char* key : {"schema", "title", "problem", "coordinates", "solver", "objective", "terms", "target_error",
                            "modes", "left_out", "backbone"}) {
      json.erase(key);
    }
    json["snaps"] = execution.snaps.size();
    json["load"] = number(execution.load);
    return json;
  }

  /// A whole trajectory is one case: means over its steps, the largest moment and model error.
  Json run_steps(const StudyCase& one, Json json) {
    session_.use(scene_of(scene_, one));
    const Trajectory trajectory = session_.plan_trajectory();
    json.update(trajectory_object(session_.scene(), trajectory));
    const StepOutcomes outcomes = execute_steps(one, trajectory);
    if (!outcomes.trouble.empty() && trajectory.solved()) {
      json["status"] = to_string(PlanStatus::not_converged);
      json["message"] = outcomes.trouble;
    }
    Json lines = Json::array();
    Json contacts = Json::array();
    Json path = Json::array();
    Json tips = Json::array();
    double moment = 0.0;
    double error = 0.0;
    double force = 0.0;
    for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
      const TrajectoryStep& step = trajectory.steps[i];
      const Plan& reached = outcomes.reached[i];
      lines.push_back(line_json(reached.backbone));
      tips.push_back(numbers({reached.tip_x, reached.tip_y}));
      add_points(contacts, reached, session_.scene());
      force += total_force(reached);
      if (step.target.position) {
        path.push_back(numbers({step.target.position->x, step.target.position->y}));
        error += std::hypot(reached.tip_x - step.target.position->x, reached.tip_y - step.target.position->y);
      }
      for (const double m : step.plan.moments) moment = std::max(moment, std::abs(m));
    }
    const double count = std::max<double>(1.0, static_cast<double>(trajectory.steps.size()));
    json["moments"] = numbers({moment});
    json["tip_error"] = path.empty() ? Json(nullptr) : number(error / count);
    json["contact_force"] = number(force / count);
    json["model_error"] = number(outcomes.model_error);
    json["tips"] = std::move(tips);
    json["contact_points"] = std::move(contacts);
    json["path"] = std::move(path);
    json["lines"] = std::move(lines);
    return json;
  }

  struct StepOutcomes {
    std::vector<Plan> reached;  ///< one for each step
    double model_error = 0.0;   ///< largest, m
    std::string trouble;        ///< the first one; empty: none
  };

  /// As execute_plan() for each step; what ignores obstacles and meets them goes from one step's state to the next.
  StepOutcomes execute_steps(const StudyCase& one, const Trajectory& trajectory) {
    StepOutcomes outcomes;
    const Scene& scene = session_.scene();
    const bool meets = one.mode == StudyMode::ignore_then_execute;
    std::optional<Plan> state;
    for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
      const Plan& plan = trajectory.steps[i].plan;
      outcomes.reached.push_back(plan);
      if (plan.status != PlanStatus::solved) continue;
      const auto take = [&](const Execution& e) {
        const bool good = e.result.status == PlanStatus::solved;
        if (!good && outcomes.trouble.empty()) {
          outcomes.trouble = fmt::format("execution does not confirm step {}: {}", i + 1, e.result.message);
        }
        return good;
      };
      const std::vector<std::unique_ptr<Obstacle>> obstacles = session_.make_obstacles(trajectory.steps[i].target);
      ExecuteControl control;
      control.with_friction = false;
      control.friction = ratios_of(plan, obstacles.size());
      control.start = &plan;
      control.with_obstacles = scene.contact.mode != ContactModeName::ignore;
      const Execution settled = execute(scene, obstacles, plan, control);
      if (take(settled)) {
        outcomes.model_error = std::max(outcomes.model_error, distance(settled.result, plan));
        if (!meets) outcomes.reached.back() = settled.result;
      }
      if (!meets) continue;
      control.start = state ? &*state : nullptr;
      control.with_obstacles = true;
      const Execution met = execute(scene, obstacles, plan, control);
      if (!take(met)) continue;
      state = met.result;
      outcomes.reached.back() = met.result;
    }
    return outcomes;
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

std::string study_heading(const Scene& scene) {
  std::string text =
      printable(scene.title.empty() ? std::filesystem::path(scene.file).filename().string() : scene.title) + "\n\n";
  if (scene.contact.friction_state == FrictionState::any)
    text += "friction_state \"any\": each plan holds if friction happens to be as its contacts have it\n\n";
  return text;
}

}  // namespace tendril::app
