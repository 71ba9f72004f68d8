#include "session/sensitivities.hpp"

#include <algorithm>

#include "scene/error_bars.hpp"
#include "session/inputs.hpp"
#include "tendril/app/input_error.hpp"

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

/// What is differentiated.
JudgedPlan result_of(Session& session, const SensitivityWishes& wishes) {
  if (wishes.plan) return parse_judged(wishes.plan->text, wishes.plan->name, session.scene());
  if (wishes.moments.text.empty()) return {session.plan(std::nullopt)};
  return {session.execute(moments_of(wishes.moments, session), std::nullopt).result, true};
}

}  // namespace

SceneSensitivity sensitivities_of(Session& session, const SensitivityWishes& wishes) {
  const Scene& scene = session.scene();
  const bool planned = !wishes.plan && wishes.moments.text.empty();
  if (scene.problem != ProblemKind::pose && (planned || scene.problem != ProblemKind::execute)) {
    throw InputError("sensitivity: found problem = \"" + std::string(to_string(scene.problem)) +
                     "\", expected a scene that plans a pose");
  }
  // A key that is not there is told before anything is planned.
  for (const std::string& key : wishes.keys) {
    if (!key.starts_with("moments[")) spread_of(session.document(), scene, key);
  }
  const auto [plan, executed] = result_of(session, wishes);
  SceneSensitivity out;
  out.of = executed ? sensitivity_of(scene, session.make_obstacles(), plan)
                    : session.sensitivity(plan, wishes.held ? SensitivityKind::held : SensitivityKind::replanned);
  if (out.of.trouble.empty()) out.keys = derivatives(session, out.of, wishes.keys, plan.moments);
  return out;
}

}  // namespace tendril::app
