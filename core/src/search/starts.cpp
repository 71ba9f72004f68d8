#include <algorithm>
#include <cmath>
#include <numbers>

#include "search/earlier_plan.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.

}  // namespace

StartShape Planner::start_shape(int index, const Mode& mode) const {
  // An earlier plan comes first, then the scene's own start, then shapes that bend to either side.
  if (control_.start != nullptr && !control_.start->backbone.empty()) {
    if (index == 0) return shape_of(d_, *control_.start, mode);
    --index;
  }
  if (d_.palm && mode.contacts.size() == 1) {
    if (index < d_.grip->starts()) return d_.grip->start(d_, mode, index);
    index -= d_.grip->starts();
  }
  if (index == 0) return d_.palm ? held(d_.scene.start_tip_angle, mode) : d_.scene_start();
  if (loaded() && index > 0) {
    if (index <= 2) return hanging(index == 2);
    index -= 2;
  }
  const double own = d_.scene.start_tip_angle;
  const double spread = std::max(0.8, std::abs(own));
  const double angles[] = {own,
                           -own - (own == 0.0 ? 0.4 : 0.0),
                           own + spread,
                           own - spread,
                           0.25 * own + 0.1,
                           own + 2.0 * spread,
                           own - 2.0 * spread};
  const double angle = angles[std::min<std::size_t>(static_cast<std::size_t>(index), std::size(angles) - 1)];
  return d_.palm ? held(angle, mode) : constant_curvature(angle);
}

double Planner::load_size() const { return norm(d_.rod.whole_load()); }

bool Planner::loaded() const {
  return search_parameters().hang && !d_.palm && load_size() > search_parameters().deciding_load;
}

StartShape Planner::hanging(bool long_way) const {
  const Vec2 load = d_.rod.whole_load();
  const Vec2 along{std::cos(d_.rod.base_angle), std::sin(d_.rod.base_angle)};
  double turn = std::atan2(cross(along, load), dot(along, load));
  if (long_way) turn -= std::copysign(2.0 * std::numbers::pi, turn);
  // Next to the clamp a rod under tension search_parameters().deciding_load within 1/sqrt(tension).
  const double width = 1.0 / std::sqrt(std::max(norm(load), search_parameters().deciding_load));
  const double peak = turn / (width * (1.0 - std::exp(-1.0 / width)));
  StartShape shape;
  shape.curvature = [peak, width](double s) { return peak * std::exp(-s / width); };
  shape.moments.assign(d_.rod.actuators.size(), 0.0);
  for (std::size_t a = 0; a < shape.moments.size(); ++a) {
    shape.moments[a] = std::clamp(0.0, d_.rod.actuators[a].minimum, d_.rod.actuators[a].maximum);
  }
  return shape;
}

StartShape Planner::held(double tip_angle, const Mode& mode) const {
  StartShape shape = constant_curvature(tip_angle);
  shape.forces.assign(mode.contacts.size(), std::isfinite(d_.max_force) ? d_.max_force : 1.0);
  return shape;
}

}  // namespace tendril
