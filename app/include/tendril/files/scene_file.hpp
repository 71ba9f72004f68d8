#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tendril/calibrate.hpp"
#include "tendril/estimate.hpp"
#include "tendril/execute.hpp"
#include "tendril/export.hpp"
#include "tendril/problem.hpp"
#include "tendril/scene.hpp"
#include "tendril/trajectory.hpp"

/// Scene files and result files, as the command reads and writes them.
namespace tendril::files {

/// A key of a scene that is set in passing, as the command's `--set` does.
struct Setting {
  std::string key;      ///< for instance "contact.max_force" or "rod.actuator[0].limit"
  std::string value;    ///< TOML; what is no TOML is text
  bool text = false;    ///< `value` is text, whatever it looks like
  std::string shown{};  ///< how messages name the setting; empty: its key
};

/// Where a scene comes from.
struct SceneSource {
  /// Names the scene in messages and results, and is read unless there is a `text`. Files that the scene names are
  /// looked for beside it.
  std::filesystem::path file;
  std::optional<std::string> text{};  ///< TOML
  std::vector<Setting> settings{};    ///< put in one after the other
  /// Searched for plugins first; then come TENDRIL_PLUGIN_PATH and the library's own.
  std::vector<std::filesystem::path> plugin_directories{};
  /// Hands over components of the program itself, which the scene names as it names plugins. Their names must be new.
  std::function<void(Registrar&)> components{};
};

/// The scene as one TOML document with its settings put in. Its values are not looked at. Throws Error.
TENDRIL_API std::string scene_text(const SceneSource& source);

/// A result as JSON, and its name for messages.
struct ResultText {
  std::string text;             ///< one JSON document
  std::string name = "result";  ///< a file, for instance
};

/// What there is to see of a result, as the JSON document of docs/drawing.md: outlines, rods, contacts, for each step,
/// state or case. Obstacles are made anew, by components that are found as a scene's. Throws Error.
TENDRIL_API std::string drawing_json(const ResultText& result,
                                     const std::vector<std::filesystem::path>& plugin_directories = {},
                                     const std::function<void(Registrar&)>& components = {});

/// Writes what there is to see of a result, as `tendril view`: a page (.html), a picture (.svg, .png, .pdf) or a movie
/// (.gif, .mp4), by the name of `file`. Returns what is to be known of it. `stop` ends a movie. Throws Error.
TENDRIL_API std::vector<std::string> view(const ResultText& result, const std::filesystem::path& file,
                                          const std::vector<std::filesystem::path>& plugin_directories = {},
                                          const std::function<void(Registrar&)>& components = {},
                                          const std::atomic<bool>* stop = nullptr);

/// How a live page is served.
struct LiveControl {
  int port = 0;                             ///< of the loopback interface; 0: any that is free
  bool open_browser = true;                 ///< where there is a display
  const std::atomic<bool>* stop = nullptr;  ///< ends it; null: Ctrl-C does
  /// Told the address once it is open; empty: it is printed.
  std::function<void(const std::string& address)> ready{};
};

/// `tendril live`: serves a page on which the scene can be dragged, until it is ended. Components are asked by threads
/// of its own. Throws Error.
TENDRIL_API void live(const SceneSource& source, const LiveControl& control = {});

/// Where a calibration is to be written.
struct CalibrationPlaces {
  std::optional<std::filesystem::path> output{};  ///< a directory, for the result, the figure, and rod.toml
  std::optional<std::filesystem::path> figure{};  ///< file of the figure alone
};

/// The kind of `Inputs::text`.
enum class InputKind {
  none,       ///< nothing was said
  moments,    ///< N m
  pressures,  ///< Pa
  each        ///< what each actuator is told: a pressure where the scene says what moment it gives, a tension, a moment
};

/// What moves the actuators, and the rod as a whole, when a scene is executed.
struct Inputs {
  InputKind kind = InputKind::none;  ///< of the numbers in `text`
  std::string text{};                ///< one SI number or quantity with a unit for each actuator, between commas
  std::string shown{};               ///< how messages name `text`; empty: all as options of the command
  std::string insertion{};           ///< length of the rod that is out of its port; empty: as it is
  std::string base{};                ///< x, y and angle of its base, between commas; empty: as it is
};

/// What `tendril sensitivity` is asked for.
struct SensitivityWishes {
  std::vector<std::string> keys{};  ///< numbers such as obstacle[0].radius; none: all of the scene
  Inputs moments{};                 ///< carried out instead of planned ones; without text: none
  bool held = false;                ///< what the rod does under the plan's moments, instead of another plan
  /// An earlier result of this scene, which is differentiated as it is: planned, or carried out, where it is held. Of a
  /// trajectory's scene one of the steps, or the whole.
  std::optional<ResultText> plan{};
  std::optional<int> step{};  ///< of `plan`, a trajectory: which one, from 1 on
};

/// What a run starts from and what may end it.
struct Run {
  const std::atomic<bool>* stop = nullptr;  ///< set to true from outside to end the run cleanly; null: nothing does
  std::optional<ResultText> start{};        ///< an earlier result to start from
  /// Told how many steps of a trajectory are finished, and how many there are; of a plan how many programs a solver has
  /// run, and 0. By the thread that runs; must not throw. Empty: nobody is told.
  std::function<void(int finished, int total)> progress{};
};

/// A scene file opened with its plugins: what the command does with it, as objects and as JSON.
///
/// Every error that a user can repair is thrown as an Error whose message is complete: it names file, line and column,
/// or the setting. Not for concurrent use. A solver that does not return after its time limit cannot be ended from
/// within; the command ends its process.
class TENDRIL_API SceneFile {
 public:
  /// Reads, checks; opens no plugin yet but those whose options have to be told apart. Throws Error.
  explicit SceneFile(const SceneSource& source);
  SceneFile(SceneFile&&) noexcept;             ///< Leaves the other one unusable.
  SceneFile& operator=(SceneFile&&) noexcept;  ///< Leaves the other one unusable.
  ~SceneFile();

  const Scene& scene() const;  ///< What the file says, SI units.
  /// The assembled problem, made when first asked for; for loops with Problem::follow().
  Problem& problem();
  /// The scene's obstacles as execute() takes them.
  std::vector<std::unique_ptr<Obstacle>> make_obstacles();

  /// What was built for the scene, and what was left out and why. Plans nothing.
  Description describe();
  /// `tendril plan` of a pose or a grasp. `verified`: the plan is executed on a fine basis, and its verdict depends on
  /// it.
  Plan plan(const Run& run = {}, bool verified = false);
  /// `tendril plan` of a trajectory; every step from the one before, `run.start` is not used.
  Trajectory plan_trajectory(const Run& run = {}, bool verified = false);
  /// `tendril plan` of an estimate; `run.start` is not used.
  Estimate estimate(const Run& run = {});
  /// `tendril execute`: what the rod does under `inputs`.
  Execution execute(const Inputs& inputs, const Run& run = {});
  /// The same along several lists between semicolons, one after the other.
  Trajectory execute_along(const Inputs& inputs, const Run& run = {});
  /// The same under the moments of an earlier result: of a plan, or of each step of a trajectory in turn. `moved`: the
  /// rod is at its insertion and base instead, of a plan also at one after the other.
  std::variant<Execution, Trajectory> execute(const ResultText& earlier, const Run& run = {}, const Inputs& moved = {});

  /// `tendril sensitivity`, as its JSON; `run.start` is not used. Where the result has no derivatives, "trouble" says
  /// why.
  std::string sensitivity_json(const SensitivityWishes& wishes, const Run& run = {});

  /// `tendril calibrate`, without its files. Throws Error, before it begins, where write() could not write to `places`.
  Calibration calibrate(const Run& run = {}, const CalibrationPlaces& places = {});
  /// The files of a calibration. Returns why there is no figure. Throws Error.
  std::vector<std::string> write(const Calibration& calibration, const CalibrationPlaces& places);
  /// The document of docs/results.md, schema 1, as the command writes it; ends in a line feed.
  std::string json(const Plan& plan) const;
  std::string json(const Execution& execution) const;      ///< Likewise.
  std::string json(const Trajectory& trajectory) const;    ///< Likewise.
  std::string json(const Estimate& estimate) const;        ///< Likewise.
  std::string json(const Description& description) const;  ///< Likewise.
  std::string json(const Calibration& calibration) const;  ///< Likewise.
  /// The plan in such a document, as a start for this scene: shape, moments and contacts. Throws Error if it belongs to
  /// another rod.
  Plan read_plan(const ResultText& result) const;

 private:
  class Opened;
  std::unique_ptr<Opened> opened_;
};

}  // namespace tendril::files
