#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "figure/gnuplot.hpp"
#include "study/grasp.hpp"
#include "system/tables.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

constexpr const char* colors[] = {"#1f4e8c", "#e0872b", "#2e7d32", "#7b3f98", "#8c5a2b", "#606060"};

/// Cases with the same force limit, in order.
struct Series {
  double limit = 0.0;
  std::vector<const Json*> values;
};

std::vector<Series> series_of(const StudyResult& result) {
  std::vector<Series> all;
  for (const Json& value : result.values) {
    if (!value.contains("axial_force") || !value["force_limit"].is_number()) continue;
    const double limit = value["force_limit"];
    const auto found = std::find_if(all.begin(), all.end(), [&](const Series& s) { return s.limit == limit; });
    Series& series = found != all.end() ? *found : all.emplace_back(Series{limit, {}});
    series.values.push_back(&value);
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

}  // namespace

void draw_grasp_study(const Scene& scene, const StudyResult& result, StagedFiles& files) {
  const LengthUnit unit = unit_for(scene.rod.length());
  const std::vector<Series> series = series_of(result);
  if (series.empty()) throw InputError("no figure: no case came to a grasp");
  const bool sweep = std::any_of(result.cases.begin(), result.cases.end(), [](const StudyCase& c) { return c.moment; });
  DataFile data(unit);
  std::vector<Curve2> left;
  std::vector<Curve2> right;
  std::string shapes;
  const std::string file = gnuplot_file("figure.dat");
  for (std::size_t s = 0; s < series.size(); ++s) {
    const std::string color = colors[s % std::size(colors)];
    const std::string limit = fmt::format("{:g} N", series[s].limit);
    if (sweep) {
      data.block(fmt::format("axial {}", s + 1), "moment (N mm), force (N)");
      for (const Json* v : series[s].values) {
        data.numbers({(*v)["moments"].back().get<double>() * 1e3, (*v)["axial_force"].get<double>()});
      }
      data.block(fmt::format("lateral {}", s + 1), "moment (N mm), force (N)");
      for (const Json* v : series[s].values) {
        data.numbers({(*v)["moments"].back().get<double>() * 1e3, (*v)["lateral_force"].get<double>()});
      }
      left.push_back({"limit " + limit, fmt::format("axial {}", s + 1), color});
      right.push_back({"limit " + limit, fmt::format("lateral {}", s + 1), color});
      continue;
    }
    for (std::size_t a = 0; a < (*series[s].values.front())["moments"].size(); ++a) {
      const bool pressures = scene.rod.actuators[a].moment_per_pressure != 0.0;
      const std::string block = fmt::format("actuation {} {}", s + 1, a + 1);
      data.block(block, pressures ? "diameter, pressure (kPa)" : "diameter, moment (N mm)");
      for (const Json* v : series[s].values) {
        const double value = pressures ? value_of((*v)["pressures"], a) * 1e-3 : value_of((*v)["moments"], a) * 1e3;
        data.numbers({(*v)["diameter"].get<double>() / unit.size, value});
      }
      left.push_back({fmt::format("{}, actuator {}", limit, a + 1), block, color, static_cast<int>(a) + 1});
    }
    for (std::size_t i = 0; i < series[s].values.size(); ++i) {
      const Json& v = *series[s].values[i];
      const std::string name = fmt::format("{} {}", s + 1, i + 1);
      data.block("object " + name, "x y");
      for (int k = 0; k <= 90; ++k) {
        const double turn = 2.0 * std::numbers::pi * k / 90.0;
        const Json& o = v["objects"][0];
        data.row({o[0].get<double>() + o[2].get<double>() * std::cos(turn),
                  o[1].get<double>() + o[2].get<double>() * std::sin(turn)});
      }
      for (std::size_t line = 0; line < v["lines"].size(); ++line) {
        data.block(fmt::format("finger {} {}", name, line + 1), "x y");
        for (const Json& p : v["lines"][line]) data.row({p[0].get<double>(), p[1].get<double>()});
      }
    }
  }
  std::string panels;
  const std::string common =
      "set border 3 linewidth 1 linecolor rgb '#404040'\nset tics out nomirror font ',12'\n"
      "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\nset key outside bottom center horizontal "
      "Left reverse samplen 2 maxcols 2 height 1.5\n";
  int count = 0;
  const auto next = [&](const std::string& settings, const std::string& plot) {
    panels += settings + plot;
    ++count;
  };
  if (sweep) {
    next(
        "set xlabel 'moment of the last actuator (N mm)'\nset ylabel 'axial force of both fingers (N)'\nset xzeroaxis "
        "linewidth 1 linecolor rgb '#404040'\nset title '(a) axial force; positive: away from the palm'\n",
        curves(file, left));
    next("set ylabel 'lateral force of each finger (N)'\nunset xzeroaxis\nset title '(b) lateral force'\n",
         curves(file, right));
  } else {
    for (std::size_t s = 0; s < series.size(); ++s) {
      std::string plot;
      const std::size_t n = series[s].values.size();
      for (std::size_t i = 0; i < n; ++i) {
        const double t = n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 1.0;
        const auto mix = [t](double a, double b) { return static_cast<int>((1.0 - t) * a + t * b); };
        const std::string color = fmt::format("#{:02x}{:02x}{:02x}", mix(224, 31), mix(135, 78), mix(43, 140));
        const std::string name = fmt::format("{} {}", s + 1, i + 1);
        plot += fmt::format("{}{} index 'object {}' using 1:2 with lines linewidth 1 linecolor rgb '{}' notitle",
                            plot.empty() ? "plot " : ", \\\n     ", file, name, color);
        for (std::size_t line = 1; line <= (*series[s].values[i])["lines"].size(); ++line) {
          plot += fmt::format(
              ", \\\n     {} index 'finger {} {}' using 1:2 with lines linewidth 2.5 linecolor rgb '{}' "
              "notitle",
              file, name, line, color);
        }
      }
      next(fmt::format("set size ratio -1\nset xlabel 'x ({0})'\nset ylabel 'y ({0})'\nset title '({1}) force limit "
                       "{2:g} N'\n",
                       unit.name, static_cast<char>('a' + count), series[s].limit),
           plot + '\n');
    }
    const bool pressures = scene.rod.actuators.empty() || scene.rod.actuators[0].moment_per_pressure != 0.0;
    next(fmt::format("set size noratio\nset xlabel 'diameter ({})'\nset ylabel '{}'\nset title '({}) actuation'\nset "
                     "xzeroaxis linewidth 1 linecolor rgb '#404040'\n",
                     unit.name, pressures ? "pressure (kPa)" : "moment (N mm)", static_cast<char>('a' + count)),
         curves(file, left));
  }
  std::string draw = fmt::format("set multiplot layout 1,{}{}\n", count,
                                 scene.title.empty() ? "" : " title " + gnuplot_string(scene.title) + " noenhanced");
  draw += common + panels + "unset multiplot\n";
  files.write("figure.dat", data.text());
  const std::vector<Picture> pictures{Picture::svg, Picture::png};
  const std::string head = "# Give this to gnuplot to draw the figure anew.\nset encoding utf8\n";
  files.write("figure.gnuplot", head + drawn_to(pictures, "figure", 520 * count, 620, draw, "reset\n" + draw));
  render(files, "figure", pictures);
}

}  // namespace tendril::app
