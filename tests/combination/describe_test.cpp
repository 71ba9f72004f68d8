// What a scene does not need is not built.

#include <algorithm>

#include "support.hpp"

namespace tendril::combination {
namespace {

int count_of(const std::vector<Description::Count>& counts, const std::string& name) {
  int sum = 0;
  for (const Description::Count& c : counts) sum += c.name == name ? c.count : 0;
  return sum;
}

std::string why_left_out(const Description& d, const std::string& what) {
  for (const LeftOut& left : d.left_out) {
    if (left.what == what) return left.why;
  }
  return "";
}

std::vector<std::string> opened(const plugins::Registry& registry) {
  std::vector<std::string> names;
  for (const plugins::Registry::Opened& o : registry.opened()) {
    names.push_back(std::string(to_string(o.kind)) + " " + o.name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

const std::vector<std::string> named_by_scenes{"coordinates legendre", "objective actuation_effort",
                                               "objective tip_pose", "solver " TENDRIL_TEST_SOLVER};

TEST(Describe, AFreeSceneHasNoTraceOfContact) {
  plugins::Registry own = fresh_registry();
  const Description d = problem(scene("free"), own).describe();
  EXPECT_EQ(opened(own), named_by_scenes);
  ASSERT_EQ(d.modes.size(), 1u);
  EXPECT_EQ(count_of(d.variables, "coordinates"), 6);
  EXPECT_EQ(count_of(d.variables, "moments"), 1);
  EXPECT_EQ(d.variables.size(), 2u);
  ASSERT_EQ(d.rows.size(), 1u);
  EXPECT_EQ(count_of(d.rows, "equilibrium"), 6);
  EXPECT_EQ(why_left_out(d, "check points"), "the scene has no obstacle");
  EXPECT_EQ(why_left_out(d, "contact variables and rows"), "the scene has no obstacle");
  EXPECT_EQ(d.energies, (std::vector<std::string>{"bending", "gravity"}));
  EXPECT_EQ(d.terms, (std::vector<std::string>{"tip_pose", "actuation_effort"}));
}

TEST(Describe, AvoidingNeedsCheckPointsButNoForce) {
  plugins::Registry own = fresh_registry();
  const Description d = problem(scene("avoid"), own).describe();
  EXPECT_EQ(opened(own), named_by_scenes);
  ASSERT_EQ(d.modes.size(), 1u);
  EXPECT_EQ(d.variables.size(), 2u);
  EXPECT_EQ(count_of(d.variables, "contact_force"), 0);
  EXPECT_EQ(count_of(d.variables, "contact_arc_length"), 0);
  for (const char* row : {"contact_gap", "closest_point", "complementarity"})
    EXPECT_EQ(count_of(d.rows, row), 0) << row;
  EXPECT_GT(count_of(d.rows, "non_penetration"), 0);
  EXPECT_EQ(why_left_out(d, "contact variables and rows"), "contact mode \"avoid\"");
}

TEST(Describe, AnIgnoredObstacleIsNotBuilt) {
  const Description d = problem(scene("brace", {"contact.mode=ignore"})).describe();
  EXPECT_EQ(count_of(d.rows, "non_penetration"), 0);
  EXPECT_EQ(d.variables.size(), 2u);
  EXPECT_EQ(why_left_out(d, "check points"), "contact mode \"ignore\"");
}

TEST(Describe, ABraceHasOneForceAndOnePlaceInItsLargestMode) {
  const Description d = problem(scene("brace")).describe();
  // No contact, a contact inside the rod, and one at the tip.
  ASSERT_EQ(d.modes.size(), 3u);
  EXPECT_EQ(count_of(d.modes[0].variables, "contact_force"), 0);
  EXPECT_EQ(count_of(d.variables, "contact_force"), 1);
  EXPECT_EQ(count_of(d.variables, "contact_arc_length"), 1);
  EXPECT_EQ(count_of(d.variables, "coordinates"), 12);
  EXPECT_EQ(count_of(d.rows, "equilibrium"), 12);
  EXPECT_EQ(count_of(d.rows, "contact_gap"), 1);
  EXPECT_EQ(count_of(d.rows, "closest_point"), 1);
  // The penalty needs no row and no variable.
  EXPECT_EQ(count_of(d.rows, "complementarity"), 0);
  EXPECT_EQ(count_of(d.variables, "slack"), 0);
  const Description slack = problem(scene("brace", {"contact.treatment=slack"})).describe();
  EXPECT_EQ(count_of(slack.rows, "complementarity"), 1);
  EXPECT_EQ(count_of(slack.variables, "slack"), 1);
}

TEST(Describe, WithoutGravityThereIsNoGravityTerm) {
  Scene weightless = scene("free");
  weightless.gravity.reset();
  const Description d = problem(weightless).describe();
  EXPECT_EQ(d.energies, std::vector<std::string>{"bending"});
  EXPECT_EQ(why_left_out(d, "gravity term"), "the scene has no gravity");
  const Description massless = problem(scene("free", {"rod.linear_density=0"})).describe();
  EXPECT_EQ(massless.energies, std::vector<std::string>{"bending"});
  EXPECT_NE(why_left_out(massless, "gravity term"), "");
}

TEST(Describe, AnObjectiveOfWeightZeroOpensNothing) {
  plugins::Registry own = fresh_registry();
  Scene without = scene("free");
  without.objectives[1].weight = 0.0;
  const Description d = problem(without, own).describe();
  EXPECT_EQ(d.terms, std::vector<std::string>{"tip_pose"});
  EXPECT_EQ(why_left_out(d, "objective actuation_effort"), "its weight is 0");
  EXPECT_EQ(opened(own),
            (std::vector<std::string>{"coordinates legendre", "objective tip_pose", "solver " TENDRIL_TEST_SOLVER}));
}

TEST(Describe, AMomentFixedAtZeroIsNoVariable) {
  const Description d = problem(scene("free", {"rod.actuator.0.limit=0"})).describe();
  EXPECT_EQ(count_of(d.variables, "moments"), 0);
  EXPECT_EQ(why_left_out(d, "moment of actuator 1"), "its limit is 0");
}

}  // namespace
}  // namespace tendril::combination
