#pragma once

#include <string>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// A bound that nothing can satisfy, in words; empty if there is none.
std::string contradiction(const NonlinearProgram& program);

}  // namespace tendril
