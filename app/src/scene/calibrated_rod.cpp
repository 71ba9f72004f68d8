#include "scene/calibrated_rod.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <regex>
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
    barred_.push_back({path, owner_, 1.0});
  }
  /// What is set from here on follows this number of the calibration.
  void follow(std::size_t number) { owner_ = number; }
  /// How the keys that were set go together.
  std::string correlations(const Calibration& calibration) const;
  /// Multiplies a key by a factor; false: it is not there.
  bool multiply(const std::string& table, const std::string& key, const Dimension& dimension,
                const CalibratedNumber& factor);
  const std::vector<Override>& all() const { return all_; }

 private:
  const Document& document_;
  const Units& units_;
  std::vector<Override> all_;
  std::size_t owner_ = 0;
  /// A key with an error bar, the number that it follows, and whether it grows or falls with that.
  struct Barred {
    std::string path;
    std::size_t number;
    double sign;
  };
  std::vector<Barred> barred_;
};

/// "rod.segment.0.density" as results name it, "rod.segment[0].density".
std::string named(const std::string& path) {
  static const std::regex index(R"(\.([0-9]+)(?=\.|$))");
  return std::regex_replace(path, index, "[$1]");
}

std::string Settings::correlations(const Calibration& calibration) const {
  constexpr double least = 1e-3;
  std::string out;
  for (std::size_t i = 0; i < barred_.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const auto a = static_cast<Eigen::Index>(barred_[i].number);
      const auto b = static_cast<Eigen::Index>(barred_[k].number);
      const Eigen::MatrixXd& c = calibration.covariance;
      const double value = barred_[i].sign * barred_[k].sign * c(a, b) / std::sqrt(c(a, a) * c(b, b));
      if (!(std::abs(value) >= least)) continue;
      out += fmt::format("\n[[correlation]]\nbetween = [\"{}\", \"{}\"]\nvalue = {:.6f}\n", named(barred_[k].path),
                         named(barred_[i].path), value);
    }
  }
  return out;
}

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

bool Settings::multiply(const std::string& table, const std::string& key, const Dimension& dimension,
                        const CalibratedNumber& factor) {
  const auto value = number(at(table), key, dimension);
  if (!value) return false;
  set(table + '.' + key, *value * factor.value, std::abs(*value) * factor.error, dimension.unit);
  if (*value < 0.0) barred_.back().sign = -1.0;
  return true;
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
    case CalibrationUnknown::axial_stiffness:
    case CalibrationUnknown::modulus: {
      const bool bends = spec.kind != CalibrationUnknown::axial_stiffness;
      const bool axial = spec.kind != CalibrationUnknown::stiffness;
      // A modulus is both: it may follow one of them alone only where the rod does not stretch.
      const bool fixed_length =
          settings.number(settings.at("coordinates"), "stretch_order", dimension::none).value_or(0.0) == 0.0;
      const bool both = axial == bends || (bends && fixed_length);
      for (const std::string& table : tables) {
        bool found = both && settings.multiply(table, "youngs_modulus", dimension::pressure, number);
        if (bends) found = settings.multiply(table, "bending_stiffness", dimension::stiffness, number) || found;
        if (axial) found = settings.multiply(table, "axial_stiffness", dimension::force, number) || found;
        whole = whole && found;
      }
      return whole;
    }
    case CalibrationUnknown::density:
      for (const std::string& table : tables) {
        const bool of_line = settings.multiply(table, "linear_density", dimension::linear_density, number);
        whole = whole && (settings.multiply(table, "density", dimension::density, number) || of_line);
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
    case CalibrationUnknown::force:
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
  for (std::size_t i = 0; i < calibration.numbers.size(); ++i) {
    const CalibratedNumber& number = calibration.numbers[i];
    settings.follow(i);
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
  return told + '\n' + text_of(changed, "rod") + settings.correlations(calibration);
}

}  // namespace tendril::app
