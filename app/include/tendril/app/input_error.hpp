#pragma once

#include "tendril/error.hpp"

namespace tendril::app {

/// Input that cannot be used: a scene, an argument, a plugin, a file. The message is complete (file, line and column
/// included) and meant for a user; the command prints it and ends with exit code 2.
class InputError : public Error {
 public:
  using Error::Error;
};

}  // namespace tendril::app
