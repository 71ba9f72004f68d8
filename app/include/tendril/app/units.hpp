#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tendril/app/input_error.hpp"
#include "tendril/options.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// Dimensions that scenes use beyond those of core. They are told apart by their SI unit.
namespace dimension {
using namespace tendril::dimension;
inline constexpr Dimension acceleration{0, 0, "m/s^2"};
inline constexpr Dimension linear_density{0, 0, "kg/m"};
inline constexpr Dimension density{0, 0, "kg/m^3"};
inline constexpr Dimension force_per_length{0, 0, "N/m"};
inline constexpr Dimension mass{0, 0, "kg"};
inline constexpr Dimension time{0, 0, "s"};
inline constexpr Dimension moment_per_pressure{0, 0, "N m/Pa"};
inline constexpr Dimension force_per_pressure{0, 0, "N/Pa"};
}  // namespace dimension

/// "a length", "a force", ...; "a pure number" where the dimension has no unit.
std::string dimension_name(const Dimension& dimension);

/// What a user may write for `dimension`, for messages: `a length, for instance "60 mm" or a number in m`.
/// `restriction` follows the name ("a length greater than 0, ...").
std::string expected_quantity(const Dimension& dimension, const std::string& restriction = "");

/// Text that is not a quantity of the dimension asked for. what() says what was found and what was expected; why() only
/// what is wrong with it, for those who say the rest themselves.
class QuantityError : public InputError {
 public:
  QuantityError(const std::string& found, std::string why, const std::string& expected, const std::string& hint)
      : InputError("found " + found + ", " + why + ", expected " + expected + hint), why_(std::move(why) + hint) {
    if (why_.starts_with("and ")) why_.erase(0, 4);
  }
  const std::string& why() const { return why_; }

 private:
  std::string why_;
};

/// "8 mm +- 0.2 mm" (or with the sign of typography) as the number and what stands behind the sign; nothing where there
/// is no sign.
std::optional<std::pair<std::string_view, std::string_view>> split_error_bar(std::string_view text);

/// Reads numbers with units. The unit database of UDUNITS is opened by the first text of the process with a unit that
/// is not among the usual ones.
class Units {
 public:
  Units() = default;
  Units(const Units&) = delete;
  Units& operator=(const Units&) = delete;

  /// SI value of text such as "60 mm". The number is read without regard to the locale and must be finite; the unit
  /// must have exactly the physical dimension asked for. Throws QuantityError.
  double read(std::string_view text, const Dimension& dimension) const;
  /// The unit that was read most often for each dimension, the earlier one of two, by the dimension's SI unit.
  std::map<std::string, WrittenUnit, std::less<>> most_used() const;

 private:
  /// How often a unit was read for a dimension.
  struct Use {
    std::string dimension;
    WrittenUnit unit;
    int times = 0;
  };
  mutable std::vector<Use> uses_;
};

}  // namespace tendril::app
