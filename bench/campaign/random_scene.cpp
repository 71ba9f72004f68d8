#include "campaign/random_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::bench {
namespace {

using std::numbers::pi;

/// Numbers from one seed. The distributions of the standard library differ between its makers; these do not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double log_between(double low, double high) { return low * std::pow(high / low, unit()); }
  bool chance(double p) { return unit() < p; }
  int whole(int low, int high) {
    return low + std::min(high - low, static_cast<int>(unit() * static_cast<double>(high - low + 1)));
  }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }

 private:
  std::mt19937_64 engine_;
};

/// A unit and its size in SI.
struct Unit {
  const char* name;
  double size;
};

struct UnitSystem {
  Unit length, force, moment, stiffness, density, curvature;
};

constexpr double inch = 0.0254;
constexpr double pound = 0.45359237;
constexpr double pound_force = pound * 9.80665;
constexpr std::array<UnitSystem, 3> systems{
    {{{"m", 1.0}, {"N", 1.0}, {"N m", 1.0}, {"N m^2", 1.0}, {"kg/m", 1.0}, {"1/m", 1.0}},
     {{"mm", 1e-3}, {"mN", 1e-3}, {"N mm", 1e-3}, {"N mm^2", 1e-6}, {"g/m", 1e-3}, {"1/mm", 1e3}},
     {{"in", inch},
      {"lbf", pound_force},
      {"lbf in", pound_force* inch},
      {"lbf in^2", pound_force* inch* inch},
      {"lb/in", pound / inch},
      {"1/in", 1.0 / inch}}}};

constexpr double g = 9.81;

/// An obstacle in units of L, as far as the draw has to know it.
struct Shape {
  std::string text;
  bool free_base = false;  ///< the base is outside
};

class Drawer {
 public:
  Drawer(std::uint64_t seed, std::string solver, double time_limit, const std::set<std::string>& plugins, bool outlines,
         bool friction)
      : dice_(seed),
        friction_dice_(~seed),
        solver_(std::move(solver)),
        time_limit_(time_limit),
        plugins_(plugins),
        outlines_(outlines),
        friction_(friction) {}

  RandomScene draw() {
    units_ = systems[static_cast<std::size_t>(dice_.whole(0, 2))];
    length_ = dice_.log_between(1e-3, 100.0);
    stiffness_ = dice_.log_between(1e-12, 1e6);
    note("EI {:.1e} N m^2, L {:.2g} m", stiffness_, length_);
    rod();
    coordinates();
    add("[start]\ntip_angle = {:.17g}\n", dice_.chance(0.3) ? 0.0 : dice_.between(-2.0, 2.0));
    obstacles();
    contact();
    target();
    objectives();
    add("[solver]\nplugin = \"{}\"\ntime_limit = {:.17g}\n", solver_, time_limit_);
    return {head_ + body_, summary_};
  }

 private:
  template <class... Args>
  void add(const char* format, const Args&... args) {
    body_ += fmt::format(fmt::runtime(format), args...);
  }
  template <class... Args>
  void note(const char* format, const Args&... args) {
    summary_ += (summary_.empty() ? "" : ", ") + fmt::format(fmt::runtime(format), args...);
  }
  static std::string quantity(double si, const Unit& unit) {
    return fmt::format("\"{:.17g} {}\"", si / unit.size, unit.name);
  }
  std::string length(double in_lengths) const { return quantity(in_lengths * length_, units_.length); }
  std::string force(double in_units) const {
    return quantity(in_units * stiffness_ / (length_ * length_), units_.force);
  }
  std::string moment(double in_units) const { return quantity(in_units * stiffness_ / length_, units_.moment); }
  std::string point(Vec2 p) const { return fmt::format("[{}, {}]", length(p.x), length(p.y)); }
  static Vec2 direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

  void rod() {
    head_ += "problem = \"pose\"\n";
    const bool heavy = dice_.chance(0.6);
    segments(heavy ? weight() : 0.0);
    actuators();
    tip_load(heavy);
  }

  /// Gravity, and the rod's weight in units of its stiffness.
  double weight() {
    const Vec2 down = dice_.chance(0.5) ? Vec2{0.0, -1.0} : direction(dice_.between(-pi, pi));
    head_ += fmt::format("gravity = [\"{:.17g} m/s^2\", \"{:.17g} m/s^2\"]\n", g * down.x, g * down.y);
    const double weight = dice_.chance(0.1) ? 0.0 : dice_.log_between(1e-3, 1e4);
    note("w {:.2g}", weight);
    return weight;
  }

  void segments(double weight) {
    const double density = weight * stiffness_ / (g * length_ * length_ * length_);
    body_ += "[rod]\n";
    const int count = dice_.chance(0.6) ? 1 : dice_.whole(2, 4);
    std::vector<double> parts;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
      parts.push_back(dice_.chance(0.1) ? dice_.log_between(1e-3, 1.0) : dice_.between(0.3, 1.0));
      sum += parts.back();
    }
    if (count > 1) note("{} segments", count);
    const auto segment = [&](double part, double ratio, double heavier) {
      const double turns = 4.0 * pi;
      const double rest = dice_.chance(0.2) ? dice_.sign() * dice_.log_between(0.1, turns) / length_ : 0.0;
      add("length = {}\nbending_stiffness = {}\nlinear_density = {}\nrest_curvature = {}\n", length(part),
          quantity(stiffness_ * ratio, units_.stiffness), quantity(density * heavier, units_.density),
          quantity(rest, units_.curvature));
    };
    if (count == 1) segment(1.0, 1.0, 1.0);
    if (dice_.chance(0.3)) {
      base_ = {dice_.between(-1.0, 1.0), dice_.between(-1.0, 1.0)};
      base_angle_ = dice_.between(-pi, pi);
      add("base = {{position = {}, angle = {:.17g}}}\n", point(base_), base_angle_);
    }
    if (count == 1) return;
    // The first segment's stiffness is the unit, so that the others span six decades around it.
    for (int i = 0; i < count; ++i) {
      const double ratio = i == 0 ? 1.0 : dice_.chance(0.2) ? dice_.log_between(1e-3, 1e3) : dice_.log_between(0.2, 5);
      const double heavier = i == 0 ? 1.0 : dice_.chance(0.1) ? 0.0 : dice_.log_between(0.1, 10.0);
      add("[[rod.segment]]\n");
      segment(parts[static_cast<std::size_t>(i)] / sum, ratio, heavier);
    }
  }

  void actuators() {
    const int actuators = dice_.chance(0.03) ? 0 : dice_.chance(0.6) ? 1 : dice_.whole(2, 3);
    for (int a = 0; a < actuators; ++a) {
      add("[[rod.actuator]]\n");
      if (a > 0) {
        const double from = dice_.between(0.0, 0.7);
        add("from = {}\nto = {}\n", length(from), length(dice_.chance(0.3) ? 1.0 : dice_.between(from + 0.1, 1.0)));
      }
      const double limit = dice_.log_between(0.1, 30.0);
      if (dice_.chance(0.05)) {
        add("limit = 0\n");
      } else if (dice_.chance(0.05)) {
        add("min = {0}\nmax = {0}\n", moment(dice_.sign() * dice_.between(0.0, 3.0)));
      } else if (dice_.chance(0.2)) {
        add("min = {}\nmax = {}\n", moment(-limit * dice_.unit()), moment(limit));
      } else if (!dice_.chance(0.1)) {
        add("limit = {}\n", moment(limit));
      }
    }
    note("{} actuators", actuators);
  }

  void tip_load(bool gravity) {
    const bool pulled = dice_.chance(0.25);
    const bool payload = gravity && dice_.chance(0.15);
    if (!pulled && !payload) return;
    add("[tip_load]\n");
    if (payload) {
      const double mass = dice_.log_between(1e-2, 1e2) * stiffness_ / (g * length_ * length_);
      add("mass = \"{:.17g} kg\"\n", mass);
      note("payload");
    }
    if (pulled) {
      const double alpha = dice_.log_between(1e-2, 1e3);
      const Vec2 to = direction(dice_.between(-pi, pi));
      add("force = [{}, {}]\n", force(alpha * to.x), force(alpha * to.y));
      note("tip force {:.2g}", alpha);
    }
  }

  void coordinates() {
    const double which = dice_.unit();
    std::string model;
    add("[coordinates]\n");
    const auto plugin = [&](const char* name, const std::string& options) {
      if (plugins_.count(name) > 0) {
        add("plugin = \"{}\"\n{}", name, options);
      } else {
        model = "default model";
      }
    };
    if (which < 0.6) {
      const int order = dice_.chance(0.1) ? dice_.whole(1, 32) : dice_.whole(2, 10);
      const int pieces = order > 12 ? 1 : dice_.chance(0.8) ? 1 : dice_.whole(2, 4);
      model = fmt::format("legendre {} x {}", order, pieces);
      plugin("legendre", fmt::format("order = {}\npieces = {}\n", order, pieces));
    } else if (which < 0.8) {
      model = "psc";
      plugin("psc", "");
    } else {
      const int pieces = dice_.chance(0.1) ? dice_.whole(11, 64) : dice_.whole(2, 10);
      model = fmt::format("pcc {}", pieces);
      plugin("pcc", fmt::format("pieces = {}\n", pieces));
    }
    const bool split = split_ = dice_.chance(0.8);
    if (!split) add("split_at_contact = false\n");
    note("{}{}", model, split ? "" : " not split");
  }

  /// An obstacle whose boundary passes near the rod's reach. All in L.
  Shape shape(int index) {
    Shape shape;
    const Vec2 surface = base_ + dice_.between(0.05, 1.1) * direction(base_angle_ + dice_.between(-1.6, 1.6));
    const Vec2 normal = direction(dice_.between(-pi, pi));
    const double radius = dice_.chance(0.25) ? dice_.log_between(1e-6, 1e4) : dice_.log_between(0.01, 0.5);
    const std::string head = fmt::format("[[obstacle]]\nname = \"o{}\"\n", index);
    const double kind = dice_.unit();
    if (kind < 0.45) {
      const Vec2 center = surface - radius * normal;
      shape.free_base = norm(center - base_) > radius * (1.0 + 1e-9);
      shape.text = head + fmt::format("shape = \"circle\"\ncenter = {}\nradius = {}\n", point(center), length(radius));
    } else if (kind < 0.65) {
      shape.free_base = dot(normal, base_ - surface) > 1e-9;
      shape.text = head + fmt::format("shape = \"wall\"\npoint = {}\nnormal = [{:.17g}, {:.17g}]\n", point(surface),
                                      normal.x, normal.y);
    } else if (kind < 0.85) {
      const double reach = dice_.log_between(0.02, 1.0);
      const Vec2 from = surface - radius * normal;
      const Vec2 to = from + reach * direction(dice_.between(-pi, pi));
      const Vec2 along = to - from;
      const double t = std::clamp(dot(base_ - from, along) / dot(along, along), 0.0, 1.0);
      shape.free_base = norm(base_ - from - t * along) > radius * (1.0 + 1e-9);
      shape.text = head + fmt::format("shape = \"capsule\"\nfrom = {}\nto = {}\nradius = {}\n", point(from), point(to),
                                      length(radius));
    } else {
      const int corners = dice_.whole(3, 6);
      const double size = dice_.log_between(0.03, 0.5);
      const double rounding = dice_.log_between(1e-3, 0.1);
      const Vec2 center = surface - (size + rounding) * normal;
      const double turn = dice_.between(0.0, 2.0 * pi);
      std::string vertices;
      for (int i = 0; i < corners; ++i) {
        const double angle = turn + 2.0 * pi * (i + dice_.between(-0.2, 0.2)) / corners;
        vertices += (i == 0 ? "" : ", ") + point(center + size * direction(angle));
      }
      shape.free_base = norm(center - base_) > size + rounding;
      shape.text =
          head + fmt::format("shape = \"polygon\"\nvertices = [{}]\nrounding = {}\n", vertices, length(rounding));
    }
    return shape;
  }

  /// Corners around `center` at angles that rise, the distances of every other one smaller.
  std::vector<Vec2> star(Vec2 center, double size, double smaller, int points) {
    std::vector<Vec2> corners;
    const double turn = dice_.between(0.0, 2.0 * pi);
    for (int i = 0; i < 2 * points; ++i) {
      const double angle = turn + pi * (i + dice_.between(-0.2, 0.2)) / points;
      const double reach = size * dice_.between(0.8, 1.0) * (i % 2 == 0 ? 1.0 : smaller);
      corners.push_back(center + reach * direction(angle));
    }
    return corners;
  }

  /// A bar of size 2 x 2 `half` with notches from above, each as deep as half of it.
  static std::vector<Vec2> comb(double half, int notches) {
    std::vector<Vec2> corners{{-1.0, -half}, {1.0, -half}, {1.0, half}};
    const double tooth = 2.0 / (2 * notches + 1);
    for (int i = 0; i < notches; ++i) {
      const double right = 1.0 - (2 * i + 1) * tooth;
      for (const Vec2 p : {Vec2{right, half}, Vec2{right, 0.0}, Vec2{right - tooth, 0.0}, Vec2{right - tooth, half}}) {
        corners.push_back(p);
      }
    }
    corners.push_back({-1.0, half});
    return corners;
  }

  std::string points_of(const std::vector<Vec2>& corners) const {
    std::string text;
    for (const Vec2 p : corners) text += (text.empty() ? "" : ", ") + point(p);
    return text;
  }

  /// A channel around the rod from its base on, or one beside it, whose walls are an obstacle as any other. All in L.
  Shape channel(int index, double rounding) {
    const bool around = dice_.chance(0.7);
    const double widest = dice_.between(0.1, 0.5);
    const double wall = dice_.between(0.1, 0.3);
    double heading = base_angle_ + (around ? 0.0 : dice_.between(-pi, pi));
    const Vec2 surface = base_ + dice_.between(0.3, 1.1) * direction(base_angle_ + dice_.between(-1.6, 1.6));
    std::vector<Vec2> line{around ? base_ - 0.1 * direction(heading) : surface};
    std::string widths;
    const int points = dice_.whole(2, 6);
    for (int i = 0; i < points; ++i) {
      widths += (i == 0 ? "" : ", ") + length(widest * dice_.between(0.5, 1.0));
      if (i == 0) continue;
      line.push_back(line.back() + dice_.between(0.2, 0.5) * direction(heading));
      heading += dice_.between(-1.0, 1.0);
    }
    static constexpr std::array<const char*, 4> ends{"none", "start", "end", "both"};
    const char* closed = ends[static_cast<std::size_t>(dice_.whole(0, 3))];
    const std::string width = dice_.chance(0.5) ? fmt::format("widths = [{}]", widths) : "width = " + length(widest);
    Shape shape;
    // A rod that stands outside of every channel is refused.
    in_channel_ = in_channel_ || around;
    shape.free_base = in_channel_;
    for (std::size_t i = 0; i + 1 < line.size() && !around; ++i) {
      const Vec2 along = line[i + 1] - line[i];
      const double t = std::clamp(dot(base_ - line[i], along) / dot(along, along), 0.0, 1.0);
      // Corners reach out farther than half of the width and the wall.
      if (norm(base_ - line[i] - t * along) < widest + 2.0 * wall) shape.free_base = false;
    }
    shape.text = fmt::format(
        "[[obstacle]]\nname = \"o{}\"\nshape = \"channel\"\npoints = [{}]\n{}\nwall = {}\nrounding = {}\nclosed = "
        "\"{}\"\n",
        index, points_of(line), width, length(wall), length(rounding), closed);
    return shape;
  }

  /// A polygon that is not convex, or a channel, near the rod's reach or around all of it. All in L.
  Shape outline(int index) {
    Shape shape;
    const double rounding = dice_.log_between(1e-3, 0.03);
    const double kind = dice_.unit();
    const double size = dice_.log_between(0.05, 0.5);
    const Vec2 surface = base_ + dice_.between(0.05, 1.1) * direction(base_angle_ + dice_.between(-1.6, 1.6));
    const double turn = dice_.between(-pi, pi);
    const Vec2 center = surface - (size + rounding) * direction(turn);
    std::string sizes;
    std::vector<Vec2> corners;
    shape.free_base = norm(center - base_) > 1.5 * size + rounding;
    if (kind > 0.7) return channel(index, rounding);
    if (kind < 0.25) {
      corners = star(center, size, dice_.between(0.35, 0.7), dice_.whole(3, 6));
    } else if (kind < 0.5) {
      const double half = dice_.between(0.2, 0.6);
      for (const Vec2 p : comb(half, dice_.whole(1, 3)))
        corners.push_back(center + size * (p.x * direction(turn) + p.y * turned(direction(turn))));
    } else {
      // A room with walls that stand in: its hole runs clockwise.
      const double far = 2.0;
      corners = {base_ + Vec2{-far, -far}, base_ + Vec2{far, -far}, base_ + Vec2{far, far}, base_ + Vec2{-far, far}};
      std::vector<Vec2> room = star(base_, 1.3, dice_.between(0.3, 0.7), dice_.whole(3, 6));
      std::reverse(room.begin(), room.end());
      corners.insert(corners.end(), room.begin(), room.end());
      sizes = fmt::format("outlines = [4, {}]\n", room.size());
      shape.free_base = true;
    }
    shape.text = fmt::format("[[obstacle]]\nname = \"o{}\"\nshape = \"polygon\"\nvertices = [{}]\n{}rounding = {}\n",
                             index, points_of(corners), sizes, length(rounding));
    return shape;
  }

  void obstacles() {
    const double many = dice_.unit();
    obstacles_ = many < 0.15 ? 0 : many < 0.65 ? 1 : many < 0.9 ? 2 : dice_.whole(3, 5);
    for (int i = 0; i < obstacles_; ++i) {
      // No rod is free of an obstacle around its base, so such a scene is refused; it is drawn again.
      Shape drawn = outlines_ ? outline(i + 1) : shape(i + 1);
      while (!drawn.free_base) drawn = outlines_ ? outline(i + 1) : shape(i + 1);
      body_ += drawn.text;
    }
    note("{} obstacles", obstacles_);
  }

  void contact() {
    if (obstacles_ == 0) return;
    add("[contact]\n");
    const double which = dice_.unit();
    const char* mode = which < 0.6 ? "allow" : which < 0.75 ? "avoid" : which < 0.9 ? "require" : "ignore";
    allowed_ = which < 0.6;
    required_ = which >= 0.75 && which < 0.9;
    add("mode = \"{}\"\n", mode);
    note("{}", mode);
    if (required_) add("min_force = {}\n", force(dice_.log_between(1e-2, 3.0)));
    limited_ = (allowed_ || required_) && dice_.chance(0.7);
    if (limited_)
      add("max_force = {}\n", force(dice_.chance(0.2) ? dice_.log_between(5.0, 1e4) : dice_.between(5.0, 50.0)));
    // What is not convex may be touched in several places.
    const int most = outlines_ && obstacles_ > 0 ? 3 : std::min(3, obstacles_);
    if ((allowed_ || required_) && most > 1 && dice_.chance(0.5)) {
      const int count = dice_.whole(2, most);
      add("count = {}\n", count);
      note("count {}", count);
    }
    if (dice_.chance(0.3)) {
      static constexpr std::array<const char*, 3> treatments{"slack", "scholtes", "fischer_burmeister"};
      const char* treatment = treatments[static_cast<std::size_t>(dice_.whole(0, 2))];
      add("treatment = \"{}\"\n", treatment);
      note("{}", treatment);
    }
    if (friction_ && (allowed_ || required_)) friction();
  }

  void friction() {
    Dice& dice = friction_dice_;
    const double coefficient = dice.chance(0.3) ? dice.log_between(1e-6, 10.0) : dice.between(0.05, 0.8);
    const double which = dice.unit();
    const char* state = which < 0.4 || !split_ ? "range" : which < 0.7 ? "worst" : "any";
    add("friction = {:.17g}\nfriction_state = \"{}\"\n", coefficient, state);
    note("friction {:.2g} {}", coefficient, state);
  }

  void target() {
    add("[target]\n");
    Vec2 wanted{};
    if (dice_.chance(0.05)) {
      wanted = dice_.log_between(2.0, 1e3) * direction(dice_.between(-pi, pi));
      note("far target");
    } else if (dice_.chance(0.5)) {
      // Where a rod of constant curvature ends.
      const double m = dice_.sign() * dice_.log_between(0.05, 6.0);
      const Vec2 along = direction(base_angle_);
      wanted = (std::sin(m) / m) * along + ((1.0 - std::cos(m)) / m) * turned(along);
    } else {
      wanted = std::sqrt(dice_.unit()) * direction(base_angle_ + dice_.between(-2.0, 2.0));
    }
    const double which = dice_.unit();
    if (which > 0.05) add("position = {}\n", point(base_ + wanted));
    if (which < 0.25) add("angle = {:.17g}\n", dice_.between(-pi, pi));
  }

  void objectives() {
    const bool wild = dice_.chance(0.05);
    const auto weight = [&](double low, double high) {
      return wild ? dice_.log_between(1e-12, 1e12) : dice_.log_between(low, high);
    };
    const bool idle = dice_.chance(0.02);
    const auto term = [&](const char* plugin, double factor) {
      if (plugins_.count(plugin) == 0) return;
      add("[[objective]]\nplugin = \"{}\"\nweight = {:.17g}\n", plugin, idle ? 0.0 : factor);
    };
    term("tip_pose", weight(1.0, 1e3));
    if (dice_.chance(0.03)) term("tip_pose", weight(1.0, 1e3));
    term("actuation_effort", weight(1e-6, 1e-2));
    if (idle) note("no weight");
    if (wild) note("wild weights");
    // Without a limit a reward of force has no least value.
    if ((allowed_ || required_) && limited_ && dice_.chance(0.05)) {
      term("contact_force", weight(1e-4, 1e-2));
      note("force rewarded");
    }
    if ((allowed_ || required_) && dice_.chance(0.05)) {
      term("contact_proximity", weight(0.01, 1.0));
      note("proximity");
    }
  }

  Dice dice_;
  Dice friction_dice_;  ///< of its own, so that all else is drawn as without
  std::string solver_;
  double time_limit_;
  const std::set<std::string>& plugins_;
  bool outlines_;
  bool friction_;
  bool split_ = true;
  UnitSystem units_{};
  double length_ = 1.0, stiffness_ = 1.0;
  Vec2 base_{};
  double base_angle_ = 0.0;
  int obstacles_ = 0;
  bool in_channel_ = false;  ///< the base stands in a channel
  bool allowed_ = false, required_ = false, limited_ = false;
  std::string head_, body_, summary_;
};

}  // namespace

RandomScene random_scene(std::uint64_t seed, const std::string& solver, double time_limit,
                         const std::set<std::string>& plugins, bool outlines, bool friction) {
  return Drawer(seed, solver, time_limit, plugins, outlines, friction).draw();
}

}  // namespace tendril::bench
