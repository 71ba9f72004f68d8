#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "certificate/certifier.hpp"
#include "nlp/feasibility.hpp"
#include "search/sides.hpp"

namespace tendril {

/// From a shape to a feasible point near it, where every contact touches. No target changes that.
struct Beginning {
  int number = -1;  ///< SideStart::number
  std::vector<ContactSetup> contacts;
  std::vector<int> regions;
  std::vector<CheckPoint> checks;
  std::shared_ptr<PoseProgram> program;  ///< without rows that hold a plan back
  std::shared_ptr<Certifier> certifier;  ///< of the program, once it was asked for
  FeasibilityReport near;
  double work = 0.0;           ///< that it took
  std::optional<Sides> sides;  ///< of the point, once they were asked for
};

}  // namespace tendril
