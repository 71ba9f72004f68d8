// Parts of a study computed apart, and what is said when one of them is not there.

#include <gtest/gtest.h>
#include <sys/file.h>

#include <fstream>

#include "support.hpp"
#include "support/contains.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {
namespace {

using test::expect_same_files;
using test::read_file;
using test::scene_path;
using test::small_study;
using test::TemporaryDirectory;
using test::tendril;

class Shards : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* shard : {"1/3", "2/3", "3/3"}) {
      const test::CommandRun run = tendril({"study", scene_, "--output", out_, "--shard", shard});
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_EQ(run.out, "");
    }
  }
  test::CommandRun merge() const { return tendril({"study", scene_, "--output", out_, "--merge"}); }
  std::string journal(int i) const { return out_ + "/shard-" + std::to_string(i) + "-of-3.journal"; }
  void expect_refused(const std::string& message) const {
    test::expect_refused(merge(), message);
    EXPECT_FALSE(std::filesystem::exists(out_ + "/study.json"));
  }

  TemporaryDirectory directory_;
  std::string scene_ = directory_.write("s.toml", small_study());
  std::string out_ = directory_ / "out";
};

TEST_F(Shards, JoinToTheSameFilesAsTheWhole) {
  EXPECT_EQ(merge().exit_code, 0);
  EXPECT_EQ(tendril({"study", scene_, "--output", directory_ / "whole"}).exit_code, 0);
  expect_same_files(out_, directory_ / "whole");
}

TEST_F(Shards, AreNamedWhenMissing) {
  std::filesystem::remove(journal(2));
  expect_refused("shard 2 of 3: 'shard-2-of-3.journal' is missing");
}

TEST_F(Shards, AreNamedWhenTorn) {
  std::filesystem::resize_file(journal(3), std::filesystem::file_size(journal(3)) - 7);
  expect_refused("shard 3 of 3: 'shard-3-of-3.journal' is torn: its last line is cut off");
  std::filesystem::resize_file(journal(3), 10);
  expect_refused("shard 3 of 3: 'shard-3-of-3.journal' is torn");
  // Run again it is whole again, and only the torn case was computed once more.
  EXPECT_EQ(tendril({"study", scene_, "--output", out_, "--shard", "3/3"}).exit_code, 0);
  EXPECT_EQ(merge().exit_code, 0);
}

TEST_F(Shards, AreNamedWhenIncomplete) {
  const std::string text = read_file(journal(1));
  const std::size_t cut = text.rfind('\n', text.size() - 2) + 1;
  std::filesystem::resize_file(journal(1), cut);
  expect_refused("shard 1 of 3: 'shard-1-of-3.journal' is not complete: 1 cases are missing, the first is number 21");
}

TEST_F(Shards, AreNamedWhenDamaged) {
  std::string text = read_file(journal(1));
  text[text.size() / 2] = text[text.size() / 2] == '1' ? '2' : '1';
  std::ofstream(journal(1), std::ios::binary) << text;
  expect_refused("and it has damaged lines");
}

TEST_F(Shards, OfAnotherSceneAreNamed) {
  directory_.write("s.toml", small_study() + "# changed\n");
  expect_refused("belongs to another study");
}

TEST_F(Shards, OfTwoDivisionsAreNotMixed) {
  EXPECT_EQ(tendril({"study", scene_, "--output", out_, "--shard", "1/2"}).exit_code, 0);
  expect_refused("found shards of 2 and of 3");
}

TEST_F(Shards, AreWrittenByOneProcessAtATime) {
  const int file = ::open(journal(1).c_str(), O_RDWR);
  ASSERT_EQ(::flock(file, LOCK_EX), 0);
  const test::CommandRun run = tendril({"study", scene_, "--output", out_, "--shard", "1/3"});
  ::close(file);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(contains_text(run.err, "another process is writing"));
}

TEST(GnuParallel, RunsShardsSideBySide) {
  const ProcessResult version = run_process("parallel", {"--version"}, ".", 20.0);
  if (!version.started || version.output.find("GNU parallel") == std::string::npos) {
    GTEST_SKIP() << "GNU parallel is not installed (Debian's package parallel)";
  }
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study());
  const std::string out = directory / "out";
  const ProcessResult run = run_process("parallel",
                                        {"--will-cite", "--jobs", "2", TENDRIL_COMMAND, "study", scene, "--output", out,
                                         "--shard", "{}/4", ":::", "1", "2", "3", "4"},
                                        directory.path(), 100.0);
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(tendril({"study", scene, "--output", out, "--merge"}).exit_code, 0);
  EXPECT_EQ(tendril({"study", scene, "--output", directory / "whole"}).exit_code, 0);
  expect_same_files(out, directory / "whole");
}

/// The script in the guide, as Slurm would start its tasks.
TEST(Slurm, RunsShardsAsAnArray) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", small_study());
  const std::string out = directory / "out";
  for (const char* task : {"3", "1", "2"}) {
    const ProcessResult run =
        run_process("env",
                    {std::string("SLURM_ARRAY_TASK_ID=") + task, "SLURM_ARRAY_TASK_COUNT=3", "SLURM_CPUS_PER_TASK=2",
                     std::string("TENDRIL=") + TENDRIL_COMMAND, "bash", TENDRIL_DOCS "/study.slurm", scene, out},
                    directory.path(), 100.0);
    EXPECT_TRUE(run.started);
    EXPECT_EQ(run.exit_code, 0) << run.output;
  }
  EXPECT_EQ(tendril({"study", scene, "--output", out, "--merge"}).exit_code, 0);
  EXPECT_EQ(tendril({"study", scene, "--output", directory / "whole"}).exit_code, 0);
  expect_same_files(out, directory / "whole");
}

}  // namespace
}  // namespace tendril::app
