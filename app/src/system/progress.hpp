#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace tendril::app {

/// One line on a terminal, renewed as something is finished; nothing anywhere else.
class Progress {
 public:
  /// `work` is made of `count` `parts` ("study", "cases"); `done` of them were finished before.
  Progress(std::string work, std::string parts, std::size_t count, std::size_t done);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step(bool failed);

 private:
  void show() const;

  const bool terminal_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::string work_, parts_;
  std::size_t count_, done_, at_start_, failed_ = 0;
};

}  // namespace tendril::app
