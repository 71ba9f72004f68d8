#pragma once

#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// What the reports of all problems begin and end with.
std::string heading(const Scene& scene);
std::string line(const std::string& name, const std::string& value);
std::string note_lines(const std::vector<std::string>& notes);  ///< what stands below the status
std::string left_out_text(const std::vector<LeftOut>& items);

}  // namespace tendril::app
