// The library's rods without contact against closed forms, tables and the boundary-value problem.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "core_support.hpp"
#include "obstacle/circle.hpp"

namespace tendril::support {
namespace {

constexpr double solved = 1e-12;

struct NamedModel {
  std::string name;
  Model model;
};

std::vector<NamedModel> all_models() {
  std::vector<NamedModel> models{{"psc", psc()}, {"pcc3", pcc(3)}, {"pcc12", pcc(12)}, {"legendre4x3", legendre(4, 3)}};
  for (int order = 1; order <= 24; ++order) models.push_back({"legendre" + std::to_string(order), legendre(order)});
  return models;
}

// Rounding alone: some ten operations on numbers of size 1 and on angles up to 20.
constexpr double to_rounding = 1e-12;

TEST(CoreReference, TipMomentIsACircularArcInEveryBasis) {
  Rod rod;
  rod.actuators.resize(1);
  const Circle dummy({0.2, 3.0}, 0.5);
  for (const NamedModel& m : all_models()) {
    for (const double moment : {-5.0, -0.7, 1e-3, 1.0, 3.0, 6.5, 13.0, 20.0}) {
      SCOPED_TRACE(m.name + " at moment " + std::to_string(moment));
      const double x = std::sin(moment) / moment;
      const double half = std::sin(0.5 * moment);
      const double y = 2.0 * half * half / moment;
      Equilibrium free(rod, m.model, {moment}, {}, {}, true, moment);
      EXPECT_LE(free.solve(constant_curvature(0.3)), solved);
      EXPECT_NEAR(free.tip().x, x, to_rounding);
      EXPECT_NEAR(free.tip().y, y, to_rounding);
      EXPECT_NEAR(free.tip_angle(), moment, to_rounding * (1.0 + std::abs(moment)));
      // A knot or a point on the rod that carries no force changes nothing.
      for (const bool split : {true, false}) {
        for (const double place : {0.01, 0.37, 0.95}) {
          const int region = split ? 0 : Chain(rod, *m.model, {}, 1).piece_at(place, {});
          Equilibrium cut(rod, m.model, {moment}, {&dummy}, {{0, false, region}}, split, moment);
          StartShape start = constant_curvature(0.3);
          start.moments = {moment};
          start.arc_lengths = {place};
          EXPECT_LE(cut.solve_coordinates(cut.program->start_from(start)), solved);
          EXPECT_NEAR(cut.tip().x, x, to_rounding);
          EXPECT_NEAR(cut.tip().y, y, to_rounding);
          const PoseProgram::ContactState& at = cut.program->contacts()[0];
          EXPECT_NEAR(at.point.x, std::sin(moment * place) / moment, to_rounding);
          EXPECT_NEAR(at.angle, moment * place, to_rounding * (1.0 + std::abs(moment)));
        }
      }
    }
  }
}

/// Tip of the library's rod at given moments from an arc; fails the test if it is not an equilibrium.
struct Tip {
  Vec2 point{};
  double angle = 0.0;
};

Tip free_tip(const RodBvp& bvp, const std::vector<double>& moments, const Model& model, double start_angle) {
  Equilibrium rod(core_rod(bvp), model, moments);
  StartShape start = constant_curvature(start_angle);
  start.moments = moments;
  EXPECT_LE(rod.solve(start), 1e-11);
  return {rod.tip(), rod.tip_angle()};
}

double distance(Vec2 a, const BvpSolution& b) { return norm(a - Vec2{b.tip_x, b.tip_y}); }

struct FreeCase {
  RodBvp rod;
  double moment = 0.0;
  std::string name;
};

std::vector<FreeCase> table_cases() {
  std::vector<FreeCase> cases;
  const ReferenceTable force("tip_force");
  for (std::size_t i = 0; i < force.rows(); ++i) {
    FreeCase c;
    c.rod.tip_force = {0.0, force.value(i, "alpha")};
    c.name = "tip force " + force.text(i, "alpha");
    cases.push_back(c);
  }
  const ReferenceTable weight("self_weight");
  for (std::size_t i = 0; i < weight.rows(); ++i) {
    FreeCase c;
    c.rod.sections[0].density = weight.value(i, "weight");
    c.rod.gravity = {0.0, -1.0};
    c.moment = weight.value(i, "moment");
    c.name = "weight " + weight.text(i, "weight") + " moment " + weight.text(i, "moment");
    cases.push_back(c);
  }
  return cases;
}

BvpSolution exact_free(const FreeCase& c) {
  BvpGuess guess;
  guess.curvature = c.rod.tip_force.y != 0.0 ? 1.0 : c.moment;
  return solve(c.rod, {c.moment}, {}, guess);
}

TEST(CoreReference, TipForceTable) {
  const ReferenceTable table("tip_force");
  for (const int order : {12, 24}) {
    for (std::size_t i = 0; i < table.rows(); ++i) {
      RodBvp rod;
      rod.tip_force = {0.0, table.value(i, "alpha")};
      const Tip tip = free_tip(rod, {0.0}, legendre(order), 0.5);
      EXPECT_NEAR(tip.angle, table.value(i, "theta"), printed(table, i, "theta")) << order << " row " << i;
      EXPECT_NEAR(1.0 - tip.point.x, table.value(i, "u"), printed(table, i, "u")) << order << " row " << i;
      EXPECT_NEAR(tip.point.y, table.value(i, "w"), printed(table, i, "w")) << order << " row " << i;
    }
  }
}

TEST(CoreReference, SelfWeightTable) {
  const ReferenceTable table("self_weight");
  for (const int order : {12, 24}) {
    for (std::size_t i = 0; i < table.rows(); ++i) {
      RodBvp rod;
      rod.sections[0].density = table.value(i, "weight");
      rod.gravity = {0.0, -1.0};
      const Tip tip = free_tip(rod, {table.value(i, "moment")}, legendre(order), table.value(i, "moment"));
      EXPECT_NEAR(tip.point.x, table.value(i, "x"), printed(table, i, "x")) << order << " row " << i;
      EXPECT_NEAR(tip.point.y, table.value(i, "y"), printed(table, i, "y")) << order << " row " << i;
      EXPECT_NEAR(tip.angle, table.value(i, "theta"), printed(table, i, "theta")) << order << " row " << i;
    }
  }
}

TEST(CoreReference, CoarseModelsShowTheirTrueError) {
  for (const FreeCase& c : table_cases()) {
    const BvpSolution reference = exact_free(c);
    const auto error = [&](const Model& model) {
      return distance(free_tip(c.rod, {c.moment}, model, 0.3).point, reference);
    };
    const double smooth6 = error(legendre(6));
    const double smooth3 = error(psc());
    std::cout << c.name << ": tip error / L  legendre6 " << smooth6 << "  psc " << smooth3;
    double previous = 0.0;
    double order = 0.0;
    double pcc3 = 0.0;
    for (const int n : {3, 6, 12, 24, 48}) {
      const double now = error(pcc(n));
      std::cout << "  pcc" << n << ' ' << now;
      if (n == 3) pcc3 = now;
      if (n > 3) order = order_of(n / 2, previous, n, now);
      previous = now;
    }
    std::cout << "  order of pcc " << order << '\n';
    // Bounds at about twice the worst row measured.
    EXPECT_LT(smooth6, 4e-6) << c.name;
    EXPECT_LT(smooth3, 3e-3) << c.name;
    EXPECT_LT(pcc3, 5e-2) << c.name;
    EXPECT_LT(smooth6, smooth3) << c.name;
    // Between 24 and 48 pieces the next term of the expansion, n^-4, is below 1 % of the first.
    EXPECT_NEAR(order, 2.0, 0.05) << c.name;
  }
}

TEST(CoreReference, LegendreConvergesExponentially) {
  for (const FreeCase& c : table_cases()) {
    const BvpSolution reference = exact_free(c);
    double previous = infinity;
    for (const int order : {3, 6, 9, 12, 16}) {
      const double error = distance(free_tip(c.rod, {c.moment}, legendre(order), 0.3).point, reference);
      // A fixed factor for every three functions more, down to rounding.
      EXPECT_LT(error, std::max(0.1 * previous, 1e-12)) << c.name << " order " << order;
      previous = error;
    }
  }
}

/// Everything a rod without contact may have, at random.
RodBvp random_rod(std::mt19937& random, std::vector<double>& moments) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  RodBvp rod;
  rod.sections.clear();
  const double cut = between(0.25, 0.45);
  const double second = between(0.55, 0.8);
  const bool three = unit(random) < 0.5;
  rod.sections.push_back({cut, 1.0, between(0.0, 3.0), between(-1.0, 1.0)});
  if (three) rod.sections.push_back({second - cut, between(0.5, 2.0), between(0.0, 3.0), between(-1.0, 1.0)});
  const double from = three ? second : cut;
  rod.sections.push_back({1.0 - from, between(0.5, 2.0), between(0.0, 3.0), between(-1.0, 1.0)});
  rod.actuators = {{0.0, 1.0}, {0.0, between(0.3, 0.7)}, {between(0.1, 0.4), between(0.6, 0.95)}};
  moments = {between(-1.5, 1.5), between(-1.5, 1.5), between(-1.5, 1.5)};
  const double tilt = between(0.0, 6.283);
  rod.gravity = {std::cos(tilt), std::sin(tilt)};
  rod.payload = between(0.0, 1.0);
  rod.tip_force = {between(-1.0, 1.0), between(-1.0, 1.0)};
  rod.base = {between(-0.5, 0.5), between(-0.5, 0.5)};
  rod.base_angle = between(-3.0, 3.0);
  return rod;
}

TEST(CoreReference, EveryLoadAtOnceAgreesWithTheBoundaryValueProblem) {
  std::mt19937 random(20);
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<double> moments;
    const RodBvp bvp = random_rod(random, moments);
    BvpGuess guess;
    guess.curvature = 0.2;
    const BvpSolution reference = follow(bvp, {0.0, 0.0, 0.0}, moments, {}, guess);
    Equilibrium rod(core_rod(bvp), legendre(14), moments);
    StartShape start;
    start.curvature = [](double) { return 0.2; };
    start.moments = moments;
    // Through the same loads, so that both find the same equilibrium where there are several.
    Eigen::VectorXd x = rod.program->start_from(start);
    for (int step = 0; step <= 4; ++step) {
      std::vector<double> part = moments;
      for (double& m : part) m *= 0.25 * step;
      // A moment of zero has no variable; a tiny one keeps the layout.
      for (double& m : part) m = step == 0 ? 1e-12 : m;
      Equilibrium at(core_rod(bvp), legendre(14), part);
      ASSERT_LE(at.solve_from(x), 1e-11);
      x = at.x;
    }
    ASSERT_LE(rod.solve_from(x), 1e-11);
    // Orders 14 per stretch resolve these loads to about 1e-12.
    EXPECT_NEAR(rod.tip().x, reference.tip_x, 1e-9);
    EXPECT_NEAR(rod.tip().y, reference.tip_y, 1e-9);
    EXPECT_NEAR(rod.tip_angle(), reference.tip_angle, 1e-9);
    for (const double s : {0.05, 0.29, 0.52, 0.77, 0.98}) {
      const Backbone::Point here = rod.program->backbone().at(s);
      const BvpState there = reference.at(s);
      EXPECT_NEAR(here.position.x, there.x, 1e-9) << s;
      EXPECT_NEAR(here.position.y, there.y, 1e-9) << s;
      EXPECT_NEAR(here.angle, there.angle, 1e-9) << s;
      // A derivative of the angle loses two digits.
      EXPECT_NEAR(here.curvature, there.curvature, 1e-7) << s;
    }
  }
}

}  // namespace
}  // namespace tendril::support
