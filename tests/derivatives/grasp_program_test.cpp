// Every derivative of the program of two fingers against central differences, with fingers of different sizes,
// stiffnesses and loads, and with rows that keep them apart; and the clearance between two fingers against circles
// whose distance is known.

#include "tendril/grasp_program.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "differences.hpp"
#include "tendril/circle.hpp"
#include "tendril/finger_clearance.hpp"
#include "tendril/wall.hpp"

namespace tendril {
namespace {

/// Reads everything that a grasp has of a finger, nonlinearly, in all three forms.
class Everything : public ObjectiveBase<Everything> {
 public:
  Reads reads() const override {
    Reads r;
    r.tip_position = r.tip_angle = r.bending_energy = r.moments = true;
    r.contact_point = r.contact_gap = r.contact_normal = r.contact_force = r.contact_arc_length = true;
    r.palm_distance = true;
    r.samples = {0.23};
    return r;
  }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    const FingerQuantities<T>& f = x.fingers[0];
    out.residual(f.tip.x * f.tip.y - 0.3);
    out.residual(sin(f.tip.angle) + f.bending_energy * 0.2);
    out.linear(0.7 * f.tip.y);
    out.smooth(exp(x.palm_distance) * f.tip.y);
    for (const T& u : f.moments) out.smooth(exp(0.3 * u) * f.tip.x);
    for (const BackboneQuantities<T>& b : f.samples) out.smooth(b.y * b.curvature + b.x * b.angle);
    for (const ContactQuantities<T>& c : f.contacts) {
      out.residual((c.x - c.reference_x) * c.force + c.normal_x * c.normal_y);
      out.smooth(c.gap * c.gap * c.gap + c.arc_length * c.force * c.normal_y);
    }
  }
};

struct Case {
  const char* name;
  bool upper_at_tip, lower_at_tip, free_palm;
};

std::ostream& operator<<(std::ostream& os, const Case& c) { return os << c.name; }

class GraspDerivatives : public testing::TestWithParam<Case> {
 protected:
  GraspDerivatives() {
    const Case& c = GetParam();
    rods[0].segments = {{0.0, 0.4, 1.0, 2.0, 0.3}, {0.4, 1.0, 0.6, 1.1, -0.2}};
    rods[0].actuators = {{0.0, 1.0, -3.0, 3.0}, {0.4, 1.0, -2.0, 2.0}};
    rods[0].gravity = {0.28, -0.96};
    rods[0].base = {0.0, 0.2};
    rods[0].base_angle = 0.1;
    rods[1].segments = {{0.0, 1.0, 1.0, 0.7, -0.4}};
    rods[1].actuators = {{0.0, 0.7, -3.0, 3.0}};
    rods[1].gravity = {0.28, 0.96};
    rods[1].payload = 0.3;
    rods[1].base = {0.0, 0.16};
    const TermUnits units[2] = {{1.2, 0.7}, {0.96, 1.9}};
    GraspProgramSpec spec;
    for (std::size_t which = 0; which < 2; ++which) {
      objects[which] = std::make_unique<Circle>(Vec2{}, 0.25 / units[which].length);
      PoseProgramSpec& own = spec.fingers[which];
      own.rod = &rods[which];
      own.model = which == 0 ? static_cast<const CoordinateModel*>(&fine) : &coarse;
      own.obstacles = {objects[which].get(), &palm};
      own.carried = 1;
      own.terms = {{&everything, 1.3, "everything"}};
      const bool tip = which == 0 ? c.upper_at_tip : c.lower_at_tip;
      own.contacts = {{0, tip, which == 0 && !tip ? 1 : 0}};
      own.nodes = 30;
      own.min_force = 0.01;
      own.max_force = which == 0 ? 5.0 : 1.0;
      own.palm = PalmSetup{};
      own.term_units = units[which];
      own.checks = {{0, 0.6, 0}, {1, 0.7, 1}};
      if (which == 1 && tip) own.checks = {{0, 0.6, 0}, {0, 0.7, 1}};
    }
    spec.palm_minimum = 0.3;
    spec.palm_maximum = c.free_palm ? 0.9 : 0.3;
    spec.separations = {{0, 0.9, 0, 0.8, {0.0, 1.0}}, {1, 1.0, 0, 1.0, {-0.6, 0.8}}};
    program = std::make_unique<GraspProgram>(spec);
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
    }
    return x;
  }

  LegendreBasis fine{5, 1}, coarse{3, 2};
  Everything everything;
  Wall palm{Vec2{}, Vec2{1.0, 0.0}};
  std::array<Rod, 2> rods;
  std::array<std::unique_ptr<Circle>, 2> objects;
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
  for (std::size_t k = 0; k < 2; ++k) {
    const FingerSeparation& s = program->spec().separations[k];
    const Vec2 apart = point(0, s.upper_piece, s.upper_sigma) - point(1, s.lower_piece, s.lower_sigma);
    EXPECT_NEAR(c[program->first_separation() + static_cast<int>(k)], dot(s.normal, apart), 1e-12);
  }
  double axial = 0.0;
  for (int which = 0; which < 2; ++which) {
    const PoseProgram::ContactState& contact = program->finger(which).contacts().front();
    EXPECT_NEAR(contact.force * forces[which], program->force(x), 1e-12);
    axial += program->force(x) * contact.surface.normal.x;
    // Both bases stand on the palm.
    const Vec2 base = point(which, 0, 0.0);
    EXPECT_NEAR(base.x, -program->palm_distance(x), 1e-12);
    EXPECT_NEAR(base.y, units[which] * (which == 0 ? 0.2 : -0.16), 1e-12);
  }
  EXPECT_NEAR(c[program->balance_row()], axial, 1e-12);
  EXPECT_NEAR(net_force(*program).x, -axial, 1e-12);
  // The smaller of both limits: 5 * 0.7 and 1 * 1.9.
  EXPECT_NEAR(program->upper()[program->variable_count() - (GetParam().free_palm ? 2 : 1)], 1.9, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, GraspDerivatives,
                         testing::Values(Case{"inside", false, false, true}, Case{"tips", true, true, true},
                                         Case{"upper_tip", true, false, false}, Case{"lower_tip", false, true, false}),
                         [](const auto& each) { return std::string(each.param.name); });

/// An arc of a circle as a finger of unit length.
struct Arc {
  Arc(Vec2 base, double angle, double curvature) : backbone(chain, base, angle) {
    backbone.move(Eigen::VectorXd::Constant(1, curvature), {});
    curve.follow(backbone);
  }
  LegendreBasis basis{1, 1};
  Rod rod{};
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

}  // namespace
}  // namespace tendril
