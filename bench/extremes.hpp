#pragma once

#include <memory>
#include <string>
#include <vector>

#include "extent.hpp"
#include "extreme_cases.hpp"
#include "section.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

enum class Outcome {
  met,        ///< what is known came out
  explained,  ///< it did not, by a limit of the model that was measured
  not_met
};
std::string to_string(Outcome outcome);

/// One case with one coordinate model and one backend.
struct ExtremeRow {
  std::string group, name;
  std::string model;    ///< "-": none takes part
  std::string backend;  ///< "-": none takes part
  std::string expected, source, got, residuals;
  double error = 0.0;    ///< of the model: against the exact state, of what is worst; NaN: there is none
  double allowed = 0.0;  ///< without any explanation
  double seconds = 0.0;
  Outcome outcome = Outcome::not_met;
  std::string why{};  ///< how the error falls where the model is coarse, or why the row is not met
};

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

/// Loads at which a rod loses its stability, by the certificate at the critical state; what a basis costs in digits.
std::vector<ExtremeRow> instability_rows(plugins::Registry& registry, const Extent& extent);
std::vector<ExtremeRow> conditioning_rows(plugins::Registry& registry, const Extent& extent);

/// All rows. Stops early if the extent says so.
std::vector<ExtremeRow> extreme_rows(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out);

Section extremes_section(plugins::Registry& registry, const Extent& extent);

}  // namespace tendril::bench
