#include "obstacle/rounded_hull.hpp"
#include "obstacle/shape_options.hpp"

namespace tendril {

Component<Obstacle> capsule_component() {
  return {"capsule",
          "all points within a radius of a line",
          {point_option("from", "one end of the line"), point_option("to", "its other end"),
           positive_length_option("radius", "radius of the capsule")},
          [](const Options& options) -> std::unique_ptr<Obstacle> {
            const Vec2 from = point_of(options, "from");
            const Vec2 to = point_of(options, "to");
            if (from == to) {
              throw OptionError("to", {},
                                "option 'to' of a capsule: found the same point as 'from'; expected another one (a "
                                "capsule without length is a circle)");
            }
            return std::make_unique<RoundedHull>(std::vector<Vec2>{from, to}, options.real("radius"));
          }};
}

}  // namespace tendril
