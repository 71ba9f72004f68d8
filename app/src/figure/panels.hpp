#pragma once

#include <string>
#include <vector>

#include "figure/frames.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app {

/// Shapes of one rod in one picture.
struct ShapePanel {
  struct Obstacle {
    std::vector<ClosedLine> outlines;
    bool ignored = false;  ///< the plan knows nothing of it
  };
  ShapePanel() = default;
  /// An empty panel of a drawing: its obstacles, and where its rod is held.
  explicit ShapePanel(const Json& drawing);
  /// Adds the rods, targets and contacts of one of its frames.
  void add(const Json& frame);

  std::string title;
  std::vector<Obstacle> obstacles;
  Clamp clamp;
  std::vector<std::vector<Vec2>> rods;  ///< m
  std::vector<Vec2> targets, contacts;  ///< m
  const char* targets_are = "targets";  ///< in the legend
  bool ordered = false;                 ///< rods and targets go from light to dark
  std::string color = "#1f4e8c";        ///< of the rods, if not ordered
};

/// Bars with deviations: a group for each quantity, in it a bar for each series.
struct BarPanel {
  struct Series {
    std::string name;
    std::string color;
    std::vector<double> values, deviations;  ///< one for each quantity
  };
  std::string title;
  std::string axis = "mean and standard deviation";
  struct Quantity {
    std::string name, unit;
  };
  std::vector<Quantity> quantities;
  std::vector<Series> series;
};

/// One number against another along a way.
struct LoopPanel {
  /// Those of a drawing.
  static std::vector<LoopPanel> of(const Json& drawing);

  std::string title, x_label, y_label;
  std::vector<Vec2> points;  ///< in the units of the labels
};

/// Draws rows of panels, all in one window and scale, and a row of bars or of loops below them. Lettered if there are
/// several. Files and errors as in draw_pictures().
void draw_panels(const std::string& title, const std::vector<std::vector<ShapePanel>>& shapes,
                 const std::vector<BarPanel>& bars, const std::vector<LoopPanel>& loops, StagedFiles& files,
                 const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
