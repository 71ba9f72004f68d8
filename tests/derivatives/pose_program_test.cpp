// Every derivative of the pose program against central differences at random points, for every kind of basis, split and
// not.

#include "program/pose_program.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "certificate/certifier.hpp"
#include "certificate/clearance.hpp"
#include "differences.hpp"
#include "support/sample_programs.hpp"

namespace tendril {
namespace {

/// One function per piece, as the constant-curvature model has.
class Linear : public CoordinateModel {
 public:
  explicit Linear(int pieces) : pieces_(pieces) {}
  int function_count() const override { return 1; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override {
    for (std::size_t g = 0; g < sigma.size(); ++g) {
      const auto i = static_cast<Eigen::Index>(g);
      value(i, 0) = sigma[g];
      first(i, 0) = 1.0;
      second(i, 0) = 0.0;
    }
  }
  std::vector<double> subdivision() const override {
    return std::vector<double>(static_cast<std::size_t>(pieces_), 1.0);
  }

 private:
  int pieces_;
};

/// Functions whose end values do not vanish, and a break: nothing that Legendre makes simple is simple here.
class Sines : public CoordinateModel {
 public:
  int function_count() const override { return 4; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override {
    for (std::size_t g = 0; g < sigma.size(); ++g) {
      const auto row = static_cast<Eigen::Index>(g);
      const double s = sigma[g];
      for (int i = 0; i < 3; ++i) {
        const double w = 0.9 * (i + 1);
        value(row, i) = std::sin(w * s);
        first(row, i) = w * std::cos(w * s);
        second(row, i) = -w * w * std::sin(w * s);
      }
      const double after = std::max(0.0, s - 0.4);
      value(row, 3) = after * after * after;
      first(row, 3) = 3.0 * after * after;
      second(row, 3) = 6.0 * after;
    }
  }
  std::vector<double> breaks() const override { return {0.4}; }
};

struct PoseCase {
  const char* name;
  std::shared_ptr<CoordinateModel> model;
  bool split;
  bool tip_contact;
  int interior_contacts;
  const char* shapes = "circles";
  bool palm = false;
  const char* rod = "uniform";
  bool profiles = false;
  bool stretches = false;
  bool moves = false;
};

std::ostream& operator<<(std::ostream& os, const PoseCase& c) { return os << c.name; }

class PoseDerivatives : public testing::TestWithParam<PoseCase> {
 protected:
  PoseDerivatives() : sample(setup_of(GetParam())), spec(sample.spec) {
    spec.tolerance = {0.2, 0.3};
    program = std::make_unique<PoseProgram>(spec);
  }

  static support::SamplePose::Setup setup_of(const PoseCase& c) {
    return {c.model, c.split, c.tip_contact, c.interior_contacts, c.shapes,
            c.palm,  c.rod,   c.profiles,    c.stretches,         c.moves};
  }

  Eigen::VectorXd random_point(std::mt19937& random) {
    std::uniform_real_distribution<double> d(-0.4, 0.4);
    Eigen::VectorXd x(program->variable_count());
    const PoseProgram::Layout& at = program->layout();
    do {
      for (double& value : x) value = d(random);
      // Shapes that the basis resolves: coefficients fall with their order.
      const int n = program->chain().functions();
      for (int i = 0; i < at.coordinates; ++i) x[i] /= std::pow(1.0 + i % n, 1.5);
      if (at.moves > 0) x[at.first_arc_length - 1] = 0.1 + 0.2 * d(random);
      for (int k = 0; k < at.arc_lengths; ++k) {
        const double low = program->lower()[at.first_arc_length + k] + (at.moves > 0 ? 0.2 : 0.0);
        const double high = program->upper()[at.first_arc_length + k];
        x[at.first_arc_length + k] = low + (high - low) * (k + 1.0 + 0.5 * d(random)) / (at.arc_lengths + 1.0);
      }
      for (int k = 0; k < at.forces; ++k) x[at.first_force + k] = 0.5 + d(random);
    } while (a_knot_meets_a_sample(x) || a_point_meets_a_seam(x));
    return x;
  }

  /// The curvature of an obstacle jumps at its seams: no second derivative there.
  bool a_point_meets_a_seam(const Eigen::VectorXd& x) {
    program->constraints(x);
    std::vector<std::pair<const Obstacle*, Vec2>> points;
    for (std::size_t k = 0; k < program->contacts().size(); ++k) {
      points.emplace_back(spec.obstacles[static_cast<std::size_t>(spec.contacts[k].obstacle)],
                          program->contacts()[k].point);
    }
    Curve curve(std::make_shared<CurveTables>(program->chain().rule()));
    curve.follow(program->backbone());
    for (const CheckPoint& c : spec.checks) {
      if (c.obstacle == 2) continue;
      points.emplace_back(spec.obstacles[static_cast<std::size_t>(c.obstacle)], curve.position(c.piece, c.sigma));
    }
    return std::any_of(points.begin(), points.end(), [](const auto& p) {
      const int patch = p.first->patch_at(p.second);
      for (int i = 0; i < 8; ++i) {
        const Vec2 away = 20.0 * step * Vec2{std::cos(0.785 * i), std::sin(0.785 * i)};
        if (p.first->patch_at(p.second + away) != patch) return true;
      }
      return false;
    });
  }

  /// The curvature at a fixed arc length jumps when a knot passes: no derivative there.
  bool a_knot_meets_a_sample(const Eigen::VectorXd& x) const {
    const Chain& chain = program->chain();
    const std::span<const double> knots = program->knots(x);
    for (int j = 0; j < chain.piece_count(); ++j) {
      for (const double s : sample.everything->reads().samples) {
        if (std::abs(chain.start(j, knots) - s) < 5.0 * step) return true;
      }
    }
    return false;
  }

  /// Lets contacts push off their normals. False: none does, or not where a knot moves with each.
  bool rub() {
    if (!GetParam().split || program->layout().forces == 0) return false;
    Loads loads = program->loads();
    for (std::size_t o = 0; o < spec.obstacles.size(); ++o) loads.friction.push_back(o % 2 == 0 ? 0.7 : -0.4);
    program->set_loads(loads);
    return true;
  }

  /// Lets contacts stick. False: there is none, or not with a knot of its own.
  bool stick() {
    if (!GetParam().split || program->layout().forces == 0) return false;
    for (ContactSetup& c : spec.contacts) c.sticks = true;
    program = std::make_unique<PoseProgram>(spec);
    Loads loads = program->loads();
    loads.anchors.resize(spec.contacts.size());
    program->set_loads(loads);
    return true;
  }

  /// Contacts stick from where they are at x, or from beside it.
  void anchor(const Eigen::VectorXd& x, std::mt19937& random) {
    std::uniform_real_distribution<double> d(-0.1, 0.1);
    Loads loads = program->loads();
    program->constraints(x);
    for (std::size_t k = 0; k < loads.anchors.size(); ++k) {
      loads.anchors[k] = program->anchor(static_cast<int>(k));
      loads.anchors[k].slid = d(random);
      loads.anchors[k].arc_length += d(random);
      loads.anchors[k].angle += d(random);
    }
    program->set_loads(loads);
  }

  /// Makes tangential forces variables, and a palm's object heavy. False: there are none, or knots do not move with
  /// them.
  bool plan_friction() {
    if (!GetParam().split || program->layout().forces == 0) return false;
    spec.friction.assign(spec.obstacles.size(), 0.7);
    if (spec.palm) {
      spec.palm->loaded = true;
      spec.palm->load = 0.3;
      spec.palm->parts = 3;
    }
    program = std::make_unique<PoseProgram>(spec);
    return true;
  }

  support::SamplePose sample;
  PoseProgramSpec spec;
  std::unique_ptr<PoseProgram> program;
};

TEST_P(PoseDerivatives, AgreeWithDifferencesWhereTangentialForcesAreVariables) {
  if (!plan_friction()) return;
  std::mt19937 random(17);
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    expect_first_derivatives(*program, x);
    expect_hessian(*program, x, random);
  }
}

TEST_P(PoseDerivatives, FirstDerivativesAgreeWithDifferences) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 5; ++trial) expect_first_derivatives(*program, random_point(random));
  if (!rub()) return;
  for (int trial = 0; trial < 3; ++trial) expect_first_derivatives(*program, random_point(random));
  ASSERT_TRUE(stick());
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    anchor(x, random);
    expect_first_derivatives(*program, x);
  }
}

TEST_P(PoseDerivatives, HessianOfTheLagrangianAgreesWithDifferencesOfItsGradient) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    expect_hessian(*program, x, random);
  }
  if (!rub()) return;
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    expect_hessian(*program, x, random);
  }
  ASSERT_TRUE(stick());
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    anchor(x, random);
    expect_hessian(*program, x, random);
  }
}

TEST_P(PoseDerivatives, MarginOfStabilityAndSpreadingChangeAsTheirRowsSay) {
  std::mt19937 random(13);
  spec.least_margin = 0.1;
  spec.least_convexity = 0.1;
  PoseProgram kept(spec);
  Certifier certifier(spec);
  const int row = kept.layout().first_margin;
  const int convexities = 2 * kept.layout().arc_lengths;
  ASSERT_EQ(kept.row_count(), program->row_count() + 1 + convexities);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    // A contact that is about to spread slides without end: no derivative there.
    const auto bends = [&](const Eigen::VectorXd& y) {
      return Eigen::VectorXd(kept.constraints(y).segment(kept.layout().first_convexity, convexities));
    };
    const auto bent_off = [&](double with_step) {
      const Eigen::MatrixXd expected = differences(x, bends, with_step);
      const auto rows = kept.jacobian(x).middleRows(kept.layout().first_convexity, convexities);
      return largest(rows - expected) / (1.0 + largest(expected));
    };
    EXPECT_LT(std::min(bent_off(step), bent_off(0.1 * step)), 1e-6);
    (void)kept.jacobian(x);
    bool spreads = false;
    for (int k = 0; k < kept.layout().arc_lengths; ++k) spreads = spreads || std::abs(kept.contact_convexity(k)) < 0.2;
    if (spreads) continue;
    // Beside another eigenvalue, or where a contact slides far, the margin bends so sharply that only a shorter step
    // follows; elsewhere that one suffers from rounding. One of them has to agree.
    const auto margin = [&](const Eigen::VectorXd& y) {
      return Eigen::VectorXd::Constant(1, kept.constraints(y)[row]);
    };
    const auto off = [&](double with_step) {
      const Eigen::MatrixXd expected = differences(x, margin, with_step);
      return largest(kept.jacobian(x).row(row) - expected) / (1.0 + largest(expected));
    };
    EXPECT_LT(std::min({off(step), off(0.3 * step), off(0.1 * step)}), 1e-6);
    // On the doubled rule, as the certificate has it.
    EXPECT_NEAR(kept.constraints(x)[row], certifier.stability(x), 1e-7 * (1.0 + std::abs(kept.constraints(x)[row])));
  }
}

std::vector<PoseCase> pose_cases() {
  std::vector<PoseCase> all;
  const auto legendre = [](int order, int pieces = 1) { return std::make_shared<LegendreBasis>(order, pieces); };
  for (const bool split : {false, true}) {
    for (const int contacts : {0, 1, 2}) {
      for (const bool tip : {false, true}) {
        all.push_back({split ? "pcc3_split" : "pcc3", std::make_shared<Linear>(3), split, tip, contacts});
        all.push_back({split ? "legendre3_split" : "legendre3", legendre(3), split, tip, contacts});
        all.push_back({split ? "legendre6_split" : "legendre6", legendre(6), split, tip, contacts});
        all.push_back({split ? "legendre14_split" : "legendre14", legendre(14), split, tip, contacts});
        all.push_back({split ? "legendre5x2_split" : "legendre5x2", legendre(5, 2), split, tip, contacts});
        all.push_back({split ? "sines_split" : "sines", std::make_shared<Sines>(), split, tip, contacts});
      }
    }
  }
  for (const bool split : {false, true}) {
    for (const char* shapes : {"walls", "hulls"}) {
      all.push_back({split ? "legendre6_split" : "legendre6", legendre(6), split, true, 2, shapes});
    }
  }
  for (const bool split : {false, true}) {
    for (const bool tip : {false, true}) {
      for (const int contacts : {1, 2}) {
        const char* name = split ? "legendre6_split_palm" : "legendre6_palm";
        all.push_back({name, legendre(6), split, tip, contacts, "circles", true});
      }
    }
    all.push_back({split ? "legendre6_split_palm" : "legendre6_palm", legendre(6), split, true, 2, "hulls", true});
    all.push_back(
        {split ? "pcc3_split_palm" : "pcc3_palm", std::make_shared<Linear>(3), split, true, 0, "circles", true});
  }
  // Moments that vary along the rod: knots that move carry their pieces along the profiles.
  for (const bool split : {false, true}) {
    const auto add = [&](const char* name, const char* split_name, std::shared_ptr<CoordinateModel> model,
                         const char* rod = "uniform") {
      for (const int contacts : {0, 1, 2}) {
        all.push_back({split ? split_name : name, model, split, contacts == 2, contacts, "circles", false, rod, true});
      }
    };
    add("pcc3_profiles", "pcc3_split_profiles", std::make_shared<Linear>(3));
    add("legendre6_profiles", "legendre6_split_profiles", legendre(6));
    add("legendre6_profiles", "legendre6_split_profiles", legendre(6), "varied");
    add("legendre5x2_profiles", "legendre5x2_split_profiles", legendre(5, 2));
    add("sines_profiles", "sines_split_profiles", std::make_shared<Sines>());
    add("sines_profiles", "sines_split_profiles", std::make_shared<Sines>(), "varied");
  }
  for (const char* rod : {"tapered", "loaded", "thick", "varied"}) {
    for (const bool split : {false, true}) {
      const char* name = split ? "legendre6_split" : "legendre6";
      all.push_back({name, legendre(6), split, true, 2, "circles", false, rod});
      all.push_back({name, legendre(6), split, false, 1, "hulls", true, rod});
      all.push_back({split ? "sines_split" : "sines", std::make_shared<Sines>(), split, true, 2, "walls", false, rod});
      all.push_back({split ? "legendre14_split" : "legendre14", legendre(14), split, false, 1, "circles", false, rod});
    }
  }
  for (const bool split : {false, true}) {
    for (const char* rod : {"uniform", "varied"}) {
      const char* name = split ? "legendre6_split_stretch" : "legendre6_stretch";
      all.push_back({name, legendre(6), split, false, 0, "circles", false, rod, false, true});
      all.push_back({name, legendre(6), split, true, 2, "hulls", true, rod, true, true});
      const char* sines = split ? "sines_split_stretch" : "sines_stretch";
      all.push_back({sines, std::make_shared<Sines>(), split, true, 1, "circles", false, rod, true, true});
      const char* large = split ? "legendre14_split_stretch" : "legendre14_stretch";
      all.push_back({large, legendre(14), split, false, 1, "walls", false, rod, false, true});
    }
  }
  for (const char* rod : {"uniform", "varied"}) {
    const bool varied = std::string(rod) == "varied";
    const auto add = [&](const char* name, std::shared_ptr<CoordinateModel> model, bool tip, int contacts,
                         const char* shapes, bool palm) {
      all.push_back({name, std::move(model), true, tip, contacts, shapes, palm, rod, varied, varied && palm, true});
    };
    add("legendre6_split_moves", legendre(6), false, 0, "circles", false);
    add("legendre6_split_moves", legendre(6), true, 2, "hulls", true);
    add("legendre5x2_split_moves", legendre(5, 2), false, 2, "circles", false);
    add("sines_split_moves", std::make_shared<Sines>(), true, 1, "walls", false);
    add("pcc3_split_moves", std::make_shared<Linear>(3), true, 2, "circles", false);
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, PoseDerivatives, testing::ValuesIn(pose_cases()), [](const auto& each) {
  const PoseCase& c = each.param;
  return std::string(c.name) + "_" + std::to_string(c.interior_contacts) + "inside" + (c.tip_contact ? "_tip" : "") +
         (std::string(c.shapes) == "circles" ? "" : "_" + std::string(c.shapes)) +
         (std::string(c.rod) == "uniform" ? "" : "_" + std::string(c.rod));
});

}  // namespace
}  // namespace tendril
