#include "system/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tendril/scale.hpp"

namespace tendril::app {

DisplayUnits::DisplayUnits(const Scene& scene) {
  const double size = scene.rod.length();
  const auto written = [&](std::string_view dimension, const WrittenUnit& otherwise) {
    const auto found = scene.units.find(dimension);
    return found != scene.units.end() ? found->second : otherwise;
  };
  length = written(dimension::length.unit, size < 2e-3  ? WrittenUnit{"um", 1e-6}
                                           : size < 2.0 ? WrittenUnit{"mm", 1e-3}
                                                        : WrittenUnit{"m", 1.0});
  moment_unit = written(dimension::moment.unit, {"N " + length.name, length.size});
  pressure_unit = written("Pa", {"kPa", 1e3});
}

// Adding 0 takes the sign from a zero: nobody means -0.

namespace {

std::string in_unit(double si, const WrittenUnit& unit) {
  return fmt::format("{:.6g} {}", si / unit.size + 0.0, unit.name);
}

}  // namespace

std::string DisplayUnits::lengths(double si) const { return in_unit(si, length); }

std::string DisplayUnits::point(Vec2 p) const {
  return fmt::format("({:.6g}, {:.6g}) {}", p.x / length.size + 0.0, p.y / length.size + 0.0, length.name);
}

std::string DisplayUnits::moment(double si) const { return in_unit(si, moment_unit); }

std::string DisplayUnits::pressure(double si) const { return in_unit(si, pressure_unit); }

std::string force(double si) {
  const double size = std::abs(si);
  if (size >= 1.0 || size == 0.0) return fmt::format("{:.6g} N", si + 0.0);
  if (size >= 1e-3) return fmt::format("{:.6g} mN", si * 1e3);
  return fmt::format("{:.6g} uN", si * 1e6);
}

std::string angle(double rad) {
  return fmt::format("{:.6g} rad ({:.4g} deg)", rad + 0.0, rad * 180.0 / std::numbers::pi + 0.0);
}

std::string seconds(double s) {
  if (s < 1e-3) return fmt::format("{:.3g} us", s * 1e6);
  return s < 1.0 ? fmt::format("{:.3g} ms", s * 1e3) : fmt::format("{:.3g} s", s);
}

std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += (c >= 0 && c < ' ') || c == 127 ? '?' : c;
  return out;
}

std::string Grid::text(const std::string& indent) const {
  std::vector<std::size_t> widths;
  for (const auto& cells : rows_) {
    widths.resize(std::max(widths.size(), cells.size()), 0);
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], cells[i].size());
  }
  std::string out;
  for (const auto& cells : rows_) {
    std::string one = indent;
    for (std::size_t i = 0; i < cells.size(); ++i) one += fmt::format("{:<{}}", cells[i], widths[i] + 2);
    out += one.substr(0, one.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

}  // namespace tendril::app
