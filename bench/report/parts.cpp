#include "report/parts.hpp"

#include "extremes/extremes.hpp"
#include "report/lean.hpp"
#include "report/scaling.hpp"
#include "report/speed.hpp"

namespace tendril::bench {

const std::vector<Part>& parts() {
  static const std::vector<Part> all{
      {"speed", "What a plan, a followed step and a certificate cost, in evaluations",
       [](plugins::Registry& registry, const Extent& extent) { return std::vector{speed_section(registry, extent)}; }},
      {"lean", "What a scene pays for what it does not use",
       [](plugins::Registry& registry, const Extent& extent) { return std::vector{lean_section(registry, extent)}; }},
      {"scaling", "How the cost grows with the size of what is asked for",
       [](plugins::Registry& registry, const Extent& extent) {
         return std::vector{scaling_section(registry, extent)};
       }},
      {"extremes", "Stiff and extreme cases with known answers",
       [](plugins::Registry& registry, const Extent& extent) {
         return std::vector{extremes_section(registry, extent)};
       }},
  };
  return all;
}

}  // namespace tendril::bench
