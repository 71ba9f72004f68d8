#pragma once

#include <gtest/gtest.h>

#include <string_view>

namespace tendril {

/// Whether `part` stands in `text`; either way the result says both.
inline testing::AssertionResult contains_text(std::string_view text, std::string_view part) {
  const bool found = text.find(part) != std::string_view::npos;
  testing::AssertionResult result = found ? testing::AssertionSuccess() : testing::AssertionFailure();
  return result << "'" << text << "' " << (found ? "contains" : "does not contain") << " '" << part << "'";
}

}  // namespace tendril
