#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "figure/box.hpp"
#include "figure/gnuplot.hpp"
#include "figure/outlines.hpp"
#include "result/result_object.hpp"

namespace tendril::app {

class PlotCommand;

/// Frames of a drawing as gnuplot draws them: all in one window, with forces at one scale.
class FrameFigure {
 public:
  /// `file`: what gnuplot reads data() from, as a string of the script.
  FrameFigure(const Json& drawing, std::vector<std::size_t> frames, std::string file);

  std::string data() const;
  /// Commands before the first picture.
  std::string settings() const;
  /// Commands that draw one of the frames. `of_several`: its title tells which, and its legend is that of all.
  std::string draw(std::size_t index, bool of_several) const;
  int width() const { return 900; }
  int height() const { return height_; }

 private:
  struct Arrow {
    Vec2 from{}, along{};
  };
  const Json& frame(std::size_t index) const { return drawing_["frames"][index]; }
  Arrow arrow_of(const Json& contact) const;
  /// Around a grasped object, how far forces on it are held; empty: that is not told.
  std::vector<Vec2> hold_line(const Json& frame) const;
  void collect();
  Box window() const;
  Vec2 emptiest_corner(double inset) const;
  std::string labels(const Json& frame) const;
  std::string gravity() const;
  void add_shapes(DataFile& data, const Json& shapes, const std::string& prefix) const;
  void add_frame(DataFile& data, std::size_t index) const;
  void add_obstacles(PlotCommand& plot, std::size_t index) const;
  void add_rods(PlotCommand& plot, std::size_t index) const;

  const Json& drawing_;
  std::vector<std::size_t> frames_;
  std::string file_;
  double length_;
  LengthUnit unit_;
  double per_newton_ = 0.0;  ///< m, of an arrow
  std::vector<Vec2> drawn_;  ///< in all frames, beside obstacles
  std::vector<ClosedLine> obstacles_;
  Box window_;
  int height_ = 0;
};

}  // namespace tendril::app
