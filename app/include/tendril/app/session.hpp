#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tendril/app/document.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/result.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/app/study.hpp"
#include "tendril/app/units.hpp"
#include "tendril/calibrate.hpp"
#include "tendril/estimate.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/problem.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::app {

/// What the command line says about a scene.
struct SceneArguments {
  std::filesystem::path scene;
  std::vector<Override> overrides;
  std::vector<std::filesystem::path> plugin_directories;
  std::optional<std::string> text{};      ///< of the scene, which `scene` then only names
  plugins::ComponentSource components{};  ///< that the program brings along
};

/// The scene file, or the text that stands for it; what the command line says is not put in yet.
Document read_document(const SceneArguments& arguments);

/// One scene on its way to a plan: read, checked, its components made.
///
/// Every error that a user can repair leaves as an InputError with the place in the scene file.
class Session {
 public:
  explicit Session(const SceneArguments& arguments);
  ~Session();

  /// Runs are ended by `stop` from now on. Else by Ctrl-C (a second one kills), and a watchdog ends the process with
  /// exit code 1 where a solver does not return within two seconds after the time limit.
  void stop_by(const std::atomic<bool>& stop) { stop_ = &stop; }
  /// As files::Run::progress, from now on.
  void tell(std::function<void(int finished, int total)> progress) { progress_ = std::move(progress); }

  const Scene& scene() const { return scene_; }
  const Document& document() const { return document_; }
  /// Assembles the problem; once.
  Problem& problem();
  /// The assembled program, or what an estimate would solve.
  Description describe();
  /// Estimates contacts until the time limit. No plugin is opened.
  Estimate estimate();
  /// Calibrates the rod by the shapes that the scene names, until the time limit. No plugin is opened.
  Calibration calibrate();
  /// The scene's [rod] as calibrated, as TOML.
  std::string calibrated_rod(const Calibration& calibration) const;
  /// Plans until a certified plan or the time limit, from an earlier result or from the scene's start. Options of the
  /// scene that were dropped are added to the plan's left_out.
  Plan plan(const std::optional<Plan>& start);
  /// What the rod does under `moments` (N m, one per actuator; of the upper finger, then of the lower one, where both
  /// are planned), from an earlier result or from the scene's start. `palm_distance`: m, where a grasp holds its
  /// object; null: where the scene fixes it.
  /// `place`, `lower_place`: where the rods are moved to, as in ExecuteControl.
  Execution execute(const std::vector<double>& moments, const std::optional<Plan>& start,
                    std::optional<double> palm_distance = std::nullopt, const RodPlace& place = {},
                    const RodPlace& lower_place = {});
  /// Executes the plan and judges it by what comes of it (core's verify()). A grasp is settled from its own shape,
  /// since the way to it is not planned, and where that fails the next best way of being in contact takes its place.
  /// What was executed, for the plan as it is left; null: it came to no shape.
  std::optional<Execution> verify(Plan& plan, const std::optional<Plan>& start);
  /// Every step from the one before.
  void verify(Trajectory& trajectory);
  const Units& units() const { return *units_; }
  /// The moments and places of an earlier trajectory's steps, each carried out from where the one before came to rest.
  Trajectory execute(const std::vector<TrajectoryStep>& steps, const std::optional<Plan>& start);
  /// The same for a trajectory, step by step; the limits hold for each plan.
  Trajectory plan_trajectory();
  /// The sweeps that the scene declares.
  StudySpec study() const { return read_study(document_, *units_); }
  /// Another scene that differs from the one in the file in plain values only: checked, and assembled when asked for.
  void use(const Scene& scene);
  /// Plans once, from `start` if not null. `without`: ways of being in contact that are not tried.
  Plan plan_from(const Plan* start, bool follow = false, const std::vector<std::string>& without = {});
  /// The scene's obstacles, made once more: the planner owns its own.
  std::vector<std::unique_ptr<Obstacle>> make_obstacles();
  /// Those that move where a step of a trajectory has them.
  std::vector<std::unique_ptr<Obstacle>> make_obstacles(const TargetSpec& step);

  /// What the scene's components come from.
  plugins::Registry& registry() { return *registry_; }
  /// Options of the scene that the plugin named by the command does not know.
  const std::vector<LeftOut>& dropped() const { return dropped_; }
  /// How a plan of this scene follows its numbers; none that an execution came to.
  Sensitivity sensitivity(const Plan& plan, SensitivityKind kind);
  RunInfo run_info() const;

 private:
  /// What the scene's error bars make of plans, or of what executions came to, where it has any: for run_info().
  void find_uncertainty(const Plan& plan, bool executed);
  /// From now on obstacles are where a step of a trajectory has them.
  void move_obstacles(const TargetSpec& step);
  Execution verify_grasp(Plan& plan, const std::optional<Plan>& earlier);
  ExecuteControl execute_control(const std::optional<Plan>& earlier) const;
  /// What ends a run, and the guard that lets Ctrl-C do it where nobody else says what does.
  const std::atomic<bool>& stop() const;
  std::unique_ptr<InterruptGuard> guarded() const;
  /// Of tables whose plugin the command replaces.
  void drop_foreign_options(bool other_coordinates, bool other_solver);
  /// Numbers of obstacles that the user may not have meant become warnings of the scene.
  void ask_about_shapes();
  Components make_components();
  plugins::Located place() const;
  template <class Make>
  decltype(auto) located(const std::string& path, Make&& make) const;
  std::string misspelt_key(const std::string& path, const std::string& entry) const;

  Document document_;
  std::shared_ptr<const Units> units_;
  std::unique_ptr<plugins::Registry> registry_;
  Scene scene_;
  std::vector<LeftOut> dropped_;
  std::optional<Problem> problem_;
  const std::atomic<bool>* stop_ = nullptr;
  std::function<void(int finished, int total)> progress_;
  std::vector<Uncertainty> uncertainties_;
  double seconds_read_ = 0.0;
  double seconds_open_ = 0.0;
};

}  // namespace tendril::app
