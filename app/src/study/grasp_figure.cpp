#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "figure/frames.hpp"
#include "figure/gnuplot.hpp"
#include "study/grasp.hpp"
#include "system/tables.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// Cases with the same force limit, in order.
struct Series {
  double limit = 0.0;
  std::vector<const Json*> values, frames;
};

std::vector<Series> series_of(const StudyResult& result, const Json& drawing) {
  std::vector<Series> all;
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    const Json& value = result.values[i];
    if (!value.contains("axial_force") || !value["force_limit"].is_number()) continue;
    const double limit = value["force_limit"];
    const auto found = std::find_if(all.begin(), all.end(), [&](const Series& s) { return s.limit == limit; });
    Series& series = found != all.end() ? *found : all.emplace_back(Series{limit, {}, {}});
    series.values.push_back(&value);
    series.frames.push_back(&drawing["frames"][i]);
  }
  return all;
}

struct Curve2 {
  std::string name, block, color;
  int dash = 1;
};

std::string curves(const std::string& data, const std::vector<Curve2>& list) {
  std::string text;
  for (const Curve2& c : list) {
    text += fmt::format(
        "{}{} index '{}' using 1:2 with linespoints dashtype {} pointtype 7 pointsize 0.6 linewidth 2 "
        "linecolor rgb '{}' title {} noenhanced",
        text.empty() ? "plot " : ", \\\n     ", data, c.block, c.dash, c.color, gnuplot_string(c.name));
  }
  return text + '\n';
}

double value_of(const Json& list, std::size_t i) {
  return list.size() > i && list[i].is_number() ? list[i].get<double>() : std::nan("");
}

/// Panels side by side, and the data behind them.
class GraspStudyFigure {
 public:
  GraspStudyFigure(const Scene& scene, const StudyResult& result, const Json& drawing, std::string file)
      : scene_(scene),
        unit_(unit_for(scene.rod.length())),
        series_(series_of(result, drawing)),
        data_(unit_),
        file_(std::move(file)) {
    if (series_.empty()) throw InputError("no figure: no case came to a grasp");
    if (std::any_of(result.cases.begin(), result.cases.end(), [](const StudyCase& c) { return c.changes_input(); })) {
      add_forces("axial_force", "axial",
                 "set xlabel 'moment of the last actuator (N mm)'\nset ylabel 'axial force of both fingers (N)'\nset "
                 "xzeroaxis linewidth 1 linecolor rgb '#404040'\nset title '(a) axial force; positive: away from the "
                 "palm'\n");
      add_forces("lateral_force", "lateral",
                 "set ylabel 'lateral force of each finger (N)'\nunset xzeroaxis\nset title '(b) lateral force'\n");
    } else {
      for (std::size_t s = 0; s < series_.size(); ++s) add_shapes(s);
      add_actuation();
    }
  }

  void write(StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) const {
    const std::string draw =
        fmt::format("set multiplot layout 1,{}{}\n", count_,
                    scene_.title.empty() ? "" : " title " + gnuplot_string(scene_.title) + " noenhanced") +
        "set border 3 linewidth 1 linecolor rgb '#404040'\nset tics out nomirror font ',12'\n"
        "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\nset key outside bottom center horizontal "
        "Left reverse samplen 2 maxcols 2 height 1.5\n" +
        panels_ + "unset multiplot\n";
    render({data_.text(), "", draw, "reset\n" + draw, 520 * count_, 620}, files, stem, pictures);
  }

 private:
  void add_panel(const std::string& settings, const std::string& plot) {
    panels_ += settings + plot;
    ++count_;
  }
  char letter() const { return static_cast<char>('a' + count_); }

  /// A force over the moment that is swept, a curve for each limit.
  void add_forces(const char* key, const std::string& name, const std::string& settings) {
    std::vector<Curve2> list;
    for (std::size_t s = 0; s < series_.size(); ++s) {
      const std::string block = fmt::format("{} {}", name, s + 1);
      data_.block(block, "moment (N mm), force (N)");
      for (const Json* v : series_[s].values) {
        data_.numbers({(*v)["moments"].back().get<double>() * 1e3, (*v)[key].get<double>()});
      }
      list.push_back({fmt::format("limit {:g} N", series_[s].limit), block, series_color(s)});
    }
    add_panel(settings, curves(file_, list));
  }

  /// Moments or pressures over the diameter, a curve for each limit and actuator.
  void add_actuation() {
    std::vector<Curve2> list;
    for (std::size_t s = 0; s < series_.size(); ++s) {
      for (std::size_t a = 0; a < (*series_[s].values.front())["moments"].size(); ++a) {
        const bool pressures = scene_.rod.actuators[a].knows_pressure();
        const std::string block = fmt::format("actuation {} {}", s + 1, a + 1);
        data_.block(block, pressures ? "diameter, pressure (kPa)" : "diameter, moment (N mm)");
        for (const Json* v : series_[s].values) {
          const double value = pressures ? value_of((*v)["pressures"], a) * 1e-3 : value_of((*v)["moments"], a) * 1e3;
          data_.numbers({(*v)["diameter"].get<double>() / unit_.size, value});
        }
        list.push_back({fmt::format("{:g} N, actuator {}", series_[s].limit, a + 1), block, series_color(s),
                        static_cast<int>(a) + 1});
      }
    }
    const bool pressures = scene_.rod.actuators.empty() || scene_.rod.actuators[0].knows_pressure();
    add_panel(
        fmt::format("set size noratio\nset xlabel 'diameter ({})'\nset ylabel '{}'\nset title '({}) actuation'\nset "
                    "xzeroaxis linewidth 1 linecolor rgb '#404040'\n",
                    unit_.name, pressures ? "pressure (kPa)" : "moment (N mm)", letter()),
        curves(file_, list));
  }

  /// Objects and fingers of all cases with one limit.
  void add_shapes(std::size_t s) {
    std::string plot;
    const std::size_t n = series_[s].values.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Json& frame = *series_[s].frames[i];
      const std::string name = fmt::format("{} {}", s + 1, i + 1);
      add_shapes_of(frame, name);
      const double t = n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 1.0;
      const auto mix = [t](double a, double b) { return static_cast<int>((1.0 - t) * a + t * b); };
      const std::string color = fmt::format("#{:02x}{:02x}{:02x}", mix(224, 31), mix(135, 78), mix(43, 140));
      plot += fmt::format("{}{} index 'object {}.' using 1:2 with lines linewidth 1 linecolor rgb '{}' notitle",
                          plot.empty() ? "plot " : ", \\\n     ", file_, name, color);
      for (std::size_t line = 1; line <= frame["rods"].size(); ++line) {
        plot += fmt::format(
            ", \\\n     {} index 'finger {} {}.' using 1:2 with lines linewidth 2.5 linecolor rgb '{}' "
            "notitle",
            file_, name, line, color);
      }
    }
    add_panel(fmt::format("set size ratio -1\nset xlabel 'x ({0})'\nset ylabel 'y ({0})'\nset title '({1}) force limit "
                          "{2:g} N'\n",
                          unit_.name, letter(), series_[s].limit),
              plot + '\n');
  }

  void add_shapes_of(const Json& frame, const std::string& name) {
    add_edges(data_, lines_of(frame["obstacles"][0]), "object " + name + '.');
    for (std::size_t line = 0; line < frame["rods"].size(); ++line) {
      data_.block(fmt::format("finger {} {}.", name, line + 1), "x y");
      for (const Json& p : frame["rods"][line]["line"]) data_.row(point(p));
    }
  }

  const Scene& scene_;
  LengthUnit unit_;
  std::vector<Series> series_;
  DataFile data_;
  std::string file_;
  std::string panels_;
  int count_ = 0;
};

}  // namespace

void draw_grasp_study(const Scene& scene, const StudyResult& result, const Json& drawing, StagedFiles& files,
                      const std::string& stem, const std::vector<Picture>& pictures) {
  GraspStudyFigure(scene, result, drawing, gnuplot_file(stem + ".dat")).write(files, stem, pictures);
}

}  // namespace tendril::app
