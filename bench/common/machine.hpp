#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// What a measurement depends on, in words: name and value each.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// Processor, cores, memory, system. Two machines are the same if all of these are.
Facts machine();
/// Version and commit of tendril, compiler, kind of build, plugins opened, and every library in the process by the file
/// it came from: call it after the plugins have been opened.
Facts versions(const plugins::Registry& registry);

}  // namespace tendril::bench
