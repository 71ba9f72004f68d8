// What users of such tools get wrong, in every feature: units that were forgotten or are of another kind, wrong signs,
// misspelt keys, keys that contradict each other, values at the edge. Each is answered right, asked back, or refused in
// one line that says where it stands and what was expected.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "../app/command.hpp"
#include "support/contains.hpp"

namespace tendril::app {
namespace {

using nlohmann::json;
using test::CommandRun;
using test::json_of;
using test::scene_path;
using test::TemporaryDirectory;
using test::tendril;

/// A scene of scenes/ with one key set, and what is said of that.
struct Setting {
  const char* scene;
  const char* setting;
  const char* message;
};

void PrintTo(const Setting& s, std::ostream* out) { *out << s.scene << " with " << s.setting; }

class RefusedSetting : public testing::TestWithParam<Setting> {};

TEST_P(RefusedSetting, IsNamedWithWhatWasExpected) {
  const auto& [scene, setting, message] = GetParam();
  const std::string line = std::string("--set ") + setting + ": " + message;
  const char* command = std::string(scene).starts_with("paradigms")   ? "study"
                        : std::string(scene).starts_with("calibrate") ? "calibrate"
                                                                      : "plan";
  test::expect_refused(tendril({command, scene_path(scene), "--set", setting}), line);
}

INSTANTIATE_TEST_SUITE_P(
    Friction, RefusedSetting,
    testing::Values(
        Setting{"brace.toml", "contact.friction=\"0.3 N\"", "found \"0.3 N\", which has a unit, expected a number"},
        Setting{"brace.toml", "contact.friction=\"17 deg\"", "found \"17 deg\", which has a unit, expected a number"},
        Setting{"brace.toml", "contact.friction=-0.3", "found the number -0.3, expected a number not below 0"},
        Setting{"brace.toml", "contact.frictoin=0.3",
                "found the key 'frictoin', which [contact] does not have; did you"},
        Setting{"brace.toml", "obstacle.0.friction=30", "the coefficient of friction is 30, expected 0 to 10"},
        Setting{"brace.toml", "contact.friction_state=\"any\"",
                "found \"any\" without friction, expected 'friction'"}));

INSTANTIATE_TEST_SUITE_P(
    Grippers, RefusedSetting,
    testing::Values(
        Setting{"grasp_60mm.toml", "gripper.object_mass=\"1 N\"", "found \"1 N\", whose unit is not that of a mass"},
        Setting{"grasp_60mm.toml", "gripper.object_mass=-0.1", "found the number -0.1, expected a mass not below 0"},
        Setting{"grasp_60mm.toml", "gripper.object_mass=0.1",
                "the object of 0.1 kg weighs nothing, expected 'gravity'"},
        Setting{"grasp_60mm.toml", "gripper.object_force=[\"1 kg\",0]",
                "found \"1 kg\", whose unit is not that of a force"},
        Setting{"grasp_60mm.toml", "gripper.object_force=1",
                "found the number 1, expected a list of two entries [x, y]"},
        Setting{"grasp_60mm.toml", "gripper.palm_distance_range=[0.1,0.01]", "the limits contradict each other"},
        Setting{"grasp_60mm.toml", "contact.mode=\"avoid\"", "a grasp needs contact, expected \"allow\" or"}));

INSTANTIATE_TEST_SUITE_P(Rods, RefusedSetting,
                         testing::Values(Setting{"inserted.toml", "rod.insertion.min=\"220 N\"",
                                                 "found \"220 N\", whose unit is not that of a length"},
                                         Setting{"inserted.toml", "rod.insertion.value=\"100 mm\"",
                                                 "found 0.1 m, expected at least min (0.12 m) and at"},
                                         Setting{"inserted.toml", "rod.insertion.max=\"300 mm\"",
                                                 "the rod is 0.24 m long, but 0.3 m of it are to be out"},
                                         Setting{"tendon_arm.toml", "rod.actuator.0.limit=\"2 N mm\"",
                                                 "found \"2 N mm\", whose unit is not that of a force"},
                                         Setting{"tendon_arm.toml", "rod.actuator.0.offset=0",
                                                 "a tendon bends the rod by its distance from the backbone"},
                                         Setting{"tendon_arm.toml", "rod.actuator.0.kind=\"cable\"",
                                                 "found \"cable\", expected one of \"moment\", \"tendon\""},
                                         Setting{"tendon_lengths.toml", "rod.actuator.0.limit=\"10 N\"",
                                                 "found \"10 N\", whose unit is not that of a length"},
                                         Setting{"extensible_arm.toml", "coordinates.stretch_order=1.5",
                                                 "found the number 1.5, expected a whole number"},
                                         Setting{"brace.toml", "rod.base.angle_range=[\"10 deg\"]",
                                                 "found a list of 1 entry, expected two angles"},
                                         Setting{"brace.toml", "rod.base.angle_range=[0.2,-0.2]",
                                                 "the limits contradict each other: at least 0.2 rad and"},
                                         Setting{"brace.toml", "include=\"other.toml\"",
                                                 "found 'include', expected it in the scene"}));

INSTANTIATE_TEST_SUITE_P(
    Measurements, RefusedSetting,
    testing::Values(
        Setting{"sequence.toml", "measurement.force_rate=\"1 N/s\"",
                "found \"1 N/s\", whose unit is not that of a force"},
        Setting{"sequence.toml", "measurement.rate=1",
                "found the key 'rate', which [measurement] does not have (known:"},
        Setting{"calibrate.toml", "calibrate.unknown.0.name=\"stifness\"",
                "found \"stifness\", expected one of \"stiffness\""},
        Setting{"calibrate.toml", "calibrate.unknown.0.segment=2", "found segment 2, expected 1"},
        Setting{"calibrate.toml", "calibrate.unknown.1.actuator=2", "found actuator 2, expected 1"},
        Setting{"calibrate.toml", "calibrate.unknown.1.degree=9", "found degree 9, expected 1 to 6"},
        Setting{"calibrate.toml", "calibrate.unknown.0.per=\"group\"",
                "stiffness per recording or group, expected only the"},
        Setting{"calibrate.toml", "calibrate.unknown.0.prior=1", "a prior needs its standard deviation 'prior_error'"},
        Setting{"calibrate.toml", "calibrate.unknown.1.prior_error=1", "found a 'prior_error' without the 'prior'"},
        Setting{"calibrate.toml", "calibrate.folds=1", "found 1 part, expected 0 or at least 2"},
        Setting{"calibrate.toml", "calibrate.angle_noise=0.1", "found 'angle_noise' without 'noise', expected both"},
        Setting{"brace.toml", "rod.length=\"100 mm +- -1 mm\"",
                "found \"100 mm +- -1 mm\", whose error bar is negative"},
        Setting{"brace.toml", "rod.length=\"100 mm +- 1 N\"",
                "found \"100 mm +- 1 N\", with an error bar whose unit"}));

INSTANTIATE_TEST_SUITE_P(Moved, RefusedSetting,
                         testing::Values(Setting{"brace.toml", "obstacle.0.shift=\"1 mm\"",
                                                 "found \"1 mm\", expected a list of two entries [x, y]"},
                                         Setting{"brace.toml", "obstacle.0.turn=\"90\"",
                                                 "found \"90\", a number as text without a unit, expected an angle"},
                                         Setting{"paradigms.toml", "study.obstacle={name=\"peg\",shifts=[[0,0]]}",
                                                 "found 'peg', expected the name of an"},
                                         Setting{"paradigms.toml", "study.obstacle={name=\"obstacle 1\"}",
                                                 "found neither 'shifts' nor 'turns', expected one"},
                                         Setting{"paradigms.toml", "study.target=[[1,2]]",
                                                 "found the key 'target', which [study] does not have; did you"},
                                         Setting{"paradigms.toml", "study.limits=[\"1 kPa\"]",
                                                 "found limits in Pa, but actuator 1 is told a moment"}));

/// Asked about beside the plan, in one line.
class AskedAbout : public testing::TestWithParam<Setting> {};

TEST_P(AskedAbout, ANumberWhoseUnitWasForgotten) {
  const auto& [scene, setting, message] = GetParam();
  const CommandRun run = tendril({"describe", scene_path(scene), "--set", setting});
  EXPECT_TRUE(contains_text(run.err, std::string("tendril: --set ") + setting + ": found " + message + '\n'))
      << run.err;
}

INSTANTIATE_TEST_SUITE_P(Lengths, AskedAbout,
                         testing::Values(Setting{"brace.toml", "rod.length=100",
                                                 "100 m as a length of a rod; did you mean \"100 mm\"?"},
                                         Setting{"brace.toml", "obstacle.0.center=[60,0]",
                                                 "60 m, 600 times the length of the rod; did you mean \"60 mm\"?"},
                                         Setting{"brace.toml", "obstacle.0.shift=[0,-10]",
                                                 "-10 m, 100 times the length of the rod; did you mean \"-10 mm\"?"},
                                         Setting{"brace.toml", "target.position=[97,20]",
                                                 "97 m, 970 times the length of the rod; did you mean \"97 mm\"?"},
                                         Setting{"tendon_arm.toml", "rod.actuator.0.offset=8",
                                                 "8 m, 40 times the length of the rod; did you mean \"8 mm\"?"},
                                         Setting{"ledge.toml", "obstacle.0.rounding=4",
                                                 "4 m, 40 times the length of the rod; did you mean \"4 mm\"?"},
                                         Setting{"endoscope.toml", "obstacle.0.width=16",
                                                 "16 m, 80 times the length of the rod; did you mean \"16 mm\"?"},
                                         Setting{"grasp_60mm.toml", "gripper.half_palm=20",
                                                 "20 m, 200 times the length of the rod; did you mean \"20 mm\"?"}));

INSTANTIATE_TEST_SUITE_P(
    Others, AskedAbout,
    testing::Values(Setting{"silicone_finger.toml", "rod.youngs_modulus=1",
                            "1 Pa, which is softer than any gel; did you mean \"1 MPa\"?"},
                    Setting{"silicone_finger.toml", "rod.density=1.07",
                            "1.07 kg/m^3, which is lighter than any foam; did you mean \"1.07 g/cm^3\"?"},
                    Setting{"brace.toml", "obstacle.0.turn=90",
                            "90 rad, which is more than a turn and a half; did you mean \"90 deg\"?"},
                    Setting{"brace.toml", "rod.base.angle_range=[-10,10]",
                            "-10 rad, which is more than a turn and a half; did you mean \"-10 deg\"?"},
                    Setting{"brace.toml", "rod.actuator.0.limit=2.5",
                            "2.5 N m, which would bend the rod by 81.2 turns; did you mean \"2.5 N mm\"?"}));

TEST(PlainNumbers, AreAskedAboutByEveryCommand) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"plan"}, {"execute", "--moments", "0"}, {"sensitivity"}, {"study"}}) {
    std::vector<std::string> words = command;
    words.insert(words.begin() + 1, {scene_path("brace.toml"), "--json", "--set", "obstacle.0.shift=[0,-10]"});
    if (command[0] == "study") words.insert(words.end(), {"--set", "study={limits=[\"2 N mm\"]}"});
    EXPECT_TRUE(contains_text(tendril(words).err, "did you mean \"-10 mm\"?")) << command[0];
  }
}

TEST(PlainNumbers, OfOptionsAreAskedAbout) {
  const CommandRun run = tendril({"describe", scene_path("table.toml"), "--set", "obstacle.0.angle=10"});
  EXPECT_TRUE(contains_text(run.err, "obstacle.0.angle=10: found 10 rad, which is more than a turn and a half"))
      << run.err;
}

// What has a unit is taken at its word, and so is what scenes say.
TEST(PlainNumbers, ThatCanBeMeantAreNotAskedAbout) {
  for (const char* setting : {"rod.length=\"100 m\"", "obstacle.0.center=[\"60 m\",0]", "obstacle.0.center=[0.9,0]",
                              "rod.actuator.0.limit=0.4", "rod.actuator.0.limit=\"2.5 N m\"", "target.angle=9.4"}) {
    EXPECT_EQ(tendril({"describe", scene_path("free.toml"), "--set",
                       "obstacle=[{shape=\"circle\",center=[0.2,0],radius=0.01}]", "--set", setting})
                  .err,
              "")
        << setting;
  }
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(scene_path("")))) {
    if (entry.path().extension() != ".toml" || entry.path().stem() == "calibrate") continue;
    EXPECT_FALSE(contains_text(tendril({"describe", entry.path().string()}).err, "did you mean")) << entry.path();
  }
}

// The points of a picture are pixels: many rods long, and meant.
TEST(PlainNumbers, ArePixelsOfPictures) {
  const CommandRun run = tendril({"plan", scene_path("estimate.toml"), "--json", "--set",
                                  "measurement.scale=\"0.1 mm\"", "--set", "measurement.origin=[320,240]"});
  EXPECT_FALSE(contains_text(run.err, "did you mean")) << run.err;
}

/// scenes/brace.toml with an outline from a file instead of its peg; `more`: keys of [obstacle.file].
CommandRun plan_outline(const std::string& name, const std::string& content, const std::string& more = "",
                        const std::string& shape = "shape = \"polygon\"\nrounding = \"1 mm\"") {
  const TemporaryDirectory directory;
  directory.write(name, content);
  const std::string peg = "shape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"";
  const std::string scene =
      test::brace_with(peg, "name = \"part\"\n" + shape + "\n[obstacle.file]\nname = \"" + name + "\"\n" + more + '\n');
  return tendril({"plan", directory.write("s.toml", scene), "--json"});
}

// Nothing in the scene tells that the numbers of the file are mm; that nothing reaches the part does.
TEST(FarAway, IsToldOfAnOutlineWithoutUnits) {
  const CommandRun run = plan_outline("part.csv", "x,y\n50,-20\n70,-20\n60,5\n");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "'part' lies 539 lengths of the rod away from its base: is its unit right?"))
      << run.out;
  EXPECT_FALSE(
      contains_text(plan_outline("part.csv", "x [mm],y [mm]\n50,-20\n70,-20\n60,5\n").out, "is its unit right"));
}

TEST(FarAway, IsToldOfATarget) {
  const json result = json_of({"plan", scene_path("free.toml"), "--set", "target.position=[\"97 m\", \"20 m\"]"});
  EXPECT_TRUE(
      contains_text(result["notes"].dump(), "lies out of reach, by 9.89e+04 % of the length: is its unit right?"));
}

// Whatever its ends are: what lies beside its walls is told with its depth, by plans and by execution.
TEST(Channel, HasNoRoomForABaseBesideIt) {
  const TemporaryDirectory directory;
  const std::string peg = "shape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"";
  for (const char* closed : {"none", "start", "end", "both"}) {
    const std::string scene = directory.write(
        "s.toml",
        test::brace_with(peg, std::string("name = \"pipe\"\nshape = \"channel\"\npoints = [[-0.01, 0.04], [0.2, "
                                          "0.04]]\nwidth = \"20 mm\"\nwall = \"6 mm\"\nclosed = \"") +
                                  closed + "\""));
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"plan", scene}, {"execute", scene, "--moments", "0"}}) {
      test::expect_refused(
          tendril(command),
          "pipe holds no room for the rod's base, which lies outside of it (0.03 m deep): its wall is in "
          "between, expected a base in the channel or in front of an open end");
    }
  }
}

TEST(OutlineFile, HasKeysOfItsKindOnly) {
  const std::string csv = "x [mm],y [mm]\n50,-20\n70,-20\n60,5\n";
  const std::string svg = R"(<svg width="99mm" viewBox="0 0 99 99"><rect id="a" width="9" height="9"/></svg>)";
  test::expect_refused(plan_outline("part.svg", svg, "height = \"1 mm\""),
                       "s.toml:27:10: found 'height' for part.svg, expected it with a file .stl");
  test::expect_refused(plan_outline("part.svg", svg, "plane = \"x\""), "found 'plane' for part.svg");
  test::expect_refused(plan_outline("part.csv", csv, "unit = \"1 cm\""),
                       "found 'unit' for part.csv, expected it with a file .svg or .stl");
  test::expect_refused(plan_outline("part.csv", csv, "id = \"a\""), "found 'id' for part.csv");
  test::expect_refused(plan_outline("line.csv", csv, "tolerance = \"1 mm\"", "shape = \"channel\"\nwidth = \"9 mm\""),
                       "found a 'tolerance' of a channel");
  test::expect_refused(plan_outline("body.stl", "solid a\nendsolid a\n"),
                       "found no facets, expected those of a closed");
}

// Numbers that go together need error bars; without any there is nothing to go together.
TEST(ErrorBars, AreNoneWhereACorrelationStandsAlone) {
  const CommandRun run = tendril({"plan", scene_path("brace.toml"), "--json", "--set",
                                  "correlation=[{between=[\"rod.length\",\"rod.bending_stiffness\"],value=0.5}]"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(json::parse(run.out).contains("uncertainty"));
}

TEST(ErrorBars, HaveTheSignOfTypographyToo) {
  const auto bars = [](const std::string& sign) {
    return json_of(
        {"plan", scene_path("brace.toml"), "--set", "obstacle.0.radius=8 mm" + sign + "0.2 mm"})["uncertainty"];
  };
  const json plain = bars(" +- ");
  EXPECT_GT(plain["tip"]["y"].get<double>(), 0.0);
  EXPECT_EQ(bars(" \xc2\xb1 "), plain);
  EXPECT_EQ(bars("\xc2\xb1"), plain);
}

TEST(Noise, LargerThanEverythingIsAskedAbout) {
  for (const char* scene : {"estimate.toml", "sequence.toml"}) {
    SCOPED_TRACE(scene);
    const json result = json_of({"plan", scene_path(scene), "--set", "measurement.noise=0.05"});
    EXPECT_TRUE(contains_text(result["message"].get<std::string>(), "times smaller than the noise: is 'noise' right?"))
        << result["message"];
    EXPECT_FALSE(contains_text(json_of({"plan", scene_path(scene)})["message"].get<std::string>(), "smaller than"));
  }
}

/// scenes/calibrate.toml with its recordings from 50 kPa on among the check files.
CommandRun calibrate_files(const std::string& checked, const std::string& known) {
  const TemporaryDirectory directory;
  const std::string points = test::read_file(scene_path("calibrate.csv"));
  directory.write("calibrate.csv", points.substr(0, points.find("80 kPa,")) + known);
  directory.write("check.csv", checked);
  const std::string scene = test::scene_with("calibrate.toml", "files = [\"calibrate.csv\"]",
                                             "files = [\"calibrate.csv\"]\ncheck_files = [\"check.csv\"]");
  return tendril({"calibrate", directory.write("s.toml", scene), "--json"});
}

TEST(Calibration, ChecksWhatHasItsPointsInACheckFile) {
  const std::string head = "case,s [mm],x [mm],y [mm]\n";
  const std::string points = "80 kPa,50,47,15\n80 kPa,100,80,50\n";
  // The pressure stands in a file, the points in a check file.
  const CommandRun run = calibrate_files(head + points, "80 kPa,80,,,\n");
  ASSERT_NE(run.exit_code, 2) << run.err;
  const json result = json::parse(run.out);
  for (const json& shape : result["shapes"]) {
    EXPECT_EQ(shape["check_only"], shape["name"] == "80 kPa") << shape["name"];
  }
  test::expect_refused(calibrate_files(head + points, "80 kPa,80,20,20,1\n"),
                       "check.csv:2: recording \"80 kPa\" has points among 'files' and among 'check_files'");
}

TEST(Settings, ThatDoNothingAreTold) {
  const json result = json_of({"plan", scene_path("brace.toml"), "--set", "contact.min_force=\"0.1 N\""});
  EXPECT_TRUE(contains_text(result["left_out"].dump(), "only contact mode \\\"require\\\" asks for it"))
      << result["left_out"];
}

TEST(TimeLimit, BelowWhatTheFirstSolveTakesSaysThatNoneWasMade) {
  const CommandRun run = tendril({"plan", scene_path("clutter.toml"), "--set", "solver.time_limit=1e-9"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(contains_text(run.out, ": not called\n")) << run.out;
  EXPECT_FALSE(contains_text(run.out, "not solved: failed")) << run.out;
}

}  // namespace
}  // namespace tendril::app
