#pragma once

#include "campaign/campaign.hpp"

namespace tendril::bench {

/// What each part of the search is worth: the same random scenes with everything, then with each of the named
/// parameters of the search set otherwise. `settings`: NAME=VALUE; none: every strategy is left out in turn. Plans
/// nothing more once `setup.stop` is set.
Section ablation_section(CampaignSetup setup, std::vector<std::string> settings);

}  // namespace tendril::bench
