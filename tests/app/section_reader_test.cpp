// Sections and loads of a rod as scenes state them.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/scene_reader.hpp"

namespace tendril::app::test {
namespace {

using std::numbers::pi;

struct Read {
  explicit Read(const std::string& rod, const std::string& table = "") {
    if (!table.empty()) directory.write("section.csv", table);
    const std::string file = directory.write("s.toml", rod);
    try {
      scene = read_scene(Document::read(file), std::make_shared<Units>());
    } catch (const InputError& error) {
      message = error.what();
    }
  }
  const SegmentSpec& segment(std::size_t i = 0) const { return scene.rod.segments.at(i); }
  static double along(double start, const std::vector<double>& more, double x) {
    double value = 0.0;
    for (auto c = more.rbegin(); c != more.rend(); ++c) value = (value + *c) * x;
    return start + value;
  }

  TemporaryDirectory directory;
  Scene scene;
  std::string message;
};

TEST(SectionReader, ARoundSectionHasItsStiffnessAndMass) {
  const Read r(
      "[rod]\nlength = 0.1\nyoungs_modulus = \"1 MPa\"\ndensity = \"1070 kg/m^3\"\ndiameter = [\"10 mm\", \"6 mm\"]\n"
      "inner_diameter = [\"4 mm\", \"3 mm\"]\n");
  ASSERT_EQ(r.message, "");
  ASSERT_EQ(r.scene.rod.segments.size(), 1U);
  const SegmentSpec& s = r.segment();
  for (const double x : {0.0, 0.3, 1.0}) {
    const double outer = 0.01 - 0.004 * x;
    const double inner = 0.004 - 0.001 * x;
    const double stiffness = 1e6 * pi / 64.0 * (std::pow(outer, 4) - std::pow(inner, 4));
    EXPECT_NEAR(Read::along(s.bending_stiffness, s.more_bending_stiffness, x), stiffness, 1e-13 * 1e-3);
    const double mass = 1070.0 * pi / 4.0 * (outer * outer - inner * inner);
    EXPECT_NEAR(Read::along(s.linear_density, s.more_linear_density, x), mass, 1e-14);
    EXPECT_NEAR(Read::along(s.thickness, s.more_thickness, x), outer, 1e-15);
  }
}

TEST(SectionReader, AnEvenSectionHasNothingThatChanges) {
  const Read r("[rod]\nlength = 0.1\nyoungs_modulus = \"1 MPa\"\ndensity = 1070\ndiameter = \"10 mm\"\n");
  ASSERT_EQ(r.message, "");
  EXPECT_NEAR(r.segment().bending_stiffness, 1e6 * pi / 64.0 * 1e-8, 1e-18);
  EXPECT_TRUE(r.segment().more_bending_stiffness.empty());
  EXPECT_TRUE(r.segment().more_linear_density.empty());
  EXPECT_EQ(r.segment().thickness, 0.01);
  EXPECT_TRUE(r.segment().more_thickness.empty());
}

TEST(SectionReader, AStatedStiffnessMayHaveABody) {
  const Read r("[rod]\nlength = 0.1\nbending_stiffness = 1e-3\nthickness = [0.01, 0.004]\n");
  ASSERT_EQ(r.message, "");
  EXPECT_EQ(r.segment().bending_stiffness, 1e-3);
  EXPECT_EQ(r.segment().thickness, 0.01);
  ASSERT_EQ(r.segment().more_thickness.size(), 1U);
  EXPECT_NEAR(r.segment().more_thickness[0], -0.006, 1e-17);
}

TEST(SectionReader, ATableIsLinearBetweenItsRows) {
  const Read r("[rod]\nfile = \"section.csv\"\n",
               "s (mm),bending_stiffness (N m^2),diameter (mm),rest_curvature (1/m)\n0,4e-4,10,0\n20,3e-4,9,1\n"
               "40,2e-4,8,2\n100,1e-4,8,2\n");
  ASSERT_EQ(r.message, "");
  // The second row lies on the line between its neighbours.
  ASSERT_EQ(r.scene.rod.segments.size(), 2U);
  EXPECT_NEAR(r.segment(0).length, 0.04, 1e-15);
  EXPECT_NEAR(r.segment(0).bending_stiffness, 4e-4, 1e-18);
  EXPECT_NEAR(r.segment(0).more_bending_stiffness.at(0), -2e-4, 1e-18);
  EXPECT_NEAR(r.segment(0).more_rest_curvature.at(0), 2.0, 1e-15);
  EXPECT_NEAR(r.segment(1).thickness, 0.008, 1e-15);
  EXPECT_TRUE(r.segment(1).more_thickness.empty());
  EXPECT_NEAR(r.scene.rod.length(), 0.1, 1e-15);
}

TEST(SectionReader, ATableOfDiametersIsRoundSections) {
  const Read r("[[rod.segment]]\nlength = 0.1\nfile = \"section.csv\"\nyoungs_modulus = 1e6\ndensity = 1000\n",
               "s,diameter\n0,0.01\n0.1,0.005\n");
  ASSERT_EQ(r.message, "");
  ASSERT_EQ(r.scene.rod.segments.size(), 1U);
  EXPECT_EQ(r.segment().more_bending_stiffness.size(), 4U);
  EXPECT_NEAR(Read::along(r.segment().linear_density, r.segment().more_linear_density, 1.0), 1000.0 * pi / 4.0 * 25e-6,
              1e-15);
}

TEST(SectionReader, TorsionGoesAlongTheRodAsItsBendingStiffness) {
  const Read unknown("[rod]\nlength = 0.1\nbending_stiffness = 3\n");
  EXPECT_EQ(unknown.segment().torsional_stiffness, 0.0);
  EXPECT_EQ(unknown.segment().out_of_plane_stiffness, 0.0);
  EXPECT_FALSE(unknown.scene.guided_in_plane);
  const Read round(
      "guided_in_plane = true\n[rod]\nlength = 0.1\nyoungs_modulus = 1e6\ndiameter = [0.01, 0.005]\npoisson_ratio = "
      "0.5\n");
  EXPECT_NEAR(round.segment().torsional_stiffness, round.segment().bending_stiffness / 1.5, 1e-18);
  EXPECT_TRUE(round.scene.guided_in_plane);
  const Read table("[rod]\nfile = \"section.csv\"\ntorsional_stiffness = 1e-4\nout_of_plane_stiffness = 8e-4\n",
                   "s,EI\n0,4e-4\n0.04,2e-4\n0.1,3e-4\n");
  ASSERT_EQ(table.message, "");
  EXPECT_NEAR(table.segment(0).torsional_stiffness, 1e-4, 1e-18);
  EXPECT_NEAR(table.segment(1).torsional_stiffness, 5e-5, 1e-18);
  EXPECT_NEAR(table.segment(1).out_of_plane_stiffness, 4e-4, 1e-18);
}

TEST(SectionReader, FingersHaveTheTorsionOfTheRodUnlessTheyAreMadeOfOtherStuff) {
  const auto torsion = [](const std::string& finger) {
    const Read r(
        "problem = \"grasp\"\n[rod]\nlength = 0.1\nbending_stiffness = 3\ntorsional_stiffness = 2\n"
        "[gripper]\nhalf_palm = 0.02\nobject_diameter = 0.02\n[[finger]]\n" +
        finger + "[[finger]]\n");
    EXPECT_EQ(r.message, "");
    return r.scene.fingers.at(0).rod.segments.at(0).torsional_stiffness;
  };
  EXPECT_EQ(torsion(""), 2.0);
  EXPECT_EQ(torsion("torsional_stiffness = 1\n"), 1.0);
  EXPECT_EQ(torsion("poisson_ratio = 0\n"), 3.0);
  EXPECT_EQ(torsion("bending_stiffness = 6\n"), 0.0);
}

TEST(SectionReader, AsksAboutATendonOutsideTheBody) {
  const auto warnings = [](const std::string& offset) {
    return Read(
               "[rod]\nlength = 0.1\nyoungs_modulus = 1e6\ndiameter = [0.01, 0.004]\n[[rod.actuator]]\nkind = "
               "\"tendon\"\noffset = " +
               offset + '\n')
        .scene.warnings;
  };
  EXPECT_TRUE(warnings("[0.005, -0.002]").empty());
  ASSERT_EQ(warnings("-0.003").size(), 1U);
  EXPECT_TRUE(contains_text(warnings("-0.003")[0], "7:10: found a tendon 0.003 m from the backbone at 0.1 m"));
}

TEST(SectionReader, LoadsActAtAPlaceOrAreSpread) {
  const Read r(
      "[rod]\nlength = 0.2\nbending_stiffness = 1e-3\n[[rod.load]]\nat = \"50 mm\"\nforce = [0, \"-1 N\"]\nmass = \"5 "
      "g\"\n"
      "[[rod.load]]\nfrom = \"0.1 m\"\nforce_per_length = [\"2 N/m\", 0]\n");
  ASSERT_EQ(r.message, "");
  ASSERT_EQ(r.scene.rod.loads.size(), 2U);
  const RodLoadSpec& point = r.scene.rod.loads[0];
  EXPECT_EQ(point.from, 0.05);
  EXPECT_EQ(point.to, 0.05);
  EXPECT_EQ(point.force.y, -1.0);
  EXPECT_EQ(point.mass, 0.005);
  const RodLoadSpec& spread = r.scene.rod.loads[1];
  EXPECT_EQ(spread.from, 0.1);
  EXPECT_EQ(spread.to, 0.2);
  EXPECT_EQ(spread.force.x, 2.0);
}

struct Bad {
  std::string rod, message, table{};
};

TEST(SectionReader, RefusesWhatMakesNoSection) {
  const std::string length = "[rod]\nlength = 0.1\n";
  const std::string plain = length + "bending_stiffness = 1e-3\n";
  const std::string file = "[rod]\nfile = \"section.csv\"\n";
  const std::string spread = plain + "[[rod.load]]\n";
  const Bad bad[] = {
      {length, "1:1: [rod] has no 'bending_stiffness', expected a bending stiffness"},
      {plain + "density = 1000\n", "4:11: found 'density' without 'diameter'"},
      {plain + "inner_diameter = 0.001\n", "4:18: found 'inner_diameter' without 'diameter'"},
      {length + "youngs_modulus = 1e6\n", "3:18: found 'youngs_modulus' without 'diameter'"},
      {length + "youngs_modulus = 1e6\ndiameter = 0.01\ninner_diameter = 0.01\n",
       "5:18: found an inner diameter of 0.01 m in a diameter of 0.01 m, expected a smaller one"},
      {length + "youngs_modulus = 1e6\ndiameter = [0.01, 0.004]\ninner_diameter = 0.005\n",
       "5:18: found an inner diameter of 0.005 m in a diameter of 0.004 m"},
      {plain + "youngs_modulus = 1e6\ndiameter = 0.01\n",
       "3:21: found bending_stiffness 0.001 N m^2, expected what the diameter gives, 0.000490874 N m^2"},
      {plain + "diameter = [0.01, 0.005]\n", "4:12: found a diameter that changes beside one 'bending_stiffness'"},
      {plain + "diameter = 0.01\nthickness = 0.01\n", "5:13: found 'thickness' beside 'diameter'"},
      {length + "youngs_modulus = 1e6\ndiameter = [0.01]\n", "4:12: found a list of 1 entry, expected one value or a"},
      {length + "youngs_modulus = 1e6\ndiameter = [0.01, 0]\n", "4:19: found the number 0, expected a length greater"},
      {plain + "file = \"section.csv\"\n", "3:21: found 'bending_stiffness' beside 'file'", "s,EI\n0,1\n0.1,2\n"},
      {file + "length = 0.2\n", "2:8: found a table from s = 0 m to 0.1 m, expected one from 0 to the length, 0.2 m",
       "s,EI\n0,1\n0.1,2\n"},
      {file, "2:8: found a table from s = 0.01 m to 0.1 m, expected one from 0", "s,EI\n0.01,1\n0.1,2\n"},
      {file, "2:8: found s = 0.05 m after 0.05 m in row 3 of the table, expected s to ascend",
       "s,EI\n0,1\n0.05,1\n0.05,2\n0.1,1\n"},
      {file, "2:8: found bending_stiffness 0 in row 2 of the table, expected more than 0", "s,EI\n0,1\n0.1,0\n"},
      {file, "2:8: the table has no bending_stiffness", "s,diameter\n0,0.01\n0.1,0.005\n"},
      {file, "2:8: the table has fewer than two rows", "s,EI\n0,1\n"},
      {plain + "poisson_ratio = 0.6\n", "4:17: found a Poisson's ratio of 0.6, expected one above -1 and at most 0.5"},
      {plain + "poisson_ratio = -1\n", "4:17: found a Poisson's ratio of -1"},
      {plain + "poisson_ratio = 0.3\ntorsional_stiffness = 1\n", "5:23: found 'torsional_stiffness' beside"},
      {plain + "out_of_plane_stiffness = 1\n", "4:26: found 'out_of_plane_stiffness' alone, expected 'torsional"},
      {"[[rod.segment]]\nlength = 0.1\nbending_stiffness = 1\npoisson_ratio = 0.5\n[[rod.segment]]\nlength = "
       "0.1\nbending_stiffness = 1\n",
       "5:1: the torsion of some segments is known and of others not"},
      {"[rod]\npoisson_ratio = 0.3\n[[rod.segment]]\nlength = 0.1\nbending_stiffness = 1\n",
       "2:17: found 'poisson_ratio' beside [[rod.segment]]"},
      {spread + "force = [0, 1]\n", "4:1: the load has no place, expected 'at' beside 'force' or 'mass'"},
      {spread + "at = 0.05\n", "5:6: found 'at' alone, expected 'force' or 'mass'"},
      {spread + "at = 0.2\nmass = 1\n", "5:6: found a load at 0.2 m, expected at most the rod's length, 0.1 m"},
      {spread + "at = 0.05\nforce_per_length = [0, 1]\n", "5:6: found 'at' beside 'force_per_length'"},
      {spread + "at = 0.05\nmass = 1\nto = 0.1\n", "7:6: found 'to' beside 'at'"},
      {spread + "from = 0.06\nto = 0.05\nforce_per_length = [0, 1]\n", "5:8: found a load from 0.06 m to 0.05 m"},
  };
  for (const Bad& b : bad) {
    SCOPED_TRACE(b.rod + b.table);
    EXPECT_TRUE(contains_text(Read(b.rod, b.table).message, b.message));
  }
}

}  // namespace
}  // namespace tendril::app::test
