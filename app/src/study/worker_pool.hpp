#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace tendril::app {

/// Worker processes, each this program with other arguments, that compute numbered cases.
///
/// A worker gets a number and a line feed at its standard input, which is a socket, and answers there with one line.
/// Its first line, before any case, must be `greeting`. What it writes to standard output and error is kept for the
/// report of a crash. A worker that ends costs its own case only; the case is tried once more by another worker, in
/// case something outside ended the first one.
struct PoolTasks {
  std::vector<std::string> arguments;  ///< without the program's name
  std::string greeting;
  int jobs = 1;
  std::vector<int> cases;
  std::function<void(int index, const std::string& line)> on_answer;
  std::function<void(int index, const std::string& reason)> on_crash;  ///< after the second attempt
  const std::atomic<bool>* stop = nullptr;
};

/// Returns when every case is answered or lost, or when asked to stop; then no worker is left. False: stopped. Throws
/// InputError with what the worker said if it refuses to start.
bool run_pool(const PoolTasks& tasks);

/// A worker's side: reads numbers and writes answers until the pool goes. Returns the exit code.
int serve_pool(const std::string& greeting, const std::function<std::string(int index)>& answer);

}  // namespace tendril::app
