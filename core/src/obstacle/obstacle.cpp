#include "tendril/obstacle.hpp"

namespace tendril {

Obstacle::~Obstacle() = default;

int Obstacle::patch_at(Vec2) const { return 0; }

SurfacePoint Obstacle::on_patch(int, Vec2 point) const { return at(point); }

std::span<const Seam> Obstacle::seams(int) const { return {}; }

bool Obstacle::convex() const { return true; }

}  // namespace tendril
