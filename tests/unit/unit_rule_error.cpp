// Bounds of what a rule leaves of its integrals, beside a rule that leaves nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rod/curve.hpp"
#include "rod/rule_error.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril {
namespace {

/// Largest error of the integrals that a RuleError speaks of over the first piece: tangent times two functions of the
/// basis times (1 - sigma), and the tangent itself.
double integral_error(const Backbone& coarse, const Backbone& fine) {
  const auto integrals = [](const Backbone& b) {
    const BasisTable& t = b.chain().table();
    Eigen::MatrixXd all(2, t.functions * t.functions + 1);
    all.setZero();
    for (int g = 0; g < t.nodes; ++g) {
      const Eigen::Vector2d tangent(b.tangent(0, g).x, b.tangent(0, g).y);
      all.col(0) += t.weight[g] * tangent;
      for (int i = 0; i < t.functions; ++i) {
        for (int k = 0; k < t.functions; ++k) {
          const double factor = t.by_node(i, g) * t.by_node(k, g) * (1.0 - t.sigma[g]);
          all.col(1 + i * t.functions + k) += t.weight[g] * factor * tangent;
        }
      }
    }
    return all;
  };
  return (integrals(coarse) - integrals(fine)).colwise().norm().maxCoeff();
}

double tangent_error(const Backbone& coarse, const Backbone& fine) {
  Curve rough(coarse.chain().curve_tables());
  Curve exact(fine.chain().curve_tables());
  rough.follow(coarse);
  exact.follow(fine);
  double worst = 0.0;
  for (int i = 0; i <= 100; ++i)
    worst = std::max(worst, norm(rough.at(0, 0.01 * i).tangent - exact.at(0, 0.01 * i).tangent));
  return worst;
}

TEST(RuleError, IsNotBelowWhatARuleLeaves) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int told = 0;
  for (const int order : {1, 3, 6, 9}) {
    const LegendreBasis basis(order);
    for (int nodes = order + 4; nodes <= order + 12; nodes += 2) {
      for (const double bent : {0.1, 0.7, 3.0}) {
        const Rod rod;
        const Chain chain(rod, basis, {}, nodes);
        const Chain finer(rod, basis, {}, 60);
        Backbone coarse(chain, {}, 0.0);
        Backbone fine(finer, {}, 0.0);
        Eigen::VectorXd q(order);
        for (double& v : q) v = bent * uniform(random);
        coarse.move(q, {});
        fine.move(q, {});
        const RuleError error(chain);
        ASSERT_TRUE(error.known());
        const RuleError::Bound bound = error.of(coarse);
        constexpr double rounding = 1e-14;
        constexpr double rounding_of_series = 1e-12;  // 60 coefficients, and all count at the ends
        EXPECT_LE(integral_error(coarse, fine), bound.integral + rounding) << order << ' ' << nodes << ' ' << bent;
        EXPECT_LE(tangent_error(coarse, fine), bound.tangent + rounding_of_series)
            << order << ' ' << nodes << ' ' << bent;
        told += integral_error(coarse, fine) > 100.0 * rounding ? 1 : 0;
      }
    }
  }
  EXPECT_GT(told, 10);  // or nothing was compared but rounding
}

TEST(RuleError, IsSmallForTheRuleOfAPlan) {
  const LegendreBasis basis(6);
  const Rod rod;
  const Chain chain(rod, basis, {}, suggested_nodes(6, 1.0));
  Backbone backbone(chain, {}, 0.0);
  backbone.move((Eigen::VectorXd(6) << 0.5, -0.1, -0.03, 1e-3, 1e-4, -1e-5).finished(), {});
  const RuleError::Bound bound = RuleError(chain).of(backbone);
  EXPECT_LT(bound.integral, 1e-15);
  EXPECT_LT(bound.tangent, 1e-12);
}

/// A function that no polynomial of the rule's degree is.
class Kinked : public CoordinateModel {
 public:
  int function_count() const override { return 1; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override {
    for (std::size_t g = 0; g < sigma.size(); ++g) {
      const auto i = static_cast<Eigen::Index>(g);
      const double after = std::max(0.0, sigma[g] - 0.3);
      value(i, 0) = after * after;
      first(i, 0) = 2.0 * after;
      second(i, 0) = after > 0.0 ? 2.0 : 0.0;
    }
  }
};

TEST(RuleError, IsNotKnownOfWhatIsNoPolynomialOrNotEven) {
  const Kinked kinked;
  const LegendreBasis smooth(4);
  Rod rod;
  EXPECT_FALSE(RuleError(Chain(rod, kinked, {}, 20)).known());
  EXPECT_TRUE(RuleError(Chain(rod, smooth, {}, 20)).known());
  EXPECT_FALSE(RuleError(Chain(rod, smooth, {}, 5)).known());
  rod.segments[0].more_stiffness = {-0.5};
  EXPECT_FALSE(RuleError(Chain(rod, smooth, {}, 20)).known());
  rod.segments[0].more_stiffness = {};
  rod.segments[0].axial = 1600.0;
  rod.stretch_order = 2;
  EXPECT_FALSE(RuleError(Chain(rod, smooth, {}, 20)).known());
}

}  // namespace
}  // namespace tendril
