#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace tendril::app {

/// The largest body whose section is taken; it is read piece by piece.
inline constexpr std::size_t largest_body = std::size_t{256} << 20;

/// A file that is read piece by piece. `what` ("scene", ...) names it in messages. Throws InputError if it is missing,
/// a directory, unreadable, or larger than `largest`.
class InputFile {
 public:
  InputFile(const std::filesystem::path& path, const std::string& what, std::size_t largest);
  /// What is open already.
  InputFile(int descriptor, std::string name, std::size_t largest);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  /// Its bytes; not known of a device.
  std::optional<std::size_t> size() const { return size_; }
  /// Fills `room` with what comes next, and says how much that is: less only at the end.
  std::size_t read(std::span<char> room);
  /// All that is left.
  std::string rest();

 private:
  std::string name_;
  std::size_t largest_;
  std::size_t done_ = 0;
  int descriptor_;
  std::optional<std::size_t> size_;
};

}  // namespace tendril::app
