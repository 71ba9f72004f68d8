// Pictures of results by gnuplot.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app::test {
namespace {

using nlohmann::json;
using Names = std::vector<std::string>;

/// A rod that bends over a peg.
json bent_result(double length) {
  json result{{"schema", 1},
              {"status", "solved"},
              {"title", ""},
              {"problem", "pose"},
              {"gravity", {0.0, -9.81}},
              {"target", {{"position", {0.9 * length, 0.4 * length}}}},
              {"obstacles",
               {{{"name", "peg"}, {"shape", "circle"}, {"center", {0.5 * length, 0.0}}, {"radius", 0.1 * length}}}}};
  for (int i = 0; i <= 20; ++i) {
    const double angle = i / 20.0;
    result["backbone"].push_back(
        {length * angle, length * std::sin(angle), length * (1.0 - std::cos(angle)), angle, 1.0 / length});
    result["start_backbone"].push_back({length * angle, length * angle, 0.0, 0.0, 0.0});
  }
  result["contacts"] = {{{"obstacle", "peg"},
                         {"obstacle_index", 0},
                         {"arc_length", 0.5 * length},
                         {"point", {0.48 * length, 0.12 * length}},
                         {"normal", {-0.48, 0.88}},
                         {"force", 0.06}}};
  return result;
}

/// Draws it as `name`.
void draw(const json& result, const TemporaryDirectory& directory, const std::string& name = "f.svg") {
  const TemporaryDirectory place;
  const CommandRun run = tendril({"view", place.write("r.json", result.dump()), "--output", directory / name});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

std::string drawn(const json& result, const std::string& file = "f.svg") {
  const TemporaryDirectory directory;
  draw(result, directory);
  return read_file(directory / file);
}

/// The rows of a block of a data file.
std::istringstream block_of(const std::string& data, const std::string& name) {
  const std::size_t at = data.find("# " + name + '\n');
  EXPECT_NE(at, std::string::npos) << name;
  if (at == std::string::npos) return {};
  return std::istringstream(data.substr(data.find('\n', data.find('\n', at) + 1) + 1));
}

TEST(Figure, IsDrawnWithItsScriptAndData) {
  const TemporaryDirectory directory;
  draw(bent_result(0.1), directory);
  draw(bent_result(0.1), directory, "g.png");
  draw(bent_result(0.1), directory, "h.pdf");
  EXPECT_EQ(directory.names(),
            (Names{"f.dat", "f.gnuplot", "f.svg", "g.dat", "g.gnuplot", "g.png", "h.dat", "h.gnuplot", "h.pdf"}));
  EXPECT_EQ(read_file(directory / "g.png").substr(1, 3), "PNG");
  EXPECT_EQ(read_file(directory / "h.pdf").substr(0, 5), "%PDF-");
  const std::string svg = read_file(directory / "f.svg");
  for (const char* text : {"peg", "rod", "start", "target", "contact force", "60 mN", "x (mm)", ">g<"}) {
    EXPECT_TRUE(contains_text(svg, text)) << text;
  }
  EXPECT_FALSE(contains_text(svg, "friction"));
}

TEST(Figure, AShapeThatIsNoPlanLooksLikeNone) {
  json result = bent_result(0.1);
  const std::string good = drawn(result);
  result["status"] = "unstable";
  const std::string bad = drawn(result);
  EXPECT_TRUE(contains_text(bad, "rod (unstable)"));
  EXPECT_FALSE(contains_text(good, "rod (unstable)"));
  // Gnuplot writes colours of lines in this way.
  EXPECT_TRUE(contains_text(good, "rgb( 31,  78, 140)"));
  EXPECT_FALSE(contains_text(bad, "rgb( 31,  78, 140)"));
}

// A rod with a body is drawn as wide as it is, one without as a line.
TEST(Figure, ABodyIsDrawn) {
  json result = bent_result(0.1);
  EXPECT_FALSE(contains_text(drawn(result, "f.gnuplot"), "body"));
  result["thickness"] = std::vector<double>(21, 0.02);
  EXPECT_TRUE(contains_text(drawn(result, "f.dat"), "# frame 1: body 1."));
  EXPECT_TRUE(contains_text(drawn(result, "f.gnuplot"), "'frame 1: body 1.' using 1:2 with filledcurves"));
}

// Around a grasped object, in the scale of the arrows: the largest force, of a newton's part, is 16 mm long.
TEST(Figure, ForcesHeldOnAnObjectAreDrawn) {
  json result = bent_result(0.1);
  result["problem"] = "grasp";
  result["grasp"] = {
      {"object", {{"center", {0.05, 0.03}}, {"radius", 0.01}}},
      {"friction", {{"coefficient", 0.3}, {"held_forces", {{0.5, 0.0}, {0.0, 1.0}, {-0.5, 0.0}, {0.0, -1.0}}}}}};
  EXPECT_TRUE(contains_text(drawn(result), "forces held"));
  std::istringstream rows = block_of(drawn(result, "f.dat"), "frame 1: hold.");
  double x[5] = {}, y[5] = {};
  for (int i = 0; i < 5; ++i) rows >> x[i] >> y[i];
  EXPECT_EQ(x[0], x[4]);
  EXPECT_NEAR(0.5 * (x[0] + x[2]), 50.0, 1e-3);
  EXPECT_NEAR(0.5 * (y[1] + y[3]), 30.0, 1e-3);
  EXPECT_NEAR(y[1] - y[3], 2.0 * (x[0] - x[2]), 1e-3);
}

// Forces under friction: what they may be, and what they are.
TEST(Figure, FrictionIsDrawn) {
  json result = bent_result(0.1);
  result["obstacles"][0]["friction"] = 0.5;
  result["contacts"][0]["tangential_force"] = 0.01;
  const std::string svg = drawn(result);
  EXPECT_TRUE(contains_text(svg, "friction cone"));
  EXPECT_TRUE(contains_text(svg, "force along the rod"));
  // The cone's sides, in mm: from the contact by the arrow of 16 mm, and half of it to either side.
  std::istringstream rows = block_of(drawn(result, "f.dat"), "frame 1: cones.");
  double x[3] = {}, y[3] = {};
  for (int i = 0; i < 3; ++i) rows >> x[i] >> y[i];
  const double size = std::hypot(0.48, 0.88);
  EXPECT_NEAR(std::hypot(0.5 * (x[1] + x[2]) - x[0], 0.5 * (y[1] + y[2]) - y[0]), 16.0 * size, 1e-3);
  EXPECT_NEAR(std::hypot(x[1] - x[2], y[1] - y[2]), 16.0 * size * size, 1e-3);
  // What acts along the rod does so from the base to the tip.
  double slip[4] = {};
  std::istringstream row = block_of(drawn(result, "f.dat"), "frame 1: slips.");
  for (double& number : slip) row >> number;
  EXPECT_GT(slip[2], 0.0);
  EXPECT_NEAR(std::hypot(slip[2], slip[3]), 16.0 * size / 6.0, 1e-3);
}

// Of a part with a hole only its own lines are stroked, none between them.
TEST(Figure, AHoleIsOne) {
  json result = bent_result(0.1);
  result["obstacles"] = {{{"name", "part"},
                          {"shape", "polygon"},
                          {"rounding", 0.001},
                          {"vertices",
                           {{0.0, -0.05},
                            {0.04, -0.05},
                            {0.04, -0.01},
                            {0.0, -0.01},
                            {0.01, -0.04},
                            {0.01, -0.02},
                            {0.03, -0.02},
                            {0.03, -0.04}}},
                          {"outlines", {4, 4}}}};
  std::istringstream lines = block_of(drawn(result, "f.dat"), "edge 1.");
  int count = 0;
  std::string first, last;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) {
      if (first.empty()) first = line;
      last = line;
      continue;
    }
    if (first.empty()) break;
    EXPECT_EQ(first, last) << "closed";
    ++count;
    first.clear();
  }
  EXPECT_EQ(count, 2);
}

TEST(Figure, BothFingersAreClamped) {
  const TemporaryDirectory directory;
  ASSERT_EQ(tendril({"plan", scene_path("grasp_60mm.toml"), "--figure", directory / "f.svg"}).exit_code, 0);
  for (const int finger : {1, 2}) {
    // A line across the base, which is 20 mm from the middle of the palm.
    double x[2] = {}, y[2] = {};
    block_of(read_file(directory / "f.dat"), "frame 1: clamp " + std::to_string(finger) + '.') >> x[0] >> y[0] >>
        x[1] >> y[1];
    EXPECT_NEAR(0.5 * (x[0] + x[1]), 0.0, 1e-6);
    EXPECT_NEAR(0.5 * (y[0] + y[1]), finger == 1 ? 20.0 : -20.0, 1e-6);
  }
}

TEST(Figure, ChoosesTheUnitByTheSizeOfTheRod) {
  for (const auto& [length, label] :
       {std::pair(500e-6, "x (\u00b5m)"), std::pair(0.5, "x (mm)"), std::pair(5.0, "x (m)")}) {
    EXPECT_TRUE(contains_text(drawn(bent_result(length)), label)) << label;
  }
}

// Each of these would run a command, if it reached gnuplot unprotected.
TEST(Figure, NeverRunsTextOfAScene) {
  const TemporaryDirectory directory;
  const std::string witness = directory / "witness";
  for (const std::string& text :
       {"`touch " + witness + "`", "'; system('touch " + witness + "'); print '", "\n!touch " + witness + "\n",
        "a\"`touch " + witness + "`\"", "\\'\n!touch " + witness, "'' . system('touch " + witness + "')",
        "a'''' . system('touch " + witness + "') . ''", "a' . system('touch " + witness + "') . '",
        "@x $(touch " + witness + ")", "\r!touch " + witness}) {
    json result = bent_result(0.1);
    result["title"] = text;
    result["obstacles"][0]["name"] = text;
    const TemporaryDirectory pictures;
    draw(result, pictures);
    EXPECT_FALSE(std::filesystem::exists(witness)) << text;
    EXPECT_TRUE(std::filesystem::exists(pictures / "f.svg")) << text;
  }
}

TEST(Figure, NeverRunsAFileName) {
  const TemporaryDirectory directory;
  draw(bent_result(0.1), directory, "|touch witness; it's `touch witness`.svg");
  EXPECT_EQ(directory.names().size(), 3U);
  EXPECT_FALSE(std::filesystem::exists(directory / "witness"));
  EXPECT_TRUE(std::filesystem::exists(directory / "|touch witness; it's `touch witness`.svg"));
}

TEST(Figure, QuotesText) {
  EXPECT_EQ(gnuplot_string("it's"), "'it\u2019s'");
  EXPECT_EQ(gnuplot_string("a\nb\x7f"), "'a b '");
}

TEST(Figure, IsDrawnWithoutAnythingButARod) {
  json result = bent_result(0.1);
  for (const char* key : {"gravity", "target", "start_backbone", "status", "title"}) result.erase(key);
  result["contacts"] = json::array();
  result["obstacles"] = json::array();
  EXPECT_TRUE(contains_text(drawn(result), "rod"));
}

TEST(Figure, IsNamedByItsKind) {
  EXPECT_EQ(picture_of("a/b.svg"), Picture::svg);
  EXPECT_EQ(picture_of("b.png"), Picture::png);
  EXPECT_EQ(picture_of("b.pdf"), Picture::pdf);
  EXPECT_EQ(picture_of("b.html"), Picture::page);
  EXPECT_THROW(picture_of("b.jpg"), InputError);
  EXPECT_THROW(picture_of("svg"), InputError);
  EXPECT_THROW(picture_of("a\nb.svg"), InputError);
  EXPECT_EQ(picture_of("it's.svg"), Picture::svg);
  EXPECT_THROW(picture_of("it''s.svg"), InputError);
}

/// Pictures in a GIF, told by the blocks that begin them; 0: it is none, or not whole.
int pictures_in(const std::string& gif) {
  if (gif.substr(0, 4) != "GIF8" || gif.back() != ';') return 0;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(gif.at(at)); };
  const auto table = [](int flags) {
    return (flags & 0x80) != 0 ? std::size_t{3} << ((flags & 7) + 1) : std::size_t{0};
  };
  std::size_t at = 13 + table(byte(10));
  int count = 0;
  const auto skip = [&] {
    while (byte(at) != 0) at += byte(at) + 1U;
    ++at;
  };
  while (byte(at) != ';') {
    if (byte(at) == 0x21) {
      at += 2;
    } else {
      ++count;
      at += 11 + table(byte(at + 9));
    }
    skip();
  }
  return at + 1 == gif.size() ? count : 0;
}

TEST(Movie, HasAFrameForEachStepStateOrCase) {
  const TemporaryDirectory directory;
  ASSERT_EQ(
      tendril({"plan", scene_path("trajectory.toml"), "--movie", directory / "t.gif", "--output", directory / "out"})
          .exit_code,
      0);
  EXPECT_EQ(directory.names(), (Names{"out", "t.gif"}));
  EXPECT_EQ(pictures_in(read_file(directory / "t.gif")), 45);
  ASSERT_EQ(tendril({"view", directory / "out/result.json", "--output", directory / "v.gif"}).exit_code, 0);
  EXPECT_TRUE(read_file(directory / "v.gif") == read_file(directory / "t.gif"));
  const std::string targets = R"(study.targets=[["97 mm", "20 mm"]])";
  const CommandRun study =
      tendril({"study", scene_path("paradigms.toml"), "--set", targets, "--movie", directory / "s.gif"});
  EXPECT_EQ(study.exit_code, 0) << study.err;
  EXPECT_EQ(pictures_in(read_file(directory / "s.gif")), 8);
}

/// PATH while it lives.
class Path {
 public:
  explicit Path(const std::string& value) : before_(::getenv("PATH")) { ::setenv("PATH", value.c_str(), 1); }
  ~Path() { ::setenv("PATH", before_.c_str(), 1); }
  Path(const Path&) = delete;
  Path& operator=(const Path&) = delete;

 private:
  std::string before_;
};

/// Makes `name` a program that does this, the directory one to look for it.
void put_program(const TemporaryDirectory& directory, const std::string& name, const std::string& script) {
  std::filesystem::permissions(directory.write(name, "#!/bin/sh\n" + script), std::filesystem::perms::owner_all);
}

TEST(Movie, OfFfmpegGetsAPictureForEachFrame) {
  const TemporaryDirectory directory, programs;
  json result{{"schema", 1}, {"problem", "trajectory"}, {"obstacles", json::array()}};
  for (int i = 0; i < 3; ++i) result["steps"].push_back(bent_result(0.1));
  const std::string file = directory.write("r.json", result.dump());
  const std::vector<std::string> view{"view", file, "--output", directory / "m.mp4"};
  // One that writes how many pictures there are, and of what, where the movie is to be.
  put_program(programs, "ffmpeg",
              "for last; do :; done\nls frame-*.png | wc -l > \"$last\"\nhead -c 4 frame-00002.png >> \"$last\"\n");
  const Path path(programs.path().string() + ':' + ::getenv("PATH"));
  EXPECT_EQ(tendril(view).exit_code, 0);
  EXPECT_EQ(read_file(directory / "m.mp4"), "3\n\x89PNG");
  EXPECT_EQ(directory.names(), (Names{"m.mp4", "r.json"}));
  // What fails leaves the movie of before as it is.
  put_program(programs, "ffmpeg", "for last; do :; done\necho half > \"$last\"\necho no such codec >&2\nexit 3\n");
  expect_refused(tendril(view), "no movie: ffmpeg failed:\nno such codec");
  EXPECT_EQ(read_file(directory / "m.mp4"), "3\n\x89PNG");
  EXPECT_EQ(directory.names(), (Names{"m.mp4", "r.json"}));
}

TEST(Movie, WithoutItsProgramsIsRefusedBeforeTheWork) {
  const TemporaryDirectory directory, programs;
  const Path path(programs.path().string());
  // The scene is not even read.
  expect_refused(tendril({"plan", "none.toml", "--movie", directory / "m.gif"}),
                 "no movie: gnuplot, which draws it, is not installed");
  put_program(programs, "gnuplot", "exit 1\n");
  expect_refused(tendril({"plan", "none.toml", "--movie", directory / "m.mp4"}),
                 "no movie: ffmpeg, which writes .mp4, is not installed");
  EXPECT_TRUE(directory.names().empty());
}

TEST(Movie, OfOneFrameIsRefusedAndLeavesNothing) {
  const TemporaryDirectory directory;
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--movie", directory / "m.gif"}),
                 "the result has one frame");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--movie", directory / "m.webm"}),
                 "found the movie 'm.webm', expected a name that ends in .gif or .mp4");
  EXPECT_TRUE(directory.names().empty());
}

}  // namespace
}  // namespace tendril::app::test
