// How every command ends: 0 solved, 1 no acceptable result, 2 wrong input; and the status that says so, the same in the
// report and in JSON.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

/// A rod that stands upright under its own weight, of length and stiffness 1.
std::string column(const char* weight) {
  return std::string("problem = \"execute\"\ngravity = [0, -1]\n[rod]\nlength = 1\nbending_stiffness = 1\n") +
         "base = {angle = \"90 deg\"}\nlinear_density = " + weight + "\n";
}

/// A heavy upright rod: under up to 25 N mm it stays on the side on which it is, and may be planned on the other.
const char* const two_sides = R"(
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[rod]
length = "200 mm"
bending_stiffness = "0.01 N m^2"
linear_density = "1.5290519877675841 kg/m"
base = {angle = "90 deg"}
[[rod.actuator]]
limit = "25 N mm"
[start]
tip_angle = "-1 rad"
[target]
position = ["-130 mm", "130 mm"]
[[objective]]
plugin = "tip_pose"
[solver]
plugin = ")" TENDRIL_TEST_SOLVER "\"\n";

/// Its first step is within reach, the second one needs more force on the peg than there may be.
std::string short_path(const char* mode) {
  const std::string text = brace_with("\"pose\"", "\"trajectory\"");
  const std::string target = "[target]\nposition = [\"97 mm\", \"20 mm\"]";
  std::string path = text;
  path.replace(path.find(target), target.size(), "[trajectory]\npositions = [[0.0985, 0.008], [0.0984, 0.009]]");
  return path.replace(path.find("mode = \"allow\""), 14, mode);
}

struct Ending {
  const char* name;
  Words words;  ///< "SCENE" stands for a file with this scene, "DIR" for a directory of its own
  std::string scene;
  int exit_code;
  const char* status;       ///< in JSON and in the report
  const char* reason = "";  ///< part of the message, in both
};
void PrintTo(const Ending& ending, std::ostream* out) { *out << ending.name; }

class Ends : public testing::TestWithParam<Ending> {
 protected:
  CommandRun run(bool as_json) {
    Words words = GetParam().words;
    for (std::string& word : words) {
      if (word == "SCENE") word = directory_.write("s.toml", GetParam().scene);
    }
    if (as_json) words.emplace_back("--json");
    return tendril(words);
  }
  TemporaryDirectory directory_;
};

TEST_P(Ends, WithItsCodeAndTheSameStatusInBothForms) {
  const Ending& ending = GetParam();
  const CommandRun as_json = run(true);
  const CommandRun report = run(false);
  EXPECT_EQ(as_json.exit_code, ending.exit_code) << as_json.err;
  EXPECT_EQ(report.exit_code, ending.exit_code) << report.err;
  const json result = json::parse(as_json.out, nullptr, false);
  ASSERT_FALSE(result.is_discarded()) << as_json.out << as_json.err;
  EXPECT_EQ(result["status"], ending.status);
  std::string reasons = result.value("message", "");
  for (const char* parts : {"steps", "cases"}) {
    for (const json& part : result.value(parts, json::array())) reasons += '\n' + part.value("message", "");
  }
  EXPECT_NE(reasons.find(ending.reason), std::string::npos) << reasons;
  EXPECT_NE(report.out.find(ending.reason), std::string::npos) << report.out;
  if (result.contains("steps") || result.contains("cases")) return;
  EXPECT_NE(report.out.find("\nstatus         " + std::string(ending.status) + "\n"), std::string::npos) << report.out;
}

const Words plan{"plan", "SCENE"};
Words plan_with(const char* solver, const char* setting) {
  return {"plan", "SCENE", "--plugin-dir", TENDRIL_TEST_PLUGINS, "--solver", solver, "--set", setting};
}

std::vector<Ending> endings() {
  const std::string brace = read_file(scene_path("brace.toml"));
  const std::string grasp = read_file(scene_path("grasp_60mm.toml"));
  const std::string pressed = brace_with("mode = \"allow\"", "mode = \"require\"\nmin_force = \"0.9 N\"");
  std::string far = brace_with("mode = \"allow\"", "mode = \"require\"\nmin_force = \"0.1 N\"");
  far.replace(far.find("60 mm"), 5, "600 mm");
  // A finger that reaches around an object as large as this is sharpened from no start.
  Words large = plan_with("scripted", "solver.options.status=diverged");
  large.insert(large.end(), {"--set", "gripper.object_diameter=90 mm"});
  const std::string study = "\n[study]\nlimits = [\"2.5 N mm\", \"3 N mm\"]\n";
  return {
      {"plan_solved", plan, brace, 0, "solved"},
      {"plan_infeasible", plan, pressed, 1, "infeasible", "from 5 starts per mode"},
      {"plan_infeasible_by_a_bound", plan, far, 1, "infeasible", "out of reach"},
      {"plan_out_of_time", {"plan", "SCENE", "--set", "solver.time_limit=1e-9"}, brace, 1, "time_limit", "time limit"},
      {"plan_interrupted", plan_with("patient", "solver.time_limit=60"), read_file(scene_path("free.toml")), 1,
       "interrupted", "interrupted before"},
      {"plan_failed", plan_with("scripted", "solver.options.status=failed"), brace, 1, "failed",
       "as its option says; solver 'scripted' ended every solve as failed"},
      {"plan_not_certified", large, grasp, 1, "not_converged", "is above 1e-06"},
      {"plan_refuted_by_its_contacts",
       {"plan", "SCENE", "--verify"},
       read_file(scene_path("avoid.toml")),
       1,
       "not_converged",
       "the plan rests on no obstacle, execution on 'obstacle 1'"},
      {"plan_refuted_by_its_tip",
       {"plan", "SCENE", "--verify"},
       two_sides,
       1,
       "not_converged",
       "execution does not confirm the plan: the tip ends elsewhere"},
      {"plan_of_two_sides_alone", plan, two_sides, 0, "solved"},
      {"grasp_solved", plan, grasp, 0, "solved"},
      {"trajectory_solved", plan, short_path("mode = \"allow\""), 0, "solved"},
      {"trajectory_with_steps_that_cannot_be", plan, short_path("mode = \"require\"\nmin_force = \"0.9 N\""), 1,
       "infeasible"},
      {"execute_solved", {"execute", "SCENE", "--moments", "2.5 N mm"}, brace, 0, "solved"},
      {"execute_not_converged", {"execute", "SCENE", "--moments", "-200 N mm"}, brace, 1, "not_converged"},
      {"execute_out_of_time",
       {"execute", "SCENE", "--moments", "1 N mm", "--set", "solver.time_limit=1e-9"},
       brace,
       1,
       "time_limit"},
      // It buckles at 7.83734744 EI/L^3 (Greenhill: 9/4 of the square of the first zero of J_-1/3); 1.8e-7 below the
      // margin of stability is that share of it, less than the 1e-6 that is asked for.
      {"execute_unstable",
       {"execute", "SCENE", "--moments", ""},
       column("7.837346"),
       1,
       "unstable",
       "the stability margin is 1.8"},
      {"execute_just_stable", {"execute", "SCENE", "--moments", ""}, column("7.8373"), 0, "solved"},
      {"study_solved", {"study", "SCENE"}, brace + study, 0, "solved"},
      {"study_with_a_case_that_is_not",
       {"study", "SCENE"},
       pressed + "\n[study]\nmodes = [\"allow\", \"require\"]\n",
       1,
       "some cases are not solved",
       "infeasible"},
  };
}

INSTANTIATE_TEST_SUITE_P(Commands, Ends, testing::ValuesIn(endings()),
                         [](const auto& each) { return std::string(each.param.name); });

struct Code {
  Words words;
  int exit_code;
  const char* out;  ///< part of standard output, or of standard error where the code is 2
};

/// Commands that plan nothing.
TEST(Exit, OfWhatPlansNothing) {
  const std::string brace = scene_path("brace.toml");
  const TemporaryDirectory directory;
  for (const Code& code : {Code{{"--help"}, 0, "plan"},
                           Code{{"--version"}, 0, "."},
                           Code{{}, 2, "see 'tendril --help'"},
                           Code{{"describe", brace}, 0, "equilibrium"},
                           Code{{"describe", brace, "--json"}, 0, "\"variables\""},
                           Code{{"describe", brace, "--set", "rod.length=1 N"}, 2, "--set rod.length=1 N: found"},
                           Code{{"describe", scene_path("none.toml")}, 2, "No such file"},
                           Code{{"plugins"}, 0, "legendre"},
                           Code{{"plugins", "--jsn"}, 2, "did you mean '--json'?"},
                           Code{{"plugins", "--plugin-dir", directory / "none"}, 0, "No such file"},
                           Code{{"new", "objective", "level_tip", directory / "level_tip"}, 0, "level_tip"},
                           Code{{"new", "objective", "level_tip", directory / "level_tip"}, 2, "level_tip"},
                           Code{{"new", "objectiv", "a", directory / "a"}, 2, "did you mean 'objective'?"},
                           Code{{"new", "objective", "tip_pose", directory / "a"}, 2, "is taken"},
                           Code{{"reference", "keys"}, 0, "bending_stiffness"},
                           Code{{"reference", "man"}, 0, ".TH"},
                           Code{{"reference", "bash"}, 0, "complete"},
                           Code{{"reference", "key"}, 2, "did you mean 'keys'?"},
                           Code{{"plan", scene_path("trajectory.toml"), "--start", brace}, 2, "expected no --start"},
                           Code{{"plan", scene_path("estimate.toml"), "--start", brace}, 2, "expected no --start"},
                           Code{{"execute", scene_path("grasp_60mm.toml"), "--moments", "0, 0"}, 2, "palm_distance"},
                           Code{{"study", brace}, 2, "the scene has no [study]"}}) {
    const CommandRun run = tendril(code.words);
    std::string line;
    for (const std::string& word : code.words) line += word + ' ';
    EXPECT_EQ(run.exit_code, code.exit_code) << line << run.err;
    const std::string& said = code.exit_code == 2 ? run.err : run.out;
    EXPECT_NE(said.find(code.out), std::string::npos) << line << run.out << run.err;
    if (code.exit_code == 2) {
      EXPECT_EQ(run.out, "") << line;
    } else {
      EXPECT_EQ(run.err, "") << line;
    }
  }
}

/// A search that time ended: still a certified plan, but no success to those who ask for a whole search.
TEST(CutShort, IsSaidAndIsNoSuccessWithStrict) {
  for (const char* limit : {"2 ms", "20 ms", "60 ms"}) {
    SCOPED_TRACE(limit);
    const Words words{"plan", scene_path("clutter.toml"), "--set", "solver.time_limit=\"" + std::string(limit) + "\""};
    Words strict = words;
    strict.insert(strict.end(), {"--strict", "--json"});
    const CommandRun run = tendril(strict);
    const json result = json::parse(run.out);
    EXPECT_TRUE(result.value("search_cut", false));
    EXPECT_EQ(run.exit_code, 1);
    const CommandRun told = tendril(words);
    const bool solved = contains_text(told.out, "status         solved");
    EXPECT_EQ(told.exit_code, solved ? 0 : 1);
    EXPECT_TRUE(
        contains_text(told.out, solved ? "solved, but time ended the search before it was done" : "the time limit of"))
        << told.out;
  }
}

}  // namespace
}  // namespace tendril::app::test
