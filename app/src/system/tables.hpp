#pragma once

#include <string>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// The units that the scene is written in; where it names none, those that suit the size of the rod.
struct DisplayUnits {
  WrittenUnit length, moment_unit, pressure_unit;

  explicit DisplayUnits(const Scene& scene);
  std::string lengths(double si) const;
  std::string point(Vec2 p) const;
  std::string moment(double si) const;
  std::string pressure(double si) const;
};

/// A force, an angle, a time with a unit of a suitable size.
std::string force(double si);
std::string angle(double rad);
std::string seconds(double s);

/// Text of a scene must not move the cursor or change colours.
std::string printable(const std::string& text);

/// Rows of cells, each column as wide as its widest cell.
class Grid {
 public:
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  std::string text(const std::string& indent) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace tendril::app
