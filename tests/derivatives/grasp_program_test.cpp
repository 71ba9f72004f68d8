// Every derivative of the program of two fingers against central differences, with fingers of different sizes,
// stiffnesses and loads, and with rows that keep them apart; and the clearance between two fingers against circles
// whose distance is known.

#include "program/grasp_program.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "certificate/finger_clearance.hpp"
#include "differences.hpp"
#include "support/sample_programs.hpp"

namespace tendril {
namespace {

struct GraspCase {
  const char* name;
  bool upper_at_tip, lower_at_tip, free_palm;
  bool rubs = false;
  bool loaded = false;
  bool moves = false;
};

std::ostream& operator<<(std::ostream& os, const GraspCase& c) { return os << c.name; }

class GraspDerivatives : public testing::TestWithParam<GraspCase> {
 protected:
  GraspDerivatives() : sample({GetParam().upper_at_tip, GetParam().lower_at_tip, GetParam().free_palm}) {
    if (GetParam().rubs) {
      for (PoseProgramSpec& finger : sample.spec.fingers) finger.friction.assign(finger.obstacles.size(), 0.6);
    }
    if (GetParam().loaded) sample.spec.load = {0.4, -0.7};
    if (GetParam().moves) {
      using Kind = Rod::Move::Kind;
      for (Rod& rod : sample.rods) {
        rod.moves = {{Kind::shift, {0.0, 1.0}, -0.05, 0.08}, {Kind::turn, {}, -0.3, 0.4, rod.base_angle}};
      }
    }
    program = std::make_unique<GraspProgram>(sample.spec);
  }

  Eigen::VectorXd random_point(std::mt19937& random) const {
    std::uniform_real_distribution<double> d(-0.4, 0.4);
    Eigen::VectorXd x(program->variable_count());
    int order = 0;
    for (int i = 0; i < x.size(); ++i) {
      // Shapes that the basis resolves: coefficients fall with their order.
      const bool coordinate = program->variable_name(i).find("coordinate") != std::string::npos;
      x[i] = coordinate ? d(random) / std::pow(1.0 + order++ % 4, 1.5) : d(random);
      const double low = program->lower()[i];
      const double high = program->upper()[i];
      if (std::isfinite(low) && std::isfinite(high) && !coordinate) x[i] = low + (high - low) * (0.5 + 0.5 * x[i]);
      // The curvature at a fixed arc length jumps when a knot passes: no derivative there.
      const bool knot = program->variable_name(i).find("arc length") != std::string::npos;
      for (const double s : sample.everything.reads().samples) {
        if (knot && std::abs(x[i] - s) < 5.0 * step) x[i] += 10.0 * step;
      }
    }
    return x;
  }

  support::SampleGrasp sample;
  std::unique_ptr<GraspProgram> program;
};

TEST_P(GraspDerivatives, FirstDerivativesAgreeWithDifferences) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 4; ++trial) expect_first_derivatives(*program, random_point(random));
}

TEST_P(GraspDerivatives, HessianOfTheLagrangianAgreesWithDifferencesOfItsGradient) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 4; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    expect_hessian(*program, x, random);
  }
}

// The rows in words, from the positions of both fingers in one frame.
TEST_P(GraspDerivatives, RowsOfTheWholeAreWhatTheySay) {
  std::mt19937 random(13);
  const Eigen::VectorXd x = random_point(random);
  const Eigen::VectorXd c = program->constraints(x);
  const double units[2] = {1.2, 0.96};
  const double forces[2] = {0.7, 1.9};
  const auto point = [&](int which, int piece, double sigma) {
    const Vec2 p = units[which] * program->finger(which).backbone().at(piece, sigma).position;
    return which == 0 ? p : Vec2{p.x, -p.y};
  };
  const auto radius = [&](std::size_t which, int piece, double sigma) {
    const Backbone& backbone = program->finger(static_cast<int>(which)).backbone();
    const double s = backbone.start(piece) + sigma * backbone.length(piece);
    return units[which] * sample.rods[which].radius_at(s).value;
  };
  for (std::size_t k = 0; k < 2; ++k) {
    const FingerSeparation& s = program->spec().separations[k];
    const Vec2 apart = point(0, s.upper_piece, s.upper_sigma) - point(1, s.lower_piece, s.lower_sigma);
    // The sides of the bodies, not the backbones.
    const double bodies = radius(0, s.upper_piece, s.upper_sigma) + radius(1, s.lower_piece, s.lower_sigma);
    EXPECT_GT(bodies, 0.01);
    EXPECT_NEAR(c[program->first_separation() + static_cast<int>(k)], dot(s.normal, apart) - bodies, 1e-12);
  }
  double axial = 0.0;
  // On the object, from where its surface is touched.
  Vec2 force{};
  double moment = 0.0;
  for (int which = 0; which < 2; ++which) {
    const PoseProgram::ContactState& contact = program->finger(which).contacts().front();
    if (!GetParam().loaded) {
      EXPECT_NEAR(contact.force * forces[which], program->force(x), 1e-12);
    }
    axial += contact.push.x;
    const double side = which == 0 ? 1.0 : -1.0;
    const Vec2 n{contact.surface.normal.x, side * contact.surface.normal.y};
    const Vec2 along = turned(contact.surface.normal);
    const Vec2 pushed = -contact.force * forces[which] * (n + contact.lean * Vec2{along.x, side * along.y});
    force += pushed;
    moment += cross(n, pushed);
    // Both bases stand on the palm.
    const Vec2 base = point(which, 0, 0.0);
    EXPECT_NEAR(base.x, -program->palm_distance(x), 1e-12);
    const Eigen::VectorXd own = program->finger_point(which, x);
    const int first = program->finger(which).layout().first_move;
    const double moved = GetParam().moves ? (which == 0 ? own[first] : -own[first]) : 0.0;
    EXPECT_NEAR(base.y, units[which] * ((which == 0 ? 0.2 : -0.16) + moved), 1e-12);
    if (GetParam().moves) {
      EXPECT_NEAR(program->finger(which).backbone().knot_angle(0), own[first + 1], 1e-12);
    }
  }
  EXPECT_NEAR(net_force(*program).x, force.x, 1e-12);
  EXPECT_NEAR(net_force(*program).y, force.y, 1e-12);
  EXPECT_NEAR(net_moment(*program), moment, 1e-12);
  const int row = program->balance_row();
  if (GetParam().loaded) {
    EXPECT_NEAR(c[row], -(force.x + 0.4), 1e-12);
    EXPECT_NEAR(c[row + 1], -(force.y - 0.7), 1e-12);
    if (GetParam().rubs) {
      EXPECT_NEAR(c[row + 2], -moment, 1e-12);
    }
    EXPECT_EQ(program->row_count(), row + (GetParam().rubs ? 3 : 2));
    return;
  }
  EXPECT_NEAR(c[row], axial, 1e-12);
  if (GetParam().rubs) return;
  // The smaller of both limits: 5 * 0.7 and 1 * 1.9.
  EXPECT_NEAR(program->upper()[program->variable_count() - (GetParam().free_palm ? 2 : 1)], 1.9, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, GraspDerivatives,
                         testing::Values(GraspCase{"inside", false, false, true}, GraspCase{"tips", true, true, true},
                                         GraspCase{"upper_tip", true, false, false},
                                         GraspCase{"lower_tip", false, true, false},
                                         GraspCase{"rubs", false, false, true, true},
                                         GraspCase{"loaded", false, true, true, false, true},
                                         GraspCase{"rubs_loaded", true, false, false, true, true},
                                         GraspCase{"rubs_loaded_inside", false, false, true, true, true},
                                         GraspCase{"moves", false, true, true, false, false, true},
                                         GraspCase{"moves_rubs_loaded", true, false, true, true, true, true}),
                         [](const auto& each) { return std::string(each.param.name); });

/// An arc of a circle as a finger of unit length.
struct Arc {
  Arc(Vec2 base, double angle, double curvature, double radius = 0.0)
      : rod(thick(radius)), backbone(chain, base, angle) {
    backbone.move(Eigen::VectorXd::Constant(1, curvature), {});
    curve.follow(backbone);
  }
  static Rod thick(double radius) {
    Rod rod;
    rod.segments[0].radius = radius;
    return rod;
  }
  LegendreBasis basis{1, 1};
  Rod rod;
  Chain chain{rod, basis, {}, 24};
  Backbone backbone;
  Curve curve{chain.curve_tables()};
};

TEST(FingerClearance, OfArcsIsThatOfTheirCircles) {
  // Straight up to the tip at (0.6, -depth) from above, against a straight finger along the axis.
  const Arc along({0.0, 0.0}, 0.0, 0.0);
  for (const double depth : {0.2, 1e-3, 1e-8}) {
    SCOPED_TRACE(depth);
    const Arc down({0.6, 1.0 - depth}, -0.5 * std::numbers::pi, 0.0);
    const FingerClearance found = finger_clearance({&down.curve, 1.0, false}, {&along.curve, 1.0, false});
    EXPECT_NEAR(found.depth, depth, 1e-9 + 1e-6 * depth);
    ASSERT_EQ(found.crossings.size(), 1U);
    EXPECT_EQ(found.crossings[0].upper_sigma, 1.0);
    EXPECT_EQ(found.crossings[0].lower_sigma, 1.0);
    EXPECT_NEAR(found.crossings[0].normal.x, std::sqrt(0.5), 1e-9);
  }
  // Apart, and touching to less than the sharpness of the bound.
  for (const double gap : {0.1, 1e-6, 1e-12}) {
    const Arc down({0.6, 1.0 + gap}, -0.5 * std::numbers::pi, 0.0);
    EXPECT_EQ(finger_clearance({&down.curve, 1.0, false}, {&along.curve, 1.0, false}).depth, 0.0);
  }
  // A bulge that goes through and comes back: an arc of radius 0.5 whose lowest point is 0.01 below the other finger.
  const double radius = 0.5;
  const Arc bulge({0.5 - radius * std::sin(1.0), radius - 0.01 - radius * std::cos(1.0)}, -1.0, 1.0 / radius);
  const FingerClearance through = finger_clearance({&bulge.curve, 1.0, false}, {&along.curve, 1.0, false});
  EXPECT_NEAR(through.depth, 0.01, 1e-6);
  // The same in units twice as large, and mirrored.
  const FingerClearance larger = finger_clearance({&along.curve, 2.0, true}, {&bulge.curve, 2.0, true});
  EXPECT_NEAR(larger.depth, 0.02, 2e-6);
}

// Backbones on their own sides whose bodies lie in each other: they are kept apart along what lies between.
TEST(FingerClearance, OfBodiesIsThatOfTheirSides) {
  const Arc low({0.0, 0.0}, 0.0, 0.0, 0.03);
  const Arc high({0.0, 0.07}, 0.0, 0.0, 0.05);
  const FingerClearance found = finger_clearance({&high.curve, 1.0, false}, {&low.curve, 1.0, false});
  EXPECT_NEAR(found.depth, 0.01, 1e-9);
  ASSERT_EQ(found.crossings.size(), 1U);
  EXPECT_NEAR(found.crossings[0].normal.x, 0.0, 1e-12);
  EXPECT_NEAR(found.crossings[0].normal.y, 1.0, 1e-12);
  const Arc higher({0.0, 0.0801}, 0.0, 0.0, 0.05);
  const FingerClearance apart = finger_clearance({&higher.curve, 1.0, false}, {&low.curve, 1.0, false});
  EXPECT_EQ(apart.depth, 0.0);
  EXPECT_TRUE(apart.crossings.empty());
}

}  // namespace
}  // namespace tendril
