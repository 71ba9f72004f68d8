#include <algorithm>
#include <cmath>

#include "tendril/hyper_dual.hpp"
#include "tendril/plugin.hpp"

using tendril::SurfacePoint;
using tendril::Vec2;

// |x/a|^n + |y/b|^n = 1 around a centre, n >= 3. The distance of a convex body is the largest distance to its
// supporting lines, inside and outside: d(P) = max over the normal's angle of P . n - h, with the support function h =
// (|a cos|^q + |b sin|^q)^(1/q), 1/n + 1/q = 1. By symmetry the first quadrant is enough.
class Superellipse : public tendril::Obstacle {
 public:
  Superellipse(Vec2 center, double a, double b, double exponent)
      : center_(center), a_(a), b_(b), n_(exponent), q_(exponent / (exponent - 1.0)), radius_(tendril::infinity) {
    for (int i = 0; i <= samples; ++i) radius_ = std::min(radius_, 1.0 / curvature(foot(quarter * i / samples)));
    radius_ *= 0.999;  // the smallest lies between two samples; the error there is of second order, far below this
  }

  SurfacePoint at(Vec2 point) const override {
    const Vec2 p = point - center_;
    const Vec2 sign{std::copysign(1.0, p.x), std::copysign(1.0, p.y)};
    const double angle = nearest_angle({std::abs(p.x), std::abs(p.y)});
    const Vec2 normal{std::cos(angle), std::sin(angle)};
    const Vec2 on = foot(angle);
    const double distance = dot({std::abs(p.x), std::abs(p.y)}, normal) - dot(on, normal);
    // The level set at distance d from a boundary of curvature k has k / (1 + k d).
    using tendril::HyperDual;
    const HyperDual k = curvature(HyperDual(on.x, -normal.y, 0.0, 0.0), HyperDual(on.y, normal.x, 0.0, 0.0));
    const double growth = 1.0 + k.v * distance;
    return {distance,
            {sign.x * normal.x, sign.y * normal.y},
            k.v / growth,
            sign.x * sign.y * k.a / (growth * growth * growth)};
  }
  double core_distance(Vec2 point) const override { return std::max(0.0, at(point).distance + radius_); }
  double rounding() const override { return radius_; }
  double smallest_radius() const override { return radius_; }
  Vec2 reference_point() const override { return center_; }
  void bounding_box(Vec2& low, Vec2& high) const override {
    low = center_ - Vec2{a_, b_};
    high = center_ + Vec2{a_, b_};
  }
  void outline(std::span<Vec2> points, Vec2, Vec2) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double t = 4.0 * quarter * double(i) / double(points.size());
      const double c = std::cos(t), s = std::sin(t);
      points[i] = center_ + Vec2{a_ * std::copysign(std::pow(std::abs(c), 2.0 / n_), c),
                                 b_ * std::copysign(std::pow(std::abs(s), 2.0 / n_), s)};
    }
  }

 private:
  static constexpr double quarter = 1.5707963267948966;
  static constexpr int samples = 1000;

  // The boundary point whose normal has this angle in [0, pi/2].
  Vec2 foot(double angle) const {
    const double c = a_ * std::max(0.0, std::cos(angle)), s = b_ * std::max(0.0, std::sin(angle));
    const double cq = std::pow(c, q_ - 1.0), sq = std::pow(s, q_ - 1.0);
    const double scale = std::pow(c * cq + s * sq, 1.0 / q_ - 1.0);
    return {a_ * cq * scale, b_ * sq * scale};
  }

  // Of the boundary through (x, y), x, y >= 0.
  template <class T>
  T curvature(const T& x, const T& y) const {
    using std::pow;
    using std::sqrt;
    const T gx = n_ / a_ * pow(x / a_, n_ - 1.0), gy = n_ / b_ * pow(y / b_, n_ - 1.0);
    const T gxx = n_ * (n_ - 1.0) / (a_ * a_) * pow(x / a_, n_ - 2.0);
    const T gyy = n_ * (n_ - 1.0) / (b_ * b_) * pow(y / b_, n_ - 2.0);
    const T square = gx * gx + gy * gy;
    return (gx * gx * gyy + gy * gy * gxx) / (square * sqrt(square));
  }
  double curvature(Vec2 p) const { return curvature(p.x, p.y); }

  // Every ascent from a grid to a maximum of P . n - h; deep inside there may be two, and the higher one counts.
  double nearest_angle(Vec2 p) const {
    constexpr int grid = 16;
    const auto lines = [&](double angle) {
      const Vec2 normal{std::cos(angle), std::sin(angle)};
      return dot(p - foot(angle), normal);
    };
    const auto slope = [&](double angle) { return dot(p - foot(angle), {-std::sin(angle), std::cos(angle)}); };
    double best = 0.0, highest = -tendril::infinity;
    double low_slope = slope(0.0);
    for (int i = 0; i < grid; ++i) {
      double low = quarter * i / grid, high = quarter * (i + 1) / grid;
      const double high_slope = slope(high);
      const bool rises = low_slope > 0.0;
      low_slope = high_slope;
      double angle = low;
      if (rises && high_slope < 0.0) {
        angle = 0.5 * (low + high);
        for (int step = 0; step < 100; ++step) {
          const double s = slope(angle);
          (s > 0.0 ? low : high) = angle;
          const double newton = angle + s / (lines(angle) + 1.0 / curvature(foot(angle)));
          const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
          if (std::abs(next - angle) < 1e-15) break;
          angle = next;
        }
      } else if (i == grid - 1 && high_slope >= 0.0) {
        angle = high;
      }
      if (lines(angle) > highest) {
        highest = lines(angle);
        best = angle;
      }
    }
    return best;
  }

  Vec2 center_;
  double a_, b_, n_, q_, radius_;
};

TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  const auto half = [](const char* name) {
    return OptionSpec{.name = name,
                      .description = "half of its extent",
                      .minimum = 0.0,
                      .dimension = dimension::length,
                      .required = true,
                      .minimum_excluded = true};
  };
  const OptionSchema options{
      {.name = "center", .type = OptionType::list, .dimension = dimension::length, .required = true, .size = 2},
      half("half_width"),
      half("half_height"),
      {.name = "exponent", .default_value = 4.0, .description = "n", .minimum = 3.0, .maximum = 20.0}};
  registrar.add(ObstacleComponent{"superellipse", "|x/a|^n + |y/b|^n <= 1", options, [](const Options& given) {
                                    const NumberTable& at = given.table("center");
                                    return std::make_unique<Superellipse>(
                                        Vec2{at(0, 0), at(0, 1)}, given.real("half_width"), given.real("half_height"),
                                        given.real("exponent"));
                                  }});
}
