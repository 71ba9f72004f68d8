#pragma once

#include <string>
#include <vector>

#include "tendril/plugin.hpp"

namespace tendril::plugins {

/// What differs between a plugin and this program, one sentence for each field, in words. Empty: they fit together.
std::vector<std::string> differences(const tendril_handshake& plugin, const tendril_handshake& program);

}  // namespace tendril::plugins
