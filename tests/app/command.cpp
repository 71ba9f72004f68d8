#include "command.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/contains.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app::test {

namespace {

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

CommandRun tendril(const std::vector<std::string>& arguments) {
  const TemporaryDirectory directory;
  std::string line = quoted(TENDRIL_COMMAND);
  for (const std::string& argument : arguments) line += ' ' + quoted(argument);
  line += " >" + quoted(directory / "out") + " 2>" + quoted(directory / "err");
  // A run that hangs must fail its test and not the whole suite.
  const ProcessResult result = run_process("/bin/sh", {"-c", line}, std::filesystem::current_path(), 120.0);
  EXPECT_TRUE(result.started);
  EXPECT_FALSE(result.timed_out);
  return {result.exit_code, read_file(directory / "out"), read_file(directory / "err")};
}

TemporaryDirectory::TemporaryDirectory() {
  std::string pattern = (std::filesystem::temp_directory_path() / "tendril-test-XXXXXX").string();
  EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
  path_ = pattern;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryDirectory::write(const std::string& name, const std::string& content) const {
  const std::string file = *this / name;
  std::ofstream(file, std::ios::binary) << content;
  return file;
}

std::vector<std::string> TemporaryDirectory::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string read_file(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void expect_refused(const CommandRun& run, const std::string& part) {
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err.rfind("tendril: ", 0), 0U) << run.err;
  EXPECT_TRUE(contains_text(run.err, part));
  EXPECT_FALSE(contains_text(run.err, "internal error"));
}

CommandRun plan_text(const std::string& text, std::vector<std::string> more) {
  const TemporaryDirectory directory;
  more.insert(more.begin(), {"plan", directory.write("s.toml", text), "--json"});
  return tendril(more);
}

std::string scene_path(const std::string& name) { return std::string(TENDRIL_SCENES "/") + name; }

nlohmann::json json_of(std::vector<std::string> arguments, int exit_code) {
  arguments.emplace_back("--json");
  const CommandRun run = tendril(arguments);
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  return nlohmann::json::parse(run.out, nullptr, false);
}

std::string scene_with(const std::string& scene, const std::string& old_text, const std::string& new_text) {
  std::string text = read_file(scene_path(scene));
  const auto at = text.find(old_text);
  EXPECT_TRUE(contains_text(text, old_text));
  if (at == std::string::npos) return text;
  EXPECT_FALSE(contains_text(text.substr(at + 1), old_text)) << "more than once";
  return text.replace(at, old_text.size(), new_text);
}

std::string brace_with(const std::string& old_text, const std::string& new_text) {
  return scene_with("brace.toml", old_text, new_text);
}

void PrintTo(const BadScene& scene, std::ostream* out) { *out << scene.new_text; }

}  // namespace tendril::app::test
