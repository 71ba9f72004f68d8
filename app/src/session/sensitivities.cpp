#include "session/sensitivities.hpp"

#include <algorithm>
#include <optional>

#include "scene/error_bars.hpp"
#include "session/inputs.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::app {

namespace {

/// The derivatives by a key of the scene, from those by the numbers that it moves.
KeySensitivity by_key(const Sensitivity& sensitivity, const Spread& spread, std::string value) {
  KeySensitivity out{spread.key, std::move(value)};
  out.rates.resize(sensitivity.quantities.size());
  for (const Spread::Part& part : spread.parts) {
    const Sensitivity::Column* column = sensitivity.find(part.key);
    if (column == nullptr || !column->trouble.empty()) {
      out.trouble = column == nullptr ? "it moves nothing that is differentiated by" : column->trouble;
      return out;
    }
    for (std::size_t i = 0; i < out.rates.size(); ++i) out.rates[i] += part.rate * column->rates[i];
  }
  return out;
}

/// Numbers of the scene that results depend on, with what they move.
std::vector<Spread> all_numbers(const Session& session) {
  std::vector<Spread> spreads;
  for (const std::string& key : number_keys(session.document())) {
    try {
      spreads.push_back(spread_of(session.document(), session.scene(), key));
    } catch (const Error&) {
      continue;  // nothing goes with it, or nothing beside it can be read
    }
  }
  return spreads;
}

/// `held`: moments, N m.
std::vector<KeySensitivity> derivatives(const Session& session, const Sensitivity& sensitivity,
                                        const std::vector<std::string>& keys, const std::vector<double>& held) {
  std::vector<Spread> spreads;
  std::vector<std::string> moments;
  for (const Sensitivity::Column& column : sensitivity.columns) {
    if (column.number.key.starts_with("moments[")) moments.push_back(column.number.key);
  }
  const auto is_moment = [&](const std::string& key) {
    return std::find(moments.begin(), moments.end(), key) != moments.end();
  };
  if (keys.empty()) {
    spreads = all_numbers(session);
    for (const std::string& key : moments) spreads.push_back({key, 0.0, {{key, 1.0}}});
  }
  for (const std::string& key : keys) {
    spreads.push_back(is_moment(key) ? Spread{key, 0.0, {{key, 1.0}}}
                                     : spread_of(session.document(), session.scene(), key));
  }
  std::vector<KeySensitivity> out;
  for (Spread& spread : spreads) {
    if (sensitivity.kind == SensitivityKind::held) follow_held_inputs(session.scene(), held, spread);
    out.push_back(by_key(sensitivity, spread, written_value(session.document(), spread.key)));
  }
  return out;
}

/// The scene becomes one that plans the pose of a step.
void aim_at(Session& session, const TargetSpec& step) {
  Scene scene = with_obstacles(session.scene(), step);
  scene.problem = ProblemKind::pose;
  scene.trajectory = {};
  scene.target = step;
  scene.target.obstacles.clear();
  session.use(scene);
}

/// An earlier result, which its scene is made to ask for; nothing: there is none.
std::optional<JudgedPlan> earlier_of(Session& session, const SensitivityWishes& wishes) {
  if (!wishes.plan) return std::nullopt;
  JudgedPlan judged = parse_judged(wishes.plan->text, wishes.plan->name, session.scene(), wishes.step);
  if (session.scene().problem == ProblemKind::trajectory) aim_at(session, judged.step.value_or(TargetSpec{}));
  return judged;
}

/// What is differentiated where there is no earlier result.
JudgedPlan made(Session& session, const SensitivityWishes& wishes) {
  if (wishes.moments.text.empty()) return {session.plan(std::nullopt)};
  return {session.execute(moments_of(wishes.moments, session), std::nullopt).result, true};
}

}  // namespace

SceneSensitivity sensitivities_of(Session& session, const SensitivityWishes& wishes) {
  const Scene& scene = session.scene();
  const bool planned = !wishes.plan && wishes.moments.text.empty();
  const bool fits = scene.problem == ProblemKind::pose || (scene.problem == ProblemKind::execute && !planned) ||
                    (scene.problem == ProblemKind::trajectory && wishes.plan);
  if (!fits) {
    throw InputError(
        "sensitivity: found problem = \"" + std::string(to_string(scene.problem)) + "\", expected " +
        (scene.problem == ProblemKind::trajectory ? "a step of an earlier result of it" : "a scene that plans a pose"));
  }
  const std::optional<JudgedPlan> earlier = earlier_of(session, wishes);
  // A key that is not there is told before anything is planned.
  for (const std::string& key : wishes.keys) {
    if (!key.starts_with("moments[")) spread_of(session.document(), scene, key);
  }
  const JudgedPlan judged = earlier ? *earlier : made(session, wishes);
  SceneSensitivity out;
  out.of = judged.executed
               ? sensitivity_of(scene, session.make_obstacles(), judged.plan)
               : session.sensitivity(judged.plan, wishes.held ? SensitivityKind::held : SensitivityKind::replanned);
  if (out.of.trouble.empty()) out.keys = derivatives(session, out.of, wishes.keys, judged.plan.moments);
  return out;
}

}  // namespace tendril::app
