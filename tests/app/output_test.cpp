// What the real command writes, and where.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;
using Names = std::vector<std::string>;

json plan_json(std::vector<std::string> arguments, int exit_code = 0) {
  arguments.insert(arguments.begin(), "plan");
  return json_of(std::move(arguments), exit_code);
}

TEST(Plan, OfTheBracedArmIsSolved) {
  const json result = plan_json({scene_path("brace.toml")});
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["status"], "solved");
  EXPECT_EQ(result["scene"], scene_path("brace.toml"));
  EXPECT_EQ(result["problem"], "pose");
  EXPECT_EQ(result["coordinates"]["name"], "legendre");
  EXPECT_EQ(result["coordinates"]["order"], 6);
  EXPECT_EQ(result["coordinates"]["dimension"], 12);
  EXPECT_EQ(result["coordinates"]["values"].size(), 12U);
  EXPECT_EQ(result["solver"]["name"], TENDRIL_TEST_SOLVER);
  ASSERT_EQ(result["moments"].size(), 1U);
  // The limit is a bound, kept to the certificate's tolerance.
  EXPECT_LE(std::abs(result["moments"][0].get<double>()), 2.5e-3 * (1.0 + 1e-9));
  ASSERT_EQ(result["contacts"].size(), 1U);
  EXPECT_GT(result["contacts"][0]["force"].get<double>(), 0.0);
  EXPECT_EQ(result["contacts"][0]["obstacle"], "obstacle 1");
  double sum = 0.0;
  for (const auto& [name, value] : result["terms"].items()) sum += value.get<double>();
  // Sums of the same terms, in another order.
  EXPECT_NEAR(sum, result["objective"].get<double>(), 1e-14 * std::max(1.0, sum));
  const json& end = result["backbone"].back();
  // Both are the same tip, scaled to SI once each.
  EXPECT_NEAR(end[1].get<double>(), result["tip"]["x"].get<double>(), 1e-12);
  EXPECT_NEAR(end[2].get<double>(), result["tip"]["y"].get<double>(), 1e-12);
  EXPECT_NEAR(result["target_error"].get<double>(),
              std::hypot(result["tip"]["x"].get<double>() - 0.097, result["tip"]["y"].get<double>() - 0.020), 1e-12);
  EXPECT_TRUE(result["certificate"]["failures"].empty());
}

TEST(Plan, OfEveryScene) {
  for (const char* name : {"free.toml", "avoid.toml", "reach_10Nmm.toml"}) {
    EXPECT_EQ(plan_json({scene_path(name)})["status"], "solved") << name;
  }
}

TEST(Plan, OfATargetOutOfReachTellsItsError) {
  const json result = plan_json({scene_path("free.toml"), "--set", "target.position=[0.3, 0]"});
  EXPECT_EQ(result["status"], "solved");
  // The rod is 0.1 m long, so 0.2 m are missing at least.
  EXPECT_GE(result["target_error"].get<double>(), 0.2);
}

TEST(Plan, ThatCannotBeIsStillWritten) {
  // No actuator of 2.5 N mm presses with 1000 N.
  const TemporaryDirectory directory;
  const json result =
      plan_json({scene_path("brace.toml"), "--set", "contact.mode=require", "--set", "contact.min_force=1000", "--set",
                 "contact.max_force=2000", "--output", directory / "out"},
                1);
  EXPECT_NE(result["status"], "solved");
  EXPECT_NE(result["message"], "");
  EXPECT_EQ(json::parse(read_file(directory / "out/result.json"))["status"], result["status"]);
}

TEST(Plan, WithoutAShapeHasNoFigure) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"plan", scene_path("brace.toml"), "--set", "solver.time_limit=1e-9", "--output",
                                  directory.path().string(), "--figure", directory / "f.svg"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(contains_text(run.err, "no figure: the plan came to no shape"));
  EXPECT_EQ(directory.names(), Names{"result.json"});
  EXPECT_EQ(json::parse(read_file(directory / "result.json"))["status"], "time_limit");
}

TEST(Plan, StartsFromAnEarlierResult) {
  const TemporaryDirectory directory;
  const json first = plan_json({scene_path("brace.toml"), "--output", directory / "out"});
  const json again = plan_json({scene_path("brace.toml"), "--start", directory / "out/result.json"});
  EXPECT_EQ(again["status"], "solved");
  // The same stationary point: both are accurate to the certificate's 1e-9 times a modest condition number, in metres.
  EXPECT_NEAR(again["tip"]["x"].get<double>(), first["tip"]["x"].get<double>(), 1e-8);
  EXPECT_NEAR(again["tip"]["y"].get<double>(), first["tip"]["y"].get<double>(), 1e-8);
}

TEST(Plan, SetsKeysOfTheScene) {
  const json result = plan_json({scene_path("brace.toml"), "--order", "8", "--no-split", "--set", "title=Another"});
  EXPECT_EQ(result["title"], "Another");
  EXPECT_EQ(result["coordinates"]["order"], 8);
  EXPECT_EQ(result["coordinates"]["split_at_contact"], false);
}

TEST(Plan, DropsOptionsThatAnotherPluginDoesNotKnow) {
  const CommandRun run = tendril({"plan", scene_path("free.toml"), "--coordinates", "pcc", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.err, "dropped option coordinates.order"));
  const json result = json::parse(run.out);
  EXPECT_EQ(result["coordinates"]["name"], "pcc");
  bool found = false;
  for (const json& item : result["left_out"])
    found = found || item["what"].get<std::string>().find("coordinates.order") != std::string::npos;
  EXPECT_TRUE(found) << result["left_out"];
}

TEST(Plan, PrintsATable) {
  const CommandRun run = tendril({"plan", scene_path("brace.toml")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* text :
       {"Brace on a peg", "status", "solved", "target error", "moment", "certificate", "stability", "time: read"}) {
    EXPECT_TRUE(contains_text(run.out, text)) << text;
  }
  EXPECT_EQ(run.err, "");
}

TEST(Output, HoldsResultAndFigure) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"plan", scene_path("brace.toml"), "--output", directory / "new/out", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_file(directory / "new/out/result.json"), run.out);
  Names names;
  for (const char* name : {"figure.dat", "figure.gnuplot", "figure.png", "figure.svg", "result.json"}) {
    EXPECT_TRUE(std::filesystem::exists(directory.path() / "new/out" / name)) << name;
  }
}

TEST(Output, WhereNothingCanBeWrittenIsRefusedAndLeavesNothing) {
  const TemporaryDirectory directory;
  const std::string file = directory.write("file", "kept");
  // Nobody, not even root, makes files in /proc.
  for (const std::string& place : {file, file + "/below", std::string("/proc/self")}) {
    const CommandRun run = tendril({"plan", scene_path("free.toml"), "--output", place});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(contains_text(run.err, "cannot write into '" + place + "'"));
  }
  EXPECT_EQ(read_file(file), "kept");
  EXPECT_EQ(directory.names(), Names{"file"});
}

TEST(Output, InTheWayOfADirectoryIsRefusedAndLeavesNothing) {
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory / "result.json");
  const CommandRun run = tendril({"plan", scene_path("free.toml"), "--output", directory.path().string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "it is a directory"));
  EXPECT_EQ(directory.names(), Names{"result.json"});
}

TEST(Figure, OfATitleFullOfCommandsRunsNone) {
  const TemporaryDirectory directory;
  const std::string witness = directory / "witness";
  const std::string scene = directory.write(
      "s.toml", brace_with("title = \"Brace on a peg\"", "title = \"`touch " + witness + "` ' . system('touch " +
                                                             witness + "') \\n!touch " + witness + "\""));
  const CommandRun run = tendril({"plan", scene, "--figure", directory / "it's `touch x`.svg"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(directory / "it's `touch x`.svg"));
  EXPECT_FALSE(std::filesystem::exists(witness));
  EXPECT_FALSE(std::filesystem::exists(directory / "x"));
}

CommandRun interrupted(int times, const std::string& output) {
  return tendril({"plan", scene_path("free.toml"), "--plugin-dir", TENDRIL_TEST_PLUGINS, "--solver", "patient", "--set",
                  "solver.options.interrupts=" + std::to_string(times), "--set", "solver.time_limit=60", "--output",
                  output});
}

TEST(Interrupt, EndsThePlanAndKeepsTheResult) {
  const TemporaryDirectory directory;
  const CommandRun run = interrupted(1, directory / "out");
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(json::parse(read_file(directory / "out/result.json"))["status"], "interrupted");
}

TEST(Interrupt, KillsTheSecondTimeAndLeavesNothing) {
  const TemporaryDirectory directory;
  const CommandRun run = interrupted(2, directory / "out");
  // The shell's code for a process that SIGINT has ended.
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(directory.names(), Names{});
}

TEST(Describe, GivesTheContract) {
  const json result = json_of({"describe", scene_path("brace.toml")});
  for (const json& variable : result["variables"]) {
    EXPECT_TRUE(variable["name"].is_string());
    EXPECT_TRUE(variable["count"].is_number_integer());
  }
  for (const json& row : result["rows"]) EXPECT_TRUE(row["kind"] == "equality" || row["kind"] == "inequality") << row;
  EXPECT_EQ(result["plugins"].size(), 4U);
  EXPECT_TRUE(result["left_out"].is_array());
}

TEST(Describe, LeavesOutWhatTheSceneDoesNotNeed) {
  const json result = json_of({"describe", scene_path("free.toml"), "--set", "objective.1.weight=0"});
  for (const json& variable : result["variables"])
    EXPECT_FALSE(contains_text(variable["name"].get<std::string>(), "contact"));
  // A term without weight is not even opened.
  for (const json& plugin : result["plugins"]) EXPECT_NE(plugin["name"], "actuation_effort");
}

TEST(Plugins, AreListedAsJson) {
  const json result = json_of({"plugins"});
  bool legendre = false;
  for (const json& plugin : result["plugins"]) {
    if (plugin["name"] != "legendre") continue;
    legendre = true;
    EXPECT_EQ(plugin["kind"], "coordinates");
    EXPECT_EQ(plugin["loadable"], true);
    EXPECT_EQ(plugin["options"][0]["name"], "order");
  }
  EXPECT_TRUE(legendre);
}

}  // namespace
}  // namespace tendril::app::test
