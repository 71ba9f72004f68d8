#pragma once

#include <string>
#include <vector>

#include "tendril/app/document.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

// A plain number is SI. Scenes are thought of in mm and degrees, and one whose unit was forgotten makes sense as a
// number all the same: an obstacle 60 m away is no obstacle. What has a unit is taken at its word.

/// Asks about angles of more than a turn and a half (degrees?), lengths of more than ten rods and moments that would
/// wind the rod up (mm?), and materials that there are none of: one question for each key of the document, with its
/// place.
std::vector<std::string> doubtful_numbers(const Document& document, const Scene& scene);

/// The same of a component's options, which stand in `table`; those that come from a file have units of their own.
std::vector<std::string> doubtful_numbers(const Document& document, const Scene& scene, const OptionSchema& schema,
                                          const Node& table);

}  // namespace tendril::app
