#include "tendril/options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "tendril/whole_number.hpp"

namespace tendril {

OptionError::OptionError(std::string option, SourcePosition position, const std::string& message)
    : Error(message), option_(std::move(option)), position_(position) {}
OptionError::~OptionError() = default;

bool Options::has(std::string_view name) const {
  const auto found = values_.find(name);
  return found != values_.end() && !std::holds_alternative<std::monostate>(found->second);
}

const OptionValue& Options::at(std::string_view name) const {
  if (!has(name)) throw Error("option '" + std::string(name) + "' was asked for but has no value");
  return values_.find(name)->second;
}

namespace {

template <class T>
const T& typed(const OptionValue& value, std::string_view name, const char* type) {
  if (const T* held = std::get_if<T>(&value)) return *held;
  throw Error("option '" + std::string(name) + "' was asked for as " + type + " but is declared as another type");
}

}  // namespace

bool Options::boolean(std::string_view name) const { return typed<bool>(at(name), name, "a boolean"); }
std::int64_t Options::integer(std::string_view name) const { return typed<std::int64_t>(at(name), name, "an integer"); }
double Options::real(std::string_view name) const { return typed<double>(at(name), name, "a real number"); }
const std::string& Options::text(std::string_view name) const { return typed<std::string>(at(name), name, "text"); }
const NumberTable& Options::table(std::string_view name) const {
  return typed<NumberTable>(at(name), name, "a list or matrix");
}

void Options::set(std::string name, OptionValue value) { values_.insert_or_assign(std::move(name), std::move(value)); }

namespace {

std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

/// The value as a user would write it; long lists are cut.
std::string shown(const RawValue& raw) {
  constexpr std::size_t longest_list = 8;
  constexpr std::size_t longest_text = 80;
  struct Show {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const {
      // A real number shows that it is one.
      const std::string text = number_text(v);
      return text + (text.find_first_not_of("-0123456789") == std::string::npos ? ".0" : "");
    }
    std::string operator()(const std::string& v) const {
      return '\'' + (v.size() > longest_text ? v.substr(0, longest_text) + "..." : v) + '\'';
    }
    std::string operator()(const RawValue::List& list) const {
      std::string text = "[";
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (i > 0) text += ", ";
        if (i == longest_list) {
          text += "...";
          break;
        }
        text += std::visit(*this, list[i].value);
      }
      return text + "]";
    }
  };
  return std::visit(Show{}, raw.value);
}

std::string joined(std::span<const std::string> words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "'" : ", '") + word + "'";
  return text;
}

/// " from 1 to 64", " >= 0", " > 0 m", " in N", "".
std::string range_text(const OptionSpec& spec) {
  const bool below = std::isfinite(spec.minimum);
  const bool above = std::isfinite(spec.maximum);
  const std::string unit = spec.dimension.unit.empty() ? "" : ' ' + std::string(spec.dimension.unit);
  if (below && above && !spec.minimum_excluded) {
    return " from " + number_text(spec.minimum) + " to " + number_text(spec.maximum) + unit;
  }
  std::string text;
  if (below) text += (spec.minimum_excluded ? " > " : " >= ") + number_text(spec.minimum) + unit;
  if (above) text += (below ? " and <= " : " <= ") + number_text(spec.maximum) + unit;
  return text.empty() && !unit.empty() ? " in" + unit : text;
}

std::string expected(const OptionSpec& spec) {
  switch (spec.type) {
    case OptionType::boolean:
      return "true or false";
    case OptionType::integer:
      return "a whole number" + range_text(spec);
    case OptionType::real:
      return "a number" + range_text(spec);
    case OptionType::text:
      return spec.choices.empty() ? "text" : "one of " + joined(spec.choices);
    case OptionType::list:
      return "a list of " + (spec.size > 0 ? std::to_string(spec.size) + ' ' : std::string()) + "numbers" +
             range_text(spec);
    case OptionType::points:
      return "a list of at least " + std::to_string(std::max(1, spec.size)) + " points [x, y]" + range_text(spec);
    case OptionType::matrix:
      return "a matrix (rows of numbers of equal length), its diagonal (a list) or one number";
  }
  return "another value";
}

/// Turns one raw value into the checked and scaled one that `spec` declares.
class Reader {
 public:
  Reader(const OptionSpec& spec, const Scale& scale, const QuantityReader& read, std::string_view owner)
      : spec_(spec), scale_(scale), read_(read), owner_(owner) {}

  OptionValue value(const RawValue& raw) const {
    switch (spec_.type) {
      case OptionType::boolean:
        if (const bool* v = std::get_if<bool>(&raw.value)) return *v;
        break;
      case OptionType::integer:
        if (const std::optional<std::int64_t> v = whole(raw)) {
          check_range(static_cast<double>(*v), raw);
          return *v;
        }
        break;
      case OptionType::real:
        return number(raw);
      case OptionType::text:
        return text(raw);
      case OptionType::list:
        return list(raw);
      case OptionType::points:
        return points(raw);
      case OptionType::matrix:
        return matrix(raw);
    }
    refuse(raw);
  }

  /// The default, scaled. A default that is not of the declared type is a defect of the component.
  OptionValue default_value() const {
    const OptionValue& given = spec_.default_value;
    switch (spec_.type) {
      case OptionType::boolean:
        if (std::holds_alternative<bool>(given)) return given;
        break;
      case OptionType::integer:
        if (std::holds_alternative<std::int64_t>(given)) return given;
        break;
      case OptionType::real:
        if (const double* v = std::get_if<double>(&given)) return scaled(*v);
        if (const auto* v = std::get_if<std::int64_t>(&given)) return scaled(static_cast<double>(*v));
        break;
      case OptionType::text:
        if (std::holds_alternative<std::string>(given)) return given;
        break;
      case OptionType::list:
      case OptionType::points:
      case OptionType::matrix:
        if (const NumberTable* v = std::get_if<NumberTable>(&given)) {
          NumberTable table = *v;
          for (double& entry : table.values) entry = scaled(entry);
          return table;
        }
        break;
    }
    throw Error(where() + " declares a default that is not " + expected(spec_));
  }

 private:
  std::string where() const { return "option '" + spec_.name + "' of " + std::string(owner_); }

  [[noreturn]] void refuse(const RawValue& raw, const std::string& reason = "", SourcePosition outer = {}) const {
    throw OptionError(spec_.name, raw.position.line > 0 ? raw.position : outer,
                      where() + ": found " + shown(raw) + (reason.empty() ? "" : " (" + reason + ")") + "; expected " +
                          expected(spec_));
  }

  static std::optional<std::int64_t> whole(const RawValue& raw) {
    if (const auto* v = std::get_if<std::int64_t>(&raw.value)) return *v;
    const auto* real = std::get_if<double>(&raw.value);
    return real != nullptr ? whole_number(*real) : std::nullopt;
  }

  double scaled(double si) const { return scale_.to_dimensionless(si, spec_.dimension); }

  void check_range(double si, const RawValue& raw, SourcePosition outer = {}) const {
    if (!std::isfinite(si)) refuse(raw, "not a finite number", outer);
    const bool below = spec_.minimum_excluded ? si <= spec_.minimum : si < spec_.minimum;
    if (below || si > spec_.maximum) refuse(raw, "out of range", outer);
  }

  /// SI, range checked, then dimensionless. `outer` is used where the number itself has no position.
  double number(const RawValue& raw, SourcePosition outer = {}) const {
    double si = 0.0;
    if (const auto* integer = std::get_if<std::int64_t>(&raw.value)) {
      si = static_cast<double>(*integer);
    } else if (const double* real = std::get_if<double>(&raw.value)) {
      si = *real;
    } else if (const auto* text = std::get_if<std::string>(&raw.value)) {
      if (!read_) refuse(raw, "numbers written as text cannot be read here", outer);
      try {
        si = read_(*text, spec_.dimension);
      } catch (const Error& error) {
        refuse(raw, error.what(), outer);
      }
    } else {
      refuse(raw, "", outer);
    }
    check_range(si, raw, outer);
    return scaled(si);
  }

  OptionValue text(const RawValue& raw) const {
    const auto* word = std::get_if<std::string>(&raw.value);
    if (!word) refuse(raw);
    if (!spec_.choices.empty() && std::find(spec_.choices.begin(), spec_.choices.end(), *word) == spec_.choices.end()) {
      const std::string near = nearest_name(*word, spec_.choices);
      refuse(raw, near.empty() ? "" : "did you mean '" + near + "'?");
    }
    return *word;
  }

  OptionValue list(const RawValue& raw) const {
    const auto* entries = std::get_if<RawValue::List>(&raw.value);
    if (!entries) refuse(raw);
    if (entries->empty()) refuse(raw, "empty");
    if (spec_.size > 0 && entries->size() != static_cast<std::size_t>(spec_.size)) {
      refuse(raw, std::to_string(entries->size()) + " entries");
    }
    NumberTable table{1, static_cast<int>(entries->size()), {}};
    for (const RawValue& entry : *entries) table.values.push_back(number(entry, raw.position));
    return table;
  }

  OptionValue points(const RawValue& raw) const {
    const auto* rows = std::get_if<RawValue::List>(&raw.value);
    if (!rows) refuse(raw);
    if (rows->size() < static_cast<std::size_t>(std::max(1, spec_.size))) {
      refuse(raw, std::to_string(rows->size()) + (rows->size() == 1 ? " entry" : " entries"));
    }
    NumberTable table{static_cast<int>(rows->size()), 2, {}};
    for (const RawValue& row : *rows) {
      const auto* point = std::get_if<RawValue::List>(&row.value);
      if (!point || point->size() != 2) refuse(row, "no point", raw.position);
      for (const RawValue& entry : *point) table.values.push_back(number(entry, raw.position));
    }
    return table;
  }

  OptionValue matrix(const RawValue& raw) const {
    const auto* rows = std::get_if<RawValue::List>(&raw.value);
    if (!rows) return NumberTable{1, 1, {number(raw)}};
    if (rows->empty()) refuse(raw, "empty");
    const std::size_t n = rows->size();
    const bool is_diagonal = !std::holds_alternative<RawValue::List>(rows->front().value);
    if (is_diagonal) {
      NumberTable table{static_cast<int>(n), static_cast<int>(n), std::vector<double>(n * n, 0.0)};
      for (std::size_t i = 0; i < n; ++i) table.values[i * (n + 1)] = number((*rows)[i], raw.position);
      return table;
    }
    const std::size_t columns = std::get<RawValue::List>(rows->front().value).size();
    NumberTable table{static_cast<int>(n), static_cast<int>(columns), {}};
    for (const RawValue& row : *rows) {
      const auto* entries = std::get_if<RawValue::List>(&row.value);
      if (!entries || entries->empty() || entries->size() != columns) refuse(raw, "rows of different or no length");
      for (const RawValue& entry : *entries) table.values.push_back(number(entry, raw.position));
    }
    return table;
  }

  const OptionSpec& spec_;
  const Scale& scale_;
  const QuantityReader& read_;
  std::string_view owner_;
};

void refuse_unknown(const OptionSchema& schema, const RawOptions& given, std::string_view owner) {
  std::vector<std::string> known;
  for (const OptionSpec& spec : schema) known.push_back(spec.name);
  if (std::find(known.begin(), known.end(), any_option) != known.end()) return;
  for (const auto& [name, raw] : given) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw OptionError(name, raw.position,
                      std::string(owner) + " has no option '" + name + "' (found " + name + " = " + shown(raw) + ")" +
                          did_you_mean(name, known));
  }
}

/// Takes scalars as they are; a list becomes nothing.
struct PassScalar {
  OptionValue operator()(const RawValue::List&) const { return {}; }
  template <class Scalar>
  OptionValue operator()(const Scalar& v) const {
    return v;
  }
};

/// Hands over what only the component's own library can judge.
void pass_unlisted(const OptionSchema& schema, const RawOptions& given, std::string_view owner, Options& options) {
  for (const auto& [name, raw] : given) {
    const auto listed =
        std::find_if(schema.begin(), schema.end(), [&, &key = name](const OptionSpec& s) { return s.name == key; });
    if (listed != schema.end()) continue;
    OptionValue value = std::visit(PassScalar{}, raw.value);
    if (std::holds_alternative<std::monostate>(value)) {
      throw OptionError(name, raw.position,
                        "option '" + name + "' of " + std::string(owner) + ": found " + shown(raw) +
                            "; expected a number, a word, or true or false");
    }
    options.set(name, std::move(value));
  }
}

}  // namespace

Options resolve_options(const OptionSchema& schema, const RawOptions& given, const Scale& scale,
                        const QuantityReader& read, std::string_view owner) {
  refuse_unknown(schema, given, owner);
  Options options(scale);
  for (const OptionSpec& spec : schema) {
    if (spec.name == any_option) {
      pass_unlisted(schema, given, owner, options);
      continue;
    }
    const Reader reader(spec, scale, read, owner);
    if (const auto found = given.find(spec.name); found != given.end()) {
      options.set(spec.name, reader.value(found->second));
    } else if (spec.required) {
      throw OptionError(
          spec.name, {},
          std::string(owner) + " needs option '" + spec.name + "': found nothing; expected " + expected(spec));
    } else if (!std::holds_alternative<std::monostate>(spec.default_value)) {
      options.set(spec.name, reader.default_value());
    }
  }
  return options;
}

namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

/// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = a[i - 1] == b[j - 1];
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
    before_last.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view name, std::span<const std::string> known) {
  // Names of a scene are short; a longer text is no misspelling, and its distance would cost quadratic time.
  constexpr std::size_t longest = 100;
  constexpr std::size_t shortest_beginning = 3;
  if (name.empty() || name.size() > longest) return "";
  const std::string wanted = lower_case(name);
  std::string nearest;
  std::size_t smallest = longest;
  for (const std::string& candidate : known) {
    const std::string offered = lower_case(candidate);
    const std::size_t distance = edit_distance(wanted, offered);
    const std::size_t allowed = std::max<std::size_t>(1, std::max(wanted.size(), offered.size()) / 3);
    const bool is_beginning = wanted.size() >= shortest_beginning && offered.starts_with(wanted);
    // A single letter is one replacement away from every other: that says nothing.
    const bool meant = (distance <= allowed && distance < wanted.size()) || is_beginning;
    if (meant && distance < smallest) {
      smallest = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> known) {
  if (const std::string near = nearest_name(name, known); !near.empty()) return "; did you mean '" + near + "'?";
  if (known.empty()) return " (none is known)";
  std::string text = " (known: ";
  for (std::size_t i = 0; i < known.size(); ++i) text += (i > 0 ? ", " : "") + known[i];
  return text + ")";
}

}  // namespace tendril
