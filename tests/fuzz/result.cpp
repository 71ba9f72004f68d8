// The result reader: whatever it is given as a result, it answers or refuses.

#include "tendril/app/result.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

#include "tendril/error.hpp"

namespace {

tendril::Scene scene() {
  tendril::Scene scene;
  scene.rod.segments = {{0.1, 4.9e-4, 0.084, 0.0}};
  scene.rod.actuators = {{0.0, 0.1}};
  scene.obstacles = {{"obstacle 1", "circle"}};
  return scene;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tendril::Scene rod = scene();
  try {
    tendril::app::parse_start(std::string(reinterpret_cast<const char*>(data), size), "fuzz.json", rod);
  } catch (const tendril::Error&) {
    // Refused, as it may be. Anything else that is thrown ends the fuzzer.
  }
  return 0;
}
