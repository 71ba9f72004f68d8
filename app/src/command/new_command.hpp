#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tendril::app {

struct NewArguments {
  std::string kind, name;
  std::optional<std::filesystem::path> directory;  ///< the name, in the current directory, by default
};

/// Writes a small plugin project that builds, plans and passes its tests as it is, and says what to do next. All files
/// or none are written. Throws InputError for a name that cannot be or is taken, and for a directory that exists.
int run_new(const NewArguments& arguments);

}  // namespace tendril::app
