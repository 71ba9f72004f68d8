// Obstacles that are elsewhere in each case of a study or at each step of a trajectory.

#include <gtest/gtest.h>

#include <cmath>

#include "support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril::app {
namespace {

using nlohmann::json;
using test::read_file;
using test::replaced;
using test::scene_path;
using test::TemporaryDirectory;
using test::tendril;

std::string brace() { return read_file(scene_path("brace.toml")); }

/// brace.toml with its peg shifted by its own options, planned.
json plan_with_peg_at(const TemporaryDirectory& directory, double x_mm, double y_mm) {
  const std::string there = "[\"" + std::to_string(60.0 + x_mm) + " mm\", \"" + std::to_string(y_mm) + " mm\"]";
  const std::string scene =
      directory.write("there.toml", replaced(brace(), "center = [\"60 mm\", \"0 mm\"]", "center = " + there));
  const test::CommandRun run = tendril({"plan", scene, "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return json::parse(run.out);
}

TEST(MovingObstacle, OfASceneIsWhatItsOptionsCouldHaveSaid) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write(
      "s.toml", replaced(brace(), "radius = \"8 mm\"", "radius = \"8 mm\"\nshift = [\"1 mm\", \"-2 mm\"]"));
  const test::CommandRun run = tendril({"plan", scene, "--json", "--verify"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json moved = json::parse(run.out);
  const json there = plan_with_peg_at(directory, 1.0, -2.0);
  EXPECT_NEAR(moved["objective"], there["objective"], 1e-12);
  EXPECT_NEAR(moved["contacts"][0]["force"], there["contacts"][0]["force"], 1e-11);
  EXPECT_EQ(moved["obstacles"][0]["shift"], json({1e-3, -2e-3}));
}

// A quarter turn about a point 20 mm below its centre takes the peg there and 20 mm to the left.
TEST(MovingObstacle, TurnsAboutItsPivot) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write(
      "s.toml",
      replaced(replaced(brace(), "center = [\"60 mm\", \"0 mm\"]", "center = [\"80 mm\", \"20 mm\"]"),
               "radius = \"8 mm\"",
               "radius = \"8 mm\"\npivot = [\"80 mm\", \"0 mm\"]\nturn = \"90 deg\"\nshift = [0, \"-2 mm\"]"));
  const std::string out = directory / "out";
  const test::CommandRun run = tendril({"plan", scene, "--json", "--output", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json turned = json::parse(run.out);
  EXPECT_NEAR(turned["objective"], plan_with_peg_at(directory, 0.0, -2.0)["objective"], 1e-12);
  EXPECT_EQ(turned["obstacles"][0]["pivot"], json({0.08, 0.0}));
  EXPECT_GT(read_file(out + "/figure.svg").size(), 1000U);
  // So do the turns of a trajectory.
  const std::string steps = directory.write(
      "t.toml", replaced(replaced(read_file(scene), "problem = \"pose\"", "problem = \"trajectory\""),
                         "turn = \"90 deg\"\n", "") +
                    "[[trajectory.obstacle]]\nname = \"obstacle 1\"\nturns = [\"60 deg\", \"90 deg\"]\n");
  const test::CommandRun carried = tendril({"plan", steps, "--json", "--verify"});
  ASSERT_EQ(carried.exit_code, 0) << carried.err;
  EXPECT_NEAR(json::parse(carried.out)["steps"][1]["objective"], turned["objective"], 1e-9);
}

TEST(MovingObstacle, OfAStudyIsSweptAndDrawn) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", brace() + R"(
[study.obstacle]
name = "obstacle 1"
shifts = [["0 mm", "0 mm"], ["1 mm", "-2 mm"], ["-3 mm", "1 mm"]]
)");
  const std::string out = directory / "out";
  const test::CommandRun run = tendril({"study", scene, "--json", "--output", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json study = json::parse(run.out);
  ASSERT_EQ(study["cases"].size(), 3U);
  for (const json& one : study["cases"]) {
    const json& moved = one["moved_obstacles"][0];
    EXPECT_EQ(moved["obstacle"], "obstacle 1");
    const json there =
        plan_with_peg_at(directory, 1e3 * moved["shift"][0].get<double>(), 1e3 * moved["shift"][1].get<double>());
    EXPECT_NEAR(one["plan"]["objective"], there["objective"], 1e-12);
  }
  EXPECT_TRUE(contains_text(read_file(out + "/cases.csv"), "shift_x_m,shift_y_m"));
  EXPECT_GT(read_file(out + "/figure.svg").size(), 1000U);
}

TEST(MovingObstacle, OfATrajectoryIsPlannedExecutedAndDrawnStepByStep) {
  const TemporaryDirectory directory;
  const std::string scene =
      directory.write("s.toml", replaced(brace(), "problem = \"pose\"", "problem = \"trajectory\"") + R"(
[[trajectory.obstacle]]
name = "obstacle 1"
shifts = [["0 mm", "0 mm"], ["0.5 mm", "-0.5 mm"], ["1 mm", "-1 mm"], ["1.5 mm", "-1.5 mm"]]
)");
  const std::string out = directory / "out";
  const test::CommandRun run = tendril({"plan", scene, "--json", "--verify", "--output", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json planned = json::parse(run.out);
  ASSERT_EQ(planned["steps"].size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const json& step = planned["steps"][i];
    const double shift = 0.5 * static_cast<double>(i);
    EXPECT_EQ(step["method"], i == 0 ? "solved" : "followed");
    EXPECT_NEAR(step["objective"], plan_with_peg_at(directory, shift, -shift)["objective"], 1e-9);
    EXPECT_LT(step["model_error"].get<double>(), 1e-8);
    EXPECT_NEAR(step["moved_obstacles"][0]["shift"][0], 1e-3 * shift, 1e-15);
  }
  // What was planned can be carried out from its result.
  const test::CommandRun carried = tendril({"execute", scene, "--plan", out + "/result.json", "--json"});
  ASSERT_EQ(carried.exit_code, 0) << carried.err;
  const json reached = json::parse(carried.out);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(reached["steps"][i]["tip"]["x"], planned["steps"][i]["tip"]["x"], 1e-8);
    EXPECT_NEAR(reached["steps"][i]["contacts"][0]["force"], planned["steps"][i]["contacts"][0]["force"], 1e-6);
  }
  EXPECT_GT(read_file(out + "/figure.svg").size(), 1000U);
}

/// Steps of an execution that holds 1 N mm while the obstacle of a planned trajectory goes `way` (mm) up from -8 mm, in
/// so many steps.
json carried_up(const TemporaryDirectory& directory, const std::string& scene, const std::string& planned, double way,
                int steps) {
  json held = json::parse(read_file(planned + "/result.json"));
  json first = held["steps"][0];
  first["moments"] = {1e-3};
  held["steps"] = json::array();
  for (int i = 0; i <= steps; ++i) {
    json& step = held["steps"].emplace_back(first);
    step["moved_obstacles"][0]["shift"][1] = 1e-3 * (-8.0 + way * i / steps);
  }
  const test::CommandRun run =
      tendril({"execute", scene, "--plan", directory.write("held.json", held.dump()), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return json::parse(run.out)["steps"];
}

// A peg that is pushed across the rod by three times its size in one step takes the rod along, as it does in small
// ones.
TEST(MovingObstacle, IsLedAlongWhereOneStepIsFar) {
  const TemporaryDirectory directory;
  const std::string scene =
      directory.write("s.toml", replaced(replaced(brace(), "problem = \"pose\"", "problem = \"trajectory\""),
                                         "radius = \"8 mm\"", "radius = \"4 mm\"") +
                                    R"(
[[trajectory.obstacle]]
name = "obstacle 1"
shifts = [["0 mm", "-8 mm"], ["0 mm", "16 mm"]]
)");
  const std::string out = directory / "out";
  ASSERT_EQ(tendril({"plan", scene, "--output", out}).exit_code, 0);
  const auto carried = [&](int steps) { return carried_up(directory, scene, out, 24.0, steps).back(); };
  const json far = carried(1);
  const json near = carried(12);
  EXPECT_NEAR(far["tip"]["y"], near["tip"]["y"], 1e-7);
  ASSERT_EQ(far["contacts"].size(), 1U);
  EXPECT_GT(far["contacts"][0]["normal"][1].get<double>(), 0.5);
}

// A peg near the tip that is pushed up until the rod slips off it: told once, at the same place, whether it is led
// there in one step or moved in steps that are as short.
TEST(MovingObstacle, TellsWhereTheRodSnapsWhileItIsLed) {
  const TemporaryDirectory directory;
  std::string text = replaced(brace(), "problem = \"pose\"", "problem = \"trajectory\"");
  text = replaced(replaced(text, "radius = \"8 mm\"", "radius = \"4 mm\""), "[\"60 mm\"", "[\"85 mm\"");
  const std::string scene = directory.write(
      "s.toml", text + "[[trajectory.obstacle]]\nname = \"obstacle 1\"\nshifts = [[0, \"-8 mm\"], [0, \"72 mm\"]]\n");
  const std::string out = directory / "out";
  (void)tendril({"plan", scene, "--output", out});
  const auto carried = [&](int steps) { return carried_up(directory, scene, out, 80.0, steps); };
  const json far = carried(1);
  ASSERT_EQ(far[1]["snaps"].size(), 1U);
  const json near = carried(80);
  std::vector<double> places;
  for (std::size_t i = 1; i < near.size(); ++i) {
    for (const json& snap : near[i]["snaps"]) {
      places.push_back((static_cast<double>(i) - 1.0 + snap["load"].get<double>()) / 80.0);
      EXPECT_EQ(snap["kind"], far[1]["snaps"][0]["kind"]);
    }
  }
  ASSERT_EQ(places.size(), 1U);
  // Each stretch says which of its shapes was left, so to the length of one.
  EXPECT_NEAR(far[1]["snaps"][0]["load"], places[0], 1.0 / 80.0);
}

TEST(MovingObstacle, RefusesWhatMakesNoSense) {
  const TemporaryDirectory directory;
  const std::string trajectory = replaced(brace(), "problem = \"pose\"", "problem = \"trajectory\"");
  const auto expect_refused = [&](const std::string& text, const std::string& reason) {
    const test::CommandRun run = tendril({"plan", directory.write("s.toml", text), "--json"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_TRUE(contains_text(run.err, reason));
  };
  expect_refused(trajectory + "[[trajectory.obstacle]]\nname = \"obstacle l\"\nturns = [0.0]\n",
                 "found 'obstacle l', expected the name of an obstacle; did you mean 'obstacle 1'?");
  expect_refused(trajectory + "[[trajectory.obstacle]]\nname = \"obstacle 1\"\n",
                 "found neither 'shifts' nor 'turns', expected one of them");
  expect_refused(trajectory + "[[trajectory.obstacle]]\nname = \"obstacle 1\"\nturns = [0.0, 0.1]\nshifts = [[0, 0]]\n",
                 "found 1 shifts for 2 steps, expected one for each");
  const test::CommandRun run = tendril(
      {"study", directory.write("s.toml", brace() + "[study.obstacle]\nname = \"peg\"\nturns = [0.0]\n"), "--json"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "found 'peg', expected the name of an obstacle"));
}

}  // namespace
}  // namespace tendril::app
