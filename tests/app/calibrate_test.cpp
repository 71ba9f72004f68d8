// `tendril calibrate`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;

/// The scene of the documentation, its file beside it, with one piece of text of either replaced.
CommandRun calibrate(std::vector<std::string> more, const std::string& old_text = "",
                     const std::string& new_text = "") {
  const TemporaryDirectory directory;
  std::string scene = read_file(scene_path("calibrate.toml"));
  std::string points = read_file(scene_path("calibrate.csv"));
  if (!old_text.empty()) {
    std::string& text = contains_text(scene, old_text) ? scene : points;
    EXPECT_TRUE(contains_text(text, old_text)) << old_text;
    text.replace(text.find(old_text), old_text.size(), new_text);
  }
  directory.write("calibrate.csv", points);
  more.insert(more.begin(), {"calibrate", directory.write("s.toml", scene)});
  return tendril(more);
}

// The points were made with 1.3e-8 N m/Pa, 5.2e-4 N m^2 and noise of 0.1 mm.
TEST(Calibrate, TheExampleFindsStiffnessAndLawOfPressure) {
  const json result = json_of({"calibrate", scene_path("calibrate.toml")});
  EXPECT_EQ(result["status"], "solved");
  ASSERT_EQ(result["numbers"].size(), 2U);
  const json& stiffness = result["numbers"][0];
  const json& moment = result["numbers"][1];
  EXPECT_EQ(stiffness["name"], "stiffness");
  EXPECT_NEAR(stiffness["value"].get<double>(), 1.3, 3.0 * stiffness["error"].get<double>());
  EXPECT_EQ(moment["unit"], "N m/Pa");
  EXPECT_NEAR(moment["value"].get<double>(), 1.3e-8, 3.0 * moment["error"].get<double>());
  EXPECT_NEAR(result["noise"].get<double>(), 1e-4, 3e-5);
  EXPECT_EQ(result["tip_errors"]["fitted"]["count"], 8);
  EXPECT_EQ(result["folds"], 5);
}

TEST(Calibrate, WritesAFragmentThatOtherScenesInclude) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"calibrate", scene_path("calibrate.toml"), "--output", directory / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "left out in turn"));
  EXPECT_TRUE(contains_text(read_file(directory / "out/figure.dat"), "0."));
  EXPECT_GT(read_file(directory / "out/figure.png").size(), 1000U);
  const std::string fragment = read_file(directory / "out/rod.toml");
  EXPECT_TRUE(contains_text(fragment, "# stiffness = 1.3")) << fragment;
  EXPECT_TRUE(contains_text(fragment, "pressure of actuator 1 2e+04 to 1.6e+05 Pa")) << fragment;
  // The fragment is the rod: a scene that includes it needs no other.
  const std::string scene = directory.write("scene.toml",
                                            "include = \"out/rod.toml\"\nproblem = \"execute\"\n"
                                            "gravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n");
  const json result = json_of({"execute", scene, "--pressures", "1e5"});
  const json fitted = json::parse(read_file(directory / "out/result.json"));
  EXPECT_EQ(result["status"], "solved");
  EXPECT_NEAR(result["moments"][0].get<double>(), 1e5 * fitted["numbers"][1]["value"].get<double>(), 1e-9);
  // Its numbers carry their error bars, and so does what comes of them.
  EXPECT_TRUE(contains_text(fragment, " +- ")) << fragment;
  EXPECT_GT(result["uncertainty"]["tip"]["y"].get<double>(), 0.0) << result["uncertainty"];
  EXPECT_EQ(result["uncertainty"]["shares"].size(), fitted["numbers"].size());
  // They go together: the moments that a pressure gives are known from how far a rod bends, as its stiffness is.
  EXPECT_TRUE(contains_text(fragment, "between = [\"rod.bending_stiffness\", \"rod.actuator[0].moment_per_pressure\"]"))
      << fragment;
}

TEST(Calibrate, TellsWhereInTheFilesSomethingIsWrong) {
  expect_refused(calibrate({}, "x [mm]", "x [kg]"), "calibrate.csv:2:");
  expect_refused(calibrate({}, "name = \"stiffness\"", "name = \"stifness\""), "did you mean 'stiffness'?");
  expect_refused(calibrate({}, "files = [\"calibrate.csv\"]", "files = [\"nowhere.csv\"]"), "nowhere.csv");
  expect_refused(calibrate({}, "pressure [kPa]", "nothing"), "found what 0 actuators was told");
  expect_refused(tendril({"calibrate", scene_path("brace.toml")}), "the scene has no [calibrate]");
}

TEST(Calibrate, TellsWhatItDidNotRead) {
  const CommandRun run = calibrate({}, "case,pressure", "humidity,pressure");
  EXPECT_TRUE(contains_text(run.out + run.err, "humidity")) << run.out << run.err;
}

}  // namespace
}  // namespace tendril::app::test
