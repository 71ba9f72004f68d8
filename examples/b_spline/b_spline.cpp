#include <vector>

#include "tendril/plugin.hpp"

// The angle as a cubic B-spline on equal intervals: curvature is continuous and its slope is too, except at the knots,
// where its second derivative jumps. breaks() names the knots, so that quadrature is cut there.
class BSpline : public tendril::CoordinateModel {
 public:
  explicit BSpline(int intervals) : intervals_(intervals), knots_(degree, 0.0) {
    for (int i = 0; i <= intervals; ++i) knots_.push_back(double(i) / intervals);
    knots_.insert(knots_.end(), degree, 1.0);
  }

  // All B-splines but the first, which is the only one that does not vanish at 0.
  int function_count() const override { return intervals_ + degree - 1; }

  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    for (Eigen::Index g = 0; g < value.rows(); ++g) {
      const double s = sigma[static_cast<std::size_t>(g)];
      for (int i = 0; i < function_count(); ++i) {
        value(g, i) = basis(i + 1, degree, 0, s);
        first(g, i) = basis(i + 1, degree, 1, s);
        second(g, i) = basis(i + 1, degree, 2, s);
      }
    }
  }

  std::vector<double> breaks() const override { return {knots_.begin() + degree + 1, knots_.end() - degree - 1}; }

 private:
  static constexpr int degree = 3;

  double knot(int i) const { return knots_[static_cast<std::size_t>(i)]; }

  // Derivative number `order` of B-spline i of degree p, by the recurrences of Cox and de Boor.
  double basis(int i, int p, int order, double s) const {
    if (p == 0)
      return s >= knot(i) && (s < knot(i + 1) || (s == 1.0 && knot(i + 1) == 1.0 && knot(i) < 1.0)) ? 1.0 : 0.0;
    const double left = knot(i + p) - knot(i);
    const double right = knot(i + p + 1) - knot(i + 1);
    double sum = 0.0;
    if (order > 0) {
      if (left > 0.0) sum += p / left * basis(i, p - 1, order - 1, s);
      if (right > 0.0) sum -= p / right * basis(i + 1, p - 1, order - 1, s);
    } else {
      if (left > 0.0) sum += (s - knot(i)) / left * basis(i, p - 1, 0, s);
      if (right > 0.0) sum += (knot(i + p + 1) - s) / right * basis(i + 1, p - 1, 0, s);
    }
    return sum;
  }

  int intervals_;
  std::vector<double> knots_;
};

TENDRIL_PLUGIN(registrar) {
  const tendril::OptionSchema options{{.name = "intervals",
                                       .type = tendril::OptionType::integer,
                                       .default_value = std::int64_t{4},
                                       .description = "equal intervals between knots on each piece",
                                       .minimum = 1,
                                       .maximum = 32}};
  registrar.add(tendril::CoordinateComponent{
      "b_spline", "the angle as a cubic B-spline", options, [](const tendril::Options& given) {
        return std::make_unique<BSpline>(static_cast<int>(given.integer("intervals")));
      }});
}
