// Bodies that are not convex, seams and corners of theirs, channels, and hundreds of pieces.

#include <fmt/format.h>

#include <cmath>

#include "common/scene_text.hpp"
#include "extremes/groups.hpp"

namespace tendril::bench {

namespace {

using namespace scene_text;

constexpr const char* group = "outlines";
constexpr const char* by_fine_basis = "the fine basis under the same loads, which finds the contacts by itself";

std::string points(const std::vector<Vec2>& all, double scale = 1.0) {
  std::string text;
  for (const Vec2 p : all) text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", scale * p.x, scale * p.y);
  return text;
}

std::string polygon(const std::vector<Vec2>& corners, double rounding, const std::string& more = "") {
  return fmt::format("[[obstacle]]\nshape = \"polygon\"\nvertices = [{}]\nrounding = {}\n{}", points(corners), rounding,
                     more);
}

std::string heavy_unit_rod(double weight) { return gravity_of(1.0) + unit_rod(weight); }

/// A trough, over both rims of which a rod may lie.
std::vector<Vec2> trough(double length = 1.0) {
  std::vector<Vec2> corners{{0.4, -0.3}, {0.8, -0.3}, {0.8, -0.06}, {0.6, -0.12}, {0.4, -0.06}};
  for (Vec2& p : corners) p = length * p;
  return corners;
}

/// On peaks from sharp to blunt, over rims, into the inner corner of a notch, on a seam where two parts meet.
void add_corners(CaseList& list) {
  CaseNumbers& number = list.number;
  for (const double table_rounding : {1e-6, 1e-3}) {
    const double rounding = number(table_rounding);
    std::vector<Vec2> peak{{0.5, -0.3}, {0.7, -0.3}, {0.65, -0.15}, {0.6, -0.05}, {0.55, -0.15}};
    for (Vec2& p : peak) p.y -= rounding;
    ExtremeCase& c = list.plan(group, fmt::format("heavy rod on a peak rounded by {} L", rounding),
                               heavy_unit_rod(number(5.0)) + polygon(peak, rounding) + contact("require") +
                                   "min_force = 0.1\n" + target(0.9, -0.3) + weighted(1.0, 0.0),
                               by_fine_basis);
    c.against_execution = true;
    c.contacts = 1;
    c.quick = table_rounding == 1e-6;
  }
  ExtremeCase& rims = list.plan(group, "over the rims of a trough",
                                heavy_unit_rod(number(5.0)) + actuator(-1.0, 1.0) + polygon(trough(), 0.01) +
                                    contact("allow", 2) + target(0.95, -0.2) + weighted(1.0, 1e-6),
                                by_fine_basis);
  rims.against_execution = true;
  ExtremeCase& notch =
      list.plan(group, "tip above the inner corner of a notch",
                heavy_unit_rod(number(5.0)) + actuator(-3.0, 3.0) +
                    polygon({{0.8, -0.5}, {1.2, -0.5}, {1.2, -0.05}, {0.99, -0.2}, {0.8, -0.1}}, 0.01) +
                    contact("allow", 2) + target(0.95, -0.2) + weighted(1.0, 1e-6),
                by_fine_basis);
  notch.against_execution = true;
  const double moment = number(1.5);
  const std::string on_top = heavy_unit_rod(number(5.0)) + actuator(moment, moment) + start(0.2) + contact("require") +
                             "min_force = 0.01\n" + target(1.0, 0.1) + weighted(1.0, 1e-6);
  const double seam = number(0.6);
  ExtremeCase& whole =
      list.plan(group, "on the top of a box",
                on_top + polygon({{0.2, -0.3}, {0.9, -0.3}, {0.9, -0.05}, {0.2, -0.05}}, 0.02), by_fine_basis);
  ExtremeCase& cut = list.plan(group, "on the top of a box in two parts",
                               on_top + polygon({{0.2, -0.3},
                                                 {seam, -0.3},
                                                 {seam, -0.05},
                                                 {0.2, -0.05},
                                                 {seam, -0.3},
                                                 {0.9, -0.3},
                                                 {0.9, -0.05},
                                                 {seam, -0.05}},
                                                0.02, "outlines = [4, 4]\n"),
                               by_fine_basis);
  for (ExtremeCase* c : {&whole, &cut}) {
    c->against_execution = true;
    c->same_as = "box";
  }
}

/// The same trough in units from a thousandth of a millimetre to a thousand kilometres.
void add_units(CaseList& list) {
  const double weight = list.number(5.0);
  for (const double length : {1.0, 1e-6, 1e6}) {
    const double moment = length * length;
    ExtremeCase& c = list.plan(group, fmt::format("over a trough of {} m", length),
                               gravity_of(1.0) + rod({{length, length * length * length, weight, 0.0}}) +
                                   actuator(-moment, moment, 0.0, length) + polygon(trough(length), 0.01 * length) +
                                   contact("allow", 2) + target(0.95 * length, -0.2 * length) + weighted(1.0, 1e-6),
                               by_fine_basis);
    c.same_as = "trough";
  }
}

/// Bent channels of a given width around an arc of a given angle, the rod within.
void add_channels(CaseList& list) {
  CaseNumbers& number = list.number;
  for (const double table_width : {0.1, 0.02}) {
    const double width = number(table_width);
    std::vector<Vec2> line{{-0.1, 0.0}, {0.0, 0.0}};
    for (int i = 0; i < 10; ++i) {
      const double angle = 0.1 * (i + 0.5);
      line.push_back(line.back() + 0.1 * Vec2{std::cos(angle), std::sin(angle)});
    }
    std::string text =
        unit_rod() + actuator(-5.0, 5.0) + "[start]\npoints = [" + points({line.begin() + 2, line.end()}) + "]\n";
    text += fmt::format(
        "[[obstacle]]\nshape = \"channel\"\npoints = [{}]\nwidth = {}\nwall = 0.05\nrounding = {}\nclosed = \"end\"\n",
        points(line), width, 0.1 * width);
    ExtremeCase& c = list.plan(group, fmt::format("in a closed bend of width {} L", width),
                               text + contact("allow", 2) + target(0.83, 0.46) + weighted(1.0, 1e-6), by_fine_basis);
    c.against_execution = true;
  }
}

/// A comb of a hundred teeth, and two hundred pegs.
void add_many(CaseList& list) {
  CaseNumbers& number = list.number;
  std::vector<Vec2> comb{{0.2, -0.3}, {0.91, -0.3}};
  for (int i = 99; i >= 0; --i) {
    comb.push_back({0.2035 + 0.007 * i, -0.05});
    comb.push_back({0.2 + 0.007 * i, -0.06});
  }
  std::string pegs;
  for (int row = 0; row < 10; ++row) {
    for (int i = 0; i < 20; ++i) pegs += circle(0.05 * i + 0.1, -0.1 - 0.1 * row, 0.01);
  }
  const double weight = number(5.0);
  const std::string aim = target(0.95, -0.2) + weighted(1.0, 1e-6);
  list.plan(group, "over a comb of a hundred teeth",
            heavy_unit_rod(weight) + actuator(-1.0, 1.0) + polygon(comb, 1e-3) + contact("allow", 3) + aim,
            by_fine_basis)
      .against_execution = true;
  list.plan(group, "over two hundred pegs",
            heavy_unit_rod(weight) + actuator(-1.0, 1.0) + pegs + contact("allow") + aim, by_fine_basis)
      .against_execution = true;
}

}  // namespace

void add_outlines(CaseList& list) {
  add_corners(list);
  add_units(list);
  add_channels(list);
  add_many(list);
}

}  // namespace tendril::bench
