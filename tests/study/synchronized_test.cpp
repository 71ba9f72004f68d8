// What is put on disk, and in which order: seen by this program's own fsync() and fdatasync(), which take a note and go
// on to the kernel.

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

#include "command.hpp"
#include "study/journal.hpp"
#include "tendril/app/files.hpp"

namespace {

namespace fs = std::filesystem;

/// A file or directory that was put on disk, and what was in the directory then.
struct Note {
  fs::path path;
  std::vector<std::string> names;
};
std::vector<Note> notes;

int noted(int file, long call) {
  Note note{fs::read_symlink("/proc/self/fd/" + std::to_string(file)), {}};
  std::error_code none;
  if (fs::is_directory(note.path, none)) {
    for (const auto& entry : fs::directory_iterator(note.path)) note.names.push_back(entry.path().filename().string());
  }
  notes.push_back(std::move(note));
  return static_cast<int>(::syscall(call, file));
}

}  // namespace

extern "C" int fsync(int file) { return noted(file, SYS_fsync); }
extern "C" int fdatasync(int file) { return noted(file, SYS_fdatasync); }

namespace tendril::app {
namespace {

using test::TemporaryDirectory;

/// Place of the first note of `path` that was taken when `name` was in it; the number of notes if there is none.
std::size_t place_of(const fs::path& path, const std::string& name = "") {
  const auto found = std::find_if(notes.begin(), notes.end(), [&](const Note& note) {
    return note.path == path && (name.empty() || std::count(note.names.begin(), note.names.end(), name) == 1);
  });
  return static_cast<std::size_t>(found - notes.begin());
}

TEST(OnDisk, IsANewJournalWithTheNamesThatLeadToIt) {
  const TemporaryDirectory directory;
  const fs::path root = fs::canonical(directory.path());
  const JournalHeader header{42, 1, 1, 3};
  notes.clear();
  {
    Journal journal(root / "new/deep/j", header);
    EXPECT_LT(place_of(root / "new/deep/j"), notes.size());
    EXPECT_LT(place_of(root / "new/deep", "j"), notes.size());
    EXPECT_LT(place_of(root / "new", "deep"), notes.size());
    EXPECT_LT(place_of(root, "new"), notes.size());
    notes.clear();
    for (int i = 0; i < 3; ++i) {
      journal.append({i, 0.5, "{}"});
      // A record is on disk before append() returns.
      ASSERT_EQ(notes.size(), static_cast<std::size_t>(i) + 1);
      EXPECT_EQ(notes.back().path, root / "new/deep/j");
    }
  }
  // Where only the journal is new, its directory is what holds a new name.
  notes.clear();
  const Journal second(root / "new/deep/k", header);
  EXPECT_LT(place_of(root / "new/deep", "k"), notes.size());
  EXPECT_EQ(place_of(root), notes.size());
}

TEST(OnDisk, AreResultsBeforeTheyAppearAndTheirNamesAfter) {
  const TemporaryDirectory directory;
  const fs::path root = fs::canonical(directory.path());
  notes.clear();
  StagedFiles files(root / "new/out");
  files.write("a", "1");
  files.write("b", "2");
  const fs::path staging = fs::canonical(files.staging());
  files.publish();
  const std::size_t names = place_of(root / "new/out", "b");
  ASSERT_LT(names, notes.size());
  EXPECT_EQ(place_of(root / "new/out", "a"), names);
  EXPECT_LT(place_of(staging / "a"), names);
  EXPECT_LT(place_of(staging / "b"), names);
  EXPECT_LT(place_of(root / "new", "out"), notes.size());
  EXPECT_LT(place_of(root, "new"), notes.size());
}

}  // namespace
}  // namespace tendril::app
