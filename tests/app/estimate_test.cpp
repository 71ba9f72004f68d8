// `tendril plan` and `tendril describe` with problem = "estimate".

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;

/// scenes/estimate.toml, with the points inside instead of in a file, and one piece of text replaced.
std::string measured_with(const std::string& measurement, const std::string& old_text = "",
                          const std::string& new_text = "") {
  std::string text = read_file(scene_path("estimate.toml"));
  const std::string file = "file = \"estimate.csv\"";
  text.replace(text.find(file), file.size(), measurement);
  if (!old_text.empty()) {
    EXPECT_TRUE(contains_text(text, old_text)) << old_text;
    text.replace(text.find(old_text), old_text.size(), new_text);
  }
  return text;
}

CommandRun plan_measured(const std::string& text, const std::string& csv = "",
                         std::vector<std::string> more = {"--json"}) {
  const TemporaryDirectory directory;
  if (!csv.empty()) directory.write("p.csv", csv);
  more.insert(more.begin(), {"plan", directory.write("s.toml", text)});
  return tendril(more);
}

TEST(Estimate, OfTheExampleFindsThePeg) {
  const CommandRun run = tendril({"plan", scene_path("estimate.toml"), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["status"], "solved");
  EXPECT_EQ(result["problem"], "estimate");
  ASSERT_EQ(result["contacts"].size(), 1U);
  const json& contact = result["contacts"][0];
  EXPECT_EQ(contact["identifiable"], true);
  // The truth of tests/reference/data/braced_arm.csv, within three of the errors that are reported.
  EXPECT_NEAR(contact["force"].get<double>(), 0.06178404562, 3.0 * contact["force_error"].get<double>());
  EXPECT_NEAR(contact["arc_length"].get<double>(), 0.05862167146, 3.0 * contact["arc_length_error"].get<double>());
  EXPECT_NEAR(contact["correlation"].get<double>(), -0.997, 0.001);
  EXPECT_NEAR(std::hypot(contact["normal"][0].get<double>(), contact["normal"][1].get<double>()), 1.0, 1e-12);
  EXPECT_GT(contact["normal"][1].get<double>(), 0.9);
  ASSERT_EQ(result["covariance"].size(), 2U);
  EXPECT_NEAR(std::sqrt(result["covariance"][0][0].get<double>()), contact["force_error"].get<double>(), 1e-12);
  EXPECT_EQ(result["tests"].size(), 3U);
  EXPECT_EQ(result["tests"][1]["supported"], true);
  EXPECT_EQ(result["tests"][2]["supported"], false);
  EXPECT_EQ(result["points"], 20);
  EXPECT_EQ(result["noise"], 5e-5);
  EXPECT_EQ(result["degrees_of_freedom"], 38);
  EXPECT_TRUE(result["plugins"].empty());
  EXPECT_EQ(result["backbone"].size(), 101U);
  EXPECT_EQ(result["moments"], json::array({2.5e-3}));
}

TEST(Estimate, WritesResultAndFigure) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"plan", scene_path("estimate.toml"), "--output", directory / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains_text(run.out, "supported by the points"));
  EXPECT_EQ(json::parse(read_file(directory / "out/result.json"))["status"], "solved");
  const std::string data = read_file(directory / "out/figure.dat");
  EXPECT_TRUE(contains_text(data, "# frame 1: measured."));
  EXPECT_TRUE(contains_text(read_file(directory / "out/figure.gnuplot"), "title 'measured'"));
  EXPECT_GT(read_file(directory / "out/figure.png").size(), 1000U);
}

TEST(Estimate, GivesNoNumberThatTheDataDoNotGive) {
  // Were each coordinate known to 1 mm only, the peg's force would be known to 32 %.
  const std::string csv = read_file(scene_path("estimate.csv"));
  const CommandRun run = plan_measured(measured_with("file = \"p.csv\"", "\"0.05 mm\"", "\"1 mm\""), csv);
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["status"], "not_identifiable");
  ASSERT_FALSE(result["contacts"].empty());
  const json& contact = result["contacts"][0];
  EXPECT_EQ(contact["identifiable"], false);
  for (const char* key : {"force", "arc_length", "point", "normal"}) EXPECT_TRUE(contact[key].is_null()) << key;
  EXPECT_NE(contact["reason"], "");
  const CommandRun table = plan_measured(measured_with("file = \"p.csv\"", "\"0.05 mm\"", "\"1 mm\""), csv, {});
  EXPECT_TRUE(contains_text(table.out, "not identifiable"));
}

TEST(Estimate, ReadsPointsInEveryForm) {
  const json file = json::parse(tendril({"plan", scene_path("estimate.toml"), "--json"}).out, nullptr, false);
  std::string with_arc_length = "points = [";
  std::string without = "points = [";
  std::string columns = "y (m), x (m)\n";
  std::istringstream lines(read_file(scene_path("estimate.csv")));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (number <= 2) continue;
    double s = 0.0;
    double x = 0.0;
    double y = 0.0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf, %lf, %lf", &s, &x, &y), 3) << line;
    char text[200];
    std::snprintf(text, sizeof text, "[\"%g mm\", \"%.3f mm\", \"%.3f mm\"],\n", s, x, y);
    with_arc_length += text;
    std::snprintf(text, sizeof text, "[%.6f, %.6f],\n", 1e-3 * x, 1e-3 * y);
    without += text;
    std::snprintf(text, sizeof text, "%.6f, %.6f\n", 1e-3 * y, 1e-3 * x);
    columns += text;
  }
  const auto force_of = [](const CommandRun& run) {
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out, nullptr, false)["contacts"][0]["force"].get<double>();
  };
  const double force = file["contacts"][0]["force"].get<double>();
  // The same dimensionless data to 12 digits.
  EXPECT_NEAR(force_of(plan_measured(measured_with(with_arc_length + "]"))), force, 1e-9 * force);
  EXPECT_NEAR(force_of(plan_measured(measured_with(without + "]"))), force, 1e-9 * force);
  EXPECT_NEAR(force_of(plan_measured(measured_with("file = \"p.csv\""), columns)), force, 1e-9 * force);
}

TEST(Estimate, IsDescribed) {
  const CommandRun run = tendril({"describe", scene_path("estimate.toml"), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["variables"][0]["name"], "coordinates");
  EXPECT_EQ(result["variables"][1]["name"], "contact_arc_length");
  EXPECT_EQ(result["variables"][2]["name"], "contact_force");
  EXPECT_EQ(result["rows"][0]["name"], "equilibrium");
  EXPECT_TRUE(result["plugins"].empty()) << result["plugins"];
}

struct BadEstimate {
  const char* measurement;
  const char* csv;
  const char* message;
};

void PrintTo(const BadEstimate& bad, std::ostream* out) { *out << bad.measurement << " " << bad.csv; }

class BadEstimateTest : public testing::TestWithParam<BadEstimate> {};

TEST_P(BadEstimateTest, IsRefusedWithItsPlace) {
  expect_refused(plan_measured(measured_with(GetParam().measurement), GetParam().csv), GetParam().message);
}

constexpr const char* from_file = "file = \"p.csv\"";

INSTANTIATE_TEST_SUITE_P(
    Measurements, BadEstimateTest,
    testing::Values(BadEstimate{"", "", "s.toml:16:1: there are no measured points"},
                    BadEstimate{"points = []", "", "s.toml:17:10: found a list of 0 entries"},
                    BadEstimate{"points = 3", "", "s.toml:17:10: found the number 3, expected a list of points"},
                    BadEstimate{"points = [[1]]", "",
                                "s.toml:17:11: found a list of 1 entry, expected a point [s, x, y] or [x, y]"},
                    BadEstimate{"points = [[1, 2], [1, 2, 3]]", "",
                                "s.toml:17:19: found a point of 3 entries, expected 2"},
                    BadEstimate{"points = [[1, nan]]", "", "s.toml:17:15: found the number nan"},
                    BadEstimate{"points = [[\"1 N\", 2]]", "", "s.toml:17:12: found \"1 N\""},
                    BadEstimate{"points = [[\"200 mm\", 0, 0], [0.1, 0, 0]]", "", "arc length 0.2 m"},
                    BadEstimate{"pints = [[1, 2]]", "", "did you mean 'points'?"},
                    BadEstimate{"points = [[0.1, 0]]\nfile = \"p.csv\"", "0.1, 0\n", "found 'file' beside 'points'"},
                    BadEstimate{"file = \"none.csv\"", "", "none.csv': No such file"},
                    BadEstimate{"file = \".\"", "", "is a directory"},
                    BadEstimate{"file = \"/dev/zero\"", "", "larger than 4 MiB"},
                    BadEstimate{from_file, "# nothing\n", "p.csv: found no points"},
                    BadEstimate{from_file, "0.1, 0\n0.2\n", "p.csv:2:1: found 1 value, expected 2"},
                    BadEstimate{from_file, "0.1, 0\n0.2, abc\n", "p.csv:2:6: found \"abc\""},
                    BadEstimate{from_file, "0.1, 0\n0.2, nan\n", "found 1 measured point, expected at least 2"},
                    BadEstimate{from_file, "0.1, 0\n0.2, \n", "found 1 measured point, expected at least 2"},
                    BadEstimate{from_file, "1, 2, 3, 4\n", "p.csv:1:1: found 4 values and no names above"},
                    BadEstimate{from_file, "x, x\n1, 2\n", "p.csv:1:4: found the column \"x\""},
                    BadEstimate{from_file, "x [N], y [mm]\n1, 2\n", "p.csv:1:1: found the unit \"N\" of the column"},
                    BadEstimate{from_file, "x [mm, y [mm]\n1, 2\n", "p.csv:1:1: found the column \"x [mm\""},
                    BadEstimate{from_file, "x\n1\n", "p.csv:1:1: found the columns \"x\", expected x, y or s, x, y"},
                    BadEstimate{from_file, "\xff\n", "p.csv:1:1: found bytes that are not UTF-8"}));

TEST(BadEstimate, NeedsItsMoments) {
  expect_refused(plan_measured(measured_with("points = [[0.1, 0]]", "moments = [\"2.5 N mm\"]", "")),
                 "s.toml:16:1: the moment of actuator 1 while the points were measured is not known");
  expect_refused(plan_measured(measured_with("points = [[0.1, 0]]", "[\"2.5 N mm\"]", "[1, 2]")), "found 2 moments");
  expect_refused(plan_measured(measured_with("points = [[0.1, 0]]", "[\"2.5 N mm\"]", "[\"2.5 N\"]")),
                 "found \"2.5 N\"");
  expect_refused(plan_measured(measured_with("points = [[0.1, 0]]", "\"0.05 mm\"", "\"0 mm\"")), "greater than 0");
  expect_refused(plan_measured(measured_with("points = [[0.1, 0], [0.1, 0]]", "count = 2", "count = 3")),
                 "expected 1 or 2");
  // A fixed actuator needs no moment beside it.
  const CommandRun run = plan_measured(measured_with("file = \"p.csv\"", "moments = [\"2.5 N mm\"]", ""),
                                       read_file(scene_path("estimate.csv")),
                                       {"--json", "--set", "rod.actuator.0={min=0.0025, max=0.0025}"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(EstimatedSequence, OfTheExampleIsWhatTheArmDid) {
  const TemporaryDirectory directory;
  const CommandRun run =
      tendril({"plan", scene_path("sequence.toml"), "--json", "--output", directory.path().string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["status"], "solved");
  ASSERT_EQ(result["frames"].size(), 48U);
  // What `tendril execute` said when the file was written, at the first frame, the highest moment and the last one.
  struct Known {
    std::size_t frame;
    int number;
    double force, arc_length;
  };
  for (const Known& known : {Known{0, 1, 0.09983, 0.05892}, {23, 2, 0.06447, 0.09646}, {47, 3, 0.09983, 0.05892}}) {
    ASSERT_EQ(result["frames"][known.frame]["contacts"].size(), 1U) << known.frame;
    const json& c = result["frames"][known.frame]["contacts"][0];
    EXPECT_EQ(c["number"], known.number);
    for (const json& told : {c, c["so_far"]}) {
      EXPECT_NEAR(told["force"].get<double>(), known.force, 3.0 * told["force_error"].get<double>());
      EXPECT_NEAR(told["arc_length"].get<double>(), known.arc_length, 3.0 * told["arc_length_error"].get<double>());
    }
    EXPECT_LE(c["force_error"].get<double>(), c["so_far"]["force_error"].get<double>());
  }
  EXPECT_EQ(result["contacts"], result["frames"][47]["contacts"]);
  EXPECT_EQ(result["measured"].size(), 20U);
  EXPECT_NEAR(result["frames"][1]["time"].get<double>(), 0.04, 1e-12);
  EXPECT_TRUE(result["rates"]["estimated"].get<bool>());
  for (const char* file : {"result.json", "figure.svg", "figure.gnuplot", "figure.dat"}) {
    EXPECT_TRUE(std::filesystem::exists(directory.path() / file)) << file;
  }
}

/// scenes/sequence.toml with another file of points.
CommandRun plan_sequence(const std::string& csv, const std::string& measurement = "noise = \"0.05 mm\"") {
  const TemporaryDirectory directory;
  directory.write("p.csv", csv);
  std::string text = scene_with("sequence.toml", "file = \"sequence.csv\"", "file = \"p.csv\"");
  text.replace(text.find("noise = \"0.05 mm\""), 17, measurement);
  return tendril({"plan", directory.write("s.toml", text), "--json"});
}

TEST(EstimatedSequence, OfNumberedFramesWithMomentsOfTheScene) {
  // The arm lies still: what counts is how the frames are told apart, and that a lost point costs none.
  std::string csv = "frame; s (mm); x (mm); y (mm)\n";
  std::istringstream lines(read_file(scene_path("estimate.csv")));
  std::vector<std::array<double, 3>> points;
  for (std::string line; std::getline(lines, line);) {
    std::array<double, 3> p{};
    if (std::sscanf(line.c_str(), "%lf, %lf, %lf", p.data(), &p[1], &p[2]) == 3) points.push_back(p);
  }
  for (const int frame : {3, 4, 7}) {
    for (const auto& [s, x, y] : points) {
      char line[80];
      const double off = 0.002 * frame;
      std::snprintf(line, sizeof line, "%d; %g; %s; %.3f\n", frame, s,
                    frame == 4 && s == 50.0 ? "" : std::to_string(x).c_str(),
                    y + (std::lround(s) % 2 == 0 ? off : -off));
      csv += line;
    }
  }
  const CommandRun run = plan_sequence(csv, "noise = \"0.05 mm\"\nmoments = [\"2.5 N mm\"]\nforce_rate = \"1 mN\"");
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
  const json result = json::parse(run.out, nullptr, false);
  ASSERT_EQ(result["frames"].size(), 3U);
  EXPECT_EQ(result["frames"][2]["frame"], 7.0);
  EXPECT_NEAR(result["rates"]["force"].get<double>(), 1e-3, 1e-15);
  EXPECT_EQ(result["frames"][1]["degrees_of_freedom"], 36);
  EXPECT_TRUE(contains_text(run.out, "1 of the 60 rows of p.csv"));
}

// A camera that begins a new file: the same frames in two files are the same sequence.
TEST(SequenceFiles, OneAfterTheOtherAreOneSequence) {
  const TemporaryDirectory directory;
  std::istringstream lines(read_file(scene_path("sequence.csv")));
  std::string head, first, second;
  while (std::getline(lines, head) && head.front() == '#') continue;
  for (std::string line; std::getline(lines, line);) (std::stod(line) < 0.5 ? first : second) += line + '\n';
  directory.write("first.csv", head + '\n' + first);
  directory.write("second.csv", head + '\n' + second);
  const auto planned = [&](const std::string& files) {
    return tendril(
        {"plan", directory.write("s.toml", scene_with("sequence.toml", "file = \"sequence.csv\"", files)), "--json"});
  };
  const CommandRun both = planned("files = [\"first.csv\", \"second.csv\"]");
  EXPECT_EQ(both.exit_code, 0) << both.err;
  const json whole = json_of({"plan", scene_path("sequence.toml")});
  EXPECT_EQ(json::parse(both.out)["frames"], whole["frames"]);
  expect_refused(planned("files = [\"second.csv\", \"first.csv\"]"), "first.csv:2:1: found time 0 s after time");
  expect_refused(planned("files = [\"first.csv\", \"first.csv\"]"), "expected an ascending time, from file to file");
  expect_refused(planned("file = \"first.csv\"\nfiles = [\"second.csv\"]"), "found 'files' beside 'file'");
  directory.write("second.csv", "s,x,y\n0.05,0.05,0\n0.1,0.1,0\n");
  expect_refused(planned("files = [\"first.csv\", \"second.csv\"]"),
                 "second.csv: found a single shape after a file with times");
}

TEST(BadSequence, IsRefusedWhereItStands) {
  const std::string head = "time [s], moment_1 [N mm], s [mm], x [mm], y [mm]\n";
  const std::string first = "0.1, 1, 50, 50, 0\n0.1, 1, 100, 100, 0\n";
  expect_refused(plan_sequence(head + first + "0.05, 1, 50, 50, 0\n"),
                 "p.csv:4:1: found time 0.05 s after time 0.1 s at ");
  expect_refused(plan_sequence(head + first + first), "p.csv:4:1: found a point at the same arc length once more");
  expect_refused(plan_sequence(head + first + ", 1, 50, 50, 0\n"), "p.csv:4:1: found a row without its time");
  expect_refused(plan_sequence(head + "0.1, 1, 50, 50, 0\n0.1, 2, 100, 100, 0\n"),
                 "p.csv:3:1: found moment_1 = 0.002 N m, but 0.001 N m before");
  expect_refused(plan_sequence(head + first + "0.2, , 50, 50, 0\n0.2, , 100, 100, 0\n"),
                 "p.csv:4:1: found no moment_1 in the frame that begins here");
  expect_refused(plan_sequence(head + first, "noise = \"0.05 mm\"\nmoments = [0]"),
                 "beside 'moments' in [measurement]");
  expect_refused(plan_sequence(head + first, "noise = \"0.05 mm\"\nforce_rate = \"1 mN\""),
                 "found 'force_rate' with a single shape");
  expect_refused(plan_sequence(head + first + "0.2, 1, 50, 50, 0\n"), "time 0.2 s: found 1 measured point");
  expect_refused(plan_sequence("time [mm], s, x, y\n0, 1, 1, 1\n"), "found the unit \"mm\" of the column");
  expect_refused(plan_sequence(head + first, "noise = \"0.05 mm\"\nplace_rate = 0"), "greater than 0");
}

TEST(BadEstimate, OfAnySizeIsRefused) {
  std::string csv;
  for (int i = 0; i < 10'001; ++i) csv += "0.01, 0\n";
  expect_refused(plan_measured(measured_with(from_file), csv), "p.csv:10001:1: found more than 10000 points");
}

TEST(BadEstimate, HasNoStart) {
  expect_refused(tendril({"plan", scene_path("estimate.toml"), "--start", "x.json"}), "--start: an estimate");
}

}  // namespace
}  // namespace tendril::app::test
