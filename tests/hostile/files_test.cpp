// Files that are no scenes or results, and places that take none.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "../app/command.hpp"
#include "support/contains.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {
namespace {

using test::brace_with;
using test::CommandRun;
using test::expect_refused;
using test::scene_path;
using test::TemporaryDirectory;
using test::tendril;

TEST(HostileFile, OfAGigabyteIsRefusedUnread) {
  const TemporaryDirectory directory;
  const std::string file = directory.write("s.toml", "");
  std::filesystem::resize_file(file, std::uintmax_t{1} << 30);
  expect_refused(tendril({"describe", file}), "larger than 4 MiB");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", file}), "larger than 4 MiB");
}

TEST(HostileFile, ThatIsAPipeIsRefusedAtOnce) {
  const TemporaryDirectory directory;
  const std::string pipe = directory / "pipe.toml";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_refused(tendril({"describe", pipe}), "it is a pipe, expected a file");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", pipe}), "it is a pipe, expected a file");
}

TEST(HostileFile, BehindALinkIsReadAndALoopIsRefused) {
  const TemporaryDirectory directory;
  std::filesystem::create_symlink(scene_path("free.toml"), directory / "link.toml");
  EXPECT_EQ(tendril({"describe", directory / "link.toml"}).exit_code, 0);
  std::filesystem::create_symlink(directory / "b.toml", directory / "a.toml");
  std::filesystem::create_symlink(directory / "a.toml", directory / "b.toml");
  expect_refused(tendril({"describe", directory / "a.toml"}), "cannot open scene");
}

TEST(HostileFile, OfAnotherKindIsRefused) {
  expect_refused(tendril({"describe", TENDRIL_COMMAND}), "");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", TENDRIL_COMMAND}), "");
}

TEST(HostileFile, NestedFiftyThousandDeepIsRefused) {
  const TemporaryDirectory directory;
  const std::string deep(50'000, '[');
  expect_refused(tendril({"describe", directory.write("s.toml", "a = " + deep)}), "nested deeper than 64");
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", directory.write("r.json", deep)}),
                 "is not JSON");
  const std::string closed = deep + std::string(50'000, ']');
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", directory.write("c.json", closed)}), "schema");
  std::string objects;
  for (int i = 0; i < 50'000; ++i) objects += "{\"schema\":";
  objects += '1' + std::string(50'000, '}');
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--start", directory.write("o.json", objects)}), "schema");
}

TEST(HostileOutput, OnAFullDeviceIsAnError) {
  const TemporaryDirectory directory;
  const std::string line = std::string(TENDRIL_COMMAND) + " plan '" + scene_path("brace.toml") +
                           "' --json >/dev/full 2>'" + (directory / "err") + "'";
  const ProcessResult run = run_process("/bin/sh", {"-c", line}, directory.path(), 60.0);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(test::read_file(directory / "err"), "cannot write to standard output"));
}

// A limit of the size of files stands for a full disk; it needs no mount.
TEST(HostileOutput, ThatDoesNotFitLeavesNothing) {
  const TemporaryDirectory directory;
  const std::string line = "trap '' XFSZ; ulimit -f 4; '" + std::string(TENDRIL_COMMAND) + "' plan '" +
                           scene_path("brace.toml") + "' --output '" + (directory / "out") + "' >/dev/null";
  const ProcessResult run = run_process("/bin/sh", {"-c", line}, directory.path(), 60.0);
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_TRUE(contains_text(run.output, "cannot write"));
  EXPECT_EQ(directory.names(), std::vector<std::string>{});
}

TEST(HostileOutput, IntoADirectoryThatTakesNothingIsRefused) {
  // Root writes everywhere else.
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--output", "/proc/self/fdinfo"}), "cannot write into");
  if (::geteuid() == 0) return;
  const TemporaryDirectory directory;
  ASSERT_EQ(::chmod(directory.path().c_str(), 0500), 0);
  expect_refused(tendril({"plan", scene_path("brace.toml"), "--output", directory.path().string()}),
                 "cannot write into");
}

// Text of a scene that a shell, gnuplot or a page could take for its own.
TEST(HostileText, IsTextEverywhere) {
  const TemporaryDirectory directory;
  const std::string witness = directory / "witness";
  const std::string text = "`touch " + witness + "`'; system('touch " + witness + "') #\\\"$(touch " + witness + ")";
  std::string scene = brace_with("Brace on a peg", text);
  scene.replace(scene.find("shape = \"circle\""), 0, "name = \"" + text + "\"\n");
  const CommandRun run = tendril({"plan", directory.write("s.toml", scene), "--json", "--output", directory / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(std::filesystem::exists(witness));
  EXPECT_TRUE(std::filesystem::exists(directory.path() / "out" / "figure.svg"));
}

}  // namespace
}  // namespace tendril::app
