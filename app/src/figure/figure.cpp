#include "tendril/app/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "figure/gnuplot.hpp"
#include "figure/panels.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/grasp.hpp"

namespace tendril::app {

namespace {

struct Box {
  Vec2 low{infinity, infinity};
  Vec2 high{-infinity, -infinity};

  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  Vec2 size() const { return high - low; }
  void grow(double by) {
    low = low - Vec2{by, by};
    high = high + Vec2{by, by};
  }
  /// The part of `other` inside this box.
  Box clipped(const Box& other) const {
    return {{std::clamp(other.low.x, low.x, high.x), std::clamp(other.low.y, low.y, high.y)},
            {std::clamp(other.high.x, low.x, high.x), std::clamp(other.high.y, low.y, high.y)}};
  }
};

double length_of(const Plan& plan) { return plan.backbone.empty() ? 1.0 : plan.backbone.back().s; }

constexpr double longest_arrow = 0.16;  // of the rod's length

double largest_force(const Plan& plan) {
  double largest = 0.0;
  for (const PlannedContact& contact : plan.contacts) largest = std::max(largest, contact.force);
  return largest;
}

Vec2 arrow_of(const Plan& plan, const PlannedContact& contact) {
  return (longest_arrow * length_of(plan) * contact.force / largest_force(plan)) * contact.normal;
}

const FingerPlan* lower_finger(const Plan& plan) {
  return plan.grasp && plan.grasp->lower ? &*plan.grasp->lower : nullptr;
}

/// The other finger of a grasp.
std::vector<Vec2> other_finger(const FigureScene& scene, const Plan& plan) {
  std::vector<Vec2> points;
  if (!scene.gripper) return points;
  if (const FingerPlan* lower = lower_finger(plan)) {
    for (const BackbonePoint& p : lower->backbone) points.push_back(p.position());
    return points;
  }
  for (const BackbonePoint& p : plan.backbone) points.push_back(mirrored(*scene.gripper, p.position()));
  return points;
}

/// The force of a contact that presses: of the plan, or of the other finger of a grasp.
struct Arrow {
  Vec2 point{}, arrow{};
  const PlannedContact* contact = nullptr;  ///< for its label; null: the mirror image of one
};

std::vector<Arrow> arrows_of(const FigureScene& scene, const Plan& plan) {
  std::vector<Arrow> arrows;
  const auto add = [&](const PlannedContact& contact) {
    if (contact.force > 0.0) arrows.push_back({contact.point, arrow_of(plan, contact), &contact});
  };
  for (const PlannedContact& contact : plan.contacts) {
    add(contact);
    if (contact.force <= 0.0 || !scene.gripper || lower_finger(plan) != nullptr) continue;
    const Vec2 point = mirrored(*scene.gripper, contact.point);
    arrows.push_back({point, mirrored(*scene.gripper, contact.point + arrow_of(plan, contact)) - point, nullptr});
  }
  if (const FingerPlan* lower = lower_finger(plan)) {
    for (const PlannedContact& contact : lower->contacts) add(contact);
  }
  return arrows;
}

/// Sides of a body; empty: it has none.
std::vector<Vec2> body_of(const RodSpec& rod, const std::vector<BackbonePoint>& backbone) {
  const BodyRadius body = rod.body();
  return body ? line_of(body_outline(backbone, body)) : std::vector<Vec2>{};
}

std::vector<Vec2> body_of(const FigureScene& scene, const Plan& plan) { return body_of(scene.rod, plan.backbone); }

std::vector<Vec2> other_body_of(const FigureScene& scene, const Plan& plan) {
  if (!scene.gripper) return {};
  if (const FingerPlan* lower = lower_finger(plan)) return body_of(scene.other_rod, lower->backbone);
  std::vector<Vec2> body = body_of(scene, plan);
  for (Vec2& p : body) p = mirrored(*scene.gripper, p);
  return body;
}

/// The window of the figure: the rod with some room around it; obstacles only as far as they are near.
Box window_of(const FigureScene& scene, const Plan& plan) {
  Box box;
  box.add(scene.base);
  for (const BackbonePoint& p : plan.backbone) box.add(p.position());
  for (const BackbonePoint& p : plan.start_backbone) box.add(p.position());
  for (const Vec2 p : other_finger(scene, plan)) box.add(p);
  for (const Vec2 p : body_of(scene, plan)) box.add(p);
  for (const Vec2 p : other_body_of(scene, plan)) box.add(p);
  if (scene.target) box.add(*scene.target);
  for (const Vec2 p : scene.measured) box.add(p);
  for (const Arrow& a : arrows_of(scene, plan)) box.add(a.point + 1.25 * a.arrow);
  const double length = length_of(plan);
  Box near = box;
  near.grow(0.35 * length);
  Box shapes;
  for (const FigureScene::Shape& shape : scene.obstacles) {
    for (const Vec2 p : shape.outline) shapes.add(p);
  }
  if (shapes.low.x <= shapes.high.x) {
    const Box part = near.clipped(shapes);
    box.add(part.low);
    box.add(part.high);
  }
  box.grow(0.07 * length);
  // A straight rod would else give a picture too flat to hold its own labels.
  const double least = 0.45 * std::max(box.size().x, box.size().y);
  if (box.size().y < least) {
    const double more = 0.5 * (least - box.size().y);
    box.low.y -= more;
    box.high.y += more;
  }
  if (box.size().x < least) {
    const double more = 0.5 * (least - box.size().x);
    box.low.x -= more;
    box.high.x += more;
  }
  return box;
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

DataFile data_of(const FigureScene& scene, const Plan& plan, LengthUnit unit) {
  DataFile data(unit);
  const double length = length_of(plan);
  data.block("rod", "x y");
  data.points(plan.backbone);
  if (scene.gripper) {
    data.block("other finger", "x y");
    for (const Vec2 p : other_finger(scene, plan)) data.row(p);
    data.block("palm", "x y");
    for (const double side : {1.0, -1.0}) {
      const Vec2 end = palm_to_world(*scene.gripper, {0.0, side * scene.gripper->half_palm});
      data.row({end.x, end.y});
    }
    const Vec2 base = mirrored(*scene.gripper, scene.base);
    const Vec2 along =
        mirrored(*scene.gripper, scene.base + Vec2{std::cos(scene.base_angle), std::sin(scene.base_angle)}) - base;
    add_clamp(data, base, std::atan2(along.y, along.x), length, "other clamp");
  }
  if (!body_of(scene, plan).empty() || !other_body_of(scene, plan).empty()) {
    data.block("body", "x y");
    for (const Vec2 p : body_of(scene, plan)) data.row(p);
    data.block("other body", "x y");
    for (const Vec2 p : other_body_of(scene, plan)) data.row(p);
  }
  data.block("start", "x y");
  data.points(plan.start_backbone);
  add_clamp(data, scene.base, scene.base_angle, length);
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    data.block(fmt::format("obstacle {}", i + 1), "x y");
    for (const Vec2 p : scene.obstacles[i].outline) data.row(p);
    if (!scene.obstacles[i].outline.empty())
      data.row({scene.obstacles[i].outline[0].x, scene.obstacles[i].outline[0].y});
  }
  data.block("contacts", "x y dx dy; the arrow's length is proportional to the force");
  for (const Arrow& a : arrows_of(scene, plan)) data.row({a.point.x, a.point.y, a.arrow.x, a.arrow.y});
  data.block("measured", "x y");
  for (const Vec2 p : scene.measured) data.row(p);
  data.block("target", "x y");
  if (scene.target) data.row({scene.target->x, scene.target->y});
  if (scene.target && scene.target_angle) {
    data.block("target direction", "x y dx dy");
    const double size = 0.1 * length;
    data.row(
        {scene.target->x, scene.target->y, size * std::cos(*scene.target_angle), size * std::sin(*scene.target_angle)});
  }
  return data;
}

/// The corner of the window, `inset` from its sides, that lies farthest from everything drawn.
Vec2 emptiest_corner(const FigureScene& scene, const Plan& plan, const Box& window, double inset) {
  Vec2 best{};
  double best_distance = -1.0;
  for (const double x : {window.high.x - inset, window.low.x + inset}) {
    for (const double y : {window.high.y - inset, window.low.y + inset}) {
      double distance = infinity;
      const auto keep_off = [&](Vec2 p) { distance = std::min(distance, norm(p - Vec2{x, y})); };
      keep_off(scene.base);
      for (const BackbonePoint& p : plan.backbone) keep_off(p.position());
      for (const BackbonePoint& p : plan.start_backbone) keep_off(p.position());
      for (const Vec2 p : other_finger(scene, plan)) keep_off(p);
      if (scene.target) keep_off(*scene.target);
      for (const Vec2 p : scene.measured) keep_off(p);
      for (const Arrow& a : arrows_of(scene, plan)) {
        if (a.contact != nullptr) keep_off(a.point + a.arrow);
      }
      for (const FigureScene::Shape& shape : scene.obstacles) {
        for (const Vec2 p : shape.outline) keep_off(p);
      }
      if (distance > best_distance) {
        best = {x, y};
        best_distance = distance;
      }
    }
  }
  return best;
}

std::string labels_of(const FigureScene& scene, const Plan& plan, const Box& window, LengthUnit unit) {
  std::string script;
  const double length = length_of(plan);
  for (const Arrow& a : arrows_of(scene, plan)) {
    if (a.contact == nullptr) continue;
    const Vec2 normal = a.contact->normal;
    const Vec2 end = a.point + a.arrow + (0.025 * length) * normal;
    const char* side = normal.x > 0.5 ? "left" : normal.x < -0.5 ? "right" : "center";
    script += fmt::format("set label {} at {:.6g},{:.6g} {} front noenhanced textcolor rgb '#a32a1e'\n",
                          gnuplot_string(force_text(a.contact->force)), end.x / unit.size, end.y / unit.size, side);
  }
  const double strength = scene.gravity ? norm(*scene.gravity) : 0.0;
  if (strength > 0.0) {
    const Vec2 direction = (1.0 / strength) * *scene.gravity;
    const double size = 0.1 * std::min(window.size().x, window.size().y) + 0.03 * length;
    const Vec2 center = emptiest_corner(scene, plan, window, 0.75 * size);
    const Vec2 from = center - (0.5 * size) * direction;
    const Vec2 to = center + (0.5 * size) * direction;
    const Vec2 beside = center + (0.3 * size) * Vec2{-std::abs(direction.y), direction.x > 0.0 ? -std::abs(direction.x)
                                                                                               : std::abs(direction.x)};
    script += fmt::format(
        "set arrow from {:.6g},{:.6g} to {:.6g},{:.6g} front head filled size screen 0.012,22 linewidth 1.5 linecolor "
        "rgb '#404040'\n",
        from.x / unit.size, from.y / unit.size, to.x / unit.size, to.y / unit.size);
    script += fmt::format("set label 'g' at {:.6g},{:.6g} center front textcolor rgb '#404040'\n", beside.x / unit.size,
                          beside.y / unit.size);
  }
  return script;
}

/// Colour, dashes and name of a rod: one that is no plan looks like none.
std::string look_of(const FigureScene& scene, const char* color, const char* name) {
  if (scene.doubt.empty()) return fmt::format("linecolor rgb '{}' title '{}'", color, name);
  return fmt::format("dashtype (6,3) linecolor rgb '#9a9a9a' title {} noenhanced",
                     gnuplot_string(fmt::format("{} ({})", name, scene.doubt)));
}

std::string plot_command(const FigureScene& scene, const Plan& plan, const std::string& data) {
  std::vector<std::string> parts;
  // Gnuplot keys have one entry for each plot element, so only the first of several alike is named.
  bool named = false;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    if (scene.obstacles[i].outline.empty()) continue;
    const std::string block = fmt::format("{} index 'obstacle {}' using 1:2", data, i + 1);
    const bool one = scene.obstacles.size() == 1;
    const std::string name = one                       ? scene.obstacles[i].name
                             : scene.obstacles_ignored ? "obstacles (ignored)"
                                                       : "obstacles";
    const std::string label = one && scene.obstacles_ignored ? name + " (ignored)" : name;
    const std::string title = named ? "notitle" : "title " + gnuplot_string(label) + " noenhanced";
    named = true;
    if (scene.obstacles_ignored) {
      parts.push_back(block + " with lines dashtype (4,4) linewidth 1.2 linecolor rgb '#808080' " + title);
    } else {
      parts.push_back(block + " with filledcurves closed fillcolor rgb '#d5d5d5' " + title);
      parts.push_back(block + " with lines linewidth 1.2 linecolor rgb '#707070' notitle");
    }
  }
  for (const char* body : {"body", "other body"}) {
    if ((body[0] == 'b' ? body_of(scene, plan) : other_body_of(scene, plan)).empty()) continue;
    parts.push_back(data + " index '" + body + "' using 1:2 with filledcurves closed fillcolor rgb '#c3d4ea' notitle");
  }
  for (const char* clamp : {"clamp", "other clamp"}) {
    if (std::string(clamp) != "clamp" && !scene.gripper) continue;
    parts.push_back(data + " index '" + clamp + "' using 1:2 with lines linewidth 1.5 linecolor rgb '#404040' notitle");
  }
  if (!plan.start_backbone.empty()) {
    parts.push_back(
        data + " index 'start' using 1:2 with lines linewidth 2 dashtype (6,5) linecolor rgb '#9db7d5' title 'start'");
  }
  if (scene.gripper) {
    parts.push_back(data + " index 'palm' using 1:2 with lines linewidth 3 linecolor rgb '#404040' title 'palm'");
    parts.push_back(data + " index 'other finger' using 1:2 with lines linewidth 5 " +
                    look_of(scene, "#6f9bd1", lower_finger(plan) != nullptr ? "lower finger" : "other finger"));
  }
  if (!plan.backbone.empty()) {
    parts.push_back(data + " index 'rod' using 1:2 with lines linewidth 5 " +
                    look_of(scene, "#1f4e8c",
                            lower_finger(plan) != nullptr ? "upper finger"
                            : scene.gripper               ? "finger"
                                                          : "rod"));
  }
  if (!scene.measured.empty()) {
    parts.push_back(data +
                    " index 'measured' using 1:2 with points pointtype 6 pointsize 1.1 linewidth 1.5 linecolor rgb "
                    "'#e08a00' title 'measured'");
  }
  if (largest_force(plan) > 0.0) {
    parts.push_back(data +
                    " index 'contacts' using 1:2:3:4 with vectors head filled size screen 0.014,20 linewidth 2.2 "
                    "linecolor rgb '#c0392b' notitle");
    parts.push_back(data +
                    " index 'contacts' using 1:2 with points pointtype 7 pointsize 0.9 linecolor rgb '#c0392b' title "
                    "'contact force'");
  }
  if (scene.target && scene.target_angle) {
    parts.push_back(data +
                    " index 'target direction' using 1:2:3:4 with vectors head nofilled size screen 0.012,20 linewidth "
                    "1.5 linecolor rgb '#2e7d32' notitle");
  }
  if (scene.target) {
    parts.push_back(data +
                    " index 'target' using 1:2 with points pointtype 2 pointsize 1.4 linewidth 2.5 linecolor rgb "
                    "'#2e7d32' title 'target'");
  }
  std::string script = "plot ";
  for (std::size_t i = 0; i < parts.size(); ++i) script += (i > 0 ? ", \\\n     " : "") + parts[i];
  return script + '\n';
}

std::string settings_of(const FigureScene& scene, const Plan& plan, const Box& window, LengthUnit unit) {
  std::string script = fmt::format("set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n", window.low.x / unit.size,
                                   window.high.x / unit.size, window.low.y / unit.size, window.high.y / unit.size);
  script += fmt::format("set xlabel 'x ({0})' noenhanced\nset ylabel 'y ({0})' noenhanced\n", unit.name);
  if (!scene.title.empty()) script += "set title " + gnuplot_string(scene.title) + " noenhanced\n";
  script +=
      "set size ratio -1\n"
      "set border 3 linewidth 1 linecolor rgb '#404040'\n"
      "set tics out nomirror textcolor rgb '#404040'\n"
      "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\n"
      "set style fill solid 1.0 noborder\n"
      "set key outside bottom center horizontal Left reverse samplen 2.2 spacing 1.25 maxcols 3 height 1\n";
  return script + labels_of(scene, plan, window, unit);
}

/// Outline of an obstacle that reaches no further than `window`, which is dimensionless like the obstacle.
std::vector<Vec2> outline_of(const Obstacle& obstacle, const Box& window) {
  std::vector<Vec2> points(361);
  obstacle.outline(points, window.low, window.high);
  for (const Vec2 p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return {};
  }
  return points;
}

}  // namespace

FigureScene figure_scene(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles) {
  FigureScene figure;
  figure.title = scene.title;
  figure.target = scene.target.position;
  figure.target_angle = scene.target.angle;
  figure.base = scene.rod.base_position;
  figure.base_angle = scene.rod.base_angle;
  figure.gravity = scene.gravity;
  figure.rod = scene.gripper ? finger_of(scene, FingerName::upper).rod : scene.rod;
  figure.other_rod = scene.gripper ? finger_of(scene, FingerName::lower).rod : RodSpec{};
  figure.obstacles_ignored = scene.contact.mode == ContactModeName::ignore;
  // Unbounded shapes are cut off well outside of what the rod can reach, so that the cut is never seen.
  const Scale scale = scale_of(scene);
  const double reach = 3.0;
  const Vec2 base = (1.0 / scale.length) * scene.rod.base_position;
  Box window{base - Vec2{reach, reach}, base + Vec2{reach, reach}};
  if (scene.target.position) {
    Box target = window;
    target.add((1.0 / scale.length) * *scene.target.position);
    window = target;
    window.grow(1.0);
  }
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    FigureScene::Shape shape;
    shape.name = scene.obstacles[i].name;
    if (obstacles[i]) {
      for (const Vec2 p : outline_of(*obstacles[i], window)) shape.outline.push_back(scale.length * p);
    }
    figure.obstacles.push_back(std::move(shape));
  }
  return figure;
}

Picture picture_of(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  for (const char c : name) {
    if ((c >= 0 && c < ' ') || c == 127)
      throw InputError("the name of the figure holds a control character, expected printable text");
  }
  if (name.find("''") != std::string::npos)
    throw InputError("the name of the figure holds two quotes in a row, which gnuplot cannot read");
  const std::string extension = file.extension().string();
  if (extension == ".svg") return Picture::svg;
  if (extension == ".png") return Picture::png;
  if (extension == ".pdf") return Picture::pdf;
  if (extension == ".html") return Picture::page;
  throw InputError("found the figure '" + name + "', expected a name that ends in .svg, .png, .pdf or .html");
}

void draw_figure(const FigureScene& scene, const Plan& plan, StagedFiles& files, const std::string& stem,
                 const std::vector<Picture>& pictures) {
  const LengthUnit unit = unit_for(length_of(plan));
  const Box window = window_of(scene, plan);
  const double height = std::clamp(90.0 + 790.0 * window.size().y / window.size().x + 90.0, 420.0, 1300.0);
  render({data_of(scene, plan, unit).text(), settings_of(scene, plan, window, unit),
          plot_command(scene, plan, gnuplot_file(stem + ".dat")), "replot\n", 900, static_cast<int>(height)},
         files, stem, pictures);
}

void add_gripper(FigureScene& figure, const Scene& scene, const Plan& plan) {
  if (!scene.gripper || !plan.grasp) return;
  figure.gripper = scene.gripper;
  const Scene upper = plans_both_fingers(scene) ? finger_of(scene, FingerName::upper) : scene;
  figure.base = palm_to_world(*upper.gripper, {0.0, upper.gripper->half_palm});
  figure.base_angle = upper.gripper->angle + upper.gripper->finger_angle;
  figure.obstacles = {object_shape(plan.grasp->object_center, plan.grasp->object_radius)};
}

FigureScene::Shape object_shape(Vec2 center, double radius) {
  FigureScene::Shape object;
  object.name = "object";
  constexpr int corners = 180;
  object.outline.reserve(corners);
  for (int i = 0; i < corners; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / corners;
    object.outline.push_back(center + radius * Vec2{std::cos(turn), std::sin(turn)});
  }
  return object;
}

}  // namespace tendril::app
