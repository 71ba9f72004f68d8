#include "common/scene_text.hpp"

#include <fmt/format.h>

#include <numbers>

namespace tendril::bench::scene_text {

std::string gravity_of(double size) { return fmt::format("gravity = [0, {}]\n", -size); }

std::string rod(const std::vector<SegmentText>& segments) {
  std::string text = "[rod]\n";
  for (const SegmentText& s : segments) {
    text +=
        fmt::format("[[rod.segment]]\nlength = {}\nbending_stiffness = {}\nlinear_density = {}\nrest_curvature = {}\n",
                    s.length, s.stiffness, s.density, s.rest_curvature);
  }
  return text;
}

std::string unit_rod(double weight) { return rod({{1.0, 1.0, weight, 0.0}}); }

std::string actuator(double low, double high, double from, double to) {
  return fmt::format("[[rod.actuator]]\nfrom = {}\nto = {}\nmin = {}\nmax = {}\n", from, to, low, high);
}

std::string tip_force(double x, double y) { return fmt::format("[tip_load]\nforce = [{}, {}]\n", x, y); }

std::string start(double angle) { return fmt::format("[start]\ntip_angle = {}\n", angle); }

std::string target(double x, double y) { return fmt::format("[target]\nposition = [{}, {}]\n", x, y); }

std::string circle(double x, double y, double radius) {
  return fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [{}, {}]\nradius = {}\n", x, y, radius);
}

std::string wall(double y, double up) {
  return fmt::format("[[obstacle]]\nshape = \"wall\"\npoint = [0, {}]\nangle = {}\n", y,
                     up > 0.0 ? 0.0 : std::numbers::pi);
}

std::string contact(const char* mode, int count) {
  return fmt::format("[contact]\nmode = \"{}\"\ncount = {}\n", mode, count);
}

std::string weighted(double tip, double effort) {
  return fmt::format(
      "[[objective]]\nplugin = \"tip_pose\"\nweight = {}\n[[objective]]\nplugin = \"actuation_effort\"\nweight = {}\n",
      tip, effort);
}

std::string capsule(Vec2 from, Vec2 to, double radius) {
  return fmt::format("[[obstacle]]\nshape = \"capsule\"\nfrom = [{}, {}]\nto = [{}, {}]\nradius = {}\n", from.x, from.y,
                     to.x, to.y, radius);
}

std::string arm_over(const std::string& peg, double length, double stiffness, double limit) {
  const double moment = stiffness / length;
  const double force = moment / length;
  const double weight = 0.084 * 9.81 * 1e-3 / 4.9e-4;
  const double most = limit * 0.1 / 4.9e-4 * moment;
  return gravity_of(1.0) + rod({{length, stiffness, weight * force / length, 0.0}}) +
         actuator(-most, most, 0.0, length) + start(0.5) + peg + contact("allow") +
         fmt::format("max_force = {}\n", 1.0 * 0.01 / 4.9e-4 * force) + weighted(100.0, 1e-4);
}

}  // namespace tendril::bench::scene_text
