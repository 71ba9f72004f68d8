#include <fstream>

#include "support.hpp"
#include "support/print.hpp"
#include "tendril/version.hpp"

namespace tendril::plugins {
namespace {

PluginError failure_of_fixture(const std::string& name) { return failure_of(name, {fixture_directory(name)}); }

/// The message with which the factory of a fixture fails.
std::string factory_failure(const std::string& name, const RawOptions& given = {}) {
  Registry registry(catalog_of({fixture_directory(name)}));
  const ObjectiveComponent& component = registry.objective(name);
  try {
    component.make(resolve_options(component.options, given, Scale{}, {}, name));
  } catch (const PluginError& error) {
    EXPECT_EQ(error.failure(), Failure::threw);
    return error.what();
  }
  return "nothing was thrown";
}

TEST(OpenPlugin, HandsOutAComponentThatWorks) {
  Registry registry(catalog_of({fixture_directory("fine")}));
  const ObjectiveComponent& component = registry.objective("fine");
  EXPECT_EQ(component.description, "a plugin for tests");
  const auto term = component.make(Options{});
  std::vector<double> residuals;
  Contribution<double> out(residuals);
  term->evaluate(Quantities<double>{}, out);
  EXPECT_EQ(out.smooth_part(), 1.0);
}

TEST(OpenPlugin, ObjectsOutliveTheRegistry) {
  std::unique_ptr<ObjectiveTerm> term;
  {
    Registry registry(catalog_of({fixture_directory("fine")}));
    term = registry.objective("fine").make(Options{});
  }
  EXPECT_TRUE(term->reads().moments);
}

TEST(OpenPlugin, CoresShapesNeedNoPlugin) {
  Registry registry(catalog_of({}));
  EXPECT_EQ(registry.obstacle("circle").name, "circle");
  EXPECT_TRUE(registry.opened().empty());
}

ComponentSource provides(const std::string& name) {
  return [name](Registrar& registrar) {
    registrar.add(ObjectiveComponent{name, "of a test", {}, [](const Options&) -> std::unique_ptr<ObjectiveTerm> {
                                       throw Error("it cannot be made");
                                     }});
  };
}

template <class Step>
std::string refusal_of(Step step) {
  try {
    step();
  } catch (const PluginError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(ProvidedComponent, NeedsNoPlugin) {
  Registry registry(catalog_of({fixture_directory("fine")}), provides("own"));
  EXPECT_EQ(registry.objective("own").description, "of a test");
  EXPECT_TRUE(registry.opened().empty());
  EXPECT_EQ(registry.names(ComponentKind::objective), (std::vector<std::string>{"fine", "own"}));
  EXPECT_EQ(registry.origin(ComponentKind::objective, "own"), "objective 'own' of this program");
  EXPECT_EQ(registry.origin(ComponentKind::obstacle, "circle"), "");
  EXPECT_TRUE(contains_text(refusal_of([&] { registry.objective("owm"); }), "did you mean 'own'"));
}

TEST(ProvidedComponent, TakesNoNameThatIsThere) {
  const auto refusal = [](const std::string& name) {
    return refusal_of([&] { Registry(catalog_of({fixture_directory("fine")}), provides(name)); });
  };
  EXPECT_TRUE(contains_text(refusal("fine"), "objective 'fine' is there already"));
  EXPECT_TRUE(contains_text(refusal("Own Term"), "is no name of a component"));
}

TEST(OpenPlugin, PathsMayHaveSpacesAndLettersOfAllLanguages) {
  const TemporaryDirectory temporary;
  const fs::path directory = temporary.directory("Größe & 触手 (1)");
  put_fine_plugin(directory);
  EXPECT_NO_THROW(Registry(catalog_of({directory})).objective("fine"));
}

TEST(OpenPlugin, LinksAreFollowed) {
  const TemporaryDirectory temporary;
  const fs::path file = fixture_file("fine");
  fs::create_symlink(file, temporary.path() / file.filename());
  const Catalog catalog = catalog_of({temporary.path()});
  EXPECT_EQ(catalog.files().at(0).resolved, fs::canonical(file));
  EXPECT_NO_THROW(Registry(catalog).objective("fine"));
}

TEST(OpenPlugin, ALinkOfAnotherNameIsToldWithWhatItLeadsTo) {
  const TemporaryDirectory temporary;
  const fs::path file = fixture_file("fine");
  fs::create_symlink(file, temporary.path() / "tendril-objective-alias.so");
  const PluginError error = failure_of("alias", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::wrong_component);
  expect_says(error.what(),
              {"registers objective 'fine'", "named for objective 'alias'", "a link to: " + file.string()});
}

TEST(OpenPlugin, ALinkToNothingIsRefused) {
  const TemporaryDirectory temporary;
  fs::create_symlink(temporary.path() / "gone.so", temporary.path() / "tendril-objective-fine.so");
  expect_says(failure_of("fine", {temporary.path()}).what(), {"a link to nothing"});
}

TEST(OpenPlugin, ATextFileIsRefused) {
  const TemporaryDirectory temporary;
  std::ofstream(temporary.path() / "tendril-objective-fine.so") << "INPUT(libm.so)\n";
  const PluginError error = failure_of("fine", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::not_a_plugin);
  expect_says(error.what(), {"not a shared library", (temporary.path() / "tendril-objective-fine.so").string()});
}

TEST(OpenPlugin, AnEmptyFileIsRefused) {
  const TemporaryDirectory temporary;
  std::ofstream(temporary.path() / "tendril-objective-fine.so").flush();
  const PluginError error = failure_of("fine", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::not_a_plugin);
  expect_says(error.what(), {"it is empty"});
}

TEST(OpenPlugin, ATruncatedLibraryIsRefused) {
  const TemporaryDirectory temporary;
  fs::resize_file(put_fine_plugin(temporary.path()), 100);
  const PluginError error = failure_of("fine", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::failed);
  expect_says(error.what(), {"was found (--plugin-dir) but cannot be used", "cannot read"});
}

TEST(OpenPlugin, ADirectoryIsRefused) {
  const TemporaryDirectory temporary;
  temporary.directory("tendril-objective-fine.so");
  const PluginError error = failure_of("fine", {temporary.path()});
  EXPECT_EQ(error.failure(), Failure::not_a_plugin);
  expect_says(error.what(), {"a directory, not a library"});
}

TEST(OpenPlugin, ALibraryWithoutTheSymbolsIsRefused) {
  const PluginError error = failure_of_fixture("no_symbols");
  EXPECT_EQ(error.failure(), Failure::not_a_plugin);
  expect_says(error.what(), {"no symbol tendril_plugin_handshake", "TENDRIL_PLUGIN"});
}

TEST(OpenPlugin, AMissingLibraryIsNamed) {
  const PluginError error = failure_of_fixture("needs_library");
  EXPECT_EQ(error.failure(), Failure::missing_dependency);
  expect_says(error.what(), {"was found", "libfixture-helper.so is missing", fixture_file("needs_library").string()});
}

TEST(OpenPlugin, AnotherInterfaceIsTold) {
  const PluginError error = failure_of_fixture("other_interface");
  EXPECT_EQ(error.failure(), Failure::other_interface);
  expect_says(error.what(), {"built for another interface",
                             "interface version: 999, this program: " + std::to_string(TENDRIL_INTERFACE_VERSION)});
}

TEST(OpenPlugin, AnOlderInterfaceIsRefusedWithAdvice) {
  const PluginError error = failure_of_fixture("older_interface");
  EXPECT_EQ(error.failure(), Failure::other_interface);
  const std::string now = std::to_string(TENDRIL_INTERFACE_VERSION);
  const std::string before = std::to_string(TENDRIL_INTERFACE_VERSION - 1);
  expect_says(error.what(), {"interface version: " + before + ", this program: " + now,
                             "the plugin is older: rebuild it against this tendril"});
}

TEST(OpenPlugin, AnotherEigenAlignmentIsTold) {
  const PluginError error = failure_of_fixture("other_alignment");
  EXPECT_EQ(error.failure(), Failure::other_interface);
  expect_says(error.what(), {"Eigen alignment in bytes: 64, this program: 16"});
}

TEST(OpenPlugin, AnotherSanitizerIsTold) {
  const PluginError error = failure_of_fixture("other_sanitizer");
  EXPECT_EQ(error.failure(), Failure::other_interface);
  expect_says(error.what(), {"sanitizers", "build both with the same -fsanitize"});
}

// A plugin is linked to libtendril, so one of another version is turned down before its handshake can be asked.
TEST(OpenPlugin, AnotherCoreIsTold) {
  const std::string now = std::to_string(TENDRIL_INTERFACE_VERSION);
  for (const auto& [fixture, version] :
       {std::pair<std::string, int>("later_core", 999), {"earlier_core", TENDRIL_INTERFACE_VERSION - 1}}) {
    const PluginError error = failure_of_fixture(fixture);
    EXPECT_EQ(error.failure(), Failure::other_interface);
    expect_says(error.what(), {"built for another interface: it needs libtendril.so." + std::to_string(version),
                               "this program has libtendril.so." + now, "rebuild the plugin against this tendril"});
  }
}

TEST(OpenPlugin, AMissingSymbolIsNamed) {
  const PluginError error = failure_of_fixture("undefined_symbol");
  EXPECT_EQ(error.failure(), Failure::other_interface);
  expect_says(error.what(), {"fixture_helper", "rebuild the plugin"});
}

TEST(OpenPlugin, AnExceptionWhileRegisteringIsTold) {
  const PluginError error = failure_of_fixture("throws_in_register");
  EXPECT_EQ(error.failure(), Failure::threw);
  expect_says(error.what(),
              {"threw while registering: no license for this term", fixture_file("throws_in_register").string()});
}

TEST(OpenPlugin, AnotherNameThanTheFilesIsRefused) {
  const PluginError error = failure_of_fixture("another_name");
  EXPECT_EQ(error.failure(), Failure::wrong_component);
  expect_says(error.what(), {"registers objective 'something_else'", "named for objective 'another_name'"});
}

TEST(OpenPlugin, AnotherKindThanTheFilesIsRefused) {
  const PluginError error = failure_of_fixture("wrong_kind");
  EXPECT_EQ(error.failure(), Failure::wrong_component);
  expect_says(error.what(), {"registers coordinates 'wrong_kind'", "named for objective 'wrong_kind'"});
}

TEST(OpenPlugin, OneComponentIsExpected) {
  expect_says(failure_of_fixture("two_components").what(),
              {"registers 2 components ('two_components', 'one_more')", "exactly one"});
  expect_says(failure_of_fixture("registers_nothing").what(), {"registers nothing"});
}

TEST(OpenPlugin, AnExceptionInTheFactoryNamesTheFile) {
  expect_says(factory_failure("throws_in_factory"),
              {"objective plugin 'throws_in_factory'", fixture_file("throws_in_factory").string(),
               "the data of this term are missing"});
  expect_says(factory_failure("throws_in_factory", {{"what", {std::string("number")}}}), {"no std::exception"});
}

TEST(OpenPlugin, AComplaintAboutAnOptionKeepsItsPlace) {
  try {
    factory_failure("throws_in_factory", {{"what", {std::string("option")}}});
    FAIL() << "nothing was thrown";
  } catch (const OptionError& error) {
    EXPECT_EQ(error.option(), "what");
    EXPECT_EQ(error.position().line, 3);
  }
}

TEST(OpenPlugin, AFactoryThatReturnsNothingIsTold) {
  expect_says(factory_failure("makes_nothing"), {"objective plugin 'makes_nothing'", "returned nothing"});
}

TEST(OpenPluginDeathTest, ACrashNamesTheLibrary) {
  EXPECT_DEATH(Registry(catalog_of({fixture_directory("aborts_at_load")})).objective("aborts_at_load"),
               "tendril-objective-aborts_at_load.so ended the program while it was being opened");
}

TEST(OpenPluginDeathTest, AnExitNamesTheLibrary) {
  EXPECT_EXIT(Registry(catalog_of({fixture_directory("calls_exit")})).objective("calls_exit"),
              testing::ExitedWithCode(2),
              "tendril-objective-calls_exit.so ended the program while it was being opened");
}

}  // namespace
}  // namespace tendril::plugins
