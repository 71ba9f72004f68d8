#pragma once

#include <csignal>
#include <exception>
#include <filesystem>
#include <mutex>
#include <string>

namespace tendril::plugins {

/// While it lives, a crash of the process (std::terminate, abort, an invalid access) names the library being opened on
/// standard error before it takes its course. One at a time: another thread waits.
class OpeningGuard {
 public:
  explicit OpeningGuard(const std::filesystem::path& library);
  ~OpeningGuard();
  OpeningGuard(const OpeningGuard&) = delete;
  OpeningGuard& operator=(const OpeningGuard&) = delete;

  static constexpr int signals[] = {SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE};

 private:
  static std::mutex only_one;

  const std::lock_guard<std::mutex> alone_{only_one};  // first, since the others change what belongs to the process
  std::string message_;
  std::terminate_handler terminate_before_;
};

}  // namespace tendril::plugins
