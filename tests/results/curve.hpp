#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::results {

/// A backbone as it is written, read between its rows: what a row says of curvature is integrated to angles, and angles
/// to points. Between two breaks (ends of segments and actuators, contacts) a curvature is smooth, so that polynomials
/// through six rows do it to rounding; no polynomial goes across a break.
class Curve {
 public:
  struct Row {
    double s, x, y, angle, curvature;
  };

  /// `breaks`: arc lengths, m. Throws nlohmann's exceptions where the rows are none.
  Curve(const nlohmann::json& rows, std::vector<double> breaks);

  const std::vector<Row>& rows() const { return rows_; }
  double length() const { return rows_.back().s; }
  /// Largest |change of the angle - integral of the curvature| between two rows, rad.
  double slope_error() const;
  /// Largest |step - integral of (cos, sin) of the angle| between two rows, m.
  double step_error() const;
  /// Share of the length between rows on which a curvature could not be integrated: too few rows between two breaks.
  double unchecked_share() const;
  /// Angle and point at an arc length.
  double angle(double s) const;
  Vec2 at(double s) const;

 private:
  /// Rows of the same smooth stretch that are nearest to [rows_[i].s, rows_[i + 1].s], at most six. `at_breaks`: those
  /// that stand on a break as well, where the angle is single-valued and the curvature is not.
  std::vector<std::size_t> stencil(std::size_t i, bool at_breaks) const;
  double angle_in(std::size_t i, double s) const;
  Vec2 step(std::size_t i, double s) const;
  std::size_t interval(double s) const;
  bool crosses_break(std::size_t i) const;

  std::vector<Row> rows_;
  std::vector<double> breaks_;
};

}  // namespace tendril::results
