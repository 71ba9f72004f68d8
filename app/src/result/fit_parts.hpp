#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "result/report_parts.hpp"
#include "result/result_object.hpp"
#include "system/tables.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/estimate.hpp"

/// What is told alike of all that is fitted to measured points. `Fit`: Estimate or SequenceEstimate.
namespace tendril::app {

/// Adds what a fit is of, how well it fits, and where the rod is.
template <class Fit>
void add_fit(Json& json, const Scene& scene, const Fit& fit, const std::vector<MeasuredPoint>& points,
             const RunInfo& run) {
  json["schema"] = 1;
  json["status"] = to_string(fit.status);
  json["message"] = fit.message;
  if (!fit.assumed.empty()) json["assumed"] = fit.assumed;
  if (!fit.notes.empty()) json["notes"] = fit.notes;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["problem"] = to_string(scene.problem);
  json["coordinates"] = {{"name", LegendreBasis::name}, {"order", fit.order}, {"split_at_contact", true}};
  json["noise"] = number(fit.noise);
  json["noise_estimated"] = fit.noise_estimated;
  json["residual_rms"] = number(fit.residual_rms);
  json["chi2"] = number(fit.chi_square);
  json["degrees_of_freedom"] = fit.degrees_of_freedom;
  json["fit_probability"] = number(fit.fit_probability);
  json["model_error"] = number(fit.model_error);
  json["starts"] = fit.starts;
  json["solves"] = fit.solves;
  // Without a shape there is no tip: nulls.
  const BackbonePoint nowhere{infinity, infinity, infinity, infinity, infinity};
  const BackbonePoint& tip = fit.backbone.empty() ? nowhere : fit.backbone.back();
  json["tip"] = {{"x", number(tip.x)}, {"y", number(tip.y)}, {"angle", number(tip.angle)}};
  json["left_out"] = left_out_json(fit.left_out);
  json["seconds"] = {
      {"read", number(run.seconds_read)}, {"open", number(run.seconds_open)}, {"solve", number(fit.seconds)}};
  json["backbone"] = backbone_json(fit.backbone);
  json["measured"] = Json::array();
  for (const MeasuredPoint& p : points) json["measured"].push_back(numbers({p.position.x, p.position.y}));
  json["versions"] = versions_json();
}

inline Json friction_json(const EstimatedFriction& friction) {
  const auto interval = [](Interval i) { return numbers({i.low, i.high}); };
  return {{"ratio", interval(friction.ratio)},
          {"force", interval(friction.force)},
          {"tangential_force", interval(friction.tangential_force)},
          {"arc_length", interval(friction.arc_length)},
          {"whole", friction.whole}};
}

/// An interval, its ends written by `text`.
template <class Text>
std::string interval_text(Interval i, const Text& text) {
  return text(i.low) + " to " + text(i.high);
}

/// Title, status, and why it is none better.
template <class Fit>
std::string fit_heading(const Scene& scene, const Fit& fit) {
  return heading(scene) + '\n' + line("status", std::string(to_string(fit.status))) +
         (fit.message.empty() ? "" : line("", printable(fit.message)));
}

template <class Fit>
std::string noise_line(const Fit& fit, const DisplayUnits& units) {
  return line("noise", units.lengths(fit.noise) + (fit.noise_estimated ? " (estimated from the residuals)" : ""));
}

/// How well it fits, and by what.
template <class Fit>
std::string fit_lines(const Fit& fit, const DisplayUnits& units) {
  return line("chi-square",
              fmt::format("{:.4g} with {} degrees of freedom{}", fit.chi_square, fit.degrees_of_freedom,
                          fit.noise_estimated ? "" : fmt::format(", probability {:.2g}", fit.fit_probability))) +
         line("model",
              fmt::format("order {} per piece, points exact to {}", fit.order, units.lengths(fit.model_error))) +
         (fit.assumed.empty() ? "" : line("assumed", fit.assumed));
}

/// What was left out, and what it took.
template <class Fit>
std::string fit_end(const Fit& fit) {
  return left_out_text(fit.left_out) +
         fmt::format("\ntime: {}, {} starts, {} equilibria\n", seconds(fit.seconds), fit.starts, fit.solves);
}

}  // namespace tendril::app
