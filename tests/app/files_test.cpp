#include "tendril/app/files.hpp"

#include <gtest/gtest.h>

#include "command.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {
namespace {

using test::read_file;
using test::TemporaryDirectory;
using Names = std::vector<std::string>;

TEST(ReadInput, StopsAtFourMebibytes) {
  const TemporaryDirectory directory;
  const std::string most(largest_input, 'a');
  EXPECT_EQ(read_input(directory.write("most", most), "scene").size(), largest_input);
  EXPECT_THROW(read_input(directory.write("more", most + 'a'), "scene"), InputError);
  // A device has no size that could be asked for beforehand.
  EXPECT_THROW(read_input("/dev/zero", "scene"), InputError);
}

TEST(ReadInput, RefusesWhatIsNotAFile) {
  const TemporaryDirectory directory;
  EXPECT_THROW(read_input(directory.path(), "scene"), InputError);
  EXPECT_THROW(read_input(directory / "missing", "scene"), InputError);
  EXPECT_EQ(read_input("/dev/null", "scene"), "");
}

TEST(StagedFiles, AppearOnlyWhenPublished) {
  const TemporaryDirectory directory;
  {
    StagedFiles files(directory.path());
    files.write("a", "1");
    files.write("b", "2");
    EXPECT_FALSE(std::filesystem::exists(directory / "a"));
    files.publish();
  }
  EXPECT_EQ(directory.names(), (Names{"a", "b"}));
  EXPECT_EQ(read_file(directory / "b"), "2");
}

TEST(StagedFiles, ReplaceOlderOnes) {
  const TemporaryDirectory directory;
  directory.write("a", "old and longer");
  StagedFiles files(directory.path());
  files.write("a", "new");
  files.publish();
  EXPECT_EQ(read_file(directory / "a"), "new");
}

TEST(StagedFiles, LeaveNothingBehindIfAbandoned) {
  const TemporaryDirectory directory;
  {
    StagedFiles files(directory.path() / "new" / "deep");
    files.write("a", "1");
  }
  EXPECT_EQ(directory.names(), Names{});
}

TEST(StagedFiles, AreAllRefusedIfOneIs) {
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory / "b");
  {
    StagedFiles files(directory.path());
    files.write("a", "1");
    files.write("b", "2");
    EXPECT_THROW(files.publish(), InputError);
  }
  EXPECT_EQ(directory.names(), Names{"b"});
}

TEST(StagedFiles, NeedADirectoryThatTakesThem) {
  const TemporaryDirectory directory;
  const std::string file = directory.write("file", "");
  EXPECT_THROW(StagedFiles{file}, InputError);
  EXPECT_THROW(StagedFiles{file + "/below"}, InputError);
  // Nobody, not even root, makes files here.
  EXPECT_THROW(StagedFiles{"/proc/self"}, InputError);
  EXPECT_EQ(directory.names(), Names{"file"});
}

}  // namespace
}  // namespace tendril::app
