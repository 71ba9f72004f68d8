#pragma once

#include <fmt/format.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "figure/outlines.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app {

/// What figures have in common: data files, scripts, and running gnuplot on them.

struct LengthUnit {
  const char* name;
  double size;
};
LengthUnit unit_for(double length);

/// The data file: blocks with a name each, two blank lines between them.
class DataFile {
 public:
  explicit DataFile(LengthUnit unit) : unit_(unit), text_(fmt::format("# Lengths in {}.\n", unit.name)) {}

  void block(const std::string& name, const std::string& columns) {
    text_ += fmt::format("\n\n# {}\n# {}\n", name, columns);
  }
  void row(Vec2 point) { row({point.x, point.y}); }
  void row(std::initializer_list<double> lengths) {
    for (const double value : lengths) text_ += fmt::format("{:.9g} ", value / unit_.size);
    text_ += '\n';
  }
  /// A row of plain numbers.
  void numbers(std::initializer_list<double> values) {
    for (const double value : values) text_ += fmt::format("{:.9g} ", value);
    text_ += '\n';
  }
  void gap() { text_ += '\n'; }
  const std::string& text() const { return text_; }

 private:
  LengthUnit unit_;
  std::string text_;
};

/// A base line across the clamp with short strokes behind it, as a block.
void add_clamp(DataFile& data, Vec2 base, double base_angle, double length, const std::string& block);

/// An obstacle: the block `body` can be filled although gnuplot knows no holes, `edge` holds its lines. What is filled
/// ends at the window: beyond it gnuplot fills the wrong side.
void add_outlines(DataFile& data, const std::vector<ClosedLine>& outlines, const Box& window, const std::string& body,
                  const std::string& edge);
/// Its lines alone.
void add_edges(DataFile& data, const std::vector<ClosedLine>& outlines, const std::string& edge);

/// A file beside the script, as a string of the script. Path names must stay as they are, so a quote is doubled;
/// picture_of() has seen to it that no two stand together.
std::string gnuplot_file(const std::string& name);

/// What gnuplot makes a picture of.
struct Drawing {
  std::string data;      ///< of the file beside the script
  std::string settings;  ///< commands before the first picture
  std::string draw;      ///< commands that draw it
  std::string again;     ///< those that draw it once more, in another format
  int width = 0, height = 0;
};

/// Writes `stem`.dat and `stem`.gnuplot, runs gnuplot and adopts the pictures. Throws InputError if gnuplot is missing
/// or fails.
void render(const Drawing& drawing, StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
