#include "obstacle/shape_options.hpp"

#include <utility>

namespace tendril {

OptionSpec point_option(std::string name, std::string description) {
  OptionSpec point;
  point.name = std::move(name);
  point.type = OptionType::list;
  point.size = 2;
  point.required = true;
  point.dimension = dimension::length;
  point.description = std::move(description);
  return point;
}

OptionSpec points_option(std::string name, int least, std::string description) {
  OptionSpec points = point_option(std::move(name), std::move(description));
  points.type = OptionType::points;
  points.size = least;
  return points;
}

OptionSpec positive_length_option(std::string name, std::string description) {
  OptionSpec length;
  length.name = std::move(name);
  length.type = OptionType::real;
  length.required = true;
  length.minimum = 0.0;
  length.minimum_excluded = true;
  length.dimension = dimension::length;
  length.description = std::move(description);
  return length;
}

void refuse_option(const std::string& shape, const std::string& option, const std::string& found,
                   const std::string& expected) {
  throw OptionError(option, {},
                    "option '" + option + "' of a " + shape + ": found " + found + "; expected " + expected);
}

Vec2 point_of(const Options& options, std::string_view name) {
  const NumberTable& at = options.table(name);
  return {at(0, 0), at(0, 1)};
}

}  // namespace tendril
