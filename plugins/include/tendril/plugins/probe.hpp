#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace tendril::plugins {

/// How a plugin behaved when it was opened in a process of its own.
struct ProbeResult {
  bool loadable = false;  ///< It opened, fits, and registered what its name says.
  std::string problem;    ///< one line or more, if it is not
};

/// Opens `file` in a child process, which is `program --probe-plugin FILE`, so that a plugin that aborts or hangs does
/// no harm here. `program` has to call answer_probe first thing; the default is the running program.
ProbeResult probe(const std::filesystem::path& file, std::chrono::milliseconds time_limit = std::chrono::seconds(10),
                  const std::filesystem::path& program = {});

/// For the beginning of main: answers a probe and returns the exit code, or returns nothing if this is no probe.
std::optional<int> answer_probe(int argc, const char* const* argv);

}  // namespace tendril::plugins
