#include "certificate/both_fingers.hpp"

#include <algorithm>
#include <cmath>

#include "nlp/multipliers.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// A row or bound this near carries a multiplier, as in the judgement of one rod.
constexpr double active = 1e-8;

GraspProgramSpec doubled(GraspProgramSpec spec) {
  for (PoseProgramSpec& finger : spec.fingers) finger.nodes *= 2;
  return spec;
}

}  // namespace

GraspCertifier::GraspCertifier(const GraspProgram& program)
    : finer_(std::make_unique<GraspProgram>(doubled(program.spec()))) {
  for (int which = 0; which < 2; ++which)
    fingers_[static_cast<std::size_t>(which)] = std::make_unique<Certifier>(program.finger(which).spec());
}

GraspProgram& GraspCertifier::finer(ConstVectorRef x) {
  (void)finer_->jacobian(x);
  return *finer_;
}

FingerClearance GraspCertifier::clearance(ConstVectorRef x) {
  const GraspProgram& at = finer(x);
  const auto curve = [&](int which) {
    const PoseProgram& finger = at.finger(which);
    Curve made(finger.chain().curve_tables());
    made.follow(finger.backbone());
    return made;
  };
  const Curve upper = curve(0);
  const Curve lower = curve(1);
  return finger_clearance({&upper, at.spec().fingers[0].term_units.length, false},
                          {&lower, at.spec().fingers[1].term_units.length, true});
}

Certificate GraspCertifier::certify(GraspProgram& program, ConstVectorRef x) {
  Certificate c;
  if (!x.allFinite()) {
    c.failures.assign(1, "the plan is not finite");
    return c;
  }
  for (int which = 0; which < 2; ++which) {
    Certificate one;
    finger(which).measure(program.finger(which), program.finger_point(which, x), one);
    c = which == 0 ? one : worse_of(c, one);
  }
  c.penetration = std::max(c.penetration, clearance(x).depth);
  GraspProgram& at = finer(x);
  c.balance = std::max(norm(net_force(at) + at.spec().load), std::abs(net_moment(at)));
  // Every contact of a grasp touches and presses, so that there is one branch only.
  c.stationarity = judge_kkt(at, x, active).stationarity;
  c.stationarity_kind = c.stationarity <= tolerance::stationarity ? "S" : "none";
  list_failures(c);
  return c;
}

}  // namespace tendril
