// `tendril calibrate`.

#include <fmt/format.h>
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

/// An arm that bends and lengthens under pressure; pressures in kPa, tips in mm.
std::string stretching_arm(const std::string& actuator) {
  return "problem = \"execute\"\n[rod]\nlength = \"100 mm\"\nbending_stiffness = \"0.01 N m^2\"\n"
         "axial_stiffness = \"50 N\"\n[[rod.actuator]]\n" +
         actuator + "[coordinates]\nstretch_order = 1\n";
}

TEST(Calibrate, LawsAreWrittenAndWhatLiesBeyondThemIsTold) {
  const TemporaryDirectory directory;
  const std::string truth = stretching_arm(
      "kind = \"pressure\"\nmin = 0\nmax = \"200 kPa\"\n"
      "moment_per_pressure = [\"4e-7 N m/Pa\", \"1e-12 N m/Pa^2\"]\n"
      "force_per_pressure = [\"2e-5 N/Pa\", \"1e-10 N/Pa^2\"]\n");
  const std::string robot = directory.write("robot.toml", truth);
  std::string points = "case,pressure [kPa],x [m],y [m]\n";
  for (const int pressure : {20, 40, 60, 80, 100, 120}) {
    const json at = json_of({"execute", robot, "--pressures", std::to_string(pressure) + " kPa"});
    ASSERT_EQ(at["status"], "solved");
    points += fmt::format("{} kPa,{},{:.15g},{:.15g}\n", pressure, pressure, at["tip"]["x"].get<double>(),
                          at["tip"]["y"].get<double>());
  }
  directory.write("points.csv", points);
  const std::string looked_for = stretching_arm("limit = \"1 N m\"\n") +
                                 "[calibrate]\nfiles = [\"points.csv\"]\nnoise = \"0.01 "
                                 "mm\"\n[[calibrate.unknown]]\nname = \"moment\"\ndegree = 2\n"
                                 "[[calibrate.unknown]]\nname = \"force\"\ndegree = 2\n";
  const CommandRun run = tendril({"calibrate", directory.write("arm.toml", looked_for), "--output", directory / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const std::string fragment = read_file(directory / "out/rod.toml");
  EXPECT_FALSE(contains_text(fragment, "no place")) << fragment;
  EXPECT_FALSE(contains_text(fragment, "limit =")) << fragment;
  const std::string scene = directory.write(
      "scene.toml", "include = \"out/rod.toml\"\nproblem = \"execute\"\n[coordinates]\nstretch_order = 1\n");
  const auto executed = [&](const std::string& file, const std::string& pressure) {
    return json_of({"execute", file, "--pressures", pressure});
  };
  // Within the fitted pressures it is the robot, and nothing is said.
  const json inside = executed(scene, "90 kPa");
  const json there = executed(robot, "90 kPa");
  EXPECT_NEAR(inside["tip"]["x"].get<double>(), there["tip"]["x"].get<double>(), 1e-8);
  EXPECT_NEAR(inside["tip"]["y"].get<double>(), there["tip"]["y"].get<double>(), 1e-8);
  EXPECT_FALSE(inside.contains("notes")) << inside["notes"];
  for (const char* pressure : {"10 kPa", "150 kPa"}) {
    const json beyond = executed(scene, pressure);
    ASSERT_TRUE(beyond.contains("notes")) << pressure;
    EXPECT_TRUE(contains_text(beyond["notes"].dump(), "beyond what its rod was calibrated with (20 to 120 kPa)"))
        << beyond["notes"];
  }
}

TEST(Calibrate, ALawOfTensionIsWritten) {
  const TemporaryDirectory directory;
  const auto arm = [](const std::string& tendon) {
    return "problem = \"execute\"\n[rod]\nlength = 0.1\nbending_stiffness = 0.01\n[[rod.actuator]]\nkind = \"tendon\"\n"
           "offset = \"5 mm\"\n" +
           tendon;
  };
  const std::string robot =
      directory.write("robot.toml", arm("max = \"4 N\"\nmoment_per_tension = [\"4 N mm/N\", \"0.5 N mm/N^2\"]\n"));
  std::string points = "case,tension [N],x [m],y [m]\n";
  for (const int tension : {1, 2, 3, 4}) {
    const json at = json_of({"execute", robot, "--inputs", std::to_string(tension) + " N"});
    ASSERT_EQ(at["status"], "solved");
    EXPECT_NEAR(at["moments"][0].get<double>(), 4e-3 * tension + 0.5e-3 * tension * tension, 1e-12);
    points += fmt::format("{0} N,{0},{1:.15g},{2:.15g}\n", tension, at["tip"]["x"].get<double>(),
                          at["tip"]["y"].get<double>());
  }
  directory.write("points.csv", points);
  const std::string looked_for = arm("limit = \"5 N\"\n") +
                                 "[calibrate]\nfiles = [\"points.csv\"]\nnoise = \"0.01 mm\"\n"
                                 "[[calibrate.unknown]]\nname = \"moment\"\ndegree = 2\n";
  const CommandRun run = tendril({"calibrate", directory.write("arm.toml", looked_for), "--output", directory / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const std::string fragment = read_file(directory / "out/rod.toml");
  EXPECT_FALSE(contains_text(fragment, "no place")) << fragment;
  const std::string scene = directory.write("scene.toml", "include = \"out/rod.toml\"\nproblem = \"execute\"\n");
  const json there = json_of({"execute", robot, "--inputs", "2.5 N"});
  const json inside = json_of({"execute", scene, "--inputs", "2.5 N"});
  EXPECT_NEAR(inside["tip"]["x"].get<double>(), there["tip"]["x"].get<double>(), 1e-8);
  EXPECT_NEAR(inside["tip"]["y"].get<double>(), there["tip"]["y"].get<double>(), 1e-8);
  EXPECT_FALSE(inside.contains("notes")) << inside["notes"];
  EXPECT_NEAR(inside["inputs"][0]["tension"].get<double>(), 2.5, 1e-9);
  EXPECT_GT(inside["uncertainty"]["tip"]["y"].get<double>(), 0.0);
  EXPECT_TRUE(contains_text(json_of({"execute", scene, "--inputs", "0.5 N"})["notes"].dump(),
                            "beyond what its rod was calibrated with (1 to 4 N)"));
}

TEST(Calibrate, LoadsBeyondThoseOfTheRecordingsAreTold) {
  const TemporaryDirectory directory;
  const std::string arm =
      "problem = \"execute\"\ngravity = [0, -9.81]\n[rod]\nlength = 0.1\nbending_stiffness = 0.01\n"
      "linear_density = 0.1\n[[rod.actuator]]\nlimit = \"20 N mm\"\n[[rod.load]]\nat = 0.05\nforce = [0, 0]\n"
      "[[rod.load]]\nforce_per_length = [0, -0.1]\n";
  const std::string robot = directory.write("robot.toml", arm);
  std::string points = "case,moment [N mm],tip_fy [N],load_1_fy [N],x [m],y [m]\n";
  for (const double force : {0.0, -0.02, -0.04}) {
    for (const double moment : {0.0, 10.0}) {
      const json at = json_of({"execute", robot, "--moments", fmt::format("{} N mm", moment), "--set",
                               fmt::format("tip_load.force=[0,{}]", force), "--set",
                               fmt::format("rod.load.0.force=[0,{}]", 2.0 * force)});
      ASSERT_EQ(at["status"], "solved");
      points += fmt::format("{} N and {} N mm,{},{},{},{:.15g},{:.15g}\n", force, moment, moment, force, 2.0 * force,
                            at["tip"]["x"].get<double>(), at["tip"]["y"].get<double>());
    }
  }
  directory.write("points.csv", points);
  const std::string sought =
      "[calibrate]\nfiles = [\"points.csv\"]\nnoise = \"0.01 mm\"\n[[calibrate.unknown]]\nname = \"stiffness\"\n";
  const CommandRun run =
      tendril({"calibrate", directory.write("arm.toml", arm + sought), "--output", directory / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const std::string included = "include = \"out/rod.toml\"\ngravity = [0, -9.81]\n";
  const std::string scene = directory.write("scene.toml", included + "problem = \"execute\"\n");
  const auto notes = [&](const std::vector<std::string>& settings) {
    std::vector<std::string> words{"execute", scene, "--moments", "5 N mm"};
    for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
    const json result = json_of(words);
    return result.contains("notes") ? result["notes"].dump() : "";
  };
  EXPECT_EQ(notes({}), "");
  EXPECT_EQ(notes({"tip_load.force=[0,-0.04]", "rod.load.0.force=[0,-0.03]"}), "");
  // All of it turned together is the same.
  EXPECT_EQ(notes({"rod.base.angle=\"90 deg\"", "gravity=[9.81,0]", "rod.load.1.force_per_length=[0.1,0]"}), "");
  const std::string nothing_says = ": nothing says how true this is";
  EXPECT_TRUE(contains_text(notes({"tip_load.force=[0,-0.05]"}),
                            "the force at the tip is (0, -0.05) N along and across the rod's base, beyond what its rod "
                            "was calibrated with ((0, -0.04) to (0, 0) N)" +
                                nothing_says));
  EXPECT_TRUE(contains_text(notes({"tip_load.mass=0.01"}), "the force at the tip is (0, -0.0981) N"));
  EXPECT_TRUE(contains_text(notes({"rod.load.0.force=[0.01,0]"}), "load 1 is (0.01, 0) N"));
  EXPECT_TRUE(contains_text(notes({"rod.load.1.force_per_length=[0,-0.2]"}), "load 2 is (0, -0.2) N/m"));
  EXPECT_TRUE(contains_text(notes({"gravity=[9.81,0]"}), "gravity is (9.81, 0) m/s^2"));
  EXPECT_TRUE(contains_text(notes({"rod.base.angle=\"180 deg\""}), "gravity is (0, 9.81) m/s^2"));
  // Without a load of this kind in the recordings there is no range of it.
  const std::string more = directory.write("more.toml", included + "[[rod.load]]\nat = 0.05\nforce = [0, -0.01]\n");
  EXPECT_TRUE(contains_text(json_of({"execute", more, "--moments", "5 N mm"})["notes"].dump(),
                            "load 1 is (0, -0.01) N along and across the rod's base, beyond what its rod was "
                            "calibrated with ((0, 0) to (0, 0) N)"));
  // So do estimates, of a shape and of a film.
  const json bent = json_of({"execute", scene, "--moments", "20 N mm"});
  std::string shape = "s [m],x [m],y [m]\n";
  std::string film = "time [s],s [m],x [m],y [m]\n";
  std::string later;
  const json& backbone = bent["backbone"];
  for (std::size_t i = 1; i <= 12; ++i) {
    const json& p = backbone[i * (backbone.size() - 1) / 12];
    const std::string point =
        fmt::format("{:.15g},{:.15g},{:.15g}\n", p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
    shape += point;
    film += "0," + point;
    later += "1," + point;
  }
  directory.write("shape.csv", shape);
  directory.write("film.csv", film + later);
  const auto estimated = [&](const std::string& file) {
    return json_of(
        {"plan", directory.write("estimate.toml", included + "problem = \"estimate\"\n[measurement]\nfile = \"" + file +
                                                      "\"\nnoise = \"0.1 mm\"\nmoments = [\"20 N mm\"]\n")});
  };
  const std::string told = "actuator 1 is told 0.02 N m, beyond what its rod was calibrated with (0 to 0.01 N m)";
  EXPECT_TRUE(contains_text(estimated("shape.csv")["notes"].dump(), told)) << estimated("shape.csv");
  EXPECT_TRUE(contains_text(estimated("film.csv")["notes"].dump(), told)) << estimated("film.csv");
  // Plans say it as executions do.
  const json plan =
      json_of({"plan", directory.write("plan.toml", included + "[target]\nposition = [0.09, 0.01]\n"
                                                               "[tip_load]\nforce = [0, -0.05]\n"
                                                               "[[objective]]\nplugin = \"tip_pose\"\n")});
  EXPECT_TRUE(contains_text(plan["notes"].dump(), "the force at the tip is (0, -0.05) N")) << plan["notes"];
  expect_refused(tendril({"execute", scene, "--moments", "0", "--set", "rod.calibrated_gravity=[[0,0]]"}),
                 "found a list of 1 entry, expected two points: the least coordinates and the largest ones");
  expect_refused(tendril({"execute", scene, "--moments", "0", "--set", "rod.load.0.calibrated=[[0,1],[0,0]]"}),
                 "found a range from (0, 1) to (0, 0), expected the least coordinates first");
}

TEST(Calibrate, FrictionIsRefusedWithItsReason) {
  expect_refused(calibrate({}, "name = \"stiffness\"", "name = \"friction\""),
                 "found \"friction\", which no shape tells");
}

TEST(Calibrate, TellsWhereInTheFilesSomethingIsWrong) {
  expect_refused(calibrate({}, "x [mm]", "x [kg]"), "calibrate.csv:2:");
  expect_refused(calibrate({}, "name = \"stiffness\"", "name = \"stifness\""), "did you mean 'stiffness'?");
  expect_refused(calibrate({}, "files = [\"calibrate.csv\"]", "files = [\"nowhere.csv\"]"), "nowhere.csv");
  expect_refused(calibrate({}, "pressure [kPa]", "nothing"), "found what 0 actuators was told");
  expect_refused(tendril({"calibrate", scene_path("brace.toml")}), "the scene has no [calibrate]");
}

TEST(Calibrate, AsksAboutUnitsThatDifferBetweenFiles) {
  const TemporaryDirectory directory;
  const std::string points = read_file(scene_path("calibrate.csv"));
  directory.write("calibrate.csv", points);
  const std::string scene = directory.write(
      "s.toml", scene_with("calibrate.toml", "[\"calibrate.csv\"]", "[\"calibrate.csv\", \"more.csv\"]"));
  const auto warnings = [&](const std::string& more) {
    directory.write("more.csv", more);
    return json::parse(tendril({"calibrate", scene, "--json"}).out, nullptr, false)["warnings"].dump();
  };
  EXPECT_FALSE(contains_text(warnings("case,pressure [bar],x [cm],y [cm]\nmore,1,9,3\n"), "unit"));
  EXPECT_TRUE(
      contains_text(warnings("case,pressure,x [cm],y [cm]\nmore,1,9,3\n"),
                    "the column pressure_1 of more.csv has no unit, and is read in Pa, that of calibrate.csv has "
                    "one: is it in the unit that is meant?"));
  directory.write("calibrate.csv", "case,pressure,x [cm],y [cm]\na,1e5,9,3\nb,2e5,8,4\nc,3e5,7,5\n");
  EXPECT_TRUE(contains_text(warnings("case,pressure,x [cm],y [cm]\nmore,250,9,3\n"),
                            "the column pressure_1 of more.csv reaches 250 Pa, that of calibrate.csv 3e+05 Pa"));
}

TEST(Calibrate, TellsWhatItDidNotRead) {
  const CommandRun run = calibrate({}, "case,pressure", "humidity,pressure");
  EXPECT_TRUE(contains_text(run.out + run.err, "humidity")) << run.out << run.err;
}

}  // namespace
}  // namespace tendril::app::test
