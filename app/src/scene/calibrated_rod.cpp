#include "scene/calibrated_rod.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace tendril::app {

namespace {

/// Settings of keys below [rod], in the order in which they were made.
class Settings {
 public:
  Settings(const Document& document, const Units& units) : document_(document), units_(units) {}

  /// The keys of a table of the rod, by its path; null: there is none.
  const Node* at(const std::string& path) const;
  /// A value of the document in SI, if it is a number.
  std::optional<double> number(const Node* table, const std::string& key, const Dimension& dimension) const;
  void set(const std::string& path, const std::string& value) { all_.push_back({"calibrated", path, value}); }
  /// A number with its standard deviation, both in `unit`.
  void set(const std::string& path, double value, double error, std::string_view unit) {
    set(path, fmt::format("{:.12g} {} +- {:.4g} {}", value, unit, error, unit));
  }
  /// Multiplies one of two keys that say the same in different ways; false: neither is there.
  bool multiply(const std::string& table, const std::pair<std::string, Dimension>& one,
                const std::pair<std::string, Dimension>& other, double factor, double error);
  const std::vector<Override>& all() const { return all_; }

 private:
  const Document& document_;
  const Units& units_;
  std::vector<Override> all_;
};

const Node* Settings::at(const std::string& path) const {
  const Node* node = &document_.root();
  std::size_t from = 0;
  while (node != nullptr && from < path.size()) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    const std::string part = path.substr(from, dot - from);
    if (const auto* list = std::get_if<Node::List>(&node->value)) {
      const auto index = static_cast<std::size_t>(std::stoul(part));
      node = index < list->size() ? &(*list)[index] : nullptr;
    } else {
      node = node->find(part);
    }
    from = dot + 1;
  }
  return node;
}

std::optional<double> Settings::number(const Node* table, const std::string& key, const Dimension& dimension) const {
  const Node* node = table != nullptr ? table->find(key) : nullptr;
  if (node == nullptr) return std::nullopt;
  if (const auto* integer = std::get_if<std::int64_t>(&node->value)) return static_cast<double>(*integer);
  if (const auto* real = std::get_if<double>(&node->value)) return *real;
  if (const auto* text = std::get_if<std::string>(&node->value)) return units_.read(*text, dimension);
  return std::nullopt;
}

bool Settings::multiply(const std::string& table, const std::pair<std::string, Dimension>& one,
                        const std::pair<std::string, Dimension>& other, double factor, double error) {
  bool any = false;
  for (const auto& [key, dimension] : {one, other}) {
    if (const auto value = number(at(table), key, dimension)) {
      set(table + '.' + key, *value * factor, std::abs(*value) * error, dimension.unit);
      any = true;
    }
  }
  return any;
}

/// The tables that describe a rod's segments: itself, or one for each.
std::vector<std::string> segment_tables(const Settings& settings) {
  const Node* segments = settings.at("rod.segment");
  if (segments == nullptr) return {"rod"};
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::get<Node::List>(segments->value).size(); ++i) {
    out.push_back("rod.segment." + std::to_string(i));
  }
  return out;
}

/// Puts a number where [rod] has it; false: it has no key for that.
bool put(Settings& settings, const CalibratedNumber& number) {
  const CalibrationUnknownSpec& spec = number.spec;
  std::vector<std::string> tables = segment_tables(settings);
  bool whole = true;
  for (const std::string& table : tables) whole = whole && settings.at(table)->find("file") == nullptr;
  if (spec.segment > 0 && whole) tables = {tables[static_cast<std::size_t>(spec.segment - 1)]};
  switch (spec.kind) {
    case CalibrationUnknown::stiffness:
      for (const std::string& table : tables) {
        whole = whole && settings.multiply(table, {"bending_stiffness", dimension::stiffness},
                                           {"youngs_modulus", dimension::pressure}, number.value, number.error);
      }
      return whole;
    case CalibrationUnknown::density:
      for (const std::string& table : tables) {
        whole = whole && settings.multiply(table, {"linear_density", dimension::linear_density},
                                           {"density", dimension::density}, number.value, number.error);
      }
      return whole;
    case CalibrationUnknown::rest_curvature:
      if (whole)
        settings.set(tables.front() + ".rest_curvature", number.value, number.error, dimension::curvature.unit);
      return whole;
    case CalibrationUnknown::moment: {
      const std::string actuator = "rod.actuator." + std::to_string(spec.actuator - 1);
      if (spec.degree > 1 || number.unit != "N m/Pa") return false;
      settings.set(actuator + ".moment_per_pressure", number.value, number.error, number.unit);
      return true;
    }
    case CalibrationUnknown::base_angle:
      if (spec.per == CalibrationScope::all)
        settings.set("rod.base.angle", number.value, number.error, dimension::angle.unit);
      return spec.per == CalibrationScope::all;
    case CalibrationUnknown::base_x:
    case CalibrationUnknown::base_y:
      break;
  }
  return false;
}

}  // namespace

std::string calibrated_rod(const Document& document, const Units& units, const Calibration& calibration) {
  std::string told = "# Calibrated; standard deviations behind +-.\n";
  Settings settings(document, units);
  for (const CalibratedNumber& number : calibration.numbers) {
    if (!number.identifiable) {
      told += fmt::format("# {}: not identifiable\n", number.name);
      continue;
    }
    const bool done = put(settings, number);
    told += fmt::format("# {} = {:.8g} +- {:.2g}{}{}{}\n", number.name, number.value, number.error,
                        number.unit.empty() ? "" : " ", number.unit,
                        done ? "" : ": not among the keys below, which have no place for it");
  }
  told += "# Fitted range of loads, outside of which nothing is known:\n";
  for (const std::string& range : calibration.ranges) told += "#   " + range + '\n';
  Document changed = document;
  changed.apply(settings.all());
  return told + '\n' + text_of(changed, "rod");
}

}  // namespace tendril::app
