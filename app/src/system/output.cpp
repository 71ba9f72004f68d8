#include "system/output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "tendril/app/input_error.hpp"

namespace tendril::app {

void print(const std::string& text) {
  const bool good = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!good) throw InputError("cannot write to standard output: " + std::generic_category().message(errno));
}

void note(const std::string& text) { fmt::print(stderr, "tendril: {}\n", text); }

}  // namespace tendril::app
