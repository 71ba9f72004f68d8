#include "tendril/app/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

SourcePosition position_of(const toml::source_region& source) {
  return {static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)};
}

Node convert(const toml::node& from) {
  Node node;
  node.position = position_of(from.source());
  switch (from.type()) {
    case toml::node_type::boolean:
      node.value = from.as_boolean()->get();
      break;
    case toml::node_type::integer:
      node.value = from.as_integer()->get();
      break;
    case toml::node_type::floating_point:
      node.value = from.as_floating_point()->get();
      break;
    case toml::node_type::string:
      node.value = from.as_string()->get();
      break;
    case toml::node_type::array: {
      Node::List list;
      for (const toml::node& item : *from.as_array()) list.push_back(convert(item));
      node.value = std::move(list);
      break;
    }
    case toml::node_type::table: {
      Node::Table table;
      for (const auto& [key, item] : *from.as_table()) {
        table.push_back({std::string(key.str()), position_of(key.source()), convert(item)});
      }
      std::stable_sort(table.begin(), table.end(), [](const Node::Entry& a, const Node::Entry& b) {
        return std::pair(a.position.line, a.position.column) < std::pair(b.position.line, b.position.column);
      });
      node.value = std::move(table);
      break;
    }
    default:
      node.value = Node::Other{from.is_date() ? "a date" : from.is_time() ? "a time of day" : "a date and time"};
  }
  return node;
}

/// Finds keys and brackets nested too deep, without recursion. It need not know TOML well: what it misjudges in a
/// malformed file the parser refuses anyway.
class DepthScanner {
 public:
  explicit DepthScanner(std::string_view text) : text_(text) {}

  std::optional<SourcePosition> first_too_deep() {
    open_.push_back({'\n', 0});
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
        continue;
      }
      read(c);
      if (depth() > deepest_key) return SourcePosition{line_, static_cast<int>(at_ - line_start_) + 1};
      advance();
    }
    return std::nullopt;
  }

 private:
  struct Open {
    char bracket;  // '\n' for the file, 'h' for a header, '[' or '{' for a value
    int parts;     // of the key that is being read or whose value is being read
  };

  int depth() const {
    int sum = header_;
    for (const Open& open : open_) sum += open.parts + (open.bracket == '[' || open.bracket == '{' ? 1 : 0);
    return sum;
  }

  void read(char c) {
    Open& top = open_.back();
    switch (c) {
      case '\n':
        if (open_.size() == 1 || top.bracket == 'h') {
          open_.resize(1);
          open_.back().parts = 0;
          in_key_ = true;
        }
        break;
      case '=':
        in_key_ = false;
        break;
      case '.':
        if (in_key_) ++top.parts;
        break;
      case '[':
        if (in_key_ && open_.size() == 1) {
          header_ = 0;
          open_.push_back({'h', 1});
        } else if (top.bracket != 'h') {
          open_.push_back({'[', 0});
          in_key_ = false;
        }
        break;
      case '{':
        open_.push_back({'{', 0});
        in_key_ = true;
        break;
      case ']':
      case '}':
        if (open_.size() > 1) {
          if (top.bracket == 'h') header_ = top.parts;
          open_.pop_back();
        }
        in_key_ = false;
        break;
      case ',':
        if (top.bracket == '{') {
          top.parts = 0;
          in_key_ = true;
        }
        break;
      default:
        if (in_key_ && top.parts == 0) top.parts = 1;
    }
  }

  void skip_string(char quote) {
    if (in_key_ && open_.back().parts == 0) open_.back().parts = 1;
    const std::string three(3, quote);
    const bool multi_line = text_.substr(at_, 3) == three;
    for (int i = 0; i < (multi_line ? 3 : 1); ++i) advance();
    while (at_ < text_.size()) {
      if (quote == '"' && text_[at_] == '\\') {
        advance();
      } else if (!multi_line && text_[at_] == '\n') {
        return;
      } else if (text_[at_] == quote && (!multi_line || text_.substr(at_, 3) == three)) {
        for (int i = 0; i < (multi_line ? 3 : 1); ++i) advance();
        return;
      }
      advance();
    }
  }

  void advance() {
    if (at_ < text_.size() && text_[at_] == '\n') {
      ++line_;
      line_start_ = at_ + 1;
    }
    ++at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_start_ = 0;
  int line_ = 1;
  int header_ = 0;
  bool in_key_ = true;
  std::vector<Open> open_;
};

/// The value that `text` stands for: TOML if it is, else the text itself, so that the shell's quotes are enough.
Node value_from_argument(const std::string& text, bool literal) {
  Node node;
  node.value = text;
  if (literal || text.find('\n') != std::string::npos || DepthScanner("v=" + text).first_too_deep()) return node;
  try {
    const toml::table table = toml::parse("v = " + text);
    if (const toml::node* found = table.get("v"); found != nullptr && table.size() == 1) return convert(*found);
  } catch (const toml::parse_error&) {
    return node;
  }
  return node;
}

void set_position(Node& node, SourcePosition position) {
  node.position = position;
  if (auto* list = std::get_if<Node::List>(&node.value)) {
    for (Node& item : *list) set_position(item, position);
  } else if (auto* table = std::get_if<Node::Table>(&node.value)) {
    for (Node::Entry& entry : *table) {
      entry.position = position;
      set_position(entry.node, position);
    }
  }
}

/// "rod.actuator[0].limit" and "rod.actuator.0.limit" as {"rod", "actuator", "0", "limit"}.
std::vector<std::string> split_path(std::string_view path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[') {
      parts.emplace_back();
    } else if (c != ']') {
      parts.back() += c;
    }
  }
  return parts;
}

void shift_lines(Node& node, int lines) {
  node.position.line += lines;
  if (auto* list = std::get_if<Node::List>(&node.value)) {
    for (Node& item : *list) shift_lines(item, lines);
  } else if (auto* table = std::get_if<Node::Table>(&node.value)) {
    for (Node::Entry& entry : *table) {
      entry.position.line += lines;
      shift_lines(entry.node, lines);
    }
  }
}

/// Adds the entries of `from` that `to` has not.
void merge(Node& to, Node from) {
  auto& own = std::get<Node::Table>(to.value);
  for (Node::Entry& entry : std::get<Node::Table>(from.value)) {
    const auto same = std::find_if(own.begin(), own.end(), [&](const Node::Entry& e) { return e.key == entry.key; });
    if (same == own.end()) {
      own.push_back(std::move(entry));
    } else if (same->node.is_table() && entry.node.is_table()) {
      merge(same->node, std::move(entry.node));
    }
  }
}

std::optional<std::size_t> as_index(std::string_view text) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return index;
}

}  // namespace

const Node* Node::find(std::string_view key) const {
  const auto* table = std::get_if<Table>(&value);
  if (table == nullptr) return nullptr;
  const auto entry = std::find_if(table->begin(), table->end(), [&](const Entry& e) { return e.key == key; });
  return entry == table->end() ? nullptr : &entry->node;
}

Document Document::read(const std::filesystem::path& path) {
  const std::string text = read_scene_input(path);
  const std::filesystem::path name = path == standard_input ? "standard input" : path;
  require_text(text, name);
  return parse(text, name.string());
}

Document Document::parse(const std::string& text, std::string file) {
  Document document;
  document.file_ = std::move(file);
  if (const auto position = DepthScanner(text).first_too_deep()) {
    document.fail(*position, fmt::format("found a key nested deeper than {} levels, expected at most {}", deepest_key,
                                         deepest_key));
  }
  try {
    document.root_ = convert(toml::parse(text, document.file_));
  } catch (const toml::parse_error& error) {
    document.fail(position_of(error.source()), "this is not TOML: " + std::string(error.description()));
  }
  document.root_.position = {1, 1};
  return document;
}

void Document::include() {
  auto& table = std::get<Node::Table>(root_.value);
  const auto key = std::find_if(table.begin(), table.end(), [](const Node::Entry& e) { return e.key == "include"; });
  if (key == table.end()) return;
  const auto* name = std::get_if<std::string>(&key->node.value);
  if (name == nullptr) fail(key->node.position, "found " + describe_value(key->node) + ", expected the name of a file");
  Document other = read(std::filesystem::path(file_).parent_path() / *name);
  if (other.root_.find("include") != nullptr) {
    other.fail(other.find("include"), "found 'include' in a file that is included, expected none");
  }
  included_ = other.file_;
  table.erase(key);
  shift_lines(other.root_, included_lines);
  merge(root_, std::move(other.root_));
}

void Document::apply(const std::vector<Override>& overrides) {
  for (const Override& setting : overrides) {
    arguments_.push_back(setting.argument);
    const SourcePosition position{0, static_cast<int>(arguments_.size())};
    const std::vector<std::string> parts = split_path(setting.key);
    if (static_cast<int>(parts.size()) > deepest_key || std::find(parts.begin(), parts.end(), "") != parts.end()) {
      fail(position, "found the key '" + setting.key.substr(0, 200) + "', expected one such as contact.max_force");
    }
    if (parts.front() == "include") fail(position, "found 'include', expected it in the scene: settings come after it");
    Node* node = &root_;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (auto* list = std::get_if<Node::List>(&node->value)) {
        const auto index = as_index(parts[i]);
        if (!index || *index >= list->size()) {
          const std::string entries = list->empty()       ? "no entry"
                                      : list->size() == 1 ? "one entry, number 0"
                                                          : fmt::format("entries 0 to {}", list->size() - 1);
          fail(position, fmt::format("found '{}' in '{}', but there is {}", parts[i], setting.key, entries));
        }
        node = &(*list)[*index];
        continue;
      }
      if (!node->is_table()) {
        fail(position, fmt::format("found '{}' in '{}', but what stands before it is a value and not a table", parts[i],
                                   setting.key));
      }
      if (as_index(parts[i])) {
        fail(position, fmt::format("found '{}' in '{}', but the scene has no such entry", parts[i], setting.key));
      }
      auto& table = std::get<Node::Table>(node->value);
      auto entry = std::find_if(table.begin(), table.end(), [&](const Node::Entry& e) { return e.key == parts[i]; });
      if (entry == table.end()) entry = table.insert(table.end(), {parts[i], position, {Node::Table{}, position}});
      node = &entry->node;
    }
    *node = value_from_argument(setting.text, setting.literal);
    set_position(*node, position);
  }
}

void Document::erase(const std::string& path) {
  Node* node = &root_;
  const std::vector<std::string> parts = split_path(path);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (auto* list = std::get_if<Node::List>(&node->value)) {
      const auto index = as_index(parts[i]);
      if (!index || *index >= list->size()) return;
      node = &(*list)[*index];
    } else if (auto* table = std::get_if<Node::Table>(&node->value)) {
      const auto entry =
          std::find_if(table->begin(), table->end(), [&](const Node::Entry& e) { return e.key == parts[i]; });
      if (entry == table->end()) return;
      if (i + 1 == parts.size()) {
        table->erase(entry);
        return;
      }
      node = &entry->node;
    } else {
      return;
    }
  }
}

std::string Document::describe(SourcePosition position) const {
  if (position.line > included_lines) {
    return fmt::format("{}:{}:{}", included_, position.line - included_lines, position.column);
  }
  if (position.line > 0) return fmt::format("{}:{}:{}", file_, position.line, position.column);
  const auto argument = static_cast<std::size_t>(position.column);
  if (argument >= 1 && argument <= arguments_.size()) return arguments_[argument - 1];
  return file_;
}

SourcePosition Document::find(const std::string& path) const {
  SourcePosition position = root_.position;
  const Node* node = &root_;
  for (const std::string& part : split_path(path)) {
    if (const auto* list = std::get_if<Node::List>(&node->value)) {
      const auto index = as_index(part);
      if (!index || *index >= list->size()) break;
      node = &(*list)[*index];
    } else {
      node = node->find(part);
      if (node == nullptr) break;
    }
    position = node->position;
  }
  return position;
}

void Document::fail(SourcePosition position, const std::string& message) const {
  throw InputError(describe(position) + ": " + message);
}

std::string describe_value(const Node& node) {
  struct Describe {
    std::string operator()(const Node::Other& other) const { return other.name; }
    std::string operator()(bool value) const { return value ? "true" : "false"; }
    std::string operator()(std::int64_t value) const { return fmt::format("the number {}", value); }
    std::string operator()(double value) const {
      // A real number shows that it is one.
      const std::string text = fmt::format("{}", value);
      return "the number " + text + (text.find_first_not_of("-0123456789") == std::string::npos ? ".0" : "");
    }
    std::string operator()(const std::string& value) const {
      std::string text = "\"";
      for (const char c : value.substr(0, 80)) text += (c >= 0 && c < ' ') || c == 127 ? '?' : c;
      return text + (value.size() > 80 ? "...\"" : "\"");
    }
    std::string operator()(const Node::List& list) const {
      return list.size() == 1 ? "a list of 1 entry" : fmt::format("a list of {} entries", list.size());
    }
    std::string operator()(const Node::Table&) const { return "a table"; }
  };
  return std::visit(Describe{}, node.value);
}

RawValue to_raw_value(const Document& document, const Node& node) {
  RawValue raw;
  raw.position = node.position;
  if (const auto* list = std::get_if<Node::List>(&node.value)) {
    RawValue::List values;
    for (const Node& item : *list) values.push_back(to_raw_value(document, item));
    raw.value = std::move(values);
  } else if (const auto* boolean = std::get_if<bool>(&node.value)) {
    raw.value = *boolean;
  } else if (const auto* integer = std::get_if<std::int64_t>(&node.value)) {
    raw.value = *integer;
  } else if (const auto* real = std::get_if<double>(&node.value)) {
    raw.value = *real;
  } else if (const auto* text = std::get_if<std::string>(&node.value)) {
    raw.value = *text;
  } else {
    document.fail(node.position, "found " + describe_value(node) + ", expected a number, text, true, false or a list");
  }
  return raw;
}

}  // namespace tendril::app
