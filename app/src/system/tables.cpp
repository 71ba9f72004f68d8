#include "system/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tendril::app {

DisplayUnits::DisplayUnits(double rod_length) {
  if (rod_length < 2e-3) {
    length = "um";
    length_size = 1e-6;
  } else if (rod_length < 2.0) {
    length = "mm";
    length_size = 1e-3;
  }
}

// Adding 0 takes the sign from a zero: nobody means -0.

std::string DisplayUnits::lengths(double si) const { return fmt::format("{:.6g} {}", si / length_size + 0.0, length); }

std::string DisplayUnits::point(Vec2 p) const {
  return fmt::format("({:.6g}, {:.6g}) {}", p.x / length_size + 0.0, p.y / length_size + 0.0, length);
}

std::string DisplayUnits::moment(double si) const { return fmt::format("{:.6g} N {}", si / length_size + 0.0, length); }

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
