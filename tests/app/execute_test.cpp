// What the real command says of moments carried out, and of plans that are.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;
using Names = std::vector<std::string>;

json execute_brace(const std::string& moments) {
  return json_of({"execute", scene_path("brace.toml"), "--moments", moments});
}

TEST(Execute, OfTheBracedArmMatchesTheReference) {
  const json result = execute_brace("2.5 N mm");
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["status"], "solved");
  EXPECT_EQ(result["problem"], "execute");
  ASSERT_EQ(result["contacts"].size(), 1U);
  // reference/braced_arm.csv, to the digits printed there.
  EXPECT_NEAR(result["tip"]["x"].get<double>(), 0.09670319442, 1e-11);
  EXPECT_NEAR(result["tip"]["y"].get<double>(), 0.02200183222, 1e-11);
  EXPECT_NEAR(result["contacts"][0]["arc_length"].get<double>(), 0.05862167146, 1e-11);
  EXPECT_NEAR(result["contacts"][0]["force"].get<double>(), 0.06178404562, 1e-10);
  EXPECT_EQ(result["contacts"][0]["obstacle"], "obstacle 1");
  EXPECT_EQ(result["moments"], json::array({0.0025}));
  EXPECT_EQ(result["load"]["reached"], 1.0);
  EXPECT_EQ(result["load"]["contact_changes"], 1);
  EXPECT_EQ(result["basis"]["pieces"], 2);
  EXPECT_EQ(result["coordinates"]["values"].size(), result["coordinates"]["dimension"].get<std::size_t>());
  EXPECT_TRUE(result["snaps"].empty());
  EXPECT_TRUE(result["certificate"]["failures"].empty());
  EXPECT_LE(result["certificate"]["moment_balance"].get<double>(), 1e-9);
  EXPECT_NEAR(result["backbone"].back()[1].get<double>(), result["tip"]["x"].get<double>(), 1e-12);
}

TEST(Execute, ReadsMomentsInAnyUnitAndSign) {
  const json si = execute_brace("-0.0025");
  const json unit = execute_brace(" -2.5 N mm ");
  EXPECT_EQ(si["status"], "solved");
  EXPECT_NEAR(si["moments"][0].get<double>(), unit["moments"][0].get<double>(), 1e-17);
  EXPECT_NEAR(si["tip"]["y"].get<double>(), unit["tip"]["y"].get<double>(), 1e-13);
}

TEST(Execute, HoldsTheLengthsOfTendonsAndTellsTheirTensions) {
  const std::string file = scene_path("tendon_lengths.toml");
  const json result = json_of({"execute", file, "--inputs", "8 mm, -8 mm"});
  EXPECT_EQ(result["status"], "solved") << result["message"];
  const json& inputs = result["inputs"];
  EXPECT_EQ(inputs[0]["kind"], "tendon");
  EXPECT_EQ(inputs[0]["control"], "length");
  EXPECT_EQ(inputs[0]["unit"], "m");
  EXPECT_NEAR(inputs[0]["value"].get<double>(), 8e-3, 1e-14);
  EXPECT_EQ(inputs[0]["value"], inputs[0]["shortening"]);
  EXPECT_GT(inputs[0]["tension"].get<double>(), 0.1);
  EXPECT_EQ(inputs[1]["tension"], 0.0);
  EXPECT_EQ(result["certificate"]["held_lengths"], 1);
  EXPECT_GE(result["load"]["tendon_changes"], 1);
  // A plan's lengths are carried out by their result, as moments are.
  const TemporaryDirectory directory;
  const json planned = json_of({"plan", file});
  const json carried = json_of({"execute", file, "--plan", directory.write("plan.json", planned.dump())});
  EXPECT_EQ(planned["status"], "solved") << planned["message"];
  EXPECT_EQ(carried["status"], "solved") << carried["message"];
  for (const std::size_t a : {0U, 1U}) {
    EXPECT_NEAR(carried["inputs"][a]["shortening"].get<double>(), planned["inputs"][a]["shortening"].get<double>(),
                1e-9);
    EXPECT_NEAR(carried["inputs"][a]["tension"].get<double>(), planned["inputs"][a]["tension"].get<double>(), 1e-3);
  }
}

TEST(Execute, UsesObstaclesWhateverTheContactModeSays) {
  const json result = json_of({"execute", scene_path("brace.toml"), "--moments", "2.5 N mm", "--set",
                               "contact.mode=ignore", "--set", "contact.max_force=0"});
  ASSERT_EQ(result["contacts"].size(), 1U);
  EXPECT_NEAR(result["contacts"][0]["force"].get<double>(), 0.06178404562, 1e-10);
}

TEST(Execute, ListsActiveContactsOnly) {
  const json result = execute_brace("6 N mm");  // lifts off; model.md: 4.9 N mm suffice
  EXPECT_EQ(result["status"], "solved");
  EXPECT_TRUE(result["contacts"].empty());
}

TEST(Execute, WayPointsFollowOneAnother) {
  const json way = json_of({"execute", scene_path("brace.toml"), "--moments", "6 N mm; 2.5 N mm"});
  ASSERT_EQ(way["steps"].size(), 2U);
  EXPECT_TRUE(way["steps"][0]["contacts"].empty());
  const json alone = execute_brace("2.5 N mm");
  ASSERT_EQ(way["steps"][1]["contacts"].size(), 1U);
  EXPECT_EQ(way["steps"][1]["moments"], json::array({0.0025}));
  EXPECT_NEAR(way["steps"][1]["tip"]["y"].get<double>(), alone["tip"]["y"].get<double>(), 1e-11);
  expect_refused(tendril({"execute", scene_path("brace.toml"), "--moments", "6 N mm; 1, 2"}),
                 "way point 2: found 2 moments");
}

// Where contacts stick and slip, the way by which the rod came counts.
TEST(Execute, WayPointsShowHysteresisUnderFriction) {
  const TemporaryDirectory directory;
  const auto rubbed = [](const std::string& moments, const Names& more) {
    Names all{"execute", scene_path("brace.toml"), "--set", "contact.friction=0.3", "--moments", moments};
    all.insert(all.end(), more.begin(), more.end());
    return json_of(all);
  };
  const json way = rubbed("1 N mm; 2.5 N mm; 2.45 N mm; 1 N mm", {"--figure", directory / "loop.svg"});
  const json& steps = way["steps"];
  ASSERT_EQ(steps.size(), 4U);
  const char* const states[] = {"slip", "slip", "stick", "slip"};
  for (std::size_t i = 0; i < 4; ++i) {
    const json& contact = steps[i]["contacts"].at(0);
    EXPECT_EQ(contact["state"], states[i]);
    const double ratio = contact["tangential_force"].get<double>() / contact["force"].get<double>();
    if (contact["state"] == "slip") {
      EXPECT_NEAR(std::abs(ratio), 0.3, 1e-12);
    } else {
      EXPECT_LT(std::abs(ratio), 0.3);
    }
  }
  EXPECT_TRUE(contains_text(read_file(directory / "loop.dat"), "loop 1."));
  EXPECT_TRUE(contains_text(read_file(directory / "loop.svg"), "friction at obstacle 1"));

  // Results on disk carry on as the way does.
  const std::string one = directory.write("one.json", rubbed("1 N mm", {}).dump());
  const std::string up = directory.write("up.json", rubbed("2.5 N mm", {"--start", one}).dump());
  const json there = rubbed("2.45 N mm", {"--start", up})["contacts"][0];
  EXPECT_EQ(there["state"], "stick");
  EXPECT_NEAR(there["tangential_force"].get<double>(), steps[2]["contacts"][0]["tangential_force"].get<double>(), 1e-9);
}

constexpr const char* pressed = R"(
title = "Pressed"
[rod]
length = "10 cm"
bending_stiffness = "4.9e-4 N m^2"
[[rod.actuator]]
min = "-5 N mm"
max = "1e4 N m"
[[rod.actuator]]
moment_per_pressure = "-1e-7 N m/Pa"
min_pressure = "0 bar"
max_pressure = "2 bar"
[target]
position = ["9.7 cm", "2 cm"]
[[objective]]
plugin = "tip_pose"
)";

TEST(Execute, TellsWhatIsHeldBeyondItsLimits) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("pressed.toml", pressed);
  struct Held {
    const char* moments;
    const char* where[2];
    double bounds;  ///< EI/L = 4.9e-3 N m
  };
  for (const Held& held :
       {Held{"1 N mm, -20 N mm", {"inside", "at its limit"}, 0.0}, Held{"1 N mm, -1 N mm", {"inside", "inside"}, 0.0},
        Held{"-5 N mm, 1 N mm", {"at its limit", "beyond its limit"}, 1.0 / 4.9},
        Held{"-6 N mm, -21 N mm", {"beyond its limit", "beyond its limit"}, 1.0 / 4.9},
        Held{"-6 N mm, 0 N mm", {"beyond its limit", "at its limit"}, 1.0 / 4.9}}) {
    SCOPED_TRACE(held.moments);
    const json result = json_of({"execute", scene, "--moments", held.moments});
    EXPECT_EQ(result["status"], "solved");
    EXPECT_NEAR(result["certificate"]["bounds"].get<double>(), held.bounds, 1e-12);
    const CommandRun run = tendril({"execute", scene, "--moments", held.moments});
    for (std::size_t a = 0; a < 2; ++a) {
      EXPECT_EQ(result["inputs"][a]["where"], held.where[a]);
      const bool beyond = std::string(held.where[a]) == "beyond its limit";
      EXPECT_EQ(contains_text(result["message"].get<std::string>(), "actuator " + std::to_string(a + 1) + " is held"),
                beyond);
      EXPECT_TRUE(contains_text(run.out, held.where[a]));
    }
    EXPECT_EQ(contains_text(run.out, "BEYOND"), held.bounds > 0.0);
  }
}

TEST(Execute, TakesPressuresAndShowsThemInTheUnitsOfTheScene) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("pressed.toml", pressed);
  const json moments = json_of({"execute", scene, "--moments", "2 N mm, -5 N mm"});
  const json each = json_of({"execute", scene, "--inputs", "2 N mm, 50 kPa"});
  EXPECT_EQ(each["inputs"][1]["kind"], "pressure");
  EXPECT_NEAR(each["inputs"][1]["pressure"].get<double>(), 5e4, 1e-9);
  EXPECT_NEAR(each["inputs"][1]["moment"].get<double>(), -5e-3, 1e-15);
  EXPECT_EQ(each["inputs"][0]["kind"], "moment");
  for (const char* c : {"x", "y"}) EXPECT_NEAR(each["tip"][c].get<double>(), moments["tip"][c].get<double>(), 1e-12);
  const CommandRun run = tendril({"execute", scene, "--inputs", "0.002, 0.5 bar"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "0.5 bar  0 bar  2 bar  inside"));
  EXPECT_TRUE(contains_text(run.out, " cm, "));
  EXPECT_FALSE(contains_text(run.out, "kPa"));
  EXPECT_TRUE(contains_text(tendril({"plan", scene}).out, "pressure  value"));
  expect_refused(tendril({"execute", scene, "--pressures", "1 bar, 2 bar"}),
                 "--pressures, number 1: the scene does not say what moment a pressure gives");
  expect_refused(tendril({"execute", scene_path("grasp_60mm.toml"), "--moments", "40 kPa, 0"}),
                 "number in N m; --pressures takes pressures");
  expect_refused(tendril({"execute", scene_path("grasp_60mm.toml"), "--pressures", "0, 40 N mm"}),
                 "number in Pa; --moments takes moments");
  expect_refused(tendril({"execute", scene, "--inputs", "1 N mm"}), "--inputs: found 1 inputs");
  expect_refused(tendril({"execute", scene, "--inputs", "1 N mm, 2 N mm"}), "--inputs, number 2: found \"2 N mm\"");
  expect_refused(tendril({"execute", scene}), "execute needs what moves the scene's 2 actuators");
}

TEST(Execute, NeedsNoMomentsWhereThereIsNoActuator) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("mast.toml", R"(
gravity = [0, -9.81]
[rod]
length = "0.1 m"
bending_stiffness = "4.9e-4 N m^2"
linear_density = "84 g/m"
)");
  const json bare = json_of({"execute", scene});
  const json empty = json_of({"execute", scene, "--moments", ""});
  EXPECT_EQ(bare["tip"], empty["tip"]);
  EXPECT_EQ(bare["inputs"], json::array());
}

TEST(Execute, CarriesOutTheStepsOfATrajectory) {
  const TemporaryDirectory directory;
  const std::string scene = scene_path("trajectory.toml");
  const json planned = json_of({"plan", scene, "--verify", "--output", directory.path().string()});
  double largest = 0.0;
  for (const json& step : planned["steps"]) {
    ASSERT_TRUE(step["model_error"].is_number());
    // Six functions per piece (README).
    EXPECT_LT(step["model_error"].get<double>(), 1e-11);
    largest = std::max(largest, step["model_error"].get<double>());
  }
  EXPECT_EQ(planned["model_error"]["largest"].get<double>(), largest);
  const std::string report = tendril({"plan", scene, "--verify"}).out;
  EXPECT_TRUE(contains_text(report, "executed, each step from the one before"));
  EXPECT_TRUE(contains_text(report, "distance to the targets: mean "));

  const json reached = json_of({"execute", scene, "--plan", directory / "result.json"});
  ASSERT_EQ(reached["steps"].size(), planned["steps"].size());
  for (std::size_t i = 0; i < planned["steps"].size(); ++i) {
    EXPECT_EQ(reached["steps"][i]["method"], "executed");
    EXPECT_EQ(reached["steps"][i]["moments"], planned["steps"][i]["moments"]);
    EXPECT_EQ(reached["steps"][i]["target"], planned["steps"][i]["target"]);
    for (const char* c : {"x", "y"}) {
      EXPECT_NEAR(reached["steps"][i]["tip"][c].get<double>(), planned["steps"][i]["tip"][c].get<double>(), 1e-11);
    }
  }
}

TEST(Execute, OfAStepThatIsWrongIsToldByItsVerification) {
  const TemporaryDirectory directory;
  // Where the loads meet an obstacle that the plans do not know.
  const std::string text = scene_with("trajectory.toml", "mode = \"allow\"", "mode = \"ignore\"");
  const CommandRun run = tendril({"plan", directory.write("blind.toml", text), "--verify", "--json"});
  const json result = json::parse(run.out);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(result["status"], "solved");
  int refuted = 0;
  for (const json& step : result["steps"]) {
    refuted += contains_text(step["message"].get<std::string>(), "execution does not confirm the plan") ? 1 : 0;
  }
  EXPECT_GT(refuted, 0);
}

TEST(Execute, WhereTheStartHasNoSideVerifiesThePlanFromItsOwnShape) {
  const TemporaryDirectory directory;
  // A straight start runs through the middle of each of these.
  for (const char* obstacle :
       {"shape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"",
        "shape = \"circle\"\ncenter = [\"90 mm\", \"0 mm\"]\nradius = \"3 mm\"",
        "shape = \"capsule\"\nfrom = [\"60 mm\", \"-10 mm\"]\nto = [\"60 mm\", \"10 mm\"]\nradius = \"2 mm\""}) {
    SCOPED_TRACE(obstacle);
    const std::string scene = directory.write("noside.toml", std::string(R"(
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
[[rod.actuator]]
limit = "20 N mm"
[[obstacle]]
)") + obstacle + R"(
[target]
position = ["80 mm", "45 mm"]
[[objective]]
plugin = "tip_pose"
[study]
modes = ["allow"]
)");
    const json result = json_of({"plan", scene, "--verify"});
    EXPECT_EQ(result["status"], "solved");
    EXPECT_LT(result["model_error"].get<double>(), 1e-9);
    const std::string told = result["verification"].get<std::string>();
    EXPECT_TRUE(contains_text(told, "it cannot be loaded from the start: the start shape runs through the core"));
    EXPECT_TRUE(contains_text(told, "settled from the plan's own shape"));
    const CommandRun study = tendril({"study", scene});
    EXPECT_EQ(study.exit_code, 0) << study.err;
    EXPECT_TRUE(contains_text(study.out, "loaded from the start, case 0: the start shape runs through the core"));
  }
}

TEST(Execute, OfAnEstimateIsRefusedInWords) {
  expect_refused(tendril({"plan", scene_path("estimate.toml"), "--verify"}), "--verify: the obstacles of an estimate");
}

TEST(Execute, CarriesOutAnEarlierPlan) {
  const TemporaryDirectory directory;
  const json plan = json_of({"plan", scene_path("brace.toml"), "--output", directory.path().string()});
  const json result = json_of({"execute", scene_path("brace.toml"), "--plan", directory / "result.json"});
  EXPECT_EQ(result["moments"], plan["moments"]);
  // Model error of 6 functions per piece (README).
  EXPECT_NEAR(result["tip"]["x"].get<double>(), plan["tip"]["x"].get<double>(), 1e-11);
  EXPECT_NEAR(result["tip"]["y"].get<double>(), plan["tip"]["y"].get<double>(), 1e-11);
}

TEST(Execute, LeadsAnEarlierPlanFromOnePlaceToTheNext) {
  const TemporaryDirectory directory;
  const std::string scene = scene_path("inserted.toml"), plan = directory / "result.json";
  const json planned = json_of({"plan", scene, "--output", directory.path().string()});
  const json reached = json_of({"execute", scene, "--plan", plan, "--insertion", "190 mm; 170 mm"});
  ASSERT_EQ(reached["steps"].size(), 2U);
  for (const json& step : reached["steps"]) EXPECT_EQ(step["moments"], planned["moments"]);
  EXPECT_EQ(reached["steps"][0]["insertion"], 0.19);
  const json there = json_of({"execute", scene, "--plan", plan, "--insertion", "170 mm"});
  for (const char* c : {"x", "y"})
    EXPECT_NEAR(reached["steps"][1]["tip"][c].get<double>(), there["tip"][c].get<double>(), 1e-9);

  const std::string path = directory / "path.json";
  std::ofstream(path) << tendril({"execute", scene, "--plan", plan, "--insertion", "190 mm; 170 mm", "--json"}).out;
  expect_refused(tendril({"execute", scene, "--plan", path, "--base", "0, 0, 0; 0, 0, 0.1"}),
                 "--base: found several way points, but the result has its own, expected one place");
}

TEST(Execute, GoesOnFromAnEarlierResult) {
  const TemporaryDirectory directory;
  const std::string scene = scene_path("snap_through.toml");
  // m = M L / EI with L = 0.2 m and EI = 0.01 N m^2: 2 and -1.
  json_of({"execute", scene, "--moments", "100 N mm", "--output", directory.path().string()});
  const json result = json_of({"execute", scene, "--moments", "-50 N mm", "--start", directory / "result.json"});
  EXPECT_EQ(result["status"], "solved");
  ASSERT_EQ(result["snaps"].size(), 1U);
  const json& snap = result["snaps"][0];
  EXPECT_EQ(snap["kind"], "fold");
  const double fold = -0.59941729;  // model.md section 8, weight 12
  EXPECT_NEAR(snap["moments"][0].get<double>() / 0.05, fold, 1e-6);
  EXPECT_NEAR(snap["load"].get<double>(), (2.0 - fold) / 3.0, 1e-6);
  EXPECT_GT(snap["stability_after"].get<double>(), 0.01);
  EXPECT_NEAR(snap["before"]["tip"]["angle"].get<double>() - std::acos(0.0), 0.8253, 1e-4);
  EXPECT_LT(snap["after"]["tip"]["angle"].get<double>(), std::acos(0.0));
  EXPECT_EQ(snap["before"]["backbone"].size(), snap["after"]["backbone"].size());
}

TEST(Execute, FindsThreeContacts) {
  const json result = json_of({"execute", scene_path("alternating_pegs.toml"), "--moments", "0"});
  Names names;
  for (const json& contact : result["contacts"]) names.push_back(contact["obstacle"].get<std::string>());
  EXPECT_EQ(names, (Names{"first peg", "second peg", "third peg"}));
  EXPECT_GT(result["certificate"]["stability"].get<double>(), 0.1);
}

TEST(Execute, WritesTableAndFigures) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"execute", scene_path("alternating_pegs.toml"), "--moments", "0", "--output",
                                  directory / "out", "--figure", directory / "f.svg"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* word : {"status         solved", "load fraction 1 reached", "first peg", "moment balance"}) {
    EXPECT_TRUE(contains_text(run.out, word)) << word << run.out;
  }
  EXPECT_TRUE(contains_text(read_file(directory / "f.svg"), "<svg"));
  EXPECT_EQ(json::parse(read_file(directory / "out/result.json"))["problem"], "execute");
}

TEST(Execute, ThatDoesNotArriveIsWrittenAllTheSame) {
  const TemporaryDirectory directory;
  // Bent the other way, past the curvature of a peg of 8 mm: the arm would lie along it.
  const json result =
      json_of({"execute", scene_path("brace.toml"), "--moments", "-200 N mm", "--output", directory / "out"}, 1);
  EXPECT_EQ(result["status"], "not_converged");
  EXPECT_NE(result["message"], "");
  EXPECT_LT(result["load"]["reached"].get<double>(), 1.0);
  EXPECT_EQ(json::parse(read_file(directory / "out/result.json"))["status"], "not_converged");
}

/// A rod of length and stiffness 1.
std::string unit_rod(const std::string& more) {
  return "problem = \"pose\"\n[rod]\nlength = 1\nbending_stiffness = 1\n" + more +
         "[coordinates]\nplugin = \"legendre\"\n[target]\nposition = [0.8, 0.4]\n[[objective]]\nplugin = "
         "\"tip_pose\"\n[solver]\nplugin = \"" TENDRIL_TEST_SOLVER "\"\n";
}

// Bent more than the circle of radius 0.15, the rod would run into it beyond a single point.
TEST(Extended, IsAPlannedContactThatSpreads) {
  const TemporaryDirectory directory;
  const std::string file = directory.write(
      "s.toml", unit_rod("[[rod.actuator]]\nmin = 7\nmax = 7\n[[obstacle]]\nshape = \"circle\"\ncenter = [0.6, 0.3]\n"
                         "radius = 0.15\n[start]\ntip_angle = 0.5\n[contact]\nmode = \"require\"\nmin_force = 0.1\n"));
  const json result = json_of({"plan", file}, 1);
  EXPECT_EQ(result["status"], "not_converged");
  EXPECT_TRUE(contains_text(result["message"].get<std::string>(), "contact spreads")) << result["message"];
  ASSERT_EQ(result["contacts"].size(), 1U);
  EXPECT_EQ(result["contacts"][0]["extended"], true);
  // Nothing presses beyond the contact, so that the rod has the curvature 7 there.
  EXPECT_NEAR(result["certificate"]["contact_convexity"].get<double>(), 1.0 / 0.15 - 7.0, 1e-6);
  const CommandRun run = tendril({"plan", file});
  EXPECT_TRUE(contains_text(run.out, "obstacle 1 (extended)"));
}

// It touches down at (72 h / w)^(1/4) = 0.1638; the wall carries w (1 - 2/3 of that) = 89.1.
TEST(Extended, IsARunOfContactsThatAreCarriedOut) {
  const TemporaryDirectory directory;
  const std::string file = directory.write(
      "s.toml", "gravity = [0, -1]\n" + unit_rod("linear_density = 100\n[[obstacle]]\nname = \"floor\"\n"
                                                 "shape = \"wall\"\npoint = [0, -1e-3]\nangle = 0\n"));
  const json result = json_of({"execute", file, "--moments", ""}, 1);
  EXPECT_EQ(result["status"], "not_converged");
  ASSERT_GT(result["contacts"].size(), 50U);
  double sum = 0.0;
  for (const json& contact : result["contacts"]) {
    EXPECT_EQ(contact["extended"], true);
    sum += contact["force"].get<double>();
  }
  EXPECT_NEAR(sum, 89.1, 1.0);
  const CommandRun run = tendril({"execute", file, "--moments", ""});
  EXPECT_TRUE(
      contains_text(run.out, "floor (tip) (extended, " + std::to_string(result["contacts"].size()) + " points)"));
}

TEST(Extended, IsNotSaidOfPoints) { EXPECT_FALSE(execute_brace("2.5 N mm")["contacts"][0].contains("extended")); }

TEST(Execute, KeepsTheTimeLimit) {
  const json result =
      json_of({"execute", scene_path("brace.toml"), "--moments", "1 N mm", "--set", "solver.time_limit=1e-9"}, 1);
  EXPECT_EQ(result["status"], "time_limit");
}

TEST(PlanVerify, ConfirmsTheBracedArm) {
  const json result = json_of({"plan", scene_path("brace.toml"), "--verify"});
  EXPECT_EQ(result["status"], "solved");
  EXPECT_LT(result["model_error"].get<double>(), 1e-6 * 0.1);
}

TEST(PlanVerify, IsOnRequestOnly) { EXPECT_FALSE(json_of({"plan", scene_path("brace.toml")}).contains("model_error")); }

TEST(PlanVerify, ReportsWhatACoarseBasisLeavesOut) {
  for (const char* basis : {"pcc", "psc"}) {
    const json result = json_of({"plan", scene_path("free.toml"), "--coordinates", basis, "--verify"});
    EXPECT_EQ(result["status"], "solved") << basis;
    const double error = result["model_error"].get<double>();
    // The moments executed by hand end as far away.
    const json executed = json_of({"execute", scene_path("free.toml"), "--moments", result["moments"][0].dump()});
    const double apart = std::hypot(executed["tip"]["x"].get<double>() - result["tip"]["x"].get<double>(),
                                    executed["tip"]["y"].get<double>() - result["tip"]["y"].get<double>());
    EXPECT_NEAR(error, apart, 1e-12) << basis;
    EXPECT_GT(error, 1e-9) << basis;
  }
}

// Loaded from above the peg the arm comes to rest on it; the plan that avoids it lies below.
TEST(PlanVerify, TurnsTheVerdictOfAPlanThatIsNotReached) {
  const json plain = json_of({"plan", scene_path("avoid.toml")});
  EXPECT_EQ(plain["status"], "solved");
  const json result = json_of({"plan", scene_path("avoid.toml"), "--verify"}, 1);
  EXPECT_EQ(result["status"], "not_converged");
  EXPECT_TRUE(
      contains_text(result["message"].get<std::string>(), "the plan rests on no obstacle, execution on 'obstacle 1'"))
      << result["message"];
  EXPECT_GT(result["model_error"].get<double>(), 0.01);
  EXPECT_LT(result["local_model_error"].get<double>(), 1e-6);
}

TEST(PlanVerify, SaysSoWhereThereIsNoShape) {
  const json result = json_of({"plan", scene_path("brace.toml"), "--verify", "--set", "solver.time_limit=1e-9"}, 1);
  EXPECT_TRUE(result["model_error"].is_null());
  EXPECT_TRUE(contains_text(result["verification"].get<std::string>(), "not executed"));
}

}  // namespace
}  // namespace tendril::app::test
