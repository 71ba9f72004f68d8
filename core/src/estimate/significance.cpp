#include "estimate/significance.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rod/quadrature.hpp"

namespace tendril {

double chi_square_probability(double value, int degrees) {
  if (degrees <= 0 || value <= 0.0) return 1.0;
  // exp(-x/2) sum (x/2)^i / i!, each term by its logarithm: both factors may leave the range of numbers.
  const double half = 0.5 * value;
  double sum = 0.0;
  double log_term = -half;
  for (int i = 0; i < degrees / 2; ++i) {
    if (i > 0) log_term += std::log(half / i);
    sum += std::exp(log_term);
  }
  return std::min(1.0, sum);
}

double t_square_probability(double square, int degrees) {
  if (square <= 0.0) return 1.0;
  // With t = sqrt(degrees) tan(angle) the density is proportional to cos^(degrees-1).
  const Quadrature rule(64);
  const auto integral = [&](double from) {
    // Where the cosine's power has died away nothing is left to integrate.
    const double to = std::min(0.5 * std::numbers::pi, from + 12.0 / std::sqrt(static_cast<double>(degrees)));
    double sum = 0.0;
    for (int g = 0; g < rule.size(); ++g) {
      const double angle = from + (to - from) * rule.nodes()[g];
      sum += rule.weights()[g] * std::pow(std::cos(angle), degrees - 1);
    }
    return (to - from) * sum;
  };
  return std::min(1.0, integral(std::atan(std::sqrt(square / degrees))) / integral(0.0));
}

double curve_length(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& known, double least) {
  Eigen::MatrixXd rest = columns;
  if (known.cols() > 0) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(known);
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(known.rows(), known.cols());
    rest -= q * (q.transpose() * rest);
  }
  double length = 0.0;
  Eigen::VectorXd before;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const double size = rest.col(i).norm();
    if (!(size > least * columns.col(i).norm())) continue;
    const Eigen::VectorXd here = rest.col(i) / size;
    if (before.size() > 0) length += std::acos(std::min(1.0, std::abs(before.dot(here))));
    before = here;
  }
  return length;
}

double improvement_probability(double improvement, double curve, int degrees) {
  if (!(improvement > 0.0)) return 1.0;
  const double single =
      degrees == 0 ? std::erfc(std::sqrt(0.5 * improvement)) : t_square_probability(improvement, degrees);
  const double along =
      degrees == 0 ? std::exp(-0.5 * improvement) : std::pow(1.0 + improvement / degrees, -0.5 * degrees);
  return std::min(1.0, single + curve / std::numbers::pi * along);
}

double smooth_probability(const Eigen::VectorXd& residuals) {
  const Eigen::Index changes = residuals.size() - 2;
  const double square = residuals.squaredNorm();
  if (changes < 2 || square == 0.0) return 1.0;
  // Sum of squared changes over sum of squares: 2 on average, with a variance of 4 over the number of residuals.
  const double ratio = (residuals.tail(changes) - residuals.head(changes)).squaredNorm() / square *
                       static_cast<double>(residuals.size()) / static_cast<double>(changes);
  const double deviations = (2.0 - ratio) / (2.0 / std::sqrt(static_cast<double>(residuals.size())));
  return 0.5 * std::erfc(deviations / std::sqrt(2.0));
}

}  // namespace tendril
