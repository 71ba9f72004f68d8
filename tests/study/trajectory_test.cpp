// Trajectories of more than forty steps: every step certified, the warm start's gain counted, contacts that come and
// go.

#include <gtest/gtest.h>

#include <cmath>

#include "support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/app/session.hpp"

namespace tendril::app {
namespace {

using test::read_file;
using test::replaced;
using test::scene_path;
using test::TemporaryDirectory;
using test::tendril;

/// scenes/trajectory.toml with this actuator limit, its targets on an arc of radius 98.5 mm between two heights.
std::string arc(double from, double to, int steps, const std::string& limit) {
  const std::string text = read_file(scene_path("trajectory.toml"));
  const std::size_t begin = text.find("positions = [");
  const std::size_t end = text.find("]\n\n", begin);
  std::string points = "positions = [";
  for (int i = 0; i < steps; ++i) {
    const double y = from + (to - from) * i / (steps - 1);
    points += "[" + std::to_string(std::sqrt(98.5 * 98.5 - y * y) / 1e3) + ", " + std::to_string(y / 1e3) + "],";
  }
  return replaced(text.substr(0, begin) + points + text.substr(end), "\"2.5 N mm\"", limit);
}

Trajectory plan(const std::string& text, Session*& session) {
  const TemporaryDirectory directory;
  static std::unique_ptr<Session> owner;
  owner = std::make_unique<Session>(SceneArguments{directory.write("s.toml", text), {}, {}});
  session = owner.get();
  return session->plan_trajectory();
}

class TrajectoryMode : public testing::TestWithParam<const char*> {};

TEST_P(TrajectoryMode, LosesNoStep) {
  const test::CommandRun run =
      tendril({"plan", scene_path("trajectory.toml"), "--json", "--set", std::string("contact.mode=") + GetParam()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["problem"], "trajectory");
  ASSERT_EQ(json["steps"].size(), 45U);
  for (const auto& step : json["steps"]) {
    EXPECT_EQ(step["status"], "solved");
    EXPECT_TRUE(step["certificate"]["failures"].empty());
  }
  // Newton alone does nearly all steps, and all of them together take far less than from cold starts.
  const auto& warm = json["effort"];
  const auto& cold = json["cold_starts"];
  EXPECT_LE(5U * warm["solver_calls"].get<unsigned>(), json["steps"].size());
  EXPECT_LT(2 * warm["evaluations"]["values"].get<int>(), cold["evaluations"]["values"].get<int>());
}

INSTANTIATE_TEST_SUITE_P(Modes, TrajectoryMode, testing::Values("ignore", "avoid", "allow"));

TEST(Trajectory, ThatRequiresContactKeepsItsForce) {
  const test::CommandRun run = tendril({"plan", scene_path("trajectory.toml"), "--json", "--set",
                                        "contact.mode=require", "--set", "contact.min_force=100 mN"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["steps"].size(), 45U);
  for (const auto& step : json["steps"]) {
    ASSERT_EQ(step["contacts"].size(), 1U);
    EXPECT_GE(step["contacts"][0]["force"].get<double>(), 0.1 * (1.0 - 1e-9));
  }
}

/// With 10 N mm the arm can lift itself off the peg: on the way up a contact is lost, on the way down one is made.
/// Every step must be as good as a plan that knows nothing of the steps before.
TEST(Trajectory, NoticesContactsThatComeAndGo) {
  for (const auto& [from, to] : {std::pair(8.0, 38.0), std::pair(38.0, 8.0)}) {
    Session* session = nullptr;
    const Trajectory t = plan(arc(from, to, 45, "\"10 N mm\""), session);
    ASSERT_EQ(t.steps.size(), 45U);
    EXPECT_TRUE(t.solved());
    int changes = 0;
    int calls_while_unchanged = 0;
    for (std::size_t i = 0; i < t.steps.size(); ++i) {
      const bool changed = i > 0 && t.steps[i].plan.contacts.empty() != t.steps[i - 1].plan.contacts.empty();
      changes += changed ? 1 : 0;
      if (i > 0 && !changed) calls_while_unchanged += t.steps[i].effort.solver_calls;
      session->problem().set_target(t.steps[i].target);
      const Plan alone = session->plan_from(nullptr);
      ASSERT_EQ(alone.status, PlanStatus::solved);
      // Both are stationary points to 1e-6 of the gradient; objectives differ by less than its square.
      EXPECT_LE(t.steps[i].plan.objective, alone.objective + 1e-9) << "step " << i + 1;
    }
    EXPECT_EQ(changes, 1);
    EXPECT_EQ(calls_while_unchanged, 0);
  }
}

TEST(Trajectory, GivesTheSameUnsplit) {
  const test::CommandRun run =
      tendril({"plan", scene_path("trajectory.toml"), "--json", "--no-split", "--set", "trajectory.cold_starts=false"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["steps"].size(), 45U);
  EXPECT_FALSE(json.contains("cold_starts"));
}

TEST(Trajectory, DrawsAFigureAndATable) {
  const TemporaryDirectory directory;
  const test::CommandRun run = tendril(
      {"plan", scene_path("trajectory.toml"), "--output", directory / "out", "--set", "trajectory.cold_starts=false"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "45 of 45 steps solved"));
  for (const char* name : {"result.json", "figure.svg", "figure.png", "figure.dat", "figure.gnuplot"}) {
    EXPECT_GT(read_file(directory / ("out/" + std::string(name))).size(), 1000U) << name;
  }
}

struct WrongPath {
  const char* old_text;
  const char* new_text;
  const char* message;
};

TEST(Trajectory, RefusesInputThatMakesNoSense) {
  const std::string good = arc(8.0, 10.0, 3, "\"2.5 N mm\"");
  const TemporaryDirectory directory;
  for (const WrongPath& wrong :
       {WrongPath{"positions = [", "positions = [[1, 2, 3], ",
                  "found a list of 3 entries, expected a list of two entries"},
        WrongPath{"positions = [", "positions = [[\"1 N\", 2], ", "found \"1 N\""},
        WrongPath{"positions = [", "positions = [[nan, 2], ", "found the number nan"},
        WrongPath{"cold_starts = true", "angles = [1, 2]", "found 2 angles for 3 positions"},
        WrongPath{"cold_starts = true", "replan_every = -1", "expected a whole number from 0"},
        WrongPath{"cold_starts = true", "cold_start = true", "did you mean 'cold_starts'?"},
        WrongPath{"[start]", "[target]\nposition = [1, 2]\n[start]", "expected no [target] beside it"},
        WrongPath{"\"trajectory\"", "\"pose\"", "[trajectory] needs problem = \"trajectory\""}}) {
    const test::CommandRun run =
        tendril({"plan", directory.write("s.toml", replaced(good, wrong.old_text, wrong.new_text))});
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_TRUE(contains_text(run.err, wrong.message));
    EXPECT_TRUE(contains_text(run.err, "s.toml:"));
  }
  const test::CommandRun empty =
      tendril({"plan", scene_path("brace.toml"), "--set", "problem=trajectory", "--set", "target.x=1"});
  EXPECT_EQ(empty.exit_code, 2);
  const test::CommandRun none = tendril({"plan", scene_path("brace.toml"), "--set", "problem=trajectory"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_TRUE(contains_text(none.err, "needs targets in [trajectory]"));
}

}  // namespace
}  // namespace tendril::app
