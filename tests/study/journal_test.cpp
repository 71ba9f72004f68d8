// The journal of a study, cut at every byte.

#include "study/journal.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "command.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {
namespace {

using test::read_file;
using test::TemporaryDirectory;

TEST(Journal, ChecksumIsFnv1a) {
  // Published values of FNV-1a, 64 bits.
  EXPECT_EQ(checksum(""), 0xcbf29ce484222325ULL);
  EXPECT_EQ(checksum("a"), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(checksum("foobar"), 0x85944171f73967e8ULL);
}

TEST(Journal, LinesComeBack) {
  const StudyRecord record{17, 0.125, "{\"a\": \"b c\"}"};
  std::string line = record_line(record);
  ASSERT_EQ(line.back(), '\n');
  line.pop_back();
  const auto back = parse_record(line);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->index, 17);
  EXPECT_EQ(back->seconds, 0.125);
  EXPECT_EQ(back->payload, record.payload);
}

TEST(Journal, AnyChangedByteIsNoticed) {
  std::string line = record_line({3, 1.5, "{\"status\":\"solved\"}"});
  line.pop_back();
  for (std::size_t i = 0; i < line.size(); ++i) {
    std::string damaged = line;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    EXPECT_FALSE(parse_record(damaged)) << damaged;
    EXPECT_FALSE(parse_record(line.substr(0, i))) << i;
  }
}

TEST(Journal, CutAnywhereLosesOnlyTheLineThatIsCut) {
  const TemporaryDirectory directory;
  const std::string path = directory / "j";
  const JournalHeader header{42, 1, 1, 3};
  {
    Journal journal(path, header);
    for (int i = 0; i < 3; ++i) journal.append({i, 0.5, "{\"value\":" + std::to_string(i) + "}"});
  }
  const std::string whole = read_file(path);
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, length);
    std::size_t kept = 0;
    {
      Journal journal(path, header);
      kept = journal.records().size();
      for (int i = 0; i < 3; ++i) {
        if (!journal.records().contains(i)) journal.append({i, 0.5, "{\"value\":" + std::to_string(i) + "}"});
      }
    }
    const auto lines =
        static_cast<std::size_t>(std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length), '\n'));
    EXPECT_EQ(kept, lines > 0 ? lines - 1 : 0) << length;
    EXPECT_EQ(read_file(path), whole) << length;
  }
}

TEST(Journal, OfAnotherStudyIsRefused) {
  const TemporaryDirectory directory;
  const std::string path = directory / "j";
  { const Journal journal(path, {42, 1, 1, 3}); }
  EXPECT_THROW(Journal(path, {43, 1, 1, 3}), InputError);
  EXPECT_THROW(Journal(path, {42, 1, 2, 3}), InputError);
  EXPECT_THROW(Journal(path, {42, 1, 1, 4}), InputError);
  EXPECT_THROW(Journal(directory / "none/../j/x", {42, 1, 1, 3}), InputError);
}

}  // namespace
}  // namespace tendril::app
