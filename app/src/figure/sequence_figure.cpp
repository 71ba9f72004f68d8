#include "figure/sequence_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "figure/gnuplot.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

constexpr const char* colors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8930b", "#56b4e9"};
/// Bands are this many standard deviations wide to either side.
constexpr double deviations = 2.0;

struct ForceUnit {
  const char* name;
  double size;
};

ForceUnit unit_of(const SequenceEstimate& estimate) {
  double most = 0.0;
  for (const EstimatedFrame& frame : estimate.frames) {
    for (const FollowedContact& c : frame.contacts) most = std::max(most, c.all.force);
  }
  return most < 1e-3 ? ForceUnit{"µN", 1e-6} : most < 1.0 ? ForceUnit{"mN", 1e-3} : ForceUnit{"N", 1.0};
}

/// A block for each contact: time, force, half the band, place, half the band.
std::string data_of(const SequenceEstimate& estimate, int contacts, const ForceUnit& force, const LengthUnit& length) {
  std::string data = fmt::format("# Force in {}, place in {}; bands are {} standard deviations.\n", force.name,
                                 length.name, deviations);
  for (int number = 1; number <= contacts; ++number) {
    data += fmt::format("\n\n# contact {}.\n# time force band place band\n", number);
    for (const EstimatedFrame& frame : estimate.frames) {
      for (const FollowedContact& c : frame.contacts) {
        if (c.number != number) continue;
        data += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", frame.time, c.all.force / force.size,
                            deviations * c.all.force_error / force.size, c.all.arc_length / length.size,
                            deviations * c.all.arc_length_error / length.size);
      }
    }
  }
  return data;
}

/// One quantity of all contacts; `column`: of its value, with its band in the next one.
std::string plot(const std::string& file, int contacts, int column) {
  std::string out;
  for (int number = 1; number <= contacts; ++number) {
    const std::string block = fmt::format("{} index 'contact {}.' using ", file, number);
    const char* color = colors[static_cast<std::size_t>(number - 1) % std::size(colors)];
    out += fmt::format(
        "{0}{1}1:(${2}-${3}):(${2}+${3}) with filledcurves fillstyle transparent solid 0.25 noborder fillcolor rgb "
        "'{4}' notitle, \\\n     {1}1:{2} with linespoints pointtype 7 pointsize 0.5 linewidth 1.5 linecolor rgb '{4}' "
        "title 'contact {5}'",
        number > 1 ? ", \\\n     " : "plot ", block, column, column + 1, color, number);
  }
  return out + '\n';
}

}  // namespace

void draw_sequence(const std::string& title, const SequenceEstimate& estimate, double length, StagedFiles& files,
                   const std::string& stem, const std::vector<Picture>& pictures) {
  int contacts = 0;
  for (const EstimatedFrame& frame : estimate.frames) {
    for (const FollowedContact& c : frame.contacts) contacts = std::max(contacts, c.number);
  }
  if (contacts == 0) throw InputError("no figure: no frame shows a contact");
  const ForceUnit force = unit_of(estimate);
  const LengthUnit unit = unit_for(length);
  const std::string file = gnuplot_file(stem + ".dat");
  const std::string range =
      fmt::format("set xrange [{:.9g}:{:.9g}]\n", estimate.frames.front().time, estimate.frames.back().time);
  const std::string draw =
      "set multiplot layout 2,1 title " + gnuplot_string(title) + " noenhanced font ',18'\n" + "unset xlabel\n" +
      fmt::format("set yrange [0:*]\nset ylabel 'force ({})' noenhanced\n", force.name) + plot(file, contacts, 2) +
      "unset key\nset autoscale y\n" +
      fmt::format(
          "set xlabel '{}; bands: two standard deviations' noenhanced\nset ylabel 'arc length ({})' noenhanced\n",
          estimate.timed ? "time (s)" : "frame", unit.name) +
      plot(file, contacts, 4) + "unset multiplot\n";
  render({data_of(estimate, contacts, force, unit),
          "set border 3 linewidth 1 linecolor rgb '#404040'\n"
          "set tics out nomirror textcolor rgb '#404040'\n"
          "set grid linewidth 0.6 linecolor rgb '#e4e4e4'\n" +
              range,
          "set key top right\n" + draw, "set key top right\n" + draw, 1000, 800},
         files, stem, pictures);
}

}  // namespace tendril::app
