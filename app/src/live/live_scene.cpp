#include "live/live_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "figure/drawing.hpp"
#include "figure/gnuplot.hpp"
#include "result/grasp_result.hpp"
#include "result/trajectory_result.hpp"
#include "session/inputs.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

std::string action_of(const Json& request) {
  const auto action = request.find("action");
  if (action == request.end() || !action->is_string()) throw InputError("action: expected plan, follow or execute");
  std::string word = action->get<std::string>();
  if (word != "plan" && word != "follow" && word != "execute") {
    throw InputError("action: expected plan, follow or execute");
  }
  return word;
}

/// What moves the actuators, SI, each in what it is told, as the command takes it. None where the page does not know
/// yet what that is: nothing moves.
std::string inputs_of(const Json& request, std::size_t actuators) {
  const auto values = request.find("inputs");
  std::string text;
  if (values == request.end()) {
    for (std::size_t a = 0; a < actuators; ++a) text += a > 0 ? ", 0" : "0";
    return text;
  }
  if (!values->is_array() || values->size() > 1000) throw InputError("inputs: expected a list of numbers");
  for (const Json& value : *values) {
    if (!value.is_number()) throw InputError("inputs: expected a list of numbers");
    text += fmt::format("{}{}", text.empty() ? "" : ", ", value.get<double>());
  }
  return text;
}

/// The line of the scene's file that a message begins with, as "scene.toml:21:1: ..."; 0: none.
int line_of(const std::string& message, const std::string& file) {
  if (!message.starts_with(file + ':')) return 0;
  int line = 0;
  std::from_chars(message.data() + file.size() + 1, message.data() + message.size(), line);
  return line;
}

/// What the page shows of a message, and the control that it belongs to: the one that it begins with, or that stands at
/// its line, or the first one of the table there.
Json refused(const std::string& message, const std::vector<Control>& controls, const std::string& file) {
  const int line = line_of(message, file);
  const auto first = [&](auto&& belongs) {
    const auto found = std::find_if(controls.begin(), controls.end(), belongs);
    return found != controls.end() ? &*found : nullptr;
  };
  const Control* at = first([&](const Control& c) { return message.starts_with(c.key + ':'); });
  if (at == nullptr && line > 0) at = first([&](const Control& c) { return c.line == line; });
  if (at == nullptr && line > 0) at = first([&](const Control& c) { return c.table == line; });
  Json body{{"error", message}};
  if (at != nullptr) body["key"] = at->key;
  return body;
}

Json drawing_without_shape(const Scene& scene) {
  const double length = scene.rod.segments.empty() ? 1.0 : scene.rod.length();
  const LengthUnit unit = unit_for(length);
  Json frame{{"label", ""}, {"rods", Json::array()}, {"contacts", Json::array()}, {"numbers", Json::array()}};
  return {{"drawing", 2},
          {"title", scene.title},
          {"problem", to_string(scene.problem)},
          {"length", length},
          {"length_unit", {{"name", unit.name}, {"size", unit.size}}},
          {"obstacles", Json::array()},
          {"frames", Json::array({frame})},
          {"notes", Json::array()}};
}

}  // namespace

LiveScene::LiveScene(const SceneArguments& arguments) : arguments_(arguments) {
  // Read once: the page shows this scene even if the file changes meanwhile.
  if (!arguments_.text) arguments_.text = read_scene_input(arguments.scene);
  Session session(arguments_);
  const Scene& scene = session.scene();
  if (scene.problem == ProblemKind::estimate) {
    throw InputError(scene.file +
                     ": an estimate is made of measured points, so there is nothing to drag; expected another problem");
  }
  if (scene.problem != ProblemKind::execute) session.describe();
  file_ = scene.file;
  controls_ = controls_of(session);
  beginning_ = {{"controls", controls_json(controls_)},
                {"plans", scene.problem != ProblemKind::execute},
                {"follows", scene.problem == ProblemKind::pose},
                {"drawing", drawing_without_shape(scene)}};
}

SceneArguments LiveScene::arguments_with(const Json& request) const {
  SceneArguments arguments = arguments_;
  const auto settings = request.is_object() ? request.find("settings") : request.end();
  if (!request.is_object() || settings == request.end()) throw InputError("expected an object with settings");
  for (Override& setting : overrides_of(controls_, *settings)) arguments.overrides.push_back(std::move(setting));
  return arguments;
}

LiveAnswer LiveScene::run(const Json& request) {
  const std::int64_t mine = ++newest_;
  stop_ = true;
  const std::lock_guard lock(running_);
  stop_ = ended_.load();
  LiveAnswer late{409, {{"error", "something newer was asked for"}}};
  // One that came since then has set the flag, which was just taken back.
  if (newest_ != mine || ended_) return late;
  try {
    Session session(arguments_with(request));
    session.stop_by(stop_);
    Made made = make(session, request);
    if (newest_ != mine) return late;
    result_number_ = mine;
    result_ = std::move(made.result);
    if (made.plan) last_ = std::move(made.plan);
    made.body["number"] = mine;
    return {200, std::move(made.body)};
  } catch (const Error& error) {
    return newest_ != mine ? late : LiveAnswer{400, refused(error.what(), controls_, file_)};
  }
}

LiveScene::Made LiveScene::make(Session& session, const Json& request) const {
  const std::string action = action_of(request);
  const auto begin = std::chrono::steady_clock::now();
  const Scene& scene = session.scene();
  Made made;
  if (action == "execute") {
    std::optional<double> palm_distance;
    RodPlace upper;
    RodPlace lower;
    if (last_ && last_->grasp) {
      palm_distance = last_->grasp->palm_distance;
      upper = last_->place;
      lower = lower_place_of(*last_);
    }
    const Inputs inputs{InputKind::each, inputs_of(request, actuators_of(scene).size()), "inputs"};
    const Execution execution = session.execute(moments_of(inputs, session), std::nullopt, palm_distance, upper, lower);
    made.result = execution_result(scene, execution, session.run_info());
  } else if (scene.problem == ProblemKind::trajectory) {
    const Trajectory trajectory = session.plan_trajectory();
    made.result = Json::parse(trajectory_json(scene, trajectory, session.run_info()));
  } else {
    const bool follow = action == "follow" && last_ && last_->status == PlanStatus::solved;
    made.plan = follow ? session.plan_from(&*last_, true) : session.plan(std::nullopt);
    made.result = plan_result(scene, *made.plan, session.run_info());
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  made.body = {{"drawing", drawing_of(made.result, "the result", session.registry())}, {"seconds", seconds}};
  for (const char* key : {"modes", "inputs"}) {
    if (made.result.contains(key)) made.body[key] = made.result[key];
  }
  Json left_out = Json::array();
  for (const LeftOut& item : session.dropped()) left_out.push_back(item.what + ": " + item.why);
  made.body["dropped"] = std::move(left_out);
  return made;
}

LiveAnswer LiveScene::scene_text(const Json& request) const {
  try {
    const SceneArguments arguments = arguments_with(request);
    Document document = read_document(arguments);
    document.apply(arguments.overrides);
    return {200, {{"text", text_of(document)}}};
  } catch (const Error& error) {
    return {400, refused(error.what(), controls_, file_)};
  }
}

LiveAnswer LiveScene::result_text(const Json& request) {
  const std::lock_guard lock(running_);
  const auto asked = request.is_object() ? request.find("number") : request.end();
  const bool same = request.is_object() && asked != request.end() && asked->is_number_integer() &&
                    asked->get<std::int64_t>() == result_number_ && result_number_ > 0;
  if (!same) return {409, {{"error", "this result was replaced by a newer one"}}};
  return {200, {{"text", written(result_)}}};
}

void LiveScene::end() {
  ended_ = true;
  stop_ = true;
}

}  // namespace tendril::app
