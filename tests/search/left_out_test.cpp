// Every reason that `left_out` can give: a scene that gives it, and one that does not.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "combination/grasp_support.hpp"
#include "scripted_solver.hpp"

namespace tendril::search {
namespace {

using combination::scene;

std::string text_of(const std::vector<LeftOut>& all) {
  std::string text;
  for (const LeftOut& one : all) text += "\n  " + one.what + ": " + one.why;
  return text;
}

bool says(const std::vector<LeftOut>& all, const std::string& what, const std::string& why) {
  return std::any_of(all.begin(), all.end(),
                     [&](const LeftOut& one) { return one.what == what && one.why.find(why) == 0; });
}

struct Reason {
  const char* what;
  const char* why;
  Scene gives, does_not;
};

Scene changed(const std::string& name, const std::function<void(Scene&)>& change) {
  Scene made = scene(name);
  change(made);
  return made;
}

std::vector<Reason> reasons() {
  const Scene brace = scene("brace");
  const Scene free = scene("free");
  const Scene grasp = scene("grasp_60mm");
  const Scene unequal = scene("grasp_unequal");
  return {
      {"objective actuation_effort", "its weight is 0", changed("free", [](Scene& s) { s.objectives[1].weight = 0.0; }),
       free},
      {"gravity term", "the scene has no gravity", changed("free", [](Scene& s) { s.gravity.reset(); }), free},
      {"gravity term", "neither the rod nor the tip has mass, or gravity is zero",
       scene("free", {"rod.linear_density=0"}), scene("free", {"rod.linear_density=0", "tip_load.mass=\"1 g\""})},
      {"gravity term", "neither the rod nor the tip has mass, or gravity is zero",
       changed("free", [](Scene& s) { s.gravity = Vec2{}; }), free},
      {"payload", "no tip mass is given", free, scene("free", {"tip_load.mass=\"1 g\""})},
      {"tip force", "none is given", free, scene("free", {"tip_load.force=[\"1 mN\", \"0 N\"]"})},
      {"moment of actuator 1", "its limit is 0", scene("free", {"rod.actuator.0.limit=0"}), free},
      {"moment of actuator 2", "its limit is 0", scene("grasp_60mm", {"rod.actuator.1.limit=0"}), grasp},
      {"moments", "the rod has no actuator", changed("free", [](Scene& s) { s.rod.actuators.clear(); }), free},
      {"check points", "the scene has no obstacle", free, brace},
      {"contact variables and rows", "the scene has no obstacle", free, brace},
      {"check points", "contact mode \"ignore\"", scene("brace", {"contact.mode=ignore"}), scene("avoid")},
      {"contact variables and rows", "contact mode \"ignore\"", scene("brace", {"contact.mode=ignore"}), brace},
      {"contact variables and rows", "contact mode \"avoid\"", scene("avoid"), brace},
      {"contact variables and rows", "max_force is 0", scene("brace", {"contact.max_force=0"}), brace},
      {"palm distance", "a pose has no palm", brace, grasp},
      {"palm distance", "it is fixed", scene("grasp_60mm", {"gripper.palm_distance=\"70 mm\""}), grasp},
      {"force balance as a row", "the scene leaves it to an objective",
       scene("grasp_60mm", {"gripper.balance=objective"}), grasp},
      {"the lower finger", "it is the mirror image of the upper one", grasp, unequal},
      {"complementarity of the contacts", "a grasp holds its object: every contact touches", grasp, brace},
      {"complementarity of the contacts", "a grasp holds its object: every contact touches", unequal, brace},
      {"other contact assignments", "", scene("clutter"), scene("two_pegs")},
      {"two contacts inside the rod with one convex obstacle",
       "within one segment only one is planned; a second one may be at the tip or on another segment",
       scene("two_pegs"), brace},
      {"moment of actuator 2 of the lower finger", "its limit is 0",
       changed("grasp_unequal",
               [](Scene& s) { s.fingers[1].rod.actuators[1].minimum = s.fingers[1].rod.actuators[1].maximum = 0.0; }),
       changed("grasp_unequal",
               [](Scene& s) { s.fingers[0].rod.actuators[1].minimum = s.fingers[0].rod.actuators[1].maximum = 0.0; })},
      {"moment of actuator 2", "its limit is 0",
       changed("grasp_unequal",
               [](Scene& s) { s.fingers[0].rod.actuators[1].minimum = s.fingers[0].rod.actuators[1].maximum = 0.0; }),
       unequal},
      {"force of the second contact", "it is that of the first: the object is at rest", unequal, grasp},
  };
}

TEST(LeftOut, EveryReasonIsGivenWhereItHoldsAndOnlyThere) {
  for (const Reason& reason : reasons()) {
    SCOPED_TRACE(std::string(reason.what) + ": " + reason.why);
    const std::vector<LeftOut> with = combination::problem(reason.gives).describe().left_out;
    EXPECT_TRUE(says(with, reason.what, reason.why)) << text_of(with);
    const std::vector<LeftOut> without = combination::problem(reason.does_not).describe().left_out;
    EXPECT_FALSE(says(without, reason.what, reason.why)) << text_of(without);
  }
}

// A plan says all that the description of its problem says.
TEST(LeftOut, APlanSaysAllThatItsDescriptionSays) {
  for (const Scene& made : {scene("free"), scene("grasp_unequal")}) {
    const std::vector<LeftOut> described = combination::problem(made).describe().left_out;
    const std::atomic<bool> stop{true};
    PlanControl control;
    control.stop = &stop;
    const std::vector<LeftOut> planned = combination::plan(made, control).left_out;
    for (const LeftOut& one : described) EXPECT_TRUE(says(planned, one.what, one.why)) << one.what;
  }
}

// n! / (n - k)! orders of k of n pegs on one stretch, and the same before one of n tips.
TEST(LeftOut, TheSearchSaysHowManyAssignmentsThereAre) {
  double expected = 0.0;
  const double pegs = 10.0;
  double ordered = 1.0;
  for (int k = 1; k <= 3; ++k) {
    // k contacts: all inside, or one of them at the tip.
    expected += ordered * pegs;
    ordered *= pegs - (k - 1);
    expected += ordered;
  }
  char text[80];
  std::snprintf(text, sizeof text, "%.0f ways of assigning up to 3 contacts are too many", expected);
  const std::vector<LeftOut> all = combination::problem(scene("clutter")).describe().left_out;
  EXPECT_TRUE(says(all, "other contact assignments", text)) << text_of(all);
}

}  // namespace
}  // namespace tendril::search
