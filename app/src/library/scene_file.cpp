#include "tendril/files/scene_file.hpp"

#include <utility>

#include "command/calibrate_command.hpp"
#include "command/result_files.hpp"
#include "figure/drawing.hpp"
#include "library/arguments.hpp"
#include "live/live.hpp"
#include "result/calibration_report.hpp"
#include "result/estimate_report.hpp"
#include "result/json_reader.hpp"
#include "result/trajectory_result.hpp"
#include "session/inputs.hpp"
#include "session/sensitivities.hpp"
#include "session/sequence.hpp"

namespace tendril::files {

app::SceneArguments arguments_of(const SceneSource& source) {
  app::SceneArguments arguments{source.file, {}, source.plugin_directories, source.text, source.components};
  arguments.overrides.reserve(source.settings.size());
  for (const Setting& setting : source.settings) {
    const std::string& shown = setting.shown.empty() ? setting.key : setting.shown;
    arguments.overrides.push_back({shown, setting.key, setting.value, setting.text});
  }
  return arguments;
}

std::string scene_text(const SceneSource& source) {
  const app::SceneArguments arguments = arguments_of(source);
  app::Document document = app::read_document(arguments);
  document.apply(arguments.overrides);
  return app::text_of(document);
}

std::string drawing_json(const ResultText& result, const std::vector<std::filesystem::path>& plugin_directories,
                         const std::function<void(Registrar&)>& components) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places(plugin_directories)), components);
  return app::drawing_of(app::parse_result(result.text, result.name, "result"), result.name, registry).dump();
}

std::vector<std::string> view(const ResultText& result, const std::filesystem::path& file,
                              const std::vector<std::filesystem::path>& plugin_directories,
                              const std::function<void(Registrar&)>& components, const std::atomic<bool>* stop) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places(plugin_directories)), components);
  return app::write_view(result, file, registry, &stop_of(stop));
}

void live(const SceneSource& source, const LiveControl& control) { app::run_live({arguments_of(source), control}); }

class SceneFile::Opened {
 public:
  explicit Opened(const SceneSource& source) : session(arguments_of(source)) { session.stop_by(stop_of(nullptr)); }

  /// Lets `run` end what is done from now on, and hear of it.
  void begin(const Run& run) {
    session.stop_by(stop_of(run.stop));
    session.tell(run.progress);
  }
  std::optional<Plan> start_of(const Run& run) const {
    if (!run.start) return std::nullopt;
    return app::parse_start(run.start->text, run.start->name, session.scene());
  }

  app::Session session;
};

SceneFile::SceneFile(const SceneSource& source) : opened_(std::make_unique<Opened>(source)) {}
SceneFile::SceneFile(SceneFile&&) noexcept = default;
SceneFile& SceneFile::operator=(SceneFile&&) noexcept = default;
SceneFile::~SceneFile() = default;

const Scene& SceneFile::scene() const { return opened_->session.scene(); }
Problem& SceneFile::problem() { return opened_->session.problem(); }
std::vector<std::unique_ptr<Obstacle>> SceneFile::make_obstacles() { return opened_->session.make_obstacles(); }
Description SceneFile::describe() { return opened_->session.describe(); }

Plan SceneFile::plan(const Run& run, bool verified) {
  opened_->begin(run);
  const std::optional<Plan> start = opened_->start_of(run);
  Plan plan = opened_->session.plan(start);
  if (verified) opened_->session.verify(plan, start);
  return plan;
}

Trajectory SceneFile::plan_trajectory(const Run& run, bool verified) {
  opened_->begin(run);
  Trajectory trajectory = opened_->session.plan_trajectory();
  if (verified) opened_->session.verify(trajectory);
  return trajectory;
}

Estimate SceneFile::estimate(const Run& run) {
  opened_->begin(run);
  if (app::sequence_of(opened_->session)) {
    throw Error("the scene has a sequence of shapes, expected estimate_json() or estimate_sequence() for it");
  }
  return opened_->session.estimate();
}

std::string SceneFile::sensitivity_json(const SensitivityWishes& wishes, const Run& run) {
  opened_->begin(run);
  const app::SceneSensitivity found = app::sensitivities_of(opened_->session, wishes);
  return app::sensitivity_json(scene(), found.of, found.keys);
}

std::vector<std::string> SceneFile::write(const Calibration& calibration, const CalibrationPlaces& places) {
  return app::write_calibration(opened_->session, calibration, {places.output, places.figure, {}, false});
}

Calibration SceneFile::calibrate(const Run& run, const CalibrationPlaces& places) {
  app::try_places({places.output, places.figure, {}, false});
  opened_->begin(run);
  return opened_->session.calibrate();
}

Execution SceneFile::execute(const Inputs& inputs, const Run& run) {
  opened_->begin(run);
  const std::optional<Plan> start = opened_->start_of(run);
  const Plan held = app::held_of(inputs, opened_->session, start);
  return opened_->session.execute(held.moments, start, std::nullopt, held.place);
}

Trajectory SceneFile::execute_along(const Inputs& inputs, const Run& run) {
  opened_->begin(run);
  const std::optional<Plan> start = opened_->start_of(run);
  return opened_->session.execute(app::way_points_of(inputs, opened_->session, start), start);
}

std::variant<Execution, Trajectory> SceneFile::execute(const ResultText& earlier, const Run& run, const Inputs& moved) {
  opened_->begin(run);
  return app::execute_result(opened_->session, earlier, opened_->start_of(run), moved);
}

std::string SceneFile::json(const Plan& plan) const {
  return app::plan_json(scene(), plan, opened_->session.run_info());
}
std::string SceneFile::json(const Execution& execution) const {
  return app::execution_json(scene(), execution, opened_->session.run_info());
}
std::string SceneFile::json(const Trajectory& trajectory) const {
  return app::trajectory_json(scene(), trajectory, opened_->session.run_info());
}
std::string SceneFile::json(const Estimate& estimate) const {
  return app::estimate_json(scene(), estimate, opened_->session.run_info());
}
std::string SceneFile::json(const Calibration& calibration) const {
  return app::calibration_json(scene(), calibration, opened_->session.run_info());
}
std::string SceneFile::json(const Description& description) const {
  return app::description_json(scene(), description, opened_->session.run_info());
}

Plan SceneFile::read_plan(const ResultText& result) const {
  return app::parse_start(result.text, result.name, scene(), "plan");
}

}  // namespace tendril::files
