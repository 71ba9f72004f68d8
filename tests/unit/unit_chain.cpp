// Rules, pieces and the backbone's points: what every program is integrated with and cut into.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "certificate/clearance.hpp"
#include "rod/backbone.hpp"
#include "rod/chain.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Functions of a test's own, with parts of different length and a break.
class Bumps : public CoordinateModel {
 public:
  int function_count() const override { return 2; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override {
    for (std::size_t g = 0; g < sigma.size(); ++g) {
      const auto i = static_cast<Eigen::Index>(g);
      const double s = sigma[g];
      const double after = std::max(0.0, s - at_break);
      value.row(i) << std::sin(3.0 * s) + offset, after * after;
      first.row(i) << 3.0 * std::cos(3.0 * s), 2.0 * after;
      second.row(i) << -9.0 * std::sin(3.0 * s), after > 0.0 ? 2.0 : 0.0;
    }
  }
  std::vector<double> breaks() const override { return {at_break}; }
  std::vector<double> subdivision() const override { return parts; }

  double at_break = 0.4;
  double offset = 0.0;
  std::vector<double> parts{1.0};
};

/// A slope with one narrow maximum, where no sample needs to be.
class Peak : public CoordinateModel {
 public:
  int function_count() const override { return 1; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override {
    for (std::size_t g = 0; g < sigma.size(); ++g) {
      const auto i = static_cast<Eigen::Index>(g);
      const double z = (sigma[g] - middle) / width;
      value(i, 0) = width * (std::atan(z) + std::atan(middle / width));
      first(i, 0) = 1.0 / (1.0 + z * z);
      second(i, 0) = -2.0 * z / (width * (1.0 + z * z) * (1.0 + z * z));
    }
  }
  double middle = 0.5, width = 0.01;
};

Rod stepped_rod() {
  Rod rod;
  rod.segments = {{0.0, 0.4, 1.0, 2.0, 0.3}, {0.4, 1.0, 0.5, 1.0, -0.2}};
  rod.actuators = {{0.0, 1.0}, {0.4, 1.0}, {0.0, 0.4}};
  return rod;
}

TEST(Quadrature, IsExactForPolynomialsOfTwiceItsOrder) {
  for (const int nodes : {1, 2, 3, 8, 21, 64, 151}) {
    SCOPED_TRACE(nodes);
    const Quadrature rule(nodes);
    for (int degree = 0; degree < 2 * nodes; ++degree) {
      double sum = 0.0;
      for (int g = 0; g < nodes; ++g) sum += rule.weights()[g] * std::pow(rule.nodes()[g], degree);
      // Rounding of the nodes to a few units in the last place, times the degree, and of a sum of positive numbers.
      ASSERT_NEAR(sum * (degree + 1), 1.0, 2e-15 * degree + 2e-14) << "degree " << degree;
    }
  }
}

TEST(Quadrature, OfTwoAndThreePointsHasItsTabulatedNumbers) {
  // Abramowitz and Stegun, table 25.4, moved to [0,1].
  const Quadrature two(2);
  EXPECT_NEAR(two.nodes()[0], 0.5 - 0.5 / std::numbers::sqrt3, 1e-16);
  EXPECT_NEAR(two.nodes()[1], 0.5 + 0.5 / std::numbers::sqrt3, 1e-15);
  EXPECT_NEAR(two.weights()[0], 0.5, 1e-15);
  const Quadrature three(3);
  EXPECT_EQ(three.nodes()[1], 0.5);
  EXPECT_NEAR(three.nodes()[2], 0.5 + 0.5 * std::sqrt(0.6), 1e-15);
  EXPECT_NEAR(three.weights()[1], 4.0 / 9.0, 1e-15);
}

TEST(Quadrature, UpToAPlaceIsExactOnEachInterval) {
  const double breaks[] = {0.3, 0.7};
  constexpr int nodes = 6;
  const Quadrature rule(nodes, breaks);
  ASSERT_EQ(rule.size(), 3 * nodes);
  EXPECT_NEAR(rule.weights().sum(), 1.0, 1e-15);
  // Another polynomial on each interval, and its integral.
  const auto f = [](double s) {
    return s < 0.3 ? 1.0 + s : s < 0.7 ? 4.0 * std::pow(s, 3) : 2.0 - 5.0 * std::pow(s, 4);
  };
  const auto integral = [](double s) {
    const auto first = [](double t) { return t + 0.5 * t * t; };
    const auto second = [](double t) { return std::pow(t, 4); };
    const auto third = [](double t) { return 2.0 * t - std::pow(t, 5); };
    if (s < 0.3) return first(s);
    if (s < 0.7) return first(0.3) + second(s) - second(0.3);
    return first(0.3) + second(0.7) - second(0.3) + third(s) - third(0.7);
  };
  std::vector<double> weights(3 * nodes);
  for (const double sigma : {0.0, 0.1, 0.3, 0.45, 0.7, 0.99, 1.0}) {
    rule.partial_weights(sigma, weights);
    double sum = 0.0;
    for (int g = 0; g < rule.size(); ++g) sum += weights[static_cast<std::size_t>(g)] * f(rule.nodes()[g]);
    EXPECT_NEAR(sum, integral(sigma), 1e-15) << "up to " << sigma;
  }
}

TEST(Quadrature, RefusesBreaksThatDoNotAscendInside) {
  for (const std::vector<double>& breaks : {std::vector<double>{0.0}, std::vector<double>{1.0},
                                            std::vector<double>{0.5, 0.5}, std::vector<double>{0.5, 0.4}}) {
    EXPECT_THROW(Quadrature(3, breaks), Error) << breaks.front();
  }
  EXPECT_THROW(Quadrature(0), Error);
}

TEST(Chain, HasPiecesWithThePropertiesOfTheirStretch) {
  const Rod rod = stepped_rod();
  Bumps model;
  model.parts = {1.0, 3.0};
  const int stretches[] = {0, 1, 1};
  const Chain chain(rod, model, stretches, 8);
  // Stretches [0, 0.4] with one knot and [0.4, 1] with two: five intervals of two pieces each.
  ASSERT_EQ(chain.piece_count(), 10);
  EXPECT_EQ(chain.knot_count(), 3);
  const double knots[] = {0.1, 0.5, 0.8};
  const double starts[] = {0.0, 0.025, 0.1, 0.175, 0.4, 0.425, 0.5, 0.575, 0.8, 0.85};
  for (int j = 0; j < 10; ++j) {
    SCOPED_TRACE("piece " + std::to_string(j));
    const double end = j == 9 ? 1.0 : starts[j + 1];
    EXPECT_NEAR(chain.start(j, knots), starts[j], 1e-15);
    EXPECT_NEAR(chain.length(j, knots), end - starts[j], 1e-15);
    const bool first = j < 4;
    EXPECT_EQ(chain.piece(j).stretch, first ? 0 : 1);
    EXPECT_EQ(chain.piece(j).stiffness, first ? 1.0 : 0.5);
    EXPECT_EQ(chain.piece(j).weight, first ? 2.0 : 1.0);
    EXPECT_EQ(chain.piece(j).rest_curvature, first ? 0.3 : -0.2);
    EXPECT_EQ(chain.level(0, j), 1.0);
    EXPECT_EQ(chain.level(1, j), first ? 0.0 : 1.0);
    EXPECT_EQ(chain.level(2, j), first ? 1.0 : 0.0);
  }
  EXPECT_EQ(chain.piece_before_knot(0), 1);
  EXPECT_EQ(chain.piece_before_knot(1), 5);
  EXPECT_EQ(chain.piece_before_knot(2), 7);
  // The earlier piece at a knot.
  EXPECT_EQ(chain.piece_at(0.0, knots), 0);
  EXPECT_EQ(chain.piece_at(0.1, knots), 1);
  EXPECT_EQ(chain.piece_at(0.1 + 1e-9, knots), 2);
  EXPECT_EQ(chain.piece_at(1.0, knots), 9);
}

TEST(Chain, FollowsItsKnotsAsItsRatesSay) {
  const Rod rod = stepped_rod();
  Bumps model;
  model.parts = {1.0, 3.0};
  const int stretches[] = {0, 1, 1};
  const Chain chain(rod, model, stretches, 8);
  const std::vector<double> knots{0.1, 0.5, 0.8};
  for (int k = 0; k < 3; ++k) {
    std::vector<double> moved = knots;
    moved[static_cast<std::size_t>(k)] += 0.01;
    for (int j = 0; j < chain.piece_count(); ++j) {
      EXPECT_NEAR(chain.start_rate()(j, k), 100.0 * (chain.start(j, moved) - chain.start(j, knots)), 1e-12);
      EXPECT_NEAR(chain.length_rate()(j, k), 100.0 * (chain.length(j, moved) - chain.length(j, knots)), 1e-12);
    }
    // The rod's own length does not change.
    EXPECT_NEAR(chain.length_rate().col(k).sum(), 0.0, 1e-15);
  }
  EXPECT_NEAR(chain.length0().sum(), 1.0, 1e-15);
}

TEST(Chain, RefusesWhatIsNoBasisOrNoKnot) {
  const Rod rod = stepped_rod();
  const LegendreBasis basis(3);
  for (const std::vector<int>& stretches : {std::vector<int>{2}, std::vector<int>{-1}, std::vector<int>{1, 0}}) {
    EXPECT_THROW(Chain(rod, basis, stretches, 8), Error) << stretches.front();
  }
  Bumps model;
  EXPECT_NO_THROW(Chain(rod, model, {}, 8));
  model.offset = 1e-9;
  EXPECT_THROW(Chain(rod, model, {}, 8), Error) << "does not vanish at sigma = 0";
  model.offset = std::nan("");
  EXPECT_THROW(Chain(rod, model, {}, 8), Error) << "not finite";
  model.offset = 0.0;
  for (const std::vector<double>& parts : {std::vector<double>{}, std::vector<double>{0.0},
                                           std::vector<double>{1.0, 0.0}, std::vector<double>{2.0, -1.0}}) {
    model.parts = parts;
    EXPECT_THROW(Chain(rod, model, {}, 8), Error) << parts.size() << " parts";
  }
}

TEST(Chain, ProjectsACurvatureOfItsBasisToItsCoordinates) {
  const LegendreBasis basis(5);
  const Chain chain(stepped_rod(), basis, {}, 12);
  const Eigen::VectorXd q = (Eigen::VectorXd(5) << 0.4, -0.3, 0.2, 0.7, -0.1).finished();
  const Eigen::VectorXd& at = chain.table().sigma;
  Eigen::MatrixXd value(12, 5), first(12, 5), second(12, 5);
  basis.evaluate({at.data(), 12}, value, first, second);
  const Eigen::VectorXd scaled = first * q;
  EXPECT_LT((chain.project({scaled.data(), 12}) - q).cwiseAbs().maxCoeff(), 1e-13);
  // Of any other one, the projection is best: what is left is orthogonal to all slopes of the basis.
  const Eigen::VectorXd other = at.array().exp().matrix();
  const Eigen::VectorXd left = other - first * chain.project({other.data(), 12});
  const Eigen::VectorXd along = first.transpose() * chain.table().weight.cwiseProduct(left);
  EXPECT_LT(along.cwiseAbs().maxCoeff(), 1e-13);
}

// The clearance bound stands on the bound of the slopes, which are only sampled.
TEST(Chain, BoundsSlopesBetweenItsSamplesToo) {
  Peak model;
  for (const double shift : {0.0, 0.1, 0.25, 0.5, 0.75}) {
    // Two functions or one: 129 samples for one.
    model.middle = 0.5 + shift / 128.0;
    const Chain chain(Rod{}, model, {}, 40);
    EXPECT_GE(chain.table().slope_bound[0], 1.0) << shift;
    EXPECT_LE(chain.table().slope_bound[0], 2.0) << shift;
  }
}

TEST(Chain, TablesAreMadeOnceForEachModelAndRule) {
  const LegendreBasis a(3), b(3);
  TableStore store;
  EXPECT_EQ(store.of(a, 8), store.of(a, 8));
  EXPECT_NE(store.of(a, 8), store.of(a, 9));
  EXPECT_NE(store.of(a, 8), store.of(b, 8));
  EXPECT_EQ(store.of(a, 9)->basis.nodes, 9);
}

TEST(SuggestedNodes, GrowWithFunctionsAndWithTheAngleEitherWay) {
  // model.md section 2: 1.5 n + 1.2 |phi| + 8.
  EXPECT_EQ(suggested_nodes(6, 0.0), 17);
  EXPECT_EQ(suggested_nodes(6, 10.0), 29);
  EXPECT_EQ(suggested_nodes(6, -10.0), 29);
  EXPECT_EQ(suggested_nodes(1, 0.1), 10);
}

// The integral of (cos phi, sin phi) on a fine rule of its own.
TEST(Backbone, PointsAreIntegralsOfTheirTangents) {
  const Rod rod = stepped_rod();
  Bumps model;
  model.parts = {1.0, 2.0};
  const Chain chain(rod, model, {}, 24);
  Backbone backbone(chain, {0.3, -0.1}, 0.5);
  Eigen::VectorXd q(chain.coordinate_count());
  for (int i = 0; i < q.size(); ++i) q[i] = 0.6 * std::cos(1.0 + i);
  backbone.move(q, {});
  const auto angle_on = [&](int j, double sigma) {
    const double after = std::max(0.0, sigma - 0.4);
    return q[2 * j] * std::sin(3.0 * sigma) + q[2 * j + 1] * after * after;
  };
  const Quadrature fine(60);
  Vec2 p{0.3, -0.1};
  double begin = 0.5;
  for (int j = 0; j < chain.piece_count(); ++j) {
    const double h = chain.length(j, {});
    for (const double sigma : {0.2, 0.4, 0.8, 1.0}) {
      SCOPED_TRACE("piece " + std::to_string(j) + ", sigma " + std::to_string(sigma));
      Vec2 at = p;
      for (const auto& [from, to] : {std::pair{0.0, std::min(sigma, 0.4)}, std::pair{std::min(sigma, 0.4), sigma}}) {
        for (int g = 0; g < fine.size(); ++g) {
          const double phi = begin + angle_on(j, from + (to - from) * fine.nodes()[g]);
          at += (h * (to - from) * fine.weights()[g]) * Vec2{std::cos(phi), std::sin(phi)};
        }
      }
      const Backbone::Point found = backbone.at(j, sigma);
      EXPECT_NEAR(norm(found.position - at), 0.0, 1e-14);
      EXPECT_NEAR(found.angle, begin + angle_on(j, sigma), 1e-14);
      const double slope = 3.0 * q[2 * j] * std::cos(3.0 * sigma) + 2.0 * q[2 * j + 1] * std::max(0.0, sigma - 0.4);
      EXPECT_NEAR(found.curvature, slope / h, 1e-12);
      const Backbone::Point same = backbone.at(chain.start(j, {}) + sigma * h);
      EXPECT_NEAR(norm(same.position - at), 0.0, 1e-14);
      if (sigma == 1.0) {
        EXPECT_NEAR(norm(backbone.knot_point(j + 1) - at), 0.0, 1e-14);
        EXPECT_NEAR(backbone.knot_angle(j + 1), found.angle, 1e-14);
        p = at;
        begin = found.angle;
      }
    }
  }
}

// What the clearance bound reads between nodes, against the basis itself.
TEST(Curve, IsTheBackboneBetweenItsNodes) {
  const LegendreBasis basis(6, 2);
  const Chain chain(stepped_rod(), basis, {}, 24);
  Backbone backbone(chain, {0.3, -0.1}, 0.5);
  Eigen::VectorXd q(chain.coordinate_count());
  for (int i = 0; i < q.size(); ++i) q[i] = 0.5 * std::cos(1.0 + 2.0 * i) / (1.0 + i % 6);
  backbone.move(q, {});
  Curve curve(chain.curve_tables());
  curve.follow(backbone);
  for (int j = 0; j < chain.piece_count(); ++j) {
    for (const double sigma : {0.0, 0.013, 0.37, 0.5, 0.94, 1.0}) {
      EXPECT_NEAR(norm(curve.position(j, sigma) - backbone.at(j, sigma).position), 0.0, 1e-13)
          << "piece " << j << ", sigma " << sigma;
    }
  }
}

}  // namespace
}  // namespace tendril
