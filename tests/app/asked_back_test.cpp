// What a user may not have meant is asked back, and what a shell user expects works: standard input, files of targets.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;

TEST(AskedBack, PlainAnglesOfManyTurns) {
  // Every key that takes an angle.
  for (const char* key : {"target.angle", "start.tip_angle", "rod.base.angle"}) {
    const CommandRun run = tendril({"plan", scene_path("free.toml"), "--json", "--set", std::string(key) + "=-90",
                                    "--set", "solver.time_limit=1"});
    EXPECT_NE(run.exit_code, 2) << run.err;
    EXPECT_TRUE(contains_text(run.err, std::string(key) + "=-90: found -90 rad, which is more than a turn and a half; "
                                                          "did you mean \"-90 deg\"?"))
        << run.err;
  }
  for (const char* value : {"9.4", "-9.4", "\"-90 deg\"", "\"720 deg\"", "\"90 rad\""}) {
    const CommandRun run =
        tendril({"describe", scene_path("free.toml"), "--set", std::string("target.angle=") + value});
    EXPECT_EQ(run.err, "") << value;
  }
}

TEST(AskedBack, AWholeNumberThatHasAFraction) {
  EXPECT_EQ(tendril({"plan", scene_path("brace.toml"), "--set", "coordinates.order=6.0"}).exit_code, 0);
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--set", "coordinates.order=6.5"}), "6.5");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--set", "contact.count=2.5"}), "2.5");
}

TEST(AskedBack, NoZeroHasASign) {
  const CommandRun run = tendril({"execute", scene_path("free.toml"), "--moments", "-0", "--set", "gravity=[0,0]"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find("-0 "), std::string::npos) << run.out;
  const CommandRun document =
      tendril({"execute", scene_path("free.toml"), "--moments", "-0", "--set", "gravity=[0,0]", "--json"});
  EXPECT_EQ(document.out.find("-0.0\n"), std::string::npos);
  EXPECT_EQ(document.out.find("-0.0,"), std::string::npos);
}

/// Runs a shell line in which TENDRIL is the command, in `directory`.
int shell(const TemporaryDirectory& directory, const std::string& line) {
  const std::string all = "cd '" + directory.path().string() + "' && TENDRIL='" + TENDRIL_COMMAND + "' && " + line;
  return std::system(all.c_str());  // NOLINT(concurrency-mt-unsafe)
}

TEST(StandardInput, IsAScene) {
  const TemporaryDirectory directory;
  directory.write("s.toml", read_file(scene_path("brace.toml")));
  for (const char* command : {"plan", "describe", "execute --moments '1 N mm'"}) {
    ASSERT_EQ(shell(directory, std::string("$TENDRIL ") + command + " - --json < s.toml > piped.json"), 0) << command;
    ASSERT_EQ(shell(directory, std::string("cat s.toml | $TENDRIL ") + command + " s.toml --json > file.json"), 0);
    const json piped = json::parse(read_file(directory / "piped.json"));
    const json file = json::parse(read_file(directory / "file.json"));
    ASSERT_TRUE(piped.contains("tip") || piped.contains("rows")) << command;
    for (const char* key : {"tip", "rows", "moments", "contacts"}) {
      EXPECT_EQ(piped.value(key, json()), file.value(key, json())) << command << ", " << key;
    }
  }
}

TEST(StandardInput, NamesItselfInMessages) {
  const TemporaryDirectory directory;
  EXPECT_NE(shell(directory, "echo 'lenght = 1' | $TENDRIL plan - 2> err"), 0);
  EXPECT_TRUE(contains_text(read_file(directory / "err"), "standard input:1:1: found the key 'lenght'"));
}

TEST(StandardInput, FindsFilesInTheCurrentDirectory) {
  const TemporaryDirectory directory;
  directory.write("estimate.csv", read_file(scene_path("estimate.csv")));
  directory.write("s.toml", read_file(scene_path("estimate.toml")));
  ASSERT_EQ(shell(directory, "cat s.toml | $TENDRIL plan - --json > out.json"), 0);
  EXPECT_EQ(json::parse(read_file(directory / "out.json"))["status"], "solved");
}

TEST(StandardInput, FeedsAStudyAndItsWorkers) {
  const TemporaryDirectory directory;
  directory.write("s.toml", read_file(scene_path("free.toml")) +
                                "\n[study]\ntargets = [[\"97 mm\", \"10 mm\"], [\"97 mm\", \"15 mm\"]]\n");
  ASSERT_EQ(shell(directory, "cat s.toml | $TENDRIL study - --jobs 2 --json > out.json 2> err"), 0)
      << read_file(directory / "err");
  EXPECT_EQ(json::parse(read_file(directory / "out.json"))["cases"].size(), 2U);
}

/// scenes/trajectory.toml with its targets in t.csv.
CommandRun plan_targets(const std::string& csv, bool as_json = true) {
  const TemporaryDirectory directory;
  directory.write("t.csv", csv);
  const std::string scene = R"(
problem = "trajectory"
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
[[rod.actuator]]
limit = "25 N mm"
[trajectory]
file = "t.csv"
[[objective]]
plugin = "tip_pose"
)";
  std::vector<std::string> words{"plan", directory.write("s.toml", scene)};
  if (as_json) words.emplace_back("--json");
  return tendril(words);
}

TEST(TrajectoryFile, TellsTargetsOutOfReach) {
  const CommandRun millimetres = plan_targets("98,10\n97,15\n", false);
  EXPECT_TRUE(contains_text(millimetres.out,
                            "2 of 2 targets lie out of reach, by up to 9.84e+04 % of the length: are "
                            "they in mm? A plain number is in m"))
      << millimetres.out;
  const CommandRun far = plan_targets("0.098,0.01\n0.12,0\n", false);
  EXPECT_TRUE(contains_text(far.out, "1 of 2 targets lie out of reach, by up to 20 % of the length\n")) << far.out;
  EXPECT_FALSE(contains_text(plan_targets("0.098,0.01\n0.1,0\n", false).out, "out of reach"));
}

TEST(TrajectoryFile, HoldsTargets) {
  const CommandRun both = plan_targets("\xef\xbb\xbfx [mm];y [mm];Angle [deg]\r\n99;5;6\r\n98;10;12\r\n;;\r\n");
  ASSERT_EQ(both.exit_code, 0) << both.err;
  const json steps = json::parse(both.out)["steps"];
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_NEAR(steps[1]["target"]["position"][1].get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(steps[1]["target"]["angle"].get<double>(), 0.20943951, 1e-8);
  EXPECT_TRUE(contains_text(both.err, "1 of the 3 rows of t.csv"));
  EXPECT_EQ(json::parse(plan_targets("0.099, 0.005\n0.098, 0.01\n0.097, 0.015\n").out)["steps"].size(), 3U);
  EXPECT_EQ(json::parse(plan_targets("angle [deg]\n10\n20\n").out)["steps"].size(), 2U);
  expect_refused(plan_targets("x [mm],y [mm]\n99,five\n"), "t.csv:2:4: found \"five\", expected a length");
  expect_refused(plan_targets("x [mm],z\n99,5\n"), "expected x, y or x, y, angle or angle");
  expect_refused(plan_targets("x,y\n"), "t.csv: found no points");
}

/// A plan whose [start] is `start`, with p.csv beside it.
CommandRun plan_from(const std::string& start, const std::string& csv = {}) {
  const TemporaryDirectory directory;
  directory.write("p.csv", csv);
  const std::string scene = R"(
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
[[rod.actuator]]
limit = "25 N mm"
[target]
position = ["80 mm", "50 mm"]
[[objective]]
plugin = "tip_pose"
[start]
)" + start;
  return tendril({"plan", directory.write("s.toml", scene), "--json"});
}

TEST(StartFile, HoldsPointsOfTheStart) {
  const CommandRun run = plan_from("file = \"p.csv\"", "x [mm];y [mm]\n50;10\n80;45\n;\n");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.err, "1 of the 3 rows of p.csv"));
  const CommandRun listed = plan_from("points = [[\"50 mm\", \"10 mm\"], [\"80 mm\", \"45 mm\"]]");
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_EQ(json::parse(run.out)["coordinates"], json::parse(listed.out)["coordinates"]);
  expect_refused(plan_from("file = \"q.csv\""), "q.csv");
  expect_refused(plan_from("file = \"p.csv\"", "x,y\n1,up\n"), "p.csv:2:3: found \"up\", expected a length");
  expect_refused(plan_from("file = \"p.csv\"\ntip_angle = 1", "x,y\n0.1,0\n"), "found 'tip_angle' beside points");
  expect_refused(plan_from("file = \"p.csv\"\npoints = [[1, 2]]", "x,y\n0.1,0\n"), "found 'file' beside 'points'");
}

}  // namespace
}  // namespace tendril::app::test
