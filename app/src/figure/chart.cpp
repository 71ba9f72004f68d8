#include "tendril/app/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "figure/gnuplot.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/numbers.hpp"

namespace tendril::app {

namespace {

/// Told apart by people who do not see all colours (Okabe and Ito), the yellow darkened for lines on white.
constexpr const char* palette[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8930b",
                                   "#56b4e9", "#000000", "#8c5a2b", "#7a7a7a"};
constexpr const char* dashes[] = {"solid", "(14,6)", "(4,5)", "(14,5,4,5)"};
constexpr int marks[] = {7, 5, 9, 11, 13, 15, 6, 4, 8};

template <std::size_t Size, class T>
T pick(const T (&list)[Size], int index) {
  return list[static_cast<std::size_t>(std::max(index, 0)) % Size];
}

struct Range {
  double low = infinity, high = -infinity;
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
};

bool drawable(double v, bool log) { return std::isfinite(v) && (!log || v > 0.0); }

/// With some room, so that nothing lies on the frame.
std::string range_text(char axis, Range range, bool log) {
  if (log) {
    double room = std::pow(range.high / range.low, 0.04);
    if (room < 1.05) room = 1.5;
    return fmt::format("set {}range [{:.6g}:{:.6g}]\n", axis, range.low / room, range.high * room);
  }
  double room = 0.04 * (range.high - range.low);
  if (room == 0.0) room = range.high == 0.0 ? 1.0 : 0.1 * std::abs(range.high);
  return fmt::format("set {}range [{:.6g}:{:.6g}]\n", axis, range.low - room, range.high + room);
}

/// Tics of a logarithmic axis: every decade, or every second or third of many; 1-2-5 where there is less than two.
std::string tics_text(char axis, Range range) {
  const double decades = std::log10(range.high / range.low);
  if (decades >= 2.0) {
    const int step = static_cast<int>(std::ceil(decades / 8.0));
    std::string text = fmt::format("set format {} '10^{{%L}}'\n", axis);
    text += fmt::format("set {0}tics 1e{1}\nset m{0}tics {2}\n", axis, step, step == 1 ? 10 : 1);
    return text;
  }
  std::string list;
  for (int e = static_cast<int>(std::floor(std::log10(range.low))) - 1; e <= std::log10(range.high) + 1; ++e) {
    for (const int m : {1, 2, 5}) {
      const double v = m * std::pow(10.0, e);
      list += fmt::format("{}'{:.6g}' {:.6g}", list.empty() ? "" : ", ", v, v);
    }
  }
  return fmt::format("set {}tics ({})\n", axis, list);
}

}  // namespace

void draw_chart(const Chart& chart, StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
  Range x, y;
  std::string data = "# " + chart.x_label + " against " + chart.y_label + '\n';
  std::vector<std::string> parts;
  const std::string file = gnuplot_file(stem + ".dat");
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& series = chart.series[i];
    const bool bars = !series.x_low.empty();
    std::string rows;
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!drawable(series.x[k], chart.log_x) || !drawable(series.y[k], chart.log_y)) continue;
      x.add(series.x[k]);
      y.add(series.y[k]);
      rows += fmt::format("{:.9g} {:.9g}", series.x[k], series.y[k]);
      if (bars) rows += fmt::format(" {:.9g} {:.9g}", series.x_low[k], series.x_high[k]);
      rows += '\n';
    }
    if (rows.empty()) continue;
    data += fmt::format("\n\n# series {}\n{}", i + 1, rows);
    const std::string block = fmt::format("{} index 'series {}' ", file, i + 1);
    const std::string line = fmt::format(
        "linewidth 2 dashtype {} linecolor rgb '{}'",
        pick(dashes, series.dash + series.color / static_cast<int>(std::size(palette))), pick(palette, series.color));
    const std::string title = "title " + gnuplot_string(series.name) + " noenhanced";
    if (bars) {
      parts.push_back(block + fmt::format("using 1:2:3:4 with xerrorbars pointtype 0 linewidth 1 linecolor rgb '{}' "
                                          "notitle",
                                          pick(palette, series.color)));
    }
    parts.push_back(
        series.steps
            ? block + "using 1:2 with steps " + line + ' ' + title
            : block + fmt::format("using 1:2 with linespoints pointtype {} pointsize 0.8 ", pick(marks, series.color)) +
                  line + ' ' + title);
  }
  if (parts.empty()) throw InputError("no figure: found no point that can be drawn in '" + chart.title + "'");
  for (const ChartLevel& level : chart.levels) {
    if (drawable(level.y, chart.log_y)) y.add(level.y);
  }

  std::string script = "set title " + gnuplot_string(chart.title) + " noenhanced\n";
  script += "set xlabel " + gnuplot_string(chart.x_label) + " noenhanced\n";
  script += "set ylabel " + gnuplot_string(chart.y_label) + " noenhanced\n";
  script +=
      "set border 3 linewidth 1 linecolor rgb '#404040'\n"
      "set tics out nomirror textcolor rgb '#404040'\n"
      "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\n"
      "set key outside right top Left reverse maxcols 1 ";
  // Long lists have to fit beside the plot.
  script += chart.series.size() > 14 ? "samplen 2 spacing 1.0 font ',11'\n" : "samplen 2.6 spacing 1.25\n";
  if (chart.log_x) script += "set logscale x\n" + tics_text('x', x);
  if (chart.log_y) script += "set logscale y\n" + tics_text('y', y);
  script += range_text('x', x, chart.log_x) + range_text('y', y, chart.log_y);
  for (const ChartLevel& level : chart.levels) {
    if (!drawable(level.y, chart.log_y)) continue;
    script += fmt::format(
        "set arrow from graph 0,first {0:.6g} to graph 1,first {0:.6g} nohead back dashtype (2,4) linewidth 1.5 "
        "linecolor rgb '#606060'\n"
        "set label {1} at graph 0.99,first {0:.6g} right offset 0,0.5 noenhanced textcolor rgb '#606060' font ',13'\n",
        level.y, gnuplot_string(level.name));
  }
  std::string plot = "plot ";
  for (std::size_t i = 0; i < parts.size(); ++i) plot += (i > 0 ? ", \\\n     " : "") + parts[i];
  render({data, script, plot + '\n', "replot\n", 1100, 620}, files, stem, pictures);
}

}  // namespace tendril::app
