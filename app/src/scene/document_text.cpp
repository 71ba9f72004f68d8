#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tendril/app/document.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

std::string text_value(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if ((c >= 0 && c < ' ') || c == 127) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? key : text_value(key);
}

bool is_list_of_tables(const Node& node) {
  const auto* list = std::get_if<Node::List>(&node.value);
  return list != nullptr && !list->empty() &&
         std::all_of(list->begin(), list->end(), [](const Node& item) { return item.is_table(); });
}

/// A value behind its key, or inside a list.
struct Inline {
  std::string operator()(const Node::Other& other) const {
    throw InputError("found " + other.name + ", which no key of a scene takes");
  }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
  std::string operator()(double value) const {
    const std::string text = fmt::format("{}", value);
    return text.find_first_not_of("-0123456789") == std::string::npos ? text + ".0" : text;
  }
  std::string operator()(const std::string& value) const { return text_value(value); }
  std::string operator()(const Node::List& list) const {
    std::string out;
    for (const Node& item : list) out += (out.empty() ? "" : ", ") + std::visit(*this, item.value);
    return '[' + out + ']';
  }
  std::string operator()(const Node::Table& table) const {
    std::string out;
    for (const Node::Entry& entry : table) {
      out += (out.empty() ? "" : ", ") + key_text(entry.key) + " = " + std::visit(*this, entry.node.value);
    }
    return '{' + out + '}';
  }
};

void write_table(const Node::Table& table, const std::string& path, std::string& out) {
  for (const Node::Entry& entry : table) {
    if (entry.node.is_table() || is_list_of_tables(entry.node)) continue;
    out += key_text(entry.key) + " = " + std::visit(Inline{}, entry.node.value) + '\n';
  }
  const auto below = [&](const std::string& header, const Node& node, const std::string& inner) {
    out += (out.empty() ? "" : "\n") + header + '\n';
    write_table(std::get<Node::Table>(node.value), inner, out);
  };
  for (const Node::Entry& entry : table) {
    const std::string inner = path + (path.empty() ? "" : ".") + key_text(entry.key);
    if (entry.node.is_table()) {
      below('[' + inner + ']', entry.node, inner);
    } else if (is_list_of_tables(entry.node)) {
      for (const Node& item : std::get<Node::List>(entry.node.value)) below("[[" + inner + "]]", item, inner);
    }
  }
}

}  // namespace

std::string text_of(const Document& document) {
  std::string out;
  write_table(std::get<Node::Table>(document.root().value), "", out);
  return out;
}

std::string text_of(const Document& document, const std::string& table) {
  Node::Table alone;
  for (const Node::Entry& entry : std::get<Node::Table>(document.root().value)) {
    if (entry.key == table) alone.push_back(entry);
  }
  std::string out;
  write_table(alone, "", out);
  return out;
}

}  // namespace tendril::app
