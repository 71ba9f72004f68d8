// Pages that show results: what is drawn is what the result says.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/geometry.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;
using Arguments = std::vector<std::string>;

/// What a page draws.
json drawn(const std::string& page) {
  const std::string begin = "<script type=\"application/json\" id=\"drawing\">";
  const std::size_t from = page.find(begin);
  EXPECT_NE(from, std::string::npos);
  if (from == std::string::npos) return {};
  const std::size_t start = from + begin.size();
  return json::parse(page.substr(start, page.find("</script>", start) - start), nullptr, false);
}

/// The page that a command writes with these arguments.
std::string page_of(Arguments arguments, int exit_code = 0) {
  const TemporaryDirectory directory;
  arguments.insert(arguments.end(), {"--figure", directory / "f.html"});
  const CommandRun run = tendril(arguments);
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_EQ(directory.names(), std::vector<std::string>{"f.html"});
  return read_file(directory / "f.html");
}

double number_of(const json& frame, const std::string& name) {
  for (const json& n : frame["numbers"]) {
    if (n["name"] == name) return n["value"];
  }
  ADD_FAILURE() << "no number " << name << " in " << frame["numbers"];
  return std::nan("");
}

double apart(const json& a, const json& b) {
  return std::hypot(a[0].get<double>() - b[0].get<double>(), a[1].get<double>() - b[1].get<double>());
}

TEST(Page, ShowsAPlan) {
  const json result = json_of({"plan", scene_path("brace.toml")});
  const json drawing = drawn(page_of({"plan", scene_path("brace.toml")}));
  ASSERT_EQ(drawing["drawing"], 2);
  EXPECT_EQ(drawing["length_unit"]["name"], "mm");
  EXPECT_EQ(drawing["gravity"], json({0.0, -9.81}));
  ASSERT_EQ(drawing["frames"].size(), 1U);
  const json& frame = drawing["frames"][0];
  EXPECT_EQ(frame["target"], result["target"]);
  // Numbers are handed on as they are; points are rounded to a millionth of the rod's 100 mm.
  EXPECT_EQ(number_of(frame, "tip x"), result["tip"]["x"]);
  EXPECT_EQ(number_of(frame, "moment 1"), result["moments"][0]);
  EXPECT_EQ(number_of(frame, "force of obstacle 1"), result["contacts"][0]["force"]);
  EXPECT_EQ(frame["contacts"][0]["force"], result["contacts"][0]["force"]);
  const json& line = frame["rods"][0]["line"];
  ASSERT_EQ(line.size(), result["backbone"].size());
  EXPECT_NEAR(line.back()[0].get<double>(), result["tip"]["x"].get<double>(), 1e-7);
  EXPECT_FALSE(frame["rods"][0].contains("body"));
  ASSERT_EQ(drawing["obstacles"].size(), 1U);
  for (const json& p : drawing["obstacles"][0]["outlines"][0]) EXPECT_NEAR(apart(p, json{0.06, 0.0}), 0.008, 2e-7);
  EXPECT_FALSE(drawing["obstacles"][0].contains("ignored"));
  EXPECT_EQ(drawing["start"].size(), result["start_backbone"].size());
}

// Programs that draw go wrong with shapes that are far larger than what is in sight, and with corners that are far
// apart a shape seems to keep away from a rod that touches it.
TEST(Page, ShowsOfALargeObstacleWhatIsInSight) {
  const TemporaryDirectory directory;
  const std::string file = directory.write("large.toml", R"(
problem = "pose"
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
[[rod.actuator]]
limit = "2.5 N mm"
[[obstacle]]
shape = "circle"
center = ["-1000 m", "-1000 m"]
radius = "1414.21 m"
[contact]
mode = "avoid"
[target]
position = ["90 mm", "30 mm"]
[[objective]]
plugin = "tip_pose"
)");
  const json drawing = drawn(page_of({"plan", file}));
  ASSERT_EQ(drawing["obstacles"].size(), 1U);
  ASSERT_EQ(drawing["obstacles"][0]["outlines"].size(), 1U);
  const json& line = drawing["obstacles"][0]["outlines"][0];
  int on_surface = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const json& a = line[i];
    const json& b = line[(i + 1) % line.size()];
    EXPECT_LT(apart(a, json{0.0, 0.0}), 1.0);
    const json middle{0.5 * (a[0].get<double>() + b[0].get<double>()), 0.5 * (a[1].get<double>() + b[1].get<double>())};
    if (std::abs(apart(middle, json{-1000.0, -1000.0}) - 1414.21) < 2e-4) ++on_surface;
  }
  EXPECT_GE(on_surface, 1);
  EXPECT_LE(line.size(), 100U);
  // What is filled ends with the picture.
  json_of({"plan", file, "--output", directory / "out"});
  std::istringstream data(read_file(directory / "out/figure.dat"));
  std::string text;
  while (std::getline(data, text) && text != "# obstacle 1.") {
  }
  int filled = 0;
  Vec2 p;
  for (std::getline(data, text); std::getline(data, text) && std::sscanf(text.c_str(), "%lf %lf", &p.x, &p.y) == 2;) {
    ++filled;
    EXPECT_LT(norm(p), 200.0) << "mm, of a picture of some 150 mm";
  }
  EXPECT_GE(filled, 3);
}

TEST(Page, OfAResultOnDiskIsThePageThatTheCommandWrote) {
  const TemporaryDirectory directory;
  const Arguments plan{"plan", scene_path("clutter.toml")};
  const std::string page = page_of(plan);
  Arguments with_json = plan;
  with_json.emplace_back("--json");
  const std::string result = directory.write("r.json", tendril(with_json).out);
  const CommandRun run = tendril({"view", result, "--output", directory / "out/v.html"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  // The search's times alone differ between two runs, and a page does not show them.
  EXPECT_TRUE(page == read_file(directory / "out/v.html"));
}

TEST(Page, OfATrajectoryIsSmall) {
  const std::string page = page_of({"plan", scene_path("trajectory.toml")});
  EXPECT_LT(page.size(), 600'000U);
  const json drawing = drawn(page);
  ASSERT_EQ(drawing["frames"].size(), 45U);
  EXPECT_EQ(drawing["path"].size(), 45U);
  EXPECT_EQ(drawing["frames"][2]["label"], "step 3 of 45");
  EXPECT_EQ(drawing["frames"][2]["target"]["position"], drawing["path"][2]);
}

TEST(Page, ABodyIsAsWideAsItIs) {
  const json result = json_of({"plan", scene_path("silicone_finger.toml")});
  const json frame = drawn(page_of({"plan", scene_path("silicone_finger.toml")}))["frames"][0];
  const json& body = frame["rods"][0]["body"];
  const std::size_t count = result["backbone"].size();
  ASSERT_EQ(body.size(), 2 * count);
  for (const std::size_t i : {std::size_t{0}, count / 2, count - 1}) {
    EXPECT_NEAR(apart(body[i], body[2 * count - 1 - i]), result["thickness"][i].get<double>(), 3e-7) << i;
  }
  // A contact is drawn where the body touches, half its width from the backbone.
  const json& contact = frame["contacts"][0];
  const double depth = apart(contact["surface"], contact["point"]);
  EXPECT_GT(depth, 0.3 * result["thickness"][count - 1].get<double>());
  EXPECT_LT(depth, 0.5 * result["thickness"][0].get<double>());
}

TEST(Page, ABandIsAsWideAsFourStandardDeviations) {
  const Arguments plan{"plan", scene_path("brace.toml"), "--set", "rod.bending_stiffness=4.9e-4 N m^2 +- 5 %"};
  const json result = json_of(plan);
  const json drawing = drawn(page_of(plan));
  const json& band = drawing["frames"][0]["rods"][0]["band"];
  const std::size_t count = result["backbone"].size();
  ASSERT_EQ(band.size(), 2 * count);
  EXPECT_EQ(band.front(), band.back());
  const json& at_tip = result["uncertainty"]["shape"].back();
  const double angle = result["tip"]["angle"];
  const double x = -std::sin(angle), y = std::cos(angle);
  const double variance =
      x * x * at_tip[1].get<double>() + 2.0 * x * y * at_tip[2].get<double>() + y * y * at_tip[3].get<double>();
  EXPECT_NEAR(apart(band[count - 1], band[count]), 4.0 * std::sqrt(variance), 3e-7);
  EXPECT_GT(variance, 0.0);
}

TEST(Page, ShowsBothFingersOfAGrasp) {
  const json frame = drawn(page_of({"plan", scene_path("grasp_60mm.toml")}))["frames"][0];
  ASSERT_EQ(frame["rods"].size(), 2U);
  const json& upper = frame["rods"][0]["line"];
  const json& lower = frame["rods"][1]["line"];
  for (std::size_t i = 0; i < upper.size(); ++i) {
    EXPECT_EQ(upper[i][0], lower[i][0]);
    EXPECT_EQ(upper[i][1], -lower[i][1].get<double>());
  }
  EXPECT_EQ(frame["palm"], json({{0.0, 0.02}, {0.0, -0.02}}));
  EXPECT_EQ(frame["obstacles"][0]["name"], "object");
  EXPECT_EQ(frame["contacts"].size(), 2U);
  const json apart_fingers = drawn(page_of({"plan", scene_path("grasp_unequal.toml")}))["frames"][0];
  ASSERT_EQ(apart_fingers["rods"].size(), 2U);
  EXPECT_EQ(apart_fingers["rods"][1]["name"], "lower finger");
  EXPECT_EQ(apart_fingers["contacts"].size(), 2U);
}

TEST(Page, ShowsTheStatesBesideSnaps) {
  const TemporaryDirectory directory;
  const std::string scene = scene_path("snap_through.toml");
  ASSERT_EQ(tendril({"execute", scene, "--moments", "100 N mm", "--output", directory / "up"}).exit_code, 0);
  const Arguments execute{"execute", scene, "--moments", "-50 N mm", "--start", directory / "up/result.json"};
  const json result = json_of(execute);
  const json frames = drawn(page_of(execute))["frames"];
  ASSERT_EQ(frames.size(), 2 * result["snaps"].size() + 1);
  ASSERT_GE(frames.size(), 3U);
  EXPECT_EQ(frames[0]["label"], "before snap 1 (" + result["snaps"][0]["kind"].get<std::string>() + ")");
  EXPECT_EQ(number_of(frames[0], "share of the loads"), result["snaps"][0]["load"]);
  EXPECT_GT(apart(frames[0]["rods"][0]["line"].back(), frames[1]["rods"][0]["line"].back()), 0.01);
  EXPECT_EQ(frames.back()["label"], "at rest");
}

TEST(Page, ShowsTheCasesOfAStudy) {
  const std::string targets = "study.targets=[[\"97 mm\", \"20 mm\"]]";
  const json frames = drawn(page_of({"study", scene_path("paradigms.toml"), "--set", targets}))["frames"];
  ASSERT_EQ(frames.size(), 8U);
  EXPECT_EQ(frames[0]["label"], "case 1 of 8: ignore");
  EXPECT_EQ(frames[0]["ignored"], true);
  EXPECT_EQ(frames[2]["target"]["position"], json({0.097, 0.02}));
}

TEST(Study, FigureGoesWhereItIsAskedFor) {
  const TemporaryDirectory directory;
  const CommandRun run = tendril({"study", scene_path("paradigms.toml"), "--set",
                                  "study.targets=[[\"97 mm\", \"20 mm\"]]", "--figure", directory / "f.svg"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(directory.names(), (std::vector<std::string>{"f.dat", "f.gnuplot", "f.svg"}));
  expect_refused(tendril({"study", scene_path("paradigms.toml"), "--figure", directory / "f.gif"}),
                 "expected a name that ends in .svg, .png, .pdf or .html");
}

TEST(Page, ObstaclesThatArePlannedWithoutAreMarked) {
  const json drawing = drawn(page_of({"plan", scene_path("brace.toml"), "--set", "contact.mode=ignore"}));
  EXPECT_EQ(drawing["obstacles"][0]["ignored"], true);
}

TEST(Page, AShapeThatIsNoPlanSaysSo) {
  const json frame =
      drawn(page_of({"plan", scene_path("brace.toml"), "--set", "target.position_tolerance=1 um"}, 1))["frames"][0];
  EXPECT_NE(frame["status"], "solved");
  EXPECT_NE(frame["message"], "");
}

// Text of a scene stays text, whatever it holds.
TEST(Page, NeverRunsTextOfAScene) {
  const std::string text = "</script><script>alert(1)</script><!-- & \" '";
  const TemporaryDirectory directory;
  const std::string scene =
      directory.write("s.toml", brace_with("radius = \"8 mm\"", "radius = \"8 mm\"\nname = '''" + text + "'''"));
  const std::string page = page_of({"plan", scene, "--set", "title=" + text});
  EXPECT_FALSE(contains_text(page, "<script>alert"));
  const json drawing = drawn(page);
  EXPECT_EQ(drawing["title"], text);
  EXPECT_EQ(drawing["obstacles"][0]["name"], text);
  const auto count = [&](const std::string& part) {
    int n = 0;
    for (std::size_t at = page.find(part); at != std::string::npos; at = page.find(part, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<script"), 2);
  EXPECT_EQ(count("default-src 'none'"), 1);
  EXPECT_EQ(count("http"), 2);  // the equivalent of a header, and the name of SVG's language
}

TEST(View, SaysWhichObstaclesAreNotDrawn) {
  const TemporaryDirectory directory;
  json result = json_of({"plan", scene_path("brace.toml")});
  json without = result;
  without.erase("obstacles");
  CommandRun run = tendril({"view", directory.write("old.json", without.dump()), "--output", directory / "a.html"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "tendril: the result does not say which obstacles there were, so none are drawn\n");
  EXPECT_TRUE(drawn(read_file(directory / "a.html"))["obstacles"].empty());
  result["obstacles"][0]["shape"] = "cirle";
  run = tendril({"view", directory.write("other.json", result.dump()), "--output", directory / "b.html"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(contains_text(run.err, "'obstacle 1' is not drawn: "));
  EXPECT_TRUE(contains_text(run.err, "did you mean 'circle'?"));
}

TEST(View, RefusesWhatIsNoResult) {
  const TemporaryDirectory directory;
  const std::string page = directory / "p.html";
  const auto refused = [&](const std::string& text, const std::string& part) {
    expect_refused(tendril({"view", directory.write("r.json", text), "--output", page}), part);
    EXPECT_FALSE(std::filesystem::exists(page));
  };
  refused("rod", "is not JSON");
  refused("[]", "'/schema' is missing");
  refused(R"({"schema": 2})", "found schema 2, expected 1");
  refused(R"({"schema": 1})", "'/backbone' is missing");
  refused(R"({"schema": 1, "backbone": [], "contacts": []})", "holds no shape");
  refused(R"({"schema": 1, "backbone": [[0, 1]], "contacts": []})", "expected five numbers");
  refused(R"({"schema": 1, "backbone": [[0, 0, 0, 0, "x"]], "contacts": []})", "found string at '/backbone/0/4'");
  refused(R"({"schema": 1, "backbone": [[0,0,0,0,0],[1,1,0,0,0]], "contacts": [], "thickness": [1]})",
          "expected a number for each point of the backbone");
  refused(R"({"schema": 1, "backbone": [[0,0,0,0,0]], "contacts": [], "start_backbone": [[0]]})",
          "expected five numbers");
  refused(R"({"schema": 1, "backbone": [[0,0,0,0,0]], "contacts": [], "target": {"position": "x"}})",
          "found string at '/target/position'");
  expect_refused(tendril({"view", directory / "none.json"}), "cannot open result");
  expect_refused(tendril({"view", directory / "r.json", "--output", directory / "p.jpg"}),
                 "expected a name that ends in .svg, .png, .pdf or .html");
}

TEST(View, WritesBesideYouByTheNameOfTheResult) {
  const TemporaryDirectory directory;
  ASSERT_EQ(tendril({"plan", scene_path("brace.toml"), "--output", directory / "out"}).exit_code, 0);
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(directory.path());
  const CommandRun run = tendril({"view", directory / "out/result.json"});
  std::filesystem::current_path(before);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "wrote result.html\n");
  EXPECT_TRUE(std::filesystem::exists(directory / "result.html"));
}

}  // namespace
}  // namespace tendril::app::test
