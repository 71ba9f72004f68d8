#include "obstacle/shrunk.hpp"

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

}  // namespace tendril
