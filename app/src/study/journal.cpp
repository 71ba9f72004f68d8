#include "study/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <sstream>
#include <system_error>

#include "system/output.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

std::string reason() { return std::generic_category().message(errno); }

std::string head_of(const StudyRecord& record) { return fmt::format("{} {:.6f}", record.index, record.seconds); }

template <class Number>
bool read_number(std::string_view& text, Number& value, int base = 10) {
  const std::size_t end = text.find(' ');
  if (end == std::string_view::npos) return false;
  std::from_chars_result result{};
  if constexpr (std::is_floating_point_v<Number>) {
    result = std::from_chars(text.data(), text.data() + end, value);
  } else {
    result = std::from_chars(text.data(), text.data() + end, value, base);
  }
  if (result.ec != std::errc{} || result.ptr != text.data() + end) return false;
  text.remove_prefix(end + 1);
  return true;
}

}  // namespace

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

std::string record_line(const StudyRecord& record) {
  const std::string head = head_of(record);
  return fmt::format("{} {} {:016x} {}\n", head, record.payload.size(), checksum(head + ' ' + record.payload),
                     record.payload);
}

std::optional<StudyRecord> parse_record(std::string_view line) {
  StudyRecord record;
  std::size_t length = 0;
  std::uint64_t sum = 0;
  if (!read_number(line, record.index) || !read_number(line, record.seconds) || !read_number(line, length) ||
      !read_number(line, sum, 16) || line.size() != length) {
    return std::nullopt;
  }
  record.payload = line;
  if (checksum(head_of(record) + ' ' + record.payload) != sum) return std::nullopt;
  return record;
}

std::string JournalHeader::line() const {
  return fmt::format("tendril study, format 1, scene {:016x}, shard {} of {}, {} cases", fingerprint, shard, shards,
                     cases);
}

std::string journal_name(int shard, int shards) { return fmt::format("shard-{}-of-{}.journal", shard, shards); }

JournalContents read_journal(const std::filesystem::path& path) {
  JournalContents contents;
  std::error_code error;
  contents.exists = std::filesystem::exists(path, error);
  if (!contents.exists) return contents;
  std::ostringstream stream;
  stream << std::ifstream(path, std::ios::binary).rdbuf();
  if (!stream) {
    // An empty file leaves the stream in this state, too.
    if (std::filesystem::file_size(path, error) > 0 || error)
      throw InputError("cannot read '" + path.string() + "': " + reason());
    return contents;
  }
  const std::string text = stream.str();
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    if (begin == 0) {
      contents.header = line;
    } else if (std::optional<StudyRecord> record = parse_record(line)) {
      const int index = record->index;
      contents.records.emplace(index, std::move(*record));
    } else {
      ++contents.damaged_lines;
    }
    begin = end + 1;
  }
  contents.whole_bytes = begin;
  contents.torn = begin < text.size();
  return contents;
}

Journal::Journal(std::filesystem::path path, const JournalHeader& header) : path_(std::move(path)) {
  const std::filesystem::path directory = path_.has_parent_path() ? path_.parent_path() : ".";
  const std::vector<std::filesystem::path> made = missing_directories(directory);
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND, 0666);
  if (file_ < 0) throw InputError("cannot write '" + path_.string() + "': " + reason());
  const auto give_up = [&](const std::string& message) {
    ::close(file_);
    throw InputError(message);
  };
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    give_up("another process is writing '" + path_.string() + "'; wait for it, or choose another --output");
  }
  JournalContents contents = read_journal(path_);
  if (!contents.header.empty() && contents.header != header.line()) {
    give_up("'" + path_.string() + "' belongs to another study (" + contents.header + "), expected \"" + header.line() +
            "\": the scene, its settings or the version changed; choose another --output or remove the file");
  }
  if (contents.torn && ::ftruncate(file_, static_cast<off_t>(contents.whole_bytes)) != 0) {
    give_up("cannot write '" + path_.string() + "': " + reason());
  }
  if (contents.damaged_lines > 0) {
    note(fmt::format("{} damaged lines in '{}'; their cases are computed again", contents.damaged_lines,
                     path_.string()));
  }
  records_ = std::move(contents.records);
  if (contents.header.empty()) {
    try {
      write(header.line() + '\n');
      // Lines that are on disk are of no use in a file whose name is not.
      synchronize(directory);
      synchronize_entries(made);
    } catch (const InputError&) {
      ::close(file_);
      throw;
    }
  }
}

Journal::~Journal() { ::close(file_); }

void Journal::append(StudyRecord record) {
  write(record_line(record));
  const int index = record.index;
  records_.emplace(index, std::move(record));
}

void Journal::write(const std::string& line) {
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t count = ::write(file_, line.data() + done, line.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw InputError("cannot write '" + path_.string() + "': " + reason());
    done += static_cast<std::size_t>(count);
  }
  if (::fdatasync(file_) != 0 && errno != EINVAL)
    throw InputError("cannot write '" + path_.string() + "': " + reason());
}

}  // namespace tendril::app
