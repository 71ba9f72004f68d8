#pragma once

#include <string>
#include <vector>

#include "tendril/app/figure.hpp"

namespace tendril::app {

/// Shapes of one rod in one picture.
struct ShapePanel {
  std::string title;
  std::vector<FigureScene::Shape> obstacles;
  bool obstacles_ignored = false;
  Vec2 base{};
  double base_angle = 0.0;
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
  struct Quantity {
    std::string name, unit;
  };
  std::vector<Quantity> quantities;
  std::vector<Series> series;
};

/// An empty panel of the scene of `figure`.
ShapePanel shape_panel(const FigureScene& figure);
std::vector<Vec2> line_of(const std::vector<BackbonePoint>& backbone);

/// Draws rows of panels, all in one window and scale, and a row of bars below them. Lettered if there are several.
/// Files and errors as in draw_figure().
void draw_panels(const std::string& title, const std::vector<std::vector<ShapePanel>>& shapes,
                 const std::vector<BarPanel>& bars, StagedFiles& files, const std::string& stem,
                 const std::vector<Picture>& pictures);

}  // namespace tendril::app
