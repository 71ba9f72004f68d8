#include "system/delimited_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace tendril::app {

namespace {

constexpr std::string_view blanks = " \t";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Calls `take(character, index)` for what stands outside of quotes.
template <class Take>
void outside_quotes(std::string_view text, Take take) {
  bool inside = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') inside = !inside;
    if (!inside) take(text[i], i);
  }
}

/// Where the cells of a line end.
std::vector<std::size_t> ends_of(std::string_view text, char separator) {
  std::vector<std::size_t> ends;
  const auto first = text.find_first_not_of(blanks);
  outside_quotes(text, [&](char c, std::size_t i) {
    if (separator != ' ') {
      if (c == separator) ends.push_back(i);
      return;
    }
    const auto next = text.find_first_not_of(blanks, i);
    const bool last_blank = blanks.find(c) != std::string_view::npos && next == i + 1 && i > first;
    if (last_blank && text[next] != '[' && text[next] != '(') ends.push_back(i);
  });
  ends.push_back(text.size());
  return ends;
}

/// Numbers with decimal commas between blanks look as if commas separated them, but for the blanks left inside.
bool blanks_separate(const TextLine& line) {
  const std::vector<TextCell> by_blank = cells_of(line, ' ');
  const std::vector<TextCell> by_comma = cells_of(line, ',');
  return by_blank.size() > 1 &&
         std::all_of(by_blank.begin(), by_blank.end(),
                     [](const TextCell& c) { return number_in(c.text, true).has_value(); }) &&
         std::any_of(by_comma.begin(), by_comma.end(),
                     [](const TextCell& c) { return c.text.find_first_of(blanks) != std::string::npos; });
}

/// 5,065 and 12,345,... may be thousands; 0,45 or 34,86 may not.
bool may_be_thousands(std::string_view number) {
  const std::string_view whole = number.substr(std::min(number.find_first_not_of("+-"), number.size()));
  const auto digits = whole.find(',');
  return digits >= 1 && digits <= 3 && whole.front() != '0' && whole.size() == digits + 4 &&
         std::all_of(whole.end() - 3, whole.end(), is_digit);
}

}  // namespace

std::string_view trimmed_text(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::string quoted_text(std::string_view text) {
  return '"' + std::string(text.substr(0, 80)) + (text.size() > 80 ? "...\"" : "\"");
}

std::vector<TextLine> lines_of(std::string_view text) {
  std::vector<TextLine> lines;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    ++number;
    if (!trimmed_text(line).empty()) lines.push_back({line, number});
    begin = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
  }
  return lines;
}

char separator_of(const TextLine& line) {
  bool comma = false;
  bool semicolon = false;
  bool bar = false;
  bool tab = false;
  outside_quotes(trimmed_text(line.text), [&](char c, std::size_t) {
    comma = comma || c == ',';
    semicolon = semicolon || c == ';';
    bar = bar || c == '|';
    tab = tab || c == '\t';
  });
  if (semicolon) return ';';
  if (bar) return '|';
  if (!comma) return tab ? '\t' : ' ';
  // Blanks and tabs beside a comma only fill up, unless the comma belongs to a number.
  const std::vector<TextCell> by_tab = cells_of(line, '\t');
  const bool filling = std::any_of(by_tab.begin(), by_tab.end(), [](const TextCell& c) {
    return c.text.empty() || c.text.front() == ',' || c.text.back() == ',';
  });
  if (tab && !filling) return '\t';
  return blanks_separate(line) ? ' ' : ',';
}

std::vector<TextCell> cells_of(const TextLine& line, char separator) {
  std::vector<TextCell> cells;
  std::size_t begin = 0;
  for (const std::size_t end : ends_of(line.text, separator)) {
    const std::string_view raw = line.text.substr(begin, end - begin);
    const auto blank = raw.find_first_not_of(blanks);
    TextCell cell{std::string(trimmed_text(raw)),
                  line.first_column + begin + (blank == std::string_view::npos ? 0 : blank)};
    if (cell.text.size() >= 2 && cell.text.front() == '"' && cell.text.back() == '"') {
      cell.text = std::string(trimmed_text(std::string_view(cell.text).substr(1, cell.text.size() - 2)));
    }
    cells.push_back(std::move(cell));
    begin = end + 1;
  }
  return cells;
}

std::pair<std::optional<double>, std::string_view> leading_number(std::string_view text, bool comma) {
  // Some programs write the minus sign of typography.
  constexpr std::string_view minus = "\xe2\x88\x92";
  if (text.starts_with(minus)) {
    const auto [number, rest] = leading_number(text.substr(minus.size()), comma);
    return {number ? std::optional(-*number) : number, number ? rest : text};
  }
  const std::string_view rest = text.starts_with('+') ? text.substr(1) : text;
  std::string plain(rest);
  if (comma) std::replace(plain.begin(), plain.end(), ',', '.');
  double value = 0.0;
  const auto [end, code] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (code != std::errc{}) return {std::nullopt, text};
  return {value, trimmed_text(rest.substr(static_cast<std::size_t>(end - plain.data())))};
}

std::optional<double> number_in(std::string_view text, bool comma) {
  const auto [number, rest] = leading_number(text, comma);
  return rest.empty() ? number : std::nullopt;
}

bool is_missing(std::string_view text) {
  constexpr std::array<std::string_view, 12> words{"",     "-",    "--",  "na",       "n/a",       "#n/a",
                                                   "null", "none", "nan", "nan(ind)", "-nan(ind)", "-nan"};
  return std::find(words.begin(), words.end(), lower_case(text)) != words.end();
}

bool are_names(const std::vector<TextCell>& cells) {
  bool named = false;
  for (const TextCell& cell : cells) {
    const auto first = cell.text.find_first_not_of("+-.,");
    if (first != std::string::npos && is_digit(cell.text[first])) return false;
    named = named || (!is_missing(cell.text) && is_letter(cell.text.front()));
  }
  return named;
}

DecimalSign decimal_sign_of(const std::vector<std::vector<TextCell>>& rows) {
  DecimalSign sign;
  std::string comma;
  std::string point;
  bool clear = false;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const std::string& text = rows[r][c].text;
      if (number_in(text, false)) {
        if (text.find('.') != std::string::npos) point = text;
      } else if (text.find(',') != std::string::npos && leading_number(text, true).first) {
        clear = clear || !may_be_thousands(text);
        if (!comma.empty()) continue;
        comma = text;
        sign.row = r;
        sign.column = c;
      }
    }
  }
  sign.comma = !comma.empty();
  if (sign.comma && !point.empty()) {
    sign.problem = "found " + quoted_text(comma) + " in a file that has " + quoted_text(point) +
                   " too, expected one decimal sign for all numbers";
  } else if (sign.comma && !clear) {
    std::string pointed = comma;
    pointed[pointed.find(',')] = '.';
    sign.problem =
        "found " + quoted_text(comma) + ", which may mean " + pointed + " or thousands, expected a decimal point";
  }
  return sign;
}

}  // namespace tendril::app
