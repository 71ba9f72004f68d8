#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/section.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// A coordinate model as the rows have it.
struct ExtremeModel {
  std::string name, plugin, option;  ///< option empty: the plugin's own defaults
  int value = 0;
};
/// Every coordinate plugin with its defaults; with `refined`, each option that counts something at 12, too.
std::vector<ExtremeModel> extreme_models(plugins::Registry& registry, bool refined, std::vector<LeftOut>& left_out);
/// Every value of every option that counts something: orders and numbers of pieces.
std::vector<ExtremeModel> counted_models(plugins::Registry& registry, const std::vector<int>& values);
Scene with_model(Scene scene, const ExtremeModel& model);
std::unique_ptr<CoordinateModel> make_model(plugins::Registry& registry, const ExtremeModel& model, double length,
                                            double stiffness);

/// How often a model can be refined.
inline constexpr int refinement_levels = 3;
/// The scene with a finer model: a larger value of what the plugin counts, or, where it counts nothing, with segments
/// cut into parts, and every piece with them. `level`: from 0 on, below refinement_levels. It is planned with the
/// default solver where that is found: errors of models are not those of solvers. None: the model is finer already.
std::optional<Scene> refined(plugins::Registry& registry, const Scene& scene, const ExtremeModel& model, int level);

}  // namespace tendril::bench
