#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "figure/panels.hpp"
#include "study/grasp.hpp"
#include "study/result.hpp"
#include "system/tables.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/scale.hpp"

namespace tendril::app {

namespace {

/// More panels than these cannot be read.
constexpr std::size_t most_columns = 6;
constexpr std::size_t most_rows = 6;

std::string title_of(const std::optional<StudyMode>& mode) {
  if (!mode) return "";
  return *mode == StudyMode::ignore_then_execute ? "ignore, then execute" : std::string(to_string(*mode));
}

/// A power of ten of a unit.
struct BarUnit {
  double size = 1.0;
  std::string name;
};
/// The one in which `largest` (in `unit`) is at most `goal`, but above a tenth of it: all bars then share an axis.
BarUnit bar_unit(double largest, double goal, const std::string& unit) {
  if (!(largest > 0.0) || !(goal > 0.0)) return {1.0, unit};
  const int exponent = static_cast<int>(std::ceil(std::log10(largest / goal)));
  return {std::pow(10.0, exponent), exponent == 0   ? unit
                                    : exponent == 1 ? "10 " + unit
                                    : exponent == 2 ? "100 " + unit
                                                    : fmt::format("1e{} {}", exponent, unit)};
}

std::vector<BarPanel> bars_of(const Scene& scene, const StudyResult& result, std::size_t columns) {
  const DisplayUnits units(scene);
  const auto drawn = [](const std::string& unit) {
    return unit.ends_with("um") ? unit.substr(0, unit.size() - 2) + "µm" : unit;
  };
  const std::string length = drawn(units.length.name);
  double error = 0.0;
  double moment = 0.0;
  double force = 0.0;
  for (const StudyGroup& g : result.groups) {
    error = std::max(error, g.tip_error.mean / units.length.size);
    moment = std::max(moment, g.moment.mean / units.moment_unit.size);
    force = std::max(force, g.contact_force.mean * 1e3);
  }
  if (!(error > 0.0)) error = moment;
  const double grazing = grazing_force * scale_of(scene).force();
  BarUnit bending = bar_unit(moment, error, drawn(units.moment_unit.name));
  bending.size *= units.moment_unit.size;
  BarUnit newton = bar_unit(force, error, "mN");
  newton.size *= 1e-3;
  std::vector<BarPanel> panels(columns);
  for (std::size_t i = 0; i < result.groups.size(); ++i) {
    const StudyGroup& g = result.groups[i];
    BarPanel& panel = panels[i % columns];
    panel.title = title_of(g.mode);
    panel.quantities = {{"moment", bending.name}, {"tip error", length}, {"contact force", newton.name}};
    const std::size_t row = i / columns;
    const bool touches = g.contact_force.mean >= grazing;
    panel.series.push_back({g.limit ? "limit " + limit_text(units, *g.limit, g.limited) : "all cases",
                            series_color(row),
                            {g.moment.mean / bending.size, g.tip_error.mean / units.length.size,
                             touches ? g.contact_force.mean / newton.size : 0.0},
                            {g.moment.deviation / bending.size, g.tip_error.deviation / units.length.size,
                             touches ? g.contact_force.deviation / newton.size : 0.0}});
  }
  return panels;
}

}  // namespace

std::string series_color(std::size_t i) {
  constexpr const char* colors[] = {"#1f4e8c", "#e0872b", "#2e7d32", "#7b3f98", "#8c5a2b", "#606060"};
  return colors[i % std::size(colors)];
}

void draw_study(const Scene& scene, const StudyResult& result, const Json& drawing, StagedFiles& files,
                const std::string& stem, const std::vector<Picture>& pictures) {
  if (scene.problem == ProblemKind::grasp) return draw_grasp_study(scene, result, drawing, files, stem, pictures);
  std::size_t columns = 1;
  while (columns < result.groups.size() && result.groups[columns].limit == result.groups[0].limit) ++columns;
  const std::size_t rows = result.groups.size() / columns;
  if (columns > most_columns || rows > most_rows) {
    throw InputError(fmt::format("no figure: found {} modes and {} limits, expected at most {} and {}", columns, rows,
                                 most_columns, most_rows));
  }
  const DisplayUnits units(scene);
  std::vector<std::vector<ShapePanel>> panels(rows);
  for (std::size_t i = 0; i < result.groups.size(); ++i) {
    const StudyGroup& group = result.groups[i];
    ShapePanel panel(drawing);
    for (ShapePanel::Obstacle& obstacle : panel.obstacles)
      obstacle.ignored = group.mode ? *group.mode == StudyMode::ignore : obstacle.ignored;
    panel.title = title_of(group.mode);
    if (group.limit) panel.title += (panel.title.empty() ? "" : ", ") + limit_text(units, *group.limit, group.limited);
    panel.color = series_color(i / columns);
    panels[i / columns].push_back(std::move(panel));
  }
  std::size_t group = 0;
  int seen = 0;
  for (std::size_t i = 0; i < result.cases.size(); ++i) {
    if (seen == result.groups[group].cases) {
      ++group;
      seen = 0;
    }
    ++seen;
    panels[group / columns][group % columns].add(drawing["frames"][i]);
  }
  draw_panels(scene.title, panels, bars_of(scene, result, columns), {}, files, stem, pictures);
}

}  // namespace tendril::app
