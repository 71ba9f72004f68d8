#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// The scenes of the bench, written as users write theirs. None names coordinates or a solver: what `tendril plan`
/// takes by default is what they are planned with, unless a comparison puts something else there.

/// A scene from text. `name` stands for the file in messages. Where the default solver is not there, the first that is
/// found takes its place.
Scene scene_from_text(const std::string& text, const std::string& name, const plugins::Registry& registry);

/// A scene from a file, with settings KEY=VALUE as `--set` of the commands takes them. Throws Error or InputError.
Scene scene_from_file(const std::string& file, const std::vector<std::string>& settings);

/// A scene whose solution is known: the moment is at its limit, so every model is put to the same moment.
struct KnownScene {
  std::string name;
  Scene scene;
  double moment = 0.0;  ///< N m, for which the exact values hold
  /// Exact values (boundary-value problem, tests/reference/data): tip in m, then arc length (m) and force (N) of the
  /// contact if there is one.
  Vec2 tip{};
  std::optional<double> arc_length, force;
  double digits = 0.0;  ///< error of the table's last digit, in units of the rod's length
};
std::vector<KnownScene> known_scenes(const plugins::Registry& registry);

/// A scene with the targets that solvers are compared on.
struct BenchScene {
  std::string name;
  Scene scene;
  std::vector<TargetSpec> targets;  ///< empty: the scene's own
};
/// The programs of a scene file: of a trajectory one per step, of a study one scene per combination of its sweeps but
/// the targets. Throws as scene_from_file() does, and for a scene that no solver plugin is asked for, or whose programs
/// differ in something that is not planned.
std::vector<BenchScene> scenes_from_file(const std::string& file, const std::vector<std::string>& settings);
/// The scene with one of its targets; the first where there are none of its own.
Scene with_target(const BenchScene& bench, std::size_t target);
/// From no obstacle to several contacts; `side` targets in x and in y.
std::vector<BenchScene> bench_scenes(const plugins::Registry& registry, int side);

/// Parts of a scene, to put together others: the arm with gravity and its objectives, and a peg under it.
std::string arm(const std::string& limit);
std::string gravity();
std::string peg();
std::string objectives();

/// The grid of `side` x `side` points from `low` to `high`, in m.
std::vector<Vec2> grid(Vec2 low, Vec2 high, int side);

}  // namespace tendril::bench
