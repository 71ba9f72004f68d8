#pragma once

#include <string>

namespace tendril::app {

/// Text to standard output. Throws InputError if it cannot be written.
void print(const std::string& text);
/// A line to standard error.
void note(const std::string& text);

}  // namespace tendril::app
