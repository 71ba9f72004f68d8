#include "tendril/plugins/probe.hpp"

#include "support.hpp"

namespace tendril::plugins {
namespace {

TEST(Probe, APluginThatWorksIsLoadable) {
  const ProbeResult result = probe(fixture_file("fine"));
  EXPECT_TRUE(result.loadable) << result.problem;
}

TEST(Probe, ItsOutputDoesNotDisturb) {
  const ProbeResult result = probe(fixture_file("prints_at_load"));
  EXPECT_TRUE(result.loadable) << result.problem;
}

TEST(Probe, SurvivesAnAbort) {
  const ProbeResult result = probe(fixture_file("aborts_at_load"));
  EXPECT_FALSE(result.loadable);
  expect_says(result.problem, {"ended the program while being loaded", "Abort"});
}

TEST(Probe, SurvivesAnException) {
  // It leaves the loader or ends the program; both are told.
  EXPECT_FALSE(probe(fixture_file("throws_at_load")).loadable);
}

TEST(Probe, SurvivesAnExit) {
  const ProbeResult result = probe(fixture_file("exits_at_load"));
  EXPECT_FALSE(result.loadable);
  expect_says(result.problem, {"ended the program while being loaded", "exit code 7"});
}

TEST(Probe, DoesNotWaitForEver) {
  const ProbeResult result = probe(fixture_file("hangs_at_load"), std::chrono::milliseconds(300));
  EXPECT_FALSE(result.loadable);
  expect_says(result.problem, {"did not finish loading within 300 ms"});
}

TEST(Probe, TellsWhyAPluginIsRefused) {
  expect_says(probe(fixture_file("other_interface")).problem, {"interface version: 999"});
  expect_says(probe(fixture_file("needs_library")).problem, {"libfixture-helper.so is missing"});
  expect_says(probe(fixture_directory("nowhere") / "tendril-objective-x.so").problem, {"cannot be read"});
}

TEST(Probe, AProgramThatIsNotThereIsAnError) {
  EXPECT_THROW(probe(fixture_file("fine"), std::chrono::seconds(1), "/nonexistent/program"), Error);
}

TEST(AnswerProbe, AnswersOnlyProbes) {
  const char* const plain[] = {"tendril", "plan", "scene.toml"};
  EXPECT_FALSE(answer_probe(3, plain).has_value());
  EXPECT_FALSE(answer_probe(1, plain).has_value());
}

}  // namespace
}  // namespace tendril::plugins
