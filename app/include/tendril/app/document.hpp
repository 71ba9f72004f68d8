#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tendril/options.hpp"

namespace tendril::app {

/// A value of a scene file with its place, before it means anything. Positions with line 0 are not from the file; their
/// column is then the number of the argument (1, 2, ...) that set the value.
struct Node {
  struct Entry;
  using List = std::vector<Node>;
  using Table = std::vector<Entry>;  ///< in the order of the file
  /// Of a kind that no key takes, such as a date.
  struct Other {
    std::string name;
  };

  std::variant<Other, bool, std::int64_t, double, std::string, List, Table> value;
  SourcePosition position{};

  bool is_table() const { return std::holds_alternative<Table>(value); }
  const Node* find(std::string_view key) const;  ///< null if this is no table or has no such key
};

struct Node::Entry {
  std::string key;
  SourcePosition position{};
  Node node;
};

/// Positions in an included file have lines above this one.
inline constexpr int included_lines = 1'000'000;

/// A setting from the command line: `key` as in `contact.max_force` or `rod.actuator.0.limit`, `text` as in `0.5 N`.
struct Override {
  std::string argument;  ///< how the user wrote it, for messages
  std::string key;
  std::string text;
  bool literal = false;  ///< text is a word as it stands, never TOML
};

/// Keys and tables may be nested this deep. The parser would overflow its stack on very deep ones.
inline constexpr int deepest_key = 64;

/// A parsed scene file, with the settings of the command line already put in.
class Document {
 public:
  /// Reads and parses `path`. Throws InputError.
  static Document read(const std::filesystem::path& path);
  /// Parses text; `file` names it in messages.
  static Document parse(const std::string& text, std::string file);

  /// Puts in what the file named by the key 'include' says and this one does not, and takes the key away. Throws
  /// InputError, also where that file includes another one.
  void include();
  /// Puts in settings, in order; tables that are missing are made. Throws InputError.
  void apply(const std::vector<Override>& overrides);
  /// Takes the key at `path` ("rod.actuator.0.limit") away, if it is there.
  void erase(const std::string& path);

  const Node& root() const { return root_; }
  const std::string& file() const { return file_; }

  /// "scene.toml:7:10", or the argument that set the value.
  std::string describe(SourcePosition position) const;
  /// Place of the key at `path` ("rod.actuator[0].limit"), or of the nearest table around it.
  SourcePosition find(const std::string& path) const;
  /// InputError at `position`.
  [[noreturn]] void fail(SourcePosition position, const std::string& message) const;

 private:
  std::string file_;
  Node root_;
  std::vector<std::string> arguments_;
  std::string included_;  ///< a file; lines of it count from `included_lines` on
};

/// "a table", "the number 3", "\"60 mm\"", ...: what was found, for messages.
std::string describe_value(const Node& node);

/// A document as TOML: its keys in their order, tables below their keys, every comment gone. Throws InputError where it
/// holds a date or a time, which no key takes.
std::string text_of(const Document& document);
/// The same of one of its tables, headers and all; empty: it has no such table.
std::string text_of(const Document& document, const std::string& table);

/// The node as an option of a component. Throws through `document` where it holds a table.
RawValue to_raw_value(const Document& document, const Node& node);

}  // namespace tendril::app
