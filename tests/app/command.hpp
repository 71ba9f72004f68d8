#pragma once

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tendril::app::test {

/// How one run of the real command ended.
struct CommandRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs `tendril` with these arguments.
CommandRun tendril(const std::vector<std::string>& arguments);

/// A directory of its own that is removed at the end.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& content) const;
  /// Names of everything inside, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

std::string read_file(const std::filesystem::path& path);
/// The command refused its input: exit code 2, nothing on standard output, and one message that holds `part`.
void expect_refused(const CommandRun& run, const std::string& part);
/// `tendril plan --json` for a scene with this text, and more arguments.
CommandRun plan_text(const std::string& text, std::vector<std::string> more = {});
std::string scene_path(const std::string& name);
/// What the command writes with these arguments and --json; fails the test unless it ends with `exit_code`.
nlohmann::json json_of(std::vector<std::string> arguments, int exit_code = 0);
/// A scene of scenes/ with one piece of text replaced; fails the test if it does not occur exactly once.
std::string scene_with(const std::string& scene, const std::string& old_text, const std::string& new_text);
/// scenes/brace.toml, likewise.
std::string brace_with(const std::string& old_text, const std::string& new_text);

/// A piece of text in a scene, what takes its place, and what is then said of it.
struct BadScene {
  const char* old_text;
  const char* new_text;
  const char* message;  ///< part of it, place included
};
void PrintTo(const BadScene& scene, std::ostream* out);

}  // namespace tendril::app::test
