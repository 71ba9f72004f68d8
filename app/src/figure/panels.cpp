#include "figure/panels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "figure/box.hpp"
#include "figure/gnuplot.hpp"

namespace tendril::app {

namespace {

double length_of(const std::vector<std::vector<ShapePanel>>& rows) {
  double longest = 0.0;
  for (const auto& row : rows) {
    for (const ShapePanel& panel : row) {
      for (const std::vector<Vec2>& rod : panel.rods) {
        double length = 0.0;
        for (std::size_t i = 1; i < rod.size(); ++i) length += norm(rod[i] - rod[i - 1]);
        longest = std::max(longest, length);
      }
    }
  }
  return longest > 0.0 ? longest : 1.0;
}

/// One window for all panels: rods and targets, and obstacles where they are near.
Box window_of(const std::vector<std::vector<ShapePanel>>& rows, double length) {
  Box window, shapes;
  for (const auto& row : rows) {
    for (const ShapePanel& panel : row) {
      window.add(panel.clamp.base);
      for (const std::vector<Vec2>& rod : panel.rods) {
        for (const Vec2 p : rod) window.add(p);
      }
      for (const Vec2 p : panel.targets) window.add(p);
      for (const ShapePanel::Obstacle& obstacle : panel.obstacles) {
        for (const ClosedLine& line : obstacle.outlines) {
          for (const Vec2 p : line) shapes.add(p);
        }
      }
    }
  }
  window.add_near(shapes, 0.35 * length);
  window.grow(0.07 * length);
  window.widen({0.0, 0.4 * window.size().x});
  return window;
}

/// Of the data file; with its end no name begins another one, as gnuplot looks for them. `item`: 0 where there is one.
std::string panel_block(int panel, const std::string& name, std::size_t item) {
  return item > 0 ? fmt::format("{} {} {}.", name, panel, item) : fmt::format("{} {}.", name, panel);
}

struct Rgb {
  double red, green, blue;
};
constexpr Rgb light_blue{186.0, 210.0, 236.0}, dark_blue{12.0, 44.0, 94.0};
constexpr Rgb light_green{176.0, 222.0, 172.0}, dark_green{18.0, 84.0, 26.0};

/// The colour of item i of n between two.
std::string between(const Rgb& light, const Rgb& dark, std::size_t i, std::size_t n) {
  const double t = n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 1.0;
  const auto mix = [t](double a, double b) { return static_cast<int>(std::lround((1.0 - t) * a + t * b)); };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(light.red, dark.red), mix(light.green, dark.green),
                     mix(light.blue, dark.blue));
}

/// Where things are on the canvas, in pixels from the top left.
struct Layout {
  int columns = 1;
  double panel_width = 0.0, panel_height = 0.0, bar_height = 0.0;
  double left = 100.0, right = 30.0, top = 16.0, between_columns = 70.0, above_panel = 50.0, below_panel = 88.0;
  double legend = 44.0;
  double width = 0.0, height = 0.0;
};

Layout layout_of(const std::string& title, const std::vector<std::vector<ShapePanel>>& rows,
                 const std::vector<BarPanel>& bars, const std::vector<LoopPanel>& loops, const Box& window) {
  Layout at;
  std::size_t columns = std::max(bars.size(), loops.size());
  for (const auto& row : rows) columns = std::max(columns, row.size());
  at.columns = static_cast<int>(columns);
  at.panel_width = columns == 1 ? 800.0 : columns == 2 ? 520.0 : 400.0;
  at.panel_height = at.panel_width * (window.high.y - window.low.y) / (window.high.x - window.low.x);
  at.bar_height = bars.empty() && loops.empty() ? 0.0 : 320.0;
  if (!title.empty()) at.top += 30.0;
  const auto count = static_cast<double>(columns);
  at.width = at.left + count * at.panel_width + (count - 1.0) * at.between_columns + at.right;
  at.height = at.top + at.legend;
  at.height += static_cast<double>(rows.size()) * (at.above_panel + at.panel_height + at.below_panel);
  if (at.bar_height > 0.0) at.height += at.above_panel + at.bar_height + at.below_panel;
  if (!bars.empty()) at.height += at.legend;
  return at;
}

class Script {
 public:
  Script(const Layout& layout, LengthUnit unit, std::string data)
      : at_(layout), unit_(unit), data_(std::move(data)), y_(layout.top) {}

  void title(const std::string& title) {
    if (title.empty()) return;
    text_ += fmt::format("set label 1000 {} at screen 0.5,{:.6g} center noenhanced font ',18'\n", gnuplot_string(title),
                         1.0 - 26.0 / at_.height);
  }

  void shapes(const std::vector<ShapePanel>& row, const Box& window) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      place(i, at_.panel_height);
      text_ += fmt::format("set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n", window.low.x / unit_.size,
                           window.high.x / unit_.size, window.low.y / unit_.size, window.high.y / unit_.size);
      text_ += fmt::format("set xtics autofreq\nset xlabel 'x ({0})' noenhanced offset 0,0.3\n", unit_.name);
      text_ += i == 0 ? fmt::format("set ylabel 'y ({0})' noenhanced offset 1,0\n", unit_.name) : "unset ylabel\n";
      heading(row[i].title);
      plot(row[i]);
    }
    y_ += at_.above_panel + at_.panel_height + at_.below_panel;
  }

  void bars(const std::vector<BarPanel>& panels) {
    double highest = 0.0;
    for (const BarPanel& panel : panels) {
      for (const BarPanel::Series& series : panel.series) {
        for (std::size_t q = 0; q < series.values.size(); ++q) {
          highest = std::max(highest, series.values[q] + series.deviations[q]);
        }
      }
    }
    for (std::size_t i = 0; i < panels.size(); ++i) {
      const BarPanel& panel = panels[i];
      place(i, at_.bar_height);
      std::string tics;
      for (std::size_t q = 0; q < panel.quantities.size(); ++q) {
        tics += fmt::format("{}{} {}", q > 0 ? ", " : "", gnuplot_string(panel.quantities[q].name), q);
        text_ += fmt::format("set label {} {} at first {},graph 0 center offset 0,-2.1 noenhanced font ',12'\n",
                             first_unit_label + q, gnuplot_string('(' + panel.quantities[q].unit + ')'), q);
      }
      text_ += fmt::format("set xrange [-0.6:{:.6g}]\nset yrange [0:{:.6g}]\n",
                           static_cast<double>(panel.quantities.size()) - 0.4, highest > 0.0 ? 1.18 * highest : 1.0);
      text_ += "set xtics (" + tics + ") scale 0 font ',12'\nunset xlabel\nset style fill solid 0.85 noborder\n";
      text_ += i == 0 ? "set ylabel '" + panel.axis + "' noenhanced offset 1,0\n" : "unset ylabel\n";
      heading(panel.title);
      std::string parts;
      const double width = 0.76 / static_cast<double>(panel.series.size());
      for (std::size_t k = 0; k < panel.series.size(); ++k) {
        const std::string block = fmt::format("{} index 'bars {} {}' ", data_, i + 1, k + 1);
        parts += fmt::format(
            "{0}{1}using 1:2:({2:.6g}) with boxes linecolor rgb '{3}' notitle, \\\n     "
            "{1}using 1:($2-$3):(0):(2*$3) with vectors heads size graph 0.012,90 linewidth 1.3 linecolor rgb "
            "'#303030' notitle, "
            "\\\n     "
            "{1}using 1:($2+$3):(sprintf('%.3g',$2)) with labels offset 0,0.6 font ',11' notitle",
            k > 0 ? ", \\\n     " : "plot ", block, 0.92 * width, panel.series[k].color);
      }
      text_ += parts + "\nset xtics scale 1 font ''\n";
      for (std::size_t q = 0; q < panel.quantities.size(); ++q) {
        text_ += fmt::format("unset label {}\n", first_unit_label + q);
      }
    }
    y_ += at_.above_panel + at_.bar_height + at_.below_panel;
  }

  void loops(const std::vector<LoopPanel>& panels) {
    for (std::size_t i = 0; i < panels.size(); ++i) {
      place(i, at_.bar_height);
      text_ += fmt::format(
          "set xrange [*:*]\nset yrange [*:*]\nset xtics autofreq font ',12'\nset xlabel {} noenhanced offset "
          "0,0.3\nset ylabel {} noenhanced offset 1,0\n",
          gnuplot_string(panels[i].x_label), gnuplot_string(panels[i].y_label));
      heading(panels[i].title);
      text_ += fmt::format(
          "plot {} index '{}' using 1:2 with linespoints pointtype 7 pointsize 0.7 linewidth 1.6 linecolor rgb "
          "'#1f4e8c' notitle\n",
          data_, panel_block(static_cast<int>(i) + 1, "loop", 0));
    }
  }

  struct Entry {
    std::string text;
    std::string line_color{}, point_color{};
    int point_type = 7;
    double line_width = 5.0;
  };
  /// A line of the legend at the current height; drawn with the next panel.
  void legend(const std::vector<Entry>& entries) {
    double x = at_.left;
    const double y = 1.0 - (y_ + 0.4 * at_.legend) / at_.height;
    for (const Entry& entry : entries) {
      if (!entry.line_color.empty()) {
        text_ += fmt::format(
            "set arrow {} from screen {:.6g},{:.6g} to screen {:.6g},{:.6g} nohead linewidth {} linecolor rgb '{}'\n",
            ++mark_, x / at_.width, y, (x + 34.0) / at_.width, y, entry.line_width, entry.line_color);
      } else {
        text_ += fmt::format(
            "set label {} '' at screen {:.6g},{:.6g} point pointtype {} pointsize 1.3 linewidth 2 linecolor rgb '{}'\n",
            ++mark_, (x + 17.0) / at_.width, y, entry.point_type, entry.point_color);
      }
      text_ += fmt::format("set label {} {} at screen {:.6g},{:.6g} left noenhanced\n", ++mark_,
                           gnuplot_string(entry.text), (x + 46.0) / at_.width, y);
      x += 42.0 + 11.2 * static_cast<double>(entry.text.size()) + (at_.columns == 1 ? 26.0 : 56.0);
    }
    y_ += at_.legend;
  }
  void skip(double pixels) { y_ += pixels; }
  double height() const { return y_; }
  const std::string& text() const { return text_; }
  void set_lettered(bool lettered) { lettered_ = lettered; }

 private:
  void place(std::size_t column, double height) {
    const double left = at_.left + static_cast<double>(column) * (at_.panel_width + at_.between_columns);
    const double top = y_ + at_.above_panel;
    text_ += fmt::format(
        "set lmargin at screen {:.6g}\nset rmargin at screen {:.6g}\nset tmargin at screen {:.6g}\nset bmargin at "
        "screen {:.6g}\n",
        left / at_.width, (left + at_.panel_width) / at_.width, 1.0 - top / at_.height,
        1.0 - (top + height) / at_.height);
  }

  void heading(const std::string& title) {
    const std::string letter = lettered_ && letter_ < 26 ? fmt::format("({}) ", static_cast<char>('a' + letter_)) : "";
    ++letter_;
    text_ += "set title " + gnuplot_string(letter + title) + " noenhanced offset 0,-0.5\n";
  }

  void plot(const ShapePanel& panel) {
    ++panel_;
    std::vector<std::string> parts;
    const auto block = [&](const std::string& name, std::size_t i) {
      return fmt::format("{} index '{}' using 1:2", data_, panel_block(panel_, name, i));
    };
    for (std::size_t i = 0; i < panel.obstacles.size(); ++i) {
      const std::string edge = block("edge", i + 1);
      if (panel.obstacles[i].ignored) {
        parts.push_back(edge + " with lines dashtype (4,4) linewidth 1.2 linecolor rgb '#808080' notitle");
      } else {
        parts.push_back(block("obstacle", i + 1) +
                        " with filledcurves closed fillstyle solid 1.0 fillcolor rgb '#d5d5d5' notitle");
        parts.push_back(edge + " with lines linewidth 1.2 linecolor rgb '#707070' notitle");
      }
    }
    parts.push_back(block("clamp", 0) + " with lines linewidth 1.5 linecolor rgb '#404040' notitle");
    const std::size_t n = panel.rods.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::string color = panel.ordered ? between(light_blue, dark_blue, i, n) : panel.color;
      parts.push_back(fmt::format("{} with lines linewidth {} linecolor rgb '{}' notitle", block("rod", i + 1),
                                  at_.columns == 1 ? 2.0 : 1.6, color));
    }
    for (std::size_t i = 0; i < panel.targets.size(); ++i) {
      parts.push_back(fmt::format(
          "{} with points pointtype 7 pointsize {} linecolor rgb '{}' notitle", block("target", i + 1),
          at_.columns == 1 ? 0.7 : 0.45,
          panel.ordered ? between(light_green, dark_green, i, panel.targets.size()) : std::string("#2e9d3a")));
    }
    if (!panel.contacts.empty()) {
      parts.push_back(fmt::format("{} with points pointtype 7 pointsize {} linecolor rgb '#c0392b' notitle",
                                  block("contacts", 0), at_.columns == 1 ? 0.6 : 0.4));
    }
    text_ += "plot ";
    for (std::size_t i = 0; i < parts.size(); ++i) text_ += (i > 0 ? ", \\\n     " : "") + parts[i];
    text_ += '\n';
    for (; mark_ > 0; --mark_) text_ += fmt::format("unset label {0}\nunset arrow {0}\n", mark_);
    text_ += "unset label 1000\n";
  }

  /// Beyond the labels of a legend.
  static constexpr std::size_t first_unit_label = 2000;

  const Layout& at_;
  LengthUnit unit_;
  std::string data_;
  std::string text_;
  double y_;
  bool lettered_ = false;
  int letter_ = 0, panel_ = 0, mark_ = 0;
};

DataFile data_of(const std::vector<std::vector<ShapePanel>>& rows, const std::vector<BarPanel>& bars,
                 const std::vector<LoopPanel>& loops, double length, const Box& window, LengthUnit unit) {
  DataFile data(unit);
  int number = 0;
  for (const auto& row : rows) {
    for (const ShapePanel& panel : row) {
      ++number;
      for (std::size_t i = 0; i < panel.obstacles.size(); ++i) {
        add_outlines(data, panel.obstacles[i].outlines, window, panel_block(number, "obstacle", i + 1),
                     panel_block(number, "edge", i + 1));
      }
      add_clamp(data, panel.clamp.base, panel.clamp.angle, length, panel_block(number, "clamp", 0));
      for (std::size_t i = 0; i < panel.rods.size(); ++i) {
        data.block(panel_block(number, "rod", i + 1), "x y");
        for (const Vec2 p : panel.rods[i]) data.row(p);
      }
      for (std::size_t i = 0; i < panel.targets.size(); ++i) {
        data.block(panel_block(number, "target", i + 1), "x y");
        data.row({panel.targets[i].x, panel.targets[i].y});
      }
      if (panel.contacts.empty()) continue;
      data.block(panel_block(number, "contacts", 0), "x y");
      for (const Vec2 p : panel.contacts) data.row(p);
    }
  }
  for (std::size_t i = 0; i < bars.size(); ++i) {
    for (std::size_t k = 0; k < bars[i].series.size(); ++k) {
      const BarPanel::Series& series = bars[i].series[k];
      data.block(fmt::format("bars {} {}", i + 1, k + 1), "place mean deviation, in the units of the axis");
      const double width = 0.76 / static_cast<double>(bars[i].series.size());
      for (std::size_t q = 0; q < series.values.size(); ++q) {
        const double shift =
            (static_cast<double>(k) - 0.5 * (static_cast<double>(bars[i].series.size()) - 1.0)) * width;
        data.numbers({static_cast<double>(q) + shift, series.values[q], series.deviations[q]});
      }
    }
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    data.block(panel_block(static_cast<int>(i) + 1, "loop", 0), "x y, in the units of the axes");
    for (const Vec2 p : loops[i].points) data.numbers({p.x, p.y});
  }
  return data;
}

std::vector<Script::Entry> shape_legend(const std::vector<std::vector<ShapePanel>>& rows) {
  bool ordered = false;
  bool contacts = false;
  const char* targets = nullptr;
  for (const auto& row : rows) {
    for (const ShapePanel& panel : row) {
      ordered = ordered || panel.ordered;
      contacts = contacts || !panel.contacts.empty();
      if (!panel.targets.empty()) targets = panel.targets_are;
    }
  }
  std::vector<Script::Entry> entries;
  if (ordered) {
    entries.push_back({"first step", between(light_blue, dark_blue, 0, 2)});
    entries.push_back({"last step", between(light_blue, dark_blue, 1, 2)});
    if (targets != nullptr)
      entries.push_back({std::string(targets) + ", in order", "", between(light_green, dark_green, 1, 2)});
  } else if (targets != nullptr) {
    entries.push_back({targets, "", "#2e9d3a"});
  }
  if (contacts) entries.push_back({"contact points", "", "#c0392b"});
  return entries;
}

}  // namespace

ShapePanel::ShapePanel(const Json& drawing) {
  for (const Json& shape : drawing["obstacles"]) obstacles.push_back({lines_of(shape), shape.value("ignored", false)});
  for (const Json& frame : drawing["frames"]) {
    if (frame["rods"].empty()) continue;
    clamp = clamp_of(frame["rods"][0]);
    break;
  }
}

void ShapePanel::add(const Json& frame) {
  const auto points_of = [](const Json& list) {
    std::vector<Vec2> points;
    points.reserve(list.size());
    for (const Json& p : list) points.push_back(point(p));
    return points;
  };
  for (const Json& rod : frame["rods"]) rods.push_back(points_of(rod["line"]));
  if (const auto own = frame.find("obstacles"); own != frame.end()) {
    for (const Json& shape : *own) obstacles.push_back({lines_of(shape), shape.value("ignored", false)});
  }
  if (has_target(frame)) targets.push_back(point(frame["target"]["position"]));
  if (has<path_key>(frame)) {
    ordered = true;
    for (const Vec2 p : points_of(frame["path"])) targets.push_back(p);
  }
  for (const Json& contact : frame["contacts"]) {
    if (presses(contact) || touches(contact)) contacts.push_back(point(contact["surface"]));
  }
}

std::vector<LoopPanel> LoopPanel::of(const Json& drawing) {
  std::vector<LoopPanel> panels;
  if (!drawing.contains("loops")) return panels;
  for (const Json& loop : drawing["loops"]) {
    LoopPanel& panel = panels.emplace_back();
    panel.title = "friction at " + loop["obstacle"].get<std::string>() + " (N)";
    panel.x_label = fmt::format("{} ({})", loop["input"].get<std::string>(), loop["unit"].get<std::string>());
    panel.y_label = "force along the rod (N)";
    for (const Json& p : loop["points"]) panel.points.push_back(point(p));
  }
  return panels;
}

void draw_panels(const std::string& title, const std::vector<std::vector<ShapePanel>>& shapes,
                 const std::vector<BarPanel>& bars, const std::vector<LoopPanel>& loops, StagedFiles& files,
                 const std::string& stem, const std::vector<Picture>& pictures) {
  const double length = length_of(shapes);
  const LengthUnit unit = unit_for(length);
  const Box window = window_of(shapes, length);
  const Layout layout = layout_of(title, shapes, bars, loops, window);
  Script script(layout, unit, gnuplot_file(stem + ".dat"));
  std::size_t count = bars.size() + loops.size();
  for (const auto& row : shapes) count += row.size();
  script.set_lettered(count > 1);
  script.title(title);
  const double below_shapes =
      layout.top + static_cast<double>(shapes.size()) * (layout.above_panel + layout.panel_height + layout.below_panel);
  script.skip(below_shapes - layout.top);
  script.legend(shape_legend(shapes));
  if (!bars.empty()) {
    std::vector<Script::Entry> entries;
    for (const BarPanel::Series& series : bars.front().series) {
      if (!series.name.empty()) entries.push_back({series.name, series.color, "", 7, 12.0});
    }
    script.skip(layout.above_panel + layout.bar_height + layout.below_panel);
    script.legend(entries);
    script.skip(-(layout.above_panel + layout.bar_height + layout.below_panel) - layout.legend);
  }
  script.skip(-(below_shapes - layout.top) - layout.legend);
  for (const auto& row : shapes) script.shapes(row, window);
  script.skip(layout.legend);
  if (!bars.empty()) script.bars(bars);
  script.loops(loops);

  const std::string draw = "set multiplot\n" + script.text() + "unset multiplot\n";
  render({data_of(shapes, bars, loops, length, window, unit).text(),
          "unset key\nset border 3 linewidth 1 linecolor rgb '#404040'\n"
          "set tics out nomirror textcolor rgb '#404040'\n"
          "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\n",
          draw, draw, static_cast<int>(layout.width), static_cast<int>(layout.height)},
         files, stem, pictures);
}

}  // namespace tendril::app
