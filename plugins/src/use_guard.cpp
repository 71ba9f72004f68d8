#include "use_guard.hpp"

#include <cmath>
#include <utility>

#include "tendril/bounded_off_target.hpp"
#include "tendril/plugins/error.hpp"

namespace tendril::plugins {

namespace {

/// Normals are unit vectors to this: rounding stays far below it, a forgotten division does not.
constexpr double unit_length = 1e-6;
/// (L) Beyond this a distance may overflow, and a solver that asks there is on its way back.
constexpr double far_away = 1e6;

class Guard {
 public:
  explicit Guard(std::string where) : where_(std::move(where)) {}

  template <class Use>
  decltype(auto) operator()(const char* what, Use&& use) const {
    try {
      return use();
    } catch (const PluginError&) {
      throw;
    } catch (const std::exception& error) {
      fail(std::string("it threw in ") + what + ": " + error.what());
    } catch (...) {
      fail(std::string("it threw something that is no std::exception in ") + what);
    }
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw PluginError(Failure::threw, where_ + " cannot be used: " + reason, reason);
  }

 private:
  std::string where_;
};

class GuardedCoordinates final : public CoordinateModel {
 public:
  GuardedCoordinates(std::unique_ptr<CoordinateModel> made, std::string where)
      : made_(std::move(made)), guard_(std::move(where)) {
    functions_ = guard_("function_count()", [&] { return made_->function_count(); });
    if (functions_ < 1) guard_.fail("function_count() is " + std::to_string(functions_) + ", expected at least 1");
    double last = 0.0;
    for (const double point : breaks()) {
      if (!(point > last && point < 1.0)) guard_.fail("breaks() are not ascending between 0 and 1");
      last = point;
    }
    const std::vector<double> parts = subdivision();
    if (parts.empty()) guard_.fail("subdivision() is empty, expected at least one part");
    for (const double part : parts) {
      if (!(part > 0.0 && std::isfinite(part))) guard_.fail("subdivision() has a part that is not positive");
    }
  }

  int function_count() const override { return functions_; }
  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    guard_("evaluate()", [&] { made_->evaluate(sigma, value, first, second); });
    if (!value.allFinite() || !first.allFinite() || !second.allFinite()) {
      guard_.fail("evaluate() gives numbers that are not finite");
    }
  }
  std::vector<double> breaks() const override {
    return guard_("breaks()", [&] { return made_->breaks(); });
  }
  std::vector<double> subdivision() const override {
    return guard_("subdivision()", [&] { return made_->subdivision(); });
  }
  std::string coordinate_name(int i) const override {
    return guard_("coordinate_name()", [&] { return made_->coordinate_name(i); });
  }

 private:
  std::unique_ptr<CoordinateModel> made_;
  Guard guard_;
  int functions_ = 0;
};

class GuardedObjective final : public ObjectiveTerm, public BoundedOffTarget {
 public:
  GuardedObjective(std::unique_ptr<ObjectiveTerm> made, std::string where)
      : made_(std::move(made)),
        bounded_(dynamic_cast<const BoundedOffTarget*>(made_.get())),
        guard_(std::move(where)) {}

  Reads reads() const override {
    return guard_("reads()", [&] { return made_->reads(); });
  }
  double lower_bound() const override {
    return guard_("lower_bound()", [&] { return made_->lower_bound(); });
  }
  double lower_bound_off_target(double distance) const override {
    if (bounded_ == nullptr) return lower_bound();
    return guard_("lower_bound_off_target()", [&] { return bounded_->lower_bound_off_target(distance); });
  }
  void evaluate(const Quantities<double>& x, Contribution<double>& out) const override {
    guard_("its evaluation", [&] { made_->evaluate(x, out); });
  }
  void evaluate(const Quantities<HyperDual>& x, Contribution<HyperDual>& out) const override {
    guard_("the evaluation of its derivatives", [&] { made_->evaluate(x, out); });
  }

 private:
  std::unique_ptr<ObjectiveTerm> made_;
  const BoundedOffTarget* bounded_;  ///< the same; null: it knows no such bound
  Guard guard_;
};

class GuardedObstacle final : public Obstacle {
 public:
  GuardedObstacle(std::unique_ptr<Obstacle> made, std::string where)
      : made_(std::move(made)), guard_(std::move(where)) {
    if (!(smallest_radius() > 0.0)) guard_.fail("smallest_radius() is not positive");
    if (!(rounding() >= 0.0 && std::isfinite(rounding()))) guard_.fail("rounding() is negative or not finite");
    if (!std::isfinite(norm(reference_point()))) guard_.fail("reference_point() is not finite");
  }

  SurfacePoint at(Vec2 point) const override {
    return checked("at()", point, guard_("at()", [&] { return made_->at(point); }));
  }
  int patch_at(Vec2 point) const override {
    return guard_("patch_at()", [&] { return made_->patch_at(point); });
  }
  SurfacePoint on_patch(int patch, Vec2 point) const override {
    return checked("on_patch()", point, guard_("on_patch()", [&] { return made_->on_patch(patch, point); }));
  }
  std::span<const Seam> seams(int patch) const override {
    return guard_("seams()", [&] { return made_->seams(patch); });
  }
  Vec2 reference_point() const override {
    return guard_("reference_point()", [&] { return made_->reference_point(); });
  }
  double smallest_radius() const override {
    return guard_("smallest_radius()", [&] { return made_->smallest_radius(); });
  }
  double core_distance(Vec2 point) const override {
    const double distance = guard_("core_distance()", [&] { return made_->core_distance(point); });
    if (is_near(point) && !std::isfinite(distance)) guard_.fail("core_distance() is not finite" + at_point(point));
    return distance;
  }
  double rounding() const override {
    return guard_("rounding()", [&] { return made_->rounding(); });
  }
  bool convex() const override {
    return guard_("convex()", [&] { return made_->convex(); });
  }
  void bounding_box(Vec2& low, Vec2& high) const override {
    guard_("bounding_box()", [&] { made_->bounding_box(low, high); });
  }
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override {
    guard_("outline()", [&] { made_->outline(points, low, high); });
  }

 private:
  static bool is_near(Vec2 point) { return std::abs(point.x) < far_away && std::abs(point.y) < far_away; }
  static std::string at_point(Vec2 point) {
    return " at (" + std::to_string(point.x) + ", " + std::to_string(point.y) + ") in units of the rod's length";
  }
  SurfacePoint checked(const char* what, Vec2 point, const SurfacePoint& surface) const {
    if (!is_near(point)) return surface;
    if (!std::isfinite(surface.distance) || !std::isfinite(surface.curvature) ||
        !std::isfinite(surface.curvature_rate)) {
      guard_.fail(std::string(what) + " gives a number that is not finite" + at_point(point));
    }
    if (!(std::abs(norm(surface.normal) - 1.0) <= unit_length)) {
      guard_.fail(std::string(what) + " gives a normal that is no unit vector" + at_point(point));
    }
    return surface;
  }

  std::unique_ptr<Obstacle> made_;
  Guard guard_;
};

}  // namespace

std::unique_ptr<CoordinateModel> guarded(std::unique_ptr<CoordinateModel> made, std::string where) {
  return std::make_unique<GuardedCoordinates>(std::move(made), std::move(where));
}

std::unique_ptr<ObjectiveTerm> guarded(std::unique_ptr<ObjectiveTerm> made, std::string where) {
  return std::make_unique<GuardedObjective>(std::move(made), std::move(where));
}

std::unique_ptr<Obstacle> guarded(std::unique_ptr<Obstacle> made, std::string where) {
  return std::make_unique<GuardedObstacle>(std::move(made), std::move(where));
}

}  // namespace tendril::plugins
