// A backend's own numbers: the multipliers that it hands back and those that it starts from.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "known_problems.hpp"
#include "solvers.hpp"
#include "support/print.hpp"

namespace tendril::conformance {

namespace {

/// Backends that have multipliers of their own. What they hand back is compared with the truth only where core did not
/// have to recover it, and it must not have to.
constexpr const char* with_multipliers[] = {"ceres", "ipopt"};

bool has_multipliers(const std::string& solver) {
  return std::find(std::begin(with_multipliers), std::end(with_multipliers), solver) != std::end(with_multipliers);
}

/// min |x - t|^2, t = (0, 2, 0, 2, 3, 5, 1): a row at its lower side, one at its upper, a lower and an upper bound, an
/// equation and a fixed variable; every one of them has another side that idles. Every multiplier is another number.
struct Sides {
  int variables = 7;
  int rows = 4;
  int residuals = 7;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const double t[] = {0.0, 2.0, 0.0, 2.0, 3.0, 5.0, 1.0};
    for (std::size_t i = 0; i < 7; ++i) out.residuals[i] = x[i] - t[i];
    out.rows[0] = x[0];
    out.rows[1] = x[1];
    out.rows[2] = x[4] + x[5];
    out.rows[3] = x[0] + x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << 1.0, -3.0, 1.0, -9.0;
    b.row_upper << 4.0, 0.5, 1.0, 9.0;
    b.lower << -infinity, -9.0, 1.5, -3.0, -infinity, -infinity, 0.3;
    b.upper << infinity, 9.0, 4.0, 0.25, infinity, infinity, 0.3;
  }
};

/// A row with two sides at its lower one, where the nearest feasible point is not the best.
struct Band {
  int variables = 2;
  int rows = 1;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0];
    out.residuals[1] = 2.0 * x[1];
    out.rows[0] = x[0] + x[1];
  }
  void bounds(Bounds b) const { b.row_lower[0] = 1.0, b.row_upper[0] = 9.0; }
};

/// A program whose multipliers are known at its only solution.
struct KnownMultipliers {
  std::string name;
  std::function<std::unique_ptr<NonlinearProgram>()> make;
  Eigen::VectorXd start;
  Eigen::VectorXd solution;
  Eigen::VectorXd rows;
  Eigen::VectorXd bounds;
};

/// From the collection: the multipliers solve grad f + J^T y + z = 0 at the published solution, by hand. Its rows are
/// written c >= 0, so that they are at their lower sides, but for the one of hs037.
KnownMultipliers known(const std::string& name, std::initializer_list<double> rows,
                       std::initializer_list<double> bounds) {
  const KnownProblem& problem = *std::find_if(hock_schittkowski().begin(), hock_schittkowski().end(),
                                              [&](const KnownProblem& p) { return p.name == name; });
  return {name, problem.make, problem.start, problem.solution, vector(rows), vector(bounds)};
}

const std::vector<KnownMultipliers>& all() {
  static const double root2 = std::sqrt(2.0);
  static const double root3 = std::sqrt(3.0);
  static const double root7 = std::sqrt(7.0);
  static const double of_row = 2.5 - 11.5 / root7;
  static const std::vector<KnownMultipliers> list{
      {"sides", [] { return std::make_unique<FormulaProgram<Sides>>(); }, vector({2.0, 0.0, 2.0, 0.0, 1.0, 1.0, 0.3}),
       vector({1.0, 0.5, 1.5, 0.25, -0.5, 1.5, 0.3}), vector({-2.0, 3.0, 7.0, 0.0}),
       vector({0.0, 0.0, -3.0, 3.5, 0.0, 0.0, 1.4})},
      {"band", [] { return std::make_unique<FormulaProgram<Band>>(); }, vector({3.0, 1.0}), vector({0.8, 0.2}),
       vector({-1.6}), vector({0.0, 0.0})},
      known("hs001", {}, {0.0, 0.0}),
      known("hs004", {}, {-4.0, -1.0}),
      known("hs007", {0.5 / root3}, {0.0, 0.0}),
      known("hs010", {-0.5}, {0.0, 0.0}),
      known("hs012", {-0.5}, {0.0, 0.0}),
      known("hs014", {5.0 - root7 + of_row * (root7 - 1.0) / 4.0, of_row}, {0.0, 0.0}),
      known("hs021", {0.0}, {-0.04, 0.0}),
      known("hs022", {-2.0 / 3.0, -2.0 / 3.0}, {0.0, 0.0}),
      known("hs024", {-0.5 * root3, 0.0, -0.5}, {0.0, 0.0}),
      known("hs028", {0.0}, {0.0, 0.0, 0.0}),
      known("hs035", {-2.0 / 9.0}, {0.0, 0.0, 0.0}),
      known("hs036", {-110.0}, {55.0, 80.0, 0.0}),
      known("hs037", {144.0}, {0.0, 0.0, 0.0}),
      known("hs039", {-1.0, -1.0}, {0.0, 0.0, 0.0, 0.0}),
      known("hs042", {-2.0, 2.5 * root2 - 1.0}, {0.0, 0.0, 0.0, 0.0}),
      known("hs043", {-1.0, 0.0, -2.0}, {0.0, 0.0, 0.0, 0.0})};
  return list;
}

TEST(KnownMultipliers, BalanceTheGradientAtTheSolution) {
  for (const KnownMultipliers& problem : all()) {
    const auto program = problem.make();
    const Eigen::VectorXd slope = program->gradient(problem.solution) +
                                  program->jacobian(problem.solution).transpose() * problem.rows + problem.bounds;
    // Rounding of numbers up to 300.
    EXPECT_LT(slope.lpNorm<Eigen::Infinity>(), 1e-12) << problem.name << ": " << slope.transpose();
  }
}

class OwnNumbers : public testing::TestWithParam<std::tuple<std::string, std::size_t>> {
 protected:
  const std::string& solver() const { return std::get<0>(GetParam()); }
  const KnownMultipliers& problem() const { return all()[std::get<1>(GetParam())]; }
};

TEST_P(OwnNumbers, MultipliersAreThoseThatAreKnown) {
  const auto program = problem().make();
  SolveControl control;
  control.max_iterations = 1000;
  const OptimalityReport report = make_solver(solver())->solve(*program, {problem().start, {}, {}}, control);
  ASSERT_EQ(report.status, SolveStatus::converged) << report.native_status << ' ' << report.message;
  if (has_multipliers(solver())) {
    EXPECT_FALSE(report.multipliers_recovered) << "what it handed back does not balance the gradient";
  }
  // Solvers end where the gradient is 1e-8 of its size; its size is up to 300, and hs004 and hs039 divide by curvature.
  const double accuracy = 1e-5 * std::max(1.0, problem().rows.size() > 0 ? problem().rows.cwiseAbs().maxCoeff() : 1.0);
  for (int i = 0; i < program->row_count(); ++i) {
    EXPECT_NEAR(report.multipliers[i], problem().rows[i], accuracy) << program->row_name(i);
  }
  for (int i = 0; i < program->variable_count(); ++i) {
    EXPECT_NEAR(report.bound_multipliers[i], problem().bounds[i], accuracy) << program->variable_name(i);
  }
}

TEST_P(OwnNumbers, StartedAtTheAnswerWithItsMultipliersItIsDoneAtOnce) {
  const auto program = problem().make();
  const OptimalityReport report =
      make_solver(solver())->solve(*program, {problem().solution, problem().rows, problem().bounds}, {});
  EXPECT_EQ(report.status, SolveStatus::converged) << report.native_status << ' ' << report.message;
  if (has_multipliers(solver())) {
    EXPECT_LE(report.iterations, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(EverySolver, OwnNumbers,
                         testing::Combine(testing::ValuesIn(solver_names()),
                                          testing::Range<std::size_t>(0, all().size())),
                         [](const auto& each) {
                           return std::get<0>(each.param) + "_" + all()[std::get<1>(each.param)].name;
                         });

}  // namespace

}  // namespace tendril::conformance
