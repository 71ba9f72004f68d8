#include <gtest/gtest.h>

#include <algorithm>

#include "known_problems.hpp"
#include "solvers.hpp"

namespace tendril::conformance {

namespace {

std::string word(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return text;
}

/// Passes if nothing is wrong, or if something is wrong that the table foresees.
void expect_known(const std::string& solver, const std::string& test, const std::string& wrong) {
  const std::string reason = expected_failure(solver, test);
  if (reason.empty()) {
    EXPECT_EQ(wrong, "") << solver << " on " << test;
  } else {
    EXPECT_NE(wrong, "") << solver << " passes " << test << ": take it out of the table of known failures (" << reason
                         << ")";
  }
}

class HockSchittkowski : public testing::TestWithParam<std::tuple<std::string, std::size_t>> {};

TEST_P(HockSchittkowski, EndsAtThePublishedOptimum) {
  const auto& [solver_name, index] = GetParam();
  const KnownProblem& problem = hock_schittkowski()[index];
  const auto program = problem.make();
  SolveControl control;
  control.max_iterations = 1000;
  const OptimalityReport report = make_solver(solver_name)->solve(*program, {problem.start, {}, {}}, control);
  expect_known(solver_name, problem.name, problem.check(report));
}

INSTANTIATE_TEST_SUITE_P(EverySolver, HockSchittkowski,
                         testing::Combine(testing::ValuesIn(solver_names()),
                                          testing::Range<std::size_t>(0, hock_schittkowski().size())),
                         [](const auto& each) {
                           return word(std::get<0>(each.param) + "_" +
                                       hock_schittkowski()[std::get<1>(each.param)].name);
                         });

/// The planner's continuation in small: raise the penalty or lower the product until every pair has a zero.
OptimalityReport solve_mpcc(Solver& solver, const KnownMpcc& problem, MpccTreatment treatment) {
  SolveControl control;
  control.max_iterations = 1000;
  SolverStart start{problem.start, {}, {}};
  OptimalityReport report;
  if (treatment == MpccTreatment::penalty) {
    for (double beta = 1.0; beta <= 1e4; beta *= 10.0) {
      report = solver.solve(*problem.make(treatment, beta), start, control);
      // A penalty too small can leave the program without a minimum; such a point is no start.
      if (report.status == SolveStatus::converged) start.x = report.x;
      if (report.status == SolveStatus::converged && problem.complementarity(report.x) <= 1e-6) break;
    }
  } else {
    for (double product = 1e-1; product >= 0.9e-9; product *= 1e-2) {
      report = solver.solve(*problem.make(treatment, product), start, control);
      if (report.status == SolveStatus::converged) start = {report.x, report.multipliers, report.bound_multipliers};
    }
  }
  return report;
}

/// Of MacMPEC, then with friction.
const std::vector<KnownMpcc>& mpccs() {
  static const std::vector<KnownMpcc> all = [] {
    std::vector<KnownMpcc> both = macmpec();
    both.insert(both.end(), friction().begin(), friction().end());
    return both;
  }();
  return all;
}

class Mpcc : public testing::TestWithParam<std::tuple<std::string, std::size_t, MpccTreatment>> {};

std::string treatment_name(MpccTreatment treatment) {
  return treatment == MpccTreatment::penalty ? "penalty" : "scholtes";
}

TEST_P(Mpcc, ContinuationEndsAtThePublishedOptimum) {
  const auto& [solver_name, index, treatment] = GetParam();
  const KnownMpcc& problem = mpccs()[index];
  const auto solver = make_solver(solver_name);
  const OptimalityReport report = solve_mpcc(*solver, problem, treatment);
  std::string wrong;
  const auto expect = [&](bool holds, const std::string& what) {
    if (!holds) wrong += (wrong.empty() ? "" : "; ") + what;
  };
  const double scale = std::max(1.0, std::abs(problem.optimum));
  // The last product allowed is 1e-9: where both sides are zero at the solution each is up to its root, 3e-5.
  expect(problem.complementarity(report.x) <= 1e-4,
         "complementarity " + std::to_string(problem.complementarity(report.x)));
  expect(report.infeasibility <= 1e-6, "infeasibility " + std::to_string(report.infeasibility));
  // Linear costs feel that root in full; the printed optima have five digits.
  expect(std::abs(problem.cost(report.x) - problem.optimum) <= 2e-4 * scale,
         "cost " + std::to_string(problem.cost(report.x)) + " instead of " + std::to_string(problem.optimum));
  if (!wrong.empty())
    wrong +=
        "; ended as " + std::string(to_string(report.status)) + " (" + report.native_status + ") " + report.message;
  expect_known(solver_name, problem.name + " " + treatment_name(treatment), wrong);
}

INSTANTIATE_TEST_SUITE_P(EverySolver, Mpcc,
                         testing::Combine(testing::ValuesIn(solver_names()),
                                          testing::Range<std::size_t>(0, mpccs().size()),
                                          testing::Values(MpccTreatment::penalty, MpccTreatment::scholtes)),
                         [](const auto& each) {
                           return word(std::get<0>(each.param) + "_" + mpccs()[std::get<1>(each.param)].name + "_" +
                                       treatment_name(std::get<2>(each.param)));
                         });

}  // namespace

}  // namespace tendril::conformance
