#include <algorithm>
#include <array>
#include <cmath>

#include "tendril/bounded_off_target.hpp"
#include "tendril/plugin.hpp"
#include "tendril/weight_matrix.hpp"

namespace {

using namespace tendril;

/// e^T Q e with e = (x, y, angle) of the tip minus the target's (paper, Eq. 5). What the target lacks counts as met, so
/// that there are always three residuals.
class TipPose : public ObjectiveBase<TipPose>, public BoundedOffTarget {
 public:
  TipPose(NumberTable root, bool reads_angle)
      : root_(std::move(root)), reads_angle_(reads_angle), least_weight_(least_weight(root_)) {}

  Reads reads() const override { return {.tip_position = true, .tip_angle = reads_angle_, .target = true}; }

  double lower_bound_off_target(double distance) const override { return least_weight_ * distance * distance; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    std::array<T, 3> error{};
    if (x.target.has_position) {
      error[0] = x.tip.x - x.target.position.x;
      error[1] = x.tip.y - x.target.position.y;
    }
    if (x.target.has_angle) error[2] = x.tip.angle - x.target.angle;
    add_weighted<T>(root_, error, out);
  }

 private:
  /// Smallest eigenvalue of Q for the position, with the angle that makes the most of it.
  static double least_weight(const NumberTable& root) {
    const auto q = [&](int i, int k) {
      double sum = 0.0;
      for (int row = 0; row < root.rows; ++row) sum += root(row, i) * root(row, k);
      return sum;
    };
    const auto weight = [&](int i, int k) { return q(i, k) - (q(2, 2) > 0.0 ? q(i, 2) * q(k, 2) / q(2, 2) : 0.0); };
    const double mean = 0.5 * (weight(0, 0) + weight(1, 1));
    return std::max(0.0, mean - std::hypot(0.5 * (weight(0, 0) - weight(1, 1)), weight(0, 1)));
  }

  NumberTable root_;
  bool reads_angle_;
  double least_weight_;
};

std::unique_ptr<ObjectiveTerm> make(const Options& given) {
  const NumberTable& weights = given.table("weights");
  if (weights.rows == 3) return std::make_unique<TipPose>(weight_root(weights, 3, "weights"), weights(2, 2) != 0.0);
  const NumberTable p = weight_root(weights, 2, "weights");
  const double angle = std::sqrt(given.real("angle_weight"));
  const NumberTable root{3, 3, {p(0, 0), p(0, 1), 0, p(1, 0), p(1, 1), 0, 0, 0, angle}};
  return std::make_unique<TipPose>(root, angle != 0.0);
}

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "weights",
                              .type = OptionType::matrix,
                              .default_value = NumberTable{1, 1, {1.0}},
                              .description = "Q for x and y, or for x, y and angle"},
                             {.name = "angle_weight",
                              .default_value = 1.0,
                              .description = "weight of the angle unless weights has one; 0: leave it out",
                              .minimum = 0}};
  registrar.add(
      ObjectiveComponent{"tip_pose", "the tip at the target: what it has of position and angle", options, make});
}
