// Every kind of result that the command writes agrees with itself, with the scene, and with its own report; and a
// result that does not is seen not to.

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "command.hpp"
#include "consistency.hpp"
#include "tendril/app/scene_reader.hpp"
#include "text_consistency.hpp"

namespace tendril::results {
namespace {

using app::test::CommandRun;
using app::test::read_file;
using app::test::scene_path;
using app::test::TemporaryDirectory;
using Words = std::vector<std::string>;

std::string replaced(std::string text, const std::string& old_text, const std::string& new_text) {
  const auto at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return at == std::string::npos ? text : text.replace(at, old_text.size(), new_text);
}

std::string scaled_numbers(const std::string& text, const char* unit, double factor, const char* new_unit) {
  const std::regex quantity(std::string("\"(-?[0-9.e-]+) ") + unit + "\"");
  std::string out;
  std::size_t end = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), quantity), none; it != none; ++it) {
    const auto begin = static_cast<std::size_t>(it->position());
    out += text.substr(end, begin - end) + "\"" + std::to_string(std::stod((*it)[1]) * factor) + " " + new_unit + "\"";
    end = begin + static_cast<std::size_t>(it->length());
  }
  return out + text.substr(end);
}

/// The same scene with inches for millimetres: a rod 25.4 times as long under the same forces, so that nothing
/// dimensionless changes.
std::string in_inches(std::string text) {
  text = scaled_numbers(text, "N m\\^2", 1e6, "N in^2");
  text = scaled_numbers(text, "N m", 1e3, "N in");
  text = scaled_numbers(text, "g/m", 1e-3, "g/in");
  text = scaled_numbers(text, "1/m", 1e-3, "1/in");
  return std::regex_replace(std::regex_replace(text, std::regex(" mm/kPa"), " in/kPa"), std::regex(" mm\""), " in\"");
}

/// Two segments, one of them bent at rest, on a base that is neither at the origin nor horizontal; two actuators over a
/// part each, of which one is said to be a chamber; a load at the tip; a polygon and a wall. 3 m long.
const char* const crane = R"(
title = "A crane"
gravity = [0, -9.81]
[rod]
base = {position = ["2 m", "1 m"], angle = "30 deg"}
[[rod.segment]]
length = "180 cm"
bending_stiffness = "900 N m^2"
linear_density = "2 kg/m"
[[rod.segment]]
length = "1.2 m"
bending_stiffness = "500 N m^2"
linear_density = "1 kg/m"
rest_curvature = "-0.1 1/m"
[[rod.actuator]]
to = "2 m"
min = "-100 N m"
max = "300 N m"
moment_per_pressure = "2 N m/kPa"
[[rod.actuator]]
from = "2 m"
limit = "40 N m"
[tip_load]
mass = "1 kg"
force = ["2 N", "3 N"]
[start]
tip_angle = "0.3 rad"
[[obstacle]]
name = "sill"
shape = "polygon"
vertices = [["3.6 m", "1 m"], ["4 m", "1.3 m"], ["3.6 m", "1.6 m"], ["3.2 m", "1.3 m"]]
rounding = "10 cm"
[[obstacle]]
name = "ground"
shape = "wall"
point = [0, -3]
angle = 0
[contact]
mode = "require"
min_force = "5 N"
[target]
position = ["4.8 m", "2 m"]
angle = "0.1 rad"
[[objective]]
plugin = "tip_pose"
weight = 10
[[objective]]
plugin = "actuation_effort"
weight = 1e-3
[solver]
plugin = ")" TENDRIL_TEST_SOLVER "\"\n";

struct Run {
  const char* name;
  std::string scene;  ///< text
  Words words;        ///< the command, and what follows the scene
  int exit_code = 0;
  const char* status = "solved";
};
void PrintTo(const Run& run, std::ostream* out) { *out << run.name; }

std::string text_of(const char* scene) { return read_file(scene_path(scene)); }

std::vector<Run> runs() {
  const std::string path = replaced(text_of("trajectory.toml"), "cold_starts = true", "cold_starts = false");
  return {
      {"brace", text_of("brace.toml"), {"plan"}},
      {"brace_in_inches", in_inches(text_of("brace.toml")), {"plan", "--verify"}},
      {"free", text_of("free.toml"), {"plan"}},
      {"reach", text_of("reach_10Nmm.toml"), {"plan"}},
      {"table", text_of("table.toml"), {"plan"}},
      {"ledge", text_of("ledge.toml"), {"plan"}},
      {"two_pegs_in_inches", in_inches(text_of("two_pegs.toml")), {"plan"}},
      {"clutter", text_of("clutter.toml"), {"plan", "--set", "contact.count=1"}},
      {"crane", crane, {"plan"}},
      {"grasp", text_of("grasp_60mm.toml"), {"plan", "--verify"}},
      {"grasp_in_inches_turned",
       replaced(in_inches(text_of("grasp_60mm.toml")), "[gripper]",
                "[gripper]\nposition = [\"3 in\", \"-7 in\"]\nangle = \"40 deg\"\nfinger_angle = \"2 deg\""),
       {"plan"}},
      {"grasp_of_unequal_fingers", text_of("grasp_unequal.toml"), {"plan"}},
      {"trajectory", path, {"plan"}},
      {"trajectory_in_inches", in_inches(path), {"plan"}},
      {"estimate", text_of("estimate.toml"), {"plan"}},
      {"executed_brace", text_of("brace.toml"), {"execute", "--moments", "2.5 N mm"}},
      {"executed_between_pegs_in_inches",
       in_inches(text_of("alternating_pegs.toml")),
       {"execute", "--moments", "1 N in"}},
      {"executed_snap", text_of("snap_through.toml"), {"execute", "--moments", "-50 N mm"}},
      {"not_reached", text_of("avoid.toml"), {"plan", "--verify"}, 1, "not_converged"},
      {"out_of_time", text_of("brace.toml"), {"plan", "--set", "solver.time_limit=1e-9"}, 1, "time_limit"},
      {"infeasible",
       replaced(text_of("brace.toml"), "mode = \"allow\"", "mode = \"require\"\nmin_force = \"0.9 N\""),
       {"plan"},
       1,
       "infeasible"},
      {"lying_along_the_peg", text_of("brace.toml"), {"execute", "--moments", "-200 N mm"}, 1, "not_converged"},
  };
}

/// A scene file and a run of the command on it.
class Result : public testing::TestWithParam<Run> {
 protected:
  void SetUp() override {
    // Beside it is what it reads.
    directory_.write("estimate.csv", text_of("estimate.csv"));
    file_ = directory_.write("s.toml", GetParam().scene);
  }
  CommandRun run(const Words& more) const {
    Words words = GetParam().words;
    words.insert(words.begin() + 1, file_);
    words.insert(words.end(), more.begin(), more.end());
    const CommandRun run = app::test::tendril(words);
    EXPECT_EQ(run.exit_code, GetParam().exit_code) << run.err;
    return run;
  }

  TemporaryDirectory directory_;
  std::string file_;
};

TEST_P(Result, AgreesWithItselfAndWithItsReport) {
  const Json result = Json::parse(run({"--json"}).out);
  EXPECT_EQ(result["status"], GetParam().status) << result["message"];
  const Scene scene = app::read_scene(app::Document::read(file_), std::make_shared<app::Units>());
  for (const std::string& finding : inconsistencies(result, scene)) ADD_FAILURE() << finding;
  const std::string report = run({}).out;
  for (const std::string& line : lines_missing(report, result, scene)) {
    ADD_FAILURE() << "the report lacks: " << line << "\n" << report;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Result, testing::ValuesIn(runs()),
                         [](const auto& each) { return std::string(each.param.name); });

/// What is dimensionless, and forces, are the same in another unit of length; lengths and moments are in its
/// proportion.
TEST(Inches, ChangeNothingButLengths) {
  const TemporaryDirectory directory;
  const std::string text = text_of("brace.toml");
  const Json mm = app::test::json_of({"plan", directory.write("mm.toml", text)});
  const Json inch = app::test::json_of({"plan", directory.write("in.toml", in_inches(text))});
  // Data are rounded to 12 digits, and a plan at its optimum moves by the root of what its objective is rounded to.
  constexpr double same = 1e-7;
  const auto expect = [&](const char* pointer, double factor) {
    const double expected = factor * mm[Json::json_pointer(pointer)].get<double>();
    EXPECT_NEAR(inch[Json::json_pointer(pointer)].get<double>(), expected, same * std::abs(expected)) << pointer;
  };
  for (const char* pointer : {"/objective", "/terms/tip_pose", "/terms/actuation_effort", "/contacts/0/force",
                              "/tip/angle", "/certificate/stability", "/contacts/0/normal/0"}) {
    expect(pointer, 1.0);
  }
  for (const char* pointer : {"/tip/x", "/tip/y", "/contacts/0/arc_length", "/contacts/0/point/0", "/moments/0",
                              "/target_error", "/backbone/50/0", "/backbone/50/1", "/backbone/50/2"}) {
    expect(pointer, 25.4);
  }
  expect("/backbone/50/3", 1.0);
  expect("/backbone/50/4", 1.0 / 25.4);
}

struct Change {
  const char* pointer;
  double by;            ///< added to it
  const char* finding;  ///< part of one
};

/// The check itself: one number of a result that agrees is changed, and it is named.
void expect_seen(const Json& good, const Scene& scene, const std::vector<Change>& changes) {
  ASSERT_TRUE(inconsistencies(good, scene).empty()) << inconsistencies(good, scene).front();
  for (const Change& change : changes) {
    Json bad = good;
    Json& value = bad.at(Json::json_pointer(change.pointer));
    value = value.get<double>() + change.by;
    std::string all;
    for (const std::string& finding : inconsistencies(bad, scene)) all += finding + '\n';
    EXPECT_NE(all.find(change.finding), std::string::npos) << change.pointer << " changed, found:\n" << all;
  }
}

TEST(Consistency, SeesANumberThatIsChanged) {
  const auto scene_of = [](const char* name) {
    return app::read_scene(app::Document::read(scene_path(name)), std::make_shared<app::Units>());
  };
  expect_seen(app::test::json_of({"plan", scene_path("brace.toml")}), scene_of("brace.toml"),
              {{"/backbone/30/4", 1e-5, "curvature against the slope"},
               {"/backbone/30/3", 1e-8, "curvature against the slope"},
               {"/backbone/30/1", 1e-9, "points against the integral"},
               {"/backbone/30/2", 1e-9, "points against the integral"},
               {"/backbone/0/1", 1e-9, "x of the base"},
               {"/backbone/101/0", 1e-9, "arc length of the last row"},
               {"/tip/x", 1e-9, "x of the tip"},
               {"/tip/angle", 1e-9, "angle of the tip"},
               {"/contacts/0/arc_length", 1e-9, "point on the backbone"},
               {"/contacts/0/point/0", 1e-9, "point on the backbone"},
               {"/contacts/0/normal/1", 1e-6, "y of the normal"},
               {"/contacts/0/gap", 1e-9, "gap (m)"},
               {"/target_error", 1e-9, "target error"},
               {"/objective", 1e-10, "sum of its terms"},
               {"/terms/tip_pose", 1e-9, "tip_pose"},
               {"/moments/0", 1e-9, "actuation_effort"}});
  expect_seen(app::test::json_of({"plan", scene_path("grasp_60mm.toml")}), scene_of("grasp_60mm.toml"),
              {{"/net_force/0", 1e-9, "x of the net force"},
               {"/net_force/1", 1e-9, "y of the net force"},
               {"/palm_distance", 1e-9, "x of the object"},
               {"/grasp/object/radius", 1e-9, "radius of the object"},
               {"/grasp/axial_force", 1e-9, "axial force"},
               {"/grasp/lateral_force", 1e-9, "lateral force"},
               {"/grasp/force_to_limit/0", 1e-9, "force to its limit"},
               {"/grasp/force_by_1_mm_of_place/1", 1e-9, "1 mm of place"},
               {"/pressures/1", 1e-3, "pressure times moment per pressure"},
               {"/contacts/0/force", 1e-9, "lateral force"}});
}

}  // namespace
}  // namespace tendril::results
