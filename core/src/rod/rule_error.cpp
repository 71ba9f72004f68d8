#include "rod/rule_error.hpp"

#include <algorithm>
#include <cmath>

#include "rod/curve.hpp"

namespace tendril {
namespace {

/// Legendre coefficients of a function of the basis below this share of the largest one are rounding.
constexpr double negligible = 1e-13;

/// Everything in the integrals but the tangent and the basis is constant over a piece, or linear.
bool is_even(const Chain& chain) {
  bool even = chain.stretches() == 0 && !chain.has_moving_work() && chain.curve_tables()->intervals() == 1;
  for (int j = 0; j < chain.piece_count(); ++j) {
    even = even && chain.piece(j).bends_evenly && chain.piece(j).weighs_evenly;
  }
  return even;
}

}  // namespace

RuleError::RuleError(const Chain& chain) : functions_(chain.functions()) {
  if (!is_even(chain)) return;
  const CurveTables& tables = *chain.curve_tables();
  const int n = tables.per_interval();
  const Eigen::MatrixXd series = tables.transform() * chain.table().by_function;
  // A function with coefficients up to the last one that the nodes can tell is not known to be a polynomial.
  const double least = negligible * series.cwiseAbs().maxCoeff();
  if (n < 3 || series.bottomRows(2).cwiseAbs().maxCoeff() > least) return;
  known_ = true;
  for (const double size : sizes) {
    Ellipse e;
    const double farthest = 0.5 * (size + 1.0 / size);
    Eigen::VectorXd largest(n);  // of Legendre polynomials in the ellipse
    legendre_polynomials(farthest, {largest.data(), static_cast<std::size_t>(n)});
    double most = 1.0;
    for (int i = 0; i < functions_; ++i) {
      double sum = 0.0;
      for (int k = 1; k < n; ++k) sum += std::abs(series(k, i)) > least ? std::abs(series(k, i)) * largest[k] : 0.0;
      e.bend.push_back(sum);
      most = std::max(most, sum + std::abs(series(0, i)));
    }
    const double reach = std::pow(size, 1 - n);
    e.integral = 32.0 / 15.0 * most * most * 0.5 * (1.0 + farthest) * reach * reach / (1.0 - 1.0 / (size * size));
    // Interpolation at Gauss's nodes is worse than the best polynomial by 1 and Lebesgue's constant, below 2 sqrt(n).
    e.tangent = (1.0 + 2.0 * std::sqrt(n)) * 2.0 * reach / (size - 1.0);
    ellipses_.push_back(std::move(e));
  }
}

RuleError::Bound RuleError::of(const Backbone& backbone) const {
  if (!known_) return {infinity, infinity};
  Bound worst;
  for (int j = 0; j < backbone.chain().piece_count(); ++j) {
    Bound own{infinity, infinity};
    const double* q = backbone.coordinates(j);
    for (const Ellipse& e : ellipses_) {
      double bend = 0.0;
      for (int i = 0; i < functions_; ++i) bend += std::abs(q[i]) * e.bend[static_cast<std::size_t>(i)];
      const double size = std::exp(bend);
      own.integral = std::min(own.integral, size * e.integral);
      own.tangent = std::min(own.tangent, size * e.tangent);
    }
    worst.integral = std::max(worst.integral, own.integral);
    worst.tangent = std::max(worst.tangent, own.tangent);
  }
  return worst;
}

}  // namespace tendril
