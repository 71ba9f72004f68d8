#include <cmath>

#include "tendril/plugin.hpp"

// Curvature as a cosine series: the angle is a straight line and sines of 1, 2, ... half waves on each piece.
class Trigonometric : public tendril::CoordinateModel {
 public:
  explicit Trigonometric(int order) : order_(order) {}

  int function_count() const override { return order_; }

  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    constexpr double pi = 3.141592653589793;
    for (Eigen::Index g = 0; g < value.rows(); ++g) {
      const double s = sigma[static_cast<std::size_t>(g)];
      value(g, 0) = s;
      first(g, 0) = 1.0;
      second(g, 0) = 0.0;
      for (int k = 1; k < order_; ++k) {
        const double wave = k * pi;
        value(g, k) = std::sin(wave * s) / wave;
        first(g, k) = std::cos(wave * s);
        second(g, k) = -wave * std::sin(wave * s);
      }
    }
  }

  std::string coordinate_name(int i) const override {
    return i == 0 ? "mean curvature [rad]" : "curvature in " + std::to_string(i) + " half waves [rad]";
  }

 private:
  int order_;
};

TENDRIL_PLUGIN(registrar) {
  const tendril::OptionSchema options{{.name = "order",
                                       .type = tendril::OptionType::integer,
                                       .default_value = std::int64_t{6},
                                       .description = "functions on each piece",
                                       .minimum = 1,
                                       .maximum = 32}};
  registrar.add(tendril::CoordinateComponent{
      "trigonometric", "curvature as a cosine series", options, [](const tendril::Options& given) {
        return std::make_unique<Trigonometric>(static_cast<int>(given.integer("order")));
      }});
}
