#pragma once

#include <string>
#include <vector>

#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app {

/// A line of a chart. Points that are not finite, or not positive on a logarithmic axis, are left out.
struct ChartSeries {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> x_low, x_high;  ///< ends of horizontal bars; empty: none
  int color = 0;                      ///< index into a palette, wraps around
  int dash = 0;                       ///< 0: solid; 1..3: kinds of dashes
  bool steps = false;                 ///< constant between its points, without marks
};

/// A horizontal line that says something.
struct ChartLevel {
  double y = 0.0;
  std::string name;
};

struct Chart {
  std::string title, x_label, y_label;
  bool log_x = true, log_y = true;
  std::vector<ChartSeries> series;
  std::vector<ChartLevel> levels;
};

/// Draws the chart with gnuplot; `stem`.svg, .png or .pdf, and beside them its script and data. Throws InputError for a
/// chart without a point.
void draw_chart(const Chart& chart, StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
