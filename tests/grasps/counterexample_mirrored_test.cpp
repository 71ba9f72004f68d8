// A certified grasp of one mirrored finger that is right but for one thing: within half the limit it is accepted, at
// twice the limit it is refused by that name and with that number (model.md section 7).

#include <cmath>
#include <functional>

#include "certificate/certifier.hpp"
#include "certified_grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::grasps {
namespace {

/// So small that the tip comes nearer to the axis than the base.
Scene small_object() { return combination::scene("grasp_60mm", {"gripper.object_diameter=\"45 mm\""}); }

Certificate judged(const Finger& finger, const Eigen::VectorXd& x) {
  PoseProgram program(finger.spec);
  program.set_branch(0, Branch::touching);
  return Certifier(finger.spec).certify(program, x);
}

/// Something that is wrong by `amount` in a grasp that is right otherwise.
struct Disturbed {
  const char* what;
  std::vector<std::string> names;  ///< of the failures
  double limit;
  double share;  ///< of the number, that its message may differ by
  std::function<Eigen::VectorXd(Finger& finger, double amount)> point;
};

Eigen::VectorXd with_row(Finger& finger, const std::string& name, double value) {
  PoseProgram program(finger.spec);
  program.set_branch(0, Branch::touching);
  return moved(program, finger.x, row_named(program, name), value);
}

/// Along the axis an object is pushed with `net`: the row is the direction of the one push.
Eigen::VectorXd with_net_force(Finger& finger, double net) {
  return with_row(finger, "force_balance row 1", net / finger.x[PoseProgram(finger.spec).layout().first_force]);
}

Eigen::Index first_moment(const Finger& finger) { return PoseProgram(finger.spec).layout().first_moment; }

const std::vector<Disturbed>& disturbances() {
  static const std::vector<Disturbed> all{
      {"an equilibrium row",
       {"equilibrium residual"},
       tolerance::equilibrium,
       three_digits,
       [](Finger& f, double amount) { return with_row(f, "equilibrium row 3", amount); }},
      {"the last equilibrium row, the other way",
       {"equilibrium residual"},
       tolerance::equilibrium,
       three_digits,
       [](Finger& f, double amount) {
         const int last = PoseProgram(f.spec).layout().coordinates;
         return with_row(f, "equilibrium row " + std::to_string(last), -amount);
       }},
      {"force out of balance, away from the palm",
       {"net force on the object"},
       tolerance::balance,
       three_digits,
       [](Finger& f, double amount) { return with_net_force(f, amount); }},
      {"force out of balance, towards the palm",
       {"net force on the object"},
       tolerance::balance,
       three_digits,
       [](Finger& f, double amount) { return with_net_force(f, -amount); }},
      {"a gap under the force",
       {"complementarity"},
       tolerance::complementarity,
       three_digits,
       [](Finger& f, double amount) { return with_row(f, "contact_gap row 1", amount); }},
      {"the finger inside the object",
       {"penetration", "complementarity"},
       tolerance::penetration,
       as_sharp_as_clearance,
       [](Finger& f, double amount) { return with_row(f, "contact_gap row 1", -amount); }},
      {"a contact beside the closest point",
       {"closest point"},
       tolerance::closest_point,
       three_digits,
       [](Finger& f, double amount) { return with_row(f, "closest_point row 1", amount); }},
      {"a contact on the other side of the closest point",
       {"closest point"},
       tolerance::closest_point,
       three_digits,
       [](Finger& f, double amount) { return with_row(f, "closest_point row 1", -amount); }},
      {"a tip across the axis",
       {"penetration"},
       tolerance::penetration,
       as_sharp_as_clearance,
       [](Finger& f, double amount) {
         PoseProgram program(f.spec);
         (void)program.constraints(f.x);
         f.move_axis(program.backbone().tip().y + amount);
         return f.x;
       }},
      {"a base inside the palm",
       {"penetration"},
       tolerance::penetration,
       as_sharp_as_clearance,
       [](Finger& f, double amount) {
         f.move_palm(amount);
         return f.x;
       }},
      {"a first moment below its limit",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.rod.actuators[0].minimum = f.x[first_moment(f)] + amount;
         return f.x;
       }},
      {"a first moment above its limit",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.rod.actuators[0].maximum = f.x[first_moment(f)] - amount;
         return f.x;
       }},
      {"a second moment below its limit",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.rod.actuators[1].minimum = f.x[first_moment(f) + 1] + amount;
         return f.x;
       }},
      {"a palm that is too near",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.spec.palm->minimum = f.palm_distance + amount;
         return f.x;
       }},
      {"a palm that is too far",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.spec.palm->maximum = f.palm_distance - amount;
         return f.x;
       }},
      {"more force than allowed",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.spec.max_force = f.force - amount;
         return f.x;
       }},
      {"less force than asked for",
       {"violation of a limit"},
       tolerance::bounds,
       three_digits,
       [](Finger& f, double amount) {
         f.spec.min_force = f.spec.max_force = f.force + amount;
         return f.x;
       }},
  };
  return all;
}

TEST(CounterexampleMirroredGrasp, OneThingWrongIsRefusedByItsNameAndNumber) {
  const std::unique_ptr<Finger> planned = mirrored_grasp(small_object());
  expect_accepted(judged(*planned, planned->x));
  const PoseProgramSpec spec = planned->spec;
  const Rod rod = planned->rod;
  for (const Disturbed& one : disturbances()) {
    SCOPED_TRACE(one.what);
    for (const double share : {0.5, 2.0}) {
      planned->spec = spec;
      planned->rod = rod;
      planned->move_palm(0.0);
      planned->move_axis(0.0);
      // A limit that moved holds for the point, not for the way there.
      const double amount = share * one.limit;
      const Eigen::VectorXd x = one.point(*planned, amount);
      const Certificate certificate = judged(*planned, x);
      if (share < 1.0) {
        expect_accepted(certificate);
      } else {
        expect_refused(certificate, one.names, amount, one.share);
      }
    }
  }
}

// Along the grasps that its rows leave, away from the best one.
TEST(CounterexampleMirroredGrasp, OneThatIsNotStationaryIsRefused) {
  const std::unique_ptr<Finger> planned = mirrored_grasp(combination::scene("grasp_60mm"));
  PoseProgram program(planned->spec);
  program.set_branch(0, Branch::touching);
  const auto beside = [&](double step) {
    Eigen::VectorXd x = planned->x;
    x[planned->x.size() - 1] += step;
    return moved(program, x);
  };
  // Near a minimum the slope grows with the distance.
  const double rate = slope_left(program, beside(1e-5)) / 1e-5;
  ASSERT_GT(rate, 0.0);
  for (const double share : {0.5, 2.0}) {
    const Eigen::VectorXd x = beside(share * tolerance::stationarity / rate);
    const double slope = slope_left(program, x);
    EXPECT_NEAR(slope, share * tolerance::stationarity, 0.1 * tolerance::stationarity);
    const Certificate certificate = judged(*planned, x);
    if (share < 1.0) {
      expect_accepted(certificate);
      EXPECT_EQ(certificate.stationarity_kind, "S");
    } else {
      expect_refused(certificate, {"stationarity"}, slope, three_digits);
      EXPECT_EQ(certificate.stationarity_kind, "none");
    }
  }
}

// A tip that is pushed back buckles the finger. Nothing is asked of the grasp but that it is one.
TEST(CounterexampleMirroredGrasp, OneThatIsNotStableIsRefused) {
  const std::unique_ptr<Finger> planned = mirrored_grasp(small_object());
  planned->spec.terms.clear();
  planned->spec.max_force = 2.0 * planned->force;
  const auto pushed = [&](double push, const Eigen::VectorXd& from) {
    planned->rod.tip_force = {-push, 0.0};
    PoseProgram program(planned->spec);
    program.set_branch(0, Branch::touching);
    return moved(program, from);
  };
  const auto margin = [&](const Eigen::VectorXd& x) { return judged(*planned, x).stability; };
  const double limit = tolerance::stability;
  for (const double wanted : {2.0 * limit, 0.5 * limit, -2.0 * limit}) {
    const Eigen::VectorXd x = pushed_to_margin(planned->x, wanted, pushed, margin);
    const Certificate certificate = judged(*planned, x);
    ASSERT_NEAR(certificate.stability, wanted, 0.1 * limit);
    if (wanted > limit) {
      expect_accepted(certificate);
    } else {
      expect_refused(certificate, {"stability"}, certificate.stability, three_digits);
    }
  }
}

TEST(CounterexampleMirroredGrasp, NoNumberIsNoGrasp) {
  const std::unique_ptr<Finger> planned = mirrored_grasp(small_object());
  Eigen::VectorXd x = planned->x;
  x[2] = std::nan("");
  const Certificate certificate = judged(*planned, x);
  ASSERT_EQ(certificate.failures.size(), 1U);
  EXPECT_EQ(certificate.failures[0], "the plan is not finite");
}

}  // namespace
}  // namespace tendril::grasps
