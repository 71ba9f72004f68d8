#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>

#include "known_problems.hpp"
#include "solvers.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril::conformance {

namespace {

bool loaded(const std::string& solver) {
  return std::find(solver_names().begin(), solver_names().end(), solver) != solver_names().end();
}

#define NEEDS(solver) \
  if (!loaded(solver)) GTEST_SKIP() << "the plugin " << (solver) << " is not on the plugin path"

const KnownProblem& known(const std::string& name) {
  return *std::find_if(hock_schittkowski().begin(), hock_schittkowski().end(),
                       [&](const KnownProblem& p) { return p.name == name; });
}

RawOptions with(const std::string& name, RawValue value) { return {{name, std::move(value)}}; }
RawOptions with(const std::string& name, const char* value) { return with(name, RawValue{std::string(value)}); }

OptimalityReport solve(const std::string& solver, const RawOptions& options, const KnownProblem& problem) {
  const auto program = problem.make();
  return make_solver(solver, options)->solve(*program, {problem.start, {}, {}}, {});
}

/// What a plugin says when it refuses an option.
std::string refusal(const std::string& solver, const RawOptions& options) {
  try {
    make_solver(solver, options);
  } catch (const OptionError& e) {
    return e.what();
  }
  return "";
}

TEST(Nlopt, RefusesInWordsWhatAnAlgorithmCannotTake) {
  NEEDS("nlopt");
  const auto message = [](const char* algorithm, const char* problem) {
    const OptimalityReport report = solve("nlopt", with("algorithm", algorithm), known(problem));
    EXPECT_EQ(report.status, SolveStatus::unsupported) << algorithm;
    EXPECT_EQ(report.evaluations.values, 0);
    return report.message;
  };
  EXPECT_EQ(message("LD_LBFGS", "hs042"), "nlopt LD_LBFGS cannot take equality constraints: 2 rows");
  EXPECT_EQ(message("LD_MMA", "hs071"), "nlopt LD_MMA cannot take equality constraints: 1 row");
  EXPECT_EQ(message("LN_BOBYQA", "hs043"), "nlopt LN_BOBYQA cannot take inequality constraints: 3 rows");
  EXPECT_EQ(message("GN_ISRES", "hs043"), "nlopt GN_ISRES needs finite bounds: variable 1 has none on one side");
  EXPECT_EQ(message("LN_NEWUOA", "hs005"), "nlopt LN_NEWUOA cannot take bounds: variable 1 has one");
}

/// Slopes of 1e300 make the multiplier of the row as large, and SLSQP's merit overflows: no step is ever good enough,
/// and it shortens its step for ever, at last by nothing.
struct Overflowing {
  int variables = 1;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::sin;
    out.rest = 1e300 * (2.0 + sin(x[0]));
    out.rows[0] = x[0];
  }
  void bounds(Bounds b) const { b.row_lower[0] = b.row_upper[0] = 0.0; }
};

TEST(Nlopt, EndsALineSearchThatGoesOnForEver) {
  NEEDS("nlopt");
  for (const double start : {1e9, 1e10, 1e12}) {
    FormulaProgram<Overflowing> program;
    SolveControl control;
    control.time_limit = 36000.0;
    const OptimalityReport report =
        make_solver("nlopt")->solve(program, {Eigen::VectorXd::Constant(1, start), {}, {}}, control);
    // Stopped from outside, and not by a limit; what is feasible beside it is the only feasible point.
    EXPECT_EQ(report.native_status, "FORCED_STOP") << start;
    EXPECT_EQ(report.status, SolveStatus::converged) << start << ": " << report.message;
    EXPECT_EQ(report.x[0], 0.0) << start;
  }
}

struct SevenRows {
  int variables = 8;
  int rows = 7;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[7];
    for (std::size_t i = 0; i < 7; ++i) out.rows[i] = x[i];
  }
  void bounds(Bounds) const {}
};

class Named : public FormulaProgram<SevenRows> {
 public:
  std::string row_name(int row) const override {
    return row < 6 ? "equilibrium row " + std::to_string(row + 1) : "closest_point row 1";
  }
};

TEST(Ipopt, SaysWhichLibraryAnOptionWouldNeed) {
  NEEDS("ipopt");
  // Debian's Ipopt is built with MUMPS; these are found only where somebody installed them.
  for (const char* absent : {"ma27", "ma57", "ma77", "ma86", "ma97", "pardiso", "wsmp"}) {
    // Some are missed when the option is set, others when they are first used.
    std::string message = refusal("ipopt", with("linear_solver", absent));
    if (message.empty()) {
      const OptimalityReport report = solve("ipopt", with("linear_solver", absent), known("hs071"));
      if (report.status == SolveStatus::converged) continue;
      EXPECT_EQ(report.status, SolveStatus::failed) << absent;
      message = report.message;
    }
    const auto said = message.find("not available");
    ASSERT_NE(said, std::string::npos) << absent << ": " << message;
    std::string before = message.substr(0, said);
    std::transform(before.begin(), before.end(), before.begin(), [](unsigned char c) { return std::tolower(c); });
    EXPECT_TRUE(contains_text(before, absent)) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Nlopt, CountsRowsByTheNameTheProgramGivesThem) {
  NEEDS("nlopt");
  Named program;
  const auto solver = make_solver("nlopt", with("algorithm", "LD_LBFGS"));
  EXPECT_EQ(solver->solve(program, {Eigen::VectorXd::Zero(8), {}, {}}, {}).message,
            "nlopt LD_LBFGS cannot take equality constraints: 6 equilibrium rows, 1 closest_point row");
}

TEST(Nlopt, EveryAlgorithmThatCanTakeAProgramFindsItsMinimum) {
  NEEDS("nlopt");
  struct Choice {
    const char* algorithm;
    const char* problem;
  };
  // hs005 has bounds only, hs012 one inequality, hs042 equalities, hs071 all of them.
  for (const auto& [algorithm, problem] :
       {Choice{"LD_MMA", "hs012"}, Choice{"LD_CCSAQ", "hs012"}, Choice{"LD_AUGLAG", "hs071"},
        Choice{"LD_AUGLAG", "hs042"}, Choice{"LD_AUGLAG_EQ", "hs042"}, Choice{"LN_COBYLA", "hs012"},
        Choice{"LD_LBFGS", "hs005"}, Choice{"LD_VAR2", "hs005"}, Choice{"LD_TNEWTON_PRECOND_RESTART", "hs005"},
        Choice{"LN_BOBYQA", "hs005"}, Choice{"LN_SBPLX", "hs005"}, Choice{"GN_CRS2_LM", "hs005"},
        Choice{"GN_DIRECT_L", "hs005"}}) {
    const OptimalityReport report = solve("nlopt", with("algorithm", algorithm), known(problem));
    EXPECT_EQ(report.effective_options.at("algorithm"), algorithm);
    EXPECT_NE(report.status, SolveStatus::failed) << algorithm << " " << report.native_status << " " << report.message;
    EXPECT_LT(report.infeasibility, 1e-6) << algorithm;
    // Methods without gradients stop when the cost no longer changes by much; four digits show that it is this minimum.
    EXPECT_NEAR(report.cost, known(problem).optimum, 1e-4 * std::max(1.0, std::abs(known(problem).optimum)))
        << algorithm;
  }
}

TEST(Nlopt, RandomAlgorithmsRepeatThemselves) {
  NEEDS("nlopt");
  const OptimalityReport first = solve("nlopt", with("algorithm", "GN_CRS2_LM"), known("hs005"));
  const OptimalityReport second = solve("nlopt", with("algorithm", "GN_CRS2_LM"), known("hs005"));
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.evaluations.values, second.evaluations.values);
}

TEST(Nlopt, NamesTheNearestAlgorithm) {
  NEEDS("nlopt");
  EXPECT_TRUE(contains_text(refusal("nlopt", with("algorithm", "LD_SLSPQ")), "LD_SLSQP"));
}

TEST(Ipopt, PassesNativeOptionsOfEveryType) {
  NEEDS("ipopt");
  const RawOptions options{{"mu_strategy", {std::string("adaptive")}},
                           {"max_soc", {std::int64_t{2}}},
                           {"mu_init", {std::int64_t{1}}},
                           {"acceptable_tol", {1e-5}}};
  const OptimalityReport report = solve("ipopt", options, known("hs071"));
  EXPECT_EQ(known("hs071").check(report), "");
  EXPECT_EQ(report.effective_options.at("mu_strategy"), "'adaptive'");
  EXPECT_EQ(report.effective_options.at("max_soc"), "2");
}

TEST(Ipopt, WhatASceneNamesWinsOverOurDefaults) {
  NEEDS("ipopt");
  const OptimalityReport report = solve("ipopt", with("max_iter", RawValue{std::int64_t{3}}), known("hs071"));
  EXPECT_EQ(report.status, SolveStatus::iteration_limit);
  EXPECT_EQ(report.iterations, 3);
}

TEST(Ipopt, NamesTheOptionThatItRefuses) {
  NEEDS("ipopt");
  EXPECT_EQ(refusal("ipopt", with("mu_strtegy", "adaptive")),
            "ipopt has no option 'mu_strtegy'; did you mean 'mu_strategy'?");
  EXPECT_EQ(refusal("ipopt", with("mu_strategy", "clever")), "ipopt refuses option 'mu_strategy' = 'clever'");
  EXPECT_EQ(refusal("ipopt", with("tol", RawValue{-1.0})), "ipopt refuses option 'tol' = -1");
  EXPECT_NE(refusal("ipopt", with("tol", "small")), "");
}

TEST(Ipopt, RefusesToReadOrWriteFiles) {
  NEEDS("ipopt");
  for (const char* option : {"output_file", "option_file_name"}) {
    EXPECT_TRUE(contains_text(refusal("ipopt", with(option, "somewhere")), "files")) << option;
  }
  EXPECT_TRUE(contains_text(refusal("ipopt", with("file_print_level", RawValue{std::int64_t{5}})), "files"));
}

TEST(Ceres, SolvesWithEitherLinearSolver) {
  NEEDS("ceres");
  for (const char* solver : {"DENSE_QR", "DENSE_NORMAL_CHOLESKY"}) {
    const OptimalityReport report = solve("ceres", with("linear_solver_type", solver), known("hs071"));
    EXPECT_EQ(known("hs071").check(report), "") << solver;
    EXPECT_EQ(report.effective_options.at("linear_solver_type"), solver);
  }
}

TEST(Ceres, RefusesToDumpProblems) {
  NEEDS("ceres");
  EXPECT_NE(refusal("ceres", with("trust_region_problem_dump_directory", "somewhere")), "");
}

}  // namespace

}  // namespace tendril::conformance
