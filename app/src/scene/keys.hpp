#pragma once

// Keys of a scene: each is declared once, with what it is called, what it may hold and where its value goes.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tendril/app/input_error.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/whole_number.hpp"

namespace tendril::app {

using dimension::none;

/// What every key needs while it is being read.
struct Context {
  const Document& document;
  const Units& units;
  std::vector<std::string>& warnings;  ///< of what is read: what the user may not have meant

  [[noreturn]] void fail(const Node& node, const std::string& expected) const {
    document.fail(node.position, "found " + describe_value(node) + ", expected " + expected);
  }
};

/// A key and where its value goes. `read` is made from the same declaration as `spec`, so the two cannot differ.
template <class Target>
struct Key {
  KeySpec spec;
  std::function<void(const Context&, const Node&, Target&)> read;
  bool first = false;  ///< read before the others of its table, which depend on it
};

/// The keys that a table may have.
template <class Target>
struct Table {
  std::vector<Key<Target>> keys;
  std::function<void(Target&, const std::string&, RawValue)> option{};  ///< takes every other key, if given

  std::vector<KeySpec> specs() const {
    std::vector<KeySpec> all;
    for (const Key<Target>& key : keys) all.push_back(key.spec);
    return all;
  }
};

inline std::string quoted_choices(const std::vector<std::string>& choices) {
  std::string text;
  for (const std::string& choice : choices) text += (text.empty() ? "\"" : ", \"") + choice + '"';
  return text;
}

template <class Target>
void read_table(const Context& context, const Node& node, const std::string& name, const Table<Target>& table,
                Target& target) {
  const auto* entries = std::get_if<Node::Table>(&node.value);
  if (entries == nullptr) context.fail(node, "a table [" + name + "]");
  std::vector<std::string> known;
  for (const Key<Target>& key : table.keys) known.push_back(key.spec.name);
  const auto key_of = [&](const std::string& entry) {
    return std::find_if(table.keys.begin(), table.keys.end(), [&](const auto& key) { return key.spec.name == entry; });
  };

  // A misspelt key is often a required one that then seems to be missing: complain about the spelling.
  for (const Node::Entry& entry : *entries) {
    if (key_of(entry.key) == table.keys.end() && !table.option) {
      const std::string where = name.empty() ? "a scene" : "[" + name + "]";
      context.document.fail(entry.position, "found the key '" + entry.key.substr(0, 200) + "', which " + where +
                                                " does not have" + did_you_mean(entry.key, known));
    }
  }
  for (const Key<Target>& key : table.keys) {
    if (key.spec.required && node.find(key.spec.name) == nullptr) {
      const std::string where = name.empty() ? "the scene" : "[" + name + "]";
      context.document.fail(node.position,
                            where + " has no '" + key.spec.name + "', expected " +
                                (key.spec.type == KeyType::quantity ? expected_quantity(key.spec.dimension)
                                 : key.spec.description.empty()     ? "one"
                                                                    : key.spec.description));
    }
  }
  for (const bool first : {true, false}) {
    for (const Node::Entry& entry : *entries) {
      const auto key = key_of(entry.key);
      if (key != table.keys.end()) {
        if (key->first == first) key->read(context, entry.node, target);
      } else if (!first) {
        table.option(target, entry.key, to_raw_value(context.document, entry.node));
      }
    }
  }
}

inline double read_quantity(const Context& context, const Node& node, const KeySpec& spec) {
  double value = 0.0;
  if (const auto* integer = std::get_if<std::int64_t>(&node.value)) {
    value = static_cast<double>(*integer);
  } else if (const auto* real = std::get_if<double>(&node.value)) {
    value = *real;
  } else if (const auto* text = std::get_if<std::string>(&node.value)) {
    try {
      value = context.units.read(*text, spec.dimension);
    } catch (const Error& error) {
      context.document.fail(node.position, error.what());
    }
  } else {
    context.fail(node, expected_quantity(spec.dimension));
  }
  if (!std::isfinite(value)) context.fail(node, expected_quantity(spec.dimension, " that is finite"));
  if (spec.minimum_excluded ? value <= spec.minimum : value < spec.minimum) {
    const std::string restriction =
        fmt::format(" {} {}", spec.minimum_excluded ? "greater than" : "not below", spec.minimum);
    context.fail(node, expected_quantity(spec.dimension, restriction));
  }
  return value;
}

/// Restrictions of a number, and the text of its default.
struct Range {
  double minimum = -std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
};
inline constexpr Range any{};
inline constexpr Range positive{0.0, true};
inline constexpr Range not_negative{0.0, false};

enum class Need { optional, required };

template <class Target, class Set>
Key<Target> quantity(std::string name, const Dimension& dimension, Range range, std::string default_text,
                     std::string description, Set set, Need need = Need::optional) {
  KeySpec spec{std::move(name), KeyType::quantity,      dimension, std::move(default_text), std::move(description),
               range.minimum,   range.minimum_excluded, {},        need == Need::required};
  return {spec, [spec, set](const Context& context, const Node& node, Target& target) {
            set(target, read_quantity(context, node, spec));
          }};
}

template <class Target, class Set>
Key<Target> point(std::string name, const Dimension& dimension, std::string default_text, std::string description,
                  Set set) {
  KeySpec spec{std::move(name), KeyType::point, dimension, std::move(default_text), std::move(description)};
  return {spec, [spec, set](const Context& context, const Node& node, Target& target) {
            const auto* list = std::get_if<Node::List>(&node.value);
            if (list == nullptr || list->size() != 2) {
              context.fail(node, "a list of two entries [x, y], each " + expected_quantity(spec.dimension));
            }
            const double x = read_quantity(context, (*list)[0], spec);
            set(target, Vec2{x, read_quantity(context, (*list)[1], spec)});
          }};
}

template <class Target, class Set>
Key<Target> text(std::string name, std::string default_text, std::string description, Set set,
                 std::vector<std::string> choices = {}, Need need = Need::optional) {
  KeySpec spec{std::move(name), KeyType::text, none, std::move(default_text), std::move(description)};
  spec.choices = std::move(choices);
  spec.required = need == Need::required;
  return {spec, [spec, set](const Context& context, const Node& node, Target& target) {
            const auto* value = std::get_if<std::string>(&node.value);
            if (value == nullptr)
              context.fail(node, spec.choices.empty() ? "text" : "one of " + quoted_choices(spec.choices));
            if (!spec.choices.empty() &&
                std::find(spec.choices.begin(), spec.choices.end(), *value) == spec.choices.end()) {
              const std::string near = nearest_name(*value, spec.choices);
              context.fail(node, "one of " + quoted_choices(spec.choices) +
                                     (near.empty() ? "" : "; did you mean '" + near + "'?"));
            }
            set(target, *value);
          }};
}

template <class Target, class Set>
Key<Target> boolean(std::string name, std::string default_text, std::string description, Set set) {
  KeySpec spec{std::move(name), KeyType::boolean, none, std::move(default_text), std::move(description)};
  return {spec, [set](const Context& context, const Node& node, Target& target) {
            const auto* value = std::get_if<bool>(&node.value);
            if (value == nullptr) context.fail(node, "true or false");
            set(target, *value);
          }};
}

template <class Target, class Set>
Key<Target> integer(std::string name, int minimum, std::string default_text, std::string description, Set set) {
  KeySpec spec{std::move(name),         KeyType::integer,       none,
               std::move(default_text), std::move(description), static_cast<double>(minimum)};
  return {spec, [minimum, set](const Context& context, const Node& node, Target& target) {
            constexpr int maximum = 1'000'000'000;
            std::optional<std::int64_t> value;
            if (const auto* whole = std::get_if<std::int64_t>(&node.value)) value = *whole;
            if (const auto* real = std::get_if<double>(&node.value)) value = whole_number(*real);
            if (!value || *value < minimum || *value > maximum) {
              context.fail(node, fmt::format("a whole number from {} to {}", minimum, maximum));
            }
            set(target, static_cast<int>(*value));
          }};
}

/// The entries of a list, each read by `read`. `what` names one of them in messages.
template <class Read>
auto read_list(const Context& context, const Node& node, const std::string& what, Read read) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr || list->empty()) context.fail(node, "a list of at least one entry, each " + what);
  std::vector<decltype(read(node))> values;
  for (const Node& item : *list) values.push_back(read(item));
  return values;
}

template <class Target, class Set>
Key<Target> quantities(std::string name, const Dimension& dimension, Range range, std::string description, Set set) {
  Key<Target> key{{std::move(name), KeyType::quantities, dimension, "", std::move(description), range.minimum,
                   range.minimum_excluded},
                  {}};
  key.read = [spec = key.spec, set](const Context& context, const Node& node, Target& target) {
    set(target, read_list(context, node, expected_quantity(spec.dimension),
                          [&](const Node& item) { return read_quantity(context, item, spec); }));
  };
  return key;
}

/// A list of points; as `targets` also the grid of all pairs from a table {x = [...], y = [...]}.
template <class Target, class Set>
Key<Target> points(std::string name, KeyType type, const Dimension& dimension, std::string description, Set set) {
  Key<Target> key{{std::move(name), type, dimension, "", std::move(description)}, {}};
  key.read = [spec = key.spec, set](const Context& context, const Node& node, Target& target) {
    std::vector<Vec2> values;
    if (spec.type == KeyType::targets && node.is_table()) {
      struct Grid {
        std::vector<double> x, y;
      };
      Grid grid;
      read_table(context, node, "study." + spec.name,
                 Table<Grid>{{quantities<Grid>("x", spec.dimension, any, "the x coordinates of a grid",
                                               [](Grid& g, const std::vector<double>& v) { g.x = v; }),
                              quantities<Grid>("y", spec.dimension, any, "the y coordinates of a grid",
                                               [](Grid& g, const std::vector<double>& v) { g.y = v; })}},
                 grid);
      if (grid.x.empty() || grid.y.empty()) context.fail(node, "both x and y, each a list of coordinates");
      for (const double x : grid.x) {
        for (const double y : grid.y) values.push_back({x, y});
      }
    } else {
      const std::string what = "a list of two entries [x, y], each " + expected_quantity(spec.dimension);
      const std::string or_grid = spec.type == KeyType::targets ? "; or a grid {x = [...], y = [...]}" : "";
      values = read_list(context, node, what + or_grid, [&](const Node& item) {
        const auto* pair = std::get_if<Node::List>(&item.value);
        if (pair == nullptr || pair->size() != 2) context.fail(item, what);
        const double x = read_quantity(context, (*pair)[0], spec);
        return Vec2{x, read_quantity(context, (*pair)[1], spec)};
      });
    }
    set(target, std::move(values));
  };
  return key;
}

template <class Target, class Set>
Key<Target> texts(std::string name, std::string description, const std::vector<std::string>& choices, Set set) {
  Key<Target> key{{std::move(name), KeyType::texts, none, "", std::move(description)}, {}};
  key.spec.choices = choices;
  const Key<std::string> one = text<std::string>(
      key.spec.name, "", "", [](std::string& t, const std::string& v) { t = v; }, key.spec.choices);
  key.read = [one, set](const Context& context, const Node& node, Target& target) {
    const std::string what = one.spec.choices.empty() ? "text" : "one of " + quoted_choices(one.spec.choices);
    set(target, read_list(context, node, what, [&](const Node& item) {
          std::string value;
          one.read(context, item, value);
          return value;
        }));
  };
  return key;
}

template <class Target, class Part, class Select>
Key<Target> table(std::string name, std::string path, std::string description, Table<Part> content, Select select,
                  Need need = Need::optional) {
  KeySpec spec{std::move(name), KeyType::table, none, "", std::move(description)};
  spec.required = need == Need::required;
  spec.keys = content.specs();
  spec.takes_options = static_cast<bool>(content.option);
  return {spec, [path = std::move(path), content = std::move(content), select](const Context& context, const Node& node,
                                                                               Target& target) {
            read_table(context, node, path, content, select(target));
          }};
}

template <class Target, class Part, class Select>
Key<Target> tables(std::string name, std::string path, std::string description, Table<Part> content, Select select) {
  KeySpec spec{std::move(name), KeyType::tables, none, "", std::move(description)};
  spec.keys = content.specs();
  spec.takes_options = static_cast<bool>(content.option);
  return {spec, [path = std::move(path), content = std::move(content), select](const Context& context, const Node& node,
                                                                               Target& target) {
            const auto* list = std::get_if<Node::List>(&node.value);
            if (list == nullptr) context.fail(node, "tables, each begun by [[" + path + "]]");
            for (const Node& item : *list) {
              Part part{};
              if constexpr (requires { part.position = item.position; }) part.position = item.position;
              read_table(context, item, path, content, part);
              select(target).push_back(std::move(part));
            }
          }};
}

/// Native options: names belong to a component, values stay as written.
template <class Target, class Select>
Key<Target> options(std::string name, std::string path, std::string description, Select select) {
  KeySpec spec{std::move(name), KeyType::options, none, "", std::move(description)};
  spec.takes_options = true;
  return {spec, [path = std::move(path), select](const Context& context, const Node& node, Target& target) {
            const auto* entries = std::get_if<Node::Table>(&node.value);
            if (entries == nullptr) context.fail(node, "a table [" + path + "]");
            for (const Node::Entry& entry : *entries)
              select(target)[entry.key] = to_raw_value(context.document, entry.node);
          }};
}

}  // namespace tendril::app
