#include "tendril/app/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>

extern char** environ;

namespace tendril::app {

ProcessResult run_process(const std::string& program, const std::vector<std::string>& arguments,
                          const std::filesystem::path& directory, double seconds, const ProcessWatch& watch) {
  ProcessResult result;
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return result;

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe[1], STDERR_FILENO);
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  result.started = ::posix_spawnp(&child, program.c_str(), &actions, nullptr, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[1]);

  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  std::array<char, 4096> block{};
  while (result.started) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd source{pipe[0], POLLIN, 0};
    const bool stopped = watch.stop != nullptr && *watch.stop;
    // What is to stop it is looked at ten times a second.
    const auto wait = watch.stop != nullptr ? std::min<long>(left, 100) : left;
    const int ready = left > 0 && !stopped ? ::poll(&source, 1, static_cast<int>(wait)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0 && left > wait && !stopped) continue;
    if (ready <= 0) {
      result.timed_out = true;
      ::kill(child, SIGKILL);
      break;
    }
    const ssize_t count = ::read(pipe[0], block.data(), block.size());
    if (count <= 0) break;
    if (result.output.size() < std::size_t{1} << 16)
      result.output.append(block.data(), static_cast<std::size_t>(count));
    if (watch.on_output) watch.on_output({block.data(), static_cast<std::size_t>(count)});
  }
  ::close(pipe[0]);
  if (result.started) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  }
  return result;
}

bool program_found(const std::string& program) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables here
  const char* const path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "/usr/bin:/bin";
  while (true) {
    const std::size_t colon = rest.find(':');
    const std::filesystem::path file = std::filesystem::path(rest.substr(0, colon)) / program;
    if (::access(file.c_str(), X_OK) == 0) return true;
    if (colon == std::string_view::npos) return false;
    rest.remove_prefix(colon + 1);
  }
}

}  // namespace tendril::app
