// The watchdog, Ctrl-C, and processes that several threads start and wait for, as a campaign does. ThreadSanitizer
// watches (scripts/threads).

#include <gtest/gtest.h>
#include <signal.h>

#include <mutex>
#include <thread>
#include <vector>

#include "tendril/app/interrupt.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {
namespace {

using Seconds = std::chrono::duration<double>;

TEST(Threads, AWatchdogCanBeCalledOffAtOnce) {
  for (int i = 0; i < 1000; ++i) const Watchdog called_off(Seconds(60.0), "late");
  // Longer than any clock holds.
  const Watchdog never(Seconds(1e300), "never");
}

TEST(Threads, ALateWatchdogEndsTheProcess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto hang = [] {
    const Watchdog watchdog(Seconds(0.05), "solver 'endless' did not return");
    std::this_thread::sleep_for(Seconds(60.0));
  };
  EXPECT_EXIT(hang(), testing::ExitedWithCode(1), "solver 'endless' did not return");
}

TEST(Threads, CtrlCIsSeenByAnother) {
  const InterruptGuard guard;
  EXPECT_FALSE(InterruptGuard::flag().load());
  std::thread waiting([] {
    while (!InterruptGuard::flag().load()) std::this_thread::yield();
  });
  ::raise(SIGINT);
  waiting.join();
  EXPECT_TRUE(InterruptGuard::flag().load());
}

TEST(Threads, EachGetsTheOutputOfItsOwnProcesses) {
  constexpr int processes = 60;
  std::mutex mutex;
  int next = 0;
  std::vector<int> seen;
  const auto work = [&] {
    while (true) {
      int own = 0;
      {
        const std::lock_guard lock(mutex);
        if (next == processes) return;
        own = next++;
      }
      const ProcessResult result =
          run_process("/bin/sh", {"-c", "echo " + std::to_string(own) + "; exit 3"}, std::filesystem::path("/"), 60.0);
      const std::lock_guard lock(mutex);
      EXPECT_EQ(result.exit_code, 3);
      EXPECT_EQ(result.output, std::to_string(own) + "\n");
      seen.push_back(own);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(processes));
}

}  // namespace
}  // namespace tendril::app
