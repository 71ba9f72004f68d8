#include "result/estimate_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "result/fit_parts.hpp"

namespace tendril::app {

namespace {

Json contact_json(const EstimatedContact& contact) {
  const bool known = contact.identifiable;
  const auto value = [&](double v) { return known ? number(v) : Json(nullptr); };
  const auto vector = [&](Vec2 v) { return known ? Json{number(v.x), number(v.y)} : Json(nullptr); };
  Json json;
  json["arc_length"] = value(contact.arc_length);
  json["force"] = value(contact.force);
  json["point"] = vector(contact.point);
  json["normal"] = vector(contact.normal);
  json["force_error"] = number(contact.force_error);
  json["arc_length_error"] = number(contact.arc_length_error);
  json["correlation"] = number(contact.correlation);
  if (const std::optional<EstimatedFriction>& f = contact.friction) {
    json["tangential_force"] = value(contact.tangential_force);
    json["friction_range"] = friction_json(*f);
  }
  json["at_tip"] = contact.at_tip;
  json["identifiable"] = known;
  json["reason"] = contact.reason;
  return json;
}

Json tests_json(const std::vector<ContactTest>& tests) {
  Json array = Json::array();
  for (const ContactTest& test : tests) {
    array.push_back({{"contacts", test.contacts},
                     {"chi2", number(test.chi_square)},
                     {"degrees_of_freedom", test.degrees_of_freedom},
                     {"probability", number(test.probability)},
                     {"supported", test.supported},
                     {"converged", test.converged}});
  }
  return array;
}

std::string contacts_text(const Estimate& estimate, const DisplayUnits& units) {
  if (estimate.contacts.empty()) return "";
  Grid grid;
  grid.row({"contact", "force", "error", "arc length", "error", "correlation", "point", "direction"});
  std::string reasons;
  for (std::size_t k = 0; k < estimate.contacts.size(); ++k) {
    const EstimatedContact& c = estimate.contacts[k];
    const std::string name = std::to_string(k + 1) + (c.at_tip ? " (tip)" : "");
    if (!c.identifiable) {
      grid.row({name, "not identifiable"});
      reasons += fmt::format("contact {} is not identifiable: {}\n", k + 1, printable(c.reason));
      continue;
    }
    grid.row({name, force(c.force), fmt::format("{:.2g} %", 100.0 * c.force_error / c.force),
              units.lengths(c.arc_length), units.lengths(c.arc_length_error), fmt::format("{:.4f}", c.correlation),
              units.point(c.point), fmt::format("({:.4f}, {:.4f})", c.normal.x, c.normal.y)});
  }
  return '\n' + grid.text("") + reasons;
}

/// What friction can have to do with it, whatever its state.
std::string friction_text(const Estimate& estimate, const DisplayUnits& units) {
  Grid grid;
  grid.row({"contact", "tangential / normal", "force", "tangential force", "arc length"});
  const auto forces = [](double v) { return force(v); };
  const auto ratios = [](double v) { return shown(v, 3); };
  const auto lengths = [&](double v) { return units.lengths(v); };
  std::string cut;
  for (std::size_t k = 0; k < estimate.contacts.size(); ++k) {
    const std::optional<EstimatedFriction>& f = estimate.contacts[k].friction;
    if (!f) return "";
    grid.row({std::to_string(k + 1), interval_text(f->ratio, ratios), interval_text(f->force, forces),
              interval_text(f->tangential_force, forces), interval_text(f->arc_length, lengths)});
    if (!f->whole) cut = "not every state within the cone was fitted\n";
  }
  return estimate.contacts.empty()
             ? ""
             : "\nwhatever friction does, each at its best fit (noise comes on top)\n" + grid.text("") + cut;
}

std::string tests_text(const std::vector<ContactTest>& tests) {
  if (tests.empty()) return "";
  Grid grid;
  grid.row({"contacts", "chi-square", "degrees of freedom", "better by chance", "supported by the points"});
  for (const ContactTest& test : tests) {
    const std::string chance = test.contacts == 0 ? "" : fmt::format("{:.2g}", test.probability);
    const std::string answer = test.contacts == 0 ? "" : test.supported ? "yes" : "no";
    grid.row({std::to_string(test.contacts),
              std::isfinite(test.chi_square) ? fmt::format("{:.6g}", test.chi_square) : "none",
              std::to_string(test.degrees_of_freedom), chance, answer});
  }
  return '\n' + grid.text("");
}

}  // namespace

std::string estimate_json(const Scene& scene, const Estimate& estimate, const RunInfo& run) {
  Json json;
  add_fit(json, scene, estimate, scene.measurement.points, run);
  json["moments"] = numbers(estimate.moments);
  json["contacts"] = Json::array();
  for (const EstimatedContact& contact : estimate.contacts) json["contacts"].push_back(contact_json(contact));
  // Force and arc length of each contact in turn.
  json["covariance"] = Json::array();
  for (Eigen::Index i = 0; i < estimate.covariance.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < estimate.covariance.cols(); ++k) row.push_back(number(estimate.covariance(i, k)));
    json["covariance"].push_back(std::move(row));
  }
  json["tests"] = tests_json(estimate.tests);
  json["points"] = scene.measurement.points.size();
  json["plugins"] = components_json(run.components);
  return written(json);
}

std::string estimate_report(const Scene& scene, const Estimate& estimate) {
  const DisplayUnits units(scene);
  std::string text = fit_heading(scene, estimate) + note_lines(estimate.notes);
  if (!estimate.backbone.empty()) {
    text += line("points", fmt::format("{}, residuals {} (rms of a coordinate)", scene.measurement.points.size(),
                                       units.lengths(estimate.residual_rms)));
    text += noise_line(estimate, units) + fit_lines(estimate, units);
    text += contacts_text(estimate, units) + friction_text(estimate, units);
  }
  text += tests_text(estimate.tests);
  return text + fit_end(estimate);
}

}  // namespace tendril::app
