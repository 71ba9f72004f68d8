#include "tendril/app/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "scene/calibrated_rod.hpp"
#include "scene/error_bars.hpp"
#include "scene/plain_numbers.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"
#include "tendril/leading.hpp"

namespace tendril::app {

namespace {

/// Adds the time that it lives to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() { seconds_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& seconds_;
  Clock::time_point begin_ = Clock::now();
};

/// The plugin that the document names in a table; empty: none.
std::string plugin_in(const Document& document, const char* table) {
  const Node* node = document.root().find(table);
  if (node != nullptr) node = node->find("plugin");
  const auto* text = node != nullptr ? std::get_if<std::string>(&node->value) : nullptr;
  return text != nullptr ? *text : "";
}

bool declares(const OptionSchema& schema, std::string_view name) {
  return std::any_of(schema.begin(), schema.end(),
                     [&](const OptionSpec& spec) { return spec.name == name || spec.name == any_option; });
}

/// The file that the option of the obstacle at `path` was read from; empty: the scene says it itself.
std::string file_behind(const Document& document, const std::string& path, const std::string& option) {
  static const std::set<std::string, std::less<>> read{"vertices", "outlines", "points", "widths"};
  const Node* obstacles = path.starts_with("obstacle[") ? document.root().find("obstacle") : nullptr;
  const auto* list = obstacles != nullptr ? std::get_if<Node::List>(&obstacles->value) : nullptr;
  if (list == nullptr || !read.contains(option)) return "";
  const Node* file = (*list)[std::stoul(path.substr(path.find('[') + 1))].find("file");
  const Node* name = file != nullptr ? file->find("name") : nullptr;
  const auto* text = name != nullptr ? std::get_if<std::string>(&name->value) : nullptr;
  return text != nullptr ? *text : "";
}

}  // namespace

/// What was meant by an entry of the table at `path` that its component does not know: a key of the table itself, or of
/// a table in it, or "" where an option is nearer.
std::string Session::misspelt_key(const std::string& path, const std::string& entry) const {
  const std::string table = path.substr(0, path.find('['));
  const std::size_t number = table == path ? 0 : std::stoul(path.substr(table.size() + 1));
  const OptionSchema* schema = table == "coordinates" ? &registry_->coordinates(scene_.coordinates.plugin).options
                               : table == "obstacle"  ? &registry_->obstacle(scene_.obstacles[number].shape).options
                               : table == "objective" ? &registry_->objective(scene_.objectives[number].plugin).options
                                                      : nullptr;
  if (schema == nullptr || declares(*schema, entry)) return "";
  const Node* node = document_.root().find(table);
  if (const auto* list = node != nullptr ? std::get_if<Node::List>(&node->value) : nullptr) node = &(*list)[number];
  std::vector<std::string> own;
  for (const KeySpec& key : scene_keys()) {
    if (key.name != table) continue;
    for (const KeySpec& below : key.keys) {
      own.push_back(below.name);
      if (node == nullptr || node->find(below.name) == nullptr) continue;
      for (const KeySpec& deeper : below.keys) {
        if (deeper.name == entry) return below.name + '.' + entry;
      }
    }
  }
  std::vector<std::string> known = own;
  for (const OptionSpec& option : *schema) known.push_back(option.name);
  const std::string nearest = nearest_name(entry, known);
  return std::find(own.begin(), own.end(), nearest) != own.end() ? nearest : "";
}

/// Runs `make`; what it throws gets the place of `path` in the scene. An option stands below `path`.
template <class Make>
decltype(auto) Session::located(const std::string& path, Make&& make) const {
  try {
    return make();
  } catch (const OptionError& error) {
    if (const std::string file = file_behind(document_, path, error.option()); !file.empty()) {
      document_.fail(document_.find(path + ".file"), fmt::format("{}: {}", file, error.what()));
    }
    const SourcePosition place =
        error.position().line > 0 ? error.position() : document_.find(path + '.' + error.option());
    const std::string meant = misspelt_key(path, error.option());
    if (meant.empty()) document_.fail(place, error.what());
    document_.fail(place, fmt::format("found the key '{}', which [{}] does not have; did you mean '{}'?",
                                      error.option(), path.substr(0, path.find('[')), meant));
  } catch (const SceneError& error) {
    document_.fail(document_.find(error.path()), error.what());
  } catch (const plugins::PluginError& error) {
    // The name of the component, if the scene writes it down.
    const std::string key = path.starts_with("obstacle") ? ".shape" : ".plugin";
    document_.fail(document_.find(path + key), error.what());
  } catch (const InputError&) {
    throw;
  } catch (const Error& error) {
    document_.fail(document_.find(path), error.what());
  }
}

Document read_document(const SceneArguments& arguments) {
  if (arguments.text) require_text(*arguments.text, arguments.scene);
  Document document =
      arguments.text ? Document::parse(*arguments.text, arguments.scene.string()) : Document::read(arguments.scene);
  document.include();
  return document;
}

Session::Session(const SceneArguments& arguments) : units_(std::make_shared<Units>()) {
  {
    const Stopwatch watch(seconds_read_);
    document_ = read_document(arguments);
    const std::string coordinates = plugin_in(document_, "coordinates");
    const std::string solver = plugin_in(document_, "solver");
    document_.apply(arguments.overrides);
    const bool other_coordinates = plugin_in(document_, "coordinates") != coordinates;
    const bool other_solver = plugin_in(document_, "solver") != solver;
    scene_ = read_scene(document_, units_);
    dropped_ = scene_.left_out;
    located("", [&] { validate(scene_); });
    scene_.spreads = error_bars(document_, scene_);
    {
      const Stopwatch open(seconds_open_);
      registry_ = std::make_unique<plugins::Registry>(
          plugins::Catalog(plugins::search_places(arguments.plugin_directories)), arguments.components);
      // An estimate opens no plugin, so nobody knows which options are foreign.
      if (scene_.problem != ProblemKind::estimate) {
        drop_foreign_options(other_coordinates, other_solver);
        ask_about_shapes();
      }
    }
  }
  seconds_read_ -= seconds_open_;
}

Session::~Session() = default;

void Session::ask_about_shapes() {
  const Node* tables = document_.root().find("obstacle");
  if (tables == nullptr || !needs_obstacles(scene_)) return;
  for (std::size_t i = 0; i < scene_.obstacles.size(); ++i) {
    const std::string path = fmt::format("obstacle[{}]", i);
    const OptionSchema& schema = located(
                                     path, [&]() -> auto& { return registry_->obstacle(scene_.obstacles[i].shape); })
                                     .options;
    for (std::string& question : doubtful_numbers(document_, scene_, schema, std::get<Node::List>(tables->value)[i])) {
      scene_.warnings.push_back(std::move(question));
    }
  }
}

void Session::drop_foreign_options(bool other_coordinates, bool other_solver) {
  const auto drop = [&](RawOptions& options, const OptionSchema& schema, const std::string& table,
                        const std::string& owner) {
    for (auto option = options.begin(); option != options.end();) {
      // What the command line itself asks for is never dropped: its position has no line.
      if (option->second.position.line > 0 && !declares(schema, option->first)) {
        dropped_.push_back({fmt::format("option {}.{} of the scene", table, option->first),
                            fmt::format("{} has no such option", owner)});
        option = options.erase(option);
      } else {
        ++option;
      }
    }
  };
  if (other_coordinates) {
    const OptionSchema& schema =
        located(
            "coordinates", [&]() -> auto& { return registry_->coordinates(scene_.coordinates.plugin); })
            .options;
    drop(scene_.coordinates.options, schema, "coordinates", "coordinates plugin '" + scene_.coordinates.plugin + "'");
  }
  if (other_solver) {
    const OptionSchema& schema = located(
                                     "solver", [&]() -> auto& { return registry_->solver(scene_.solver.plugin); })
                                     .options;
    drop(scene_.solver.options, schema, "solver.options", "solver plugin '" + scene_.solver.plugin + "'");
  }
}

std::vector<std::unique_ptr<Obstacle>> Session::make_obstacles() {
  return plugins::make_obstacles(*registry_, scene_, place());
}

std::vector<std::unique_ptr<Obstacle>> Session::make_obstacles(const TargetSpec& step) {
  return plugins::make_obstacles(*registry_, with_obstacles(scene_, step), place());
}

Components Session::make_components() { return plugins::make_components(*registry_, scene_, place()); }

plugins::Located Session::place() const {
  return [this](const std::string& path, const std::function<void()>& step) { located(path, step); };
}

Problem& Session::problem() {
  if (problem_) return *problem_;
  Components components;
  {
    const Stopwatch open(seconds_open_);
    components = make_components();
  }
  located("", [&] { problem_.emplace(scene_, std::move(components)); });
  return *problem_;
}

Description Session::describe() {
  if (scene_.problem != ProblemKind::estimate) return problem().describe();
  return located("", [&] { return describe_estimate(scene_); });
}

const std::atomic<bool>& Session::stop() const { return stop_ != nullptr ? *stop_ : InterruptGuard::flag(); }

std::unique_ptr<InterruptGuard> Session::guarded() const {
  return stop_ != nullptr ? nullptr : std::make_unique<InterruptGuard>();
}

Estimate Session::estimate() {
  const auto guard = guarded();
  PlanControl control;
  control.stop = &stop();
  Estimate estimate = located("", [&] { return tendril::estimate(scene_, control); });
  estimate.left_out.insert(estimate.left_out.end(), dropped_.begin(), dropped_.end());
  return estimate;
}

Calibration Session::calibrate() {
  const auto known = static_cast<std::ptrdiff_t>(scene_.warnings.size());
  const CalibrationSpec spec = read_calibration(document_, *units_, scene_);
  const auto guard = guarded();
  PlanControl control;
  control.stop = &stop();
  Calibration result = located("", [&] { return tendril::calibrate(scene_, spec, control); });
  // What is to be asked about the files comes first.
  result.warnings.insert(result.warnings.begin(), scene_.warnings.begin() + known, scene_.warnings.end());
  return result;
}

std::string Session::calibrated_rod(const Calibration& calibration) const {
  return app::calibrated_rod(document_, *units_, calibration);
}

Plan Session::plan(const std::optional<Plan>& start) {
  problem();
  const auto guard = guarded();
  Plan plan = plan_from(start ? &*start : nullptr);
  uncertainties_.clear();
  find_uncertainty(plan, false);
  plan.left_out.insert(plan.left_out.end(), dropped_.begin(), dropped_.end());
  return plan;
}

Plan Session::plan_from(const Plan* start, bool follow, const std::vector<std::string>& without) {
  Problem& ready = problem();
  PlanControl control;
  control.stop = &stop();
  control.start = start;
  control.follow = follow;
  control.without = without;
  if (progress_) control.progress = [this, runs = 0]() mutable { progress_(++runs, 0); };
  constexpr double grace = 2.0;
  std::optional<Watchdog> watchdog;
  if (stop_ == nullptr) {
    watchdog.emplace(std::chrono::duration<double>(scene_.solver.time_limit + grace),
                     fmt::format("tendril: solver '{}' did not return within {} s after the time limit of {} s; no "
                                 "result was written",
                                 scene_.solver.plugin, grace, scene_.solver.time_limit));
  }
  return located("", [&] { return ready.plan(control); });
}

void Session::move_obstacles(const TargetSpec& step) {
  if (step.obstacles.empty()) return;
  scene_ = with_obstacles(std::move(scene_), step);
  problem_.reset();
}

Trajectory Session::plan_trajectory() {
  problem();
  const auto guard = guarded();
  const std::vector<ObstacleSpec> still = scene_.obstacles;
  // Steps are what is told of, not the programs of each.
  const TrajectoryOptions options{scene_.trajectory.replan_every, scene_.trajectory.cold_starts,
                                  std::exchange(progress_, nullptr)};
  Trajectory trajectory = tendril::plan_trajectory(scene_.trajectory.targets, options,
                                                   [this](const TargetSpec& target, const Plan* start, bool follow) {
                                                     move_obstacles(target);
                                                     problem().set_target(target);
                                                     return plan_from(start, follow);
                                                   });
  uncertainties_.clear();
  for (const TrajectoryStep& step : trajectory.steps) {
    if (!scene_.spreads.empty()) move_obstacles(step.target);
    find_uncertainty(step.plan, false);
  }
  if (std::any_of(trajectory.steps.begin(), trajectory.steps.end(),
                  [](const TrajectoryStep& step) { return !step.target.obstacles.empty(); })) {
    scene_.obstacles = still;
    problem_.reset();
  }
  return trajectory;
}

Sensitivity Session::sensitivity(const Plan& plan, SensitivityKind kind) {
  return located("", [&] { return problem().sensitivity(plan, kind); });
}

void Session::find_uncertainty(const Plan& plan, bool executed) {
  if (scene_.spreads.empty()) return;
  std::vector<Spread> spreads = scene_.spreads;
  std::vector<std::string> keys;
  for (Spread& spread : spreads) {
    follow_held_inputs(scene_, plan.moments, spread);
    for (const Spread::Part& part : spread.parts) {
      // The offset of a tendon is no number of the program: uncertainty_of() says that it has no column.
      if (part.key != spread.key || !part.key.ends_with("offset")) keys.push_back(part.key);
    }
  }
  const Sensitivity sensitivity = located("", [&] {
    return executed ? sensitivity_of(scene_, make_obstacles(), plan, keys)
                    : problem().sensitivity(plan, SensitivityKind::held, keys);
  });
  uncertainties_.push_back(uncertainty_of(sensitivity, spreads));
}

void Session::use(const Scene& scene) {
  scene_ = scene;
  problem_.reset();
  located("", [&] { validate(scene_); });
}

Execution Session::execute(const std::vector<double>& held, const std::optional<Plan>& start,
                           std::optional<double> palm_distance, const RodPlace& place, const RodPlace& lower_place) {
  const bool grasp = scene_.problem == ProblemKind::grasp;
  if (grasp && !palm_distance) palm_distance = scene_.gripper->palm_distance;
  if (grasp && !palm_distance) {
    document_.fail(document_.find("gripper"),
                   "the object's place is not known, expected 'palm_distance' in [gripper], or a result for --plan");
  }
  const auto guard = guarded();
  ExecuteControl control = execute_control(start);
  control.place = place;
  control.lower_place = lower_place;
  Execution done;
  if (plans_both_fingers(scene_)) {
    done = located("", [&] { return execute_both_fingers(scene_, *palm_distance, held, control); });
  } else {
    const std::vector<std::unique_ptr<Obstacle>> obstacles =
        grasp ? obstacles_of_finger(scene_, *palm_distance) : make_obstacles();
    const Scene executed = grasp ? finger_in_world(scene_) : scene_;
    done = located("", [&] { return tendril::execute(executed, obstacles, held, control); });
    if (grasp && !done.result.backbone.empty())
      done.result.grasp = grasp_of(scene_, *palm_distance, done.result.contacts);
  }
  done.result.left_out.insert(done.result.left_out.end(), dropped_.begin(), dropped_.end());
  uncertainties_.clear();
  find_uncertainty(done.result, true);
  return done;
}

std::optional<Execution> Session::verify(Plan& plan, const std::optional<Plan>& start) {
  if (plan.backbone.empty()) {
    plan.verification = "not executed: the plan came to no shape";
    return std::nullopt;
  }
  const auto guard = guarded();
  if (plan.grasp) return verify_grasp(plan, start);
  const std::vector<std::unique_ptr<Obstacle>> obstacles = make_obstacles();
  const ExecuteControl control = execute_control(start);
  return located("", [&] { return tendril::verify(scene_, obstacles, plan, control); });
}

void Session::verify(Trajectory& trajectory) {
  const auto guard = guarded();
  const ObstaclesAt obstacles = [this](const TargetSpec& step) { return make_obstacles(step); };
  located("", [&] { tendril::verify(scene_, obstacles, trajectory, execute_control(std::nullopt)); });
}

Trajectory Session::execute(const std::vector<TrajectoryStep>& steps, const std::optional<Plan>& start) {
  std::optional<Plan> state = start;
  const auto guard = guarded();
  Trajectory done;
  uncertainties_.clear();
  for (const TrajectoryStep& step : steps) {
    const std::vector<std::unique_ptr<Obstacle>> obstacles = make_obstacles(step.target);
    TrajectoryStep& reached = done.steps.emplace_back();
    reached.target = step.target;
    reached.method = StepMethod::executed;
    Scene aimed = scene_;
    aimed.problem = ProblemKind::pose;
    aimed.trajectory = {};
    aimed.target = step.target;
    ExecuteControl control = execute_control(state);
    control.place = step.plan.place;
    std::optional<Led> led;
    if (done.steps.size() > 1) {
      const ObstaclesAt at = [this](const TargetSpec& where) { return make_obstacles(where); };
      led = located("", [&] { return led_near(aimed, at, (&reached - 1)->target, *state, step, control); });
    }
    if (led) control.start = &led->at;
    Execution rest = located("", [&] { return tendril::execute(aimed, obstacles, step.plan, control); });
    reached.snaps = snaps_of(led, rest);
    reached.plan = std::move(rest.result);
    done.interrupted = stop().load();
    if (done.interrupted || reached.plan.backbone.empty()) break;
    find_uncertainty(reached.plan, true);
    state = reached.plan;
  }
  return done;
}

Execution Session::verify_grasp(Plan& plan, const std::optional<Plan>& earlier) {
  const auto settle = [&](Plan& judged) {
    ExecuteControl control = execute_control(earlier);
    if (!earlier) control.start = &judged;
    if (judged.grasp->lower) return located("", [&] { return verify_both_fingers(scene_, judged, control); });
    const Scene finger = finger_in_world(scene_);
    const std::vector<std::unique_ptr<Obstacle>> obstacles = obstacles_of_finger(scene_, judged.grasp->palm_distance);
    return located("", [&] { return tendril::verify(finger, obstacles, judged, control); });
  };
  const bool planned = plan.status == PlanStatus::solved;
  Execution reached = settle(plan);
  std::vector<std::string> refuted;
  for (Plan last = plan; planned && last.status != PlanStatus::solved;) {
    const auto won = std::find_if(last.modes.begin(), last.modes.end(), [&](const ModeRecord& mode) {
      return mode.certified && mode.objective == last.objective;
    });
    if (won == last.modes.end()) break;
    refuted.push_back(won->mode);
    Plan next = plan_from(nullptr, false, refuted);
    if (next.status != PlanStatus::solved) break;
    Execution executed = settle(next);
    for (const std::string& mode : refuted) {
      next.left_out.push_back({mode, "a plan was certified, but the finger does not come to rest there"});
    }
    if (next.status == PlanStatus::solved) {
      plan = next;
      reached = std::move(executed);
    }
    last = std::move(next);
  }
  return reached;
}

/// `earlier` has to outlive what is returned.
ExecuteControl Session::execute_control(const std::optional<Plan>& earlier) const {
  ExecuteControl control;
  control.stop = &stop();
  control.start = earlier ? &*earlier : nullptr;
  control.time_limit = scene_.solver.time_limit;
  return control;
}

RunInfo Session::run_info() const {
  RunInfo run;
  for (const plugins::Registry::Opened& opened : registry_->opened()) {
    run.components.push_back({std::string(to_string(opened.kind)), opened.name, opened.file.string()});
  }
  run.seconds_read = seconds_read_;
  run.seconds_open = seconds_open_;
  run.uncertainties = uncertainties_;
  return run;
}

}  // namespace tendril::app
