#include "live/controls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "tendril/app/input_error.hpp"
#include "tendril/app/scene_reader.hpp"

namespace tendril::app {

namespace {

/// Tables whose keys a page may change. What stands in others is read from files, or is no number.
constexpr const char* offered[] = {"rod",       "tip_load", "coordinates", "obstacle", "contact", "target",
                                   "objective", "solver",   "search",      "gripper",  "finger"};

/// A number as a scene writes it.
struct Written {
  double value = 0.0;
  std::string unit;
};

std::optional<Written> written(const Node& node) {
  if (const auto* integer = std::get_if<std::int64_t>(&node.value)) return Written{static_cast<double>(*integer), ""};
  if (const auto* real = std::get_if<double>(&node.value)) return Written{*real, ""};
  const auto* text = std::get_if<std::string>(&node.value);
  if (text == nullptr) return std::nullopt;
  Written number;
  const auto [rest, code] = std::from_chars(text->data(), text->data() + text->size(), number.value);
  if (code != std::errc{}) return std::nullopt;
  number.unit.assign(rest, text->data() + text->size());
  number.unit.erase(0, number.unit.find_first_not_of(' '));
  return number;
}

/// Collects controls from a scene's document and what is known of its keys.
class Offer {
 public:
  explicit Offer(Session& session) : session_(session) {}

  std::vector<Control> controls() {
    const Document& document = session_.document();
    for (const KeySpec& spec : scene_keys()) {
      if (spec.name == "gravity") add(spec, "gravity", document.root().find("gravity"));
      if (std::find(std::begin(offered), std::end(offered), spec.name) == std::end(offered)) continue;
      // Menus of what is planned with are there whether or not the scene says anything.
      const Node* node = document.root().find(spec.name);
      const Node empty{Node::Table{}, {}};
      const bool always = spec.name == "coordinates" || spec.name == "solver" || spec.name == "contact";
      if (node != nullptr || always) add_table(spec, spec.name, node != nullptr ? *node : empty);
    }
    if (session_.scene().problem != ProblemKind::grasp && find("rod.base.position") == nullptr) {
      const Vec2 base = session_.scene().rod.base_position;
      const auto unit = session_.scene().units.find("m");
      Control control{"rod.base.position", Control::Kind::points, "m"};
      if (unit != session_.scene().units.end()) {
        control.unit = unit->second.name;
        control.size = unit->second.size;
      }
      control.value = Json::array({Json::array({base.x / control.size, base.y / control.size})});
      control.one_point = true;
      control.moves = "base";
      controls_.push_back(std::move(control));
    }
    return std::move(controls_);
  }

 private:
  /// Plans of poses look at friction, one or many.
  bool may_rub() const {
    const ProblemKind problem = session_.scene().problem;
    return (problem == ProblemKind::pose || problem == ProblemKind::trajectory) && !session_.scene().obstacles.empty();
  }

  const Control* find(const std::string& key) const {
    const auto found = std::find_if(controls_.begin(), controls_.end(), [&](const Control& c) { return c.key == key; });
    return found != controls_.end() ? &*found : nullptr;
  }

  void add_table(const KeySpec& spec, const std::string& path, const Node& node) {
    if (const auto* list = std::get_if<Node::List>(&node.value)) {
      for (std::size_t i = 0; i < list->size(); ++i) add_table(spec, fmt::format("{}.{}", path, i), (*list)[i]);
      return;
    }
    if (!node.is_table()) return;
    for (const KeySpec& key : spec.keys) {
      table_ = node.position.line;
      const std::string inner = path + '.' + key.name;
      const Node* value = node.find(key.name);
      if (inner == "coordinates.plugin") {
        add_menu(inner, session_.scene().coordinates.plugin, ComponentKind::coordinates);
      } else if (inner == "solver.plugin") {
        add_menu(inner, session_.scene().solver.plugin, ComponentKind::solver);
      } else if (inner == "contact.mode") {
        add_choice(inner, std::string(to_string(session_.scene().contact.mode)), key.choices);
      } else if (value != nullptr && (key.type == KeyType::table || key.type == KeyType::tables)) {
        add_table(key, inner, *value);
      } else if (value != nullptr) {
        add(key, inner, value);
      } else if (inner == "contact.friction" && may_rub()) {
        Control control{inner};
        control.value = 0.0;
        control.minimum = 0.0;
        controls_.push_back(std::move(control));
      }
    }
    table_ = node.position.line;
    if (spec.takes_options) add_options(spec.name, path, node);
  }

  /// Options of a component, by its own schema.
  void add_options(const std::string& table, const std::string& path, const Node& node) {
    for (const OptionSpec& option : schema_of(table, node)) {
      const Node* value = node.find(option.name);
      if (value == nullptr) continue;
      KeySpec spec{option.name, KeyType::text, option.dimension};
      spec.minimum = option.minimum;
      spec.choices = option.choices;
      const bool in_plane = option.dimension.unit == dimension::length.unit;
      if (option.type == OptionType::real) spec.type = KeyType::quantity;
      if (option.type == OptionType::integer) spec.type = KeyType::integer;
      if (option.type == OptionType::boolean) spec.type = KeyType::boolean;
      if (option.type == OptionType::list && option.size == 2 && in_plane) spec.type = KeyType::point;
      if (option.type == OptionType::points && in_plane) spec.type = KeyType::points;
      add(spec, path + '.' + option.name, value);
    }
  }

  OptionSchema schema_of(const std::string& table, const Node& node) {
    const Node* name = node.find(table == "obstacle" ? "shape" : "plugin");
    const auto* text = name != nullptr ? std::get_if<std::string>(&name->value) : nullptr;
    plugins::Registry& registry = session_.registry();
    if (table == "coordinates") return registry.coordinates(session_.scene().coordinates.plugin).options;
    if (text == nullptr) return {};
    if (table == "obstacle") return registry.obstacle(*text).options;
    if (table == "objective") return registry.objective(*text).options;
    return {};
  }

  void add_menu(const std::string& key, const std::string& value, ComponentKind kind) {
    add_choice(key, value, session_.registry().names(kind));
  }
  void add_choice(const std::string& key, const std::string& value, const std::vector<std::string>& choices) {
    Control control{key, Control::Kind::choice};
    control.value = value;
    control.choices = choices;
    controls_.push_back(std::move(control));
  }

  void add(const KeySpec& spec, const std::string& path, const Node* node) {
    if (node == nullptr) return;
    Control control{path};
    control.line = node->position.line;
    control.table = table_;
    control.minimum = spec.minimum;
    if (spec.type == KeyType::quantity || spec.type == KeyType::integer) {
      const auto number = written(*node);
      if (!number || !read_unit(control, number->unit, spec.dimension)) return;
      control.kind = spec.type == KeyType::integer ? Control::Kind::whole : Control::Kind::number;
      control.value = number->value;
    } else if (spec.type == KeyType::boolean && std::holds_alternative<bool>(node->value)) {
      control.kind = Control::Kind::flag;
      control.value = std::get<bool>(node->value);
    } else if (spec.type == KeyType::text && !spec.choices.empty() &&
               std::holds_alternative<std::string>(node->value)) {
      return add_choice(path, std::get<std::string>(node->value), spec.choices);
    } else if (spec.type == KeyType::point || spec.type == KeyType::points) {
      control.kind = Control::Kind::points;
      control.one_point = spec.type == KeyType::point;
      if (!read_points(control, *node, spec.dimension)) return;
      if (spec.dimension.unit == dimension::length.unit) control.moves = moved_by(path);
    } else {
      return;
    }
    controls_.push_back(std::move(control));
  }

  /// Whether the unit can be read alone; numbers with error bars cannot, and stay as they are.
  bool read_unit(Control& control, const std::string& unit, const Dimension& dimension) const {
    control.unit = unit;
    if (unit.empty()) {
      control.unit = dimension.unit;
      return true;
    }
    try {
      control.size = session_.units().read("1 " + unit, dimension);
    } catch (const Error&) {
      return false;
    }
    return true;
  }

  /// All numbers in the unit of the first.
  bool read_points(Control& control, const Node& node, const Dimension& dimension) const {
    const auto* list = std::get_if<Node::List>(&node.value);
    if (list == nullptr || list->empty()) return false;
    control.value = Json::array();
    for (std::size_t i = 0; i < (control.one_point ? 1 : list->size()); ++i) {
      const auto* pair = control.one_point ? list : std::get_if<Node::List>(&(*list)[i].value);
      if (pair == nullptr || pair->size() != 2) return false;
      Json point = Json::array();
      for (const Node& entry : *pair) {
        const auto number = written(entry);
        Control own;
        if (!number || !read_unit(own, number->unit, dimension)) return false;
        if (control.value.empty() && point.empty()) {
          control.unit = own.unit;
          control.size = own.size;
        }
        point.push_back(own.unit == control.unit ? number->value : number->value * own.size / control.size);
      }
      control.value.push_back(std::move(point));
    }
    return true;
  }

  static std::string moved_by(const std::string& path) {
    if (path == "target.position") return "target";
    if (path == "rod.base.position") return "base";
    if (!path.starts_with("obstacle.")) return "";
    const std::size_t dot = path.find('.', 9);
    return fmt::format("obstacle {}", std::stoi(path.substr(9, dot - 9)) + 1);
  }

  Session& session_;
  int table_ = 0;  ///< the line of the table that is looked at
  std::vector<Control> controls_;
};

const char* word_of(Control::Kind kind) {
  constexpr const char* words[] = {"number", "whole", "flag", "choice", "points"};
  return words[static_cast<int>(kind)];
}

std::string number_text(const Control& control, const Json& value) {
  if (!value.is_number() || !std::isfinite(value.get<double>()) || std::abs(value.get<double>()) > 1e12) {
    throw InputError(fmt::format("{}: found {}, expected a number", control.key, value.dump().substr(0, 80)));
  }
  if (control.kind == Control::Kind::whole) {
    const double whole = std::round(value.get<double>());
    return fmt::format("{}", static_cast<std::int64_t>(std::clamp(whole, -1e9, 1e9)));
  }
  if (control.unit.empty()) return fmt::format("{:.17g}", value.get<double>());
  return fmt::format("\"{} {}\"", value.get<double>(), control.unit);
}

std::string points_text(const Control& control, const Json& value) {
  constexpr std::size_t most_points = 1000;
  const std::size_t expected = control.value.size();
  if (!value.is_array() || value.size() != expected || value.size() > most_points) {
    throw InputError(fmt::format("{}: expected a list of {} points", control.key, expected));
  }
  std::string text;
  for (const Json& point : value) {
    if (!point.is_array() || point.size() != 2) throw InputError(control.key + ": expected points [x, y]");
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", number_text(control, point[0]),
                        number_text(control, point[1]));
  }
  return control.one_point ? text : '[' + text + ']';
}

Override override_of(const Control& control, const Json& value) {
  Override setting{control.key, control.key, "", false};
  switch (control.kind) {
    case Control::Kind::number:
    case Control::Kind::whole:
      setting.text = number_text(control, value);
      break;
    case Control::Kind::points:
      setting.text = points_text(control, value);
      break;
    case Control::Kind::flag:
      if (!value.is_boolean()) throw InputError(control.key + ": expected true or false");
      setting.text = value.get<bool>() ? "true" : "false";
      break;
    case Control::Kind::choice:
      if (!value.is_string() || std::find(control.choices.begin(), control.choices.end(), value.get<std::string>()) ==
                                    control.choices.end()) {
        throw InputError(fmt::format("{}: found {}, expected one of the words offered", control.key,
                                     value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 80)));
      }
      setting.text = value.get<std::string>();
      setting.literal = true;
      break;
  }
  return setting;
}

}  // namespace

std::vector<Control> controls_of(Session& session) { return Offer(session).controls(); }

Json controls_json(const std::vector<Control>& controls) {
  Json array = Json::array();
  for (const Control& control : controls) {
    array.push_back({{"key", control.key},
                     {"kind", word_of(control.kind)},
                     {"unit", control.unit},
                     {"size", control.size},
                     {"value", control.value},
                     {"minimum", number(control.minimum / control.size)},
                     {"choices", control.choices},
                     {"moves", control.moves}});
  }
  return array;
}

std::vector<Override> overrides_of(const std::vector<Control>& controls, const Json& settings) {
  if (!settings.is_object()) throw InputError("settings: expected an object");
  std::vector<Override> overrides;
  std::size_t known = 0;
  for (const Control& control : controls) {
    const auto value = settings.find(control.key);
    if (value == settings.end()) continue;
    ++known;
    overrides.push_back(override_of(control, *value));
  }
  if (known == settings.size()) return overrides;
  for (const auto& [key, value] : settings.items()) {
    if (std::none_of(controls.begin(), controls.end(), [&, &name = key](const Control& c) { return c.key == name; })) {
      throw InputError("found the key '" + key.substr(0, 80) + "', which the page does not offer");
    }
  }
  return overrides;
}

}  // namespace tendril::app
