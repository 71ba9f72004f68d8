#include "figure/gnuplot.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "tendril/app/input_error.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {

namespace {

constexpr double gnuplot_seconds = 60.0;

}  // namespace

LengthUnit unit_for(double length) {
  if (length < 2e-3) return {"µm", 1e-6};
  if (length < 2.0) return {"mm", 1e-3};
  return {"m", 1.0};
}

void add_clamp(DataFile& data, Vec2 base, double base_angle, double length, const std::string& block) {
  const Vec2 along{std::cos(base_angle), std::sin(base_angle)};
  const Vec2 across = turned(along);
  const double half = 0.07 * length;
  data.block(block, "x y");
  const auto line = [&](Vec2 a, Vec2 b) {
    data.row({a.x, a.y});
    data.row({b.x, b.y});
    data.gap();
  };
  line(base - half * across, base + half * across);
  constexpr int strokes = 7;
  const double stroke = 2.0 * half / strokes;
  for (int i = 0; i < strokes; ++i) {
    const Vec2 end = base + (-half + (i + 1) * stroke) * across;
    line(end, end - stroke * across - stroke * along);
  }
}

void add_outlines(DataFile& data, const std::vector<ClosedLine>& outlines, const Box& window, const std::string& body,
                  const std::string& edge) {
  // Rounded, no point may lie outside.
  Box within = window;
  within.grow(-1e-5 * norm(window.size()));
  std::vector<ClosedLine> filled = outlines;
  for (ClosedLine& line : filled) line = cut_off(within, std::move(line));
  std::erase_if(filled, [](const ClosedLine& line) { return line.empty(); });
  // A block without points would be missed.
  if (filled.empty()) filled.push_back({within.low});
  data.block(body, "x y");
  for (const Vec2 p : joined(filled)) data.row(p);
  add_edges(data, outlines, edge);
}

void add_edges(DataFile& data, const std::vector<ClosedLine>& outlines, const std::string& edge) {
  data.block(edge, "x y");
  for (const ClosedLine& line : outlines) {
    for (const Vec2 p : line) data.row(p);
    if (!line.empty()) data.row(line[0]);
    data.gap();
  }
}

std::string gnuplot_file(const std::string& name) {
  std::string out = "'./";
  for (const char c : name) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

std::string gnuplot_string(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    // Line feeds would end the string, and with it the command.
    if ((c >= 0 && c < ' ') || c == 127) {
      out += ' ';
    } else if (c == '\'') {
      out += "\u2019";
    } else {
      out += c;
    }
  }
  return out + "'";
}

namespace {

const char* extension(Picture picture) {
  return picture == Picture::svg ? ".svg" : picture == Picture::png ? ".png" : ".pdf";
}

/// Sets the terminal of a picture that not every gnuplot can write, and its file. Where this one cannot, an SVG is
/// left for rsvg-convert.
std::string terminal_or_svg(const Drawing& drawing, const std::string& stem, Picture picture,
                            const std::string& svg_terminal) {
  const std::string terminal =
      picture == Picture::pdf
          // A hundred points of the drawing to the inch.
          ? fmt::format("pdfcairo size {},{} font 'sans-serif,11' rounded background '#ffffff'", drawing.width / 100.0,
                        drawing.height / 100.0)
          : fmt::format(
                "pngcairo size {},{} font 'sans-serif,16' fontscale 2 linewidth 2 pointscale 2 rounded "
                "background '#ffffff'",
                2 * drawing.width, 2 * drawing.height);
  return fmt::format(
      "picture = {}\n"
      "if (strstrt(GPVAL_TERMINALS, '{}') > 0) {{\n"
      "  set terminal {}\n"
      "}} else {{\n"
      "  {}\n"
      "  picture = {}\n"
      "}}\n"
      "set output picture\n",
      gnuplot_file(stem + extension(picture)), terminal.substr(0, terminal.find(' ')), terminal, svg_terminal,
      gnuplot_file(stem + ".svg"));
}

/// The script as a whole: what it draws goes to each kind of picture in turn.
std::string script_of(const Drawing& drawing, const std::string& stem, const std::vector<Picture>& pictures) {
  std::string script = "# Give this to gnuplot to draw the figure anew.\nset encoding utf8\n" + drawing.settings;
  std::string draw = drawing.draw;
  const std::string svg_terminal = fmt::format(
      "set terminal svg size {},{} font 'sans-serif,16' rounded background '#ffffff'", drawing.width, drawing.height);
  for (const Picture picture : pictures) {
    script += picture == Picture::svg ? svg_terminal + "\nset output " + gnuplot_file(stem + ".svg") + '\n'
                                      : terminal_or_svg(drawing, stem, picture, svg_terminal);
    script += draw + "unset output\n";
    draw = drawing.again;
  }
  return script;
}

/// Has rsvg-convert make the picture where gnuplot left an SVG in its place.
void convert(Picture picture, const std::string& stem, const std::filesystem::path& directory) {
  std::vector<std::string> arguments{"--output", "./" + stem + extension(picture), "./" + stem + ".svg"};
  const char* const how[] = {picture == Picture::pdf ? "--format" : "--zoom", picture == Picture::pdf ? "pdf" : "2"};
  arguments.insert(arguments.begin(), std::begin(how), std::end(how));
  run_process("rsvg-convert", arguments, directory, gnuplot_seconds);
}

}  // namespace

void render(const Drawing& drawing, StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
  files.write(stem + ".dat", drawing.data);
  files.write(stem + ".gnuplot", script_of(drawing, stem, pictures));
  // -d: a user's own start-up file would change the picture.
  const ProcessResult gnuplot =
      run_process("gnuplot", {"-d", "./" + stem + ".gnuplot"}, files.staging(), gnuplot_seconds);
  if (!gnuplot.started)
    throw InputError("no figure: gnuplot cannot be started; install gnuplot or leave the figure out");
  const auto wrong = [&](const std::string& what) {
    return InputError("no figure: " + what + (gnuplot.output.empty() ? "" : ":\n" + gnuplot.output));
  };
  if (gnuplot.timed_out) throw wrong("gnuplot did not end within a minute");
  if (gnuplot.exit_code != 0) throw wrong("gnuplot failed");
  for (const Picture picture : pictures) {
    const std::string name = stem + extension(picture);
    std::error_code error;
    const auto there = [&](const std::string& file) { return std::filesystem::exists(files.staging() / file, error); };
    if (!there(name) && there(stem + ".svg")) convert(picture, stem, files.staging());
    if (!there(name)) {
      throw wrong(picture == Picture::svg   ? "gnuplot wrote no SVG"
                  : picture == Picture::png ? "this gnuplot cannot write PNG, and rsvg-convert is not there either"
                                            : "this gnuplot cannot write PDF, and rsvg-convert is not there either");
    }
    files.adopt(name);
  }
}

}  // namespace tendril::app
