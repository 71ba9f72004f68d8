#include "extremes/cases.hpp"

#include <cmath>

#include "extremes/groups.hpp"

namespace tendril::bench {

Vec2 arc_tip(double angle) {
  if (angle == 0.0) return {1.0, 0.0};
  return {std::sin(angle) / angle, (1.0 - std::cos(angle)) / angle};
}

const KnownAnswer braced{Vec2{0.9670319442, 0.2200183222}, 0.5862167146, 0.06178404562 * 0.01 / 4.9e-4, 1e-9};

std::vector<ExtremeCase> extreme_cases(std::uint64_t held_out) {
  CaseList list(held_out);
  add_scales(list);
  add_softness(list);
  add_large_angles(list);
  add_obstacles(list);
  add_contacts(list);
  add_shapes(list);
  add_trajectories(list);
  add_programs(list);
  add_outlines(list);
  return list.take();
}

}  // namespace tendril::bench
