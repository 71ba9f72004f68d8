#include "findings.hpp"

#include <algorithm>

#include "tendril/numbers.hpp"

namespace tendril::kit {

void Findings::add(const std::string& kind, const std::string& text) {
  const auto same =
      std::find_if(mistakes_.begin(), mistakes_.end(), [&](const Mistake& mistake) { return mistake.kind == kind; });
  if (same != mistakes_.end()) {
    ++same->times;
  } else {
    mistakes_.push_back({kind, text});
  }
}

void Findings::expect(bool holds, const std::string& kind, const std::string& text) {
  ++tested_;
  if (!holds) add(kind, text);
}

std::string Findings::text() const {
  std::string text;
  for (const Mistake& mistake : mistakes_) {
    text += "  " + mistake.kind + ": " + mistake.text + '\n';
    if (mistake.times > 1) text += "    (the same at " + std::to_string(mistake.times - 1) + " more places)\n";
  }
  return text;
}

std::string shown(double value) { return tendril::shown(value, 9); }

}  // namespace tendril::kit
