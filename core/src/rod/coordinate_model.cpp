#include "tendril/coordinate_model.hpp"

#include "tendril/error.hpp"

namespace tendril {

CoordinateModel::~CoordinateModel() = default;

std::vector<double> CoordinateModel::breaks() const { return {}; }

std::vector<double> CoordinateModel::subdivision() const { return {1.0}; }

std::string CoordinateModel::coordinate_name(int i) const { return "q_" + std::to_string(i + 1) + " [rad]"; }

LegendreBasis::LegendreBasis(int order, int pieces) : order_(order), pieces_(pieces) {
  if (order < 1 || order > maximum_order) {
    throw Error("the Legendre basis has order " + std::to_string(order) + "; expected 1 to " +
                std::to_string(maximum_order));
  }
  if (pieces < 1) {
    throw Error("the Legendre basis has " + std::to_string(pieces) + " pieces; expected at least 1");
  }
}

LegendreBasis::~LegendreBasis() = default;

int LegendreBasis::function_count() const { return order_; }

std::vector<double> LegendreBasis::subdivision() const {
  return std::vector<double>(static_cast<std::size_t>(pieces_), 1.0 / pieces_);
}

void LegendreBasis::evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value,
                             Eigen::Ref<Eigen::MatrixXd> first, Eigen::Ref<Eigen::MatrixXd> second) const {
  for (Eigen::Index g = 0; g < static_cast<Eigen::Index>(sigma.size()); ++g) {
    const double s = sigma[static_cast<std::size_t>(g)];
    const double x = 2.0 * s - 1.0;
    // P_(i-2) and P_(i-1) at 2 sigma - 1, and their derivatives in sigma. At sigma = 0 and 1 every step of the
    // recurrence is a whole number, so beta_i vanishes there exactly.
    double before = 0.0;
    double here = 1.0;
    double before_slope = 0.0;
    double here_slope = 0.0;
    for (int i = 1; i <= order_; ++i) {
      const double after = ((2 * i - 1) * x * here - (i - 1) * before) / i;
      const double after_slope = before_slope + (2 * i - 1) * 2.0 * here;
      value(g, i - 1) = i == 1 ? s : (after - before) / (2.0 * (2 * i - 1));
      first(g, i - 1) = here;
      second(g, i - 1) = here_slope;
      before = here;
      here = after;
      before_slope = here_slope;
      here_slope = after_slope;
    }
  }
}

}  // namespace tendril
