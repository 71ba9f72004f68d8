// Measured points as spreadsheets and cameras write them: the same points in many layouts give the same estimate, and
// what cannot be read is refused where it stands, for its true cause.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;

/// A point of scenes/estimate.csv, in mm.
struct Point {
  double s = 0.0, x = 0.0, y = 0.0;
};

std::vector<Point> example_points() {
  std::vector<Point> points;
  std::istringstream lines(read_file(scene_path("estimate.csv")));
  std::string line;
  while (std::getline(lines, line)) {
    Point p;
    if (std::sscanf(line.c_str(), "%lf, %lf, %lf", &p.s, &p.x, &p.y) == 3) points.push_back(p);
  }
  return points;
}

std::string number(double value, bool comma = false) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  std::string out = text;
  if (comma) std::replace(out.begin(), out.end(), '.', ',');
  return out;
}

/// scenes/estimate.toml with points in p.csv.
std::string scene_text(const std::string& more = "") {
  return scene_with("estimate.toml", "file = \"estimate.csv\"", "file = \"p.csv\"\n" + more);
}

CommandRun plan_points(const std::string& csv, const std::string& more = "") {
  const TemporaryDirectory directory;
  directory.write("p.csv", csv);
  return tendril({"plan", directory.write("s.toml", scene_text(more)), "--json"});
}

using Write = std::function<std::string(const Point&)>;

/// What a file looks like: lines before the points, each point, what ends a line.
struct Layout {
  std::string name;
  std::string head;
  Write point;
  std::string end = "\n";
  std::string more{};  ///< keys of [measurement]
  std::string tail{};
  bool tip_first = false;
};

void PrintTo(const Layout& layout, std::ostream* out) { *out << layout.name; }

std::string written(const Layout& layout) {
  std::vector<Point> points = example_points();
  if (layout.tip_first) std::reverse(points.begin(), points.end());
  std::string text = layout.head;
  for (const Point& p : points) text += layout.point(p) + layout.end;
  return text + layout.tail;
}

Write columns(const std::string& separator, bool comma = false, const std::string& quote = "",
              const std::string& after = "") {
  return [=](const Point& p) {
    std::string text;
    for (const double v : {p.s, p.x, p.y}) text += (text.empty() ? "" : separator) + quote + number(v, comma) + quote;
    return text + after;
  };
}

Write scaled(double factor, bool with_s) {
  return [=](const Point& p) {
    return (with_s ? number(factor * p.s) + "," : "") + number(factor * p.x) + "," + number(factor * p.y);
  };
}

std::vector<Layout> layouts() {
  const std::string names = "s [mm],x [mm],y [mm]\n";
  const Write plain = columns(",");
  const Write bare = [](const Point& p) { return number(p.x) + "," + number(p.y); };
  return {
      {"plain", names, plain},
      {"byte_order_mark", "\xef\xbb\xbf" + names, plain},
      {"windows_lines", "s [mm],x [mm],y [mm]\r\n", plain, "\r\n"},
      {"macintosh_lines", "s [mm],x [mm],y [mm]\r", plain, "\r"},
      {"semicolons", "s [mm];x [mm];y [mm]\n", columns(";")},
      {"bars", "s [mm]|x [mm]|y [mm]\n", columns("|")},
      {"decimal_commas", "s [mm];x [mm];y [mm]\n", columns(";", true)},
      {"decimal_commas_between_tabs", "s [mm]\tx [mm]\ty [mm]\n", columns("\t", true)},
      {"decimal_commas_in_quotes", "\"s [mm]\",\"x [mm]\",\"y [mm]\"\n", columns(",", true, "\"")},
      {"decimal_commas_between_blanks", "s_mm x_mm y_mm\n", columns("  ", true)},
      {"tabs", "s [mm]\tx [mm]\ty [mm]\n", columns("\t")},
      {"blanks", "s [mm]  x [mm]  y [mm]\n", columns("   ")},
      {"commas_and_blanks", "s [mm], x [mm], y [mm]\n", columns(", ")},
      {"quotes", "\"s [mm]\",\"x [mm]\",\"y [mm]\"\n", columns(",", false, "\"")},
      {"trailing_comma", "s [mm],x [mm],y [mm],\n", columns(",", false, "", ",")},
      {"hint_for_spreadsheets", "sep=;\ns [mm];x [mm];y [mm]\n", columns(";")},
      {"capitals", "S [MM],X [MM],Y [MM]\n", plain},
      {"round_brackets", "S (mm),X (mm),Y (mm)\n", plain},
      {"units_behind_slashes", "s/mm,x/mm,y/mm\n", plain},
      {"units_below", "s,x,y\nmm,mm,mm\n", plain},
      {"units_below_in_brackets", "frame;s;x;y\n-;[mm];[mm];[mm]\n",
       [](const Point& p) { return "7;" + columns(";")(p); }},
      {"minus_of_typography", names,
       [](const Point& p) { return number(p.s) + "," + number(p.x) + ",\xe2\x88\x92" + number(p.y); }, "\n",
       "y_down = true"},
      {"long_name", "arc_length [mm],x [mm],y [mm]\n", plain},
      {"names_as_comment", "# s [mm],x [mm],y [mm]\n", plain},
      {"names_between_other_separators", names, columns(";")},
      {"centimetres", "s [cm],x [cm],y [cm]\n", scaled(0.1, true)},
      {"metres", "", scaled(1e-3, true)},
      {"units_in_cells", "",
       [](const Point& p) { return number(p.s) + " mm," + number(p.x) + " mm," + number(p.y) + " mm"; }},
      {"other_columns", "frame,s [mm],likelihood,x [mm],y [mm]\n",
       [](const Point& p) { return "7," + number(p.s) + ",high," + number(p.x) + "," + number(p.y); }},
      {"index_without_name", ",s [mm],x [mm],y [mm]\n", [plain](const Point& p) { return "3," + plain(p); }},
      {"other_order", "y [mm],s [mm],x [mm]\n",
       [](const Point& p) { return number(p.y) + "," + number(p.s) + "," + number(p.x); }},
      {"tip_first", names, plain, "\n", "", "", true},
      {"empty_rows_between", names, [plain](const Point& p) { return p.s == 50.0 ? ",,\n\n" + plain(p) : plain(p); }},
      {"rows_without_numbers", names,
       [plain](const Point& p) { return p.s == 50.0 ? "52,nan,NaN\n" + plain(p) : plain(p); }},
      {"empty_rows_at_the_end", names, plain, "\n", "", ",,\n,,\n"},
      {"base_marker", names + "0,0.01,-0.02\n", plain},
      {"no_arc_lengths", "x [mm],y [mm]\n", bare},
      {"no_arc_lengths_tip_first", "x [mm],y [mm]\n", bare, "\n", "", "", true},
      {"no_arc_lengths_base_marker", "x [mm],y [mm]\n0,0\n", bare},
      {"no_arc_lengths_tip_first_to_base_marker", "x [mm],y [mm]\n", bare, "\n", "", "0,0\n", true},
      {"no_arc_lengths_empty_rows_at_the_end", "x [mm],y [mm]\n", bare, "\n", "", ",\n,\n"},
      {"pixels", "s [mm],x [px],y [px]\n",
       [](const Point& p) { return number(p.s) + "," + number(20 * p.x + 100) + "," + number(400 - 20 * p.y); }, "\n",
       "scale = \"0.05 mm\"\norigin = [100, 400]\ny_down = true\n"},
      {"pixels_without_names", "", [](const Point& p) { return number(20 * p.x + 100) + "," + number(20 * p.y - 7); },
       "\n", "scale = 5e-5\norigin = [\"5 mm\", -7]\n"},
  };
}

class MeasuredLayoutTest : public testing::TestWithParam<Layout> {};

TEST_P(MeasuredLayoutTest, GivesTheSameFit) {
  const json expected = json_of({"plan", scene_path("estimate.toml")});
  const CommandRun run = plan_points(written(GetParam()), GetParam().more);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json found = json::parse(run.out);
  EXPECT_EQ(found["status"], "solved");
  ASSERT_EQ(found["contacts"].size(), 1U);
  // The same numbers to rounding.
  for (const char* key : {"force", "arc_length", "force_error", "correlation"}) {
    const double value = expected["contacts"][0][key].get<double>();
    EXPECT_NEAR(found["contacts"][0][key].get<double>(), value, 1e-8 * std::abs(value)) << key;
  }
  EXPECT_EQ(found["degrees_of_freedom"], expected["degrees_of_freedom"]);
}

INSTANTIATE_TEST_SUITE_P(Files, MeasuredLayoutTest, testing::ValuesIn(layouts()),
                         [](const auto& layout) { return layout.param.name; });

/// Whether the report says that something was left out.
bool left_out(const json& result, const std::string& what) {
  const auto& items = result["left_out"];
  return std::any_of(items.begin(), items.end(), [&](const json& item) { return item["what"] == what; });
}

TEST(MeasuredPoints, RowsThatHoldNoPointAreCounted) {
  const Layout layout{"", "s [mm],x [mm],y [mm]\n", columns(","), "\n", "", "1,nan,2\n,,\n3,4,\n"};
  const CommandRun run = plan_points(written(layout));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(left_out(json::parse(run.out), "3 of the 23 rows of p.csv")) << run.out;
  EXPECT_TRUE(contains_text(run.err, "3 of the 23 rows of p.csv")) << run.err;
}

TEST(MeasuredPoints, ColumnsThatAreNotReadAreNamed) {
  const Layout layout{"", "time,s [mm],x [mm],y [mm]\n", [](const Point& p) { return "12:30," + columns(",")(p); }};
  const CommandRun run = plan_points(written(layout));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(left_out(json::parse(run.out), "column \"time\" of p.csv")) << run.out;
}

TEST(MeasuredPoints, AMarkerAtTheBaseIsNoMeasurement) {
  const Layout layout{"", "x [mm],y [mm]\n0,0\n", [](const Point& p) { return number(p.x) + "," + number(p.y); }};
  const json result = json::parse(plan_points(written(layout)).out);
  EXPECT_TRUE(left_out(result, "the measured point at the base")) << result;
  EXPECT_EQ(result["degrees_of_freedom"], 38);
}

// 3.93701 inches are the rod's 100 mm, with the digits that a table has.
TEST(MeasuredPoints, TheTipMayBeBeyondTheRodByTheRoundingOfAnotherUnit) {
  const double inch = 25.4;
  const Layout layout{"", "s [inch],x [inch],y [inch]\n", scaled(1.0 / inch, true)};
  const CommandRun run = plan_points(written(layout));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const double force = json_of({"plan", scene_path("estimate.toml")})["contacts"][0]["force"].get<double>();
  EXPECT_NEAR(json::parse(run.out)["contacts"][0]["force"].get<double>(), force, 1e-4 * force);
}

// A lost marker keeps its place along the rod.
TEST(MeasuredPoints, WithoutArcLengthsAMissingPointKeepsItsPlace) {
  const auto text = [](bool with_arc_length) {
    std::string csv = with_arc_length ? "s [mm],x [mm],y [mm]\n" : "x [mm],y [mm]\n";
    for (const Point& p : example_points()) {
      const bool lost = p.s == 40.0;
      if (with_arc_length && !lost) csv += columns(",")(p) + "\n";
      if (!with_arc_length) csv += lost ? "NaN,NaN\n" : number(p.x) + "," + number(p.y) + "\n";
    }
    return csv;
  };
  const json expected = json::parse(plan_points(text(true)).out);
  const json found = json::parse(plan_points(text(false)).out);
  EXPECT_NEAR(found["contacts"][0]["force"].get<double>(), expected["contacts"][0]["force"].get<double>(), 1e-10);
  EXPECT_EQ(found["degrees_of_freedom"], 36);
}

struct Refused {
  const char* csv;
  const char* message;
  const char* more = "";
};

void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.csv; }

class RefusedPointsTest : public testing::TestWithParam<Refused> {};

TEST_P(RefusedPointsTest, NamesThePlaceAndTheCause) {
  expect_refused(plan_points(GetParam().csv, GetParam().more), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Files, RefusedPointsTest,
    testing::Values(
        Refused{"s;x;y\n0,005;0.005;0\n", "p.csv:2:1: found \"0,005\" in a file that has \"0.005\" too"},
        Refused{"x [mm];y [mm]\n5,065;1,128\n", "p.csv:2:1: found \"5,065\", which may mean 5.065 or thousands"},
        Refused{"s [mm],x [mm],y [mm]\n5,5,065,0,128\n",
                "p.csv:2:11: found 5 values, expected 3 as in the lines before; decimal commas need"},
        Refused{"x [mm],y [mm]\n1,2\n3,4,5\n", "p.csv:3:5: found 3 values, expected 2"},
        Refused{"x [mm],y [mm]\n1,two\n", "p.csv:2:3: found \"two\", expected a length"},
        Refused{"x [mm],y [mm]\n1,2 N\n", "p.csv:2:3: found \"2 N\", expected a length"},
        Refused{"x [mm],y [mm]\n1,inf\n", "p.csv:2:3: found \"inf\", expected a length that is finite"},
        Refused{"x [N],y [mm]\n1,2\n", "p.csv:1:1: found the unit \"N\" of the column \"x [N]\""},
        Refused{"y [mm],x [mm\n1,2\n", "p.csv:1:8: found the column \"x [mm\""},
        Refused{"frame,x [mm],x [cm]\n1,2,3\n",
                "p.csv:1:14: found the column \"x [cm]\", but the column x stands before it"},
        Refused{"a,b\n1,2\n", "p.csv:1:1: found the columns \"a\", \"b\", expected x, y or s, x, y"},
        Refused{
            "x [px],y [px]\n1,2\n",
            "p.csv:1:1: found the column \"x [px]\" in pixels, expected the length of one as 'scale' in [measurement]"},
        Refused{"1,2,3,4\n", "p.csv:1:1: found 4 values and no names above"},
        Refused{"\xff\xfe"
                "x",
                "p.csv:1:1: found UTF-16 text"},
        Refused{"x,y\n", "p.csv: found no points"}, Refused{"nan,nan\n,\n", "there are no measured points"},
        Refused{"x [mm],y [mm]\n10,0\n30,0\n100,0\n", "lie 0.07 m apart", ""},
        Refused{"97,22\n80,20\n60,10\n",
                "the points lie up to 99.5 m from the base of a rod of 0.1 m, expected them within its length: are "
                "they in mm?"},
        Refused{"0.005,97,22\n", "the points lie up to 99.5 m"},
        Refused{"5,0.005,0\n",
                "arc length 5 m, expected at least 0 and at most the rod's length, 0.1 m: are the points in mm?"},
        Refused{"s [mm],x [mm],y [mm]\n50,50,0\n110,99,0\n",
                "arc length 0.11 m, expected at least 0 and at most the rod's length, 0.1 m: are its unit and the "
                "rod's length right?"},
        Refused{"s,x,y\nmm,N,mm\n50,50,0\n", "p.csv:2:1: found \"mm\", expected a length"},
        Refused{"s [mm],x [mm],y [mm]\n0,20,5\n50,50,0\n100,99,0\n",
                "the measured point at arc length 0 lies 0.0206 m from the rod's base"},
        Refused{"1,2\n", "s.toml:18:10: found a list of 1 entry, expected a list of two entries [x, y]",
                "origin = [1]"},
        Refused{"1,2\n", "s.toml:18:9: found the number 0, expected a length greater than 0", "scale = 0"}));

/// What an estimate says of points that its scene does not explain; not solved.
std::string message_of(const std::string& csv, const std::string& old_text = "", const std::string& new_text = "") {
  const TemporaryDirectory directory;
  std::string scene = scene_text();
  if (!old_text.empty()) {
    EXPECT_TRUE(contains_text(scene, old_text));
    scene.replace(scene.find(old_text), old_text.size(), new_text);
  }
  directory.write("p.csv", csv);
  const CommandRun run = tendril({"plan", directory.write("s.toml", scene), "--json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const json result = json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["status"], "poor_fit");
  for (const json& contact : result["contacts"]) EXPECT_EQ(contact["identifiable"], false);
  return result["message"].get<std::string>();
}

TEST(PoorFit, AnArcLengthOfZeroAtTheTipIsRefused) {
  std::string csv = "s [mm],x [mm],y [mm]\n";
  for (const Point& p : example_points()) csv += columns(",")({100.0 - p.s, p.x, p.y}) + "\n";
  expect_refused(plan_points(csv), "are the points' origin and the rod's base right, and the arc lengths counted");
}

TEST(PoorFit, TellsArcLengthsFromTheTip) {
  std::string csv = "s [mm],x [mm],y [mm]\n";
  for (const Point& p : example_points()) csv += columns(",")({105.0 - p.s, p.x, p.y}) + "\n";
  EXPECT_TRUE(contains_text(message_of(csv), "are the arc lengths counted from the tip?")) << message_of(csv);
}

TEST(PoorFit, NamesTheAxesThatExplainThePoints) {
  struct Seen {
    const char* name;
    Point (*from)(const Point&);
  };
  for (const Seen& seen : {Seen{"x and y are swapped",
                                [](const Point& p) {
                                  return Point{p.s, p.y, p.x};
                                }},
                           Seen{"y points the other way",
                                [](const Point& p) {
                                  return Point{p.s, p.x, -p.y};
                                }},
                           Seen{"x points the other way", [](const Point& p) {
                                  return Point{p.s, -p.x, p.y};
                                }}}) {
    for (const double base : {0.0, 20.0}) {
      std::string csv = "s [mm],x [mm],y [mm]\n";
      for (const Point& p : example_points()) {
        const Point at = seen.from(p);
        csv += columns(",")({at.s, at.x + base, at.y - base}) + "\n";
      }
      const std::string place = "[rod.base]\nposition = [" + number(1e-3 * base) + ", " + number(-1e-3 * base) + "]\n";
      const std::string message = message_of(csv, "[measurement]", place + "[measurement]");
      EXPECT_TRUE(contains_text(message, "as if " + std::string(seen.name))) << message;
      EXPECT_TRUE(contains_text(message, "'y_down'")) << message;
    }
  }
}

TEST(PoorFit, NamesNoAxesWhereNoneExplainThePoints) {
  const std::string csv = written({"", "s [mm],x [mm],y [mm]\n", columns(",")});
  const std::string message = message_of(csv, "noise = \"0.05 mm\"", "noise = \"0.001 mm\"");
  EXPECT_FALSE(contains_text(message, "as if")) << message;
}

TEST(PoorFit, TellsPointsOfAnotherScale) {
  std::string csv = "s [mm],x [um],y [um]\n";
  for (const Point& p : example_points()) csv += columns(",")(p) + "\n";
  EXPECT_TRUE(contains_text(message_of(csv), "is their unit right?")) << message_of(csv);
}

TEST(PoorFit, TellsMomentsThatCannotBe) {
  const std::string csv = written({"", "s [mm],x [mm],y [mm]\n", columns(",")});
  for (const char* moment : {"moments = [\"2.5 N m\"]", "moments = [-0.1]"}) {
    const std::string message = message_of(csv, "moments = [\"2.5 N mm\"]", moment);
    EXPECT_TRUE(contains_text(message, "are the moments right?")) << moment << ": " << message;
  }
}

TEST(PoorFit, TellsUnequalDistances) {
  std::string csv = "x [mm],y [mm]\n";
  std::size_t i = 0;
  for (const Point& p : example_points()) {
    // Three of the first ten points were lost, and nothing stands in their place.
    if (i != 2 && i != 5 && i != 7) csv += number(p.x) + "," + number(p.y) + "\n";
    ++i;
  }
  const CommandRun run = plan_points(csv);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "expected equal distances")) << run.err;
}

TEST(PoorFit, IsAFitOfUnknownNoiseWhoseResidualsAreAShape) {
  // The rod is said to be twice as stiff as it is: the misfit is smooth.
  const std::string csv = written({"", "s [mm],x [mm],y [mm]\n", columns(",")});
  std::string scene = scene_text();
  const auto replace = [&](const std::string& from, const std::string& to) {
    scene.replace(scene.find(from), from.size(), to);
  };
  replace("noise = \"0.05 mm\"\n", "");
  replace("4.9e-4 N m^2", "2e-3 N m^2");
  replace("count = 2", "count = 1");
  const TemporaryDirectory directory;
  directory.write("p.csv", csv);
  const json result = json::parse(tendril({"plan", directory.write("s.toml", scene), "--json"}).out);
  EXPECT_EQ(result["status"], "poor_fit") << result["message"] << result["residual_rms"];
}

}  // namespace
}  // namespace tendril::app::test
