// What the real command says to input that it cannot use: one message with the place, and exit code 2.

#include <gtest/gtest.h>

#include <algorithm>

#include "command.hpp"
#include "support/contains.hpp"

namespace tendril::app::test {
namespace {

CommandRun plan_brace(std::vector<std::string> more) {
  more.insert(more.begin(), {"plan", scene_path("brace.toml"), "--json"});
  return tendril(more);
}

class BadSceneTest : public testing::TestWithParam<BadScene> {};

TEST_P(BadSceneTest, IsRefusedWithItsPlace) {
  expect_refused(plan_text(brace_with(GetParam().old_text, GetParam().new_text)), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, BadSceneTest,
    testing::Values(
        BadScene{"length =", "lenght =",
                 "s.toml:6:1: found the key 'lenght', which [rod] does not have; did you mean 'length'?"},
        BadScene{"\"100 mm\"", "\"100 N\"", "s.toml:6:10: found \"100 N\", whose unit"},
        BadScene{"\"100 mm\"", "nan", "s.toml:6:10: found the number nan"},
        BadScene{"\"100 mm\"", "\"0 mm\"", "s.toml:6:10: found \"0 mm\", expected a length greater than 0"},
        BadScene{"\"8 mm\"", "\"0 mm\"", "s.toml:24:10: option 'radius'"},
        BadScene{"\"8 mm\"", "\"-8 mm\"", "s.toml:24:10: option 'radius'"},
        BadScene{"\"8 mm\"", "nan", "s.toml:24:10: option 'radius'"},
        BadScene{"\"8 mm\"", "\"8 Nm\"", "s.toml:24:10: option 'radius'"},
        BadScene{"radius", "raduis", "did you mean 'radius'?"}, BadScene{"radius = \"8 mm\"", "", "radius"},
        BadScene{"split_at_contact", "splitat_contact",
                 "s.toml:16:19: found the key 'splitat_contact', which [coordinates] does not have; did you "
                 "mean 'split_at_contact'?"},
        BadScene{"weight = 100", "Weight = 100",
                 "found the key 'Weight', which [objective] does not have; did you mean 'weight'?"},
        BadScene{"radius =", "nam = \"peg\"\nradius =",
                 "found the key 'nam', which [obstacle] does not have; did you mean 'name'?"},
        BadScene{"order = 6", "ordr = 6", "has no option 'ordr' (found ordr = 6); did you mean 'order'?"},
        BadScene{"\"100 mm\"", "1e8", "times EI/L^2, the force that bends the rod"},
        BadScene{"\"circle\"", "\"circel\"", "s.toml:22:9: "},
        BadScene{"\"circle\"", "\"circel\"", "did you mean 'circle'?"},
        BadScene{"[\"60 mm\", \"0 mm\"]", "[\"0 mm\", \"0 mm\"]", "s.toml:2"},
        BadScene{"order = 6", "order = 0", "s.toml:15:9: option 'order'"},
        BadScene{"order = 6", "order = 1000", "s.toml:15:9: option 'order'"},
        BadScene{"order = 6", "order = 6.5", "s.toml:15:9: option 'order'"},
        BadScene{"order = 6", "ordr = 6", "s.toml:15:8: coordinates plugin 'legendre' has no option 'ordr'"},
        BadScene{"\"legendre\"", "\"lgendre\"",
                 "s.toml:14:10: coordinates plugin 'lgendre' was not found; did you mean 'legendre'?"},
        BadScene{"\"" TENDRIL_TEST_SOLVER "\"", "\"" TENDRIL_TEST_SOLVER "x\"",
                 "s.toml:42:10: solver plugin '" TENDRIL_TEST_SOLVER
                 "x' was not found; did you mean '" TENDRIL_TEST_SOLVER "'?"},
        BadScene{"\"tip_pose\"", "\"tip_pos\"",
                 "s.toml:34:10: objective plugin 'tip_pos' was not found; did you mean 'tip_pose'?"},
        BadScene{"\"tip_pose\"", "\"../tip_pose\"", "s.toml:34:10: "},
        BadScene{"limit = \"2.5 N mm\"", "min = 1\nmax = -1", "s.toml:11:7: found min"},
        BadScene{"\"pose\"", "\"grasp\"", "problem \"grasp\" needs a [gripper]"},
        BadScene{"[coordinates]", "[rod.insertion]\nvalue = \"120 mm\"\n[coordinates]",
                 "s.toml:14:9: the rod is 0.1 m long, but 0.12 m of it are to be out of its port"},
        BadScene{"[coordinates]", "[rod.insertion]\nmin = \"90 mm\"\nmax = \"80 mm\"\n[coordinates]",
                 "s.toml:14:7: found min 0.09 m above max 0.08 m"},
        BadScene{"[coordinates]", "[rod.insertion]\nmin = \"90 mm\"\n[coordinates]",
                 "found 'min' alone, expected 'min' and 'max', or 'value' alone"},
        BadScene{"[[rod.actuator]]", "[rod.insertion]\nvalue = \"30 mm\"\n[[rod.actuator]]\nto = \"60 mm\"",
                 "s.toml:12:1: the actuator ends at 0.06 m, inside the port"},
        BadScene{"[coordinates]", "[rod.insertion]\nmin = \"30 mm\"\nmax = \"120 mm\"\n[coordinates]",
                 "s.toml:15:7: the rod is 0.1 m long, but 0.12 m of it are to be out of its port"},
        BadScene{"[coordinates]", "[rod.base]\nangle_range = [1]\n[coordinates]",
                 "s.toml:14:15: found a list of 1 entry, expected two angles"},
        BadScene{"[coordinates]", "[rod.base]\nangle_range = [0.2, 0.1]\n[coordinates]",
                 "s.toml:14:15: the limits contradict each other"},
        BadScene{"[coordinates]",
                 "[rod.base]\nposition = [0, 0]\nposition_range = [[0.01, 0], [0.02, 0]]\n[coordinates]",
                 "s.toml:15:18: the x coordinate of the base, 0 m, lies outside of 0.01 m to 0.02 m"},
        BadScene{"split_at_contact = true",
                 "split_at_contact = false\n[rod.insertion]\nmin = \"60 mm\"\nmax = \"90 mm\"",
                 "a rod whose insertion is chosen has knots that move with it"},
        BadScene{"[target]\nposition = [\"97 mm\", \"20 mm\"]", "", "target"}));

TEST(BadFile, IsRefused) {
  const TemporaryDirectory directory;
  expect_refused(tendril({"plan", directory / "none.toml"}), "none.toml': No such file");
  expect_refused(tendril({"plan", directory.path().string()}), "it is a directory");
  expect_refused(plan_text("hello world"), "s.toml:1:7: this is not TOML");
  expect_refused(plan_text(std::string("a\0b", 3)), "s.toml:1:1: found a zero byte");
  expect_refused(plan_text("# \xff\n"), "s.toml:1:1: found bytes that are not UTF-8");
  expect_refused(plan_text(""), "s.toml:1:1: the scene has no 'rod'");
  expect_refused(tendril({"plan", "/dev/zero"}), "larger than 4 MiB");
}

TEST(BadFile, WithAnOutlineThatCrossesItselfIsNamed) {
  const TemporaryDirectory directory;
  directory.write("part.csv", "x (mm),y (mm)\n60,0\n80,10\n80,0\n60,10\n");
  const std::string scene =
      directory.write("s.toml", brace_with("shape = \"circle\"\ncenter = [\"60 mm\", \"0 mm\"]\nradius = \"8 mm\"",
                                           "shape = \"polygon\"\nrounding = \"1 mm\"\nfile = {name = \"part.csv\"}"));
  expect_refused(tendril({"plan", scene}),
                 "s.toml:24:8: part.csv: option 'vertices' of a polygon: found sides that cross or meet");
}

TEST(BadFile, OfAnySizeIsRefused) {
  expect_refused(plan_text(std::string((std::size_t{4} << 20) + 1, '#')), "larger than 4 MiB");
  // Just below the limit the contents count.
  expect_refused(plan_text(std::string((std::size_t{4} << 20) - 1, '#')), "has no 'rod'");
}

TEST(BadFile, OfAnyDepthIsRefused) {
  std::string key = "a";
  for (int i = 0; i < 500'000; ++i) key += ".a";
  expect_refused(plan_text(key + " = 1"), "nested deeper than 64");
  expect_refused(plan_text('[' + key + ']'), "nested deeper than 64");
  expect_refused(plan_text("a = " + std::string(1'000'000, '[')), "nested deeper than 64");
  expect_refused(plan_brace({"--set", key.substr(0, 100'000) + "=1"}), "--set");
}

CommandRun execute_brace(std::vector<std::string> more) {
  more.insert(more.begin(), {"execute", scene_path("brace.toml"), "--json"});
  return tendril(more);
}

TEST(BadMoments, AreRefused) {
  expect_refused(execute_brace({}), "expected --moments \"M, ...\" or --plan RESULT.json");
  expect_refused(execute_brace({"--moments", ""}), "--moments: found 0 moments, expected one for each");
  expect_refused(execute_brace({"--moments", "1 mm"}),
                 "--moments, number 1: found \"1 mm\", whose unit is not that of a moment");
  expect_refused(execute_brace({"--moments", "1 Nm"}), "did you mean 'N m'?");
  expect_refused(execute_brace({"--moments", "nan"}), "--moments, number 1: found \"nan\", which is not finite");
  expect_refused(execute_brace({"--moments", "1e999"}), "--moments, number 1: found \"1e999\"");
  expect_refused(execute_brace({"--moments", "0, 1"}),
                 "--moments: found 2 moments, expected one for each of the scene's 1 actuators");
  expect_refused(execute_brace({"--moments", "0,"}), "--moments, number 2: found \"\"");
  expect_refused(execute_brace({"--moments", "0", "--plan", "r.json"}), "excludes");
  expect_refused(execute_brace({"--plan", ""}), "--plan: found an empty name");
  expect_refused(execute_brace({"--moments", "0", "--start", ""}), "--start: found an empty name");
  expect_refused(execute_brace({"--moments", "0", "--insertion", "120 mm"}),
                 "found an insertion of 0.12 m, expected more than 0 and at most what there is of the rod (0.1 m)");
  expect_refused(execute_brace({"--moments", "0", "--insertion", "1 N"}), "--insertion: ");
  expect_refused(execute_brace({"--moments", "0", "--base", "0, 0"}),
                 "--base: found 2 numbers, expected three: x, y, angle");
  expect_refused(execute_brace({"--moments", "0; 1", "--insertion", "0.1; 0.09; 0.08"}),
                 "--moments: found 2 way points, expected 3, or one for all");
}

TEST(BadExecution, IsRefused) {
  const TemporaryDirectory directory;
  expect_refused(execute_brace({"--plan", directory / "none.json"}), "cannot open plan");
  expect_refused(execute_brace({"--plan", directory.write("a.json", "{")}), "is not JSON");
  expect_refused(execute_brace({"--moments", "0", "--figure", "f.jpg"}),
                 "expected a name that ends in .svg, .png, .pdf or .html");
  const std::string core = directory.write("core.toml", brace_with("0.5 rad", "0 rad"));
  expect_refused(tendril({"execute", core, "--moments", "0"}),
                 "core.toml:19:13: the start shape runs through the core");
  const std::string other = directory.write("other.toml", brace_with("\"pose\"", "\"execute\""));
  expect_refused(tendril({"plan", other}), "other.toml:2:11: problem \"execute\" cannot be planned here");
}

TEST(BadArguments, AreRefused) {
  expect_refused(tendril({}), "");
  expect_refused(tendril({"plan"}), "SCENE is required");
  expect_refused(tendril({"pln", "x"}), "did you mean 'plan'?");
  expect_refused(plan_brace({"--ordr", "3"}), "did you mean '--order'?");
  expect_refused(plan_brace({"--split", "--no-split"}), "excludes");
  expect_refused(plan_brace({"--set", "contact.max_force"}), "expected KEY=VALUE");
  expect_refused(plan_brace({"--figure", "x.gif"}), "expected a name that ends in .svg, .png, .pdf or .html");
  expect_refused(plan_brace({"--figure", ""}), "empty name");
}

TEST(BadSettings, AreRefusedLikeTheFile) {
  expect_refused(plan_brace({"--set", "contact.max_force=0.5 Nm"}), "--set contact.max_force=0.5 Nm: found \"0.5 Nm\"");
  expect_refused(plan_brace({"--set", "contact.max_forc=1"}), "--set contact.max_forc=1: found the key 'max_forc'");
  expect_refused(plan_brace({"--set", "rod.actuator.1.limit=1"}), "--set rod.actuator.1.limit=1: ");
  expect_refused(plan_brace({"--set", "rod.length=nan"}), "--set rod.length=nan: ");
  expect_refused(plan_brace({"--set", "obstacle.0.radius=0"}), "--set obstacle.0.radius=0: option 'radius'");
  expect_refused(plan_brace({"--set", "solver.options.no_such_option=1"}), "--set solver.options.no_such_option=1: ");
  expect_refused(plan_brace({"--order", "0"}), "--order 0: option 'order'");
  expect_refused(plan_brace({"--order", "1000"}), "--order 1000: option 'order'");
  expect_refused(plan_brace({"--order", "many"}), "--order many: option 'order'");
  expect_refused(plan_brace({"--coordinates", "pcc", "--order", "3"}),
                 "--order 3: coordinates plugin 'pcc' has no option 'order'");
  expect_refused(plan_brace({"--coordinates", "psc", "--pieces", "0"}), "--pieces 0: ");
  expect_refused(plan_brace({"--coordinates", "lgendre"}), "--coordinates lgendre: ");
  expect_refused(plan_brace({"--solver", "nlpt"}), "--solver nlpt: ");
}

TEST(BadStart, IsRefused) {
  const TemporaryDirectory directory;
  expect_refused(plan_brace({"--start", directory / "none.json"}), "none.json': No such file");
  expect_refused(plan_brace({"--start", directory.write("r.json", "{")}), "is not JSON");
  expect_refused(plan_brace({"--start", directory.write("r.json", "{}")}), "schema");
  expect_refused(plan_brace({"--start", directory.write("r.json", R"({"schema": 1, "coordinates": []})")}),
                 "coordinates");
  expect_refused(plan_brace({"--start", "/dev/zero"}), "larger than 4 MiB");
}

TEST(BadPlugin, WithoutItsLibraryIsToldFromAMissingOne) {
  const CommandRun run = plan_brace({"--plugin-dir", TENDRIL_TEST_PLUGINS, "--solver", "incomplete"});
  expect_refused(run, "--solver incomplete: ");
  EXPECT_TRUE(contains_text(run.err, "libtendril-test-absent.so"));
  EXPECT_FALSE(contains_text(run.err, "was not found; did you mean"));
}

TEST(BadPlugin, IsListedWithTheReason) {
  const CommandRun run = tendril({"plugins", "--plugin-dir", TENDRIL_TEST_PLUGINS});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(contains_text(run.out, "NOT LOADABLE"));
  EXPECT_TRUE(contains_text(run.out, "libtendril-test-absent.so"));
  EXPECT_TRUE(contains_text(run.out, "coordinates legendre"));
}

TEST(BadText, DoesNotSteerTheTerminal) {
  const CommandRun run = plan_text("\"\\u001b[31mkey\" = 1\n[rod]\nlength = 1\nbending_stiffness = 1\n");
  expect_refused(run, "found the key '?[31mkey'");
  EXPECT_FALSE(contains_text(run.err, "\x1b"));
}

TEST(EndlessSolver, IsEndedByTheWatchdog) {
  const TemporaryDirectory directory;
  const CommandRun run = plan_brace({"--plugin-dir", TENDRIL_TEST_PLUGINS, "--solver", "endless", "--set",
                                     "solver.time_limit=0.1 s", "--output", directory / "out"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(contains_text(run.err, "solver 'endless' did not return"));
  EXPECT_EQ(directory.names(), std::vector<std::string>{});
}

}  // namespace
}  // namespace tendril::app::test
