#include "tendril/app/figure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {
namespace {

using test::read_file;
using test::TemporaryDirectory;
using Names = std::vector<std::string>;

Plan bent_plan(double length) {
  Plan plan;
  for (int i = 0; i <= 20; ++i) {
    const double angle = i / 20.0;
    plan.backbone.push_back(
        {length * angle, length * std::sin(angle), length * (1.0 - std::cos(angle)), angle, 1.0 / length});
    plan.start_backbone.push_back({length * angle, length * angle, 0.0, 0.0, 0.0});
  }
  plan.contacts = {{0, "peg", false, 0.5 * length, {0.48 * length, 0.12 * length}, {-0.48, 0.88}, 0.06, 0.0}};
  return plan;
}

FigureScene scene_with_peg(double length) {
  FigureScene scene;
  FigureScene::Shape peg;
  peg.name = "peg";
  for (int i = 0; i < 36; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 36.0;
    peg.outline.push_back({length * (0.5 + 0.1 * std::cos(t)), length * 0.1 * std::sin(t)});
  }
  scene.obstacles = {peg};
  scene.target = Vec2{0.9 * length, 0.4 * length};
  scene.gravity = Vec2{0.0, -9.81};
  return scene;
}

void draw(const FigureScene& scene, const Plan& plan, const TemporaryDirectory& directory) {
  StagedFiles files(directory.path());
  draw_figure(scene, plan, files, "f", {Picture::svg, Picture::png});
  files.publish();
}

TEST(Figure, IsDrawnWithItsScriptAndData) {
  const TemporaryDirectory directory;
  draw(scene_with_peg(0.1), bent_plan(0.1), directory);
  EXPECT_EQ(directory.names(), (Names{"f.dat", "f.gnuplot", "f.png", "f.svg"}));
  EXPECT_EQ(read_file(directory / "f.png").substr(1, 3), "PNG");
  const std::string svg = read_file(directory / "f.svg");
  for (const char* text : {"peg", "rod", "start", "target", "contact force", "60 mN", "x (mm)", ">g<"}) {
    EXPECT_TRUE(contains_text(svg, text)) << text;
  }
}

TEST(Figure, IsDrawnAsPdf) {
  const TemporaryDirectory directory;
  {
    StagedFiles files(directory.path());
    draw_figure(scene_with_peg(0.1), bent_plan(0.1), files, "f", {Picture::pdf});
    files.publish();
  }
  EXPECT_EQ(directory.names(), (Names{"f.dat", "f.gnuplot", "f.pdf"}));
  EXPECT_EQ(read_file(directory / "f.pdf").substr(0, 5), "%PDF-");
}

TEST(Figure, AShapeThatIsNoPlanLooksLikeNone) {
  const TemporaryDirectory directory;
  FigureScene scene = scene_with_peg(0.1);
  draw(scene, bent_plan(0.1), directory);
  const std::string good = read_file(directory / "f.svg");
  scene.doubt = "unstable";
  draw(scene, bent_plan(0.1), directory);
  const std::string bad = read_file(directory / "f.svg");
  EXPECT_TRUE(contains_text(bad, "rod (unstable)"));
  EXPECT_FALSE(contains_text(good, "rod (unstable)"));
  // Gnuplot writes colours of lines in this way.
  EXPECT_TRUE(contains_text(good, "rgb( 31,  78, 140)"));
  EXPECT_FALSE(contains_text(bad, "rgb( 31,  78, 140)"));
}

// A rod with a body is drawn as wide as it is, one without as a line.
TEST(Figure, ABodyIsDrawn) {
  const TemporaryDirectory directory;
  FigureScene scene = scene_with_peg(0.1);
  draw(scene, bent_plan(0.1), directory);
  EXPECT_FALSE(contains_text(read_file(directory / "f.dat"), "body"));
  EXPECT_FALSE(contains_text(read_file(directory / "f.gnuplot"), "body"));
  scene.rod.segments = {{0.1, 1e-3, 0.0, 0.0}};
  scene.rod.segments[0].thickness = 0.02;
  draw(scene, bent_plan(0.1), directory);
  EXPECT_TRUE(contains_text(read_file(directory / "f.dat"), "body"));
  EXPECT_TRUE(contains_text(read_file(directory / "f.gnuplot"), "'body' using 1:2 with filledcurves"));
  EXPECT_FALSE(contains_text(read_file(directory / "f.gnuplot"), "'other body'"));
}

TEST(Figure, BothFingersAreClamped) {
  const TemporaryDirectory directory;
  FigureScene scene;
  scene.gripper = GripperSpec{};
  scene.gripper->half_palm = 0.03;
  scene.base = {0.0, 0.03};
  draw(scene, bent_plan(0.1), directory);
  const std::string data = read_file(directory / "f.dat");
  const std::size_t other = data.find("# other clamp");
  ASSERT_NE(other, std::string::npos);
  EXPECT_TRUE(contains_text(data.substr(other, 400), "0 -23")) << data.substr(other, 400);
}

TEST(Figure, ChoosesTheUnitByTheSizeOfTheRod) {
  for (const auto& [length, label] :
       {std::pair(500e-6, "x (\u00b5m)"), std::pair(0.5, "x (mm)"), std::pair(5.0, "x (m)")}) {
    const TemporaryDirectory directory;
    draw(scene_with_peg(length), bent_plan(length), directory);
    EXPECT_TRUE(contains_text(read_file(directory / "f.svg"), label)) << label;
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
    const TemporaryDirectory pictures;
    FigureScene scene = scene_with_peg(0.1);
    scene.title = text;
    scene.obstacles[0].name = text;
    draw(scene, bent_plan(0.1), pictures);
    EXPECT_FALSE(std::filesystem::exists(witness)) << text;
    EXPECT_TRUE(std::filesystem::exists(pictures / "f.svg")) << text;
  }
}

TEST(Figure, NeverRunsAFileName) {
  const TemporaryDirectory directory;
  StagedFiles files(directory.path());
  draw_figure(scene_with_peg(0.1), bent_plan(0.1), files, "|touch witness; it's `touch witness`", {Picture::svg});
  // Gnuplot ran in there.
  EXPECT_FALSE(std::filesystem::exists(files.staging() / "witness"));
  files.publish();
  EXPECT_TRUE(std::filesystem::exists(directory / "|touch witness; it's `touch witness`.svg"));
}

TEST(Figure, QuotesText) {
  EXPECT_EQ(gnuplot_string("it's"), "'it\u2019s'");
  EXPECT_EQ(gnuplot_string("a\nb\x7f"), "'a b '");
}

TEST(Figure, IsDrawnWithoutAnythingButARod) {
  const TemporaryDirectory directory;
  Plan plan = bent_plan(0.1);
  plan.contacts.clear();
  plan.start_backbone.clear();
  draw({}, plan, directory);
  EXPECT_TRUE(std::filesystem::exists(directory / "f.png"));
}

TEST(Figure, IsNamedByItsKind) {
  EXPECT_EQ(picture_of("a/b.svg"), Picture::svg);
  EXPECT_EQ(picture_of("b.png"), Picture::png);
  EXPECT_EQ(picture_of("b.pdf"), Picture::pdf);
  EXPECT_THROW(picture_of("b.jpg"), InputError);
  EXPECT_THROW(picture_of("svg"), InputError);
  EXPECT_THROW(picture_of("a\nb.svg"), InputError);
  EXPECT_EQ(picture_of("it's.svg"), Picture::svg);
  EXPECT_THROW(picture_of("it''s.svg"), InputError);
}

}  // namespace
}  // namespace tendril::app
