// Obstacles whose points stand in files: tables, drawings, bodies.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/numbers.hpp"

namespace tendril::app::test {
namespace {

using std::numbers::pi;
using Line = std::vector<Vec2>;

/// A scene with one obstacle beside a file of this name.
struct Outlined {
  Outlined(const std::string& name, const std::string& content, const std::string& keys = "",
           const std::string& shape = "polygon") {
    directory.write(name, content);
    const std::string file =
        directory.write("s.toml", "[rod]\nlength = 1\nbending_stiffness = 1\n[[obstacle]]\nshape = \"" + shape +
                                      "\"\nfile = {name = \"" + name + "\"" + keys + "}\n");
    try {
      scene = read_scene(Document::read(file), std::make_shared<Units>());
    } catch (const InputError& error) {
      message = error.what();
    }
  }

  std::vector<double> list(const char* option) const {
    std::vector<double> values;
    const auto& options = scene.obstacles.at(0).options;
    if (options.find(option) == options.end()) return values;
    for (const RawValue& v : std::get<RawValue::List>(options.at(option).value))
      values.push_back(std::get<double>(v.value));
    return values;
  }
  Line points(const char* option) const {
    Line all;
    for (const RawValue& p : std::get<RawValue::List>(scene.obstacles.at(0).options.at(option).value)) {
      const auto& pair = std::get<RawValue::List>(p.value);
      all.push_back({std::get<double>(pair[0].value), std::get<double>(pair[1].value)});
    }
    return all;
  }
  std::vector<Line> outlines() const {
    const Line all = points("vertices");
    std::vector<double> sizes = list("outlines");
    if (sizes.empty()) sizes.push_back(static_cast<double>(all.size()));
    std::vector<Line> lines;
    std::size_t at = 0;
    for (const double size : sizes) {
      const std::size_t end = at + static_cast<std::size_t>(size);
      lines.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at), all.begin() + static_cast<std::ptrdiff_t>(end));
      at = end;
    }
    return lines;
  }

  /// The first of them.
  Line outline() const { return outlines().at(0); }

  TemporaryDirectory directory;
  Scene scene;
  std::string message;
};

double area(const Line& line) {
  double sum = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i) sum += 0.5 * cross(line[i], line[(i + 1) % line.size()]);
  return sum;
}

double area(const std::vector<Line>& lines) {
  double sum = 0.0;
  for (const Line& line : lines) sum += area(line);
  return sum;
}

/// Distance to a polygon, negative inside.
double distance(const Line& line, Vec2 p) {
  double least = infinity;
  double winding = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec2 a = line[i] - p;
    const Vec2 b = line[(i + 1) % line.size()] - p;
    const double t = std::clamp(-dot(a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    least = std::min(least, norm(a + t * (b - a)));
    winding += std::atan2(cross(a, b), dot(a, b));
  }
  return std::abs(winding) > pi ? -least : least;
}

TEST(OutlineFile, ATableHoldsAPolygonWithHolesAndItsPlace) {
  const Outlined r("part.csv",
                   "x [mm];y [mm];outline\n0;0;1\n30;0;1\n30;30;1\n0;30;1\n0;0;1\n10;10;2\n10;20;2\n20;20;2\n20;10;2\n",
                   R"(, position = ["1 m", 0], angle = "90 deg")");
  ASSERT_EQ(r.message, "");
  const std::vector<Line> lines = r.outlines();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].size(), 4U);
  EXPECT_NEAR(area(lines[0]), 9e-4, 1e-15);
  EXPECT_NEAR(area(lines[1]), -1e-4, 1e-15);
  EXPECT_NEAR(lines[0][1].x, 1.0, 1e-15);
  EXPECT_NEAR(lines[0][1].y, 0.03, 1e-15);
}

TEST(OutlineFile, ATableHoldsAChannelWithItsWidths) {
  const Outlined r("pipe.csv", "x,y,width\n0,0,0.1\n1,0,0.2\n", "", "channel");
  ASSERT_EQ(r.message, "");
  EXPECT_EQ(r.points("points").size(), 2U);
  EXPECT_EQ(r.list("widths"), (std::vector<double>{0.1, 0.2}));
}

// Noisy and smooth outlines: what is left has fewer corners, contains all that there was, and stays within the
// tolerance.
TEST(OutlineFile, WithATolerancePolygonsGrowToHaveFewerCorners) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  for (int trial = 0; trial < 30; ++trial) {
    Line line;
    constexpr int corners = 300;
    std::string table = "x,y\n";
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * pi * i / corners;
      const double radius =
          1.0 + 0.3 * std::cos((3 + trial % 4) * angle) + (trial % 2 == 0 ? 0.005 * noise(random) : 0.0);
      line.push_back(radius * Vec2{std::cos(angle), std::sin(angle)});
      table += fmt::format("{:.17g},{:.17g}\n", line.back().x, line.back().y);
    }
    const double tolerance = 0.01 * (1 + trial % 4);
    const Outlined r("part.csv", table, fmt::format(", tolerance = {}", tolerance));
    ASSERT_EQ(r.message, "");
    const Line fewer = r.outline();
    EXPECT_LT(fewer.size(), 200U);
    for (const Vec2 p : line) EXPECT_LE(distance(fewer, p), 1e-12);
    for (std::size_t i = 0; i < fewer.size(); ++i) {
      for (const double t : {0.0, 0.25, 0.5, 0.75}) {
        EXPECT_LE(distance(line, fewer[i] + t * (fewer[(i + 1) % fewer.size()] - fewer[i])), tolerance * (1.0 + 1e-9));
      }
    }
  }
}

const char* const drawing = R"svg(<?xml version="1.0"?>
<!-- 0.5 mm for each unit -->
<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 200 100">
<defs><circle id="unseen" r="4"/></defs>
<g id="all" transform="translate(10,20) scale(2)">
<path id="nonzero" d="M0 0h10v10H0zM2,2 v6 h6 v-6z"/>
<path id="evenodd" fill-rule="evenodd" d="M0 0h10v10H0zm2,2h6v6h-6z m2,2 h2v2h-2z"/>
<path id="curves" d="M 0,0 C 0,-10 20,-10 20,0 S 40,10 40,0 Q 50,30 20,30 T 0,0 z"/>
<path id="arcs" d="M10,30A20,20 0,0,1 50,30 20 20 0 0190,30Q90,60 50,90 Q10,60 10,30z"/>
</g>
<rect id="rect" x="5mm" y="1" width="20" height="10" rx="3"/>
<circle id="circle" cx="50" cy="50" r="10" transform="rotate(30 50 50)"/>
<ellipse id="ellipse" cx="50" cy="50" rx="10" ry="4" style="display:inline"/>
<polygon id="polygon" points="0,0 10,0 10,10"/>
<text id="text">no outline</text>
</svg>)svg";

Outlined drawn(const std::string& id, const std::string& more = "") {
  return {"part.svg", drawing, ", id = \"" + id + "\"" + more};
}

TEST(OutlineFile, ADrawingHasItsAreaAndItsPlace) {
  // Square millimetres: a unit is 0.5 mm, and 1 mm in the group.
  const std::vector<std::pair<const char*, double>> areas{
      {"nonzero", 100.0 - 36.0}, {"evenodd", 100.0 - 36.0 + 4.0}, {"rect", 0.25 * (200.0 - (4.0 - pi) * 9.0)},
      {"circle", 25.0 * pi},     {"ellipse", 10.0 * pi},          {"polygon", 12.5}};
  for (const auto& [id, exact] : areas) {
    const Outlined r = drawn(id, ", tolerance = \"1 um\"");
    ASSERT_EQ(r.message, "") << id;
    EXPECT_GE(area(r.outlines()), 1e-6 * exact * (1.0 - 1e-9)) << id;
    EXPECT_LE(area(r.outlines()), 1e-6 * exact + 1e-6 * 0.06) << id;
  }
  for (const Vec2 p : drawn("circle", ", tolerance = \"10 um\"").outline()) {
    const double away = norm(p - Vec2{0.025, -0.025});
    EXPECT_GE(away, 0.005 * (1.0 - 1e-8));
    EXPECT_LE(away, 0.005 + 1e-5);
  }
  EXPECT_NEAR(area(drawn("circle", ", unit = \"1 m\"").outlines()), 100.0 * pi, 1.0);
}

TEST(OutlineFile, CurvesOfADrawingLieInsideOfItsSides) {
  for (const char* id : {"curves", "arcs"}) {
    const Outlined coarse = drawn(id, ", tolerance = \"0.5 mm\"");
    const Outlined fine = drawn(id, ", tolerance = \"1 um\"");
    ASSERT_EQ(coarse.message + fine.message, "") << id;
    EXPECT_LT(coarse.outline().size(), 60U) << id;
    for (const Vec2 p : fine.outline()) EXPECT_LE(distance(coarse.outline(), p), 1e-6) << id;
    for (const Vec2 p : coarse.outline()) EXPECT_LE(distance(fine.outline(), p), 5e-4) << id;
  }
}

// Its two halves have the same area, one to the left and one to the right. What crosses itself is refused by the shape.
TEST(OutlineFile, ALineOfADrawingThatCrossesItselfIsNotPassedOver) {
  for (const char* rule : {"nonzero", "evenodd"}) {
    const Outlined r("part.svg",
                     fmt::format("<svg><rect width=\"2\" height=\"2\"/><path d=\"M0 9\"/><path d=\"M1 9L3 8z\"/>"
                                 "<path fill-rule=\"{}\" d=\"M9 0L14 5V0L9 5z\"/></svg>",
                                 rule));
    ASSERT_EQ(r.message, "");
    ASSERT_EQ(r.outlines().size(), 2U);
    EXPECT_NEAR(area(r.outlines()[1]), 0.0, 1e-15);
  }
}

TEST(OutlineFile, WhatADrawingHoldsBesideOutlinesIsTold) {
  const Outlined r("part.svg", drawing);
  ASSERT_EQ(r.message, "");
  ASSERT_EQ(r.scene.left_out.size(), 2U);
  EXPECT_EQ(r.scene.left_out[0].what, "1 <text> of part.svg");
  EXPECT_TRUE(contains_text(r.scene.left_out[1].what, "crossings of outlines of part.svg: "));
}

// Bodies that overlap are one, which a report tells; lines of one path that cross have no rule that all readers share.
TEST(OutlineFile, CrossingOutlinesAreTold) {
  const std::string squares = "x,y,part\n0,0,1\n2,0,1\n2,2,1\n0,2,1\n1,1,2\n3,1,2\n3,3,2\n1,3,2\n";
  const Outlined table("part.csv", squares + "9,9,3\n10,9,3\n9,10,3\n");
  ASSERT_EQ(table.message, "");
  ASSERT_EQ(table.scene.left_out.size(), 1U);
  EXPECT_EQ(table.scene.left_out[0].what, "crossings of outlines of part.csv: 1 and 2");
  const Outlined touching("part.csv", "x,y,part\n0,0,1\n2,0,1\n2,2,1\n0,2,1\n2,0,2\n4,0,2\n4,2,2\n2,2,2\n");
  EXPECT_TRUE(touching.scene.left_out.empty());
  const Outlined two("part.svg",
                     R"(<svg><rect width="20" height="20"/><rect x="10" y="9" width="20" height="20"/></svg>)");
  ASSERT_EQ(two.message, "");
  ASSERT_EQ(two.scene.left_out.size(), 1U);
  EXPECT_EQ(two.scene.left_out[0].what, "crossings of outlines of part.svg: 1 and 2");
  for (const char* rule : {"nonzero", "evenodd"}) {
    const Outlined one(
        "part.svg", fmt::format("<svg>\n<path fill-rule=\"{}\" d=\"M0 0h20v20h-20zM10 9h20v20h-20z\"/></svg>", rule));
    EXPECT_TRUE(contains_text(one.message, "part.svg:2:1: found lines 1 and 2 of one path that cross each other"));
  }
}

/// A box from the origin to (2, 3, 4), its facets counterclockwise from outside, without the first `missing` of them.
std::vector<std::array<std::array<float, 3>, 3>> box(std::size_t missing = 0) {
  const std::array<std::array<int, 4>, 6> sides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  const auto corner = [](int i) {
    return std::array<float, 3>{(i & 1) != 0 ? 2.0F : 0.0F, (i & 2) != 0 ? 3.0F : 0.0F, (i & 4) != 0 ? 4.0F : 0.0F};
  };
  std::vector<std::array<std::array<float, 3>, 3>> all;
  for (const auto& s : sides) {
    all.push_back({corner(s[0]), corner(s[1]), corner(s[2])});
    all.push_back({corner(s[0]), corner(s[2]), corner(s[3])});
  }
  all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(missing));
  return all;
}

std::string binary(std::size_t missing = 0) {
  std::string bytes(80, ' ');
  const auto facets = box(missing);
  const auto count = static_cast<std::uint32_t>(facets.size());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& facet : facets) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(facet.data()), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string text() {
  std::string all = "solid box\n";
  for (const auto& facet : box()) {
    all += "facet normal 0 0 0\nouter loop\n";
    for (const auto& p : facet) all += fmt::format("vertex {} {:e} +{}\n", p[0], p[1], p[2]);
    all += "endloop\nendfacet\n";
  }
  return all + "endsolid box\n";
}

TEST(OutlineFile, ABodyHasItsSections) {
  for (const std::string& content : {binary(), text()}) {
    const std::vector<std::pair<const char*, Vec2>> sizes{{"z", {2, 3}}, {"x", {3, 4}}, {"y", {4, 2}}};
    for (const auto& [plane, size] : sizes) {
      for (const char* height : {"0.5 mm", "1 mm", "1.7 mm"}) {
        const Outlined r("body.stl", content, fmt::format(R"(, plane = "{}", height = "{}")", plane, height));
        ASSERT_EQ(r.message, "");
        ASSERT_EQ(r.outlines().size(), 1U);
        EXPECT_NEAR(area(r.outlines()), 1e-6 * size.x * size.y, 1e-9 * size.x * size.y);
        Vec2 high{};
        for (const Vec2 p : r.outline()) high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        EXPECT_NEAR(high.x, 1e-3 * size.x, 1e-8);
        EXPECT_NEAR(high.y, 1e-3 * size.y, 1e-8);
      }
    }
  }
}

/// A tube of so many facets as a file, written piece by piece: a cylinder around z of radius 10 and height 1.
void write_tube(const std::filesystem::path& path, int sides, int layers, bool binary) {
  std::ofstream file(path, std::ios::binary);
  const auto count = static_cast<std::uint32_t>(2 * sides * layers);
  if (binary) {
    file << std::string(80, ' ');
    file.write(reinterpret_cast<const char*>(&count), 4);
  } else {
    file << "solid tube\n";
  }
  const auto at = [&](int side, int layer) {
    const double angle = 2.0 * pi * (side % sides) / sides;
    return std::array<float, 3>{static_cast<float>(10.0 * std::cos(angle)), static_cast<float>(10.0 * std::sin(angle)),
                                static_cast<float>(layer) / static_cast<float>(layers)};
  };
  const auto facet = [&](const std::array<std::array<float, 3>, 3>& corners) {
    if (binary) {
      std::array<char, 50> bytes{};
      std::memcpy(bytes.data() + 12, corners.data(), sizeof corners);
      file.write(bytes.data(), bytes.size());
      return;
    }
    file << "facet normal 0 0 0\nouter loop\n";
    for (const auto& p : corners) file << fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", p[0], p[1], p[2]);
    file << "endloop\nendfacet\n";
  };
  for (int layer = 0; layer < layers; ++layer) {
    for (int side = 0; side < sides; ++side) {
      facet({at(side, layer), at(side + 1, layer), at(side + 1, layer + 1)});
      facet({at(side, layer), at(side + 1, layer + 1), at(side, layer + 1)});
    }
  }
}

/// KiB of memory that this process has held at most.
long most_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// 60 MB of facets as numbers and 20 MB of text: read piece by piece, of which the section alone is kept.
TEST(OutlineFile, ALargeBodyIsReadPieceByPiece) {
  for (const bool binary : {true, false}) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory / "body.stl";
    write_tube(path, 1000, binary ? 600 : 50, binary);
    ASSERT_GT(std::filesystem::file_size(path), std::uintmax_t{4} << 20);
    const std::string scene =
        directory.write("s.toml",
                        "[rod]\nlength = 1\nbending_stiffness = 1\n[[obstacle]]\nshape = \"polygon\"\nfile = {name = "
                        "\"body.stl\", height = \"0.512345 mm\", tolerance = \"1 um\"}\n");
    const long before = most_memory();
    const Scene read = read_scene(Document::read(scene), std::make_shared<Units>());
    EXPECT_LT(most_memory() - before, 16 * 1024);
    const auto& corners = std::get<RawValue::List>(read.obstacles.at(0).options.at("vertices").value);
    EXPECT_GT(corners.size(), 100U);
    for (const RawValue& corner : corners) {
      const auto& p = std::get<RawValue::List>(corner.value);
      EXPECT_NEAR(std::hypot(std::get<double>(p[0].value), std::get<double>(p[1].value)), 0.01, 2e-6);
    }
  }
}

TEST(OutlineFile, RefusesABodyThatIsTooLargeBeforeItIsRead) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write(
      "s.toml",
      "[rod]\nlength = 1\nbending_stiffness = 1\n[[obstacle]]\nshape = \"polygon\"\nfile = {name = \"body.stl\"}\n");
  std::ofstream(directory / "body.stl") << "solid";
  std::filesystem::resize_file(directory / "body.stl", (std::uintmax_t{256} << 20) + 1);
  try {
    (void)read_scene(Document::read(scene), std::make_shared<Units>());
    FAIL() << "nothing was refused";
  } catch (const InputError& error) {
    EXPECT_TRUE(contains_text(error.what(), "body.stl' is larger than 256 MiB, the most that is read"));
  }
}

TEST(OutlineFile, RefusesWhatHoldsNoOutline) {
  const auto refused = [](const Outlined& r, const std::string& reason) {
    EXPECT_TRUE(contains_text(r.message, reason));
  };
  refused({"part.svg", "<svg>\n<rect x=\"9\" width=\"-2\" height=\"2\"/></svg>"},
          "part.svg:2:1: found width = \"-2\", expected a length that is not negative");
  refused({"body.stl", "solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 nan 1\n"},
          "facet 1 has a vertex that is not finite");
  refused({"part.csv", "x,y\n0,0\n1,\n0,1\n"}, "part.csv: point 2 of 3 has an empty value");
  refused({"part.csv", "x,y\n0,0\n1,0\n0,1\n", "", "circle"}, "s.toml:6:8: found a file for the shape 'circle'");
  refused({"part.svg", "<svg><text>a</text><image/></svg>"},
          "found 1 <image>, 1 <text> and no outline, expected paths");
  refused({"part.svg", "<svg>\n<path d=\"M 0 0 L 1 x\"/></svg>"}, "part.svg:2:1: found 'x' at character 11 of a path");
  refused({"part.svg", "<svg>\n<path d=\"L 0 0\"/></svg>"}, "expected M, with which a path begins");
  refused({"part.svg", "<svg><path d=\"M0 0\"></svg>"}, "part.svg:1:23: this is no SVG: mismatched tag");
  refused({"part.svg", "<html/>"}, "found <html>, expected <svg>");
  refused({"part.svg", "<svg width=\"100%\" viewBox=\"0 0 9 9\"/>"}, "found width = \"100%\", expected a length");
  refused({"part.svg", "<svg><g transform=\"spin(3)\"/></svg>"}, "found transform = \"spin(3)\"");
  refused({"part.svg", "<svg><rect width=\"50%\"/></svg>"}, "found width = \"50%\"");
  refused(drawn("circel"), "nothing has the id 'circel'; did you mean 'circle'?");
  refused(drawn("circle", ", tolerance = 0"), "found a tolerance of 0");
  refused({"body.stl", binary(1), R"(, plane = "x", height = "1 mm")"}, "not closed at the section: a side ends at (");
  refused({"body.stl", binary(), R"(, height = "5 mm")"},
          "found nothing at z = 0.005 m, expected a height between 0 m");
  refused({"body.stl", binary() + "x"}, "found neither");
  refused({"body.stl", "no body"}, "found neither an STL in text");
  refused({"body.stl", "solid a\nvertex 0 0 0\nvertex 0 q 0\n"},
          "body.stl:3: found 'q', expected a number of a vertex");
  refused({"body.stl", "solid a\nvertex 0 0 0\n"}, "found 1 vertices, expected three");
  refused({"part.svg", std::string(std::size_t{5} << 20, ' ')}, "part.svg");
}

}  // namespace
}  // namespace tendril::app::test
