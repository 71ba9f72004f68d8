#pragma once

#include <filesystem>
#include <string>

#include "common/section.hpp"

namespace tendril::bench {

/// This report beside an earlier one: machines, commits, ranking, counts, times. `now` is the text of a report.json;
/// `earlier` the directory of the other report. Throws InputError if that is none.
Section against_section(const std::string& now, const std::filesystem::path& earlier);

}  // namespace tendril::bench
