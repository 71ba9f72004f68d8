#include "tendril/app/files.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <system_error>
#include <utility>

#include "system/input_file.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace fs = std::filesystem;

namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// Closes a file descriptor when it goes.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  bool valid() const { return number_ >= 0; }

 private:
  int number_;
};

std::string too_large(std::size_t largest) {
  return " is larger than " + std::to_string(largest >> 20U) + " MiB, the most that is read";
}

/// Tells a process where the standard input of the one that started it stands.
constexpr const char* shared_input = "TENDRIL_STANDARD_INPUT";

}  // namespace

void synchronize(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  // Who may write into a directory may still be kept from reading it, and some file systems cannot synchronize one;
  // then there is nothing to wait for.
  if (!file.valid() && errno == EACCES) return;
  if (!file.valid() || (::fsync(file.get()) != 0 && errno != EINVAL)) {
    throw InputError("cannot write '" + path.string() + "': " + reason(errno));
  }
}

std::vector<fs::path> missing_directories(const fs::path& directory) {
  std::vector<fs::path> missing;
  std::error_code error;
  for (fs::path path = directory; !path.empty() && !fs::exists(path, error); path = path.parent_path()) {
    missing.insert(missing.begin(), path);
    if (path == path.parent_path()) break;
  }
  return missing;
}

void synchronize_entries(const std::vector<fs::path>& made) {
  for (const fs::path& path : made) synchronize(path.has_parent_path() ? path.parent_path() : fs::path("."));
}

// Opening a pipe would wait for somebody to write into it.
InputFile::InputFile(const fs::path& path, const std::string& what, std::size_t largest)
    : InputFile(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), what + " '" + path.string() + "'", largest) {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) throw InputError("cannot read " + name_ + ": " + reason(errno));
  if (S_ISDIR(status.st_mode)) throw InputError("cannot read " + name_ + ": it is a directory, expected a file");
  if (S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode)) {
    throw InputError("cannot read " + name_ + ": it is a pipe, expected a file");
  }
  if (!S_ISREG(status.st_mode)) return;
  size_ = static_cast<std::size_t>(status.st_size);
  if (*size_ > largest) throw InputError(name_ + too_large(largest));
}

InputFile::InputFile(int descriptor, std::string name, std::size_t largest)
    : name_(std::move(name)), largest_(largest), descriptor_(descriptor) {
  if (descriptor_ < 0) throw InputError("cannot open " + name_ + ": " + reason(errno));
}

InputFile::~InputFile() { ::close(descriptor_); }

std::size_t InputFile::read(std::span<char> room) {
  std::size_t count = 0;
  while (count < room.size()) {
    const ssize_t more = ::read(descriptor_, room.data() + count, room.size() - count);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) throw InputError("cannot read " + name_ + ": " + reason(errno));
    if (more == 0) break;
    count += static_cast<std::size_t>(more);
  }
  // The size of a device or a pipe is not known beforehand.
  done_ += count;
  if (done_ > largest_) throw InputError(name_ + too_large(largest_));
  return count;
}

std::string InputFile::rest() {
  std::string text;
  std::string block(std::size_t{1} << 16, '\0');
  while (const std::size_t count = read(block)) text.append(block, 0, count);
  return text;
}

std::string read_input(const fs::path& path, const std::string& what, std::size_t largest) {
  return InputFile(path, what, largest).rest();
}

std::string read_scene_input(const fs::path& path) {
  if (path != standard_input) return read_input(path, "scene");
  static std::optional<std::string> text;
  if (text) return *text;
  const char* shared = std::getenv(shared_input);  // NOLINT(concurrency-mt-unsafe): before any thread
  text = shared != nullptr ? read_input(shared, "scene")
                           : InputFile(::dup(STDIN_FILENO), "the scene on standard input", largest_input).rest();
  return *text;
}

void share_standard_input() {
  const std::string text = read_scene_input(standard_input);
  const int file = ::memfd_create("tendril-scene", 0);
  bool good = file >= 0;
  for (std::size_t done = 0; good && done < text.size();) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    good = count > 0;
    if (good) done += static_cast<std::size_t>(count);
  }
  if (!good) throw InputError("cannot hand on the scene of standard input: " + reason(errno));
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  ::setenv(shared_input, path.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): before any thread
}

void require_text(const std::string& text, const fs::path& path) {
  std::size_t line = 1;
  const auto refuse = [&](const std::string& found) {
    throw InputError(path.string() + ':' + std::to_string(line) + ":1: found " + found + ", expected UTF-8 text");
  };
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if (lead == '\n') ++line;
    if (lead == 0) refuse("a zero byte (a binary file?)");
    std::size_t length = 1;
    if (lead >= 0x80)
      length = lead >= 0xc2 && lead < 0xe0 ? 2 : lead >= 0xe0 && lead < 0xf0 ? 3 : lead >= 0xf0 && lead < 0xf5 ? 4 : 0;
    bool good = length > 0 && i + length <= text.size();
    for (std::size_t k = 1; good && k < length; ++k) good = (static_cast<unsigned char>(text[i + k]) & 0xc0U) == 0x80U;
    if (good && length > 2) {
      const auto second = static_cast<unsigned char>(text[i + 1]);
      // Overlong forms, surrogates, and code points that do not exist.
      if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second >= 0xa0) || (lead == 0xf0 && second < 0x90) ||
          (lead == 0xf4 && second >= 0x90)) {
        good = false;
      }
    }
    if (!good) refuse("bytes that are not UTF-8");
    i += length;
  }
}

StagedFiles::StagedFiles(fs::path directory) : directory_(std::move(directory)) {
  if (directory_.empty()) directory_ = ".";
  made_ = missing_directories(directory_);
  std::error_code error;
  fs::create_directories(directory_, error);
  if (!error && !fs::is_directory(directory_, error)) error = std::make_error_code(std::errc::not_a_directory);
  if (error) {
    for (auto path = made_.rbegin(); path != made_.rend(); ++path) ::rmdir(path->c_str());
    throw InputError("cannot write into '" + directory_.string() + "': " + error.message());
  }
  std::string pattern = (directory_ / ".tendril-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) {
    const int number = errno;
    for (auto path = made_.rbegin(); path != made_.rend(); ++path) ::rmdir(path->c_str());
    throw InputError("cannot write into '" + directory_.string() + "': " + reason(number));
  }
  staging_ = pattern;
}

StagedFiles::~StagedFiles() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (published_) return;
  // rmdir removes empty directories only, so nothing that somebody else put there is lost.
  for (auto path = made_.rbegin(); path != made_.rend(); ++path) ::rmdir(path->c_str());
}

void StagedFiles::write(const std::string& name, const std::string& content) {
  write_aside(name, content);
  names_.push_back(name);
}

void StagedFiles::write_aside(const std::string& name, const std::string& content) {
  const fs::path path = staging_ / name;
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  bool good = file.valid();
  for (std::size_t done = 0; good && done < content.size();) {
    const ssize_t count = ::write(file.get(), content.data() + done, content.size() - done);
    if (count < 0 && errno == EINTR) continue;
    good = count > 0;
    if (good) done += static_cast<std::size_t>(count);
  }
  if (!good) throw InputError("cannot write '" + (directory_ / name).string() + "': " + reason(errno));
}

void StagedFiles::adopt(const std::string& name) { names_.push_back(name); }

void StagedFiles::publish() {
  for (const std::string& name : names_) synchronize(staging_ / name);
  std::vector<std::string> moved;
  for (const std::string& name : names_) {
    std::error_code error;
    // A directory in the way would make the last of several renames fail; look before the first.
    if (fs::is_directory(directory_ / name, error)) {
      throw InputError("cannot write '" + (directory_ / name).string() + "': it is a directory");
    }
  }
  for (const std::string& name : names_) {
    std::error_code error;
    fs::rename(staging_ / name, directory_ / name, error);
    if (error) {
      for (const std::string& other : moved) fs::remove(directory_ / other, error);
      throw InputError("cannot write '" + (directory_ / name).string() + "': " + error.message());
    }
    moved.push_back(name);
  }
  synchronize(directory_);
  synchronize_entries(made_);
  published_ = true;
}

}  // namespace tendril::app
