// Programs at the edge: bounds that leave nothing, weights of all sizes, targets out of reach.

#include <fmt/format.h>

#include "common/scene_text.hpp"
#include "extremes/groups.hpp"

namespace tendril::bench {

namespace {

using namespace scene_text;

}  // namespace

void add_programs(CaseList& list) {
  const char* group = "programs";
  const std::string heavy = gravity_of(1.0) + unit_rod(list.number(1.0));
  ExtremeCase& none = list.plan(group, "torque limit 0",
                                heavy + actuator(0.0, 0.0) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  none.known = list.number.table({Vec2{0.9912463953, -0.1234714020}, {}, {}, 1e-9});
  none.quick = true;
  const double moment = list.number(1.0);
  ExtremeCase& equal = list.plan(
      group, "equal bounds", heavy + actuator(moment, moment) + target(0.9, 0.3) + weighted(1.0, 1e-6), "exact table");
  equal.known = list.number.table({Vec2{0.898317039, 0.363091933}, {}, {}, 1e-9});
  ExtremeCase& contradictory =
      list.plan(group, "contradictory bounds", heavy + actuator(1.0, -1.0) + target(0.9, 0.3) + weighted(1.0, 1e-6),
                "no such moment");
  contradictory.verdict = "refused";
  contradictory.quick = true;
  const double effort = list.number(1e-3);
  const std::string reach = heavy + actuator(-2.0, 2.0) + target(list.number(0.9), list.number(0.3));
  for (const double weight : {1.0, 1e-12, 1e-6, 1e6, 1e12}) {
    ExtremeCase& c = list.plan(group, fmt::format("all weights times {}", weight),
                               reach + weighted(weight, effort * weight), "only ratios of weights matter");
    c.same_as = "weights";
    c.quick = weight == 1.0 || weight == 1e-12 || weight == 1e12;
  }
  (void)list.plan(group, "weights 1e12 and 1e-12", reach + weighted(1e12, 1e-12), "certificate");
  (void)list.plan(group, "weights 1e-12 and 1e12", reach + weighted(1e-12, 1e12), "certificate");
  ExtremeCase& far =
      list.plan(group, "target 1e3 L away",
                unit_rod() + actuator(-2.0, 2.0) + start(0.5) + target(list.number(1000.0), 0.0) + weighted(1.0, 0.0),
                "straight");
  far.known = {Vec2{1.0, 0.0}, {}, {}, 1e-6};
  far.quick = true;
  (void)list.plan(group, "all weights 0", reach + weighted(0.0, 0.0), "certificate");
  ExtremeCase& twice =
      list.plan(group, "duplicate terms", reach + weighted(0.5, 0.5 * effort) + weighted(0.5, 0.5 * effort),
                "one term of twice the weight");
  twice.same_as = "weights";
}

}  // namespace tendril::bench
