#pragma once

#include <utility>

#include "program/pose_program.hpp"

namespace tendril {

/// The same rod and contacts without what does not decide its shape: terms, clearances, and rows that hold a plan back.
/// Variables and the rows of equilibrium and contact stay where they are.
inline PoseProgramSpec equations_alone(PoseProgramSpec spec) {
  spec.least_margin.reset();
  spec.least_convexity.reset();
  spec.checks.clear();
  spec.terms.clear();
  return spec;
}

}  // namespace tendril
