// Grasps whose fingers are both planned, through the real command: what it writes, carries out and refuses.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;

TEST(GraspOfTwoFingers, IsWrittenDownFingerByFingerAndCarriedOut) {
  const TemporaryDirectory directory;
  const CommandRun planned =
      tendril({"plan", scene_path("grasp_unequal.toml"), "--verify", "--output", directory / "out"});
  ASSERT_EQ(planned.exit_code, 0) << planned.err << planned.out;
  EXPECT_TRUE(contains_text(planned.out, "upper finger: settled from the plan's own shape"));
  EXPECT_TRUE(contains_text(planned.out, "lower finger: settled from the plan's own shape"));
  const json result = json::parse(read_file(directory / "out/result.json"));
  ASSERT_EQ(result["fingers"].size(), 2U);
  ASSERT_EQ(result["moments"].size(), 4U);
  ASSERT_EQ(result["contacts"].size(), 2U);
  const char* names[] = {"upper", "lower"};
  const double lengths[] = {0.12, 0.09};
  for (std::size_t which = 0; which < 2; ++which) {
    const json& finger = result["fingers"][which];
    EXPECT_EQ(finger["finger"], names[which]);
    EXPECT_EQ(result["contacts"][which]["finger"], names[which]);
    EXPECT_EQ(finger["contacts"][0], result["contacts"][which]);
    for (std::size_t a = 0; a < 2; ++a) EXPECT_EQ(finger["moments"][a], result["moments"][2 * which + a]);
    EXPECT_NEAR(finger["backbone"].back()[0].get<double>(), lengths[which], 1e-12);
    EXPECT_NEAR(finger["backbone"].back()[1].get<double>(), finger["tip"]["x"].get<double>(), 1e-12);
  }
  // In the world the lower finger is below.
  EXPECT_LT(result["fingers"][1]["backbone"][0][2].get<double>(), 0.0);
  EXPECT_LT(result["contacts"][1]["normal"][1].get<double>(), 0.0);
  for (const char* file : {"out/figure.png", "out/figure.svg"}) EXPECT_GT(read_file(directory / file).size(), 1000U);

  // Its own moments from its own shape: the state that was planned.
  const json reached = json_of({"execute", scene_path("grasp_unequal.toml"), "--plan", directory / "out/result.json",
                                "--start", directory / "out/result.json"});
  for (std::size_t which = 0; which < 2; ++which) {
    for (const char* c : {"x", "y", "angle"}) {
      // Six functions per piece.
      EXPECT_NEAR(reached["fingers"][which]["tip"][c].get<double>(), result["fingers"][which]["tip"][c].get<double>(),
                  1e-6);
    }
    EXPECT_NEAR(reached["contacts"][which]["force"].get<double>(), 3.0, 1e-6);
  }
  EXPECT_LT(std::abs(reached["net_force"][0].get<double>()), 1e-6);
  // A plan from an earlier one is the same.
  const json again = json_of({"plan", scene_path("grasp_unequal.toml"), "--start", directory / "out/result.json"});
  EXPECT_NEAR(again["objective"].get<double>(), result["objective"].get<double>(), 1e-9);
}

/// A change of the planned pressure may leave its limits: the case is what the rod would do, and says so.
TEST(GraspStudy, TellsPressuresThatAreHeldBeyondTheirLimits) {
  const TemporaryDirectory directory;
  const std::string head = R"(
title = "Fingers that hang down"
problem = "grasp"
gravity = [0, -9.81]
[gripper]
half_palm = "25 mm"
object_diameter = "50 mm"
angle = "-90 deg"
finger_angle = "10 deg"
[rod]
length = "110 mm"
bending_stiffness = "0.008 N m^2"
linear_density = "150 g/m"
rest_curvature = "3 1/m"
[[rod.actuator]]
to = "60 mm"
min_pressure = "0 kPa"
max_pressure = "80 kPa"
moment_per_pressure = "-4 N mm/kPa"
[[rod.actuator]]
from = "60 mm"
min_pressure = "0 kPa"
max_pressure = "80 kPa"
moment_per_pressure = "-4 N mm/kPa"
[start]
tip_angle = "-0.5 rad"
[contact]
max_force = "2 N"
[[objective]]
plugin = "contact_force"
[[objective]]
plugin = "actuation_effort"
weight = 1e-3
[solver]
plugin = ")" TENDRIL_TEST_SOLVER "\"\n[study]\n";
  const std::string pressures =
      directory.write("pressures.toml", head + "pressures = [\"12.5 kPa\", \"0 kPa\", \"-12.5 kPa\", \"-37.5 kPa\"]\n");
  const std::string moments =
      directory.write("moments.toml", head + "moments = [\"-50 N mm\", \"0 N mm\", \"50 N mm\", \"150 N mm\"]\n");
  const json result = json_of({"study", pressures});
  const json same = json_of({"study", moments});
  const CommandRun told = tendril({"study", pressures});
  // The planned pressure of the last actuator is 0, its limit; EI/L = 0.008 / 0.11 N m.
  const double beyond[] = {0.0, 0.0, 0.05 * 0.11 / 0.008, 0.15 * 0.11 / 0.008};
  const char* const where[] = {"inside", "at its limit", "beyond its limit", "beyond its limit"};
  ASSERT_EQ(result["cases"].size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const json& one = result["cases"][i];
    EXPECT_EQ(one["where"][1], where[i]);
    EXPECT_NEAR(one["bounds"].get<double>(), beyond[i], 1e-6);
    EXPECT_NEAR(one["moment_change"].get<double>(), same["cases"][i]["moment_change"].get<double>(), 1e-15);
    EXPECT_NEAR(one["axial_force"].get<double>(), same["cases"][i]["axial_force"].get<double>(), 1e-9);
    EXPECT_EQ(contains_text(told.out, "case " + std::to_string(i) + ": solved: actuator 2 is held at"), i >= 2);
    EXPECT_TRUE(contains_text(told.out, where[i]));
  }
  // By a law of several coefficients equal changes of the pressure are different changes of the moment.
  const std::string straight = "\"-4 N mm/kPa\"";
  const std::string curved =
      std::string(head).replace(head.rfind(straight), straight.size(), "[\"-4 N mm/kPa\", \"-0.1 N mm/kPa^2\"]");
  const json bent =
      json_of({"study", directory.write("curved.toml", curved + "pressures = [\"0 kPa\", \"10 kPa\", \"20 kPa\"]\n")});
  const double planned = bent["cases"][0]["pressures"][1].get<double>();
  const auto law = [](double pa) { return -4e-6 * pa - 0.1e-9 * pa * pa; };
  for (const json& one : bent["cases"]) {
    const double change = one["pressure_change"].get<double>();
    EXPECT_NEAR(one["pressures"][1].get<double>(), planned + change, 1e-6);
    EXPECT_NEAR(one["moments"][1].get<double>(), law(planned + change), 1e-12);
    EXPECT_NEAR(one["moment_change"].get<double>(), law(planned + change) - law(planned), 1e-12);
  }
  expect_refused(tendril({"study", directory.write("both.toml", head + "pressures = [0]\nmoments = [0]\n")}),
                 "found 'pressures' beside 'moments'");
}

TEST(GraspOfTwoFingers, IsDescribedAsOneProgram) {
  const json described = json_of({"describe", scene_path("grasp_unequal.toml")});
  EXPECT_EQ(described["modes"].size(), 9U);
  for (const json& variable : described["variables"]) {
    if (variable["name"] == "moments") {
      EXPECT_EQ(variable["count"], 4);
    } else if (variable["name"] == "contact_force") {
      EXPECT_EQ(variable["count"], 1);
    }
  }
}

class RefusedGrasp : public testing::TestWithParam<BadScene> {};

TEST_P(RefusedGrasp, NamesThePlace) {
  const BadScene& scene = GetParam();
  expect_refused(plan_text(scene_with("grasp_unequal.toml", scene.old_text, scene.new_text)), scene.message);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, RefusedGrasp,
    testing::Values(
        BadScene{"object_diameter", "fingers = \"mirrored\"\nobject_diameter",
                 "s.toml:8:11: found \"mirrored\" beside [[finger]], expected \"both\""},
        BadScene{"object_diameter", "fingers = \"bth\"\nobject_diameter",
                 "s.toml:8:11: found \"bth\", expected one of"},
        BadScene{"[[finger]]\nlength = \"90 mm\"\nbending_stiffness = \"0.015 N m^2\"\nrest_curvature = \"-2 1/m\"\n"
                 "max_force = \"3 N\"",
                 "", "found 1 [[finger]], expected two"},
        BadScene{"length = \"90 mm\"", "length = \"60 mm\"",
                 "s.toml:33:1: found an actuator from 0.07 m to 0.06 m, expected from < to"},
        BadScene{"length = \"90 mm\"", "length = \"90 N\"", "s.toml:34:10: found \"90 N\", whose unit"},
        BadScene{"max_force = \"3 N\"", "max_force = 0", "s.toml:37:13: a grasp needs a max_force above 0"},
        BadScene{"max_force = \"3 N\"", "max_force = \"1 N\"\nmin_force = \"2 N\"",
                 "s.toml:38:13: found min_force 2 N"},
        BadScene{"problem = \"grasp\"", "problem = \"pose\"", "[gripper] needs problem = \"grasp\""},
        BadScene{"order = 6", "order = 6\nsplit_at_contact = false",
                 "s.toml:42:20: found false, but where both fingers are planned"}));

TEST(GraspOfMirroredFingers, RefusesGravityAcrossWithItsPlace) {
  const TemporaryDirectory directory;
  std::string text = read_file(scene_path("grasp_60mm.toml"));
  text.insert(0, "gravity = [0, -9.81]\n");
  text.replace(text.find("[gripper]"), 9, "[gripper]\nfingers = \"mirrored\"");
  text.replace(text.find("bending_stiffness"), 17, "linear_density = \"80 g/m\"\nbending_stiffness");
  const CommandRun run = tendril({"plan", directory.write("s.toml", text), "--json"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "s.toml:1:"));
  EXPECT_TRUE(contains_text(run.err, "gravity has a component across the axis"));
}

TEST(GraspOfTwoFingers, IsExecutedWithAMomentForEachActuatorOfBoth) {
  const CommandRun run = tendril(
      {"execute", scene_path("grasp_unequal.toml"), "--moments", "0, 0", "--set", "gripper.palm_distance=\"55 mm\""});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "found 2 moments, expected one for each of the scene's 4 actuators"));
}

}  // namespace
}  // namespace tendril::app::test
