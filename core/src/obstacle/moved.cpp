#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "obstacle/room.hpp"
#include "obstacle/shape_options.hpp"
#include "tendril/numbers.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/pivot.hpp"

namespace tendril {
namespace {

bool is_finite(Vec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }

/// An obstacle elsewhere: turned about a point, then shifted.
class Elsewhere : public Obstacle, public Room {
 public:
  Elsewhere(std::unique_ptr<Obstacle> still, Vec2 center, Vec2 shift, double turn)
      : still_(std::move(still)),
        center_(center),
        moved_center_(center_ + shift),
        turns_(turn != 0.0),
        along_{std::cos(turn), std::sin(turn)} {}
  Elsewhere(const Elsewhere&) = delete;
  Elsewhere& operator=(const Elsewhere&) = delete;
  ~Elsewhere() override;

  SurfacePoint at(Vec2 point) const override { return turned_with(still_->at(back(point))); }
  int patch_at(Vec2 point) const override { return still_->patch_at(back(point)); }
  SurfacePoint on_patch(int patch, Vec2 point) const override {
    return turned_with(still_->on_patch(patch, back(point)));
  }
  std::span<const Seam> seams(int patch) const override {
    const std::span<const Seam> still = still_->seams(patch);
    if (still.empty()) return {};
    const std::lock_guard lock(mutex_);
    std::vector<Seam>& here = seams_[patch];
    for (std::size_t i = here.size(); i < still.size(); ++i) {
      const Vec2 normal = turned_by(still[i].normal);
      here.push_back({normal, still[i].offset - dot(still[i].normal, center_) + dot(normal, moved_center_)});
    }
    return here;
  }
  Vec2 reference_point() const override { return there(still_->reference_point()); }
  Vec2 pivot() const { return moved_center_; }
  double smallest_radius() const override { return still_->smallest_radius(); }
  double core_distance(Vec2 point) const override { return still_->core_distance(back(point)); }
  double rounding() const override { return still_->rounding(); }
  bool convex() const override { return still_->convex(); }
  double outside_room(Vec2 point) const override { return tendril::outside_room(*still_, back(point)); }
  void bounding_box(Vec2& low, Vec2& high) const override {
    still_->bounding_box(low, high);
    const std::array<Vec2, 4> corners{low, Vec2{high.x, low.y}, high, Vec2{low.x, high.y}};
    if (turns_ && !(is_finite(low) && is_finite(high))) {
      low = {-infinity, -infinity};
      high = {infinity, infinity};
      return;
    }
    low = {infinity, infinity};
    high = {-infinity, -infinity};
    for (const Vec2 corner : corners) {
      const Vec2 p = there(corner);
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override {
    // What holds the box holds what of the obstacle lies in it.
    Vec2 inner_low{infinity, infinity};
    Vec2 inner_high{-infinity, -infinity};
    for (const Vec2 corner : {low, Vec2{high.x, low.y}, high, Vec2{low.x, high.y}}) {
      const Vec2 p = back(corner);
      inner_low = {std::min(inner_low.x, p.x), std::min(inner_low.y, p.y)};
      inner_high = {std::max(inner_high.x, p.x), std::max(inner_high.y, p.y)};
    }
    still_->outline(points, inner_low, inner_high);
    for (Vec2& p : points) {
      if (is_finite(p)) p = there(p);
    }
  }

 private:
  Vec2 turned_by(Vec2 v) const { return turns_ ? v.x * along_ + v.y * turned(along_) : v; }
  Vec2 there(Vec2 point) const {
    return turns_ ? moved_center_ + turned_by(point - center_) : point + (moved_center_ - center_);
  }
  Vec2 back(Vec2 point) const {
    const Vec2 d = point - moved_center_;
    return turns_ ? center_ + Vec2{dot(along_, d), dot(turned(along_), d)} : point - (moved_center_ - center_);
  }
  SurfacePoint turned_with(SurfacePoint p) const {
    p.normal = turned_by(p.normal);
    return p;
  }

  std::unique_ptr<Obstacle> still_;
  Vec2 center_, moved_center_;
  bool turns_;
  Vec2 along_;
  mutable std::mutex mutex_;
  mutable std::map<int, std::vector<Seam>> seams_;  ///< of the patches that were asked for
};

Elsewhere::~Elsewhere() = default;

}  // namespace

std::unique_ptr<Obstacle> moved(std::unique_ptr<Obstacle> obstacle, Vec2 shift, double turn) {
  if (shift.x == 0.0 && shift.y == 0.0 && turn == 0.0) return obstacle;
  const Vec2 center = obstacle->reference_point();
  return std::make_unique<Elsewhere>(std::move(obstacle), center, shift, turn);
}

const OptionSpec& pivot_option() {
  static const OptionSpec option = point_option("pivot", "what it is turned about");
  return option;
}

std::unique_ptr<Obstacle> moved_about(std::unique_ptr<Obstacle> obstacle, Vec2 pivot, Vec2 shift, double turn) {
  return std::make_unique<Elsewhere>(std::move(obstacle), pivot, shift, turn);
}

Vec2 pivot_of(const Obstacle& obstacle) {
  const auto* elsewhere = dynamic_cast<const Elsewhere*>(&obstacle);
  return elsewhere == nullptr ? obstacle.reference_point() : elsewhere->pivot();
}

}  // namespace tendril
