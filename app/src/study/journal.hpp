#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace tendril::app {

/// What one case of a study came to. `payload` is JSON on one line and holds nothing that differs from run to run.
struct StudyRecord {
  int index = 0;
  double seconds = 0.0;
  std::string payload;
};

/// FNV-1a, 64 bits.
std::uint64_t checksum(std::string_view bytes);

/// A record as one line with its length and checksum, ending in a line feed; and back. Null: the line is damaged.
std::string record_line(const StudyRecord& record);
std::optional<StudyRecord> parse_record(std::string_view line);

/// Which study a journal belongs to.
struct JournalHeader {
  std::uint64_t fingerprint = 0;
  int shard = 1;
  int shards = 1;
  int cases = 0;  ///< of the whole study
  std::string line() const;
};

/// A journal as it was found on disk.
struct JournalContents {
  bool exists = false;
  std::string header;  ///< without its line feed; empty: not even that was written
  std::map<int, StudyRecord> records;
  std::uintmax_t whole_bytes = 0;  ///< up to the end of the last line that is whole
  bool torn = false;               ///< something follows that is no whole line
  int damaged_lines = 0;           ///< whole lines whose checksum is wrong
};
/// Throws InputError if the file is there and cannot be read.
JournalContents read_journal(const std::filesystem::path& path);

std::string journal_name(int shard, int shards);

/// An append-only file with a line for each finished case. It survives the end of its writer at any moment: a line is
/// there as a whole or is recognized as torn and cut off when the journal is opened again.
class Journal {
 public:
  /// Opens or creates the journal. Throws InputError if it belongs to another study, if another process is writing it,
  /// or if the disk refuses.
  Journal(std::filesystem::path path, const JournalHeader& header);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Everything recorded so far, by index of the case.
  const std::map<int, StudyRecord>& records() const { return records_; }
  /// Puts a record on disk before it returns. Throws InputError if that fails.
  void append(StudyRecord record);

 private:
  void write(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::map<int, StudyRecord> records_;
};

}  // namespace tendril::app
