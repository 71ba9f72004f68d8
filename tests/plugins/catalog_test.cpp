#include "tendril/plugins/catalog.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "support.hpp"
#include "support/print.hpp"

namespace tendril::plugins {
namespace {

/// Sets an environment variable for the length of a test.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~EnvironmentVariable() {
    if (before_) {
      ::setenv(name_, before_->c_str(), 1);
    } else {
      ::unsetenv(name_);
    }
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// Makes another directory the current one for the length of a test.
class CurrentDirectory {
 public:
  explicit CurrentDirectory(const fs::path& path) : before_(fs::current_path()) { fs::current_path(path); }
  ~CurrentDirectory() { fs::current_path(before_); }
  CurrentDirectory(const CurrentDirectory&) = delete;
  CurrentDirectory& operator=(const CurrentDirectory&) = delete;

 private:
  fs::path before_;
};

TEST(FileName, TellsKindAndName) {
  const auto parsed = parse_file_name("tendril-objective-tip_pose.so");
  ASSERT_TRUE(parsed.has_value());
  EXPECT_EQ(parsed->kind, ComponentKind::objective);
  EXPECT_EQ(parsed->name, "tip_pose");
  EXPECT_EQ(file_name(parsed->kind, parsed->name), "tendril-objective-tip_pose.so");
}

TEST(FileName, OfAnotherFormTellsNothing) {
  for (const char* name : {"tendril-objective-.so", "tendril-objective-Tip.so", "tendril-objective-a.b.so",
                           "tendril-widget-a.so", "libtendril.so", "tendril-.so", "tendril-objective-a.so.1", ".so", "",
                           "tendril-.s", "tendril-objective-2d.so"}) {
    EXPECT_FALSE(parse_file_name(name).has_value()) << name;
  }
}

TEST(SearchPlaces, AreGivenThenEnvironmentThenOwn) {
  const EnvironmentVariable variable("TENDRIL_PLUGIN_PATH", "/from/environment:/second");
  const std::vector<fs::path> given{"/given"};
  const std::vector<SearchPlace> places = search_places(given);
  ASSERT_EQ(places.size(), 4U);
  EXPECT_EQ(places[0].directory, "/given");
  EXPECT_EQ(places[1].directory, "/from/environment");
  EXPECT_EQ(places[2].directory, "/second");
  EXPECT_EQ(places[3].directory, executable_path().parent_path().parent_path() / "lib/tendril/plugins");
}

TEST(SearchPlaces, EmptyEntriesOfTheEnvironmentAreIgnored) {
  const EnvironmentVariable variable("TENDRIL_PLUGIN_PATH", ":/a::/b:");
  const std::vector<SearchPlace> places = search_places({});
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(places[0].directory, "/a");
  EXPECT_EQ(places[1].directory, "/b");
}

TEST(SearchPlaces, TheCurrentDirectoryIsNotSearched) {
  const EnvironmentVariable variable("TENDRIL_PLUGIN_PATH", ":");
  const CurrentDirectory here(fixture_directory("fine"));
  const Catalog catalog(search_places({}));
  EXPECT_THROW(catalog.find(ComponentKind::objective, "fine"), PluginError);
}

TEST(Catalog, ListsWithoutOpening) {
  // Opening this one would end the test.
  const Catalog catalog = catalog_of({fixture_directory("aborts_at_load")});
  EXPECT_EQ(catalog.names(ComponentKind::objective), std::vector<std::string>{"aborts_at_load"});
  EXPECT_TRUE(catalog.names(ComponentKind::solver).empty());
}

TEST(Catalog, TheFirstDirectoryWinsAndTheOtherIsListedAsShadowed) {
  const TemporaryDirectory temporary;
  const fs::path first = temporary.directory("first");
  put_fine_plugin(first);
  const Catalog catalog = catalog_of({first, fixture_directory("fine")});
  EXPECT_EQ(catalog.find(ComponentKind::objective, "fine").path.parent_path(), first);
  ASSERT_EQ(catalog.files().size(), 2U);
  EXPECT_FALSE(catalog.files()[0].shadowed);
  EXPECT_TRUE(catalog.files()[1].shadowed);
  EXPECT_EQ(catalog.names(ComponentKind::objective).size(), 1U);
}

TEST(Catalog, ADirectoryNamedTwiceCountsOnce) {
  const TemporaryDirectory temporary;
  const fs::path directory = temporary.directory("plugins");
  put_fine_plugin(directory);
  fs::create_directory_symlink(directory, temporary.path() / "link");
  const Catalog catalog = catalog_of({directory, directory, temporary.path() / "link"});
  EXPECT_EQ(catalog.places().size(), 1U);
  EXPECT_EQ(catalog.files().size(), 1U);
}

TEST(Catalog, LibrariesOfAnotherNameAreListedApart) {
  const TemporaryDirectory temporary;
  std::ofstream(temporary.path() / "tendril-objective-Big.so") << "x";
  std::ofstream(temporary.path() / "notes.txt") << "x";
  const Catalog catalog = catalog_of({temporary.path()});
  EXPECT_TRUE(catalog.files().empty());
  ASSERT_EQ(catalog.strays().size(), 1U);
  EXPECT_EQ(catalog.strays()[0].path.filename(), "tendril-objective-Big.so");
}

TEST(NotFound, TellsEveryPlaceAndTheNearestName) {
  const TemporaryDirectory temporary;
  const fs::path missing = temporary.path() / "missing";
  const PluginError error = failure_of("fien", {missing, fixture_directory("fine")});
  EXPECT_EQ(error.failure(), Failure::not_found);
  expect_says(error.what(),
              {"objective plugin 'fien' was not found", "did you mean 'fine'?", "tendril-objective-fien.so",
               missing.string() + " (--plugin-dir): No such file or directory",
               fixture_directory("fine").string() + " (--plugin-dir): not there"});
}

TEST(NotFound, KnowsThatANameIsNoPath) {
  for (const char* name : {"../fine", "/lib/fine", "fine.so", "", "FINE"}) {
    const PluginError error = failure_of(name, {fixture_directory("fine")});
    EXPECT_EQ(error.failure(), Failure::not_found);
    expect_says(error.what(), {"is never a path"});
  }
}

TEST(NotFound, TellsOfAPluginOfThatNameAndAnotherKind) {
  Registry registry(catalog_of({fixture_directory("fine")}));
  try {
    registry.solver("fine");
    FAIL() << "an objective was taken for a solver";
  } catch (const PluginError& error) {
    expect_says(error.what(), {"solver plugin 'fine' was not found", "of kind objective"});
  }
}

TEST(NotFound, KnowsTheShapesOfCore) {
  Registry registry(catalog_of({}));
  try {
    registry.obstacle("circel");
    FAIL() << "a misspelled shape was found";
  } catch (const PluginError& error) {
    expect_says(error.what(), {"obstacle plugin 'circel' was not found", "did you mean 'circle'?"});
  }
}

TEST(Trust, AWorldWritableDirectoryIsRefused) {
  const TemporaryDirectory temporary;
  const fs::path directory = temporary.directory("open");
  put_fine_plugin(directory);
  ::chmod(directory.c_str(), 0777);
  const PluginError error = failure_of("fine", {directory});
  EXPECT_EQ(error.failure(), Failure::untrusted);
  expect_says(error.what(), {directory.string() + " can be written by everybody"});
}

TEST(Trust, AWorldWritableStickyDirectoryOfPluginsIsRefusedToo) {
  const TemporaryDirectory temporary;
  const fs::path directory = temporary.directory("sticky");
  put_fine_plugin(directory);
  ::chmod(directory.c_str(), 01777);
  EXPECT_EQ(failure_of("fine", {directory}).failure(), Failure::untrusted);
  // The directory itself is told, not only what is in it.
  expect_says(catalog_of({directory}).places().at(0).problem, {"can be written by everybody"});
}

TEST(Trust, AWorldWritableLibraryIsRefused) {
  const TemporaryDirectory temporary;
  const fs::path file = put_fine_plugin(temporary.path());
  ::chmod(file.c_str(), 0777);
  const PluginError error = failure_of("fine", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::untrusted);
  expect_says(error.what(), {file.string() + " can be written by everybody"});
}

TEST(Trust, AWorldWritableDirectoryAboveIsRefusedUnlessSticky) {
  const TemporaryDirectory temporary;
  const fs::path above = temporary.directory("above");
  const fs::path directory = temporary.directory("above/plugins");
  put_fine_plugin(directory);
  ::chmod(above.c_str(), 0777);
  expect_says(failure_of("fine", {directory}).what(), {above.string() + " can be written by everybody"});
  ::chmod(above.c_str(), 01777);
  EXPECT_NO_THROW(Registry(catalog_of({directory})).objective("fine"));
}

TEST(Trust, TheDirectoryBehindALinkIsLookedAt) {
  const TemporaryDirectory temporary;
  const fs::path open = temporary.directory("open");
  const fs::path closed = temporary.directory("closed");
  const fs::path file = put_fine_plugin(open);
  fs::create_symlink(file, closed / file.filename());
  ::chmod(open.c_str(), 0777);
  const PluginError error = failure_of("fine", {closed});
  EXPECT_EQ(error.failure(), Failure::untrusted);
  expect_says(error.what(), {open.string() + " can be written by everybody"});
}

/// One of the things that may belong to somebody else: the library, its directory, or one above, of these permissions.
struct Owned {
  const char* what;
  const char* path;
  mode_t mode;
};

TEST(Trust, WhatBelongsToAnotherUserIsRefused) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  constexpr uid_t nobody = 65534;
  for (const Owned& owned :
       {Owned{"library", "above/plugins/tendril-objective-fine.so", 0755}, Owned{"directory", "above/plugins", 0755},
        Owned{"directory above", "above", 0755}, Owned{"sticky directory above", "above", 01777},
        Owned{"sticky directory above that only its owner can write", "above", 01755}}) {
    SCOPED_TRACE(owned.what);
    const TemporaryDirectory temporary;
    temporary.directory("above");
    const fs::path directory = temporary.directory("above/plugins");
    put_fine_plugin(directory);
    const fs::path given = temporary.path() / owned.path;
    ::chmod(given.c_str(), owned.mode);
    EXPECT_NO_THROW(Registry(catalog_of({directory})).objective("fine"));
    ASSERT_EQ(::chown(given.c_str(), nobody, nobody), 0);
    const PluginError error = failure_of("fine", {directory});
    EXPECT_EQ(error.failure(), Failure::untrusted);
    expect_says(error.what(), {given.string() + " belongs to user 65534, neither to root nor to you"});
  }
}

TEST(Trust, ARefusedFirstChoiceIsNotReplacedByALaterOne) {
  const TemporaryDirectory temporary;
  const fs::path file = put_fine_plugin(temporary.path());
  ::chmod(file.c_str(), 0777);
  EXPECT_EQ(failure_of("fine", {temporary.path(), fixture_directory("fine")}).failure(), Failure::untrusted);
}

TEST(Trust, WhatHoldsTheExecutableTooIsNotLookedAt) {
  const TemporaryDirectory temporary;
  const fs::path above = temporary.directory("prefix");
  const fs::path directory = temporary.directory("prefix/lib/tendril/plugins");
  put_fine_plugin(directory);
  ::chmod(above.c_str(), 0777);
  const std::vector<SearchPlace> places{{directory, "beside the executable", above}};
  EXPECT_NO_THROW(Registry{Catalog(places)}.objective("fine"));
  ::chmod(temporary.directory("prefix/lib").c_str(), 0777);
  EXPECT_THROW(Registry{Catalog(places)}.objective("fine"), PluginError);
}

}  // namespace
}  // namespace tendril::plugins
