#include "result/uncertainty_result.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "result/report_parts.hpp"
#include "system/tables.hpp"

namespace tendril::app {

namespace {

/// The quantities whose names end so, in their order.
std::vector<double> ending_in(const Uncertainty& uncertainty, std::string_view end) {
  std::vector<double> values;
  for (const ResultQuantity& q : uncertainty.deviations) {
    if (q.name.ends_with(end)) values.push_back(q.value);
  }
  return values;
}

double value_of(const Uncertainty& uncertainty, std::string_view name) { return ending_in(uncertainty, name).front(); }

std::string quantity_text(const DisplayUnits& units, const ResultQuantity& q) {
  return q.unit == "m"     ? units.lengths(q.value)
         : q.unit == "rad" ? angle(q.value)
         : q.unit.empty()  ? shown(q.value, 3)
                           : force(q.value);
}

}  // namespace

Json uncertainty_json(const Uncertainty& uncertainty) {
  Json json{{"kind", to_string(uncertainty.kind)}};
  if (!uncertainty.trouble.empty()) {
    json["trouble"] = uncertainty.trouble;
    return json;
  }
  if (!uncertainty.warning.empty()) json["warning"] = uncertainty.warning;
  json["tip"] = {{"x", number(value_of(uncertainty, "tip.x"))},
                 {"y", number(value_of(uncertainty, "tip.y"))},
                 {"angle", number(value_of(uncertainty, "tip.angle"))}};
  json["forces"] = numbers(ending_in(uncertainty, ".force"));
  json["arc_lengths"] = numbers(ending_in(uncertainty, ".arc_length"));
  json["stability"] = number(value_of(uncertainty, "stability"));
  json["shares"] = Json::object();
  for (const Uncertainty::Share& share : uncertainty.shares) json["shares"][share.key] = number(share.tip);
  Json::array_t shape;
  for (const Uncertainty::Point& p : uncertainty.shape) shape.push_back(numbers({p.arc_length, p.xx, p.xy, p.yy}));
  json["shape"] = std::move(shape);
  return json;
}

std::string uncertainty_text(const Scene& scene, const Uncertainty& uncertainty) {
  if (!uncertainty.trouble.empty()) return line("error bars", "none: " + printable(uncertainty.trouble));
  const DisplayUnits units(scene);
  std::string deviations;
  for (const ResultQuantity& q : uncertainty.deviations) {
    deviations += (deviations.empty() ? "" : ", ") + q.name + " +- " + quantity_text(units, q);
  }
  std::vector<Uncertainty::Share> shares = uncertainty.shares;
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.tip > b.tip; });
  std::string inputs;
  for (const Uncertainty::Share& share : shares) {
    inputs += fmt::format("{}{} {:.3g} %", inputs.empty() ? "" : ", ", printable(share.key), 100.0 * share.tip);
  }
  std::string text = line("error bars", deviations + " (moments held)") + line("", "the tip's from " + inputs);
  if (!uncertainty.warning.empty()) text += line("", printable(uncertainty.warning));
  return text;
}

std::string sensitivity_json(const Scene& scene, const Sensitivity& sensitivity,
                             const std::vector<KeySensitivity>& keys) {
  Json json{{"schema", 1}, {"scene", scene.file}, {"kind", to_string(sensitivity.kind)}};
  if (!sensitivity.trouble.empty()) json["trouble"] = sensitivity.trouble;
  json["quantities"] = Json::array();
  for (const ResultQuantity& q : sensitivity.quantities) {
    json["quantities"].push_back({{"name", q.name}, {"unit", q.unit}, {"value", number(q.value)}});
  }
  json["numbers"] = Json::array();
  for (const KeySensitivity& key : keys) {
    Json one{{"key", key.key}, {"value", key.value}};
    if (key.trouble.empty()) {
      one["derivatives"] = numbers(key.rates);
    } else {
      one["trouble"] = key.trouble;
    }
    json["numbers"].push_back(std::move(one));
  }
  return written(json);
}

std::string sensitivity_report(const Scene& scene, const Sensitivity& sensitivity,
                               const std::vector<KeySensitivity>& keys) {
  std::string text = heading(scene) + '\n';
  if (!sensitivity.trouble.empty()) return text + line("derivatives", "none: " + printable(sensitivity.trouble));
  text += line("derivatives", sensitivity.kind == SensitivityKind::held ? "of what the rod does under held moments, SI"
                                                                        : "of the plan, planned anew, SI");
  Grid grid;
  std::vector<std::string> head{"by", "value"};
  for (const ResultQuantity& q : sensitivity.quantities) head.push_back(q.name);
  grid.row(head);
  std::string refused;
  for (const KeySensitivity& key : keys) {
    if (!key.trouble.empty()) {
      refused += line("none by", printable(key.key) + ": " + printable(key.trouble));
      continue;
    }
    std::vector<std::string> row{printable(key.key), printable(key.value)};
    for (const double rate : key.rates) row.push_back(fmt::format("{:.6g}", rate + 0.0));
    grid.row(row);
  }
  return text + '\n' + grid.text("") + (refused.empty() ? "" : '\n' + refused);
}

}  // namespace tendril::app
