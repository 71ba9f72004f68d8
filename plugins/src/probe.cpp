#include "tendril/plugins/probe.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>
#include <string_view>

#include "tendril/plugins/error.hpp"
#include "tendril/plugins/registry.hpp"

extern char** environ;

namespace tendril::plugins {

namespace {

constexpr const char* probe_argument = "--probe-plugin";
// A plugin may print what it likes while it is loaded; what follows the last mark is ours.
constexpr std::string_view mark = "\ntendril-probe: ";
constexpr std::string_view loadable = "loadable";

using Clock = std::chrono::steady_clock;

/// A child process and what it prints. The destructor ends it.
class Child {
 public:
  Child(const std::filesystem::path& program, const std::filesystem::path& file) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(std::string("no pipe for a probe: ") + std::strerror(errno));
    output_ = ends[0];

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    // A group of its own, so that what the plugin starts is ended with it.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);

    std::string arguments[] = {program.string(), probe_argument, file.string()};
    char* argv[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(), nullptr};
    const int failure = ::posix_spawn(&id_, program.c_str(), &actions, &attributes, argv, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (failure != 0) {
      ::close(output_);
      throw Error("cannot start " + program.string() + " for a probe: " + std::strerror(failure));
    }
  }

  ~Child() {
    ::kill(-id_, SIGKILL);
    if (!ended_) ::waitpid(id_, &status_, 0);
    ::close(output_);
  }

  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Reads until the child has ended; false if the time was over first.
  bool wait_until(Clock::time_point end) {
    constexpr int tick_ms = 20;
    while (!ended_) {
      if (Clock::now() >= end) return false;
      // Closed output says nothing about the process itself, so both are looked at.
      pollfd waiting{output_, POLLIN, 0};
      if (!closed_ && ::poll(&waiting, 1, tick_ms) > 0) {
        read_some();
      } else {
        if (closed_) ::usleep(1000);
        ended_ = ::waitpid(id_, &status_, WNOHANG) == id_;
      }
    }
    pollfd rest{output_, POLLIN, 0};
    while (!closed_ && ::poll(&rest, 1, 0) > 0) read_some();
    return true;
  }

  int status() const { return status_; }
  const std::string& output() const { return text_; }

 private:
  void read_some() {
    constexpr std::size_t most = 1U << 16U;
    char buffer[4096];
    const ssize_t count = ::read(output_, buffer, sizeof buffer);
    if (count <= 0) {
      closed_ = count == 0 || errno != EINTR;
      return;
    }
    text_.append(buffer, static_cast<std::size_t>(count));
    // The end matters: a plugin that floods its output loses the beginning.
    if (text_.size() > 2 * most) text_.erase(0, text_.size() - most);
  }

  pid_t id_ = -1;
  int output_ = -1;
  int status_ = 0;
  bool ended_ = false;
  bool closed_ = false;
  std::string text_;
};

}  // namespace

ProbeResult probe(const std::filesystem::path& file, std::chrono::milliseconds time_limit,
                  const std::filesystem::path& program) {
  Child child(program.empty() ? executable_path() : program, file);
  if (!child.wait_until(Clock::now() + time_limit)) {
    return {false, "it did not finish loading within " + std::to_string(time_limit.count()) + " ms"};
  }
  const std::size_t at = child.output().rfind(mark);
  if (WIFEXITED(child.status()) && at != std::string::npos) {
    std::string answer = child.output().substr(at + mark.size());
    if (!answer.empty() && answer.back() == '\n') answer.pop_back();
    return answer == loadable ? ProbeResult{true, ""} : ProbeResult{false, answer};
  }
  std::string problem =
      WIFSIGNALED(child.status())
          ? "it ended the program while being loaded (signal " + std::to_string(WTERMSIG(child.status())) + ", " +
                ::strsignal(WTERMSIG(child.status())) + ")"
          : "it ended the program while being loaded (exit code " + std::to_string(WEXITSTATUS(child.status())) + ")";
  return {false, problem};
}

std::optional<int> answer_probe(int argc, const char* const* argv) {
  if (argc != 3 || std::string_view(argv[1]) != probe_argument) return std::nullopt;
  // A crash is an answer here, not something to keep a memory image of.
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);

  const std::filesystem::path path = argv[2];
  std::string answer(loadable);
  const auto parsed = parse_file_name(path.filename().native());
  if (!parsed) {
    answer = "not named like a plugin";
  } else {
    try {
      std::error_code error;
      open_plugin(
          {parsed->kind, parsed->name, path, std::filesystem::canonical(path, error), "probe", "", false, false});
    } catch (const PluginError& error) {
      answer = error.reason();
    }
  }
  std::cout << mark << answer << std::endl;
  return 0;
}

}  // namespace tendril::plugins
