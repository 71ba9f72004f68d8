// A certified grasp of two fingers that differ, each planned on its own, that is right but for one thing of one of
// them: within half the limit it is accepted, at twice the limit it is refused by that name and with that number
// (model.md section 7). Numbers of a finger are in units of its own rod, those of the whole in units of the grasp.

#include <cmath>
#include <functional>

#include "certificate/both_fingers.hpp"
#include "certificate/certifier.hpp"
#include "certified_grasp.hpp"
#include "tendril/grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::grasps {
namespace {

/// The ways of touching that win. Nothing else is planned, for time.
const char* const inside =
    "upper finger: interior contact with 'object' on segment 2; lower finger: interior contact with 'object' on "
    "segment 2";

const char* const near_the_palm =
    "upper finger: interior contact with 'object' on segment 1; lower finger: interior contact with 'object' on "
    "segment 1";

Certificate judged(const Pair& grasp, const Eigen::VectorXd& x) {
  GraspProgram program(grasp.spec());
  return GraspCertifier(program).certify(program, x);
}

Eigen::VectorXd planned_point(const Pair& grasp) {
  GraspProgram program(grasp.spec());
  return moved(program, grasp.x(program));
}

const char* name_of(std::size_t which) { return which == 0 ? "upper finger: " : "lower finger: "; }

struct DisturbedPair {
  const char* what;
  std::vector<std::string> names;  ///< of the failures
  double limit;
  double share;  ///< of the number, that its message may differ by
  /// A point where finger `which` is wrong by `amount`; `x` is right.
  std::function<Eigen::VectorXd(Pair& grasp, std::size_t which, const Eigen::VectorXd& x, double amount)> point;
};

Eigen::VectorXd with_row(const Pair& grasp, const Eigen::VectorXd& x, const std::string& name, double value) {
  GraspProgram program(grasp.spec());
  return moved(program, x, row_named(program, name), value);
}

/// Along the axis the object is pushed with `net`: the row is the sum of both directions.
Eigen::VectorXd with_net_force(const Pair& grasp, const Eigen::VectorXd& x, double net) {
  return with_row(grasp, x, "force_balance row 1", net / GraspProgram(grasp.spec()).force(x));
}

/// Variable `variable` of a finger's own program at x.
double own_value(const Pair& grasp, std::size_t which, const Eigen::VectorXd& x, const std::string& variable) {
  GraspProgram program(grasp.spec());
  const int finger = static_cast<int>(which);
  const Eigen::VectorXd own = program.finger_point(finger, x);
  for (int i = 0; i < program.finger(finger).variable_count(); ++i) {
    if (program.finger(finger).variable_name(i) == variable) return own[i];
  }
  ADD_FAILURE() << "no variable is called '" << variable << "'";
  return 0.0;
}

const std::vector<DisturbedPair>& disturbances_of_a_finger() {
  using Point = const Eigen::VectorXd&;
  static const std::vector<DisturbedPair> all{
      {"an equilibrium row",
       {"equilibrium residual"},
       tolerance::equilibrium,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         return with_row(g, x, name_of(which) + std::string("equilibrium row 2"), -amount);
       }},
      {"a gap under the force",
       {"complementarity"},
       tolerance::complementarity,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         return with_row(g, x, name_of(which) + std::string("contact_gap row 1"), amount);
       }},
      {"the finger inside the object",
       {"penetration", "complementarity"},
       tolerance::penetration,
       as_sharp_as_clearance,
       [](Pair& g, std::size_t which, Point x, double amount) {
         return with_row(g, x, name_of(which) + std::string("contact_gap row 1"), -amount);
       }},
      {"a contact beside the closest point",
       {"closest point"},
       tolerance::closest_point,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         return with_row(g, x, name_of(which) + std::string("closest_point row 1"), amount);
       }},
      {"a base inside the palm",
       {"penetration"},
       tolerance::penetration,
       as_sharp_as_clearance,
       [](Pair& g, std::size_t which, Point x, double amount) {
         g.fingers[which]->move_palm(amount);
         return Eigen::VectorXd(x);
       }},
      {"a first moment below its limit",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         g.fingers[which]->rod.actuators[0].minimum = own_value(g, which, x, "moment 1") + amount;
         return Eigen::VectorXd(x);
       }},
      {"a second moment above its limit",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         g.fingers[which]->rod.actuators[1].maximum = own_value(g, which, x, "moment 2") - amount;
         return Eigen::VectorXd(x);
       }},
      {"more force than allowed",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         g.fingers[which]->spec.max_force = own_value(g, which, x, "contact force 1") - amount;
         return Eigen::VectorXd(x);
       }},
      {"less force than asked for",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t which, Point x, double amount) {
         PoseProgramSpec& spec = g.fingers[which]->spec;
         spec.min_force = own_value(g, which, x, "contact force 1") + amount;
         spec.max_force = std::max(spec.max_force, spec.min_force);
         return Eigen::VectorXd(x);
       }},
  };
  return all;
}

const std::vector<DisturbedPair>& disturbances_of_the_whole() {
  using Point = const Eigen::VectorXd&;
  static const std::vector<DisturbedPair> all{
      {"force out of balance, away from the palm",
       {"net force on the object"},
       tolerance::balance,
       three_digits,
       [](Pair& g, std::size_t, Point x, double amount) { return with_net_force(g, x, amount); }},
      {"force out of balance, towards the palm",
       {"net force on the object"},
       tolerance::balance,
       three_digits,
       [](Pair& g, std::size_t, Point x, double amount) { return with_net_force(g, x, -amount); }},
      {"a palm that is too near",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t, Point x, double amount) {
         // The worse of both fingers is the one with the shorter unit.
         const double unit = std::min(g.fingers[0]->spec.term_units.length, g.fingers[1]->spec.term_units.length);
         g.palm_minimum = x[x.size() - 1] + amount * unit;
         return Eigen::VectorXd(x);
       }},
      {"a palm that is too far",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Pair& g, std::size_t, Point x, double amount) {
         const double unit = std::min(g.fingers[0]->spec.term_units.length, g.fingers[1]->spec.term_units.length);
         g.palm_maximum = x[x.size() - 1] - amount * unit;
         return Eigen::VectorXd(x);
       }},
  };
  return all;
}

/// The grasp as it was planned, each time.
class PlannedPair {
 public:
  explicit PlannedPair(const Scene& scene) : grasp(scene, inside), x(planned_point(grasp)) {
    for (std::size_t which = 0; which < 2; ++which) {
      specs_[which] = grasp.fingers[which]->spec;
      rods_[which] = grasp.fingers[which]->rod;
    }
    palm_ = {grasp.palm_minimum, grasp.palm_maximum};
  }
  void restore() {
    for (std::size_t which = 0; which < 2; ++which) {
      grasp.fingers[which]->spec = specs_[which];
      grasp.fingers[which]->rod = rods_[which];
      grasp.fingers[which]->move_palm(0.0);
    }
    grasp.palm_minimum = palm_.first;
    grasp.palm_maximum = palm_.second;
  }
  void expect_limit(const DisturbedPair& one, std::size_t which) {
    for (const double share : {0.5, 2.0}) {
      restore();
      const double amount = share * one.limit;
      const Certificate certificate = judged(grasp, one.point(grasp, which, x, amount));
      if (share < 1.0) {
        expect_accepted(certificate);
      } else {
        expect_refused(certificate, one.names, amount, one.share);
      }
    }
    restore();
  }

  Pair grasp;
  Eigen::VectorXd x;

 private:
  std::array<PoseProgramSpec, 2> specs_;
  std::array<Rod, 2> rods_;
  std::pair<double, double> palm_;
};

TEST(CounterexampleBothFingers, OneThingWrongIsRefusedByItsNameAndNumber) {
  PlannedPair planned(combination::scene("grasp_unequal"));
  expect_accepted(judged(planned.grasp, planned.x));
  for (const DisturbedPair& one : disturbances_of_the_whole()) {
    SCOPED_TRACE(one.what);
    planned.expect_limit(one, 0);
  }
  for (const DisturbedPair& one : disturbances_of_a_finger()) {
    for (const std::size_t which : {0, 1}) {
      SCOPED_TRACE(std::string(name_of(which)) + one.what);
      planned.expect_limit(one, which);
    }
  }
}

TEST(CounterexampleBothFingers, OneThatIsNotStationaryIsRefused) {
  const PlannedPair planned(combination::scene("grasp_unequal"));
  GraspProgram program(planned.grasp.spec());
  const auto beside = [&](double step) {
    Eigen::VectorXd x = planned.x;
    x[program.palm_variable()] += step;
    return moved(program, x);
  };
  // Near a minimum the slope grows with the distance.
  const double rate = slope_left(program, beside(1e-5)) / 1e-5;
  ASSERT_GT(rate, 0.0);
  for (const double share : {0.5, 2.0}) {
    const Eigen::VectorXd x = beside(share * tolerance::stationarity / rate);
    const double slope = slope_left(program, x);
    EXPECT_NEAR(slope, share * tolerance::stationarity, 0.1 * tolerance::stationarity);
    const Certificate certificate = judged(planned.grasp, x);
    if (share < 1.0) {
      expect_accepted(certificate);
      EXPECT_EQ(certificate.stationarity_kind, "S");
    } else {
      expect_refused(certificate, {"stationarity"}, slope, three_digits);
      EXPECT_EQ(certificate.stationarity_kind, "none");
    }
  }
}

// The tip of the long soft finger is pushed back until that one buckles, whichever of the two it is. Nothing is asked
// of the grasp but that it is one.
TEST(CounterexampleBothFingers, OneFingerThatIsNotStableIsRefused) {
  const double limit = tolerance::stability;
  for (const std::size_t which : {0, 1}) {
    SCOPED_TRACE(name_of(which));
    Scene made = combination::scene("grasp_unequal");
    if (which == 1) {
      std::swap(made.fingers[0], made.fingers[1]);
      made.gravity = Vec2{made.gravity->x, -made.gravity->y};
    }
    PlannedPair planned(made);
    for (const auto& finger : planned.grasp.fingers) {
      finger->spec.terms.clear();
      finger->spec.max_force = 2.0 * finger->force;
    }
    const auto pushed = [&](double push, const Eigen::VectorXd& from) {
      planned.grasp.fingers[which]->rod.tip_force = {-push, 0.0};
      GraspProgram program(planned.grasp.spec());
      return moved(program, from);
    };
    const auto margin = [&](const Eigen::VectorXd& x) { return judged(planned.grasp, x).stability; };
    for (const double wanted : {2.0 * limit, 0.5 * limit}) {
      const Eigen::VectorXd x = pushed_to_margin(planned.x, wanted, pushed, margin);
      const Certificate certificate = judged(planned.grasp, x);
      ASSERT_NEAR(certificate.stability, wanted, 0.1 * limit);
      if (wanted > limit) {
        expect_accepted(certificate);
      } else {
        expect_refused(certificate, {"stability"}, certificate.stability, three_digits);
      }
    }
  }
}

// Tips that lean against each other on the axis, and then pass each other: where both rise at an angle a against the
// axis, a tip that is a distance d beyond the other one is d cos(a) from the other finger.
TEST(CounterexampleBothFingers, FingersThatCrossAreRefused) {
  Scene made = combination::scene(
      "grasp_60mm", {"gripper.object_diameter=\"31.1 mm\"", "gripper.half_palm=\"6.4 mm\"",
                     "gripper.finger_angle=\"0.77 rad\"", "rod.actuator.0.to=\"30 mm\"",
                     "rod.actuator.1.from=\"30 mm\"", "contact.max_force=\"13.96 N\"", "gripper.fingers=both"});
  Pair grasp(made, near_the_palm);
  GraspProgram without(grasp.spec());
  const Eigen::VectorXd meeting = moved(without, grasp.x(without));
  const int last = without.finger(0).chain().piece_count() - 1;
  (void)without.constraints(meeting);
  ASSERT_NEAR(without.finger(0).backbone().tip().y, 0.0, 1e-9);
  const double angle = without.finger(0).backbone().tip_angle();
  grasp.separations = {{last, 1.0, last, 1.0, {0.0, 1.0}}};
  GraspProgram program(grasp.spec());
  for (const double share : {0.5, 2.0}) {
    const double depth = share * tolerance::penetration;
    const Eigen::VectorXd x = moved(program, meeting, program.first_separation(), -depth / std::cos(angle));
    const Certificate certificate = judged(grasp, x);
    if (share < 1.0) {
      expect_accepted(certificate);
    } else {
      expect_refused(certificate, {"penetration"}, depth, as_sharp_as_clearance);
    }
  }
}

// Equal forces along the axis cancel where both fingers press from the same side of it, too.
TEST(CounterexampleBothFingers, ForceAcrossTheAxisIsNetForce) {
  PlannedPair planned(combination::scene("grasp_unequal"));
  const double radius = 0.025;
  Eigen::VectorXd x = planned.x;
  for (const std::size_t which : {0, 1}) {
    Finger& finger = *planned.grasp.fingers[which];
    // Straight along the object: the upper finger above it, the lower one, which is mirrored, above it as well.
    finger.rod.base = {0.0, (which == 0 ? radius : -radius) / finger.scale.length};
    finger.rod.base_angle = 0.0;
  }
  GraspProgram program(planned.grasp.spec());
  for (int i = 0; i < program.variable_count(); ++i) {
    const std::string name = program.variable_name(i);
    if (name.find("coordinate") != std::string::npos) x[i] = 0.0;
    if (name.find("arc length") == std::string::npos) continue;
    const double unit = planned.grasp.fingers[name.find("upper") == 0 ? 0 : 1]->spec.term_units.length;
    x[i] = x[program.palm_variable()] / unit;
  }
  const Certificate certificate = GraspCertifier(program).certify(program, x);
  ASSERT_LE(certificate.complementarity, tolerance::complementarity);
  EXPECT_NEAR(certificate.balance, 2.0 * program.force(x), 1e-9);
  const std::vector<Refusal> all = refusals(certificate);
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const Refusal& r) { return r.name == "net force on the object"; }),
            1);
}

TEST(CounterexampleBothFingers, NoNumberIsNoGrasp) {
  const PlannedPair planned(combination::scene("grasp_unequal"));
  Eigen::VectorXd x = planned.x;
  x[x.size() - 3] = std::nan("");
  const Certificate certificate = judged(planned.grasp, x);
  ASSERT_EQ(certificate.failures.size(), 1U);
  EXPECT_EQ(certificate.failures[0], "the plan is not finite");
}

}  // namespace
}  // namespace tendril::grasps
