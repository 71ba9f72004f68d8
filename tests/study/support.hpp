#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"

namespace tendril::app::test {

/// scenes/paradigms.toml with two limits, three modes and four targets: 24 cases.
std::string small_study();
/// `text` with one piece replaced; fails the test if it does not occur.
std::string replaced(std::string text, const std::string& old_text, const std::string& new_text);
/// Names of the final files of a study that are the same whenever its results are.
const std::vector<std::string>& final_files();
/// All final files of two output directories are the same, byte for byte.
void expect_same_files(const std::string& a, const std::string& b);

}  // namespace tendril::app::test
