#include "scene/calibrated_rod.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>
#include <utility>
#include <vector>

#include "scene/actuator_reader.hpp"

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
  /// The coefficients of a law, those of `numbers` in their order.
  void set_law(const std::string& path, const std::vector<std::pair<std::size_t, const CalibratedNumber*>>& numbers);
  /// A key that goes with what is set no more.
  void drop(const std::string& path) { dropped_.push_back(path); }
  /// What is set from here on follows this number of the calibration.
  void follow(std::size_t number) { owner_ = number; }
  /// How the keys that were set go together.
  std::string correlations(const Calibration& calibration) const;
  /// Multiplies a key by a factor; false: it is not there.
  bool multiply(const std::string& table, const std::string& key, const Dimension& dimension,
                const CalibratedNumber& factor);
  /// The document with all of it.
  Document applied() const;

 private:
  const Document& document_;
  const Units& units_;
  std::vector<Override> all_;
  std::vector<std::string> dropped_;
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

void Settings::set_law(const std::string& path,
                       const std::vector<std::pair<std::size_t, const CalibratedNumber*>>& numbers) {
  if (numbers.size() == 1) {
    set(path, numbers.front().second->value, numbers.front().second->error, numbers.front().second->unit);
    return;
  }
  std::string list;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const CalibratedNumber& n = *numbers[i].second;
    list += fmt::format("{}\"{:.12g} {} +- {:.4g} {}\"", i == 0 ? "" : ", ", n.value, n.unit, n.error, n.unit);
    barred_.push_back({path + '.' + std::to_string(i), numbers[i].first, 1.0});
  }
  set(path, '[' + list + ']');
}

Document Settings::applied() const {
  Document changed = document_;
  for (const std::string& path : dropped_) changed.erase(path);
  changed.apply(all_);
  return changed;
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
    case CalibrationUnknown::base_angle:
      if (spec.per == CalibrationScope::all)
        settings.set("rod.base.angle", number.value, number.error, dimension::angle.unit);
      return spec.per == CalibrationScope::all;
    case CalibrationUnknown::moment:
    case CalibrationUnknown::force:
    case CalibrationUnknown::base_x:
    case CalibrationUnknown::base_y:
      break;
  }
  return false;
}

using Numbers = std::vector<std::pair<std::size_t, const CalibratedNumber*>>;

/// What was found of a law, powers ascending; empty: it was not looked for. Nothing where it is not known.
std::optional<Numbers> law_of(const Calibration& calibration, CalibrationUnknown kind, std::size_t actuator) {
  Numbers out;
  for (std::size_t i = 0; i < calibration.numbers.size(); ++i) {
    const CalibratedNumber& n = calibration.numbers[i];
    if (n.spec.kind != kind || n.spec.actuator != static_cast<int>(actuator) + 1) continue;
    if (!n.identifiable) return std::nullopt;
    out.emplace_back(i, &n);
  }
  return out;
}

/// Whether a law of the pressure, or the tension, rises, or falls, all the way between two of them: only then a moment
/// tells one.
bool tells_pressure(const Numbers& law, double low, double high) {
  constexpr int samples = 200;
  int rises = 0;
  int falls = 0;
  for (int i = 0; i <= samples; ++i) {
    const double pressure = low + i * (high - low) / samples;
    double slope = 0.0;
    for (std::size_t k = law.size(); k-- > 0;) {
      slope = slope * pressure + static_cast<double>(k + 1) * law[k].second->value;
    }
    rises += slope > 0.0 ? 1 : 0;
    falls += slope < 0.0 ? 1 : 0;
  }
  return rises == 0 || falls == 0;
}

/// Puts an actuator's laws where [rod] has them, and from where to where they were fitted; which numbers have their
/// place then.
std::vector<std::size_t> put_actuator(Settings& settings, const Calibration& calibration, std::size_t index) {
  const std::string path = "rod.actuator." + std::to_string(index);
  const Node* table = settings.at(path);
  if (table == nullptr || index >= calibration.inputs.size()) return {};
  const CalibratedInput& told = calibration.inputs[index];
  const auto range = [&](double low, double high, const Dimension& dimension) {
    settings.set(path + ".calibrated",
                 fmt::format("[\"{:.12g} {}\", \"{:.12g} {}\"]", low, dimension.unit, high, dimension.unit));
  };
  const std::optional<Numbers> found_moment = law_of(calibration, CalibrationUnknown::moment, index);
  const std::optional<Numbers> found_force = law_of(calibration, CalibrationUnknown::force, index);
  if (!found_moment || !found_force) return {};
  const Numbers& moment = *found_moment;
  const Numbers& force = *found_force;
  const auto says = [&](const char* key, std::string_view word) {
    const Node* node = table->find(key);
    return node != nullptr && std::get<std::string>(node->value) == word;
  };
  const bool tendon = told.kind == ActuatorKind::tendon && says("kind", to_string(told.kind)) && !moment.empty();
  const bool by_length = says("control", "length");
  if (told.kind != ActuatorKind::pressure && !tendon) {
    // A range stands in what the scene's actuator is told, which the recordings may not say.
    const bool same =
        says("kind", to_string(told.kind)) || (told.kind == ActuatorKind::moment && table->find("kind") == nullptr);
    if (same && !by_length && moment.empty() && force.empty())
      range(told.least, told.largest, ActuatorSpec{.kind = told.kind}.input_dimension());
    return {};
  }
  // Of a law the pressures or tensions that it was fitted to, from none on.
  const double low = std::min(told.least, 0.0);
  const double high = std::max(told.largest, 0.0);
  const auto is_law = [&](const char* key) {
    const Node* node = table->find(key);
    return node != nullptr && std::holds_alternative<Node::List>(node->value);
  };
  const bool known = !moment.empty() || table->find("moment_per_pressure") != nullptr;
  if (!known || std::max(moment.size(), force.size()) > most_coefficients || !tells_pressure(moment, low, high))
    return {};
  std::vector<std::size_t> placed;
  const auto put_law = [&](const char* key, const Numbers& law) {
    if (law.empty()) return;
    settings.follow(law.front().first);
    settings.set_law(path + key, law);
    for (const auto& [number, of] : law) placed.push_back(number);
  };
  if (tendon) {
    put_law(".moment_per_tension", moment);
    if (moment.size() > 1 && by_length) settings.set(path + ".max_tension", fmt::format("{:.12g} N", high));
    if (moment.size() > 1 && !by_length) {
      settings.drop(path + ".limit");
      settings.set(path + ".min", fmt::format("{:.12g} N", low));
      settings.set(path + ".max", fmt::format("{:.12g} N", high));
    }
    if (!by_length) range(told.least, told.largest, dimension::force);
    return placed;
  }
  put_law(".moment_per_pressure", moment);
  put_law(".force_per_pressure", force);
  if (moment.size() > 1 || force.size() > 1 || is_law("moment_per_pressure") || is_law("force_per_pressure")) {
    for (const char* key : {".limit", ".min_pressure", ".max_pressure"}) settings.drop(path + key);
    settings.set(path + ".min", fmt::format("{:.12g} Pa", low));
    settings.set(path + ".max", fmt::format("{:.12g} Pa", high));
  } else if (!says("kind", to_string(ActuatorKind::pressure))) {
    return placed;  // its limits are moments; the range stands above
  }
  settings.set(path + ".kind", std::string(to_string(ActuatorKind::pressure)));
  range(told.least, told.largest, dimension::pressure);
  return placed;
}

/// From where to where the loads of the recordings were.
void put_loads(Settings& settings, const CalibratedLoads& loads) {
  const auto put = [&](const std::string& path, const LoadRange& range, std::string_view unit) {
    const auto point = [&](Vec2 v) {
      return fmt::format("[\"{:.12g} {}\", \"{:.12g} {}\"]", v.x + 0.0, unit, v.y + 0.0, unit);
    };
    settings.set(path, '[' + point(range.first) + ", " + point(range.second) + ']');
  };
  put("rod.calibrated_gravity", loads.gravity, dimension::acceleration.unit);
  put("rod.calibrated_tip_force", loads.tip_force, dimension::force.unit);
  for (std::size_t i = 0; i < loads.along.size(); ++i) {
    const std::string path = "rod.load." + std::to_string(i);
    const bool spread = settings.at(path)->find("force_per_length") != nullptr;
    put(path + ".calibrated", loads.along[i], spread ? dimension::force_per_length.unit : dimension::force.unit);
  }
}

}  // namespace

std::string calibrated_rod(const Document& document, const Units& units, const Calibration& calibration) {
  std::string told = "# Calibrated; standard deviations behind +-.\n";
  Settings settings(document, units);
  std::vector<bool> done(calibration.numbers.size(), false);
  for (std::size_t i = 0; i < done.size(); ++i) {
    settings.follow(i);
    done[i] = calibration.numbers[i].identifiable && put(settings, calibration.numbers[i]);
  }
  for (std::size_t a = 0; a < calibration.inputs.size(); ++a) {
    for (const std::size_t i : put_actuator(settings, calibration, a)) done[i] = true;
  }
  put_loads(settings, calibration.loads);
  for (std::size_t i = 0; i < done.size(); ++i) {
    const CalibratedNumber& number = calibration.numbers[i];
    told += number.identifiable ? fmt::format("# {} = {:.8g} +- {:.2g}{}{}{}\n", number.name, number.value,
                                              number.error, number.unit.empty() ? "" : " ", number.unit,
                                              done[i] ? "" : ": not among the keys below, which have no place for it")
                                : fmt::format("# {}: not identifiable\n", number.name);
  }
  told += "# Fitted range of loads, outside of which nothing is known:\n";
  for (const std::string& range : calibration.ranges) told += "#   " + range + '\n';
  return told + '\n' + text_of(settings.applied(), "rod") + settings.correlations(calibration);
}

}  // namespace tendril::app
