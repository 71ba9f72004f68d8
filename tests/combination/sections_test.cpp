// Rods whose sections vary, with a body and with loads along them: every solver plans them, and their plans are what
// execution reaches.

#include <algorithm>
#include <cmath>

#include "support.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"

namespace tendril::combination {
namespace {

/// The braced arm of a rod that is stated by `rod`, over a peg whose top is where the arm's lower side passes.
std::string arm(const std::string& rod, const std::string& loads, const std::string& peg,
                const std::string& coordinates = "") {
  return "problem = \"pose\"\ngravity = [0, \"-9.81 m/s^2\"]\n[rod]\n" + rod +
         "[[rod.actuator]]\nlimit = \"2.5 N mm\"\n" + loads + "[coordinates]\nplugin = \"legendre\"\norder = 12\n" +
         coordinates + "[start]\ntip_angle = \"0.5 rad\"\n[[obstacle]]\nshape = \"circle\"\n" + peg +
         "[contact]\nmax_force = \"1 N\"\n[target]\nposition = [\"97 mm\", \"20 mm\"]\n[[objective]]\n"
         "plugin = \"tip_pose\"\nweight = 100\n[[objective]]\nplugin = \"actuation_effort\"\nweight = 1e-4\n";
}

struct SectionCase {
  const char* name;
  std::string scene;
};

const std::string round_taper =
    "length = \"100 mm\"\nyoungs_modulus = \"1 MPa\"\ndensity = \"1070 kg/m^3\"\ndiameter = [\"10 mm\", \"7 mm\"]\n";
const std::string even = "length = \"100 mm\"\nbending_stiffness = \"4.9e-4 N m^2\"\nlinear_density = \"84 g/m\"\n";
const std::string low_peg = "center = [\"60 mm\", \"-4 mm\"]\nradius = \"8 mm\"\n";
const std::string peg = "center = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"\n";
const std::string loads =
    "[[rod.load]]\nat = \"70 mm\"\nmass = \"0.5 g\"\nforce = [\"2 mN\", \"-3 mN\"]\n[[rod.load]]\nfrom = \"20 mm\"\n"
    "to = \"90 mm\"\nforce_per_length = [0, \"-0.1 N/m\"]\n";

const SectionCase cases[] = {
    {"tapered, with a body", arm(round_taper, "", low_peg)},
    {"with loads", arm(even, loads, peg)},
    {"with a tapered body", arm(even + "thickness = [\"10 mm\", \"6 mm\"]\n", "", low_peg)},
    {"all of it", arm(round_taper, loads, low_peg)},
    {"that stretches", arm(even + "axial_stiffness = \"10 N\"\n", loads, peg, "stretch_order = 12\n")}};

TEST(Sections, EverySolverPlansWhatExecutionReaches) {
  for (const SectionCase& c : cases) {
    double objective = 0.0;
    for (const std::string& solver : solvers_to_combine()) {
      SCOPED_TRACE(std::string(c.name) + ", " + solver);
      Scene scene = scene_from_text(c.scene);
      scene.solver.plugin = solver;
      const Plan found = plan(scene);
      ASSERT_TRUE(certified(found));
      ASSERT_EQ(found.contacts.size(), 1u);
      if (objective == 0.0) objective = found.objective;
      EXPECT_NEAR(found.objective, objective, 1e-7 * objective);
      const Execution done = execute(scene, plugins::make_obstacles(registry(), scene), found.moments);
      ASSERT_EQ(done.result.status, PlanStatus::solved) << done.result.message;
      EXPECT_LT(std::hypot(done.result.tip_x - found.tip_x, done.result.tip_y - found.tip_y), 1e-8 * 0.1);
      ASSERT_EQ(done.result.contacts.size(), 1u);
      EXPECT_NEAR(done.result.contacts[0].force, found.contacts[0].force, 1e-6 * found.contacts[0].force);
    }
  }
}

// Nothing is said of what a scene does not have.
TEST(Sections, DescriptionsOfOtherRodsAreAsBefore) {
  const Description plain = problem(scene("brace")).describe();
  for (const std::string& energy : plain.energies) EXPECT_EQ(energy.find("along"), std::string::npos);
  for (const LeftOut& left : plain.left_out) EXPECT_EQ(left.what.find("along"), std::string::npos) << left.what;
  const Description loaded = problem(scene_from_text(arm(even, loads, peg))).describe();
  EXPECT_NE(std::find(loaded.energies.begin(), loaded.energies.end(), "loads along the rod"), loaded.energies.end());
}

// One tendon alone bends the arm and shortens it: the plan takes both, in every basis of contacts.
TEST(Sections, TendonsShortenARodThatStretches) {
  for (const std::string& solver : solvers_to_combine()) {
    for (const char* split : {"true", "false"}) {
      if (solver != "ipopt" && std::string(split) == "false") continue;
      SCOPED_TRACE(solver + ", split " + split);
      const Scene arm =
          scene("extensible_arm", {"solver.plugin=" + solver, "coordinates.order=14", "coordinates.stretch_order=14",
                                   std::string("coordinates.split_at_contact=") + split});
      Plan found = plan(arm);
      ASSERT_TRUE(certified(found));
      EXPECT_LT(found.certificate.least_stretch, 0.98);
      if (std::string(split) == "false") continue;
      const Components parts = plugins::make_components(registry(), arm);
      ExecuteControl control;
      control.start = &found;
      const Execution reached = verify(arm, parts.obstacles, found, control);
      EXPECT_EQ(reached.result.status, PlanStatus::solved) << reached.result.message;
      EXPECT_LT(found.model_error.value_or(infinity), 1e-8 * arm.rod.length());
    }
  }
}

TEST(Sections, TaperedFingersWithTwoChambersGraspWithEverySolver) {
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene made = scene("silicone_grasp");
    made.solver.plugin = solver;
    Plan found = plan(made);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(found.contacts.at(0).force, made.contact.max_force, 1e-6);
    EXPECT_LT(norm(found.grasp->net_force), 1e-8);
    EXPECT_GT(found.certificate.out_of_plane.value_or(0.0), 0.1);
    // By the law of its chamber each moment has its pressure.
    for (std::size_t a = 0; a < 2; ++a) {
      const ActuatorSpec& chamber = made.rod.actuators[a];
      const double kilopascals = chamber.input_of(found.moments[a]) / 1e3;
      const double linear = a == 0 ? -1.2e-3 : -0.8e-3;
      const double square = a == 0 ? -4e-6 : -2e-6;
      EXPECT_NEAR(linear * kilopascals + square * kilopascals * kilopascals, found.moments[a], 1e-12);
    }
    ExecuteControl control;
    control.start = &found;
    verify(finger_in_world(made), obstacles_of_finger(made, found.grasp->palm_distance), found, control);
    EXPECT_EQ(found.status, PlanStatus::solved) << found.message;
    EXPECT_LT(found.model_error.value_or(infinity), 1e-8 * made.rod.length());
  }
}

TEST(Sections, WhatIsKnownOfTheStretchAndNotAskedForIsTold) {
  const Description fixed = problem(scene_from_text(arm(even + "axial_stiffness = \"10 N\"\n", "", peg))).describe();
  EXPECT_EQ(std::find(fixed.energies.begin(), fixed.energies.end(), "stretch"), fixed.energies.end());
  const Scene read = scene_from_text(arm(even + "axial_stiffness = \"10 N\"\n", "", peg));
  ASSERT_EQ(read.left_out.size(), 1u);
  EXPECT_EQ(read.left_out[0].what, "axial_stiffness");
  const Description stretches = problem(scene("extensible_arm")).describe();
  EXPECT_NE(std::find(stretches.energies.begin(), stretches.energies.end(), "stretch"), stretches.energies.end());
}

}  // namespace
}  // namespace tendril::combination
