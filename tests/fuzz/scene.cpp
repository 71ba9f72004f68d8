// The scene reader, from bytes to a scene that core has checked: whatever it is given, it answers or refuses.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "tendril/app/document.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/problem.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto units = std::make_shared<tendril::app::Units>();
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    tendril::app::require_text(text, "fuzz.toml");
    const tendril::app::Document document = tendril::app::Document::parse(text, "fuzz.toml");
    tendril::validate(tendril::app::read_scene(document, units));
  } catch (const tendril::Error&) {
    // Refused, as it may be. Anything else that is thrown ends the fuzzer.
  }
  return 0;
}
