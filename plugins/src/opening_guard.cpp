#include "opening_guard.hpp"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <iterator>

namespace tendril::plugins {

namespace {

// A signal handler reaches nothing but static data. The text belongs to the guard that lives.
std::atomic<const char*> text = nullptr;
std::atomic<std::size_t> text_size = 0;
struct sigaction actions_before[std::size(OpeningGuard::signals)];
std::terminate_handler terminate_before = nullptr;

/// Once only: a terminate ends in an abort, which comes here again.
void say() {
  if (const char* message = text.exchange(nullptr)) {
    // Nothing can be done about a failed write while the process ends.
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, text_size);
  }
}

extern "C" void tendril_on_crash_while_opening(int signal_number) {
  say();
  // With the former action back in place the signal comes again after the return: an abort raises it a second time, a
  // fault repeats itself.
  for (std::size_t i = 0; i < std::size(OpeningGuard::signals); ++i) {
    if (OpeningGuard::signals[i] == signal_number) ::sigaction(signal_number, &actions_before[i], nullptr);
  }
}

/// A plugin that calls exit() must not look like a program that had nothing more to say.
void on_exit_while_opening() {
  if (text.load() == nullptr) return;
  say();
  ::_exit(2);
}

[[noreturn]] void on_terminate() {
  say();
  if (terminate_before) terminate_before();
  std::abort();
}

}  // namespace

std::mutex OpeningGuard::only_one;

OpeningGuard::OpeningGuard(const std::filesystem::path& library)
    : message_("tendril: the plugin " + library.string() + " ended the program while it was being opened\n"),
      terminate_before_(std::set_terminate(on_terminate)) {
  terminate_before = terminate_before_;
  static const bool registered = std::atexit(on_exit_while_opening) == 0;
  static_cast<void>(registered);
  text_size = message_.size();
  text = message_.c_str();
  struct sigaction action {};
  action.sa_handler = tendril_on_crash_while_opening;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < std::size(signals); ++i) ::sigaction(signals[i], &action, &actions_before[i]);
}

OpeningGuard::~OpeningGuard() {
  for (std::size_t i = 0; i < std::size(signals); ++i) ::sigaction(signals[i], &actions_before[i], nullptr);
  std::set_terminate(terminate_before_);
  text = nullptr;
}

}  // namespace tendril::plugins
