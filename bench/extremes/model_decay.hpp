#pragma once

#include <map>
#include <string>

#include "common/extent.hpp"
#include "extremes/models.hpp"
#include "tendril/plan.hpp"

namespace tendril::bench {

/// How the error of a coarse model falls while it is refined.
struct Decay {
  bool as_expected = false;  ///< at least in proportion to the coordinates
  std::string text{};        ///< the errors, and with how many coordinates
};

/// Decays of models, each measured once.
class ModelDecays {
 public:
  ModelDecays(plugins::Registry& registry, const Extent& extent) : registry_(registry), extent_(extent) {}

  /// Of `name`, a scene that `plan` is the plan of with this model and this error.
  const Decay& of(const std::string& name, const Scene& scene, const Plan& plan, double error,
                  const ExtremeModel& model);

 private:
  Decay measured(const Scene& scene, const Plan& plan, double error, const ExtremeModel& model);

  plugins::Registry& registry_;
  const Extent& extent_;
  std::map<std::string, Decay> known_;
};

}  // namespace tendril::bench
