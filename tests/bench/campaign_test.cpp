// When a campaign is good enough, and how the bench's command ends.

#include "campaign/campaign.hpp"

#include <gtest/gtest.h>

#include "tendril/app/process.hpp"

namespace tendril::bench {
namespace {

CampaignCase ended(const char* solver, bool met, bool grave = false) {
  CampaignCase c;
  c.solver = solver;
  c.met = met;
  c.grave = grave;
  return c;
}

TEST(Acceptable, IsAShareOfTheCasesOfEverySolverAndNoneThatIsGrave) {
  CampaignSetup setup;
  setup.share = 0.5;
  const CampaignCase good = ended("a", true);
  const CampaignCase bad = ended("a", false);
  EXPECT_TRUE(acceptable(setup, {good, bad}));
  EXPECT_FALSE(acceptable(setup, {good, bad, bad}));
  EXPECT_TRUE(acceptable(setup, {good, good, bad}));
  // One solver that does well does not make up for another.
  EXPECT_FALSE(acceptable(setup, {good, good, good, ended("b", false)}));
  EXPECT_FALSE(acceptable(setup, {good, good, good, ended("a", false, true)}));
  EXPECT_FALSE(acceptable(setup, {ended("a", true, true)}));
  EXPECT_TRUE(acceptable(setup, {}));
  setup.share = 1.0;
  EXPECT_FALSE(acceptable(setup, {good, bad}));
}

TEST(CampaignSection, CountsWhatWasMet) {
  CampaignSetup setup;
  setup.solvers = {"a", "b"};
  CampaignCase slow = ended("a", false);
  slow.verdict = "not_converged";
  slow.seconds = 2.0;
  CampaignCase quick = ended("a", true);
  quick.verdict = "solved";
  quick.seconds = 1.0;
  const Section section = campaign_section(setup, {quick, slow, quick});
  const auto& counts = section.tables.at(0).rows;
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(std::get<std::int64_t>(counts[0].at(1)), 3);
  EXPECT_EQ(std::get<std::int64_t>(counts[0].at(2)), 2);
  EXPECT_DOUBLE_EQ(std::get<double>(counts[0].at(3)), 200.0 / 3.0);
  EXPECT_EQ(std::get<std::string>(counts[0].at(4)), "1 not_converged, 2 solved");
  EXPECT_EQ(std::get<double>(counts[0].at(5)), 1.0);
  EXPECT_EQ(std::get<double>(counts[0].at(6)), 2.0);
  EXPECT_EQ(section.tables.at(1).rows.size(), 1U);
  EXPECT_EQ(section.tables.at(2).rows.size(), 3U);
}

struct Code {
  std::vector<std::string> words;
  int exit_code;
  const char* said;
};

TEST(BenchCommand, EndsWithItsCode) {
  const std::string brace = std::string(TENDRIL_SCENES) + "/brace.toml";
  const std::string solver = TENDRIL_TEST_SOLVER;
  for (const Code& code :
       {Code{{"--version"}, 0, "."}, Code{{}, 2, "tendril-bench: "}, Code{{"campaing"}, 2, "subcommand"},
        Code{{"campaign", "--seeds", "1:2", "--solver", solver, "--share", "1"}, 0, "| 2 | 2 |"},
        // Its solver breaks down at every call.
        Code{{"campaign", "--seeds", "1:1", "--solver", "scripted", "--plugin-dir", TENDRIL_TEST_PLUGINS, "--share",
              "0.5"},
             1,
             "ended every solve as failed"},
        Code{{"campaign", "--seeds", "1:1", "--solver", "scripted", "--plugin-dir", TENDRIL_TEST_PLUGINS, "--share",
              "0"},
             0,
             "ended every solve as failed"},
        Code{{"campaign", "--list-search"}, 0, "most_starts"},
        Code{{"campaign", "--seeds", "1:2", "--solver", solver, "--ablation", "--search", "most_sides=0"},
             0,
             "most_sides=0"},
        Code{{"campaign", "--seeds", "1:3", "--solver", solver, "--relaxed"}, 0, "limits of moments 1.5 times as wide"},
        Code{{"campaign", "--seeds", "1:1", "--solver", solver, "--relaxation", "wider"}, 2, "wider"},
        Code{{"campaign", "--search", "most_side=0"}, 2, "no search parameter 'most_side'"},
        Code{{"campaign", "--search", "most_sides=few"}, 2, "is no number"},
        Code{{"campaign", "--seeds", "2:1"}, 2, "--seeds 2:1: expected FIRST:LAST"},
        Code{{"campaign", "--seeds", "1:2x"}, 2, "expected FIRST:LAST"},
        Code{{"campaign", "--seeds", "1:1", "--one", "--solver", "none"}, 2, "'none'"},
        Code{{"campaign", "--seeds", "1:1", "--one", "--solver", solver}, 0, "{\"campaign\":1"},
        Code{{"campaign", "--seeds", "3:3", "--print-scene"}, 0, "# seed 3: "},
        Code{{"campaign", "--share", "2"}, 2, "--share"},
        Code{{"solvers", brace, "--solver", solver, "--repetitions", "1"}, 0, solver.c_str()},
        Code{{"solvers", brace, "--solver", "none"}, 2, "none"},
        Code{{"solvers", std::string(TENDRIL_SCENES) + "/estimate.toml"}, 2, "problem \"estimate\" needs no solver"},
        Code{{"solvers", std::string(TENDRIL_SCENES) + "/grasp_distal_sweep.toml"},
             2,
             "[study] moments are carried out"},
        Code{{"solvers", brace, "--targets-x", "91 mm:99 mm:5"}, 2, "go together"}}) {
    const app::ProcessResult run = app::run_process(TENDRIL_BENCH_COMMAND, code.words, "/", 100.0);
    std::string line;
    for (const std::string& word : code.words) line += word + ' ';
    EXPECT_TRUE(run.started);
    EXPECT_EQ(run.exit_code, code.exit_code) << line << '\n' << run.output;
    EXPECT_NE(run.output.find(code.said), std::string::npos) << line << '\n' << run.output;
  }
}

}  // namespace
}  // namespace tendril::bench
