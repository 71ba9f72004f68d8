#include "tendril/plugins/crash.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <iterator>
#include <string_view>

namespace tendril::plugins {

namespace {

// A signal handler must not allocate, so everything here is plain data.

constexpr int fatal[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
/// Frames above the plugin's: the handler, the kernel's, and what the plugin calls.
constexpr int most_frames = 64;
/// A stack that has overflowed cannot take the handler.
std::array<char, 65536> spare_stack;

void say(std::string_view text) {
  // Nothing can be done about a failed write while the process ends.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

/// "objective 'straight'" of ".../tendril-objective-straight.so"; writes nothing for other libraries.
bool say_plugin(const char* path) {
  constexpr std::string_view prefix = "tendril-";
  constexpr std::string_view suffix = ".so";
  std::string_view name = path;
  name = name.substr(name.rfind('/') + 1);
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return false;
  name = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  const auto dash = name.find('-');
  if (dash == std::string_view::npos) return false;
  say(name.substr(0, dash));
  say(" plugin '");
  say(name.substr(dash + 1));
  say("' (");
  say(path);
  say(")");
  return true;
}

/// Names the innermost plugin that is being executed.
bool say_running_plugin() {
  void* frames[most_frames];
  const int count = ::backtrace(frames, most_frames);
  for (int i = 0; i < count; ++i) {
    Dl_info info;
    if (::dladdr(frames[i], &info) != 0 && info.dli_fname != nullptr && say_plugin(info.dli_fname)) return true;
  }
  return false;
}

extern "C" void tendril_on_crash(int signal_number) {
  say("tendril: ");
  if (!say_running_plugin()) say("the program");
  say(" crashed: ");
  say(::sigdescr_np(signal_number));
  say("\n");
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);
}

extern "C" void tendril_on_alarm(int) {
  say("tendril: ");
  if (!say_running_plugin()) say("the program");
  say(" was running and did not return in time\n");
  ::_exit(1);
}

/// The first call of backtrace() loads a library, which a handler must not do.
void prepare_backtrace() {
  void* frame = nullptr;
  ::backtrace(&frame, 1);
}

void take_alarms() {
  prepare_backtrace();
  struct sigaction action {};
  action.sa_handler = tendril_on_alarm;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGALRM, &action, nullptr);
}

}  // namespace

void name_plugin_in_crashes() {
  prepare_backtrace();
  stack_t stack{};
  stack.ss_sp = spare_stack.data();
  stack.ss_size = spare_stack.size();
  ::sigaltstack(&stack, nullptr);
  for (const int signal_number : fatal) {
    struct sigaction before {};
    if (::sigaction(signal_number, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = tendril_on_crash;
    action.sa_flags = SA_ONSTACK | SA_NODEFER;
    sigemptyset(&action.sa_mask);
    ::sigaction(signal_number, &action, nullptr);
  }
}

void end_after(unsigned seconds) {
  take_alarms();
  ::alarm(seconds);
}

void end_while_running(pthread_t thread) {
  take_alarms();
  ::pthread_kill(thread, SIGALRM);
  ::sleep(1);
  ::_exit(1);
}

}  // namespace tendril::plugins
