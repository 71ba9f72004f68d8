#include "figure/frame_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "figure/frames.hpp"

namespace tendril::app {

namespace {

constexpr double longest_arrow = 0.16;  // of the rod's length

double distance_to(Vec2 from, Vec2 to, Vec2 p) {
  const Vec2 along = to - from;
  const double square = dot(along, along);
  const double share = square > 0.0 ? std::clamp(dot(p - from, along) / square, 0.0, 1.0) : 0.0;
  return norm(p - from - share * along);
}

std::string force_text(double force) {
  struct Step {
    double size;
    const char* unit;
  };
  for (const Step step : {Step{1e3, "kN"}, Step{1.0, "N"}, Step{1e-3, "mN"}, Step{1e-6, "µN"}}) {
    if (force >= step.size) return fmt::format("{:.3g} {}", force / step.size, step.unit);
  }
  return fmt::format("{:.3g} nN", force / 1e-9);
}

}  // namespace

/// The parts of a plot command.
class PlotCommand {
 public:
  /// `file`: with its quotes.
  explicit PlotCommand(std::string file) : file_(std::move(file)) {}

  /// `last`: no row beyond it is drawn.
  void add(const std::string& block, std::string_view how, std::string_view columns = "1:2",
           std::optional<std::size_t> last = std::nullopt) {
    const std::string every = last ? fmt::format(" every ::0::{}", *last) : "";
    parts_.push_back(fmt::format("{} index '{}'{} using {} {}", file_, block, every, columns, how));
  }
  /// Only in the legend, so that this is the same for all frames of a movie.
  void name(std::string_view how) { parts_.push_back(fmt::format("keyentry {}", how)); }
  std::string text() const {
    if (parts_.empty()) return "plot NaN notitle\n";
    std::string text = "plot ";
    for (std::size_t i = 0; i < parts_.size(); ++i) text += (i > 0 ? ", \\\n     " : "") + parts_[i];
    return text + '\n';
  }

 private:
  std::string file_;
  std::vector<std::string> parts_;
};

namespace {

/// What is drawn over the rods, from a block of its name, of frames that have it.
struct Sign {
  bool (*has)(const Json& frame);
  const char* block;
  std::string_view how;
  const char* columns = "1:2";
  constexpr bool named() const { return how.find(" title ") != std::string_view::npos; }
};
constexpr Sign signs[] = {
    {has<palm_key>, "palm", "with lines linewidth 3 linecolor rgb '#404040' title 'palm'"},
    {has<path_key>, "path", "with points pointtype 7 pointsize 0.6 linecolor rgb '#2e7d32' title 'targets'"},
    {has<hold_key>, "hold", "with lines linewidth 1.8 dashtype (5,3) linecolor rgb '#7b3f98' title 'forces held'"},
    {has<measured_key>, "measured",
     "with points pointtype 6 pointsize 1.1 linewidth 1.5 linecolor rgb '#e08a00' title 'measured'"},
    {has<tips_key>, "tips",
     "with points pointtype 6 pointsize 0.8 linewidth 1.5 linecolor rgb '#7b3f98' title 'tip under friction'"},
    {has_contact<presses>, "contacts",
     "with vectors head filled size screen 0.014,20 linewidth 2.2 linecolor rgb '#c0392b' notitle", "1:2:3:4"},
    {has_contact<slips>, "slips",
     "with vectors head filled size screen 0.012,20 linewidth 2 linecolor rgb '#7b241c' title 'force along the rod'",
     "1:2:3:4"},
    {has_contact<presses>, "contacts",
     "with points pointtype 7 pointsize 0.9 linecolor rgb '#c0392b' title 'contact force'"},
    {has_contact<touches>, "touches",
     "with points pointtype 7 pointsize 0.6 linecolor rgb '#c0392b' title 'contact points'"},
    {has_direction, "direction",
     "with vectors head nofilled size screen 0.012,20 linewidth 1.5 linecolor rgb '#2e7d32' notitle", "1:2:3:4"},
    {has_target, "target",
     "with points pointtype 2 pointsize 1.4 linewidth 2.5 linecolor rgb '#2e7d32' title 'target'"},
};

}  // namespace

FrameFigure::FrameFigure(const Json& drawing, std::vector<std::size_t> frames, std::string file)
    : drawing_(drawing),
      frames_(std::move(frames)),
      file_(std::move(file)),
      length_(drawing["length"]),
      unit_(unit_for(length_)) {
  double largest = 0.0;
  for (const std::size_t i : frames_) {
    for (const Json& contact : frame(i)["contacts"]) {
      if (presses(contact)) largest = std::max(largest, contact["force"].get<double>());
    }
  }
  if (largest > 0.0) per_newton_ = longest_arrow * length_ / largest;
  collect();
  window_ = window();
  height_ = static_cast<int>(std::clamp(180.0 + 790.0 * window_.size().y / window_.size().x, 420.0, 1300.0));
  height_ += height_ % 2;  // movies are compressed in blocks of two
}

FrameFigure::Arrow FrameFigure::arrow_of(const Json& contact) const {
  return {point(contact["surface"]), (per_newton_ * contact["force"].get<double>()) * point(contact["normal"])};
}

std::vector<Vec2> FrameFigure::hold_line(const Json& frame) const {
  std::vector<Vec2> line;
  if (!has<hold_key>(frame)) return line;
  const Json& hold = frame["hold"];
  for (const Json& force : hold["forces"]) line.push_back(point(hold["center"]) + per_newton_ * point(force));
  line.push_back(line.front());
  return line;
}

void FrameFigure::collect() {
  const auto add_all = [&](const Json& owner, const char* key) {
    if (!owner.contains(key)) return;
    for (const Json& p : owner[key]) {
      if (!p.is_null()) drawn_.push_back(point(p));
    }
  };
  const auto add_obstacles = [&](const Json& owner) {
    if (!owner.contains("obstacles")) return;
    for (const Json& shape : owner["obstacles"]) {
      for (ClosedLine& line : lines_of(shape)) obstacles_.push_back(std::move(line));
    }
  };
  for (const char* list : {"start", "path"}) add_all(drawing_, list);
  add_obstacles(drawing_);
  for (const std::size_t i : frames_) {
    const Json& one = frame(i);
    for (const Json& rod : one["rods"]) {
      for (const char* list : {"line", "body", "band"}) add_all(rod, list);
    }
    for (const char* list : {"measured", "tips", "path", "palm"}) add_all(one, list);
    for (const Vec2 p : hold_line(one)) drawn_.push_back(p);
    if (has_target(one)) drawn_.push_back(point(one["target"]["position"]));
    for (const Json& contact : one["contacts"]) {
      if (presses(contact)) drawn_.push_back(arrow_of(contact).from + 1.25 * arrow_of(contact).along);
    }
    add_obstacles(one);
  }
}

/// The rods with some room around them; obstacles only as far as they are near.
Box FrameFigure::window() const {
  Box box, shapes;
  for (const Vec2 p : drawn_) box.add(p);
  for (const ClosedLine& line : obstacles_) {
    for (const Vec2 p : line) shapes.add(p);
  }
  box.add_near(shapes, 0.35 * length_);
  box.grow(0.07 * length_);
  // A straight rod would else give a picture too flat to hold its own labels.
  const double least = 0.45 * std::max(box.size().x, box.size().y);
  box.widen({least, least});
  return box;
}

/// The corner of the window, `inset` from its sides, that lies farthest from everything drawn.
Vec2 FrameFigure::emptiest_corner(double inset) const {
  Vec2 best{};
  double best_distance = -1.0;
  for (const double x : {window_.high.x - inset, window_.low.x + inset}) {
    for (const double y : {window_.high.y - inset, window_.low.y + inset}) {
      const Vec2 corner{x, y};
      double distance = infinity;
      for (const Vec2 p : drawn_) distance = std::min(distance, norm(p - corner));
      for (const ClosedLine& line : obstacles_) {
        for (std::size_t i = 0; i < line.size(); ++i)
          distance = std::min(distance, distance_to(line[i], line[(i + 1) % line.size()], corner));
      }
      if (distance > best_distance) {
        best = corner;
        best_distance = distance;
      }
    }
  }
  return best;
}

std::string FrameFigure::settings() const {
  return fmt::format(
      "set xrange [{0:.6g}:{1:.6g}]\nset yrange [{2:.6g}:{3:.6g}]\n"
      "set xlabel 'x ({4})' noenhanced\nset ylabel 'y ({4})' noenhanced\n"
      "set size ratio -1\n"
      "set border 3 linewidth 1 linecolor rgb '#404040'\n"
      "set tics out nomirror textcolor rgb '#404040'\n"
      "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\n"
      "set style fill solid 1.0 noborder\n"
      "set key outside bottom center horizontal Left reverse samplen 2.2 spacing 1.25 maxcols 3 height 1\n",
      window_.low.x / unit_.size, window_.high.x / unit_.size, window_.low.y / unit_.size, window_.high.y / unit_.size,
      unit_.name);
}

std::string FrameFigure::draw(std::size_t index, bool of_several) const {
  const Json& one = frame(index);
  std::string script = "unset label\nunset arrow\n";
  std::string title = drawing_.value("title", "");
  if (of_several) title += (title.empty() ? "" : ", ") + one.value("label", "");
  if (!title.empty()) script += "set title " + gnuplot_string(title) + " noenhanced\n";
  PlotCommand plot(file_);
  add_obstacles(plot, index);
  add_rods(plot, index);
  for (const Sign& sign : signs) {
    if (sign.has(one)) {
      plot.add(block_of(index, sign.block), sign.how, sign.columns);
    } else if (of_several && sign.named() &&
               std::any_of(frames_.begin(), frames_.end(), [&](std::size_t i) { return sign.has(frame(i)); })) {
      // What some frames have stands in the legend of all.
      plot.name(sign.how);
    }
  }
  return script + gravity() + labels(one) + plot.text();
}

void FrameFigure::add_obstacles(PlotCommand& plot, std::size_t index) const {
  const Json& one = frame(index);
  bool named = false;
  const auto add = [&](const Json& shapes, const std::string& prefix) {
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const bool ignored = shapes[i].value("ignored", false) || one.value("ignored", false);
      const std::string name = shapes.size() == 1 ? shapes[i]["name"].get<std::string>() : "obstacles";
      // Legends have an entry for each element, so only the first of several alike is named.
      const std::string title =
          named ? "notitle" : "title " + gnuplot_string(name + (ignored ? " (ignored)" : "")) + " noenhanced";
      named = true;
      const std::string edge = fmt::format("{}edge {}.", prefix, i + 1);
      if (ignored) {
        plot.add(edge, "with lines dashtype (4,4) linewidth 1.2 linecolor rgb '#808080' " + title);
      } else {
        plot.add(fmt::format("{}obstacle {}.", prefix, i + 1),
                 "with filledcurves closed fillcolor rgb '#d5d5d5' " + title);
        plot.add(edge, "with lines linewidth 1.2 linecolor rgb '#707070' notitle");
      }
    }
  };
  add(drawing_["obstacles"], "");
  if (has<obstacles_key>(one)) add(one["obstacles"], fmt::format("frame {}: ", index + 1));
}

void FrameFigure::add_rods(PlotCommand& plot, std::size_t index) const {
  const Json& one = frame(index);
  const std::size_t count = one["rods"].size();
  const auto own = [&](const char* name, std::size_t r) { return block_of(index, fmt::format("{} {}", name, r + 1)); };
  for (std::size_t r = 0; r < count; ++r) {
    if (one["rods"][r].contains("band")) {
      plot.add(own("band", r), "with filledcurves closed fillcolor rgb '#f6d3bd' title 'two standard deviations'");
    }
    if (one["rods"][r].contains("body")) {
      plot.add(own("body", r), "with filledcurves closed fillcolor rgb '#c3d4ea' notitle");
      plot.add(own("body", r), "with lines linewidth 0.7 linecolor rgb '#6b86a8' notitle");
    }
    plot.add(own("clamp", r), "with lines linewidth 1.5 linecolor rgb '#404040' notitle");
  }
  if (has_contact<rubs>(one))
    plot.add(block_of(index, "cones"), "with filledcurves closed fillcolor rgb '#f3c9c3' title 'friction cone'");
  if (drawing_.contains("start"))
    plot.add("start.", "with lines linewidth 2 dashtype (6,5) linecolor rgb '#9db7d5' title 'start'");
  if (drawing_.contains("path")) {
    plot.add("path.", "with points pointtype 7 pointsize 0.4 linecolor rgb '#2e7d32' title 'targets'");
    plot.add("way.", "with lines linewidth 1.5 linecolor rgb '#7b3f98' title 'way of the tip'", "1:2", index);
  }
  const std::string status = one.value("status", "solved");
  for (std::size_t r = count; r-- > 0;) {
    const std::string name = one["rods"][r]["name"];
    std::string how = fmt::format("with lines linewidth {} ", count > 2 ? 2 : 5);
    // A shape that is no plan looks like none.
    how += status == "solved" ? fmt::format("linecolor rgb '{}' ", r == 0 ? "#1f4e8c" : "#6f9bd1")
                              : std::string("dashtype (6,3) linecolor rgb '#9a9a9a' ");
    const std::string title = status == "solved" ? name : fmt::format("{} ({})", name, status);
    // Of many lines alike the legend tells once.
    plot.add(own("rod", r), how + (count > 2 && r > 0 ? "notitle" : "title " + gnuplot_string(title) + " noenhanced"));
  }
}

std::string FrameFigure::labels(const Json& one) const {
  std::string script;
  for (const Json& contact : one["contacts"]) {
    // The mirror image of a contact says nothing new.
    if (!presses(contact) || contact.value("finger", "") == "other") continue;
    const auto [from, along] = arrow_of(contact);
    const Vec2 normal = point(contact["normal"]);
    const Vec2 end = from + along + (0.025 * length_) * normal;
    const char* side = normal.x > 0.5 ? "left" : normal.x < -0.5 ? "right" : "center";
    script += fmt::format("set label {} at {:.6g},{:.6g} {} front noenhanced textcolor rgb '#a32a1e'\n",
                          gnuplot_string(force_text(contact["force"])), end.x / unit_.size, end.y / unit_.size, side);
  }
  return script;
}

std::string FrameFigure::gravity() const {
  const Vec2 pull = drawing_.contains("gravity") ? point(drawing_["gravity"]) : Vec2{};
  if (!(norm(pull) > 0.0)) return "";
  const Vec2 direction = (1.0 / norm(pull)) * pull;
  const double size = 0.1 * std::min(window_.size().x, window_.size().y) + 0.03 * length_;
  const Vec2 center = emptiest_corner(0.75 * size);
  const Vec2 from = center - (0.5 * size) * direction;
  const Vec2 to = center + (0.5 * size) * direction;
  const double aside = direction.x > 0.0 ? -std::abs(direction.x) : std::abs(direction.x);
  const Vec2 beside = center + (0.3 * size) * Vec2{-std::abs(direction.y), aside};
  return fmt::format(
      "set arrow from {:.6g},{:.6g} to {:.6g},{:.6g} front head filled size screen 0.012,22 linewidth 1.5 linecolor "
      "rgb '#404040'\nset label 'g' at {:.6g},{:.6g} center front textcolor rgb '#404040'\n",
      from.x / unit_.size, from.y / unit_.size, to.x / unit_.size, to.y / unit_.size, beside.x / unit_.size,
      beside.y / unit_.size);
}

}  // namespace tendril::app
