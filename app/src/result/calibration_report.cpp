#include "result/calibration_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "result/fit_parts.hpp"

namespace tendril::app {

namespace {

/// Correlations of this size are told: a change of one number then nearly undoes that of the other.
constexpr double notable_correlation = 0.9;

double correlation(const Calibration& c, std::size_t i, std::size_t k) {
  const double product = c.numbers[i].error * c.numbers[k].error;
  return product > 0.0 ? c.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) / product : 0.0;
}

Json number_json(const CalibratedNumber& number) {
  Json json;
  json["kind"] = to_string(number.spec.kind);
  json["name"] = number.name;
  json["unit"] = number.unit;
  json["segment"] = number.spec.segment;
  json["actuator"] = is_law(number.spec.kind) ? number.spec.actuator : 0;
  json["power"] = number.power;
  json["value"] = number.identifiable ? tendril::app::number(number.value) : Json(nullptr);
  json["error"] = number.identifiable ? tendril::app::number(number.error) : Json(nullptr);
  json["identifiable"] = number.identifiable;
  json["at_bound"] = number.at_bound;
  json["reason"] = number.reason;
  return json;
}

Json tips_json(const TipErrors& tips) {
  return {{"count", tips.count},
          {"mean", number(tips.mean)},
          {"median", number(tips.median)},
          {"largest", number(tips.largest)}};
}

Json points_json(const std::vector<Vec2>& points) {
  Json list = Json::array();
  for (const Vec2 p : points) list.push_back({number(p.x), number(p.y)});
  return list;
}

Json shape_json(const CalibratedShape& shape) {
  return {{"name", shape.name},
          {"check_only", shape.check_only},
          {"rms", number(shape.rms)},
          {"tip_error", number(shape.tip_error)},
          {"left_out_rms", number(shape.left_out_rms)},
          {"left_out_tip_error", number(shape.left_out_tip_error)},
          {"beyond", shape.beyond},
          {"measured", points_json(shape.measured)},
          {"fitted", points_json(shape.fitted)}};
}

std::string numbers_text(const Calibration& c) {
  Grid grid;
  grid.row({"number", "value", "error", "unit"});
  std::string reasons;
  for (const CalibratedNumber& n : c.numbers) {
    const std::string unit = n.unit.empty() ? "factor" : n.unit;
    if (!n.identifiable) {
      grid.row({printable(n.name), "not identifiable", "", unit});
      continue;
    }
    grid.row(
        {printable(n.name), fmt::format("{:.6g}", n.value),
         n.at_bound ? "at its bound" : fmt::format("{:.2g} ({:.2g} %)", n.error, 100.0 * n.error / std::abs(n.value)),
         unit});
  }
  for (const std::string& direction : c.undetermined) reasons += "not determined: " + printable(direction) + '\n';
  for (std::size_t i = 0; i < c.numbers.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double r = correlation(c, i, k);
      if (std::abs(r) < notable_correlation) continue;
      reasons += fmt::format("correlation of {} and {}: {:.4f}\n", printable(c.numbers[k].name),
                             printable(c.numbers[i].name), r);
    }
  }
  return '\n' + grid.text("") + reasons;
}

std::string tips_text(const Calibration& c) {
  Grid grid;
  grid.row({"tip errors, % of the length", "recordings", "mean", "median", "largest"});
  const auto add = [&](const std::string& name, const TipErrors& tips) {
    if (tips.count == 0) return;
    const auto percent = [&](double v) { return fmt::format("{:.3g}", 100.0 * v / c.length); };
    grid.row({name, std::to_string(tips.count), percent(tips.mean), percent(tips.median), percent(tips.largest)});
  };
  add("fitted", c.fitted);
  add("left out in turn, within the others' loads", c.left_out);
  add("left out in turn, beyond them", c.left_out_beyond);
  add("only checked, within the fitted loads", c.checked);
  add("only checked, beyond them", c.checked_beyond);
  return '\n' + grid.text("");
}

std::string beyond_text(const Calibration& c) {
  std::string text;
  constexpr int most = 10;
  int count = 0;
  for (const CalibratedShape& shape : c.shapes) {
    if (shape.beyond.empty() || ++count > most) continue;
    text += "beyond: " + printable(shape.name + ": " + shape.beyond) + '\n';
  }
  if (count > most) text += fmt::format("beyond: {} more\n", count - most);
  return text;
}

}  // namespace

std::string calibration_json(const Scene& scene, const Calibration& c, const RunInfo& run) {
  Json json;
  json["schema"] = 1;
  json["status"] = to_string(c.status);
  json["message"] = c.message;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["problem"] = "calibrate";
  json["length"] = number(c.length);
  json["numbers"] = Json::array();
  for (const CalibratedNumber& n : c.numbers) json["numbers"].push_back(number_json(n));
  json["covariance"] = Json::array();
  for (Eigen::Index i = 0; i < c.covariance.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < c.covariance.cols(); ++k) row.push_back(number(c.covariance(i, k)));
    json["covariance"].push_back(std::move(row));
  }
  json["undetermined"] = c.undetermined;
  json["noise"] = number(c.noise);
  json["noise_estimated"] = c.noise_estimated;
  json["repeatability"] = number(c.repeatability);
  json["residual_rms"] = number(c.residual_rms);
  json["degrees_of_freedom"] = c.degrees_of_freedom;
  json["folds"] = c.folds;
  json["tip_errors"] = {{"fitted", tips_json(c.fitted)},
                        {"left_out", tips_json(c.left_out)},
                        {"left_out_beyond", tips_json(c.left_out_beyond)},
                        {"checked", tips_json(c.checked)},
                        {"checked_beyond", tips_json(c.checked_beyond)}};
  json["ranges"] = c.ranges;
  json["warnings"] = c.warnings;
  json["shapes"] = Json::array();
  for (const CalibratedShape& shape : c.shapes) json["shapes"].push_back(shape_json(shape));
  json["starts"] = c.starts;
  json["starts_agreed"] = c.starts_agreed;
  json["solves"] = c.solves;
  json["order"] = c.order;
  json["model_error"] = number(c.model_error);
  json["left_out"] = left_out_json(scene.left_out);
  json["seconds"] = {{"read", number(run.seconds_read)}, {"solve", number(c.seconds)}};
  json["versions"] = versions_json();
  return written(json);
}

std::string calibration_report(const Scene& scene, const Calibration& c) {
  const DisplayUnits units(scene);
  std::string text = fit_heading(scene, c);
  if (!c.shapes.empty()) {
    text += line("recordings",
                 fmt::format("{}, residuals {} (rms of a coordinate)", c.shapes.size(), units.lengths(c.residual_rms)));
    text += noise_line(c, units);
    if (std::isfinite(c.repeatability)) {
      text += line("repeated", units.lengths(c.repeatability) + " between recordings under the same loads");
    }
    text += numbers_text(c) + tips_text(c) + beyond_text(c);
    text += "\nfitted loads\n";
    for (const std::string& range : c.ranges) text += "  " + printable(range) + '\n';
  }
  for (const std::string& warning : c.warnings) text += "note: " + printable(warning) + '\n';
  return text + left_out_text(scene.left_out) +
         fmt::format("\ntime: {}, {} starts of which {} agreed, {} equilibria, order {}, points exact to {}\n",
                     seconds(c.seconds), c.starts, c.starts_agreed, c.solves, c.order, units.lengths(c.model_error));
}

}  // namespace tendril::app
