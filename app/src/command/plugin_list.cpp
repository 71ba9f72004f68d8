#include "tendril/app/plugin_list.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command/listed_components.hpp"
#include "tendril/plugins/probe.hpp"

namespace tendril::app {

namespace {

using Json = nlohmann::ordered_json;

template <class Interface>
void describe(const Component<Interface>& component, Listed& listed) {
  listed.description = component.description;
  listed.options = component.options;
}

Listed look_at(const plugins::PluginFile& file) {
  Listed listed{file.kind, file.name, file.path.string(), file.refusal, {}, {}};
  if (listed.problem.empty() && file.shadowed)
    listed.problem = "hidden by a plugin of the same name in an earlier place";
  if (!listed.problem.empty()) return listed;
  const plugins::ProbeResult probe = plugins::probe(file.path);
  listed.problem = probe.loadable ? "" : probe.problem;
  if (!probe.loadable) return listed;
  try {
    std::visit([&](const auto& component) { describe(component, listed); }, plugins::open_plugin(file));
  } catch (const Error& error) {
    listed.problem = error.what();
  }
  return listed;
}

std::vector<Listed> builtin_shapes(plugins::Registry& registry) {
  std::vector<Listed> shapes;
  for (const std::string& name : registry.builtin_obstacles()) {
    Listed listed{ComponentKind::obstacle, name, {}, {}, {}, {}};
    describe(registry.obstacle(name), listed);
    shapes.push_back(std::move(listed));
  }
  return shapes;
}

const char* type_name(OptionType type) {
  switch (type) {
    case OptionType::boolean:
      return "true or false";
    case OptionType::integer:
      return "whole number";
    case OptionType::real:
      return "number";
    case OptionType::text:
      return "text";
    case OptionType::list:
      return "list";
    case OptionType::points:
      return "list of points";
    case OptionType::matrix:
      return "matrix";
  }
  return "";
}

Json value_json(const OptionValue& value) {
  struct Convert {
    Json operator()(std::monostate) const { return nullptr; }
    Json operator()(bool v) const { return v; }
    Json operator()(std::int64_t v) const { return v; }
    Json operator()(double v) const { return std::isfinite(v) ? Json(v) : Json(nullptr); }
    Json operator()(const std::string& v) const { return v; }
    Json operator()(const NumberTable& table) const {
      if (table.rows == 1) return table.values;
      Json rows = Json::array();
      for (int i = 0; i < table.rows; ++i) {
        Json row = Json::array();
        for (int k = 0; k < table.columns; ++k) row.push_back(table(i, k));
        rows.push_back(std::move(row));
      }
      return rows;
    }
  };
  return std::visit(Convert{}, value);
}

Json option_json(const OptionSpec& spec) {
  const auto bound = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  return {{"name", spec.name},
          {"type", type_name(spec.type)},
          {"unit", spec.dimension.unit},
          {"default", value_json(spec.default_value)},
          {"required", spec.required},
          {"minimum", bound(spec.minimum)},
          {"minimum_excluded", spec.minimum_excluded},
          {"maximum", bound(spec.maximum)},
          {"choices", spec.choices},
          {"description", spec.description}};
}

std::string option_text(const OptionSpec& spec) {
  if (spec.name == any_option) return "    and any other option of the library, by its own name\n";
  std::string text = fmt::format("    {:<20} {}", spec.name, option_range(spec));
  const std::string value = option_default(spec);
  if (spec.required) {
    text += ", required";
  } else if (!value.empty()) {
    text += ", default " + value;
  }
  return text + (spec.description.empty() ? "\n" : ". " + spec.description + '\n');
}

std::string indented(const std::string& text) {
  std::string out = "    ";
  for (const char c : text) out += c == '\n' ? std::string("\n    ") : std::string(1, c);
  return out + '\n';
}

}  // namespace

std::vector<Listed> listed_components(plugins::Registry& registry) {
  std::vector<Listed> all = builtin_shapes(registry);
  for (const plugins::PluginFile& file : registry.catalog().files()) all.push_back(look_at(file));
  return all;
}

std::string option_range(const OptionSpec& spec) {
  std::string text = type_name(spec.type);
  if (!spec.dimension.unit.empty()) text += fmt::format(" in {}", spec.dimension.unit);
  if (!spec.choices.empty()) text += fmt::format(" ({})", fmt::join(spec.choices, ", "));
  if (std::isfinite(spec.minimum)) text += fmt::format(" {} {:g}", spec.minimum_excluded ? ">" : ">=", spec.minimum);
  if (std::isfinite(spec.maximum)) text += fmt::format(" <= {:g}", spec.maximum);
  return text;
}

std::string option_default(const OptionSpec& spec) {
  const Json value = value_json(spec.default_value);
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string plugin_list(const std::vector<std::filesystem::path>& plugin_directories, bool json) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places(plugin_directories))};
  const plugins::Catalog& catalog = registry.catalog();
  const std::vector<Listed> all = listed_components(registry);

  if (json) {
    Json document{{"schema", 1}, {"plugins", Json::array()}, {"places", Json::array()}, {"strays", Json::array()}};
    for (const Listed& listed : all) {
      Json options = Json::array();
      for (const OptionSpec& spec : listed.options) options.push_back(option_json(spec));
      document["plugins"].push_back({{"kind", to_string(listed.kind)},
                                     {"name", listed.name},
                                     {"file", listed.file.empty() ? Json(nullptr) : Json(listed.file)},
                                     {"loadable", listed.problem.empty()},
                                     {"problem", listed.problem},
                                     {"description", listed.description},
                                     {"options", std::move(options)}});
    }
    for (const plugins::Catalog::Place& place : catalog.places()) {
      document["places"].push_back({{"directory", place.place.directory.string()},
                                    {"origin", place.place.origin},
                                    {"problem", place.problem},
                                    {"plugins", place.plugin_count}});
    }
    for (const plugins::Catalog::Stray& stray : catalog.strays()) {
      document["strays"].push_back({{"file", stray.path.string()}, {"problem", stray.problem}});
    }
    return document.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
  }

  std::string text;
  for (const Listed& listed : all) {
    text += fmt::format("{} {}{}\n", to_string(listed.kind), listed.name,
                        listed.description.empty() ? "" : ": " + listed.description);
    text += listed.file.empty() ? "    built in\n" : "    " + listed.file + '\n';
    if (!listed.problem.empty()) text += indented("NOT LOADABLE: " + listed.problem);
    for (const OptionSpec& spec : listed.options) text += option_text(spec);
  }
  text += "\nsearched\n";
  for (const plugins::Catalog::Place& place : catalog.places()) {
    const std::string found = place.problem.empty() ? fmt::format("{} plugins", place.plugin_count) : place.problem;
    text += fmt::format("  {} ({}): {}\n", place.place.directory.string(), place.place.origin, found);
  }
  for (const plugins::Catalog::Stray& stray : catalog.strays()) {
    text += fmt::format("  passed over {}: {}\n", stray.path.string(), stray.problem);
  }
  return text;
}

}  // namespace tendril::app
