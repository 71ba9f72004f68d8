#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/registrar.hpp"

namespace tendril::plugins {

/// A directory in which plugins are looked for.
struct SearchPlace {
  std::filesystem::path directory;  ///< searched without its subdirectories
  std::string origin;  ///< who named it: "--plugin-dir", "TENDRIL_PLUGIN_PATH", "beside the executable", ...
  /// Directories that are trusted without a look, with all above them. Empty: none.
  std::filesystem::path trusted_above{};
};

/// The directories to search, in order: `plugin_directories` (from --plugin-dir), the entries of TENDRIL_PLUGIN_PATH
/// (separated by ':', empty ones ignored), and the own directory of this build or installation, found from the
/// executable, or from libtendril where the program stands elsewhere. The current directory is never searched unless it
/// is named.
std::vector<SearchPlace> search_places(std::span<const std::filesystem::path> plugin_directories);

/// The file of the running program.
std::filesystem::path executable_path();

/// What a plugin's file name says: `tendril-<kind>-<name>.so`.
struct PluginName {
  ComponentKind kind{};  ///< the middle word
  std::string name;      ///< as scenes write it
};
/// Nothing if the name is not of that form.
std::optional<PluginName> parse_file_name(std::string_view file_name);
/// The name of a plugin's file: the reverse of parse_file_name().
std::string file_name(ComponentKind kind, std::string_view name);

/// A file that is named like a plugin. It has not been opened.
struct PluginFile {
  ComponentKind kind{};            ///< from its file's name
  std::string name;                ///< from its file's name
  std::filesystem::path path;      ///< as found in the search place
  std::filesystem::path resolved;  ///< behind all links; empty for a broken link
  std::string origin;              ///< of its search place
  std::string refusal;             ///< why it must not be opened; empty: it may
  bool untrusted = false;          ///< the refusal is about who may change it
  bool shadowed = false;           ///< an earlier place has a plugin of the same kind and name
};

/// What the search path offers, read from file names alone: nothing is opened.
class Catalog {
 public:
  explicit Catalog(std::span<const SearchPlace> places);  ///< Searches `places` in order.

  /// A search place, and what came of searching it.
  struct Place {
    SearchPlace place;     ///< as it was named
    std::string problem;   ///< why nothing could be taken from it; empty: searched
    int plugin_count = 0;  ///< files named like plugins
  };
  /// A library that is not named like a plugin.
  struct Stray {
    std::filesystem::path path;  ///< as found
    std::string problem;         ///< why it is no plugin
  };

  /// In the order of search.
  const std::vector<Place>& places() const { return places_; }
  /// In the order of search, then by name; shadowed and refused ones too.
  const std::vector<PluginFile>& files() const { return files_; }
  /// Libraries in a search place that are not named like a plugin.
  const std::vector<Stray>& strays() const { return strays_; }
  /// Names of one kind, sorted, each once.
  std::vector<std::string> names(ComponentKind kind) const;
  /// The file that stands for a name: the first on the search path. Throws PluginError (not_found) with every place
  /// tried and the nearest name; `more_names` are known by other means (shapes that core brings along).
  const PluginFile& find(ComponentKind kind, std::string_view name, std::span<const std::string> more_names = {}) const;

 private:
  void read(Place& place);

  std::vector<Place> places_;
  std::vector<PluginFile> files_;
  std::vector<Stray> strays_;
};

}  // namespace tendril::plugins
