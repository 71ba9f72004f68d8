#include "extremes/models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "common/workload.hpp"
#include "extremes/runs.hpp"
#include "scene/make_rod.hpp"

namespace tendril::bench {

namespace {

/// Values of a counted option, or parts of the rod's segments, that a coarse model is refined by.
constexpr int refinements[refinement_levels] = {12, 24, 48};
constexpr int parts[refinement_levels] = {3, 5, 9};

/// The backend that every model is refined with.
std::string refining_solver(const plugins::Registry& registry, const Scene& scene) {
  const std::string wanted = SolverSpec{}.plugin;
  const std::vector<std::string> found = registry.names(ComponentKind::solver);
  return std::find(found.begin(), found.end(), wanted) != found.end() ? wanted : scene.solver.plugin;
}

}  // namespace

std::vector<ExtremeModel> extreme_models(plugins::Registry& registry, bool refined, std::vector<LeftOut>& left_out) {
  std::vector<ExtremeModel> models;
  for (const std::string& plugin : registry.names(ComponentKind::coordinates)) {
    try {
      (void)registry.coordinates(plugin);
    } catch (const plugins::PluginError& error) {
      if (!refined) left_out.push_back({"coordinates '" + plugin + "'", error.what()});
      continue;
    }
    models.push_back({plugin, plugin, "", 0});
    if (!refined) continue;
    for (ExtremeModel& model : counted_models(registry, {12})) {
      if (model.plugin == plugin) models.push_back(std::move(model));
    }
  }
  return models;
}

std::vector<ExtremeModel> counted_models(plugins::Registry& registry, const std::vector<int>& values) {
  std::vector<ExtremeModel> models;
  std::vector<LeftOut> ignored;
  for (const ModelSweep& sweep : model_sweeps(registry, values, ignored)) {
    if (!sweep.split || sweep.option.empty()) continue;
    for (const int value : sweep.values) {
      models.push_back(
          {fmt::format("{}, {} = {}", sweep.plugin, sweep.option, value), sweep.plugin, sweep.option, value});
    }
  }
  return models;
}

Scene with_model(Scene scene, const ExtremeModel& model) {
  scene.coordinates.plugin = model.plugin;
  scene.coordinates.options.clear();
  if (!model.option.empty()) scene.coordinates.options[model.option] = RawValue{std::int64_t{model.value}};
  return scene;
}

std::unique_ptr<CoordinateModel> make_model(plugins::Registry& registry, const ExtremeModel& model, double length,
                                            double stiffness) {
  const CoordinateComponent& component = registry.coordinates(model.plugin);
  RawOptions raw;
  if (!model.option.empty()) raw[model.option] = RawValue{std::int64_t{model.value}};
  return component.make(resolve_options(component.options, raw, Scale{length, stiffness}, {}, model.name));
}

std::optional<Scene> refined(plugins::Registry& registry, const Scene& scene, const ExtremeModel& model, int level) {
  std::string option = model.option;
  for (const ExtremeModel& counted : counted_models(registry, {refinements[level]})) {
    if (counted.plugin == model.plugin && option.empty()) option = counted.option;
  }
  Scene finer = scene;
  finer.solver.time_limit = refined_time_limit;
  if (const std::string solver = refining_solver(registry, scene); finer.solver.plugin != solver) {
    finer.solver.plugin = solver;
    finer.solver.options.clear();
  }
  if (!option.empty()) {
    const int value = refinements[level];
    if (value <= model.value) return std::nullopt;
    return with_model(finer, {model.name, model.plugin, option, value});
  }
  // Every stretch between two fixed knots, so that pieces beside an actuator's end are cut, too.
  const std::vector<double> knots = make_rod(scene, scale_of(scene)).fixed_knots();
  std::vector<SegmentSpec> cut;
  std::size_t segment = 0;
  double end = scene.rod.segments[0].length;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double middle = 0.5 * (knots[k] + knots[k + 1]) * scene.rod.length();
    while (middle > end && segment + 1 < scene.rod.segments.size()) end += scene.rod.segments[++segment].length;
    for (int i = 0; i < parts[level]; ++i) {
      cut.push_back(scene.rod.segments[segment]);
      cut.back().length = (knots[k + 1] - knots[k]) * scene.rod.length() / parts[level];
    }
  }
  finer.rod.segments = std::move(cut);
  return finer;
}

}  // namespace tendril::bench
