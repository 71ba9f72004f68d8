#include "study/worker_pool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <deque>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "tendril/app/input_error.hpp"

extern char** environ;

namespace tendril::app {

namespace {

constexpr std::size_t kept_output = 2000;  ///< bytes of what a worker said last
constexpr int attempts = 2;

[[noreturn]] void fail(const std::string& what, int error) {
  throw InputError("cannot start a worker process: " + what + ": " + std::generic_category().message(error));
}

/// A file descriptor of its own.
class Handle {
 public:
  Handle() = default;
  explicit Handle(int number) : number_(number) {}
  ~Handle() { reset(); }
  Handle(Handle&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      number_ = std::exchange(other.number_, -1);
    }
    return *this;
  }
  int get() const { return number_; }
  void reset() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_ = -1;
};

/// The environment with one thread for the linear algebra below some solvers: processes are the parallelism here.
std::vector<std::string> worker_environment() {
  constexpr std::string_view threads = "OPENBLAS_NUM_THREADS=";
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with(threads)) entries.emplace_back(*entry);
  }
  entries.push_back(std::string(threads) + "1");
  return entries;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> list;
  list.reserve(words.size() + 1);
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

/// One process and what is known of it.
class Worker {
 public:
  explicit Worker(const std::vector<std::string>& arguments) {
    std::array<int, 2> channel{};
    std::array<int, 2> messages{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, channel.data()) != 0) fail("socketpair", errno);
    channel_ = Handle(channel[0]);
    const Handle far_channel(channel[1]);
    if (::pipe2(messages.data(), O_CLOEXEC) != 0) fail("pipe", errno);
    messages_ = Handle(messages[0]);
    const Handle far_messages(messages[1]);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, far_channel.get(), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, far_messages.get(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, far_messages.get(), STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    // A group of its own: Ctrl-C at the terminal is for the pool, which then ends its workers itself.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    std::vector<std::string> words{"tendril"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<std::string> environment = worker_environment();
    const int error = ::posix_spawn(&child_, "/proc/self/exe", &actions, &attributes, pointers(words).data(),
                                    pointers(environment).data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (error != 0) fail("posix_spawn", error);
  }
  ~Worker() {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      wait();
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int channel() const { return channel_.get(); }
  int messages() const { return messages_.get(); }
  bool greeted = false;
  int index = -1;  ///< of the case that it is working on; -1: none

  void give(int number) {
    index = number;
    const std::string line = std::to_string(number) + '\n';
    // A worker that is gone shows itself at the next read; the signal would end this process.
    [[maybe_unused]] const ssize_t count = ::send(channel_.get(), line.data(), line.size(), MSG_NOSIGNAL);
  }

  /// Reads what is there; false at the end of the channel.
  bool read_channel() {
    std::array<char, 65536> block{};
    const ssize_t count = ::read(channel_.get(), block.data(), block.size());
    if (count > 0) buffer_.append(block.data(), static_cast<std::size_t>(count));
    return count > 0 || (count < 0 && (errno == EINTR || errno == EAGAIN));
  }
  bool read_messages() {
    std::array<char, 4096> block{};
    const ssize_t count = ::read(messages_.get(), block.data(), block.size());
    if (count <= 0) return false;
    said_.append(block.data(), static_cast<std::size_t>(count));
    if (said_.size() > kept_output) said_.erase(0, said_.size() - kept_output);
    return true;
  }
  /// Takes a whole line out of what was read.
  bool next_line(std::string& line) {
    const std::size_t end = buffer_.find('\n');
    if (end == std::string::npos) return false;
    line = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return true;
  }

  void close_messages() { messages_.reset(); }

  /// Waits for the process to end and says how it did.
  std::string end() {
    channel_.reset();
    while (messages_.get() >= 0 && read_messages()) {
    }
    const int status = wait();
    std::string text = WIFSIGNALED(status)
                           ? fmt::format("the worker process was ended by signal {} ({})", WTERMSIG(status),
                                         ::strsignal(WTERMSIG(status)))
                           : fmt::format("the worker process ended with exit code {}", WEXITSTATUS(status));
    if (!said_.empty()) text += ": " + said();
    return text;
  }
  std::string said() const {
    std::string text = said_;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  }

 private:
  int wait() {
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = 0;
    return status;
  }

  Handle channel_, messages_;
  pid_t child_ = 0;
  std::string buffer_, said_;
};

class Pool {
 public:
  explicit Pool(const PoolTasks& tasks) : tasks_(tasks), waiting_(tasks.cases.begin(), tasks.cases.end()) {}

  bool run() {
    while (!waiting_.empty() || !workers_.empty()) {
      if (tasks_.stop != nullptr && tasks_.stop->load()) {
        workers_.clear();
        return false;
      }
      while (workers_.size() < static_cast<std::size_t>(tasks_.jobs) && unstarted() < waiting_.size()) {
        workers_.push_back(std::make_unique<Worker>(tasks_.arguments));
      }
      wait_for_news();
    }
    return true;
  }

 private:
  /// Workers that have no case yet.
  std::size_t unstarted() const {
    return static_cast<std::size_t>(
        std::count_if(workers_.begin(), workers_.end(), [](const auto& worker) { return worker->index < 0; }));
  }

  void wait_for_news() {
    std::vector<pollfd> sources;
    for (const auto& worker : workers_) {
      sources.push_back({worker->channel(), POLLIN, 0});
      sources.push_back({worker->messages(), POLLIN, 0});
    }
    constexpr int milliseconds = 200;  // until the next look at `stop`
    if (::poll(sources.data(), sources.size(), milliseconds) <= 0) return;
    std::vector<Worker*> gone;
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      Worker& worker = *workers_[i];
      // A closed pipe is ready all the time; -1 takes it out of the poll.
      if (sources[2 * i + 1].revents != 0 && !worker.read_messages()) worker.close_messages();
      if (sources[2 * i].revents != 0 && !advance(worker)) gone.push_back(&worker);
    }
    for (Worker* worker : gone) {
      std::erase_if(workers_, [&](const auto& other) { return other.get() == worker; });
    }
  }

  /// False: the worker is done with or dead.
  bool advance(Worker& worker) {
    const bool open = worker.read_channel();
    std::string line;
    while (worker.next_line(line)) {
      if (!worker.greeted) {
        if (line != tasks_.greeting) {
          throw InputError("the scene changed while the study was running; finished cases are kept for the old one");
        }
        worker.greeted = true;
      } else {
        tasks_.on_answer(worker.index, line);
        worker.index = -1;
      }
      if (waiting_.empty()) return false;
      worker.give(waiting_.front());
      waiting_.pop_front();
    }
    if (open) return true;
    const int index = worker.index;
    const std::string reason = worker.end();
    // Workers that cannot even start would be replaced for ever.
    if (!worker.greeted) throw InputError(worker.said().empty() ? reason : worker.said());
    if (index < 0) return false;
    if (++tries_[index] < attempts) {
      waiting_.push_front(index);
    } else {
      tasks_.on_crash(index, reason);
    }
    return false;
  }

  const PoolTasks& tasks_;
  std::deque<int> waiting_;
  std::map<int, int> tries_;
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace

bool run_pool(const PoolTasks& tasks) { return Pool(tasks).run(); }

int serve_pool(const std::string& greeting, const std::function<std::string(int index)>& answer) {
  // Nobody waits for the answer of a worker whose pool is gone.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto reply = [](const std::string& line) {
    const std::string text = line + '\n';
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t count = ::send(STDIN_FILENO, text.data() + done, text.size() - done, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      done += static_cast<std::size_t>(count);
    }
    return true;
  };
  if (!reply(greeting)) return 1;
  std::string buffer;
  std::array<char, 256> block{};
  while (true) {
    const ssize_t count = ::read(STDIN_FILENO, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count == 0 ? 0 : 1;
    buffer.append(block.data(), static_cast<std::size_t>(count));
    for (std::size_t end = buffer.find('\n'); end != std::string::npos; end = buffer.find('\n')) {
      int index = 0;
      std::from_chars(buffer.data(), buffer.data() + end, index);
      buffer.erase(0, end + 1);
      if (!reply(answer(index))) return 1;
    }
  }
}

}  // namespace tendril::app
