#include "support.hpp"

#include <gtest/gtest.h>

#include "support/contains.hpp"

namespace tendril::app::test {

std::string replaced(std::string text, const std::string& old_text, const std::string& new_text) {
  const auto at = text.find(old_text);
  EXPECT_TRUE(contains_text(text, old_text));
  return at == std::string::npos ? text : text.replace(at, old_text.size(), new_text);
}

std::string small_study() {
  const std::string text = read_file(scene_path("paradigms.toml"));
  const std::size_t begin = text.find("targets = {");
  EXPECT_TRUE(contains_text(text, "targets = {"));
  const std::string line = text.substr(begin, text.find('\n', begin) - begin);
  return replaced(replaced(text, line, "targets = [[0.092, 0.008], [0.095, 0.016], [0.097, 0.02], [0.099, 0.024]]"),
                  "modes = [\"ignore\", \"ignore_then_execute\",", "modes = [\"ignore\",");
}

const std::vector<std::string>& final_files() {
  static const std::vector<std::string> names{"study.json", "cases.csv",  "groups.csv",     "table.txt",
                                              "figure.dat", "figure.svg", "figure.gnuplot", "figure.png"};
  return names;
}

void expect_same_files(const std::string& a, const std::string& b) {
  for (const std::string& name : final_files()) {
    const std::string content = read_file(a + '/' + name);
    EXPECT_FALSE(content.empty()) << name;
    EXPECT_TRUE(content == read_file(b + '/' + name)) << name << " differs between " << a << " and " << b;
  }
}

}  // namespace tendril::app::test
