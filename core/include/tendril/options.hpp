#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tendril/error.hpp"
#include "tendril/export.hpp"
#include "tendril/scale.hpp"

namespace tendril {

/// Where a value stands in a scene file; line 0: not from a file (the command line or a program).
struct SourcePosition {
  int line = 0;    ///< counted from 1
  int column = 0;  ///< counted from 1
};

/// A value as a user wrote it, before its type and unit are checked.
struct RawValue {
  using List = std::vector<RawValue>;                                 ///< Values in brackets.
  std::variant<bool, std::int64_t, double, std::string, List> value;  ///< as written
  SourcePosition position{};                                          ///< where it stands
};

/// Options as given, by name. Sorted, so that reports are stable.
using RawOptions = std::map<std::string, RawValue, std::less<>>;

/// What kind of value an option takes.
enum class OptionType {
  boolean,
  integer,
  real,
  text,
  list,    ///< numbers in a row
  points,  ///< [x, y] each
  matrix   ///< rows of numbers of equal length; a list is taken as the diagonal, a number as a multiple of the identity
};

/// Numbers in row-major order. A list has one row.
struct NumberTable {
  int rows = 0;                ///< 1 for a list
  int columns = 0;             ///< entries of a row
  std::vector<double> values;  ///< rows * columns
  /// Entry of a row and a column, both counted from 0; not checked.
  double operator()(int row, int column) const { return values[static_cast<std::size_t>(row * columns + column)]; }
};

/// A checked value; std::monostate: none.
using OptionValue = std::variant<std::monostate, bool, std::int64_t, double, std::string, NumberTable>;

/// Declares one option of a component: what it is called, may be, and is if nothing is said.
struct OptionSpec {
  std::string name;                                           ///< as a scene writes it
  OptionType type = OptionType::real;                         ///< what it takes
  OptionValue default_value{};                                ///< std::monostate: absent unless given
  std::string description{};                                  ///< for the reference page and messages
  double minimum = -std::numeric_limits<double>::infinity();  ///< in SI; also for each number of a list
  double maximum = std::numeric_limits<double>::infinity();   ///< likewise
  Dimension dimension = dimension::none;                      ///< in which a scene may give it
  std::vector<std::string> choices{};                         ///< for text: the only words allowed; empty: any
  bool required = false;                                      ///< A scene that does not give it is refused.
  bool minimum_excluded = false;                              ///< `minimum` itself is refused (a radius of 0)
  int size = 0;  ///< for a list: number of entries, 0: any; for points: least number
};

using OptionSchema = std::vector<OptionSpec>;  ///< All options of a component.

/// An OptionSpec of this name lets every option pass that the schema does not list: its value is handed over in the
/// type in which it was written (a list is refused). For backends whose own library knows hundreds of options.
inline constexpr std::string_view any_option = "*";

/// An option that is unknown, of the wrong type, or out of range. `option()` names it; `position()` says where it
/// stands.
class TENDRIL_API OptionError : public Error {
 public:
  /// `option` is its name, `message` is for a user.
  OptionError(std::string option, SourcePosition position, const std::string& message);
  OptionError(const OptionError&) = default;  ///< As exceptions are.
  ~OptionError() override;
  /// Name of the option.
  const std::string& option() const { return option_; }
  /// Where it stands.
  SourcePosition position() const { return position_; }

 private:
  std::string option_;
  SourcePosition position_;
};

/// Options after checking: dimensionless numbers of the declared type. This is what a component's factory sees.
class TENDRIL_API Options {
 public:
  Options() = default;
  /// Empty; set() fills it.
  explicit Options(const Scale& scale) : scale_(scale) {}

  bool has(std::string_view name) const;  ///< present (given, or by default)
  /// Value of a boolean. This and the following throw Error for an absent option and for one of another type.
  bool boolean(std::string_view name) const;
  std::int64_t integer(std::string_view name) const;     ///< Value of an integer.
  double real(std::string_view name) const;              ///< Value of a real number, dimensionless.
  const std::string& text(std::string_view name) const;  ///< Value of a text.
  /// Value of a list, of points, or of a matrix; dimensionless.
  const NumberTable& table(std::string_view name) const;

  /// Gives an option a value, which is taken as it is.
  void set(std::string name, OptionValue value);
  /// All values by name.
  const std::map<std::string, OptionValue, std::less<>>& values() const { return values_; }
  /// Size of the dimensionless units (for reports; computations need it rarely).
  const Scale& scale() const { return scale_; }

 private:
  const OptionValue& at(std::string_view name) const;
  std::map<std::string, OptionValue, std::less<>> values_;
  Scale scale_{};
};

/// Turns text such as "60 mm" into an SI number of the dimension asked for; throws Error with the reason.
using QuantityReader = std::function<double(std::string_view text, const Dimension&)>;

/// Checks `given` against `schema`, fills in defaults, converts to dimensionless numbers. Throws OptionError; an
/// unknown name is answered with the nearest known one. `read` is used for numbers written as text; if empty such
/// numbers are refused. `owner` is named in messages, for instance "coordinates plugin 'legendre'".
TENDRIL_API Options resolve_options(const OptionSchema& schema, const RawOptions& given, const Scale& scale,
                                    const QuantityReader& read, std::string_view owner);

/// The entry of `known` nearest to `name` in edit distance, or "" if none is near enough to be meant.
TENDRIL_API std::string nearest_name(std::string_view name, std::span<const std::string> known);

/// "; did you mean 'x'?" for the nearest name, or " (known: a, b, c)" when none is near.
TENDRIL_API std::string did_you_mean(std::string_view name, std::span<const std::string> known);

/// What a component says of itself, and how to make one.
template <class Interface>
struct Component {
  std::string name;                                                ///< as scenes write it: lower case, digits, '_'
  std::string description;                                         ///< one line
  OptionSchema options;                                            ///< what a scene may set
  std::function<std::unique_ptr<Interface>(const Options&)> make;  ///< from checked, dimensionless options
};

}  // namespace tendril
