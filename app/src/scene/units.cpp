#include "tendril/app/units.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "scene/common_units.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// A dimension: its SI unit, what it is called, and the sizes (SI) between which units make sense for a rod: lengths
/// from 1 um to 1 km, forces from nN to kN, and what comes of them.
struct Named {
  std::string_view unit;
  const char* name;
  const char* example;
  double smallest;
  double largest;
};

constexpr std::array<Named, 16> names{{{"m", "a length", "60 mm", 1e-6, 1e3},
                                       {"rad", "an angle", "30 deg", 1e-9, 10.0},
                                       {"1/m", "a curvature", "5 1/m", 1e-5, 1e6},
                                       {"N", "a force", "0.5 N", 1e-9, 1e4},
                                       {"N m", "a moment", "2.5 N mm", 1e-15, 1e5},
                                       {"N m^2", "a bending stiffness", "4.9e-4 N m^2", 1e-21, 1e5},
                                       {"m/s^2", "an acceleration", "-9.81 m/s^2", 1e-6, 1e3},
                                       {"kg/m", "a linear density", "84 g/m", 1e-12, 1e2},
                                       {"kg/m^3", "a density", "1047 kg/m^3", 1e-3, 1e9},
                                       {"N/m", "a force per length", "0.5 N/m", 1e-9, 1e9},
                                       {"kg", "a mass", "20 g", 1e-15, 1e2},
                                       {"s", "a time", "10 s", 1e-6, 1e5},
                                       {"N m/Pa", "a moment per pressure", "2e-6 N m/Pa", 1e-24, 1e3},
                                       {"N/Pa", "a force per pressure", "2e-4 N/Pa", 1e-18, 1e3},
                                       {"Pa", "a pressure", "50 kPa", 1.0, 1e9},
                                       {"", "a pure number", "0.5", 0.0, 0.0}}};

/// What a unit of this size asks for; empty: it is as large as units for a rod are.
std::string unusual_size(double size, const Dimension& dimension) {
  for (const Named& known : names) {
    constexpr double rounding = 1.0 + 1e-9;
    if (known.unit != dimension.unit || dimension.unit.empty()) continue;
    if (size * rounding >= known.smallest && size <= known.largest * rounding) return "";
    return fmt::format("whose unit is {:.3g} {}, too {} for a rod", size, known.unit,
                       size < known.smallest ? "small" : "large");
  }
  return "";
}

constexpr std::size_t longest_unit = 64;
constexpr std::string_view blanks = " \t";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '%'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_beyond_ascii(char c) { return static_cast<unsigned char>(c) >= 0x80; }

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, 80)) out += (c >= 0 && c < ' ') || c == 127 ? '?' : c;
  return out + (text.size() > 80 ? "...\"" : "\"");
}

// UDUNITS reads numbers, offsets and times inside a unit ("3 4 m", "mm @ 3"). A unit here is letters, products,
// quotients and whole exponents; the one number allowed is the 1 of "1/m".
bool looks_like_unit(std::string_view unit) {
  if (unit.size() > longest_unit) return false;
  if (unit.starts_with('1') && trimmed(unit.substr(1)).starts_with('/')) unit.remove_prefix(1);
  char before = ' ';
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const char c = unit[i];
    if (is_digit(c)) {
      const bool exponent =
          is_letter(before) || is_beyond_ascii(before) || is_digit(before) || before == '^' || before == '-';
      if (!exponent) return false;
    } else if (c == '-' || c == '+') {
      if (before != '^' && !is_letter(before)) return false;
      if (i + 1 == unit.size() || !is_digit(unit[i + 1])) return false;
    } else if (!is_letter(c) && !is_beyond_ascii(c) &&
               std::string_view(" \t.*/^()").find(c) == std::string_view::npos) {
      return false;
    }
    before = c;
  }
  return true;
}

struct UnitDeleter {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
using Unit = std::unique_ptr<ut_unit, UnitDeleter>;

/// What is left of a quotient of two units.
struct Quotient {
  double factor = 1.0;
  int radians = 0;
  bool same = true;  ///< nothing but radians is left
};

ut_status visit_basic(const ut_unit* unit, void* arg) {
  auto& quotient = *static_cast<Quotient*>(arg);
  const char* name = ut_get_name(unit, UT_ASCII);
  if (name != nullptr && std::string_view(name) == "radian") {
    ++quotient.radians;
  } else {
    quotient.same = false;
  }
  return UT_SUCCESS;
}

ut_status visit_product(const ut_unit*, int count, const ut_unit* const* basic, const int* powers, void* arg) {
  auto& quotient = *static_cast<Quotient*>(arg);
  for (int i = 0; i < count; ++i) {
    Quotient one;
    visit_basic(basic[i], &one);
    quotient.radians += one.radians * powers[i];
    quotient.same = quotient.same && one.same;
  }
  return UT_SUCCESS;
}

ut_status visit_scaled(const ut_unit*, double scale, const ut_unit* underlying, double offset, void* arg);

ut_status visit_timestamp(const ut_unit*, const ut_unit*, double, void* arg) {
  static_cast<Quotient*>(arg)->same = false;
  return UT_SUCCESS;
}

ut_status visit_logarithmic(const ut_unit*, double, const ut_unit*, void* arg) {
  static_cast<Quotient*>(arg)->same = false;
  return UT_SUCCESS;
}

constexpr ut_visitor visitor{visit_basic, visit_product, visit_scaled, visit_timestamp, visit_logarithmic};

ut_status visit_scaled(const ut_unit*, double scale, const ut_unit* underlying, double offset, void* arg) {
  auto& quotient = *static_cast<Quotient*>(arg);
  quotient.factor *= scale;
  if (offset != 0.0) quotient.same = false;
  return ut_accept_visitor(underlying, &visitor, arg);
}

std::optional<double> common_size(std::string_view unit, const Dimension& dimension) {
  for (const CommonUnit& common : common_units) {
    if (common.unit == unit && common.dimension == dimension.unit) return common.size;
  }
  return std::nullopt;
}

/// UDUNITS keeps its parser and its tables of names in statics, so that one thread at a time may use it, and one
/// database serves the process.
std::mutex udunits_in_use;

class Database {
 public:
  /// Read when first asked for. For those who hold udunits_in_use.
  static const Database& of_process() {
    static const Database database;
    return database;
  }

  Database() : system_(nullptr, &ut_free_system) {
    ut_set_error_message_handler(ut_ignore);
    system_.reset(ut_read_xml(nullptr));
    if (!system_) {
      ut_status status = UT_SUCCESS;
      const char* path = ut_get_path_xml(nullptr, &status);
      throw InputError(std::string("the unit database of UDUNITS cannot be read: ") +
                       (path != nullptr ? path : "no path known"));
    }
    if (const Unit degree{ut_get_unit_by_name(system_.get(), "degree")}) {
      ut_map_name_to_unit("deg", UT_UTF8, degree.get());
    }
  }

  /// Size of `unit` in the SI unit of `dimension`; nothing if it is no unit or of another dimension. `known` tells the
  /// two apart.
  std::optional<double> factor(std::string_view unit, const Dimension& dimension, bool& known) const {
    const Unit given = parse(unit);
    known = given != nullptr;
    const Unit wanted = parse(dimension.unit);
    if (!given || !wanted) return std::nullopt;
    const Unit left{ut_divide(given.get(), wanted.get())};
    Quotient quotient;
    if (!left || ut_accept_visitor(left.get(), &visitor, &quotient) != UT_SUCCESS) return std::nullopt;
    // An angle per length is a curvature; elsewhere a radian too many is a slip.
    const bool radian_is_free = dimension.unit == "1/m" && quotient.radians == 1;
    if (!quotient.same || (quotient.radians != 0 && !radian_is_free)) return std::nullopt;
    return quotient.factor;
  }

  /// `unit` with one missing space put in ("Nm": "N m"), or "" if that does not help.
  std::string with_space(std::string_view unit, const Dimension& dimension) const {
    for (std::size_t i = 1; i < unit.size(); ++i) {
      if (!is_letter(unit[i - 1]) || !is_letter(unit[i])) continue;
      std::string split = std::string(unit.substr(0, i)) + ' ' + std::string(unit.substr(i));
      bool known = false;
      const std::optional<double> size = factor(split, dimension, known);
      if (size && unusual_size(*size, dimension).empty()) return split;
    }
    return {};
  }

 private:
  Unit parse(std::string_view unit) const { return Unit{ut_parse(system_.get(), std::string(unit).c_str(), UT_UTF8)}; }

  std::unique_ptr<ut_system, void (*)(ut_system*)> system_;
};

}  // namespace

std::string dimension_name(const Dimension& dimension) {
  for (const Named& known : names) {
    if (known.unit == dimension.unit) return known.name;
  }
  return "a quantity in " + std::string(dimension.unit);
}

std::string expected_quantity(const Dimension& dimension, const std::string& restriction) {
  if (dimension.unit.empty()) return "a number" + restriction;
  std::string text = dimension_name(dimension) + restriction;
  for (const Named& known : names) {
    if (known.unit != dimension.unit) continue;
    text += fmt::format(", for instance \"{}\" or a number in {}", known.example, known.unit);
  }
  return text;
}

std::optional<std::pair<std::string_view, std::string_view>> split_error_bar(std::string_view text) {
  for (const std::string_view sign : {"+-", "\xc2\xb1"}) {
    const auto at = text.find(sign);
    if (at != std::string_view::npos) return std::pair(text.substr(0, at), text.substr(at + sign.size()));
  }
  return std::nullopt;
}

double Units::read(std::string_view text, const Dimension& dimension) const {
  const auto refuse = [&](std::string why, const std::string& hint = "") {
    const std::string expected = expected_quantity(dimension, dimension.unit.empty() ? " without a unit" : "");
    throw QuantityError(quoted(text), std::move(why), expected, hint);
  };
  // An error bar behind it is another number.
  const auto with_error = split_error_bar(text);
  std::string_view rest = trimmed(with_error ? with_error->first : text);
  if (rest.starts_with('+') && rest.size() > 1 && (is_digit(rest[1]) || rest[1] == '.')) rest.remove_prefix(1);

  double value = 0.0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error == std::errc::result_out_of_range) refuse("a number too large or too small to hold");
  if (error != std::errc{}) refuse("which does not begin with a number");
  if (!std::isfinite(value)) refuse("which is not finite");

  const std::string_view unit = trimmed(rest.substr(static_cast<std::size_t>(end - rest.data())));
  if (unit.empty()) {
    if (!dimension.unit.empty()) refuse("a number as text without a unit");
    return value;
  }
  if (dimension.unit.empty()) refuse("which has a unit");
  if (!looks_like_unit(unit)) refuse("and " + quoted(unit) + " is not a unit");

  const std::lock_guard lock(udunits_in_use);
  bool known = false;
  std::optional<double> factor = common_size(unit, dimension);
  if (!factor) factor = Database::of_process().factor(unit, dimension, known);
  if (!factor) {
    const std::string split = Database::of_process().with_space(unit, dimension);
    refuse(known ? "whose unit is not that of " + dimension_name(dimension)
                 : "and " + quoted(unit) + " is not a known unit",
           split.empty() ? "" : "; did you mean '" + split + "'?");
  }
  if (const std::string unusual = unusual_size(*factor, dimension); !unusual.empty()) {
    std::string other(unit);
    if (other.front() == 'M' || other.front() == 'm') other.front() = other.front() == 'M' ? 'm' : 'M';
    const auto size = Database::of_process().factor(other, dimension, known);
    const bool better = other != unit && size && unusual_size(*size, dimension).empty();
    refuse(unusual, better ? "; did you mean '" + other + "'?" : "");
  }
  const double si = value * *factor;
  if (!std::isfinite(si)) refuse("a number too large to hold");
  const auto use = std::find_if(uses_.begin(), uses_.end(),
                                [&](const Use& u) { return u.dimension == dimension.unit && u.unit.name == unit; });
  if (use == uses_.end()) {
    uses_.push_back({std::string(dimension.unit), {std::string(unit), *factor}, 1});
  } else {
    ++use->times;
  }
  return si;
}

std::map<std::string, WrittenUnit, std::less<>> Units::most_used() const {
  std::map<std::string, WrittenUnit, std::less<>> most;
  std::map<std::string, int> times;
  for (const Use& use : uses_) {
    if (use.times <= times[use.dimension]) continue;
    times[use.dimension] = use.times;
    most[use.dimension] = use.unit;
  }
  return most;
}

}  // namespace tendril::app
