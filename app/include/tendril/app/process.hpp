#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace tendril::app {

/// How a program that was run ended.
struct ProcessResult {
  bool started = false;
  bool timed_out = false;
  int exit_code = -1;  ///< -1 if it was ended by a signal
  std::string output;  ///< what it wrote to its standard output and error, at most 64 KiB
};

/// What happens while a program runs.
struct ProcessWatch {
  std::function<void(std::string_view)> on_output{};  ///< told all that it writes, as it comes
  const std::atomic<bool>* stop = nullptr;            ///< set to true to end it; it has then timed out
};

/// Runs `program` (looked up in PATH, without a shell) with `arguments` in `directory` and waits for it, at most
/// `seconds`.
ProcessResult run_process(const std::string& program, const std::vector<std::string>& arguments,
                          const std::filesystem::path& directory, double seconds, const ProcessWatch& watch = {});

/// Whether PATH has a program of this name.
bool program_found(const std::string& program);

}  // namespace tendril::app
