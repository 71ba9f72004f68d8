#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tendril::app {

/// How a program that was run ended.
struct ProcessResult {
  bool started = false;
  bool timed_out = false;
  int exit_code = -1;  ///< -1 if it was ended by a signal
  std::string output;  ///< what it wrote to its standard output and error, at most 64 KiB
};

/// Runs `program` (looked up in PATH, without a shell) with `arguments` in `directory` and waits for it, at most
/// `seconds`.
ProcessResult run_process(const std::string& program, const std::vector<std::string>& arguments,
                          const std::filesystem::path& directory, double seconds);

}  // namespace tendril::app
