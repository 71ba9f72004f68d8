#pragma once

#include <pybind11/pybind11.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>

#include "tendril/error.hpp"

namespace tendril::python {

/// While it lives in Python's main thread, Ctrl-C sets stop() and then does what Python does with it. Elsewhere nobody
/// sets stop(), since only the main thread hears of signals.
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

  const std::atomic<bool>& stop() const { return listening_ ? flag : never; }
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
  static inline const std::atomic<bool> never{false};
  static inline struct sigaction previous {};
  bool listening_ = false;
};

/// Runs `work` without Python's lock; Ctrl-C ends it.
template <class Work>
auto interruptible(Work&& work) {
  const Interruptible guard;
  try {
    auto result = [&] {
      const pybind11::gil_scoped_release released;
      return work(guard.stop());
    }();
    guard.raise();
    return result;
  } catch (const Error&) {
    guard.raise();  // what was ended is no error of its own
    throw;
  }
}

}  // namespace tendril::python
