#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tendril::app {

/// An option or argument of the command, as far as a reader or a shell has to know it.
struct CommandOption {
  std::string name;   ///< "--output"; a positional argument: "SCENE"
  std::string value;  ///< what follows it, "DIR"; empty: nothing
  std::string description;
  bool positional = false;
  bool required = false;
};

/// A subcommand of `tendril`.
struct CommandSpec {
  std::string name;
  std::string description;
  std::vector<CommandOption> options;
};

/// A Markdown page on every key of a scene and every option of every component on the search path.
std::string key_page(const std::vector<std::filesystem::path>& plugin_directories);

/// tendril(1), in the macros of man(7).
std::string manual_page(const std::vector<CommandSpec>& commands);

/// A completion function for bash: commands, options, keys and words for --set, files and directories by what an
/// option takes.
std::string bash_completion(const std::vector<CommandSpec>& commands);

}  // namespace tendril::app
