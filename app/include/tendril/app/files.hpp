#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tendril::app {

/// No scene, and no result that is read as a start, may be larger than this.
inline constexpr std::size_t largest_input = std::size_t{4} << 20;

/// The largest result that is shown: studies hold all their plans.
inline constexpr std::size_t largest_result = std::size_t{256} << 20;

/// The bytes of the file at `path`, at most `largest` of them. `what` ("scene", ...) names the file in messages.
/// Throws InputError if it is missing, a directory, unreadable, or too large.
std::string read_input(const std::filesystem::path& path, const std::string& what, std::size_t largest = largest_input);

/// A scene named so is read from standard input; files that it names are then looked for in the current directory.
inline constexpr const char* standard_input = "-";

/// The text of a scene: of the file at `path`, or of standard input, which is read once and then remembered. Throws
/// InputError as read_input() does.
std::string read_scene_input(const std::filesystem::path& path);

/// Lets processes that this one starts read the same standard input as their scene.
void share_standard_input();

/// Throws InputError if `text` holds a NUL byte or is not UTF-8, naming the line.
void require_text(const std::string& text, const std::filesystem::path& path);

/// Puts the bytes of a file, or the names that a directory holds, on disk before it returns. Throws InputError if the
/// disk refuses.
void synchronize(const std::filesystem::path& path);

/// `directory` and those above it that do not exist, outermost first.
std::vector<std::filesystem::path> missing_directories(const std::filesystem::path& directory);

/// Puts the names of directories that were made on disk: each is an entry of the one above it.
void synchronize_entries(const std::vector<std::filesystem::path>& made);

/// A set of files that appear in a directory all together, each of them whole, or not at all.
///
/// They are collected in a private directory beside their destination and moved by publish(). Whatever was not
/// published is removed by the destructor, also a destination directory that was made for it.
class StagedFiles {
 public:
  /// Makes `directory` if it does not exist. Throws InputError if nothing can be written there.
  explicit StagedFiles(std::filesystem::path directory);
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  /// Where files are collected; programs such as gnuplot run here.
  const std::filesystem::path& staging() const { return staging_; }
  /// Writes one file. `name` is a plain file name. Throws InputError if the disk refuses.
  void write(const std::string& name, const std::string& content);
  /// Writes one that other programs read in staging() and that stays there.
  void write_aside(const std::string& name, const std::string& content);
  /// Takes in a file that another program has written into staging().
  void adopt(const std::string& name);
  /// Puts everything on disk and moves it to its place. Throws InputError and leaves nothing behind if that fails.
  void publish();

 private:
  std::filesystem::path directory_;
  std::filesystem::path staging_;
  std::vector<std::filesystem::path> made_;  ///< directories that did not exist, outermost first
  std::vector<std::string> names_;
  bool published_ = false;
};

}  // namespace tendril::app
