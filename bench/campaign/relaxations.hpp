#pragma once

#include <string>
#include <vector>

#include "campaign/campaign.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// A change of a scene that leaves every plan of it possible, or a wider search: no plan may get worse.
struct Relaxation {
  std::string name, meaning;
  bool (*apply)(Scene& scene);  ///< false: the scene has nothing to relax
};

const std::vector<Relaxation>& relaxations();

/// Plans random scenes and each of their relaxations, with every solver: how many pairs there are, and which plans got
/// worse; how often the scene's own plan is the best that any solver found for it. Plans nothing more once `setup.stop`
/// is set. `violations`: plans that got worse.
Section relaxation_section(CampaignSetup setup, int& violations);

}  // namespace tendril::bench
