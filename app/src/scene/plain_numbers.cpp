#include "scene/plain_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tendril/app/scene_reader.hpp"

namespace tendril::app {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;
constexpr double most_angle = 1.5 * turn;
constexpr double most_rods = 10.0;
constexpr double longest_rod = 10.0;   // m
constexpr double most_moment = 100.0;  // EI/L: by so many radians it bends the rod

constexpr double softest = 100.0;  // Pa
constexpr double lightest = 5.0;   // kg/m^3

class Doubts {
 public:
  Doubts(const Document& document, const Scene& scene) : document_(document) {
    const auto measure = [&](const RodSpec& rod) {
      length_ = std::max(length_, rod.length());
      reach_ = std::max(reach_, rod.length() + norm(rod.base_position));
      for (const SegmentSpec& segment : rod.segments) stiffness_ = std::max(stiffness_, segment.bending_stiffness);
      for (const ActuatorSpec& a : rod.actuators) told_moments_ = told_moments_ && a.kind == ActuatorKind::moment;
    };
    measure(scene.rod);
    for (const FingerSpec& finger : scene.fingers) measure(finger.rod);
  }

  void ask_table(const Node& node, const std::vector<KeySpec>& keys) {
    if (const auto* list = std::get_if<Node::List>(&node.value)) {
      for (const Node& item : *list) ask_table(item, keys);
    }
    for (const KeySpec& key : keys) {
      const Node* value = node.find(key.name);
      // Measured points may be in pixels, and an estimate itself asks about those that cannot be.
      if (value == nullptr || key.name == "measurement") continue;
      if (key.keys.empty()) {
        ask(*value, key.name, key.dimension);
      } else {
        ask_table(*value, key.keys);
      }
    }
  }

  /// About the first number of a value that is doubtful; whether there was one.
  bool ask(const Node& node, const std::string& key, const Dimension& dimension) {
    if (const auto* list = std::get_if<Node::List>(&node.value)) {
      return std::any_of(list->begin(), list->end(), [&](const Node& item) { return ask(item, key, dimension); });
    }
    if (const auto* table = std::get_if<Node::Table>(&node.value)) {
      return std::any_of(table->begin(), table->end(),
                         [&](const Node::Entry& entry) { return ask(entry.node, key, dimension); });
    }
    double value = 0.0;
    if (const auto* real = std::get_if<double>(&node.value)) value = *real;
    if (const auto* integer = std::get_if<std::int64_t>(&node.value)) value = static_cast<double>(*integer);
    const std::string question = question_about(value, key, dimension);
    if (question.empty()) return false;
    questions.push_back(document_.describe(node.position) + ": found " + question);
    return true;
  }

  std::vector<std::string> questions;

 private:
  /// Empty: nothing is doubtful.
  std::string question_about(double value, const std::string& key, const Dimension& dimension) const {
    const double size = std::abs(value);
    if (dimension.unit == dimension::angle.unit && size > most_angle) {
      return fmt::format("{} rad, which is more than a turn and a half; did you mean \"{} deg\"?", value, value);
    }
    if (dimension.unit == dimension::length.unit && key == "length" && size > longest_rod) {
      return fmt::format("{} m as a length of a rod; did you mean \"{} mm\"?", value, value);
    }
    if (dimension.unit == dimension::length.unit && key != "length" && size > most_rods * reach_) {
      return fmt::format("{} m, {:.3g} times the length of the rod; did you mean \"{} mm\"?", value, size / length_,
                         value);
    }
    if (key == "youngs_modulus" && size > 0.0 && size < softest) {
      return fmt::format("{} Pa, which is softer than any gel; did you mean \"{} MPa\"?", value, value);
    }
    if (key == "density" && size > 0.0 && size < lightest) {
      return fmt::format("{} kg/m^3, which is lighter than any foam; did you mean \"{} g/cm^3\"?", value, value);
    }
    const double bend = size * length_ / stiffness_;
    if (dimension.unit == dimension::moment.unit && told_moments_ && bend > most_moment) {
      return fmt::format("{} N m, which would bend the rod by {:.3g} turns; did you mean \"{} N mm\"?", value,
                         bend / turn, value);
    }
    return "";
  }

  const Document& document_;
  double length_ = 0.0, reach_ = 0.0;  // m
  double stiffness_ = 0.0;             // N m^2
  bool told_moments_ = true;           // else a plain limit is one of something else
};

}  // namespace

std::vector<std::string> doubtful_numbers(const Document& document, const Scene& scene) {
  Doubts doubts(document, scene);
  doubts.ask_table(document.root(), scene_keys());
  return std::move(doubts.questions);
}

std::vector<std::string> doubtful_numbers(const Document& document, const Scene& scene, const OptionSchema& schema,
                                          const Node& table) {
  Doubts doubts(document, scene);
  for (const OptionSpec& option : schema) {
    if (const Node* value = table.find(option.name)) doubts.ask(*value, option.name, option.dimension);
  }
  return std::move(doubts.questions);
}

}  // namespace tendril::app
