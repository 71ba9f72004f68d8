#include "tendril/plugins/catalog.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <system_error>
#include <utility>

#include "kinds.hpp"
#include "tendril/options.hpp"
#include "tendril/plugins/error.hpp"
#include "trust.hpp"

namespace tendril::plugins {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view prefix = "tendril-";
constexpr std::string_view suffix = ".so";

bool is_plugin_name(std::string_view name) {
  const auto lower = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto allowed = [&](char c) { return lower(c) || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && lower(name.front()) && std::all_of(name.begin(), name.end(), allowed);
}

/// The closest directory that holds both, itself and the executable. Whoever can change that one can change the
/// program.
fs::path shared_directory(const fs::path& a, const fs::path& b) {
  fs::path shared;
  for (auto x = a.begin(), y = b.begin(); x != a.end() && y != b.end() && *x == *y; ++x, ++y) shared /= *x;
  return shared;
}

/// The file of libtendril; empty if the loader does not tell.
fs::path library_path() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&register_builtin_obstacles), &info) == 0) return {};
  std::error_code error;
  return fs::canonical(info.dli_fname, error);
}

}  // namespace

fs::path executable_path() { return fs::read_symlink("/proc/self/exe"); }

std::vector<SearchPlace> search_places(std::span<const fs::path> plugin_directories) {
  std::vector<SearchPlace> places;
  for (const fs::path& directory : plugin_directories) places.push_back({directory, "--plugin-dir"});
  if (const char* variable = std::getenv("TENDRIL_PLUGIN_PATH")) {
    std::string_view rest = variable;
    while (!rest.empty()) {
      const std::size_t colon = rest.find(':');
      const std::string_view entry = rest.substr(0, colon);
      if (!entry.empty()) places.push_back({fs::path(entry), "TENDRIL_PLUGIN_PATH"});
      rest = colon == std::string_view::npos ? "" : rest.substr(colon + 1);
    }
  }
  const fs::path bin = executable_path().parent_path();
  const fs::path own = fs::weakly_canonical(bin / TENDRIL_PLUGINS_FROM_EXECUTABLE);
  places.push_back({own, "beside the executable", shared_directory(own, bin)});
  // Programs that link libtendril stand anywhere; the plugins stand where the library does.
  const fs::path library = library_path().parent_path();
  const fs::path beside_library = fs::weakly_canonical(library / TENDRIL_PLUGINS_FROM_LIBRARY);
  if (!library.empty() && beside_library != own) {
    if (!fs::is_directory(own)) places.pop_back();
    places.push_back({beside_library, "beside libtendril", shared_directory(beside_library, library)});
  }
  return places;
}

std::optional<PluginName> parse_file_name(std::string_view file_name) {
  if (!file_name.starts_with(prefix) || !file_name.ends_with(suffix)) return std::nullopt;
  file_name.remove_prefix(prefix.size());
  if (file_name.size() < suffix.size()) return std::nullopt;
  file_name.remove_suffix(suffix.size());
  for (const ComponentKind kind : kinds) {
    const std::string beginning = std::string(to_string(kind)) + '-';
    if (!file_name.starts_with(beginning)) continue;
    const std::string_view name = file_name.substr(beginning.size());
    if (is_plugin_name(name)) return PluginName{kind, std::string(name)};
  }
  return std::nullopt;
}

std::string file_name(ComponentKind kind, std::string_view name) {
  return std::string(prefix) + std::string(to_string(kind)) + '-' + std::string(name) + std::string(suffix);
}

Catalog::Catalog(std::span<const SearchPlace> places) {
  std::set<fs::path> seen_directories;
  for (const SearchPlace& given : places) {
    Place place{given, "", 0};
    std::error_code error;
    const fs::path resolved = fs::canonical(given.directory, error);
    if (error) {
      place.problem = error.message();
    } else if (!seen_directories.insert(resolved).second) {
      continue;  // named twice
    } else {
      place.place.directory = resolved;
      read(place);
    }
    places_.push_back(std::move(place));
  }

  std::set<std::pair<ComponentKind, std::string>> seen_names;
  for (PluginFile& file : files_) file.shadowed = !seen_names.emplace(file.kind, file.name).second;
}

void Catalog::read(Place& place) {
  const fs::path& directory = place.place.directory;
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().native().ends_with(suffix)) entries.push_back(entry->path());
  }
  if (error) {
    place.problem = error.message();
    return;
  }
  std::sort(entries.begin(), entries.end());

  // Plugins of a directory that is not trusted are listed all the same: one that would have been taken must be told.
  place.problem = distrust(directory, place.place.trusted_above);
  for (const fs::path& path : entries) {
    const auto parsed = parse_file_name(path.filename().native());
    if (!parsed) {
      strays_.push_back({path,
                         "not named tendril-<kind>-<name>.so, where <kind> is coordinates, objective, obstacle or "
                         "solver and <name> has lower-case letters, digits and '_'"});
      continue;
    }
    PluginFile file{parsed->kind,  parsed->name,           path, fs::canonical(path, error), place.place.origin,
                    place.problem, !place.problem.empty(), false};
    if (error) {
      file.refusal = "a link to nothing (" + error.message() + ")";
    } else if (!fs::is_regular_file(file.resolved, error)) {
      file.refusal = fs::is_directory(file.resolved, error) ? "a directory, not a library" : "not a regular file";
    } else if (file.refusal.empty()) {
      file.refusal = distrust(file.resolved, place.place.trusted_above);
      file.untrusted = !file.refusal.empty();
    }
    files_.push_back(std::move(file));
    ++place.plugin_count;
  }
}

std::vector<std::string> Catalog::names(ComponentKind kind) const {
  std::vector<std::string> names;
  for (const PluginFile& file : files_) {
    if (file.kind == kind && !file.shadowed) names.push_back(file.name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

const PluginFile& Catalog::find(ComponentKind kind, std::string_view name,
                                std::span<const std::string> more_names) const {
  for (const PluginFile& file : files_) {
    if (file.kind == kind && file.name == name) return file;
  }

  std::vector<std::string> known = names(kind);
  known.insert(known.end(), more_names.begin(), more_names.end());
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  std::string message =
      std::string(to_string(kind)) + " plugin '" + std::string(name) + "' was not found" + did_you_mean(name, known);
  for (const ComponentKind other : kinds) {
    const std::vector<std::string> others = names(other);
    if (other != kind && std::find(others.begin(), others.end(), name) != others.end()) {
      message += "\nthere is a plugin of that name, but of kind " + std::string(to_string(other));
    }
  }
  if (!is_plugin_name(name)) {
    message += "\na plugin's name has lower-case letters, digits and '_' and is never a path";
  } else {
    message += "\nlooked for " + file_name(kind, name) + " in";
    for (const Place& place : places_) {
      message += "\n  " + place.place.directory.string() + " (" + place.place.origin +
                 "): " + (place.problem.empty() ? "not there" : place.problem);
    }
  }
  throw PluginError(Failure::not_found, message);
}

}  // namespace tendril::plugins
