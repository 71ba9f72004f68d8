#include "system/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace tendril::app {

Progress::Progress(std::string work, std::string parts, std::size_t count, std::size_t done)
    : terminal_(::isatty(STDERR_FILENO) == 1),
      work_(std::move(work)),
      parts_(std::move(parts)),
      count_(count),
      done_(done),
      at_start_(done) {
  show();
}

Progress::~Progress() {
  if (terminal_) fmt::print(stderr, "\r\x1b[K");
}

void Progress::step(bool failed) {
  ++done_;
  failed_ += failed ? 1 : 0;
  show();
}

void Progress::show() const {
  if (!terminal_) return;
  std::string text = fmt::format("\r{}: {} of {} {}", work_, done_, count_, parts_);
  if (failed_ > 0) text += fmt::format(", {} failed", failed_);
  if (done_ > at_start_) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    text += fmt::format(", {:.0f} s left",
                        seconds * static_cast<double>(count_ - done_) / static_cast<double>(done_ - at_start_));
  }
  fmt::print(stderr, "{}\x1b[K", text);
  std::fflush(stderr);
}

}  // namespace tendril::app
