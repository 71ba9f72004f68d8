#pragma once

#include <Eigen/Core>
#include <array>

namespace tendril::bench {

inline constexpr int rule_size = 16;

/// Gauss-Legendre on [0,1] with the matrix of integrals from 0 to each node.
struct GaussRule {
  std::array<double, rule_size> node{}, weight{};
  Eigen::Matrix<double, rule_size, rule_size> to_node;

  GaussRule();
};

/// The one rule, made once.
const GaussRule& rule();

}  // namespace tendril::bench
