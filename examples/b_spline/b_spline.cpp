#include <cmath>

#include "tendril/plugin.hpp"

// The angle as a cubic B-spline on equal intervals: curvature is continuous and its slope is too, except at the knots,
// where its second derivative jumps. breaks() names the knots, so that quadrature is cut there.
class BSpline : public tendril::CoordinateModel {
 public:
  explicit BSpline(int intervals) : intervals_(intervals) {}

  // One B-spline for each run of four intervals that meets the piece. One is left out: all of them add up to a
  // constant.
  int function_count() const override { return intervals_ + 2; }

  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    for (Eigen::Index g = 0; g < value.rows(); ++g) {
      for (int i = 0; i < function_count(); ++i) {
        // From the middle of the B-spline, in intervals. Local functions begin at 0, so its value there is taken off.
        const double u = intervals_ * sigma[static_cast<std::size_t>(g)] - i, at_start = -i;
        const double side = u < 0.0 ? -1.0 : 1.0, a = std::abs(u), b = std::max(0.0, 2.0 - a);
        value(g, i) = cubic(u) - cubic(at_start);
        first(g, i) = intervals_ * side * (a < 1.0 ? a * (1.5 * a - 2.0) : -0.5 * b * b);
        second(g, i) = intervals_ * intervals_ * (a < 1.0 ? 3.0 * a - 2.0 : b);
      }
    }
  }

  std::vector<double> breaks() const override {
    std::vector<double> knots;
    for (int i = 1; i < intervals_; ++i) knots.push_back(static_cast<double>(i) / intervals_);
    return knots;
  }

 private:
  static double cubic(double u) {
    const double a = std::abs(u), b = std::max(0.0, 2.0 - a);
    return a < 1.0 ? 2.0 / 3.0 + a * a * (0.5 * a - 1.0) : b * b * b / 6.0;
  }

  int intervals_;
};

TENDRIL_PLUGIN(registrar) {
  const tendril::OptionSchema options{{"intervals", tendril::OptionType::integer, 4L, "equal intervals", 1, 32}};
  registrar.add(tendril::CoordinateComponent{
      "b_spline", "the angle as a cubic B-spline", options, [](const tendril::Options& given) {
        return std::make_unique<BSpline>(static_cast<int>(given.integer("intervals")));
      }});
}
