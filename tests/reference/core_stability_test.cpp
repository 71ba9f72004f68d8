// The certificate's second variation, margins and strong form against known critical loads, folds and differences.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <random>

#include "certificate/certifier.hpp"
#include "core_support.hpp"
#include "obstacle/circle.hpp"
#include "support/link_chain.hpp"

namespace tendril::support {
namespace {

using std::numbers::pi;

std::unique_ptr<Equilibrium> braced(int order, bool split = true) {
  const DimensionlessArm arm;
  static const auto circle = core_obstacle(DimensionlessArm{}.circle);
  const double moment = 2.5e-3 / DimensionlessArm::moment_unit;
  return equilibrium_near(arm.rod, {moment}, {arm.circle}, {circle.get()}, arm.brace(moment), legendre(order), split);
}

TEST(CoreStabilityReference, StrongFormShowsTheModelErrorOfTheBracedArm) {
  // model.md section 7.
  for (const auto& [order, expected] : {std::pair{3, 5e-4}, std::pair{6, 1.8e-6}, std::pair{10, 5e-11}}) {
    const auto rod = braced(order);
    Certifier certifier(rod->spec);
    const Certificate c = certifier.certify(*rod->program, rod->x);
    std::cout << "order " << order << ": moment balance " << c.moment_balance << '\n';
    // The source gives one or two digits.
    EXPECT_LT(c.moment_balance, 3.0 * expected);
    EXPECT_GT(c.moment_balance, expected / 3.0);
    EXPECT_LE(c.equilibrium, 1e-12);
    EXPECT_LE(c.closest_point, 1e-12);
    EXPECT_LE(c.complementarity, 1e-12);
    EXPECT_LE(c.quadrature, 1e-12);
    EXPECT_LE(c.penetration, 1e-9);
  }
}

// The strong form compares a local quantity: it must see a wrong curvature wherever it is.
TEST(CoreStabilityReference, StrongFormIsTheLocalMoment) {
  Rod rod;
  rod.actuators.resize(1);
  rod.tip_force = {0.3, -0.8};
  Equilibrium at(rod, legendre(16), {0.5});
  ASSERT_LE(at.solve(constant_curvature(0.3)), 1e-12);
  Certifier certifier(at.spec);
  EXPECT_LT(certifier.certify(*at.program, at.x).moment_balance, 1e-11);
  Eigen::VectorXd bent = at.x;
  // A change of the linear coefficient by e changes the curvature by e everywhere and the moments by less.
  bent[0] += 1e-3;
  const double seen = certifier.certify(*at.program, bent).moment_balance;
  EXPECT_GT(seen, 1e-3 * 0.5);
  EXPECT_LT(seen, 1e-3 * 2.0);
}

// The strong form by hand: contact force times arm, and the weight beyond summed by trapezoids.
TEST(CoreStabilityReference, StrongFormAgreesWithDenseSampling) {
  const ReferenceTable table("circle_contact");
  const DimensionlessArm arm;
  struct Case {
    RodBvp rod;
    BvpContact circle;
    double moment;
    BvpSolution exact;
  };
  const BvpContact circle = table_circle(table, 0);
  for (const Case& c :
       {Case{RodBvp{}, circle, 3.0, press(circle, 3.0)}, Case{arm.rod, arm.circle, 0.2, arm.brace(0.2)}}) {
    const auto obstacle = core_obstacle(c.circle);
    const double weight = c.rod.gravity.y != 0.0 ? c.rod.sections[0].density : 0.0;
    for (const bool split : {true, false}) {
      for (const int order : {3, 6, 12}) {
        const auto rod =
            equilibrium_near(c.rod, {c.moment}, {c.circle}, {obstacle.get()}, c.exact, legendre(order), split);
        Certifier certifier(rod->spec);
        const double reported = certifier.certify(*rod->program, rod->x).moment_balance;
        rod->program->constraints(rod->x);
        const PoseProgram::ContactState& contact = rod->program->contacts()[0];
        const Backbone& backbone = rod->program->backbone();
        double sampled = 0.0;
        // From the tip on: the weight beyond acts downwards at its centre.
        double mass = 0.0;
        double first_moment = 0.0;
        constexpr int samples = 4000;
        for (int j = backbone.chain().piece_count() - 1; j >= 0; --j) {
          double previous = 0.0;
          for (int i = samples; i >= 0; --i) {
            const double sigma = static_cast<double>(i) / samples;
            const Backbone::Point here = backbone.at(j, sigma);
            if (i < samples) {
              const double step = weight * backbone.length(j) / samples;
              mass += step;
              first_moment += 0.5 * step * (previous + here.position.x);
            }
            previous = here.position.x;
            double beyond = here.position.x * mass - first_moment;
            if (backbone.start(j) + sigma * backbone.length(j) < contact.arc_length - 1e-12) {
              beyond += cross(contact.point - here.position, contact.force * contact.surface.normal);
            }
            sampled = std::max(sampled, std::abs(here.curvature - c.moment - beyond));
          }
        }
        std::cout << (split ? "split " : "unsplit ") << order << ": moment balance " << reported << ", sampled "
                  << sampled << '\n';
        // 4000 trapezoids of the weight are good to 1e-8. Samples miss the kink at an unsplit contact, where the
        // moment's slope jumps by the force, by half a spacing at most.
        EXPECT_LT(reported, sampled + (split ? 0.0 : contact.force / samples) + 1e-8);
        // The certificate looks at nodes, knots and contacts: a peak between nodes may show a little lower.
        EXPECT_GT(reported, 0.97 * sampled - 1e-8);
      }
    }
  }
}

// model.md section 7, to the digits shown.
TEST(CoreStabilityReference, MarginAndConvexityOfTheBracedArm) {
  for (const int order : {6, 10, 14}) {
    const auto rod = braced(order);
    Certifier certifier(rod->spec);
    EXPECT_NEAR(certifier.stability(rod->x), 0.99079, 0.6e-5) << order;
    EXPECT_NEAR(certifier.contact_convexity(rod->x, 0), 12.8737, 0.6e-4) << order;
  }
}

double root_by_bisection(const std::function<double(double)>& f, double low, double high) {
  const double at_low = f(low);
  EXPECT_LT(at_low * f(high), 0.0);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) * at_low > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double straight_margin(const Rod& rod, const Model& model) {
  Equilibrium at(rod, model, {0.0});
  EXPECT_LE(at.program->constraints(at.x).cwiseAbs().maxCoeff(), 1e-14);
  Certifier certifier(at.spec);
  return certifier.stability(at.x);
}

double euler_load(const Model& model) {
  return root_by_bisection([&](double load) { return straight_margin(upright_rod(0.0, load), model); }, 2.0, 4.0);
}

double critical_weight(const Model& model) {
  return root_by_bisection([&](double weight) { return straight_margin(upright_rod(weight, 0.0), model); }, 6.0, 12.0);
}

constexpr double exact_euler = 0.25 * pi * pi;
constexpr double exact_weight = 7.8373474389;

TEST(CoreStabilityReference, BucklingLoadsOfLegendre) {
  for (const int order : {8, 10, 14, 20}) {
    EXPECT_NEAR(euler_load(legendre(order)), exact_euler, 1e-6) << order;
    EXPECT_NEAR(critical_weight(legendre(order)), exact_weight, 1e-6) << order;
  }
  // Converged: rounding for the one, the eleven digits given for the other.
  EXPECT_NEAR(euler_load(legendre(14)), exact_euler, 1e-11);
  EXPECT_NEAR(critical_weight(legendre(14)), exact_weight, 1e-10);
}

TEST(CoreStabilityReference, BucklingLoadsOfCoarseModels) {
  const double euler = euler_load(psc()) - exact_euler;
  const double weight = critical_weight(psc()) - exact_weight;
  std::cout << "psc: Euler load off by " << euler << ", critical weight by " << weight << '\n';
  // model.md section 8, two digits.
  EXPECT_NEAR(euler, 3.4e-4, 0.1e-4);
  EXPECT_NEAR(weight, 3.5e-2, 0.1e-2);
  const auto pcc_euler = [](int n) { return euler_load(pcc(n)) - exact_euler; };
  const auto pcc_weight = [](int n) { return critical_weight(pcc(n)) - exact_weight; };
  // A model is stiffer than the rod, by an error of n^-2 up to n^-4.
  EXPECT_GT(pcc_euler(32), 0.0);
  EXPECT_GT(pcc_weight(32), 0.0);
  EXPECT_NEAR(order_of(16, pcc_euler(16), 32, pcc_euler(32)), 2.0, 0.02);
  EXPECT_NEAR(order_of(16, pcc_weight(16), 32, pcc_weight(32)), 2.0, 0.02);
}

// For a straight rod under a tip force the margin is 1 - load / critical load exactly.
TEST(CoreStabilityReference, MarginFallsLinearlyWithTheLoad) {
  for (const double part : {-0.5, 0.0, 0.25, 0.5, 0.9, 1.5}) {
    const Rod rod = upright_rod(0.0, part * exact_euler);
    // Pulling leaves the high modes, whose margin nears 1 from above.
    const double expected = part < 0.0 ? 1.0 : 1.0 - part;
    EXPECT_NEAR(straight_margin(rod, legendre(14)), expected, part < 0.0 ? 1e-2 : 1e-10) << part;
  }
}

TEST(CoreStabilityReference, MarginOfABentRodAgreesWithALinkChain) {
  RodBvp bvp;
  bvp.sections[0].density = 5.0;
  bvp.gravity = {0.05, -1.0};
  bvp.base_angle = 1.45;
  bvp.tip_force = {0.0, -0.3};
  LinkChainOptions options;
  options.links = 200;
  const double chain = stability_margin(bvp, {-0.05}, settle(bvp, {-0.05}, {}, options));
  Equilibrium at(core_rod(bvp), legendre(14), {-0.05});
  ASSERT_LE(at.solve(constant_curvature(-1.0)), 1e-12);
  Certifier certifier(at.spec);
  const double margin = certifier.stability(at.x);
  std::cout << "bent rod: margin " << margin << ", link chain " << chain << '\n';
  EXPECT_GT(margin, 0.05);
  EXPECT_LT(margin, 0.95);
  // 200 links are off by about 1 / 200^2 times the sizes of the loads.
  EXPECT_NEAR(margin, chain, 3e-4);
}

/// Smallest eigenvalue of H against the bending energy on what the contacts leave free, by other means than the
/// library's.
double margin_of(Equilibrium& at, const Eigen::MatrixXd& h) {
  const int n = at.program->layout().coordinates;
  const MatrixView jacobian = at.program->jacobian(at.x);
  const Chain& chain = at.program->chain();
  Eigen::MatrixXd energy = Eigen::MatrixXd::Zero(n, n);
  for (int j = 0; j < chain.piece_count(); ++j) {
    const int f = chain.functions();
    energy.block(j * f, j * f, f, f) =
        chain.piece(j).stiffness / at.program->backbone().length(j) * chain.table().stiffness;
  }
  const int contacts = at.program->layout().forces;
  Eigen::MatrixXd free = Eigen::MatrixXd::Identity(n, n);
  if (contacts > 0) {
    free = Eigen::FullPivLU<Eigen::MatrixXd>(jacobian.block(at.program->layout().first_gap, 0, contacts, n)).kernel();
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(
             free.transpose() * h * free, free.transpose() * energy * free, Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

// model.md section 7: the second variation must let the contact slide.
TEST(CoreStabilityReference, LeavingOutTheSlidingTermWouldCallAStableRodUnstable) {
  const ReferenceTable table("circle_contact");
  const BvpContact circle = table_circle(table, 0);
  const auto obstacle = core_obstacle(circle);
  const BvpSolution exact = press(circle, 6.0);
  for (const int order : {14, 20}) {
    const auto rod = equilibrium_near(RodBvp{}, {6.0}, {circle}, {obstacle.get()}, exact, legendre(order), true);
    Certifier certifier(rod->spec);
    const int n = rod->program->layout().coordinates;
    const Eigen::MatrixXd frozen = -rod->program->jacobian(rod->x).topLeftCorner(n, n);
    const double with = certifier.stability(rod->x);
    std::cout << "order " << order << ": margin " << with << ", without sliding " << margin_of(*rod, frozen) << '\n';
    // Three digits are given.
    EXPECT_NEAR(with, 0.958, 0.6e-3);
    EXPECT_NEAR(margin_of(*rod, frozen), -0.144, 0.6e-3);
    EXPECT_NEAR(margin_of(*rod, certifier.second_variation(rod->x)), with, 1e-9);
  }
}

/// The fold of model.md section 8, followed from a moment of +2 with the tip's angle as the parameter.
struct Fold {
  double weight, moment, lean;
};

TEST(CoreStabilityReference, SnapThroughFolds) {
  for (const Fold& fold : {Fold{10.0, -0.24017224, 0.7272}, Fold{12.0, -0.59941729, 0.8253}}) {
    SCOPED_TRACE(fold.weight);
    const Rod rod = upright_rod(fold.weight, 0.0);
    for (const int order : {10, 14}) {
      // Down from +2 at given moments: stable, with a margin that falls.
      Eigen::VectorXd x;
      double previous = 1.0;
      for (const double part : {0.0, 0.3, 0.6, 0.8, 0.9, 0.97, 0.99, 0.999, 0.9999}) {
        const double moment = 2.0 + part * (fold.moment - 2.0);
        Equilibrium at(rod, legendre(order), {moment});
        ASSERT_LE(part == 0.0 ? at.solve(constant_curvature(2.0)) : at.solve_from(x), 1e-11);
        x = at.x;
        Certifier certifier(at.spec);
        const double margin = certifier.stability(at.x);
        EXPECT_GT(margin, 0.0) << moment;
        EXPECT_LT(margin, previous) << moment;
        previous = margin;
      }
      // Across the fold with the tip's angle given.
      Equilibrium free(rod, legendre(order), {});
      Certifier certifier(free.spec);
      const auto margin_at = [&](double lean) {
        EXPECT_LE(free.solve_at_tip_angle(x, 0.5 * pi + lean), 1e-11);
        return certifier.stability(free.x);
      };
      const double lean = root_by_bisection(margin_at, fold.lean - 0.05, fold.lean + 0.02);
      EXPECT_NEAR(margin_at(lean), 0.0, 1e-10);
      // The margin vanishes where the moment is least: eight digits of the moment, four of the angle are given.
      EXPECT_NEAR(free.x[free.program->moment_variable(0)], fold.moment, 0.6e-8) << order;
      EXPECT_NEAR(lean, fold.lean, 0.6e-4) << order;
      // At the very moment given the margin is zero to 1e-6 times the slope of order one; on the far side it is
      // negative.
      EXPECT_GT(margin_at(lean + 0.01), 0.0);
      EXPECT_LT(margin_at(lean - 0.01), 0.0);
    }
  }
}

/// A rod with gravity and load that overlaps or misses obstacles as it likes: the second variation is defined at any
/// shape whose contact points are closest points.
struct Posed {
  Rod rod;
  Circle upper{{0.25, 0.5}, 0.2};
  Circle lower{{0.75, -0.3}, 0.15};
  Circle ahead{{1.1, 0.4}, 0.1};
  Posed() {
    rod.segments = {{0.0, 0.5, 1.0, 2.0, 0.3}, {0.5, 1.0, 0.7, 1.0, -0.2}};
    rod.actuators = {{0.0, 1.0}};
    rod.gravity = {0.28, -0.96};
    rod.payload = 0.4;
    rod.tip_force = {0.3, -0.2};
    rod.base_angle = 0.2;
  }
};

/// Moves each interior contact to its closest point at the coordinates of x.
void slide(PoseProgram& program, Eigen::VectorXd& x) {
  const PoseProgram::Layout& at = program.layout();
  for (int iteration = 0; iteration < 30; ++iteration) {
    double worst = 0.0;
    for (int k = 0; k < at.arc_lengths; ++k) {
      const int variable = program.arc_length_variable(k);
      const double slope = program.jacobian(x)(at.first_closest + k, variable);
      const double step = program.constraints(x)[at.first_closest + k] / slope;
      x[variable] -= step;
      worst = std::max(worst, std::abs(step));
    }
    if (worst < 1e-15) return;
  }
}

// Without a split q does not depend on s, so H is the plain derivative of the equilibrium rows while contacts slide.
TEST(CoreStabilityReference, SecondVariationIsTheDerivativeOfTheSlidingEquilibrium) {
  Posed posed;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const bool tip : {false, true}) {
    std::vector<ContactSetup> contacts{{0, false, 0}, {1, false, 1}};
    if (tip) contacts.push_back({2, true, 0});
    Equilibrium at(posed.rod, legendre(6), {0.4}, {&posed.upper, &posed.lower, &posed.ahead}, contacts, false);
    for (int trial = 0; trial < 4; ++trial) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(at.x.size());
      const PoseProgram::Layout& layout = at.program->layout();
      for (int i = 0; i < layout.coordinates; ++i) x[i] = 0.3 * unit(random) / std::pow(1.0 + i % 6, 2);
      x[at.program->moment_variable(0)] = 0.4;
      x[at.program->arc_length_variable(0)] = 0.3;
      x[at.program->arc_length_variable(1)] = 0.7;
      for (int k = 0; k < layout.forces; ++k) x[at.program->force_variable(k)] = 1.5 + unit(random);
      slide(*at.program, x);
      ASSERT_LE(at.program->constraints(x).segment(layout.first_closest, 2).cwiseAbs().maxCoeff(), 1e-14);
      const int n = layout.coordinates;
      Eigen::MatrixXd differences(n, n);
      constexpr double step = 1e-3;
      for (int i = 0; i < n; ++i) {
        const auto residual = [&](double shift) {
          Eigen::VectorXd moved = x;
          moved[i] += shift;
          slide(*at.program, moved);
          return Eigen::VectorXd(at.program->constraints(moved).head(n));
        };
        differences.col(i) =
            -(45.0 * (residual(step) - residual(-step)) - 9.0 * (residual(2.0 * step) - residual(-2.0 * step)) +
              (residual(3.0 * step) - residual(-3.0 * step))) /
            (60.0 * step);
      }
      Certifier certifier(at.spec);
      const Eigen::MatrixXd h = certifier.second_variation(x);
      // Sixth-order differences: 1e-18 times seventh derivatives, and 1e-16 / 1e-3 of rounding times entries of
      // order 10.
      EXPECT_LT((h - differences).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + h.cwiseAbs().maxCoeff())) << tip << ' ' << trial;
      EXPECT_LT((h - h.transpose()).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + h.cwiseAbs().maxCoeff()));
    }
  }
}

// d_ss is the second derivative of the distance along the rod.
TEST(CoreStabilityReference, ConvexityIsTheSecondDerivativeOfTheDistance) {
  Posed posed;
  posed.rod.segments = {{0.0, 1.0, 1.0, 1.0, 0.0}};
  for (const bool split : {true, false}) {
    Equilibrium at(posed.rod, legendre(7), {0.4}, {&posed.upper}, {{0, false, 0}}, split);
    StartShape start;
    start.curvature = [](double s) { return 0.4 + 0.3 * s - 0.5 * s * s; };
    start.moments = {0.4};
    start.arc_lengths = {0.61};
    start.forces = {0.7};
    const Eigen::VectorXd x = at.program->start_from(start);
    Certifier certifier(at.spec);
    const double exact = certifier.contact_convexity(x, 0);
    at.program->constraints(x);
    const auto distance = [&](double s) { return posed.upper.at(at.program->backbone().at(s).position).distance; };
    constexpr double step = 2e-3;
    const double second = (-distance(0.61 + 2 * step) + 16.0 * distance(0.61 + step) - 30.0 * distance(0.61) +
                           16.0 * distance(0.61 - step) - distance(0.61 - 2 * step)) /
                          (12.0 * step * step);
    // Fourth-order differences: 2e-11 times sixth derivatives of order 1e3, and 1e-15 / 4e-6 of rounding.
    EXPECT_NEAR(exact, second, 1e-6 * (1.0 + std::abs(second))) << split;
  }
}

// A variation of the whole rod is the same quadratic form however the rod is cut: polynomials are in both bases.
TEST(CoreStabilityReference, SplittingDoesNotChangeTheSecondVariation) {
  Posed posed;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const std::vector<const Obstacle*> obstacles{&posed.upper, &posed.ahead};
  const std::vector<ContactSetup> contacts{{0, false, 0}, {1, true, 0}};
  Equilibrium whole(posed.rod, legendre(7), {0.4}, obstacles, contacts, false);
  Equilibrium cut(posed.rod, legendre(7), {0.4}, obstacles, contacts, true);
  for (int trial = 0; trial < 5; ++trial) {
    const auto polynomial = [&] {
      const double a = unit(random), b = unit(random), c = unit(random), d = unit(random);
      return [=](double s) { return a + s * (b + s * (c + s * d)); };
    };
    StartShape start;
    start.curvature = polynomial();
    start.moments = {0.4};
    start.arc_lengths = {0.43, 1.0};
    start.forces = {1.3, 0.6};
    // The identity holds wherever the contact is put, closest point or not.
    const Eigen::VectorXd x = whole.program->start_from(start);
    const Eigen::VectorXd y = cut.program->start_from(start);
    Certifier judge_whole(whole.spec);
    Certifier judge_cut(cut.spec);
    const Eigen::MatrixXd h = judge_whole.second_variation(x);
    const Eigen::MatrixXd k = judge_cut.second_variation(y);
    EXPECT_NEAR(judge_whole.contact_convexity(x, 0), judge_cut.contact_convexity(y, 0), 1e-10);
    for (int direction = 0; direction < 4; ++direction) {
      StartShape variation = start;
      variation.curvature = polynomial();
      const Eigen::VectorXd v = whole.program->start_from(variation).head(h.rows());
      const Eigen::VectorXd w = cut.program->start_from(variation).head(k.rows());
      // Exact but for rounding, amplified by the sliding term where d_ss is small.
      const double scale = v.dot(v) * h.cwiseAbs().maxCoeff();
      EXPECT_NEAR(v.dot(h * v), w.dot(k * w), 1e-11 * (1.0 + scale)) << trial;
    }
  }
}

TEST(CoreStabilityReference, MarginsOfSplitAndUnsplitProgramsMeet) {
  const auto split = braced(14);
  const double exact = Certifier(split->spec).stability(split->x);
  double previous = 0.0;
  for (const int order : {12, 24, 48}) {
    const auto whole = braced(order, false);
    const double error = std::abs(Certifier(whole->spec).stability(whole->x) - exact);
    std::cout << "unsplit " << order << ": margin off by " << error << '\n';
    // The softest variation kinks at the contact, so an unsplit basis finds it to order 1/n only.
    EXPECT_LT(error, order == 12 ? 1e-3 : 0.6 * previous);
    previous = error;
  }
}

}  // namespace
}  // namespace tendril::support
