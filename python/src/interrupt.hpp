#pragma once

#include <pybind11/pybind11.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <optional>
#include <utility>

#include "tendril/error.hpp"

namespace tendril::python {

/// While it lives in Python's main thread, Ctrl-C sets stop() and then does what Python does with it. Elsewhere only
/// end() sets stop(), since only the main thread hears of signals.
class Interruptible {
 public:
  Interruptible() {
    if (::gettid() != ::getpid()) return;
    flag.store(false);
    ::sigaction(SIGINT, nullptr, &previous);
    // Who ignores Ctrl-C, or lets it end the process, goes on doing so.
    listening_ =
        previous.sa_handler != SIG_IGN && previous.sa_handler != SIG_DFL && (previous.sa_flags & SA_SIGINFO) == 0;
    if (!listening_) return;
    struct sigaction action = previous;
    action.sa_handler = &on_interrupt;
    ::sigaction(SIGINT, &action, nullptr);
  }
  ~Interruptible() {
    if (listening_) ::sigaction(SIGINT, &previous, nullptr);
  }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  const std::atomic<bool>& stop() const { return listening_ ? flag : ended_; }
  void end() { (listening_ ? flag : ended_).store(true); }
  /// Lets Python raise KeyboardInterrupt, or whatever the user's handler does.
  void raise() const {
    if (stop().load() && PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  static void on_interrupt(int number) {
    flag.store(true);
    previous.sa_handler(number);
  }

  static inline std::atomic<bool> flag{false};
  static inline struct sigaction previous {};
  std::atomic<bool> ended_{false};
  bool listening_ = false;
};

/// Tells a function of Python, or None, how far a run is. What the function raises ends the run.
class Reporter {
 public:
  Reporter(pybind11::object function, Interruptible& run) : function_(std::move(function)), run_(run) {}

  /// Empty where nobody wants to know.
  std::function<void(int finished, int total)> report() {
    if (function_.is_none()) return {};
    return [this](int finished, int total) {
      const pybind11::gil_scoped_acquire held;
      if (raised_) return;
      try {
        function_(finished, total);
      } catch (pybind11::error_already_set& raised) {
        raised_.emplace(raised);
        run_.end();
      }
    };
  }
  /// Once more, what the function raised.
  void raise() const {
    if (raised_) throw pybind11::error_already_set(*raised_);
  }

 private:
  pybind11::object function_;
  Interruptible& run_;
  std::optional<pybind11::error_already_set> raised_;
};

/// Runs `work` without Python's lock, with what ends it and what it tells `progress` by; Ctrl-C ends it.
template <class Work>
auto reporting(const pybind11::object& progress, Work&& work) {
  Interruptible guard;
  Reporter reporter(progress, guard);
  const auto raise = [&] {
    reporter.raise();
    guard.raise();
  };
  try {
    auto result = [&] {
      const auto report = reporter.report();
      const pybind11::gil_scoped_release released;
      return work(guard.stop(), report);
    }();
    raise();
    return result;
  } catch (const Error&) {
    raise();  // what was ended is no error of its own
    throw;
  }
}

/// The same of what tells nothing.
template <class Work>
auto interruptible(Work&& work) {
  return reporting(pybind11::none(), [&](const auto& stop, const auto&) { return work(stop); });
}

}  // namespace tendril::python
