// The command `study`: numbers that do not depend on how they were computed, and cases that go wrong.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <set>

#include "support.hpp"
#include "support/contains.hpp"

namespace tendril::app {
namespace {

using test::expect_same_files;
using test::read_file;
using test::replaced;
using test::scene_path;
using test::small_study;
using test::TemporaryDirectory;
using test::tendril;

TEST(Study, GivesTheSameFilesForAnyNumberOfWorkers) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study());
  const test::CommandRun one = tendril({"study", scene, "--output", directory / "one"});
  const test::CommandRun two = tendril({"study", scene, "--jobs", "2", "--output", directory / "two"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(two.exit_code, 0) << two.err;
  EXPECT_EQ(one.out, two.out);
  // No terminal, no progress.
  EXPECT_EQ(one.err, "");
  expect_same_files(directory / "one", directory / "two");
}

TEST(Study, WritesEveryCaseOnceWithItsCertificate) {
  const TemporaryDirectory directory;
  const test::CommandRun run = tendril({"study", directory.write("s.toml", small_study()), "--jobs", "2", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["schema"], 1);
  ASSERT_EQ(json["cases"].size(), 24U);
  EXPECT_EQ(json["groups"].size(), 6U);
  for (std::size_t i = 0; i < 24; ++i) {
    const auto& one = json["cases"][i];
    EXPECT_EQ(one["index"], i);
    EXPECT_EQ(one["status"], "solved");
    EXPECT_TRUE(one["plan"]["certificate"]["failures"].empty());
    EXPECT_LE(std::abs(one["moments"][0].get<double>()), one["limit"].get<double>() * (1.0 + 1e-9));
  }
  // The groups' means are those of their cases.
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += json["cases"][i]["tip_error"].get<double>();
  EXPECT_NEAR(json["groups"][0]["tip_error"]["mean"].get<double>(), sum / 4.0, 1e-15);
}

/// The paper's Fig. 5, where the distal moment closes the finger and where it opens it.
TEST(Study, OfADistalMomentSaysWhereThePlannedOneOpensTheFinger) {
  const TemporaryDirectory directory;
  const std::string sweep = replaced(test::read_file(scene_path("grasp_distal_sweep.toml")), "60 mm\"\n", "40 mm\"\n");
  const test::CommandRun closing =
      tendril({"study", scene_path("grasp_distal_sweep.toml"), "--output", directory / "60"});
  const test::CommandRun opening = tendril({"study", directory.write("s.toml", sweep), "--output", directory / "40"});
  EXPECT_EQ(closing.exit_code, 0) << closing.err;
  EXPECT_EQ(opening.exit_code, 0) << opening.err;
  const std::string sentence = "the planned moment of the last actuator is an opening one";
  EXPECT_FALSE(contains_text(closing.out, sentence));
  EXPECT_TRUE(contains_text(opening.out, sentence));
}

/// Plans that hold only if friction happens to be so are not mixed up with others.
TEST(Study, TellsThatItsPlansChooseTheStateOfFriction) {
  const TemporaryDirectory directory;
  const std::string text =
      test::read_file(scene_path("brace.toml")) + "\n[study]\ntargets = {x = [\"97 mm\"], y = [\"20 mm\"]}\n";
  for (const char* state : {"range", "any"}) {
    const std::vector<std::string> command{"study", directory.write("s.toml", text),
                                           "--set", "contact.friction=0.3",
                                           "--set", std::string("contact.friction_state=") + state};
    const bool chosen = std::string(state) == "any";
    const test::CommandRun told = tendril(command);
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_EQ(contains_text(told.out, "if friction happens to be as its contacts have it"), chosen);
    std::vector<std::string> as_json = command;
    as_json.emplace_back("--json");
    EXPECT_EQ(nlohmann::json::parse(tendril(as_json).out).value("friction_state", ""), chosen ? "any" : "");
  }
}

/// Where both fingers are planned a case is carried out with both.
TEST(Study, OfTwoFingersPlannedApart) {
  const TemporaryDirectory directory;
  const std::string text = test::read_file(scene_path("grasp_unequal.toml")) +
                           "\n[study]\ndiameters = [\"45 mm\", \"50 mm\"]\nforce_limits = [\"2 N\"]\n";
  const test::CommandRun run = tendril({"study", directory.write("s.toml", text), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["cases"].size(), 2U);
  for (const auto& one : json["cases"]) {
    EXPECT_EQ(one["status"], "solved");
    EXPECT_EQ(one["moments"].size(), 4U);
    EXPECT_EQ(one["pressures"].size(), 4U);
    EXPECT_NEAR(one["contact_force"].get<double>(), 2.0, 1e-6);
    EXPECT_LT(std::abs(one["axial_force"].get<double>()), 1e-6);
    // Six functions per piece.
    EXPECT_LT(one["model_error"].get<double>(), 1e-6);
    // The lower finger is no mirror image of the upper one.
    EXPECT_GT(std::abs(one["lines"][0].back()[0].get<double>() - one["lines"][1].back()[0].get<double>()), 0.01);
  }
  const test::CommandRun swept =
      tendril({"study", directory.write("m.toml", text + "moments = [\"1 N mm\"]\n"), "--json"});
  EXPECT_EQ(swept.exit_code, 2);
  EXPECT_TRUE(contains_text(swept.err, "both fingers of this scene are planned"));
}

/// An arm that a chamber bends, told pressures; `law`: its moment by the pressure.
std::string pressed_arm(const std::string& law) {
  return "[rod]\nlength = \"100 mm\"\nbending_stiffness = \"4.9e-4 N m^2\"\n[[rod.actuator]]\nkind = \"pressure\"\n"
         "min = 0\nmax = \"60 kPa\"\nmoment_per_pressure = " +
         law +
         "\n[target]\nposition = [\"80 mm\", \"50 mm\"]\n[[objective]]\nplugin = \"tip_pose\"\nweight = 100\n"
         "[solver]\nplugin = \"" TENDRIL_TEST_SOLVER "\"\n[study]\nlimits = ";
}

/// A sweep over the largest pressures is a sweep over `max`, whatever the law: a straight one, a curved one, one that
/// bends to the right. The side that is 0 stays 0.
TEST(Study, TakesLimitsInPressures) {
  const TemporaryDirectory directory;
  int number = 0;
  for (const std::string law :
       {"\"0.08 N mm/kPa\"", "\"-0.08 N mm/kPa\"", "[\"0.05 N mm/kPa\", \"6e-4 N mm/kPa^2\", \"1e-6 N mm/kPa^3\"]"}) {
    SCOPED_TRACE(law);
    const std::string scene = directory.write("s.toml", pressed_arm(law) + "[\"10 kPa\", \"25 kPa\"]\n");
    const std::string out = directory / std::to_string(++number);
    const test::CommandRun run = tendril({"study", scene, "--output", out});
    const auto json = nlohmann::json::parse(read_file(out + "/study.json"));
    ASSERT_EQ(json["cases"].size(), 2U) << run.err;
    for (const auto& one : json["cases"]) {
      EXPECT_EQ(one["limit_unit"], "Pa");
      const auto plan = nlohmann::json::parse(
          tendril({"plan", scene, "--json", "--set", "rod.actuator.0.max=" + one["limit"].dump()}).out);
      EXPECT_EQ(plan["moments"], one["moments"]);
      EXPECT_EQ(plan["inputs"], one["plan"]["inputs"]);
      const bool to_the_right = law[1] == '-';
      EXPECT_NEAR(one["plan"]["inputs"][0]["pressure"].get<double>(), to_the_right ? 0.0 : one["limit"].get<double>(),
                  to_the_right ? 1e-2 : 1e-4);
    }
    EXPECT_TRUE(contains_text(run.out, "10 kPa"));
    EXPECT_TRUE(contains_text(read_file(out + "/cases.csv"), "limit_Pa"));
    EXPECT_TRUE(contains_text(read_file(out + "/groups.csv"), "limit_Pa"));
  }
}

/// Likewise of tensions, for four tendons on either side of the backbone.
TEST(Study, TakesLimitsInTensions) {
  const TemporaryDirectory directory;
  const std::string scene =
      directory.write("s.toml", read_file(scene_path("tendon_arm.toml")) + "\n[study]\nlimits = [\"1 N\"]\n");
  const auto one = nlohmann::json::parse(tendril({"study", scene, "--json"}).out)["cases"][0];
  std::vector<std::string> plan{"plan", scene, "--json"};
  for (const char* actuator : {"0", "1", "2", "3"}) {
    plan.insert(plan.end(), {"--set", std::string("rod.actuator.") + actuator + ".limit=1"});
  }
  EXPECT_EQ(one["limit_unit"], "N");
  EXPECT_EQ(one["plan"]["inputs"], nlohmann::json::parse(tendril(plan).out)["inputs"]);
  EXPECT_EQ(one["plan"]["inputs"][0]["where"], "at its limit");
}

TEST(Study, RefusesLimitsThatItsActuatorsAreNotTold) {
  const TemporaryDirectory directory;
  const auto refusal = [&](const std::string& law, const std::string& limits) {
    const test::CommandRun run = tendril({"study", directory.write("s.toml", pressed_arm(law) + limits)});
    EXPECT_EQ(run.exit_code, 2);
    return run.err;
  };
  EXPECT_TRUE(contains_text(refusal("\"0.08 N mm/kPa\"", "[\"1 N\"]\n"), "found limits in N, but actuator 1 is told"));
  EXPECT_TRUE(contains_text(refusal("\"0.08 N mm/kPa\"", "[\"10 kPa\", \"1 N mm\"]\n"), "found \"10 kPa\""));
  EXPECT_TRUE(contains_text(refusal("[\"0.05 N mm/kPa\", \"6e-4 N mm/kPa^2\"]", "[\"80 kPa\"]\n"),
                            "the law of actuator 1 is known up to 60000 Pa only"));
  // Moments limit whatever bends the rod.
  const test::CommandRun moments =
      tendril({"study", directory.write("m.toml", pressed_arm("\"0.08 N mm/kPa\"") + "[\"1 N mm\"]\n"), "--json"});
  EXPECT_NEAR(nlohmann::json::parse(moments.out)["cases"][0]["moments"][0].get<double>(), 1e-3, 1e-12);
}

/// A study's case is what `plan` says about the same scene.
TEST(Study, AgreesWithPlan) {
  const TemporaryDirectory directory;
  const std::string text = replaced(small_study(), "starts = [\"ignore_then_execute\", \"avoid\"]\n", "");
  const std::string scene = directory.write("s.toml", text);
  const auto json = nlohmann::json::parse(tendril({"study", scene, "--json"}).out);
  for (const std::size_t i : {5U, 10U, 23U}) {
    const auto& one = json["cases"][i];
    const auto number = [](const nlohmann::json& value) { return value.dump(); };
    const auto plan = nlohmann::json::parse(
        tendril({"plan", scene, "--json", "--set", "rod.actuator.0.limit=" + number(one["limit"]), "--set",
                 "contact.mode=" + one["mode"].get<std::string>(), "--set", "target.position=" + number(one["target"])})
            .out);
    EXPECT_EQ(plan["moments"], one["moments"]);
    EXPECT_EQ(plan["target_error"], one["plan"]["target_error"]);
    EXPECT_EQ(plan["contacts"], one["plan"]["contacts"]);
  }
}

TEST(Study, LosesOnlyTheCasesThatCrash) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study() + "\n[[objective]]\nplugin = \"fragile\"\n");
  const std::vector<std::string> base{"study", scene, "--plugin-dir", TENDRIL_TEST_PLUGINS, "--output"};
  auto two = base;
  two.insert(two.end(), {directory / "two", "--jobs", "2"});
  const test::CommandRun run = tendril(two);
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_TRUE(contains_text(run.out, "2 of 4"));
  const auto json = nlohmann::json::parse(read_file(directory / "two/study.json"));
  int failed = 0;
  for (const auto& one : json["cases"]) {
    const bool far = one["target"][0].get<double>() > 0.096;
    EXPECT_EQ(one["status"], far ? "failed" : "solved");
    if (!far) continue;
    ++failed;
    EXPECT_TRUE(contains_text(one["message"].get<std::string>(), "ended by signal 6")) << one["message"];
  }
  EXPECT_EQ(failed, 12);
  auto one = base;
  one.insert(one.end(), {directory / "one"});
  EXPECT_EQ(tendril(one).exit_code, 1);
  expect_same_files(directory / "one", directory / "two");
}

TEST(Study, TriesACaseOnceMoreWhoseWorkerDied) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study() + "\n[[objective]]\nplugin = \"fragile\"\n");
  ::setenv("TENDRIL_TEST_ONCE", (directory / "died").c_str(), 1);
  const test::CommandRun run = tendril({"study", scene, "--plugin-dir", TENDRIL_TEST_PLUGINS});
  ::unsetenv("TENDRIL_TEST_ONCE");
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_TRUE(std::filesystem::exists(directory / "died"));
}

/// Ctrl-C as early as it gets, after some cases, and never: each time in the case of that number.
TEST(Study, GoesOnAfterCtrlC) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study() + "\n[[objective]]\nplugin = \"interrupting\"\n");
  const auto study = [&](const std::string& out) {
    return tendril({"study", scene, "--plugin-dir", TENDRIL_TEST_PLUGINS, "--output", out});
  };
  ASSERT_EQ(study(directory / "whole").exit_code, 0);
  const std::string out = directory / "out";
  const auto journal_lines = [&] {
    const std::string text = read_file(out + "/shard-1-of-1.journal");
    return std::count(text.begin(), text.end(), '\n');
  };
  long finished = 0;
  for (const int number : {1, 4, 9}) {
    ::setenv("TENDRIL_TEST_INTERRUPT", std::to_string(number).c_str(), 1);
    const test::CommandRun run = study(out);
    ::unsetenv("TENDRIL_TEST_INTERRUPT");
    EXPECT_EQ(run.exit_code, 1) << number;
    EXPECT_TRUE(contains_text(run.err, "run the same command again to go on"));
    EXPECT_FALSE(std::filesystem::exists(out + "/study.json"));
    // Those before the interruption are kept, behind the line that says what the journal is of.
    finished += number - 1;
    EXPECT_EQ(journal_lines(), 1 + finished);
  }
  EXPECT_EQ(study(out).exit_code, 0);
  expect_same_files(directory / "whole", out);
  // Nothing was done twice: one line for each case.
  EXPECT_EQ(journal_lines(), 25);
}

TEST(Study, OfAnotherSceneIsNotContinued) {
  const TemporaryDirectory directory;
  const std::string out = directory / "out";
  ASSERT_EQ(tendril({"study", directory.write("s.toml", small_study()), "--output", out}).exit_code, 0);
  const test::CommandRun run = tendril(
      {"study", directory.write("s.toml", replaced(small_study(), "\"84 g/m\"", "\"85 g/m\"")), "--output", out});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "belongs to another study"));
  const test::CommandRun set =
      tendril({"study", directory.write("s.toml", small_study()), "--output", out, "--set", "rod.linear_density=0"});
  EXPECT_EQ(set.exit_code, 2);
}

TEST(Study, CarriesATrajectoryThroughAllParadigms) {
  const TemporaryDirectory directory;
  const test::CommandRun run =
      tendril({"study", scene_path("trajectory.toml"), "--jobs", "2", "--output", directory / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
  const auto json = nlohmann::json::parse(read_file(directory / "out/study.json"));
  ASSERT_EQ(json["cases"].size(), 8U);
  for (const auto& one : json["cases"]) {
    EXPECT_EQ(one["steps"].size(), 45U);
    for (const auto& step : one["steps"]) EXPECT_EQ(step["status"], "solved");
    EXPECT_EQ(one["lines"].size(), 45U);
    // 1e-6 L; the coordinates are split at the contact.
    EXPECT_LT(one["model_error"].get<double>(), 1e-7);
  }
  // Planned as if it were not there, the peg is met; and tracking is best where the plan knows that it may lean on it.
  for (const std::size_t limit : {0U, 4U}) {
    const auto value = [&](std::size_t mode, const char* what) {
      return json["cases"][limit + mode][what].get<double>();
    };
    EXPECT_GT(value(1, "contact_force"), 0.01);
    EXPECT_LT(value(3, "tip_error"), value(1, "tip_error"));
    EXPECT_LT(value(3, "tip_error"), value(2, "tip_error"));
  }
}

/// The claims of the paradigm study on a part of its targets; the whole study is scenes/paradigms.toml.
TEST(Study, ShowsThatPlanningWithContactComesNearest) {
  const TemporaryDirectory directory;
  const std::string text =
      replaced(small_study(), "modes = [\"ignore\",", "modes = [\"ignore\", \"ignore_then_execute\",");
  const test::CommandRun run = tendril({"study", directory.write("s.toml", text), "--jobs", "2", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["groups"].size(), 8U);
  const auto mean = [&](std::size_t group, const char* what) {
    return json["groups"][group][what]["mean"].get<double>();
  };
  for (const std::size_t limit : {0U, 4U}) {
    EXPECT_LT(mean(limit + 3, "tip_error"), mean(limit + 1, "tip_error"));
    EXPECT_LT(mean(limit + 3, "tip_error"), mean(limit + 2, "tip_error"));
    EXPECT_GT(mean(limit + 1, "contact_force"), 1e-3);
  }
  for (const auto& one : json["cases"]) {
    // 1e-6 L with coordinates that are split at the contact.
    EXPECT_LT(one["model_error"].get<double>(), 1e-7);
    EXPECT_EQ(one["execution"]["from_plan"]["status"], "solved");
    if (one["mode"] != "avoid") continue;
    EXPECT_TRUE(one["plan"]["contacts"].empty());
    // Execution keeps the rod off by nothing, the plan by up to 1e-9 L: what is left of a force is of that size.
    EXPECT_LT(one["contact_force"].get<double>(), 1e-6 * 4.9e-2);
    // With the weak actuator the arm passes below the peg, which is at y = 0.
    if (one["limit"].get<double>() > 0.003) continue;
    EXPECT_LT(one["tip"][1].get<double>(), -0.008);
  }
}

/// Coordinates that are not split and of low order leave out more, and the study says how much.
TEST(Study, ShowsTheModelErrorOfThePapersCoordinates) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study());
  const auto json =
      nlohmann::json::parse(tendril({"study", scene, "--coordinates", "psc", "--no-split", "--json"}).out);
  double largest = 0.0;
  for (const auto& one : json["cases"]) {
    if (one["mode"] == "allow" && one["status"] == "solved")
      largest = std::max(largest, one["model_error"].get<double>());
  }
  EXPECT_GT(largest, 1e-7);
}

struct WrongStudy {
  const char* old_text;
  const char* new_text;
  const char* message;
};

TEST(Study, RefusesInputThatMakesNoSense) {
  const TemporaryDirectory directory;
  const std::string good = small_study();
  for (const WrongStudy& wrong :
       {WrongStudy{"modes = [", "modes = [\"alow\", ", "did you mean 'allow'?"},
        WrongStudy{"modes = [", "modes = [3, ", "found the number 3"},
        WrongStudy{"modes = [\"ignore\", \"avoid\", \"allow\"]", "modes = []", "a list of at least one entry"},
        WrongStudy{"limits = [", "limits = [\"2 N\", ", "found \"2 N\""},
        WrongStudy{"limits = [", "limits = [\"0 N mm\", ", "a moment greater than 0"},
        WrongStudy{"limits = [", "limit = [", "did you mean 'limits'?"},
        WrongStudy{"targets = [", "targets = [[1], ", "found a list of 1 entry"},
        WrongStudy{"targets = [[0.092, 0.008], [0.095, 0.016], [0.097, 0.02], [0.099, 0.024]]", "targets = {x = [1]}",
                   "expected both x and y"},
        WrongStudy{"targets = [[0.092, 0.008], [0.095, 0.016], [0.097, 0.02], [0.099, 0.024]]",
                   "targets = {x = [1], z = [1]}", "found the key 'z'"},
        WrongStudy{"modes = [\"ignore\", \"avoid\", \"allow\"]", "modes = [\"require\"]", "needs a min_force"},
        WrongStudy{"starts = [", "starts = [\"allow\", ", "found \"allow\""}}) {
    const test::CommandRun run =
        tendril({"study", directory.write("s.toml", replaced(good, wrong.old_text, wrong.new_text))});
    EXPECT_EQ(run.exit_code, 2) << wrong.new_text << run.out;
    EXPECT_TRUE(contains_text(run.err, wrong.message));
    EXPECT_TRUE(contains_text(run.err, "s.toml:"));
  }
  const test::CommandRun none = tendril({"study", scene_path("brace.toml")});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_TRUE(contains_text(none.err, "the scene has no [study]"));
  const std::string scene = directory.write("s.toml", good);
  for (const auto& [words, message] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--jobs", "0"}, "--jobs"},
           {{"--jobs", "many"}, "--jobs"},
           {{"--shard", "0/2", "--output", directory / "x"}, "--shard 0/2: expected i/N"},
           {{"--shard", "3/2", "--output", directory / "x"}, "--shard 3/2: expected i/N"},
           {{"--shard", "1/2x", "--output", directory / "x"}, "expected i/N"},
           {{"--shard", "1/2"}, "need --output"},
           {{"--merge"}, "need --output"},
           {{"--merge", "--shard", "1/2", "--output", directory / "x"}, "expected no --shard"},
           {{"--merge", "--output", directory / "x"}, "cannot read"},
           {{"--job", "2"}, "did you mean '--jobs'?"}}) {
    auto all = words;
    all.insert(all.begin(), {"study", scene});
    const test::CommandRun run = tendril(all);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_TRUE(contains_text(run.err, message));
  }
}

}  // namespace
}  // namespace tendril::app
