#pragma once

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "result/result_object.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/geometry.hpp"

namespace tendril::app {

/// Reads members of a JSON value that anybody may have written.
class Reader {
 public:
  Reader(const Json& json, std::string file, std::string path)
      : json_(json), file_(std::move(file)), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& expected) const {
    throw InputError(fmt::format("{}: found {} at '{}', expected {}", file_, json_.type_name(),
                                 path_.empty() ? "/" : path_, expected));
  }
  Reader member(const std::string& name) const {
    const auto found = json_.is_object() ? json_.find(name) : json_.end();
    if (!json_.is_object() || found == json_.end()) {
      throw InputError(
          fmt::format("{}: '{}/{}' is missing, expected a result of 'tendril plan --json'", file_, path_, name));
    }
    return {*found, file_, path_ + '/' + name};
  }
  bool has(const std::string& name) const { return json_.is_object() && json_.contains(name); }
  /// A member that may be absent or null.
  std::optional<Reader> optional(const std::string& name) const {
    const auto found = json_.is_object() ? json_.find(name) : json_.end();
    if (!json_.is_object() || found == json_.end() || found->is_null()) return std::nullopt;
    return Reader(*found, file_, path_ + '/' + name);
  }
  const Json& json() const { return json_; }
  double real() const {
    if (!json_.is_number()) fail("a number");
    const double value = json_.get<double>();
    if (!std::isfinite(value)) fail("a finite number");
    return value;
  }
  int whole(int minimum, int maximum) const {
    const double value = real();
    if (value < minimum || value > maximum || value != std::floor(value))
      fail(fmt::format("a whole number from {} to {}", minimum, maximum));
    return static_cast<int>(value);
  }
  bool truth() const {
    if (!json_.is_boolean()) fail("true or false");
    return json_.get<bool>();
  }
  std::string text() const {
    if (!json_.is_string()) fail("text");
    return json_.get<std::string>();
  }
  std::vector<Reader> list() const {
    if (!json_.is_array()) fail("a list");
    std::vector<Reader> entries;
    for (std::size_t i = 0; i < json_.size(); ++i) entries.push_back({json_[i], file_, fmt::format("{}/{}", path_, i)});
    return entries;
  }
  std::vector<double> reals() const {
    std::vector<double> values;
    for (const Reader& entry : list()) values.push_back(entry.real());
    return values;
  }
  Vec2 point() const {
    const std::vector<double> values = reals();
    if (values.size() != 2) fail("a list of two numbers");
    return {values[0], values[1]};
  }

 private:
  const Json& json_;
  std::string file_;
  std::string path_;
};

/// A result as JSON. Throws InputError where it is none or of another schema; `file` and `what` the file is to be, for
/// messages.
Json parse_result(const std::string& text, const std::string& file, const std::string& what);

}  // namespace tendril::app
