#include "command/new_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "command/plugin_templates.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::app {

namespace fs = std::filesystem;

namespace {

const PluginTemplate& template_of(const std::string& kind) {
  std::vector<std::string> kinds;
  for (const PluginTemplate& each : plugin_templates) {
    if (kind == to_string(each.kind)) return each;
    kinds.emplace_back(to_string(each.kind));
  }
  throw InputError("new: found the kind '" + kind + "', expected coordinates, objective, obstacle or solver" +
                   did_you_mean(kind, kinds));
}

void check_name(ComponentKind kind, const std::string& name) {
  // The library's file name is longer by its kind and must still be one.
  constexpr std::size_t longest = 64;
  const auto parsed = plugins::parse_file_name(plugins::file_name(kind, name));
  if (!parsed || parsed->name != name || name.size() > longest) {
    std::string found = name.substr(0, 200);
    std::replace(found.begin(), found.end(), '\n', ' ');
    throw InputError(
        fmt::format("new: found the name '{}', expected lower-case letters, digits and '_', beginning with "
                    "a letter, at most {} of them",
                    found, longest));
  }
  const plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  const std::vector<std::string> taken = registry.names(kind);
  if (std::find(taken.begin(), taken.end(), name) != taken.end()) {
    throw InputError(
        fmt::format("new: the name '{}' is taken by a component of the kind '{}' that is there already, "
                    "expected another name",
                    name, to_string(kind)));
  }
}

/// "level_tip" -> "LevelTip"
std::string class_name(const std::string& name) {
  std::string text;
  bool begins = true;
  for (const char c : name) {
    if (c != '_') text += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = c == '_';
  }
  return text;
}

std::string filled(std::string_view text, ComponentKind kind, const std::string& name) {
  std::string result(text);
  for (const auto& [mark, value] : {std::pair<std::string, std::string>{"@name@", name},
                                    {"@kind@", std::string(to_string(kind))},
                                    {"@Class@", class_name(name)}}) {
    for (std::size_t at = 0; (at = result.find(mark, at)) != std::string::npos; at += value.size()) {
      result.replace(at, mark.size(), value);
    }
  }
  return result;
}

/// As a shell takes it for one word.
std::string word(const fs::path& path) {
  std::string text = path.string();
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("._-/+").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// What CMake has to be told to find this tendril: nothing in the usual prefixes.
std::string package_argument() {
  const fs::path prefix = plugins::executable_path().parent_path().parent_path();
  if (prefix == "/usr" || prefix == "/usr/local") return "";
  for (const fs::path& directory : {prefix / TENDRIL_PACKAGE_FROM_PREFIX, prefix}) {
    if (fs::exists(directory / "tendril-config.cmake")) return " -Dtendril_DIR=" + word(directory);
  }
  return "";
}

}  // namespace

int run_new(const NewArguments& arguments) {
  const PluginTemplate& from = template_of(arguments.kind);
  check_name(from.kind, arguments.name);
  const fs::path directory = arguments.directory.value_or(fs::path(arguments.name));
  std::error_code error;
  if (fs::symlink_status(directory, error).type() != fs::file_type::not_found) {
    throw InputError("new: '" + directory.string() + "' exists already, expected a directory that does not");
  }
  const std::string source = arguments.name + ".cpp";
  StagedFiles files(directory);
  files.write(source, filled(from.source, from.kind, arguments.name));
  files.write("CMakeLists.txt", filled(project_template, from.kind, arguments.name));
  files.write("scene.toml", filled(from.scene, from.kind, arguments.name));
  files.publish();

  const std::string where = word(directory);
  const std::string build = word(directory / "build");
  fmt::print("{}: {}, CMakeLists.txt, scene.toml\n\nBuild, test, plan:\n\n", where, source);
  fmt::print("    cmake -S {} -B {}{}\n    cmake --build {}\n    ctest --test-dir {} --output-on-failure\n", where,
             build, package_argument(), build, build);
  fmt::print("    tendril plan {} --plugin-dir {}\n", word(directory / "scene.toml"), build);
  return 0;
}

}  // namespace tendril::app
