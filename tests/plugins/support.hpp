#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "support/contains.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::plugins {

namespace fs = std::filesystem;

/// A directory that vanishes with the test.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (fs::canonical(fs::temp_directory_path()) / "tendril-test-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  const fs::path& path() const { return path_; }

  /// Makes a directory in it.
  fs::path directory(const std::string& name) const {
    fs::create_directories(path_ / name);
    return path_ / name;
  }

 private:
  fs::path path_;
};

inline fs::path fixture_directory(const std::string& name) { return fs::path(FIXTURES) / name; }
inline fs::path fixture_file(const std::string& name) {
  return fixture_directory(name) / file_name(ComponentKind::objective, name);
}

/// Puts a copy of the plugin that works into `directory`, under another name if one is given.
inline fs::path put_fine_plugin(const fs::path& directory, const std::string& name = "fine") {
  const fs::path file = directory / file_name(ComponentKind::objective, name);
  fs::copy_file(fixture_file("fine"), file);
  return file;
}

inline Catalog catalog_of(const std::vector<fs::path>& directories) {
  std::vector<SearchPlace> places;
  for (const fs::path& directory : directories) places.push_back({directory, "--plugin-dir"});
  return Catalog(places);
}

/// What opening the objective `name` from `directories` fails with.
inline PluginError failure_of(const std::string& name, const std::vector<fs::path>& directories) {
  try {
    Registry(catalog_of(directories)).objective(name);
  } catch (const PluginError& error) {
    return error;
  }
  throw std::logic_error("the plugin '" + name + "' was opened");
}

inline void expect_says(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_TRUE(contains_text(message, part)) << message << "\nlacks: " << part;
  }
}

}  // namespace tendril::plugins
