#include "scene/error_bars.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "scene/common_units.hpp"
#include "system/delimited_text.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/scene_reader.hpp"

namespace tendril::app {

namespace {

/// Of the value: how far apart a key is read to differentiate by it.
constexpr double reading_step = 0.01;
/// A number that moves by less than this share of itself, per share of the key, does not go with it.
constexpr double moves_at_all = 1e-9;

constexpr std::array<Dimension, 24> dimensions{dimension::length,
                                               dimension::angle,
                                               dimension::curvature,
                                               dimension::force,
                                               dimension::moment,
                                               dimension::stiffness,
                                               dimension::pressure,
                                               dimension::acceleration,
                                               dimension::linear_density,
                                               dimension::density,
                                               dimension::force_per_length,
                                               dimension::mass,
                                               dimension::moment_per_pressure,
                                               dimension::force_per_pressure,
                                               Dimension{0, 0, "N m/Pa^2"},
                                               Dimension{0, 0, "N m/Pa^3"},
                                               Dimension{0, 0, "N m/Pa^4"},
                                               Dimension{0, 0, "N m/Pa^5"},
                                               Dimension{0, 0, "N/Pa^2"},
                                               Dimension{0, 0, "N/Pa^3"},
                                               Dimension{0, 0, "N/Pa^4"},
                                               Dimension{0, 0, "N/Pa^5"},
                                               dimension::time,
                                               dimension::none};

/// Calls `visit` with the path of every value that is neither a table nor a list.
void each_value(const Node& node, const std::string& path,
                const std::function<void(const std::string&, const Node&)>& visit) {
  if (const auto* list = std::get_if<Node::List>(&node.value)) {
    for (std::size_t i = 0; i < list->size(); ++i) each_value((*list)[i], fmt::format("{}[{}]", path, i), visit);
  } else if (const auto* table = std::get_if<Node::Table>(&node.value)) {
    for (const Node::Entry& entry : *table) {
      each_value(entry.node, path.empty() ? entry.key : path + '.' + entry.key, visit);
    }
  } else {
    visit(path, node);
  }
}

const Node* node_at(const Document& document, const std::string& key) {
  const Node* found = nullptr;
  each_value(document.root(), "", [&](const std::string& path, const Node& node) {
    if (path == key) found = &node;
  });
  return found;
}

/// A number of the document in SI.
struct Written {
  double value = 0.0;
  Dimension dimension{};
};

/// What stands behind the number of "8 mm +- 0.2 mm", but its error bar.
std::string_view unit_of(std::string_view text) {
  if (const auto parts = split_error_bar(text)) text = parts->first;
  double value = 0.0;
  const char* begin = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
  return trimmed_text(text.substr(static_cast<std::size_t>(begin - text.data())));
}

/// Nothing where it is no number.
std::optional<Written> read_number(const Node& node) {
  if (const auto* integer = std::get_if<std::int64_t>(&node.value)) return Written{static_cast<double>(*integer)};
  if (const auto* real = std::get_if<double>(&node.value)) return Written{*real};
  const auto* text = std::get_if<std::string>(&node.value);
  if (text == nullptr) return std::nullopt;
  const Units units;
  // The usual units first: the others are in a database that takes longer to read than a pose to plan.
  std::array<Dimension, dimensions.size()> ordered = dimensions;
  const std::string_view unit = unit_of(*text);
  std::stable_partition(ordered.begin(), ordered.end(), [&](const Dimension& dimension) {
    return std::any_of(common_units.begin(), common_units.end(), [&](const CommonUnit& usual) {
      return usual.unit == unit && usual.dimension == dimension.unit;
    });
  });
  for (const Dimension& dimension : ordered) {
    try {
      return Written{units.read(*text, dimension), dimension};
    } catch (const QuantityError&) {
      continue;
    }
  }
  return std::nullopt;
}

/// By key: a scene that a step of a trajectory was made of has numbers that its document has not.
std::map<std::string, double> numbers_at(const Document& document, const std::string& key, const std::string& text) {
  Document changed = document;
  changed.apply({{key, key, text}});
  std::map<std::string, double> values;
  for (const SceneNumber& n : scene_numbers(read_scene(changed, std::make_shared<Units>()))) values[n.key] = n.value;
  return values;
}

/// Of a key that is no number of the scene itself.
std::vector<Spread::Part> parts_of(const Document& document, const std::vector<SceneNumber>& numbers,
                                   const std::string& key, const Written& written) {
  const double step = written.value != 0.0 ? reading_step * std::abs(written.value) : reading_step;
  const auto at = [&](int steps) {
    const double value = written.value + steps * step;
    const std::string unit(written.dimension.unit);
    return numbers_at(document, key, fmt::format("{:.17g}{}{}", value, unit.empty() ? "" : " ", unit));
  };
  std::map<std::string, double> far_before = at(-2), before = at(-1), behind = at(1), far_behind = at(2);
  std::vector<Spread::Part> parts;
  for (const SceneNumber& n : numbers) {
    if (!before.contains(n.key)) continue;
    const double rate =
        (8.0 * (behind[n.key] - before[n.key]) - (far_behind[n.key] - far_before[n.key])) / (12.0 * step);
    const double scale = std::abs(n.value) / std::max(std::abs(written.value), step);
    if (std::abs(rate) > moves_at_all * scale) parts.push_back({n.key, rate});
  }
  return parts;
}

/// Nothing for a key of no law.
std::optional<Spread::Law> law_of(const std::string& key) {
  constexpr std::string_view table = "rod.actuator[";
  const auto end = key.find("].");
  if (!key.starts_with(table) || end == std::string::npos) return std::nullopt;
  const std::string name = key.substr(end + 2);
  const bool of_law = name.starts_with("moment_per_");
  if (!of_law && !name.starts_with("offset")) return std::nullopt;
  const auto bracket = name.find('[');
  const int coefficient = bracket == std::string::npos ? 0 : std::stoi(name.substr(bracket + 1));
  // One of several offsets is no number by which a moment goes.
  const int power = of_law ? 1 + coefficient : name == "offset" ? 0 : -1;
  return Spread::Law{std::stoul(key.substr(table.size(), end - table.size())), power};
}

double deviation_of(const Document& document, const Node& node, std::string_view bar, const Written& written) {
  const std::string text(bar);
  const auto refuse = [&](const std::string& why) {
    document.fail(node.position, "found " + describe_value(node) + ", " + why +
                                     ", expected an error bar such as \"4.9e-4 N m^2 +- 5 %\" or \"8 mm +- 0.2 mm\"");
  };
  const auto percent = text.find('%');
  double deviation = 0.0;
  try {
    const Units units;
    if (percent != std::string::npos) {
      if (text.find_first_not_of(" \t", percent + 1) != std::string::npos) refuse("which goes on behind the %");
      deviation = 0.01 * units.read(text.substr(0, percent), dimension::none) * std::abs(written.value);
      if (written.value == 0.0) refuse("a share of nothing");
    } else {
      deviation = units.read(text, written.dimension);
    }
  } catch (const QuantityError& error) {
    refuse("with an error bar " + error.why());
  }
  if (!(deviation >= 0.0)) refuse("whose error bar is negative");
  return deviation;
}

/// Correlations that the document states, of numbers with error bars.
void read_correlations(const Document& document, std::vector<Spread>& spreads) {
  const Node* list = document.root().find("correlation");
  if (list == nullptr) return;
  for (const Node& entry : std::get<Node::List>(list->value)) {
    const Node* between = entry.find("between");
    std::vector<std::string> keys;
    for (const Node& key : between != nullptr ? std::get<Node::List>(between->value) : Node::List{}) {
      keys.push_back(std::get<std::string>(key.value));
      if (node_at(document, keys.back()) == nullptr) {
        document.fail(key.position, "found " + describe_value(key) + ", expected the key of a number" +
                                        did_you_mean(keys.back(), number_keys(document)));
      }
    }
    if (keys.size() != 2 || keys[0] == keys[1]) {
      document.fail(entry.position, "found a correlation of other than two numbers, expected 'between' with two keys");
    }
    const Node& value = *entry.find("value");
    const double correlation = read_number(value)->value;
    if (std::abs(correlation) > 1.0) {
      document.fail(value.position, "found " + describe_value(value) + ", expected a correlation from -1 to 1");
    }
    const auto spread = [&](const std::string& key) {
      return std::find_if(spreads.begin(), spreads.end(), [&](const Spread& s) { return s.key == key; });
    };
    // A number that has no error bar any more goes with nothing.
    const auto one = spread(keys[0]), other = spread(keys[1]);
    if (one == spreads.end() || other == spreads.end()) continue;
    one->correlations[other->key] = other->correlations[one->key] = correlation;
  }
  if (spreads.empty()) return;
  const auto count = static_cast<Eigen::Index>(spreads.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Identity(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& known = spreads[static_cast<std::size_t>(i)].correlations;
      const auto found = known.find(spreads[static_cast<std::size_t>(k)].key);
      if (found != known.end()) all(i, k) = found->second;
    }
  }
  constexpr double rounding = 1e-4;  // of correlations as they are written
  if (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(all, Eigen::EigenvaluesOnly).eigenvalues()[0] < -rounding) {
    document.fail(list->position, "found correlations that no numbers have, expected those of one distribution");
  }
}

}  // namespace

std::vector<std::string> number_keys(const Document& document) {
  std::vector<std::string> keys;
  each_value(document.root(), "", [&](const std::string& path, const Node& node) {
    for (const char* table : {"gravity", "rod", "tip_load", "obstacle", "contact", "target", "objective"}) {
      if (path.starts_with(table) && read_number(node)) {
        keys.push_back(path);
        return;
      }
    }
  });
  return keys;
}

Spread spread_of(const Document& document, const Scene& scene, const std::string& key) {
  const std::vector<SceneNumber> numbers = scene_numbers(scene);
  const Node* node = node_at(document, key);
  std::string own = key;
  // The numbers of a rod with one segment are the rod's.
  const std::string only = "rod.segment[0].";
  if (scene.rod.segments.size() == 1 && own.starts_with(only)) own = "rod." + own.substr(only.size());
  const auto same = std::find_if(numbers.begin(), numbers.end(), [&](const SceneNumber& n) { return n.key == own; });
  // A property that changes along the rod has its first coefficient's name, and may be more than that.
  const auto more = std::find_if(numbers.begin(), numbers.end(), [&](const SceneNumber& n) {
    return n.key.starts_with("rod.") && n.key.find(".more_") != std::string::npos;
  });
  if (same != numbers.end() && more == numbers.end()) return {key, 0.0, {{own, 1.0}}};
  // Rods that stretch are not differentiated at all, and others do not read it.
  if (key.ends_with(".axial_stiffness") || key.find(".force_per_pressure") != std::string::npos) return {key};
  if (node == nullptr) {
    std::vector<std::string> known = number_keys(document);
    throw InputError("the scene has no number '" + key + "'" + did_you_mean(key, known));
  }
  const std::optional<Written> written = read_number(*node);
  if (!written) document.fail(node->position, "found " + describe_value(*node) + ", expected a number");
  Spread spread{key, 0.0, parts_of(document, numbers, key, *written), law_of(key)};
  if (spread.parts.empty() && !spread.law) {
    document.fail(node->position, "by '" + key +
                                      "' nothing is differentiated, expected a number of the rod, its "
                                      "loads, an obstacle, a limit, the target or an objective");
  }
  return spread;
}

void follow_held_inputs(const Scene& scene, const std::vector<double>& moments, Spread& spread) {
  if (!spread.law || spread.law->actuator >= moments.size()) return;
  const std::size_t i = spread.law->actuator;
  const auto gain = scene.rod.actuators[i].gain_of(spread.law->power, moments[i]);
  // By its own key nothing is differentiated.
  spread.parts.push_back(gain ? Spread::Part{fmt::format("moments[{}]", i), gain->rate} : Spread::Part{spread.key});
}

std::vector<Spread> error_bars(const Document& document, const Scene& scene) {
  std::vector<Spread> spreads;
  each_value(document.root(), "", [&](const std::string& path, const Node& node) {
    const auto* text = std::get_if<std::string>(&node.value);
    if (text == nullptr || path == "title") return;
    const auto parts = split_error_bar(*text);
    const std::optional<Written> written = parts ? read_number(node) : std::nullopt;
    if (!written) return;  // text that is no number is told by who reads it
    const double deviation = deviation_of(document, node, parts->second, *written);
    if (deviation == 0.0) return;
    Spread spread = spread_of(document, scene, path);
    spread.deviation = deviation;
    spreads.push_back(std::move(spread));
  });
  read_correlations(document, spreads);
  return spreads;
}

std::string written_value(const Document& document, const std::string& key) {
  const Node* node = node_at(document, key);
  if (node == nullptr) return "";
  if (const auto* text = std::get_if<std::string>(&node->value)) return *text;
  if (const auto* integer = std::get_if<std::int64_t>(&node->value)) return fmt::format("{}", *integer);
  if (const auto* real = std::get_if<double>(&node->value)) return fmt::format("{:.12g}", *real);
  return "";
}

}  // namespace tendril::app
