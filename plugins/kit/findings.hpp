#pragma once

#include <string>
#include <vector>

namespace tendril::kit {

/// What is wrong with a component, in sentences for its author. A kind of mistake is told once, where it shows first.
class Findings {
 public:
  /// `kind` names the mistake ("first derivative"); `text` says where it shows, what was found and what was expected.
  void add(const std::string& kind, const std::string& text);
  /// Counts a statement that was tested, whether or not it holds.
  void expect(bool holds, const std::string& kind, const std::string& text);

  bool empty() const { return mistakes_.empty(); }
  int tested() const { return tested_; }
  /// One paragraph per kind of mistake.
  std::string text() const;

 private:
  struct Mistake {
    std::string kind;
    std::string text;
    int times = 1;
  };
  std::vector<Mistake> mistakes_;
  int tested_ = 0;
};

/// A number as messages show it.
std::string shown(double value);

}  // namespace tendril::kit
