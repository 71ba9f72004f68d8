// The numbers that verdicts stand on, and what is made of them.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "certificate/certifier.hpp"
#include "certificate/clearance.hpp"
#include "core_support.hpp"
#include "nlp/multipliers.hpp"
#include "obstacle/circle.hpp"
#include "rod/self_overlap.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::support {
namespace {

// model.md section 7, "`solved` means", and "Held plans"; sections 2 and 4 for the knots and the branch.
TEST(CounterexampleJudgement, TheLimitsAreThoseOfTheModel) {
  EXPECT_EQ(tolerance::equilibrium, 1e-9);
  EXPECT_EQ(tolerance::bounds, 1e-9);
  EXPECT_EQ(tolerance::penetration, 1e-9);
  EXPECT_EQ(tolerance::complementarity, 1e-9);
  EXPECT_EQ(tolerance::closest_point, 1e-8);
  EXPECT_EQ(tolerance::stationarity, 1e-6);
  EXPECT_EQ(tolerance::stability, 1e-6);
  EXPECT_EQ(tolerance::held_margin, 1e-3);
  EXPECT_EQ(tolerance::held_convexity, 1e-6);
  EXPECT_EQ(tolerance::branch_decided, 1e-6);
  EXPECT_EQ(tolerance::quadrature, 1e-10);
  EXPECT_EQ(knot_clearance, 1e-5);
  // Not in that list: a grasp's balance is one more equilibrium row, an execution's moment balance its strong form, a
  // contact holds the rod with no less than complementarity leaves, and clearance is known to a tenth of its limit.
  EXPECT_EQ(tolerance::balance, 1e-9);
  EXPECT_EQ(tolerance::moment_balance, 1e-9);
  EXPECT_EQ(tolerance::force, 1e-9);
  EXPECT_EQ(tolerance::clearance_sharpness, 1e-10);
  EXPECT_EQ(tolerance::convexity, 1e-9);
  EXPECT_EQ(tolerance::model_error, 5e-2);
}

/// A certificate in which nothing is wrong.
Certificate flawless() {
  Certificate c;
  c.equilibrium = c.bounds = c.penetration = c.complementarity = c.closest_point = c.balance = c.stationarity = 0.0;
  c.moment_balance = c.quadrature = 0.0;
  c.stationarity_kind = "S";
  c.stability = 1.0;
  list_failures(c);
  return c;
}

struct Line {
  double Certificate::*number;
  double limit;
  const char* name;
  const char* at_half;
  const char* at_twice;  ///< of the limit
};

const Line defects[] = {
    {&Certificate::equilibrium, 1e-9, "equilibrium", "", "equilibrium residual 2.00e-09 is above 1e-09"},
    {&Certificate::balance, 1e-9, "balance", "", "net force on the object 2.00e-09 is above 1e-09"},
    {&Certificate::bounds, 1e-9, "bounds", "", "violation of a limit 2.00e-09 is above 1e-09"},
    {&Certificate::penetration, 1e-9, "penetration", "", "penetration 2.00e-09 is above 1e-09"},
    {&Certificate::complementarity, 1e-9, "complementarity", "", "complementarity 2.00e-09 is above 1e-09"},
    {&Certificate::closest_point, 1e-8, "closest point", "", "closest point 2.00e-08 is above 1e-08"},
    {&Certificate::stationarity, 1e-6, "stationarity", "", "stationarity 2.00e-06 is above 1e-06"},
    // These must not be too small.
    {&Certificate::stability, 1e-6, "stability", "unstable: the stability margin is 5.000e-07", ""},
    {&Certificate::contact_convexity, 1e-9, "contact convexity",
     "contact spreads: the rod lies along the obstacle, a point contact does not hold it", ""},
    // These are told, and judged elsewhere.
    {&Certificate::moment_balance, 1e-9, "moment balance", "", ""},
    {&Certificate::quadrature, 1e-10, "quadrature", "", ""}};

std::vector<std::string> lines(const std::string& text) {
  return text.empty() ? std::vector<std::string>{} : std::vector<std::string>{text};
}

TEST(CounterexampleJudgement, EveryNumberIsJudgedByItsLimit) {
  ASSERT_TRUE(flawless().valid());
  for (const Line& line : defects) {
    Certificate c = flawless();
    c.*line.number = 0.5 * line.limit;
    list_failures(c);
    EXPECT_EQ(c.failures, lines(line.at_half)) << "half the limit of " << line.name;
    c.*line.number = 2.0 * line.limit;
    list_failures(c);
    EXPECT_EQ(c.failures, lines(line.at_twice)) << "twice the limit of " << line.name;
  }
}

TEST(CounterexampleJudgement, WhatIsNoNumberIsNotMet) {
  for (const Line& line : defects) {
    if (line.at_half[0] == '\0' && line.at_twice[0] == '\0') continue;
    Certificate c = flawless();
    c.*line.number = std::nan("");
    list_failures(c);
    EXPECT_EQ(c.failures.size(), 1U) << line.name;
  }
}

TEST(CounterexampleJudgement, EveryFailureHasALine) {
  Certificate c;
  list_failures(c);
  EXPECT_EQ(c.failures.size(), 8U) << "seven sizes and the stability";
  c.contact_convexity = 0.0;
  list_failures(c);
  EXPECT_EQ(c.failures.size(), 8U) << "where a contact spreads there is no margin to speak of";
  EXPECT_EQ(c.failures.back().find("contact spreads"), 0U) << c.failures.back();
}

TEST(CounterexampleJudgement, WithoutAJudgementNothingIsCertified) { EXPECT_FALSE(Certificate{}.valid()); }

TEST(CounterexampleJudgement, OnlyStrongStationarityCounts) {
  for (const auto& [kind, line] : {std::pair{"M", "the point is M-stationary, not S-stationary"},
                                   std::pair{"C", "the point is C-stationary, not S-stationary"},
                                   std::pair{"none", "the point is not even C-stationary, not S-stationary"}}) {
    Certificate c = flawless();
    c.stationarity_kind = kind;
    list_failures(c);
    EXPECT_EQ(c.failures, lines(line));
    // A slope that is left says more.
    c.stationarity = 2e-6;
    list_failures(c);
    EXPECT_EQ(c.failures, lines("stationarity 2.00e-06 is above 1e-06")) << kind;
  }
}

TEST(CounterexampleJudgement, TheWorseOfTwoIsWorseInEveryNumber) {
  for (const Line& line : defects) {
    const bool small_is_bad = line.number == &Certificate::stability || line.number == &Certificate::contact_convexity;
    const Certificate good = flawless();
    Certificate bad = good;
    bad.*line.number = small_is_bad ? -3.0 : 3.0;
    EXPECT_EQ(worse_of(good, bad).*line.number, bad.*line.number) << line.name;
    EXPECT_EQ(worse_of(bad, good).*line.number, bad.*line.number) << line.name;
    bad.*line.number = std::nan("");
    EXPECT_TRUE(std::isnan(worse_of(good, bad).*line.number)) << line.name;
    EXPECT_TRUE(std::isnan(worse_of(bad, good).*line.number)) << line.name;
  }
}

TEST(CounterexampleJudgement, TheWorseOfTwoIsOfTheWeakerKindAndHasBothLists) {
  const std::vector<std::string> kinds{"S", "M", "C", "none"};
  for (std::size_t a = 0; a < kinds.size(); ++a) {
    for (std::size_t b = 0; b < kinds.size(); ++b) {
      Certificate first = flawless();
      Certificate second = flawless();
      first.stationarity_kind = kinds[a];
      second.stationarity_kind = kinds[b];
      EXPECT_EQ(worse_of(first, second).stationarity_kind, kinds[std::max(a, b)]) << kinds[a] << " and " << kinds[b];
    }
  }
  Certificate first = flawless();
  Certificate second = flawless();
  first.failures = {"one"};
  second.failures = {"two"};
  EXPECT_EQ(worse_of(first, second).failures, (std::vector<std::string>{"one", "two"}));
}

/// Linear cost over one row r = x0 + x1 and two variables, with limits as given.
class Corner : public NonlinearProgram {
 public:
  Corner(Eigen::Vector2d slope, double row_low, double row_high, double low, double high)
      : NonlinearProgram(2, 1, 0), slope_(std::move(slope)) {
    row_lower_[0] = row_low;
    row_upper_[0] = row_high;
    lower_.setConstant(low);
    upper_.setConstant(high);
  }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    out.cost = out.rest = slope_.dot(x);
    out.constraints[0] = x[0] + x[1];
    if (!derivatives) return;
    out.gradient = out.rest_gradient = slope_;
    out.jacobian.setOnes();
  }
  void do_hessian(ConstVectorRef, double, ConstVectorRef, Workspace& out) override { out.hessian.setZero(); }

 private:
  Eigen::Vector2d slope_;
};

struct Kkt {
  const char* what;
  Eigen::Vector2d slope;
  double row_low, row_high, low, high;
  Eigen::Vector2d x;
  double row;              ///< multiplier
  Eigen::Vector2d bounds;  ///< multipliers
  double stationarity, infeasibility;
};

const std::vector<Kkt>& corners() {
  const Eigen::Vector2d none(0.0, 0.0);
  static const std::vector<Kkt> cases{
      {"row at its lower limit", {1.0, 1.0}, 1.0, infinity, -infinity, infinity, {0.5, 0.5}, -1.0, none, 0.0, 0.0},
      {"row at its upper limit", {-1.0, -1.0}, -infinity, 1.0, -infinity, infinity, {0.5, 0.5}, 1.0, none, 0.0, 0.0},
      {"row at the wrong limit", {1.0, 1.0}, -infinity, 1.0, -infinity, infinity, {0.5, 0.5}, 0.0, none, 1.0, 0.0},
      {"an equation pushes either way", {2.0, 2.0}, 1.0, 1.0, -infinity, infinity, {0.5, 0.5}, -2.0, none, 0.0, 0.0},
      {"and the other", {-2.0, -2.0}, 1.0, 1.0, -infinity, infinity, {0.5, 0.5}, 2.0, none, 0.0, 0.0},
      {"a row that is not active", {1.0, 1.0}, 0.0, infinity, -infinity, infinity, {0.5, 0.5}, 0.0, none, 1.0, 0.0},
      {"bounds below", {3.0, 2.0}, -infinity, infinity, 0.0, infinity, none, 0.0, {-3.0, -2.0}, 0.0, 0.0},
      {"bounds above", {-3.0, -2.0}, -infinity, infinity, -infinity, 0.0, none, 0.0, {3.0, 2.0}, 0.0, 0.0},
      {"bounds at the wrong side", {-3.0, -2.0}, -infinity, infinity, 0.0, infinity, none, 0.0, none, 3.0, 0.0},
      {"a violated row still pushes", {1.0, 1.0}, 1.0, infinity, -infinity, infinity, none, -1.0, none, 0.0, 1.0},
      {"a violated upper row", {-1.0, -1.0}, -infinity, -3.0, -infinity, infinity, none, 1.0, none, 0.0, 3.0},
      {"a violated bound", {-1.0, -1.0}, -infinity, infinity, -infinity, -2.0, none, 0.0, {1.0, 1.0}, 0.0, 2.0}};
  return cases;
}

TEST(CounterexampleJudgement, FirstOrderConditionsOfCorners) {
  for (const Kkt& k : corners()) {
    Corner program(k.slope, k.row_low, k.row_high, k.low, k.high);
    const KktJudgement found = judge_kkt(program, k.x, 1e-8);
    EXPECT_NEAR(found.stationarity, k.stationarity, 1e-14) << k.what;
    EXPECT_EQ(found.infeasibility, k.infeasibility) << k.what;
    EXPECT_EQ(infeasibility(program, k.x), k.infeasibility) << k.what;
    EXPECT_NEAR(found.multipliers[0], k.row, 1e-14) << k.what;
    EXPECT_NEAR((found.bound_multipliers - k.bounds).norm(), 0.0, 1e-14) << k.what;
    // The same multipliers, handed over; and with every sign turned, when none of a limit counts.
    const Eigen::VectorXd row = Eigen::VectorXd::Constant(1, k.row);
    const Eigen::VectorXd bounds = k.bounds;
    const KktJudgement given = judge_kkt(program, k.x, 1e-8, &row, &bounds);
    EXPECT_NEAR(given.stationarity, k.stationarity, 1e-14) << k.what;
    EXPECT_EQ(given.infeasibility, k.infeasibility) << k.what;
    EXPECT_EQ(given.cost, k.slope.dot(k.x)) << k.what;
    if (k.row_low == k.row_high) continue;
    const Eigen::VectorXd row_turned = -row;
    const Eigen::VectorXd bounds_turned = -bounds;
    const KktJudgement turned_over = judge_kkt(program, k.x, 1e-8, &row_turned, &bounds_turned);
    EXPECT_EQ(turned_over.multipliers.norm(), 0.0) << k.what;
    EXPECT_EQ(turned_over.bound_multipliers.norm(), 0.0) << k.what;
    EXPECT_EQ(turned_over.stationarity, k.slope.lpNorm<Eigen::Infinity>()) << k.what;
  }
}

TEST(CounterexampleJudgement, ALimitIsActiveWithinTheToleranceAskedFor) {
  for (const double away : {0.5e-6, 2e-6}) {
    Corner below({1.0, 1.0}, 1.0, infinity, -infinity, infinity);
    EXPECT_NEAR(judge_kkt(below, Eigen::Vector2d(1.0 + away, 0.0), 1e-6).stationarity, away < 1e-6 ? 0.0 : 1.0, 1e-14);
    Corner bound({1.0, 1.0}, -infinity, infinity, 0.0, infinity);
    EXPECT_NEAR(judge_kkt(bound, Eigen::Vector2d(away, away), 1e-6).stationarity, away < 1e-6 ? 0.0 : 1.0, 1e-14);
  }
}

/// A straight rod along x.
struct Straight {
  LegendreBasis basis{3, 2};
  Chain chain{Rod{}, basis, {}, 8};
  Backbone backbone{chain, {}, 0.0};
  Curve curve{std::make_shared<CurveTables>(chain.rule())};
  Straight() {
    backbone.move(Eigen::VectorXd::Zero(chain.coordinate_count()), {});
    curve.follow(backbone);
  }
};

TEST(CounterexampleJudgement, DepthIsSeenOnBothSidesOfItsLimit) {
  const Straight rod;
  for (const double s : {0.0, 0.2, 0.5, 0.77, 1.0}) {
    for (const double side : {1.0, -1.0}) {
      for (const double depth : {0.5e-9, 2e-9}) {
        const double found = certified_depth(rod.curve, Circle({s, side * (0.1 - depth)}, 0.1));
        EXPECT_GE(found, depth * (1.0 - 1e-6)) << s;
        EXPECT_LE(found, depth + 1e-10) << s;
      }
    }
  }
}

TEST(CounterexampleJudgement, AClosestApproachIsTold) {
  const Straight rod;
  for (const double s : {0.0, 0.2, 0.5, 0.77, 1.0}) {
    const Circle circle({s, 0.3}, 0.1);
    const auto found = closest_approaches(rod.curve, circle, 0.21);
    ASSERT_EQ(found.size(), 1U) << s;
    EXPECT_NEAR(found[0].arc_length, s, 1e-7);
    EXPECT_NEAR(found[0].distance, 0.2, 1e-13);
    EXPECT_TRUE(closest_approaches(rod.curve, circle, 0.19).empty()) << s;
  }
}

BackbonePoint place(double s, double x, double y, double angle) { return {s, x, y, angle, 0.0}; }

/// Out along x, back above, and down across the way out, at x = 0.5; `reach` is where the last chord ends.
std::vector<BackbonePoint> hook(double reach) {
  return {place(0.0, 0.0, 0.0, 0.0), place(1.0, 1.0, 0.0, 1.6), place(2.0, 1.0, 1.0, 3.2), place(2.5, 0.5, 1.0, 4.7),
          place(3.5 - reach, 0.5, reach, 4.7)};
}

TEST(CounterexampleJudgement, ARodThatEndsShortOfItselfDoesNotOverlap) {
  EXPECT_FALSE(self_overlap(hook(1e-6)));
  const auto met = self_overlap(hook(-1e-6));
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->first, 0.5, 1e-12);
  EXPECT_NEAR(met->second, 3.5, 1e-5);
  // Turned by less than 3 rad in all, nothing is looked for: such a curve moves on along some direction.
  std::vector<BackbonePoint> straight = hook(-1e-6);
  for (BackbonePoint& p : straight) p.angle *= 2.9 / 4.7;
  EXPECT_FALSE(self_overlap(straight));
}

TEST(CounterexampleJudgement, ARodThatComesBackAlongItselfOverlaps) {
  // Out along x, a loop beyond, and back on the way out as far as x = 0.5; beside it by 1e-6 it meets nothing.
  for (const double beside : {0.0, 1e-6}) {
    const std::vector<BackbonePoint> rod{place(0.0, 0.0, 0.0, 0.0), place(1.0, 1.0, 0.0, 0.0),
                                         place(2.0, 2.0, -1.0, -1.0), place(3.0, 3.0, beside, -3.0),
                                         place(5.5, 0.5, beside, -4.0)};
    const auto met = self_overlap(rod);
    ASSERT_EQ(met.has_value(), beside == 0.0) << beside;
    if (met) {
      EXPECT_NEAR(met->first, 0.5, 1e-9);
      EXPECT_NEAR(met->second, 5.5, 1e-9);
    }
  }
}

TEST(CounterexampleJudgement, TwoRodsMeetWhereTheyCross) {
  const std::vector<BackbonePoint> along{place(0.0, 0.0, 0.0, 0.0), place(1.0, 1.0, 0.0, 0.0),
                                         place(2.0, 2.0, 0.0, 0.0)};
  const std::vector<BackbonePoint> down{place(0.0, 1.5, 1.0, -1.6), place(2.0, 1.5, -1.0, -1.6)};
  const auto met = meeting_of(along, down);
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->first, 1.5, 1e-12);
  EXPECT_NEAR(met->second, 1.0, 1e-12);
  const std::vector<BackbonePoint> short_of{place(0.0, 1.5, 1.0, -1.6), place(1.0, 1.5, 1e-6, -1.6)};
  EXPECT_FALSE(meeting_of(along, short_of));
}

}  // namespace
}  // namespace tendril::support
