#include "tendril/plugin.hpp"

// Keeps the root mean square of the curvature below a limit: the excess of (mean square / limit^2) over 1 is a
// residual, and next to nothing below. The corner at 1 is rounded, since solvers need a second derivative.
class MeanCurvature : public tendril::ObjectiveBase<MeanCurvature> {
 public:
  explicit MeanCurvature(double limit) : square_(limit * limit) {}

  // Curvature at the nodes of Gauss's rule with five points on either half.
  tendril::Reads reads() const override {
    tendril::Reads reads;
    for (const double half : {0.0, 0.5}) {
      for (const double node : nodes) reads.samples.push_back(half + 0.5 * node);
    }
    return reads;
  }

  template <class T>
  void operator()(const tendril::Quantities<T>& x, tendril::Contribution<T>& out) const {
    using std::sqrt;
    T mean{};
    for (std::size_t i = 0; i < x.samples.size(); ++i) {
      mean += 0.5 * weights[i % 5] * x.samples[i].curvature * x.samples[i].curvature;
    }
    const T excess = mean / square_ - 1.0;
    constexpr double rounding = 1e-2;
    out.residual(0.5 * (excess + sqrt(excess * excess + rounding * rounding)));
  }

 private:
  static constexpr double nodes[] = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842, 0.953089922969332};
  static constexpr double weights[] = {0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683,
                                       0.118463442528095};
  double square_;
};

TENDRIL_PLUGIN(registrar) {
  const tendril::OptionSchema options{{.name = "limit",
                                       .default_value = 100.0,
                                       .description = "root mean square of the curvature that is free",
                                       .minimum = 0.0,
                                       .dimension = tendril::dimension::curvature,
                                       .minimum_excluded = true}};
  registrar.add(tendril::ObjectiveComponent{
      "mean_curvature", "bends no more than a limit, in the mean", options,
      [](const tendril::Options& given) { return std::make_unique<MeanCurvature>(given.real("limit")); }});
}
