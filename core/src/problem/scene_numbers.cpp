#include "problem/scene_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "obstacle/shape_options.hpp"
#include "scene/make_rod.hpp"
#include "tendril/pivot.hpp"

namespace tendril {
namespace {

constexpr const char* moves_a_knot = "pieces of the rod begin or end there, by which nothing is differentiated";

/// The numbers of a rod, all of which scale with powers of length and force.
template <class Visit>
void each_number(Rod& rod, Visit visit) {
  constexpr Dimension per_length{-1, 1, "N/m"};
  for (Rod::Segment& s : rod.segments) {
    const auto along = [&](double& first, std::vector<double>& more, const Dimension& d) {
      visit(first, d);
      for (double& c : more) visit(c, d);
    };
    along(s.stiffness, s.more_stiffness, dimension::stiffness);
    along(s.weight, s.more_weight, per_length);
    along(s.rest_curvature, s.more_rest_curvature, dimension::curvature);
    along(s.radius, s.more_radius, dimension::length);
  }
  for (Rod::Load& l : rod.loads) {
    const Dimension& unit = l.at_point() ? dimension::force : per_length;
    visit(l.force.x, unit);
    visit(l.force.y, unit);
    visit(l.weight, dimension::force);
  }
  visit(rod.payload, dimension::force);
  visit(rod.tip_force.x, dimension::force);
  visit(rod.tip_force.y, dimension::force);
}

/// Relative rate of a unit.
double unit_rate(const SceneChange& c, const Dimension& d) {
  return d.length * c.length + d.force * (c.stiffness - 2.0 * c.length);
}

/// What a scene was made into, borrowed.
struct Setting {
  const Scene& scene;
  const Scale& scale;
  const Rod& rod;
  /// What the units L and EI0 do to a program's numbers.
  void follow_units(SceneChange& c) const;
};

/// Collects entries of one scene.
class Collector {
 public:
  /// `keys`: of the numbers that are asked for; empty: all.
  explicit Collector(const Setting& setting, std::vector<std::string> keys = {})
      : setting_(setting), keys_(std::move(keys)), scene_(setting.scene), scale_(setting.scale), rod_(setting.rod) {}

  std::vector<SceneEntry> collect();
  SceneEntry held_moment(int actuator, double moment);

 private:
  using Place = std::function<double&(Scene&)>;  ///< of a number in a scene

  /// Whether a key is asked for that begins so.
  bool asks_for(std::string_view begin) const {
    return keys_.empty() ||
           std::any_of(keys_.begin(), keys_.end(), [&](const std::string& key) { return key.starts_with(begin); });
  }
  void add(std::string key, double value, const Dimension& dimension, std::function<void(SceneChange&)> change) {
    if (!asks_for(key)) return;
    entries_.push_back(
        {{std::move(key), value, std::string(dimension.unit)}, [setting = setting_, change = std::move(change)] {
           SceneChange c;
           change(c);
           setting.follow_units(c);
           return c;
         }});
  }
  /// `stiffness`: relative rate of EI0.
  void add_rod_number(const std::string& key, const Place& place, const Dimension& dimension, double unit,
                      double stiffness = 0.0);
  void add_refused(const std::string& key, double value, const Dimension& dimension, const char* why) {
    add(key, value, dimension, [why](SceneChange& c) { c.trouble = why; });
  }
  void add_gravity();
  void add_segments();
  void add_actuators();
  void add_loads();
  void add_base();
  void add_obstacles();
  /// A number that moves an obstacle.
  void add_motion(const std::string& key, double value, const Dimension& dimension, int obstacle, const Motion& motion);
  void add_obstacle(int index);
  void add_contact_and_target();
  bool only_whole_spans() const;
  Motion shifted(int axis) const { return {(1.0 / scale_.length) * (axis == 0 ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0})}; }
  std::optional<Motion> obstacle_motion(const std::string& shape, const Options& options, const std::string& name,
                                        int column) const;

  Setting setting_;
  std::vector<std::string> keys_;
  const Scene& scene_;
  const Scale& scale_;
  const Rod& rod_;
  std::vector<SceneEntry> entries_{};
};

void Setting::follow_units(SceneChange& c) const {
  if (c.length == 0.0 && c.stiffness == 0.0) return;
  SceneChange units;
  units.length = c.length;
  units.stiffness = c.stiffness;
  c.rod = [own = c.rod, step = c.step, units, &rod = rod](double share) {
    Rod changed = own ? own(share) : rod;
    std::vector<double> at_first;
    Rod unchanged = rod;
    each_number(unchanged, [&](double& v, const Dimension&) { at_first.push_back(v); });
    auto next = at_first.begin();
    each_number(changed, [&](double& v, const Dimension& d) { v -= share * step * unit_rate(units, d) * *next++; });
    return changed;
  };
  c.lowest.resize(rod.actuators.size());
  c.highest.resize(rod.actuators.size());
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    const double rate = unit_rate(c, dimension::moment);
    if (std::isfinite(rod.actuators[a].minimum)) c.lowest[a] -= rate * rod.actuators[a].minimum;
    if (std::isfinite(rod.actuators[a].maximum)) c.highest[a] -= rate * rod.actuators[a].maximum;
  }
  const auto force = [&](double si) {
    return std::isfinite(si) ? unit_rate(c, dimension::force) * si / scale.force() : 0.0;
  };
  c.least_force -= force(scene.contact.min_force);
  c.most_force -= force(scene.contact.max_force);
  if (c.length == 0.0) return;
  c.moves = true;
  c.motion.base.shift += -c.length * rod.base;
  c.motion.obstacles.resize(scene.obstacles.size());
  for (Motion& obstacle : c.motion.obstacles) obstacle.stretch -= c.length;
  if (scene.target.position) c.target += (-c.length / scale.length) * *scene.target.position;
}

void Collector::add_rod_number(const std::string& key, const Place& place, const Dimension& dimension, double unit,
                               double stiffness) {
  if (!asks_for(key)) return;
  Scene scene = scene_;
  const double value = place(scene);
  const double step = value != 0.0 ? std::abs(value) : unit;
  add(key, value, dimension, [&scene = scene_, &scale = scale_, place, step, stiffness](SceneChange& c) {
    c.step = step;
    c.stiffness = stiffness;
    c.rod = [&scene, &scale, place, step](double share) {
      Scene changed = scene;
      place(changed) += share * step;
      return make_rod(changed, scale);
    };
  });
}

void Collector::add_gravity() {
  if (!scene_.gravity) return;
  const double size = norm(*scene_.gravity);
  constexpr Dimension acceleration{0, 0, "m/s^2"};
  for (const int axis : {0, 1}) {
    const std::string key = "gravity[" + std::to_string(axis) + "]";
    const double value = axis == 0 ? scene_.gravity->x : scene_.gravity->y;
    if (size == 0.0) {
      add_refused(key, value, acceleration, "gravity is zero, and so is every weight in the program");
      continue;
    }
    add(key, value, acceleration, [&rod = rod_, size, axis](SceneChange& c) {
      c.step = size;
      c.rod = [&rod, axis](double share) {
        Rod changed = rod;
        (axis == 0 ? changed.gravity.x : changed.gravity.y) += share;
        return changed;
      };
    });
  }
}

bool Collector::only_whole_spans() const {
  const double length = scene_.rod.length();
  const auto at_end = [&](double s) { return s == 0.0 || s == length; };
  const RodSpec& rod = scene_.rod;
  return rod.segments.size() == 1 &&
         std::all_of(rod.actuators.begin(), rod.actuators.end(),
                     [&](const ActuatorSpec& a) {
                       return a.from == 0.0 && a.to == length &&
                              std::all_of(a.offset.begin(), a.offset.end(),
                                          [&](const OffsetPoint& p) { return at_end(p.arc_length); });
                     }) &&
         std::all_of(rod.loads.begin(), rod.loads.end(),
                     [&](const RodLoadSpec& l) { return at_end(l.from) && at_end(l.to); });
}

void Collector::add_segments() {
  constexpr Dimension linear_density{0, 0, "kg/m"};
  const double g = scene_.gravity ? norm(*scene_.gravity) : 0.0;
  const double stiffness = scale_.stiffness;
  const double length = scale_.length;
  const bool one = scene_.rod.segments.size() == 1;
  for (std::size_t i = 0; i < scene_.rod.segments.size(); ++i) {
    const std::string key = one ? "rod." : "rod.segment[" + std::to_string(i) + "].";
    const SegmentSpec& segment = scene_.rod.segments[i];
    if (only_whole_spans()) {
      add(key + "length", segment.length, dimension::length, [length](SceneChange& c) { c.length = 1.0 / length; });
    } else {
      add_refused(key + "length", segment.length, dimension::length, moves_a_knot);
    }
    const auto along = [&](const char* name, double SegmentSpec::*first, std::vector<double> SegmentSpec::*more,
                           const Dimension& d, double unit) {
      // That of the first one is the unit of stiffness as well.
      const bool is_unit = i == 0 && first == &SegmentSpec::bending_stiffness;
      add_rod_number(
          key + name, [i, first](Scene& s) -> double& { return s.rod.segments[i].*first; }, d, unit,
          is_unit ? 1.0 / stiffness : 0.0);
      for (std::size_t k = 0; k < (segment.*more).size(); ++k) {
        add_rod_number(
            key + "more_" + name + "[" + std::to_string(k) + "]",
            [i, more, k](Scene& s) -> double& { return (s.rod.segments[i].*more)[k]; }, d, unit);
      }
    };
    along("bending_stiffness", &SegmentSpec::bending_stiffness, &SegmentSpec::more_bending_stiffness,
          dimension::stiffness, stiffness);
    along("linear_density", &SegmentSpec::linear_density, &SegmentSpec::more_linear_density, linear_density,
          g > 0.0 ? scale_.force() / (length * g) : 1.0);
    along("rest_curvature", &SegmentSpec::rest_curvature, &SegmentSpec::more_rest_curvature, dimension::curvature,
          1.0 / length);
    along("thickness", &SegmentSpec::thickness, &SegmentSpec::more_thickness, dimension::length, length);
  }
}

void Collector::add_actuators() {
  for (std::size_t i = 0; i < scene_.rod.actuators.size(); ++i) {
    const ActuatorSpec& actuator = scene_.rod.actuators[i];
    const std::string key = "rod.actuator[" + std::to_string(i) + "].";
    const auto limit = [&](const char* name, double value, std::vector<double> SceneChange::*side) {
      if (!std::isfinite(value)) return;
      add(key + name, value, dimension::moment,
          [i, side, count = scene_.rod.actuators.size(), unit = scale_.moment()](SceneChange& c) {
            (c.*side).assign(count, 0.0);
            (c.*side)[i] = 1.0 / unit;
          });
    };
    limit("minimum", actuator.minimum, &SceneChange::lowest);
    limit("maximum", actuator.maximum, &SceneChange::highest);
    if (actuator.from != 0.0) add_refused(key + "from", actuator.from, dimension::length, moves_a_knot);
    if (actuator.to != scene_.rod.length()) add_refused(key + "to", actuator.to, dimension::length, moves_a_knot);
  }
}

void Collector::add_loads() {
  constexpr Dimension mass{0, 0, "kg"};
  constexpr Dimension per_length{-1, 1, "N/m"};
  const double g = scene_.gravity ? norm(*scene_.gravity) : 0.0;
  const double mass_unit = g > 0.0 ? scale_.force() / g : 1.0;
  for (std::size_t i = 0; i < scene_.rod.loads.size(); ++i) {
    const RodLoadSpec& load = scene_.rod.loads[i];
    const std::string key = "rod.load[" + std::to_string(i) + "].";
    const bool point = load.from == load.to;
    const std::string force = key + (point ? "force" : "force_per_length");
    add_rod_number(
        force + "[0]", [i](Scene& s) -> double& { return s.rod.loads[i].force.x; },
        point ? dimension::force : per_length, scale_.force() / (point ? 1.0 : scale_.length));
    add_rod_number(
        force + "[1]", [i](Scene& s) -> double& { return s.rod.loads[i].force.y; },
        point ? dimension::force : per_length, scale_.force() / (point ? 1.0 : scale_.length));
    if (point) {
      add_rod_number(
          key + "mass", [i](Scene& s) -> double& { return s.rod.loads[i].mass; }, mass, mass_unit);
      add_refused(key + "at", load.from, dimension::length, moves_a_knot);
    } else {
      add_refused(key + "from", load.from, dimension::length, moves_a_knot);
      add_refused(key + "to", load.to, dimension::length, moves_a_knot);
    }
  }
  add_rod_number(
      "tip_load.mass", [](Scene& s) -> double& { return s.tip_load.mass; }, mass, mass_unit);
  add_rod_number(
      "tip_load.force[0]", [](Scene& s) -> double& { return s.tip_load.force.x; }, dimension::force, scale_.force());
  add_rod_number(
      "tip_load.force[1]", [](Scene& s) -> double& { return s.tip_load.force.y; }, dimension::force, scale_.force());
}

void Collector::add_base() {
  for (const int axis : {0, 1}) {
    add("rod.base.position[" + std::to_string(axis) + "]",
        axis == 0 ? scene_.rod.base_position.x : scene_.rod.base_position.y, dimension::length,
        [motion = shifted(axis)](SceneChange& c) {
          c.moves = true;
          c.motion.base = motion;
        });
  }
  // Seen from the base dead loads turn back.
  add("rod.base.angle", scene_.rod.base_angle, dimension::angle, [&rod = rod_](SceneChange& c) {
    c.moves = true;
    c.motion.base = turn_about(rod.base, 1.0);
    c.rod = [&rod](double share) {
      Rod changed = rod;
      const auto turn_back = [share](Vec2& force) { force += -share * turned(force); };
      turn_back(changed.gravity);
      turn_back(changed.tip_force);
      for (Rod::Load& l : changed.loads) turn_back(l.force);
      return changed;
    };
  });
}

std::optional<Component<Obstacle>> builtin_shape(const std::string& name) {
  for (Component<Obstacle> component :
       {circle_component(), wall_component(), capsule_component(), polygon_component(), channel_component()}) {
    if (component.name == name) return component;
  }
  return std::nullopt;
}

std::optional<Motion> Collector::obstacle_motion(const std::string& shape, const Options& options,
                                                 const std::string& name, int column) const {
  if ((shape == "circle" && name == "center") || (shape == "wall" && name == "point")) return shifted(column);
  if ((shape != "channel" && name == "rounding") || name == "radius") {
    return Motion{{}, 0.0, 0.0, 1.0 / scale_.length};
  }
  if (shape != "wall") return std::nullopt;
  const Vec2 point = (1.0 / scale_.length) * point_of(options, "point");
  if (name == "angle") return turn_about(point, 1.0);
  const Vec2 normal = point_of(options, "normal");
  const double square = dot(normal, normal);
  return turn_about(point, (column == 0 ? -normal.y : normal.x) / square);
}

void Collector::add_motion(const std::string& key, double value, const Dimension& dimension, int obstacle,
                           const Motion& motion) {
  add(key, value, dimension, [obstacle, motion, count = scene_.obstacles.size()](SceneChange& c) {
    c.moves = true;
    c.motion.obstacles.resize(count);
    c.motion.obstacles[static_cast<std::size_t>(obstacle)] = motion;
  });
}

void Collector::add_obstacle(int index) {
  if (!asks_for("obstacle[" + std::to_string(index) + ']')) return;
  const ObstacleSpec& spec = scene_.obstacles[static_cast<std::size_t>(index)];
  const std::optional<Component<Obstacle>> component = builtin_shape(spec.shape);
  if (!component) return;
  Options options;
  try {
    RawOptions own = spec.options;
    own.erase(pivot_option().name);
    options = resolve_options(component->options, own, Scale{}, scene_.read_quantity, spec.shape);
  } catch (const OptionError&) {
    return;  // told by whoever makes the obstacle
  }
  const auto add_number = [&](const OptionSpec& option, const std::string& key, double value, int column) {
    // How far out the surface is has nothing to do with where the obstacle is.
    const bool elsewhere = spec.place.moves() && option.name != "radius" && option.name != "rounding";
    if (elsewhere) {
      return add_refused(key, value, option.dimension,
                         "of an obstacle that was moved only its shift is differentiated");
    }
    const std::optional<Motion> motion = obstacle_motion(spec.shape, options, option.name, column);
    if (!motion) {
      return add_refused(key, value, option.dimension, "by corners of a shape nothing is differentiated");
    }
    add_motion(key, value, option.dimension, index, *motion);
  };
  for (int axis = 0; axis < 2 && spec.place.moves(); ++axis) {
    add_motion("obstacle[" + std::to_string(index) + "].shift[" + std::to_string(axis) + "]",
               axis == 0 ? spec.place.shift.x : spec.place.shift.y, dimension::length, index, shifted(axis));
  }
  for (const OptionSpec& option : component->options) {
    if (!options.has(option.name)) continue;
    const std::string key = "obstacle[" + std::to_string(index) + "]." + option.name;
    if (option.type == OptionType::real) add_number(option, key, options.real(option.name), 0);
    if (option.type != OptionType::list && option.type != OptionType::points) continue;
    const NumberTable& table = options.table(option.name);
    for (int r = 0; r < table.rows; ++r) {
      const std::string row = option.type == OptionType::points ? key + "[" + std::to_string(r) + "]" : key;
      for (int k = 0; k < table.columns; ++k) {
        if (option.name != "outlines") add_number(option, row + "[" + std::to_string(k) + "]", table(r, k), k);
      }
    }
  }
}

void Collector::add_obstacles() {
  for (int i = 0; i < static_cast<int>(scene_.obstacles.size()); ++i) add_obstacle(i);
}

void Collector::add_contact_and_target() {
  const auto force = [&](const char* key, double value, double SceneChange::*side) {
    if (!std::isfinite(value)) return;
    add(key, value, dimension::force, [side, unit = scale_.force()](SceneChange& c) { c.*side = 1.0 / unit; });
  };
  force("contact.min_force", scene_.contact.min_force, &SceneChange::least_force);
  force("contact.max_force", scene_.contact.max_force, &SceneChange::most_force);
  if (scene_.target.position) {
    for (const int axis : {0, 1}) {
      add("target.position[" + std::to_string(axis) + "]",
          axis == 0 ? scene_.target.position->x : scene_.target.position->y, dimension::length,
          [rate = shifted(axis).shift](SceneChange& c) { c.target = rate; });
    }
  }
  if (scene_.target.angle) {
    add("target.angle", *scene_.target.angle, dimension::angle, [](SceneChange& c) { c.target_angle = 1.0; });
  }
  for (std::size_t i = 0; i < scene_.objectives.size(); ++i) {
    if (!needs_term(scene_.objectives[i])) continue;
    add("objective[" + std::to_string(i) + "].weight", scene_.objectives[i].weight, dimension::none,
        [i](SceneChange& c) { c.objective = static_cast<int>(i); });
  }
}

std::vector<SceneEntry> Collector::collect() {
  add_gravity();
  add_segments();
  add_actuators();
  add_loads();
  add_base();
  add_obstacles();
  add_contact_and_target();
  return std::move(entries_);
}

SceneEntry Collector::held_moment(int actuator, double moment) {
  add("moments[" + std::to_string(actuator) + "]", moment, dimension::moment,
      [actuator, unit = scale_.moment()](SceneChange& c) {
        c.actuator = actuator;
        c.held = 1.0 / unit;
      });
  return std::move(entries_.back());
}

}  // namespace

std::vector<SceneEntry> scene_entries(const Scene& scene, const Scale& scale, const Rod& rod,
                                      const std::vector<std::string>& keys) {
  return Collector({scene, scale, rod}, keys).collect();
}

SceneEntry held_moment(const Scene& scene, const Scale& scale, const Rod& rod, int actuator, double moment) {
  return Collector({scene, scale, rod}).held_moment(actuator, moment);
}

std::vector<SceneNumber> scene_numbers(const Scene& scene) {
  const Scale scale = scale_of(scene);
  const Rod rod = make_rod(scene, scale);
  std::vector<SceneNumber> numbers;
  for (SceneEntry& entry : scene_entries(scene, scale, rod, {})) numbers.push_back(std::move(entry.number));
  return numbers;
}

}  // namespace tendril
