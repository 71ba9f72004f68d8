#pragma once

#include <array>
#include <memory>

#include "certificate/certifier.hpp"
#include "certificate/finger_clearance.hpp"
#include "program/grasp_program.hpp"

namespace tendril {

/// Judges points of a grasp of two fingers as Certifier does those of one rod: what concerns a finger alone is the
/// worse of both; balance, clearance between them and stationarity are those of the whole.
class TENDRIL_API GraspCertifier {
 public:
  /// For the program to be judged; what its spec points at must outlive this.
  explicit GraspCertifier(const GraspProgram& program);

  Certificate certify(GraspProgram& program, ConstVectorRef x);
  /// Judge of one finger alone, for points of its own program.
  Certifier& finger(int which) { return *fingers_[static_cast<std::size_t>(which)]; }
  /// How the fingers lie to each other at x.
  FingerClearance clearance(ConstVectorRef x);
  /// The program on the rule with twice the nodes, moved to x.
  GraspProgram& finer(ConstVectorRef x);

 private:
  std::array<std::unique_ptr<Certifier>, 2> fingers_;
  std::unique_ptr<GraspProgram> finer_;
};

}  // namespace tendril
