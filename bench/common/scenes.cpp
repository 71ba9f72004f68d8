#include "common/scenes.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>

#include "tendril/app/document.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/app/study.hpp"
#include "tendril/numbers.hpp"
#include "tendril/problem.hpp"

namespace tendril::bench {

Scene scene_from_text(const std::string& text, const std::string& name, const plugins::Registry& registry) {
  Scene scene = app::read_scene(app::Document::parse(text, "scene '" + name + "'"), std::make_shared<app::Units>());
  const std::vector<std::string> solvers = registry.names(ComponentKind::solver);
  if (solvers.empty()) throw Error("no solver was found, expected at least one: see `tendril plugins`");
  if (std::find(solvers.begin(), solvers.end(), scene.solver.plugin) == solvers.end()) {
    scene.solver.plugin = solvers.front();
  }
  validate(scene);
  return scene;
}

namespace {

app::Document document_of(const std::string& file, const std::vector<std::string>& settings) {
  app::Document document = app::Document::read(file);
  std::vector<app::Override> overrides;
  for (const std::string& text : settings) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) throw Error("--set " + text + ": expected KEY=VALUE");
    overrides.push_back({"--set " + text, text.substr(0, equals), text.substr(equals + 1)});
  }
  document.apply(overrides);
  return document;
}

Scene scene_of_document(const app::Document& document, const std::shared_ptr<const app::Units>& units) {
  Scene scene = app::read_scene(document, units);
  validate(scene);
  return scene;
}

/// What distinguishes a case of a study, but its target.
std::string case_name(const app::StudyCase& one) {
  std::string name;
  const auto add = [&](const std::string& part) { name += ", " + part; };
  if (one.mode)
    add(std::string(
        app::to_string(one.mode == app::StudyMode::ignore_then_execute ? app::StudyMode::ignore : *one.mode)));
  if (one.limit) add(shown(*one.limit) + ' ' + std::string(one.limited.unit));
  if (one.force_limit) add(shown(*one.force_limit) + " N");
  if (one.diameter) add(shown(*one.diameter) + " m");
  return name;
}

}  // namespace

Scene scene_from_file(const std::string& file, const std::vector<std::string>& settings) {
  return scene_of_document(document_of(file, settings), std::make_shared<app::Units>());
}

std::vector<BenchScene> scenes_from_file(const std::string& file, const std::vector<std::string>& settings) {
  const app::Document document = document_of(file, settings);
  const auto units = std::make_shared<app::Units>();
  Scene scene = scene_of_document(document, units);
  if (scene.problem == ProblemKind::estimate || scene.problem == ProblemKind::execute) {
    throw Error(file + ": problem \"" + std::string(to_string(scene.problem)) +
                "\" needs no solver plugin, so there is nothing to compare; expected \"pose\", \"trajectory\" or "
                "\"grasp\"");
  }
  std::vector<TargetSpec> steps;
  if (scene.problem == ProblemKind::trajectory) {
    // Each step by itself: what a warm start would save is not the solvers' doing.
    steps = scene.trajectory.targets;
    scene.problem = ProblemKind::pose;
    scene.trajectory = {};
    scene.target = {};
  }
  const std::string name = std::filesystem::path(file).stem().string();
  if (document.root().find("study") == nullptr) return {{name, scene, steps}};
  const app::StudySpec study = app::read_study(document, *units);
  if (!study.moments.empty()) {
    throw Error(file +
                ": [study] moments are carried out and not planned, so there is nothing to compare in them; "
                "expected a study of targets, modes, limits, force_limits or diameters");
  }
  std::vector<BenchScene> scenes;
  for (app::StudyCase one : app::study_cases(study)) {
    const std::string own = name + case_name(one);
    const std::optional<Vec2> target = one.target;
    one.target.reset();
    // Plans that ignore obstacles are the same whatever is then done with them.
    auto known = std::find_if(scenes.begin(), scenes.end(), [&](const BenchScene& s) { return s.name == own; });
    if (known == scenes.end()) known = scenes.insert(known, {own, app::scene_of(scene, one), steps});
    const bool there = std::any_of(known->targets.begin(), known->targets.end(), [&](const TargetSpec& t) {
      return t.position && target && t.position->x == target->x && t.position->y == target->y;
    });
    if (target && !there) known->targets.push_back({target, scene.target.angle});
  }
  return scenes;
}

Scene with_target(const BenchScene& bench, std::size_t target) {
  Scene scene = bench.scene;
  if (target >= bench.targets.size()) return scene;
  const TargetSpec& own = bench.targets[target];
  if (own.position) scene.target.position = own.position;
  if (own.angle) scene.target.angle = own.angle;
  if (own.turns) scene.target.turns = own.turns;
  scene.target.position_tolerance = std::min(scene.target.position_tolerance, own.position_tolerance);
  scene.target.angle_tolerance = std::min(scene.target.angle_tolerance, own.angle_tolerance);
  for (const MovedObstacle& moved : own.obstacles) {
    scene.obstacles[static_cast<std::size_t>(moved.obstacle)].place = moved.place;
  }
  return scene;
}

std::string gravity() { return "gravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n"; }

std::string arm(const std::string& limit) {
  return "[rod]\nlength = \"100 mm\"\nbending_stiffness = \"4.9e-4 N m^2\"\nlinear_density = \"84 g/m\"\n"
         "[[rod.actuator]]\nlimit = \"" +
         limit + "\"\n[start]\ntip_angle = \"0.5 rad\"\n";
}

std::string peg() {
  return "[[obstacle]]\nname = \"peg\"\nshape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"\n";
}

std::string objectives() {
  return "[[objective]]\nplugin = \"tip_pose\"\nweight = 100\n"
         "[[objective]]\nplugin = \"actuation_effort\"\nweight = 1e-4\n";
}

std::vector<KnownScene> known_scenes(const plugins::Registry& registry) {
  std::vector<KnownScene> known;
  // self_weight.csv, weight 1 and tip moment 1.
  known.push_back({"free arm",
                   scene_from_text(gravity() +
                                       "[rod]\nlength = \"100 mm\"\nbending_stiffness = \"9.81e-3 N m^2\"\n"
                                       "linear_density = \"1 kg/m\"\n[[rod.actuator]]\nlimit = \"98.1 N mm\"\n"
                                       "[target]\nposition = [\"70 mm\", \"70 mm\"]\n" +
                                       objectives(),
                                   "free arm", registry),
                   0.0981,
                   {0.0898317039, 0.0363091933},
                   std::nullopt,
                   std::nullopt,
                   1e-9});
  // braced_arm.csv, moment 2.5 N mm.
  known.push_back({"braced arm",
                   scene_from_text(gravity() + arm("2.5 N mm") + peg() +
                                       "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n"
                                       "[target]\nposition = [\"97 mm\", \"26 mm\"]\n" +
                                       objectives(),
                                   "braced arm", registry),
                   0.0025,
                   {0.09670319442, 0.02200183222},
                   0.05862167146,
                   0.06178404562,
                   1e-10});
  return known;
}

std::vector<Vec2> grid(Vec2 low, Vec2 high, int side) {
  std::vector<Vec2> points;
  const auto at = [&](double a, double b, int i) { return side == 1 ? 0.5 * (a + b) : a + (b - a) * i / (side - 1); };
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) points.push_back({at(low.x, high.x, i), at(low.y, high.y, j)});
  }
  return points;
}

std::vector<BenchScene> bench_scenes(const plugins::Registry& registry, int side) {
  const std::string target = "[target]\nposition = [\"97 mm\", \"20 mm\"]\n";
  const std::string allow = "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n";
  const std::string two_pegs =
      peg() +
      "[[obstacle]]\nname = \"upper\"\nshape = \"circle\"\ncenter = [\"80 mm\", \"26 mm\"]\nradius = \"8 mm\"\n";
  const std::string ledge =
      "[[obstacle]]\nname = \"ledge\"\nshape = \"polygon\"\nvertices = [[\"50 mm\", \"3 mm\"], [\"40 mm\", \"-20 "
      "mm\"], "
      "[\"72 mm\", \"-20 mm\"], [\"66 mm\", \"2 mm\"]]\nrounding = \"4 mm\"\n"
      "[[obstacle]]\nname = \"bar\"\nshape = \"capsule\"\nfrom = [\"78 mm\", \"22 mm\"]\nto = [\"100 mm\", \"42 mm\"]\n"
      "radius = \"5 mm\"\n";
  std::vector<BenchScene> scenes;
  const auto add = [&](const std::string& name, const std::string& text, Vec2 low, Vec2 high) {
    BenchScene& scene = scenes.emplace_back(BenchScene{name, scene_from_text(text, name, registry), {}});
    for (const Vec2 at : grid(low, high, side)) scene.targets.push_back({at, std::nullopt});
  };
  // The targets of the paper's pose problem, both limits of its motor; then scenes with two obstacles.
  add("free", gravity() + arm("10 N mm") + target + objectives(), {0.091, 0.006}, {0.099, 0.026});
  add("avoid", gravity() + arm("10 N mm") + peg() + "[contact]\nmode = \"avoid\"\n" + target + objectives(),
      {0.091, 0.006}, {0.099, 0.026});
  add("brace", gravity() + arm("2.5 N mm") + peg() + allow + target + objectives(), {0.091, 0.006}, {0.099, 0.026});
  add("brace, strong", gravity() + arm("10 N mm") + peg() + allow + target + objectives(), {0.091, 0.006},
      {0.099, 0.026});
  add("two pegs", gravity() + arm("5 N mm") + two_pegs + allow + "count = 2\n" + target + objectives(), {0.091, 0.018},
      {0.097, 0.030});
  add("ledge", gravity() + arm("5 N mm") + ledge + allow + "count = 2\n" + target + objectives(), {0.090, 0.014},
      {0.096, 0.030});
  return scenes;
}

}  // namespace tendril::bench
