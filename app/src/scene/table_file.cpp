#include "scene/table_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "system/delimited_text.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

bool is_pixel(std::string_view unit) {
  const std::string small = lower_case(unit);
  return small == "px" || small == "pixel" || small == "pixels";
}

class Reader {
 public:
  Reader(const std::filesystem::path& path, const TableFileSpec& spec, const Units& units)
      : path_(path), spec_(spec), units_(units) {
    has_words_ = std::any_of(spec.columns.begin(), spec.columns.end(), [](const ColumnSpec& c) { return c.text; });
  }

  TableFile read();

 private:
  /// The column that a name means, and the size of its unit.
  struct Named {
    std::size_t column;
    double factor;
    bool with_unit = true;
  };

  [[noreturn]] void fail(const TextLine& line, const TextCell& cell, const std::string& message) const {
    throw InputError(fmt::format("{}:{}:{}: {}", path_.string(), line.number, cell.column, message));
  }

  std::optional<std::size_t> column_called(std::string_view name) const;
  std::optional<Named> with_bracket(const TextLine& line, const TextCell& cell, std::size_t bracket) const;
  std::optional<Named> named(const TextLine& line, const TextCell& cell) const;
  std::optional<double> factor(std::string_view unit, const Dimension& dimension) const;
  double plain_factor(std::size_t column) const;
  std::string example(std::size_t column) const;
  std::string expected() const;

  void collect(const std::vector<TextLine>& lines);
  bool take_comment(const TextLine& line);
  void take_names(const TextLine& line, std::vector<TextCell> cells);
  bool take_units(const std::vector<TextCell>& cells);
  void take_columns_by_count();
  void leave_out_others();
  void take_row(const TextLine& line, std::vector<TextCell> cells);
  double value(const TextLine& line, const TextCell& cell, std::size_t at) const;

  const std::filesystem::path& path_;
  const TableFileSpec& spec_;
  const Units& units_;
  std::vector<TextLine> lines_;  // with values
  std::vector<std::vector<TextCell>> cells_;
  char separator_ = ',';
  bool comma_ = false;           // is the decimal sign
  bool has_words_ = false;       // a column may hold some
  std::vector<int> column_of_;   // of each cell: place in TableFile::form, or -1
  std::vector<double> factors_;  // of each column of the form
  TableFile file_;
};

TableFile Reader::read() {
  const std::string text = read_input(path_, spec_.what);
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    fail({{}, 1}, {}, "found UTF-16 text, expected UTF-8 (spreadsheets call it \"CSV UTF-8\")");
  }
  require_text(text, path_);
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  collect(lines_of(std::string_view(text).substr(text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0)));
  if (lines_.empty()) throw InputError(path_.string() + ": found no points, expected lines with " + expected());
  const DecimalSign sign = decimal_sign_of(cells_);
  if (!sign.problem.empty()) fail(lines_[sign.row], cells_[sign.row][sign.column], sign.problem);
  comma_ = sign.comma;
  if (column_of_.empty()) take_columns_by_count();
  leave_out_others();
  for (std::size_t i = 0; i < lines_.size(); ++i) take_row(lines_[i], std::move(cells_[i]));
  return std::move(file_);
}

/// Takes the names, and sets lines with values apart.
void Reader::collect(const std::vector<TextLine>& lines) {
  bool begun = false;
  for (const TextLine& line : lines) {
    if (trimmed_text(line.text).front() == '#') {
      if (!begun) take_comment(line);
      continue;
    }
    if (!begun && lower_case(trimmed_text(line.text)).starts_with("sep=")) continue;  // a hint for spreadsheets
    if (!begun) {
      begun = true;
      std::vector<TextCell> cells = cells_of(line, separator_of(line));
      if (are_names(cells)) {
        take_names(line, std::move(cells));
        continue;
      }
    }
    if (lines_.empty() && take_units(cells_of(line, separator_of(line)))) continue;
    if (lines_.empty()) separator_ = separator_of(line);
    lines_.push_back(line);
    cells_.push_back(cells_of(line, separator_));
  }
}

/// Some programs write the names as a comment.
bool Reader::take_comment(const TextLine& line) {
  const auto after = line.text.find('#') + 1;
  const TextLine names{line.text.substr(after), line.number, after + 1};
  if (trimmed_text(names.text).empty()) return false;
  std::vector<TextCell> cells = cells_of(names, separator_of(names));
  const bool all = std::all_of(cells.begin(), cells.end(), [&](const TextCell& cell) {
    const auto name = cell.text.substr(0, cell.text.find_first_of("[("));
    return column_called(name).has_value() || (name == cell.text && named(names, cell));
  });
  if (!all || cells.size() < 2) return false;
  take_names(names, std::move(cells));
  return true;
}

std::string Reader::expected() const {
  std::string text;
  if (spec_.forms.empty()) {
    for (const ColumnSpec& column : spec_.columns) text += (text.empty() ? "some of " : ", ") + column.name;
  }
  for (const auto& form : spec_.forms) {
    text += text.empty() ? "" : " or ";
    for (std::size_t i = 0; i < form.size(); ++i) text += (i > 0 ? ", " : "") + spec_.columns[form[i]].name;
  }
  return text;
}

std::string Reader::example(std::size_t column) const {
  const ColumnSpec& spec = spec_.columns[column];
  const std::string_view unit = spec.dimension.unit;
  return spec.name + (unit == dimension::length.unit  ? " [mm]"
                      : unit == dimension::angle.unit ? " [deg]"
                      : unit.empty()                  ? ""
                                                      : " [" + std::string(unit) + "]");
}

std::optional<std::size_t> Reader::column_called(std::string_view name) const {
  const std::string wanted = lower_case(trimmed_text(name));
  for (std::size_t c = 0; c < spec_.columns.size(); ++c) {
    const ColumnSpec& column = spec_.columns[c];
    if (column.name == wanted || std::find(column.also.begin(), column.also.end(), wanted) != column.also.end()) {
      return c;
    }
  }
  return std::nullopt;
}

double Reader::plain_factor(std::size_t column) const {
  return spec_.pixel > 0.0 && spec_.columns[column].dimension.unit == dimension::length.unit ? spec_.pixel : 1.0;
}

std::optional<double> Reader::factor(std::string_view unit, const Dimension& dimension) const {
  if (is_pixel(unit)) return spec_.pixel > 0.0 ? std::optional(spec_.pixel) : std::nullopt;
  for (const std::string& spelling : {std::string(unit), lower_case(unit)}) {
    try {
      return units_.read("1 " + spelling, dimension);
    } catch (const QuantityError&) {
      continue;
    }
  }
  return std::nullopt;
}

/// "x [mm]" or "x (mm)"; nothing: another column.
std::optional<Reader::Named> Reader::with_bracket(const TextLine& line, const TextCell& cell,
                                                  std::size_t bracket) const {
  const std::string_view text = cell.text;
  const auto column = column_called(text.substr(0, bracket));
  if (!column) return std::nullopt;
  if (text.back() != (text[bracket] == '[' ? ']' : ')')) {
    fail(line, cell,
         "found the column " + quoted_text(text) + ", expected its unit in brackets, such as " + example(*column));
  }
  const std::string_view unit = trimmed_text(text.substr(bracket + 1, text.size() - bracket - 2));
  if (unit.empty()) return Named{*column, plain_factor(*column), false};
  const Dimension& dimension = spec_.columns[*column].dimension;
  if (const auto size = factor(unit, dimension)) return Named{*column, *size};
  if (is_pixel(unit)) {
    fail(line, cell,
         "found the column " + quoted_text(text) + " in pixels, expected the length of one as 'scale' in [" +
             spec_.what + "]");
  }
  fail(line, cell,
       "found the unit " + quoted_text(unit) + " of the column " + quoted_text(text) + ", expected that of " +
           dimension_name(dimension) + ", such as " + example(*column));
}

/// What the name over a column means; nothing: it is not read.
std::optional<Reader::Named> Reader::named(const TextLine& line, const TextCell& cell) const {
  const std::string_view text = cell.text;
  if (const auto bracket = text.find_first_of("[("); bracket != std::string_view::npos) {
    return with_bracket(line, cell, bracket);
  }
  if (const auto column = column_called(text)) return Named{*column, plain_factor(*column), false};
  // "x_mm", "x/mm", "x mm", "x in mm".
  for (auto at = text.find_first_of(" _/,"); at != std::string_view::npos; at = text.find_first_of(" _/,", at + 1)) {
    const auto column = column_called(text.substr(0, at));
    if (!column) continue;
    std::string_view unit = trimmed_text(text.substr(at + 1));
    if (unit.starts_with("in ")) unit = trimmed_text(unit.substr(3));
    if (const auto size = factor(unit, spec_.columns[*column].dimension)) return Named{*column, *size};
  }
  return std::nullopt;
}

void Reader::take_names(const TextLine& line, std::vector<TextCell> cells) {
  while (cells.size() > 1 && cells.back().text.empty()) cells.pop_back();
  file_ = {};
  column_of_.clear();
  std::vector<std::optional<Named>> found;
  found.reserve(cells.size());
  std::string names;
  for (const TextCell& cell : cells) {
    found.push_back(named(line, cell));
    names += (names.empty() ? "" : ", ") + quoted_text(cell.text);
    if (!found.back()) {
      if (!cell.text.empty()) file_.unread.push_back(cell.text);
      continue;
    }
    const std::size_t column = found.back()->column;
    if (std::find(file_.form.begin(), file_.form.end(), column) != file_.form.end()) {
      fail(line, cell,
           "found the column " + quoted_text(cell.text) + ", but the column " + spec_.columns[column].name +
               " stands before it");
    }
    file_.form.push_back(column);
  }
  std::sort(file_.form.begin(), file_.form.end());
  std::vector<std::size_t> form = file_.form;
  std::erase_if(form, [&](std::size_t column) {
    return std::find(spec_.besides.begin(), spec_.besides.end(), column) != spec_.besides.end();
  });
  const bool fits = spec_.forms.empty() ? !form.empty()
                                        : std::find(spec_.forms.begin(), spec_.forms.end(), form) != spec_.forms.end();
  if (!fits) {
    fail(line, cells.front(),
         "found the columns " + names + ", expected " + expected() + ", each with its unit, such as " +
             example(spec_.example));
  }
  factors_.assign(file_.form.size(), 1.0);
  file_.with_unit.assign(file_.form.size(), false);
  for (const auto& one : found) {
    column_of_.push_back(-1);
    if (!one) continue;
    const auto at = std::find(file_.form.begin(), file_.form.end(), one->column) - file_.form.begin();
    column_of_.back() = static_cast<int>(at);
    factors_[static_cast<std::size_t>(at)] = one->factor;
    file_.with_unit[static_cast<std::size_t>(at)] = one->with_unit;
  }
}

/// Some programs write the units on a line below the names. False: it is none of these.
bool Reader::take_units(const std::vector<TextCell>& cells) {
  if (column_of_.empty()) return false;
  std::vector<double> factors = factors_;
  for (std::size_t i = 0; i < column_of_.size(); ++i) {
    if (column_of_[i] < 0) continue;
    const auto at = static_cast<std::size_t>(column_of_[i]);
    std::string_view unit = i < cells.size() ? std::string_view(cells[i].text) : "";
    // Pure numbers have none.
    if (spec_.columns[file_.form[at]].dimension.unit.empty() && is_missing(unit)) continue;
    const bool in_brackets = unit.size() > 2 && (unit.front() == '[' || unit.front() == '(');
    if (in_brackets) unit = trimmed_text(unit.substr(1, unit.size() - 2));
    const auto size = unit.empty() ? std::nullopt : factor(unit, spec_.columns[file_.form[at]].dimension);
    if (!size) return false;
    factors[at] = *size;
  }
  factors_ = factors;
  file_.with_unit.assign(file_.form.size(), true);
  return true;
}

void Reader::take_columns_by_count() {
  std::size_t count = cells_.front().size();
  while (count > 1 && cells_.front()[count - 1].text.empty()) --count;
  for (const auto& form : spec_.forms) {
    if (form.size() == count) file_.form = form;
  }
  if (file_.form.empty()) {
    fail(
        lines_.front(), cells_.front().front(),
        fmt::format("found {} {} and no names above, expected {}", count, count == 1 ? "value" : "values", expected()));
  }
  for (std::size_t i = 0; i < count; ++i) {
    column_of_.push_back(static_cast<int>(i));
    factors_.push_back(plain_factor(file_.form[i]));
    file_.with_unit.push_back(false);
  }
}

/// Times of day, for instance, are no times.
void Reader::leave_out_others() {
  for (const std::size_t column : spec_.besides) {
    const auto found = std::find(file_.form.begin(), file_.form.end(), column);
    if (found == file_.form.end()) continue;
    const auto at = static_cast<int>(found - file_.form.begin());
    const auto cell =
        static_cast<std::size_t>(std::find(column_of_.begin(), column_of_.end(), at) - column_of_.begin());
    try {
      for (std::size_t i = 0; i < cells_.size(); ++i) {
        if (cell < cells_[i].size() && !std::isnan(value(lines_[i], cells_[i][cell], static_cast<std::size_t>(at))))
          break;
      }
    } catch (const InputError&) {
      file_.unread.push_back(spec_.columns[column].name);
      file_.form.erase(found);
      factors_.erase(factors_.begin() + at);
      for (int& of : column_of_) of = of == at ? -1 : of > at ? of - 1 : of;
    }
  }
}

void Reader::take_row(const TextLine& line, std::vector<TextCell> cells) {
  const bool blank = std::all_of(cells.begin(), cells.end(), [](const TextCell& c) { return c.text.empty(); });
  while (cells.size() > column_of_.size() && cells.back().text.empty()) cells.pop_back();
  if (blank) cells.resize(column_of_.size());
  if (cells.size() != column_of_.size()) {
    const bool too_many = separator_ == ',' && cells.size() > column_of_.size();
    fail(line, cells.back(),
         fmt::format("found {} {}, expected {} as in the lines before{}", cells.size(),
                     cells.size() == 1 ? "value" : "values", column_of_.size(),
                     too_many ? "; decimal commas need semicolons or tabs between the values" : ""));
  }
  if (file_.rows.size() == spec_.most_rows) {
    fail(line, cells.front(), fmt::format("found more than {} points, expected at most as many", spec_.most_rows));
  }
  std::vector<double> row(file_.form.size(), nothing);
  std::vector<std::string> words(has_words_ ? file_.form.size() : 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (column_of_[i] < 0) continue;
    const auto at = static_cast<std::size_t>(column_of_[i]);
    if (spec_.columns[file_.form[at]].text) {
      words[at] = cells[i].text;
    } else {
      row[at] = value(line, cells[i], at);
    }
  }
  file_.rows.push_back(std::move(row));
  file_.texts.push_back(std::move(words));
  file_.lines.push_back(line.number);
  file_.blank.push_back(blank);
}

double Reader::value(const TextLine& line, const TextCell& cell, std::size_t at) const {
  if (is_missing(cell.text)) return nothing;
  const Dimension& dimension = spec_.columns[file_.form[at]].dimension;
  const auto [number, unit] = leading_number(cell.text, comma_);
  if (number && !std::isfinite(*number)) {
    fail(line, cell,
         "found " + quoted_text(cell.text) + ", expected " + expected_quantity(dimension, " that is finite"));
  }
  // A number may have a unit of its own.
  const std::optional<double> size = !number ? std::nullopt : unit.empty() ? factors_[at] : factor(unit, dimension);
  if (!size) fail(line, cell, "found " + quoted_text(cell.text) + ", expected " + expected_quantity(dimension));
  return *number * *size;
}

}  // namespace

TableFile read_table_file(const std::filesystem::path& path, const TableFileSpec& spec, const Units& units) {
  return Reader(path, spec, units).read();
}

}  // namespace tendril::app
