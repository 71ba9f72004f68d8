#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tendril::app {

// Text in lines and cells, as spreadsheets and cameras write tables.

/// A line that says something.
struct TextLine {
  std::string_view text;
  int number = 0;
  std::size_t first_column = 1;  ///< of `text` in the file
};

/// What stands between two separators, without quotes, and the column where it begins.
struct TextCell {
  std::string text;
  std::size_t column = 1;
};

/// Those lines of a text that are not blank. They end as Unix, Windows or old Macintosh programs end them.
std::vector<TextLine> lines_of(std::string_view text);

/// Semicolon, tab, comma or blank: what stands between the values of a line.
char separator_of(const TextLine& line);

/// Cells of a line. Blanks separate as runs; a unit in brackets stays with the name before it.
std::vector<TextCell> cells_of(const TextLine& line, char separator);

/// The number that a text begins with, and what follows it; no number: nothing, and all of the text. A comma is the
/// decimal sign if `comma`. The number may be infinite.
std::pair<std::optional<double>, std::string_view> leading_number(std::string_view text, bool comma);

/// The whole text as a number.
std::optional<double> number_in(std::string_view text, bool comma);

/// Whether a program writes this where it has no number.
bool is_missing(std::string_view text);

/// Names, and no value among them.
bool are_names(const std::vector<TextCell>& cells);

/// The sign between whole and fraction in the numbers of a table.
struct DecimalSign {
  bool comma = false;
  std::string problem{};  ///< why it cannot be told; then the number at `row` and `column` shows it
  std::size_t row = 0, column = 0;
};

/// A comma in a number is its decimal sign if no number has a point, and if one of them at least cannot mean
/// thousands: 5,065 alone may be either.
DecimalSign decimal_sign_of(const std::vector<std::vector<TextCell>>& rows);

/// Without blanks at both ends; in small letters; in quotes.
std::string_view trimmed_text(std::string_view text);
std::string lower_case(std::string_view text);
std::string quoted_text(std::string_view text);

}  // namespace tendril::app
