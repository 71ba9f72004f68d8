#include "command/reference.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

#include "command/listed_components.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/version.hpp"

namespace tendril::app {

namespace {

std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : c == '\n' ? std::string(" ") : std::string(1, c);
  return out;
}

std::string range_of(const KeySpec& key) {
  if (!std::isfinite(key.minimum)) return "";
  return fmt::format(" {} {:g}", key.minimum_excluded ? ">" : ">=", key.minimum);
}

/// Some descriptions stand inside messages too and are no sentences.
std::string sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text.ends_with('.') ? text : text + '.';
}

std::string unit_of(const KeySpec& key) {
  return key.dimension.unit.empty() ? std::string() : fmt::format(" in {}", key.dimension.unit);
}

std::string choices_of(const KeySpec& key) {
  return key.choices.empty() ? std::string() : fmt::format("\"{}\"", fmt::join(key.choices, "\", \""));
}

std::string value_of(const KeySpec& key) {
  switch (key.type) {
    case KeyType::text:
      return key.choices.empty() ? "text" : choices_of(key);
    case KeyType::boolean:
      return "true or false";
    case KeyType::integer:
      return "whole number" + range_of(key);
    case KeyType::quantity:
      return "number" + unit_of(key) + range_of(key);
    case KeyType::point:
      return "[x, y]" + unit_of(key);
    case KeyType::texts:
      return key.choices.empty() ? "list of texts" : "list of " + choices_of(key);
    case KeyType::quantities:
      return "list of numbers" + unit_of(key) + range_of(key);
    case KeyType::ends:
      return "number, or [at the base, at the end]" + unit_of(key) + range_of(key);
    case KeyType::points:
      return "list of points" + unit_of(key);
    case KeyType::targets:
      return "list of [x, y], or {x = [...], y = [...]}" + unit_of(key);
    case KeyType::law:
      return "number, or [of its first power, of its square, ...]" + unit_of(key);
    case KeyType::offsets:
      return "number, [number, number], or [[s, number], ...]" + unit_of(key);
    case KeyType::table:
    case KeyType::tables:
    case KeyType::options:
      return "table";
  }
  return "";
}

bool is_table(const KeySpec& key) {
  return key.type == KeyType::table || key.type == KeyType::tables || key.type == KeyType::options;
}

/// The keys of one table, then the tables in it.
void add_table(std::string& page, const std::vector<KeySpec>& keys, const std::string& path) {
  std::string rows;
  for (const KeySpec& key : keys) {
    if (is_table(key)) continue;
    rows += fmt::format("| `{}` | {} | {} | {} |\n", key.name, cell(value_of(key)),
                        key.required ? "required" : cell(key.default_text), cell(sentence(key.description)));
  }
  if (!rows.empty()) page += "\n| key | value | default | |\n|---|---|---|---|\n" + rows;
  for (const KeySpec& key : keys) {
    if (!is_table(key)) continue;
    const std::string name = path + key.name;
    page += fmt::format("\n## `{}{}{}`\n\n{}\n", key.type == KeyType::tables ? "[[" : "[", name,
                        key.type == KeyType::tables ? "]]" : "]", sentence(key.description));
    add_table(page, key.keys, name + '.');
  }
}

std::string component_section(const Listed& listed) {
  std::string text = fmt::format("\n### `{}`\n\n{}\n", listed.name, sentence(listed.description));
  std::string rows;
  bool native = false;
  for (const OptionSpec& option : listed.options) {
    if (option.name == any_option) {
      native = true;
      continue;
    }
    rows +=
        fmt::format("| `{}` | {} | {} | {} |\n", option.name, cell(option_range(option)),
                    option.required ? "required" : cell(option_default(option)), cell(sentence(option.description)));
  }
  if (!rows.empty()) text += "\n| option | value | default | |\n|---|---|---|---|\n" + rows;
  if (native) text += "\nAny other option of the library is taken by its own name.\n";
  return text;
}

const char* heading_of(ComponentKind kind) {
  switch (kind) {
    case ComponentKind::coordinates:
      return "Coordinate models: options of `[coordinates]`";
    case ComponentKind::objective:
      return "Objective terms: options of `[[objective]]`";
    case ComponentKind::obstacle:
      return "Obstacle shapes: options of `[[obstacle]]`";
    case ComponentKind::solver:
      return "Solvers: options of `[solver.options]`";
  }
  return "";
}

/// Text in a manual page: '\' and a leading '.' or ''' mean something there, and a plain '-' is a hyphen.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '-' || c == '\\')
      out += c == '\\' ? "\\(rs" : "\\-";
    else
      out += c;
  }
  return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

std::string between_single_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// "contact.mode=allow" and the like; lists of tables are counted, so their first entry stands for them.
void add_settings(std::vector<std::string>& settings, const std::vector<KeySpec>& keys, const std::string& path) {
  for (const KeySpec& key : keys) {
    const std::string name = path + key.name;
    if (is_table(key)) {
      add_settings(settings, key.keys, name + (key.type == KeyType::tables ? ".0." : "."));
    } else if (key.type == KeyType::text && !key.choices.empty()) {
      for (const std::string& choice : key.choices) settings.push_back(name + '=' + choice);
    } else if (key.type == KeyType::boolean) {
      for (const char* choice : {"true", "false"}) settings.push_back(name + '=' + choice);
    } else {
      settings.push_back(name + '=');
    }
  }
}

/// How bash finds candidates for a value of this name; empty: it has none.
std::string candidates(const std::string& value) {
  if (value == "DIR") return "compgen -d -- \"$word\"";
  if (value == "SCENE") return "compgen -d -- \"$word\"; compgen -f -X '!*.toml' -- \"$word\"";
  if (value == "RESULT.json") return "compgen -d -- \"$word\"; compgen -f -X '!*.json' -- \"$word\"";
  if (value == "FILE") return "compgen -f -- \"$word\"";
  if (value == "KIND") return "compgen -W 'coordinates objective obstacle solver' -- \"$word\"";
  if (value == "PAGE") return "compgen -W 'keys man bash' -- \"$word\"";
  if (value == "KEY=VALUE") return "compgen -W \"$settings\" -- \"$word\"";
  return "";
}

}  // namespace

std::string key_page(const std::vector<std::filesystem::path>& plugin_directories) {
  std::string page =
      "# Scene keys and options of plugins\n\n"
      "Written by `tendril reference keys` from the declarations that the reader itself uses. A number with a unit "
      "may\n"
      "be written as text, \"60 mm\"; a plain number is taken in the unit named here. An empty default means that the\n"
      "key is absent unless given. Plain numbers that are hardly meant so are asked about: angles of more than a turn\n"
      "and a half, lengths of more than ten rods, moments that would bend the rod by 100 rad, materials softer than "
      "100 Pa\nor lighter than 5 kg/m^3.\n\n## At the top of a scene\n";
  add_table(page, scene_keys(), "");
  plugins::Registry registry{plugins::Catalog(plugins::search_places(plugin_directories))};
  const std::vector<Listed> all = listed_components(registry);
  for (const ComponentKind kind :
       {ComponentKind::coordinates, ComponentKind::objective, ComponentKind::obstacle, ComponentKind::solver}) {
    page += fmt::format("\n## {}\n", heading_of(kind));
    for (const Listed& listed : all) {
      if (listed.kind == kind && listed.problem.empty()) page += component_section(listed);
    }
  }
  return page;
}

std::string manual_page(const std::vector<CommandSpec>& commands) {
  std::string page = fmt::format(
      ".TH TENDRIL 1 \"\" \"tendril {}\" \"User commands\"\n.SH NAME\ntendril \\- plans poses of soft continuum robots "
      "that use contact\n.SH SYNOPSIS\n",
      TENDRIL_VERSION);
  for (const CommandSpec& command : commands) {
    page += ".B tendril " + roff(command.name) + "\n";
    bool optional = false;
    for (const CommandOption& option : command.options) {
      if (option.positional)
        page += (option.required ? ".I " : ".RI [ ") + roff(option.name) + (option.required ? "\n" : " ]\n");
      optional = optional || !option.positional;
    }
    if (optional) page += ".RI [ option .\\|.\\|.]\n";
    page += ".br\n";
  }
  page +=
      ".SH DESCRIPTION\nA scene, a TOML file, describes the robot, its obstacles and what is wanted of it.\n"
      ".B tendril\nfinds actuator moments, shape and contacts, and proves the result with a certificate.\n.SH "
      "COMMANDS\n";
  for (const CommandSpec& command : commands) {
    page += fmt::format(".SS {}\n{}.\n", roff(command.name), roff(command.description));
    for (const CommandOption& option : command.options) {
      page += fmt::format(".TP\n.B {}\n", roff(option.name + (option.value.empty() ? "" : ' ' + option.value)));
      page += roff(option.description.empty() ? "no description" : option.description) + ".\n";
    }
  }
  page +=
      ".SH EXIT STATUS\n.TP\n.B 0\nsolved\n.TP\n.B 1\nno acceptable plan; the result is written all the same\n.TP\n.B "
      "2\n"
      "wrong usage, scene or plugin\n.SH ENVIRONMENT\n.TP\n.B TENDRIL_PLUGIN_PATH\nDirectories to search for plugins, "
      "separated by colons, after\n.B \\-\\-plugin\\-dir\nand before tendril's own.\n";
  return page;
}

std::string bash_completion(const std::vector<CommandSpec>& commands) {
  std::string names;
  std::string options;
  std::string values;
  for (const CommandSpec& command : commands) {
    names += (names.empty() ? "" : " ") + command.name;
    std::string own;
    std::string positional;
    for (const CommandOption& option : command.options) {
      if (option.positional) {
        const std::string found = candidates(option.name);
        if (!found.empty() && positional.empty()) positional = found;
        continue;
      }
      own += (own.empty() ? "" : " ") + option.name;
      if (!option.value.empty()) {
        const std::string found = candidates(option.value);
        values += fmt::format("    {}:{}) {} ;;\n", command.name, option.name, found.empty() ? ":" : found);
      }
    }
    options += fmt::format("    {}) options='{}' ;;\n", command.name, own + (own.empty() ? "" : " ") + "--help");
    if (!positional.empty()) values += fmt::format("    {}:) {} ;;\n", command.name, positional);
  }
  std::vector<std::string> settings;
  add_settings(settings, scene_keys(), "");
  return fmt::format(
      R"(# Completion of tendril in bash; written by 'tendril reference bash'.
_tendril_values() {{
  local word=$2 settings={2}
  case $1 in
{3}    *) return 1 ;;
  esac
}}
_tendril() {{
  local line=${{COMP_LINE:0:COMP_POINT}} words word before options=
  read -ra words <<< "$line"
  [[ $line == *[[:space:]] ]] && words+=('')
  word=${{words[-1]}}
  before=${{words[-2]}}
  if ((${{#words[@]}} <= 2)); then
    mapfile -t COMPREPLY < <(compgen -W '{0} --help --version' -- "$word")
    return
  fi
  case ${{words[1]}} in
{1}  esac
  if [[ $before == --* ]] && COMPREPLY=($(_tendril_values "${{words[1]}}:$before" "$word")); then
    :
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
  else
    mapfile -t COMPREPLY < <(_tendril_values "${{words[1]}}:" "$word")
  fi
  # Bash breaks words at '=': what stands before it is there already.
  if [[ $word == *=* && $COMP_WORDBREAKS == *=* ]]; then COMPREPLY=("${{COMPREPLY[@]#*=}}"); fi
  if [[ ${{#COMPREPLY[@]}} == 1 && ${{COMPREPLY[0]}} == *= ]]; then compopt -o nospace 2> /dev/null; fi
  return 0
}}
complete -o filenames -F _tendril tendril
)",
      names, options, between_single_quotes(fmt::format("{}", fmt::join(settings, " "))), values);
}

}  // namespace tendril::app
