// Plugins that misbehave in use: the command names the plugin, never calls the plan solved, and ends as it should.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "../app/command.hpp"
#include "support/contains.hpp"

namespace tendril::app {
namespace {

using test::brace_with;
using test::CommandRun;
using test::expect_refused;
using test::plan_text;
using test::scene_path;
using test::TemporaryDirectory;
using test::tendril;

CommandRun plan(const std::string& scene, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"--plugin-dir", HOSTILE_PLUGINS});
  return plan_text(scene, more);
}

/// Told on standard error with exit code 2, or in the message of a plan that is not solved.
void expect_blamed(const CommandRun& run, const std::string& plugin, const std::string& part) {
  EXPECT_TRUE(run.exit_code == 1 || run.exit_code == 2) << run.exit_code << run.err;
  std::string said = run.err;
  if (run.exit_code == 1) {
    const nlohmann::json result = nlohmann::json::parse(run.out);
    EXPECT_NE(result["status"], "solved");
    said = result["message"].get<std::string>();
  }
  EXPECT_TRUE(contains_text(said, plugin));
  EXPECT_TRUE(contains_text(said, part));
  EXPECT_FALSE(contains_text(said, "internal error"));
}

std::string with_term(const std::string& term) { return brace_with("\"actuation_effort\"", '"' + term + '"'); }

std::string with_shape(const std::string& shape) {
  return brace_with("shape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"",
                    "shape = \"" + shape + '"');
}

TEST(HostileObjective, ThatThrowsIsNamed) {
  expect_blamed(plan(with_term("throwing_term")), "objective plugin 'throwing_term'", "the sensor is gone");
}

TEST(HostileObjective, ThatGivesNoNumberIsNamed) {
  const CommandRun run = plan(with_term("nan_term"));
  expect_blamed(run, "objective 'nan_term'", "nan with the tip at (");
  // Where a solver goes along it, other terms are asked of shapes that are no shapes.
  EXPECT_FALSE(contains_text(run.out + run.err, "objective 'tip_pose'")) << run.out;
}

// No number only where the tip is above 10 mm, where the plan is wanted: the plugin and the place, by every solver.
TEST(HostileObjective, ThatGivesNoNumberSomewhereIsNamedWithThePlace) {
  const std::string scene = test::scene_with("free.toml", "\"actuation_effort\"", "\"low_term\"");
  const CommandRun run = plan(scene, {"--set", "rod.actuator.0.limit=\"10 N mm\""});
  expect_blamed(run, "objective 'low_term'", "it is nan with the tip at (");
  EXPECT_EQ(nlohmann::json::parse(run.out)["status"], "failed");
}

// With the peg there is another plan, below it. It is solved, and says what it stayed away from.
TEST(HostileObjective, ThatGivesNoNumberSomewhereIsNamedByAPlanElsewhere) {
  const CommandRun run = plan(with_term("low_term"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "shapes where objective 'low_term' is no number"));
}

TEST(HostileObstacle, ThatMisbehavesIsNamed) {
  expect_blamed(plan(with_shape("throwing_shape")), "obstacle plugin 'throwing_shape'", "the map is gone");
  expect_blamed(plan(with_shape("nan_shape")), "obstacle plugin 'nan_shape'", "not finite");
  expect_blamed(plan(with_shape("long_normal")), "obstacle plugin 'long_normal'", "no unit vector");
  expect_blamed(plan(with_shape("negative_radius")), "obstacle plugin 'negative_radius'",
                "smallest_radius() is not positive");
}

// A shape of core cannot be replaced: the flawed circle on the path is never opened.
TEST(HostileObstacle, NamedLikeAShapeOfCoreIsNotUsed) {
  const CommandRun run = tendril({"plan", scene_path("brace.toml"), "--json", "--plugin-dir", HOSTILE_PLUGINS});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(HostileCoordinates, ThatMisbehaveAreNamed) {
  const auto with = [](const std::string& name) {
    return plan(brace_with("\"legendre\"\norder = 6", '"' + name + '"'));
  };
  expect_blamed(with("no_function"), "coordinates plugin 'no_function'", "function_count() is 0");
  expect_blamed(with("throwing_basis"), "coordinates plugin 'throwing_basis'", "no basis today");
  expect_blamed(with("nan_basis"), "coordinates plugin 'nan_basis'", "not finite");
  expect_blamed(with("dependent_basis"), "coordinates plugin 'dependent_basis'",
                "its functions 1, 2, 3 depend linearly");
  expect_blamed(with("negative_part"), "coordinates plugin 'negative_part'", "not positive");
}

// Restoration and Newton's method alone lead to a certified point of this scene, but never to the plan that was asked
// for: a solver that did nothing makes the plan a failed one, like any other plugin that breaks down.
TEST(HostileSolver, ThatDoesNothingIsBlamed) {
  const std::string scene = brace_with("Brace on a peg", "Brace");
  const std::pair<const char*, const char*> reasons[] = {
      {"throwing_solver", "no license"}, {"short_solver", "not finite"}, {"nan_solver", "not finite"}};
  for (const auto& [name, reason] : reasons) {
    SCOPED_TRACE(name);
    const CommandRun run = plan(scene, {"--solver", name});
    EXPECT_EQ(run.exit_code, 1);
    expect_blamed(run, std::string("solver '") + name + "'", reason);
    const nlohmann::json result = nlohmann::json::parse(run.out);
    EXPECT_EQ(result["status"], "failed");
    EXPECT_EQ(result["solver"]["name"], name);
    EXPECT_EQ(result["solver"]["status"], std::string(name) == "throwing_solver" ? "failed" : "not_finite");
  }
}

// One that breaks down now and then is helped over it, and the certificate has the word.
TEST(HostileSolver, ThatWorksOnceIsEnough) {
  const CommandRun run = plan(brace_with("Brace on a peg", "Brace"), {"--solver", "moody_solver"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = nlohmann::json::parse(run.out);
  EXPECT_EQ(result["status"], "solved");
  EXPECT_TRUE(result["certificate"]["failures"].empty());
}

TEST(HostileDirectory, ThatAnybodyCanChangeIsRefused) {
  const TemporaryDirectory directory;
  const std::string file = "tendril-solver-nan_solver.so";
  std::filesystem::copy_file(std::filesystem::path(HOSTILE_PLUGINS) / file, directory.path() / file);
  ASSERT_EQ(::chmod(directory.path().c_str(), 0777), 0);
  const CommandRun run =
      tendril({"plan", scene_path("brace.toml"), "--plugin-dir", directory.path().string(), "--solver", "nan_solver"});
  expect_refused(run, "refused, because others could have changed it");
}

}  // namespace
}  // namespace tendril::app
