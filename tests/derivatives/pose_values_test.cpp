// What a pose program says, from what it means: equilibrium rows from the energy, d_ss from distances along the rod,
// limits and names from its parts. Derivatives alone would agree with wrong values.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "differences.hpp"
#include "program/pose_program.hpp"
#include "support/sample_programs.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

using support::SamplePose;

Eigen::VectorXd sample_point(const PoseProgram& program) {
  const PoseProgram::Layout& at = program.layout();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(program.variable_count());
  const int n = program.chain().functions();
  for (int i = 0; i < at.coordinates; ++i) x[i] = 0.4 * std::cos(1.0 + 1.7 * i) / std::pow(1.0 + i % n, 1.5);
  for (int i = 0; i < at.moments; ++i) x[at.first_moment + i] = 0.7 - 1.1 * i;
  for (int k = 0; k < at.arc_lengths; ++k) {
    const double low = program.lower()[at.first_arc_length + k];
    const double high = program.upper()[at.first_arc_length + k];
    x[at.first_arc_length + k] = low + (high - low) * (k + 1.0) / (at.arc_lengths + 1.0);
  }
  for (int k = 0; k < at.forces; ++k) x[at.first_force + k] = 0.8 + 0.5 * k;
  if (at.palm >= 0) x[at.palm] = 0.1;
  return x;
}

/// Mass beyond arc length s, the payload included.
double mass_beyond(const Rod& rod, double s) {
  double mass = rod.payload;
  for (const Rod::Segment& segment : rod.segments) {
    mass += segment.whole_weight() - segment.weight_up_to(std::clamp(s, segment.from, segment.to));
  }
  for (const Rod::Load& load : rod.loads) {
    if (load.from > s) mass += load.weight;
  }
  return mass;
}

struct DeadForce {
  double arc_length = 0.0;
  Vec2 force{};
};

/// Bending, gravity, actuation and dead forces of model.md section 3, on a rule of its own that is cut where forces
/// act. What every shape has in common is left out.
double potential(const SamplePose& sample, PoseProgram& program, const Eigen::VectorXd& x,
                 const std::vector<DeadForce>& forces) {
  program.constraints(x);
  const Backbone& backbone = program.backbone();
  const Rod& rod = sample.rod;
  const Quadrature rule(30);
  const int n = program.chain().functions();
  Eigen::MatrixXd value(rule.size(), n), first(rule.size(), n), second(rule.size(), n);
  double energy = 0.0;
  for (int j = 0; j < program.chain().piece_count(); ++j) {
    const double begin = backbone.start(j);
    const double length = backbone.length(j);
    const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
    std::vector<double> cuts{begin, begin + length};
    for (const DeadForce& f : forces) {
      if (f.arc_length > begin && f.arc_length < begin + length) cuts.push_back(f.arc_length);
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const double width = cuts[c + 1] - cuts[c];
      const Eigen::VectorXd sigma = ((cuts[c] - begin + width * rule.nodes().array()) / length).matrix();
      sample.model->evaluate({sigma.data(), static_cast<std::size_t>(rule.size())}, value, first, second);
      const Eigen::VectorXd angle = (value * q).array() + backbone.knot_angle(j);
      const Eigen::VectorXd curvature = first * q / length;
      for (int g = 0; g < rule.size(); ++g) {
        const double s = begin + length * sigma[g];
        const Rod::Segment& segment = rod.segment_at(s);
        Vec2 beyond = rod.tip_force + mass_beyond(rod, s) * rod.gravity;
        for (const Rod::Load& load : rod.loads) {
          const double share =
              load.at_point() ? (load.from > s ? 1.0 : 0.0) : load.to - std::clamp(s, load.from, load.to);
          beyond += share * load.force;
        }
        for (const DeadForce& f : forces) {
          if (f.arc_length > s) beyond += f.force;
        }
        const double bent = curvature[g] - segment.rest_curvature_at(s).value;
        double moment = 0.0;
        for (int a = 0; a < static_cast<int>(rod.actuators.size()); ++a) {
          const int variable = program.moment_variable(a);
          if (variable >= 0) moment += x[variable] * rod.actuators[static_cast<std::size_t>(a)].at(s);
        }
        energy += width * rule.weights()[g] *
                  (0.5 * segment.stiffness_at(s).value * bent * bent - moment * curvature[g] -
                   dot(beyond, {std::cos(angle[g]), std::sin(angle[g])}));
      }
    }
  }
  return energy;
}

struct ValueCase {
  const char* name;
  bool split, tip;
  int inside;
  bool palm;
  const char* rod = "uniform";
  bool profiles = false;
};

const ValueCase cases[] = {{"free", true, false, 0, false},
                           {"inside", true, false, 1, false},
                           {"inside in a piece", false, false, 1, false},
                           {"two and tip", true, true, 2, false},
                           {"two and tip in pieces", false, true, 2, false},
                           {"on a palm", true, true, 1, true},
                           {"tapered", true, true, 2, false, "tapered"},
                           {"tapered in pieces", false, true, 2, false, "tapered"},
                           {"loaded", true, false, 1, true, "loaded"},
                           {"loaded in pieces", false, true, 2, false, "loaded"},
                           {"thick", false, true, 2, false, "thick"},
                           {"thick, tapered and loaded", true, true, 2, true, "varied"},
                           {"profiles", true, true, 2, false, "uniform", true},
                           {"profiles in pieces, tapered and loaded", false, true, 2, true, "varied", true}};

// h_e = -dPi/dq + sum of f J^T n, by differences of the energy itself.
TEST(PoseValues, EquilibriumRowsAreTheSlopesOfTheEnergy) {
  for (const ValueCase& c : cases) {
    SCOPED_TRACE(c.name);
    SamplePose sample(
        {std::make_shared<LegendreBasis>(5, 2), c.split, c.tip, c.inside, "circles", c.palm, c.rod, c.profiles});
    PoseProgram program(sample.spec);
    const Eigen::VectorXd x = sample_point(program);
    const PoseProgram::Layout& at = program.layout();
    const Eigen::VectorXd rows = program.constraints(x).head(at.coordinates);
    EXPECT_NEAR(program.potential(x), potential(sample, program, x, {}), 1e-12);
    std::vector<DeadForce> forces;
    for (const PoseProgram::ContactState& contact : program.contacts()) {
      forces.push_back({contact.arc_length, contact.force * contact.surface.normal});
    }
    const Eigen::MatrixXd slopes = differences(x.head(at.coordinates), [&](const Eigen::VectorXd& q) {
      Eigen::VectorXd y = x;
      y.head(at.coordinates) = q;
      return Eigen::VectorXd::Constant(1, potential(sample, program, y, forces));
    });
    for (int i = 0; i < at.coordinates; ++i) {
      // Sixth-order differences of an energy of size 1 leave 1e-12.
      EXPECT_NEAR(rows[i], -slopes(0, i), 1e-10) << program.row_name(i);
    }
  }
}

TEST(PoseValues, RowsOfContactsAreGapsAndAngles) {
  for (const ValueCase& c : cases) {
    SCOPED_TRACE(c.name);
    SamplePose sample({std::make_shared<LegendreBasis>(5, 2), c.split, c.tip, c.inside, "hulls", c.palm, c.rod});
    PoseProgram program(sample.spec);
    const Eigen::VectorXd x = sample_point(program);
    const Eigen::VectorXd rows = program.constraints(x);
    const PoseProgram::Layout& at = program.layout();
    EXPECT_NEAR(program.palm_distance(x), c.palm ? 0.1 : 0.0, 1e-15);
    for (int k = 0; k < at.forces; ++k) {
      const PoseProgram::ContactState& contact = program.contacts()[static_cast<std::size_t>(k)];
      const bool at_tip = program.spec().contacts[static_cast<std::size_t>(k)].at_tip;
      const double s = at_tip ? 1.0 : x[program.arc_length_variable(k)];
      EXPECT_EQ(contact.arc_length, s);
      EXPECT_EQ(contact.force, x[program.force_variable(k)]);
      const Backbone::Point p = program.backbone().at(s);
      EXPECT_NEAR(norm(contact.point - p.position), 0.0, 1e-13);
      const int obstacle = program.spec().contacts[static_cast<std::size_t>(k)].obstacle;
      const SurfacePoint surface = program.spec().obstacles[static_cast<std::size_t>(obstacle)]->at(p.position);
      const Rod::Jet body = sample.rod.radius_at(s);
      EXPECT_NEAR(rows[at.first_gap + k], surface.distance - body.value, 1e-13);
      EXPECT_NEAR(rows[at.first_closest + k], dot(surface.normal, {std::cos(p.angle), std::sin(p.angle)}) - body.slope,
                  1e-13);
    }
    for (int i = 0; i < at.checks; ++i) {
      const CheckPoint& check = sample.spec.checks[static_cast<std::size_t>(i)];
      Vec2 p = program.backbone().at(check.piece, check.sigma).position;
      // The last obstacle moves with the base, so it sees the rod as if the base had not moved.
      if (c.palm && check.obstacle == 2) p = p - program.base_shift();
      const Obstacle& obstacle = *sample.spec.obstacles[static_cast<std::size_t>(check.obstacle)];
      // What stands on the palm is kept off the backbone alone.
      const double s = program.backbone().start(check.piece) + check.sigma * program.backbone().length(check.piece);
      const double radius = c.palm && check.obstacle == 2 ? 0.0 : sample.rod.radius_at(s).value;
      EXPECT_NEAR(rows[at.first_check + i], obstacle.at(p).distance - radius, 1e-13) << "check point " << i;
    }
    const Vec2 shift = c.palm ? -0.1 * Vec2{0.8, -0.6} : Vec2{};
    EXPECT_NEAR(norm(program.base_shift() - shift), 0.0, 1e-15);
    EXPECT_NEAR(norm(program.backbone().knot_point(0) - sample.rod.base - shift), 0.0, 1e-15);
  }
}

// d_ss = d^2/ds^2 of the distance along the rod, on either side of the contact; the larger one counts.
TEST(PoseValues, ConvexityOfAContactIsTheBendingOfItsGap) {
  for (const auto& [shapes, rod] : {std::pair("circles", "uniform"), {"walls", "uniform"}, {"circles", "thick"}}) {
    for (const bool split : {true, false}) {
      SCOPED_TRACE(std::string(shapes) + (split ? ", split, " : ", whole, ") + rod);
      SamplePose sample({std::make_shared<LegendreBasis>(5), split, true, 2, shapes, false, rod});
      PoseProgram program(sample.spec);
      Eigen::VectorXd x = sample_point(program);
      // Bent the other way, the other side of each contact has more.
      for (int way = 0; way < 2; ++way, x.head(program.layout().coordinates) *= -1.0)
        for (int k = 0; k < 2; ++k) {
          program.constraints(x);
          const PoseProgram::ContactState& contact = program.contacts()[static_cast<std::size_t>(k)];
          const Obstacle& obstacle = *sample.spec.obstacles[static_cast<std::size_t>(k % 2)];
          const auto gap = [&](double s) {
            return obstacle.at(program.backbone().at(s).position).distance - sample.rod.radius_at(s).value;
          };
          const auto bending = [&](double side) {
            const double h = 1e-3 * side;
            const double s = contact.arc_length;
            // One-sided differences of fourth order.
            return (35.0 * gap(s) - 104.0 * gap(s + h) + 114.0 * gap(s + 2 * h) - 56.0 * gap(s + 3 * h) +
                    11.0 * gap(s + 4 * h)) /
                   (12.0 * h * h);
          };
          // The differences err by h^3 times fifth derivatives: 2e-5 here, an eighth of that with half the step.
          EXPECT_NEAR(program.contact_convexity(k), std::max(bending(1.0), bending(-1.0)), 1e-4) << "contact " << k;
        }
      EXPECT_EQ(program.contact_convexity(2), infinity) << "at the tip";
    }
  }
}

/// Reads the bending energy and nothing else.
struct BendingAlone : public ObjectiveBase<BendingAlone> {
  Reads reads() const override {
    Reads r;
    r.bending_energy = true;
    return r;
  }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.smooth(x.bending_energy);
  }
};

TEST(PoseValues, BendingEnergyCountsFromTheRestShape) {
  SamplePose sample({std::make_shared<LegendreBasis>(5, 2), true, false, 1});
  const BendingAlone term;
  sample.spec.terms = {{&term, 1.0, "bending"}};
  PoseProgram program(sample.spec);
  const Eigen::VectorXd x = sample_point(program);
  const double found = program.cost(x);
  const Quadrature rule(30);
  double expected = 0.0;
  for (int j = 0; j < program.chain().piece_count(); ++j) {
    const Chain::Piece& p = program.chain().piece(j);
    for (int g = 0; g < rule.size(); ++g) {
      const double bent = program.backbone().at(j, rule.nodes()[g]).curvature - p.rest_curvature;
      expected += program.backbone().length(j) * rule.weights()[g] * 0.5 * p.stiffness * bent * bent;
    }
  }
  EXPECT_NEAR(found, expected, 1e-12);
}

TEST(PoseValues, LimitsAreThoseOfActuatorsForcesAndStretches) {
  SamplePose sample({std::make_shared<LegendreBasis>(5), true, true, 2, "circles", true});
  sample.spec.min_force = 0.25;
  sample.spec.max_force = 4.0;
  PoseProgram program(sample.spec);
  const PoseProgram::Layout& at = program.layout();
  const auto expect_bounds = [&](int variable, double low, double high) {
    EXPECT_EQ(program.lower()[variable], low) << program.variable_name(variable);
    EXPECT_EQ(program.upper()[variable], high) << program.variable_name(variable);
  };
  for (int i = 0; i < at.coordinates; ++i) expect_bounds(i, -infinity, infinity);
  ASSERT_EQ(at.moments, 2);
  EXPECT_EQ(program.moment_variable(2), -1) << "an actuator that can do nothing";
  expect_bounds(program.moment_variable(0), -3.0, 3.0);
  expect_bounds(program.moment_variable(1), -2.0, 2.0);
  for (int k = 0; k < 2; ++k)
    expect_bounds(program.arc_length_variable(k), 0.45 + knot_clearance, 1.0 - knot_clearance);
  EXPECT_EQ(program.arc_length_variable(2), -1);
  for (int k = 0; k < 3; ++k) expect_bounds(program.force_variable(k), 0.25, 4.0);
  expect_bounds(at.palm, -0.3, 0.4);
  ASSERT_EQ(at.orders, 1) << "both contacts in one stretch";
  EXPECT_EQ(program.row_lower()[at.first_order], knot_clearance);
  EXPECT_EQ(program.row_upper()[at.first_order], infinity);
  for (int i = 0; i < at.checks; ++i) {
    EXPECT_EQ(program.row_lower()[at.first_check + i], 0.0);
    EXPECT_EQ(program.row_upper()[at.first_check + i], infinity);
  }
  ASSERT_EQ(at.balances, 1);
  EXPECT_EQ(program.row_lower()[at.first_balance], 0.0);
  EXPECT_EQ(program.row_upper()[at.first_balance], 0.0);
}

TEST(PoseValues, AContactInAWholePieceStaysOnIt) {
  SamplePose sample({std::make_shared<LegendreBasis>(4, 2), false, false, 0});
  // Pieces [0, 0.225], [0.225, 0.45], [0.45, 0.725], [0.725, 1]: the base alone is no place for a contact.
  sample.spec.contacts = {{0, false, 0}, {1, false, 2}};
  const PoseProgram program(sample.spec);
  const int first = program.layout().first_arc_length;
  EXPECT_EQ(program.lower()[first], knot_clearance);
  EXPECT_NEAR(program.upper()[first], 0.225, 1e-15);
  EXPECT_NEAR(program.lower()[first + 1], 0.45, 1e-15);
  EXPECT_NEAR(program.upper()[first + 1], 0.725, 1e-15);
  EXPECT_EQ(program.layout().orders, 0) << "contacts in different pieces";
}

TEST(PoseValues, ABranchChangesLimitsOnly) {
  SamplePose sample({std::make_shared<LegendreBasis>(4), true, true, 1});
  sample.spec.min_force = 0.25;
  sample.spec.max_force = 4.0;
  sample.spec.least_convexity = 0.01;
  PoseProgram program(sample.spec);
  const PoseProgram::Layout& at = program.layout();
  struct Limits {
    Branch branch;
    double gap, force_low, force_high, tip_closest, convexity;
  };
  for (const Limits& l :
       {Limits{Branch::open, infinity, 0.25, 4.0, 0.0, -infinity}, Limits{Branch::touching, 0.0, 0.25, 4.0, 0.0, 0.01},
        Limits{Branch::separated, infinity, 0.0, 0.0, infinity, -infinity},
        Limits{Branch::open, infinity, 0.25, 4.0, 0.0, -infinity}}) {
    SCOPED_TRACE("branch " + std::to_string(static_cast<int>(l.branch)));
    for (int k = 0; k < 2; ++k) {
      program.set_branch(k, l.branch);
      EXPECT_EQ(program.branch(k), l.branch);
      EXPECT_EQ(program.row_lower()[at.first_gap + k], 0.0);
      EXPECT_EQ(program.row_upper()[at.first_gap + k], l.gap);
      EXPECT_EQ(program.lower()[program.force_variable(k)], l.force_low);
      EXPECT_EQ(program.upper()[program.force_variable(k)], l.force_high);
    }
    // Inside, a point is closest on both sides; at the tip the rod ends.
    EXPECT_EQ(program.row_lower()[at.first_closest], 0.0);
    EXPECT_EQ(program.row_upper()[at.first_closest], 0.0);
    EXPECT_EQ(program.row_lower()[at.first_closest + 1], -infinity);
    EXPECT_EQ(program.row_upper()[at.first_closest + 1], l.tip_closest);
    ASSERT_EQ(at.convexities, 2);
    for (int side = 0; side < 2; ++side) {
      EXPECT_EQ(program.row_lower()[at.first_convexity + side], l.convexity);
      EXPECT_EQ(program.row_upper()[at.first_convexity + side], infinity);
    }
  }
}

TEST(PoseValues, RowsAndVariablesAreNamedByTheirBlocks) {
  SamplePose sample({std::make_shared<LegendreBasis>(4), true, true, 2, "circles", true});
  sample.spec.tolerance = {0.1, 0.1};
  sample.spec.least_margin = 0.1;
  sample.spec.least_convexity = 0.1;
  const PoseProgram program(sample.spec);
  // Two stretches, the second with two knots: four pieces.
  const std::vector<std::pair<std::string, int>> rows{
      {"equilibrium row", 16},    {"contact_gap row", 3},   {"closest_point row", 3},
      {"non_penetration row", 5}, {"contact_order row", 1}, {"force_balance row", 1},
      {"target row", 2},          {"stability row", 1},     {"point_contact row", 4}};
  int row = 0;
  for (const auto& [name, count] : rows) {
    for (int i = 1; i <= count; ++i) EXPECT_EQ(program.row_name(row++), name + " " + std::to_string(i));
  }
  EXPECT_EQ(row, program.row_count());
  const std::vector<std::pair<std::string, int>> variables{
      {"coordinate", 16}, {"moment", 2}, {"contact arc length", 2}, {"contact force", 3}};
  int variable = 0;
  for (const auto& [name, count] : variables) {
    for (int i = 1; i <= count; ++i) EXPECT_EQ(program.variable_name(variable++), name + " " + std::to_string(i));
  }
  EXPECT_EQ(program.variable_name(variable), "palm distance");
  EXPECT_EQ(variable + 1, program.variable_count());
}

TEST(PoseValues, RefuseACheckPointOutsideItsPiece) {
  SamplePose sample({std::make_shared<LegendreBasis>(4), true, false, 0});
  for (const CheckPoint& wrong :
       {CheckPoint{-1, 0.5, 0}, CheckPoint{2, 0.5, 0}, CheckPoint{0, 0.0, 0}, CheckPoint{0, 1.1, 0}}) {
    sample.spec.checks = {wrong};
    EXPECT_THROW(PoseProgram{sample.spec}, Error) << wrong.piece << ' ' << wrong.sigma;
  }
  sample.spec.checks = {{1, 1.0, 0}};
  EXPECT_NO_THROW(PoseProgram{sample.spec});
}

}  // namespace
}  // namespace tendril
