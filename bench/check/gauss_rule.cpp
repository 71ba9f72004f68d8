#include "check/gauss_rule.hpp"

#include <cmath>

namespace tendril::bench {

GaussRule::GaussRule() {
  for (int i = 0; i < rule_size; ++i) {
    double x = std::cos(M_PI * (i + 0.75) / (rule_size + 0.5));
    double slope = 0.0;
    for (int step = 0; step < 50; ++step) {
      const double p = std::legendre(rule_size, x);
      slope = rule_size * (x * p - std::legendre(rule_size - 1, x)) / (x * x - 1.0);
      const double change = p / slope;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    const auto at = static_cast<std::size_t>(rule_size - 1 - i);
    node[at] = 0.5 * (1.0 + x);
    weight[at] = 1.0 / ((1.0 - x * x) * slope * slope);
  }
  for (int i = 0; i < rule_size; ++i) {
    for (int k = 0; k < rule_size; ++k) {
      double sum = 0.0;
      for (int j = 0; j < rule_size; ++j) {
        const double t = node[static_cast<std::size_t>(i)] * node[static_cast<std::size_t>(j)];
        double cardinal = 1.0;
        for (int m = 0; m < rule_size; ++m) {
          if (m == k) continue;
          const double xm = node[static_cast<std::size_t>(m)];
          cardinal *= (t - xm) / (node[static_cast<std::size_t>(k)] - xm);
        }
        sum += weight[static_cast<std::size_t>(j)] * cardinal;
      }
      to_node(i, k) = node[static_cast<std::size_t>(i)] * sum;
    }
  }
}

const GaussRule& rule() {
  static const GaussRule the_rule;
  return the_rule;
}

}  // namespace tendril::bench
