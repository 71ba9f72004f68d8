#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// An arithmetic sequence of lengths, "91 mm:99 mm:5": first, last, count.
std::vector<double> read_lengths(const std::string& text, const QuantityReader& read);

/// Uniform numbers from a seed, the same on every platform.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}
  /// In [low, high).
  double operator()(double low, double high);

 private:
  std::uint64_t state_;
};

/// A shape to start from: curvature over the arc length is a parabola with random coefficients, the tip is turned by up
/// to 2 rad either way. Knows neither moments nor contacts.
Plan random_start(Uniform& random, double length);

/// On which side of every obstacle the rod passes it: '+' to the left of its reference point (seen along the rod), '-'
/// to the right. One character per obstacle. `references` in m.
std::string sides(const Plan& plan, const std::vector<Vec2>& references);

double median(std::vector<double> values);

}  // namespace tendril::bench
