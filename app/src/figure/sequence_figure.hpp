#pragma once

#include <string>
#include <vector>

#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"
#include "tendril/estimate_sequence.hpp"

namespace tendril::app {

/// Draws force and place of every contact over time, with bands of two standard deviations. Files and errors as in
/// draw_pictures().
void draw_sequence(const std::string& title, const SequenceEstimate& estimate, double length, StagedFiles& files,
                   const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
