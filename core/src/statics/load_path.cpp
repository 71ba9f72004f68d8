#include "statics/load_path.hpp"

#include <utility>

namespace tendril {

ShrunkObstacle::~ShrunkObstacle() = default;

SurfacePoint ShrunkObstacle::at(Vec2 point) const {
  SurfacePoint p = whole_->at(point);
  p.distance += by_;
  return p;
}

SurfacePoint ShrunkObstacle::on_patch(int patch, Vec2 point) const {
  SurfacePoint p = whole_->on_patch(patch, point);
  p.distance += by_;
  return p;
}

LoadPath::LoadPath(Rod rod, const std::vector<const Obstacle*>& obstacles, Ends ends)
    : rod_(std::move(rod)),
      gravity_(rod_.gravity),
      tip_force_(rod_.tip_force),
      rod_has_loads_(rod_.has_gravity() || rod_.has_tip_force()),
      ends_(std::move(ends)),
      shrink_(obstacles.size(), 0.0) {
  // Moments are given: no limit applies, and a limit of zero must not remove an actuator.
  for (Rod::Actuator& a : rod_.actuators) {
    a.minimum = -infinity;
    a.maximum = infinity;
  }
  for (const Obstacle* o : obstacles) {
    own_.push_back(std::make_unique<ShrunkObstacle>(*o));
    pointers_.push_back(own_.back().get());
  }
}

void LoadPath::apply(double load) {
  load_ = load;
  const double share = ends_.loads_grow ? load : 1.0;
  rod_.gravity = share * gravity_;
  rod_.tip_force = share * tip_force_;
  for (std::size_t o = 0; o < own_.size(); ++o) own_[o]->shrink((1.0 - load) * shrink_[o]);
}

}  // namespace tendril
