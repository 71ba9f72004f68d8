#include "tendril/app/interrupt.hpp"

#include <signal.h>
#include <unistd.h>

#include "tendril/plugins/crash.hpp"

namespace tendril::app {

namespace {

// A signal handler reaches nothing but objects of static lifetime.
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);
struct sigaction previous {};

void on_interrupt(int) { interrupted.store(true); }

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted.store(false);
  struct sigaction action {};
  action.sa_handler = &on_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  ::sigaction(SIGINT, &action, &previous);
}

InterruptGuard::~InterruptGuard() { ::sigaction(SIGINT, &previous, nullptr); }

const std::atomic<bool>& InterruptGuard::flag() { return interrupted; }

Watchdog::Watchdog(std::chrono::duration<double> limit, std::string message)
    : thread_([this, limit, watched = ::pthread_self(), text = std::move(message) + '\n'] {
        std::unique_lock lock(mutex_);
        // A limit that the clock cannot hold is no limit.
        if (limit > std::chrono::hours(24 * 365)) {
          done_.wait(lock, [this] { return finished_; });
          return;
        }
        if (done_.wait_for(lock, limit, [this] { return finished_; })) return;
        // Destructors would wait for the very code that does not return.
        [[maybe_unused]] const auto count = ::write(STDERR_FILENO, text.data(), text.size());
        plugins::end_while_running(watched);
      }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  done_.notify_one();
  thread_.join();
}

}  // namespace tendril::app
