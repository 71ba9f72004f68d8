#pragma once

#include <memory>
#include <string>

#include "program/tip_deviations.hpp"
#include "search/task.hpp"

namespace tendril {

/// Why nothing of such a rod is differentiated by numbers of its scene; empty: it is.
std::string undifferentiated(const Rod& rod);

/// What the task's scene says that it does not know, for the programs of terms that read it. Throws SceneError at
/// `path` where there is nothing, or something by which nothing is differentiated; `needs` begins the message.
std::shared_ptr<const Uncertainties> uncertainties_of(const Task& task, const std::string& path,
                                                      const std::string& needs);

}  // namespace tendril
