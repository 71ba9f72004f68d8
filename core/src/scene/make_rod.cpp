#include "scene/make_rod.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "obstacle/room.hpp"
#include "scene/plan_report.hpp"
#include "tendril/error.hpp"

namespace tendril {

namespace {

/// The offset of a tendon between its ends, over its largest one; none where it is the same all along.
std::vector<ProfilePart> profile_of(const ActuatorSpec& spec, const Rod::Actuator& actuator, const Scale& scale) {
  std::vector<ProfilePart> profile;
  const double largest = spec.largest_offset();
  for (std::size_t i = 0; i + 1 < spec.offset.size(); ++i) {
    const auto arc_length = [&](std::size_t p) {
      return std::clamp(scale.to_dimensionless(spec.offset[p].arc_length, dimension::length), actuator.from,
                        actuator.to);
    };
    const double from = arc_length(i);
    const double to = i + 2 == spec.offset.size() ? actuator.to : arc_length(i + 1);
    const double first = round_to_12_digits(spec.offset[i].offset / largest);
    const double last = round_to_12_digits(spec.offset[i + 1].offset / largest);
    profile.push_back({from, to, {first, (last - first) / (to - from)}});
  }
  return profile;
}

/// What may be moved of the rod as a whole.
void add_moves(const RodSpec& spec, const Scale& scale, Rod& rod) {
  using Kind = Rod::Move::Kind;
  const auto length = [&](double metres) { return scale.to_dimensionless(metres, dimension::length); };
  const Vec2 base = spec.base_position;
  if (spec.base_position_range) {
    const auto [low, high] = *spec.base_position_range;
    if (low.x < high.x) rod.moves.push_back({Kind::shift, {1.0, 0.0}, length(low.x - base.x), length(high.x - base.x)});
    if (low.y < high.y) rod.moves.push_back({Kind::shift, {0.0, 1.0}, length(low.y - base.y), length(high.y - base.y)});
  }
  if (spec.base_angle_range && spec.base_angle_range->first < spec.base_angle_range->second) {
    const auto [low, high] = *spec.base_angle_range;
    rod.moves.push_back({Kind::turn, {}, round_to_12_digits(low), round_to_12_digits(high), rod.base_angle});
  }
  if (spec.most_drawn_in == 0.0) return;
  rod.moves.push_back({Kind::draw, {}, 0.0, length(spec.most_drawn_in), length(spec.drawn_in)});
}

/// A pressure pushes along the rod with the moment that it gives, or by a law of its own.
void add_pull(const ActuatorSpec& spec, const Scale& scale, Rod::Actuator& a) {
  if (spec.force_per_pressure.empty()) return;
  if (spec.pulls_in_proportion()) {
    // Of equal coefficients any tells the proportion; without a linear one the pressure that gives most.
    const double moment = spec.moment_per_pressure != 0.0
                              ? spec.moment_per_pressure
                              : spec.moment_of(spec.most_pressure > 0.0 ? spec.most_pressure : spec.least_pressure);
    const double force = spec.moment_per_pressure != 0.0 ? spec.force_per_pressure.front() : spec.pull_of(moment).force;
    a.thrust = round_to_12_digits(scale.length * force / moment);
    return;
  }
  a.pull = [spec, scale](double u) {
    const ActuatorSpec::Pull pull = spec.pull_of(u * scale.moment());
    return Rod::Jet{pull.force / scale.force(), pull.slope * scale.length, pull.bend * scale.stiffness};
  };
}

}  // namespace

Rod make_rod(const Scene& scene, const Scale& scale) {
  Rod rod;
  rod.segments.clear();
  const double length = scene.rod.length();
  const double g = scene.gravity ? norm(*scene.gravity) : 0.0;
  // Forces per length come in EI0/L^3; weights are rounded like every other datum.
  constexpr Dimension per_length{-1, 1, "N/m"};
  double from = 0.0;
  for (const SegmentSpec& spec : scene.rod.segments) {
    Rod::Segment s;
    s.from = from;
    s.to = round_to_12_digits(from + spec.length / length);
    s.stiffness = round_to_12_digits(spec.bending_stiffness / scale.stiffness);
    s.weight = scale.to_dimensionless(spec.linear_density * g, per_length);
    s.radius = scale.to_dimensionless(0.5 * spec.thickness, dimension::length);
    s.rest_curvature = scale.to_dimensionless(spec.rest_curvature, dimension::curvature);
    s.torsion = round_to_12_digits(spec.torsional_stiffness / spec.bending_stiffness);
    if (spec.out_of_plane_stiffness > 0.0) {
      s.across = round_to_12_digits(spec.out_of_plane_stiffness / spec.bending_stiffness);
    }
    const auto along = [](const std::vector<double>& more, std::vector<double>& out, auto dimensionless) {
      for (const double c : more) out.push_back(dimensionless(c));
    };
    if (scene.coordinates.stretch_order > 0) {
      s.axial = scale.to_dimensionless(spec.axial_stiffness, dimension::force);
      along(spec.more_axial_stiffness, s.more_axial,
            [&](double c) { return scale.to_dimensionless(c, dimension::force); });
    }
    along(spec.more_bending_stiffness, s.more_stiffness,
          [&](double c) { return round_to_12_digits(c / scale.stiffness); });
    along(spec.more_linear_density, s.more_weight, [&](double c) { return scale.to_dimensionless(c * g, per_length); });
    along(spec.more_rest_curvature, s.more_rest_curvature,
          [&](double c) { return scale.to_dimensionless(c, dimension::curvature); });
    along(spec.more_thickness, s.more_radius,
          [&](double c) { return scale.to_dimensionless(0.5 * c, dimension::length); });
    rod.segments.push_back(s);
    from = s.to;
  }
  rod.segments.back().to = 1.0;
  rod.stretch_order = scene.coordinates.stretch_order;
  rod.guided = scene.guided_in_plane;
  for (const ActuatorSpec& spec : scene.rod.actuators) {
    Rod::Actuator a;
    a.from = scale.to_dimensionless(spec.from, dimension::length);
    a.to = std::min(1.0, scale.to_dimensionless(spec.to, dimension::length));
    a.minimum = scale.to_dimensionless(spec.minimum, dimension::moment);
    a.maximum = scale.to_dimensionless(spec.maximum, dimension::moment);
    a.profile = profile_of(spec, a, scale);
    // A tendon pulls along the rod what it bends over its offset.
    if (spec.kind == ActuatorKind::tendon) a.thrust = -round_to_12_digits(length / spec.largest_offset());
    a.offset = round_to_12_digits(spec.largest_offset() / length);
    a.by_length = spec.by_length;
    if (spec.by_length) {
      const double offset = std::abs(spec.largest_offset());
      a.least_shortening = round_to_12_digits(spec.least_shortening / offset);
      a.most_shortening = round_to_12_digits(spec.most_shortening / offset);
    }
    add_pull(spec, scale, a);
    rod.actuators.push_back(std::move(a));
  }
  rod.base = {scale.to_dimensionless(scene.rod.base_position.x, dimension::length),
              scale.to_dimensionless(scene.rod.base_position.y, dimension::length)};
  rod.base_angle = round_to_12_digits(scene.rod.base_angle);
  if (g > 0.0) rod.gravity = {round_to_12_digits(scene.gravity->x / g), round_to_12_digits(scene.gravity->y / g)};
  for (const RodLoadSpec& spec : scene.rod.loads) {
    Rod::Load l;
    l.from = std::min(1.0, scale.to_dimensionless(spec.from, dimension::length));
    l.to = std::min(1.0, scale.to_dimensionless(spec.to, dimension::length));
    const Dimension& unit = l.at_point() ? dimension::force : per_length;
    l.force = {scale.to_dimensionless(spec.force.x, unit), scale.to_dimensionless(spec.force.y, unit)};
    l.weight = scale.to_dimensionless(spec.mass * g, dimension::force);
    rod.loads.push_back(l);
  }
  rod.payload = scale.to_dimensionless(scene.tip_load.mass * g, dimension::force);
  rod.tip_force = {scale.to_dimensionless(scene.tip_load.force.x, dimension::force),
                   scale.to_dimensionless(scene.tip_load.force.y, dimension::force)};
  add_moves(scene.rod, scale, rod);
  return rod;
}

void require_free_base(const Scene& scene, const Rod& rod, const std::vector<const Obstacle*>& obstacles,
                       const Scale& scale) {
  if (!rod.moves.empty()) return;
  const std::vector<std::string> names = obstacle_names(scene);
  const auto refuse = [&](std::size_t i, const std::string& where, double depth, const std::string& why) {
    throw SceneError("obstacle[" + std::to_string(i) + "]",
                     names[i] + where + " (" + shown(scale.to_si(depth, dimension::length)) + " m deep): " + why);
  };
  double least = infinity;
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const double depth = rod.radius_at(0.0).value - obstacles[i]->at(rod.base).distance;
    if (!(depth <= 0.0)) refuse(i, " lies around the rod's base", depth, "no shape is free of it");
    const double outside = outside_room(*obstacles[i], rod.base);
    if (outside < least) nearest = i;
    least = std::min(least, outside);
  }
  if (least > 0.0 && least < infinity) {
    refuse(nearest, " holds no room for the rod's base, which lies outside of it", least,
           "its wall is in between, expected a base in the channel or in front of an open end");
  }
}

void let_base_move(Rod& rod) {
  std::vector<Rod::Move> moves{{Rod::Move::Kind::shift, {1.0, 0.0}, -infinity, infinity},
                               {Rod::Move::Kind::shift, {0.0, 1.0}, -infinity, infinity},
                               {Rod::Move::Kind::turn, {}, -infinity, infinity, rod.base_angle}};
  for (const Rod::Move& own : rod.moves) {
    const auto same = std::find_if(moves.begin(), moves.end(),
                                   [&](const Rod::Move& m) { return m.kind == own.kind && m.along == own.along; });
    if (same != moves.end()) {
      *same = own;
    } else {
      moves.push_back(own);
    }
  }
  rod.moves = std::move(moves);
}

namespace {

/// The stretch between fixed knots that a port is in, where it is at a knot the one behind it.
int stretch_of_port(const std::vector<double>& knots, double drawn_in) {
  const auto behind = std::upper_bound(knots.begin(), knots.end() - 1, drawn_in + knot_merge_distance);
  return static_cast<int>(behind - knots.begin()) - 1;
}

bool is_inside(const Rod::Actuator& a, double port) { return a.to <= port + knot_merge_distance; }

}  // namespace

void hide_inside_port(Rod& rod, double drawn_in, const Scale& scale) {
  if (!(drawn_in >= 0.0 && drawn_in < 1.0)) {
    throw SceneError("rod.insertion", "found an insertion of " + shown(scale.to_si(1.0 - drawn_in, dimension::length)) +
                                          " m, expected more than 0 and at most what there is of the rod (" +
                                          shown(scale.length) + " m)");
  }
  rod.hidden = 0;
  rod.hidden = stretch_of_port(rod.fixed_knots(), drawn_in);
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    if (!rod.actuators[a].by_length || !is_inside(rod.actuators[a], drawn_in)) continue;
    throw SceneError("rod.insertion", "actuator " + std::to_string(a + 1) +
                                          ", a tendon that is told its length, is all inside the port: it cannot be "
                                          "held there");
  }
}

std::vector<Rod> port_windows(const Rod& rod) {
  if (!rod.draws()) return {rod};
  std::vector<Rod> windows;
  const std::vector<double> knots = rod.fixed_knots();
  const Rod::Move& whole = rod.moves.back();
  const int last = stretch_of_port(knots, whole.maximum);
  for (int w = stretch_of_port(knots, whole.minimum); w <= last; ++w) {
    const double begin = knots[static_cast<std::size_t>(w)];
    Rod one = rod;
    one.hidden = w;
    Rod::Move& draw = one.moves.back();
    draw.minimum = std::max(whole.minimum, begin);
    if (w < last) draw.maximum = knots[static_cast<std::size_t>(w) + 1] - before_knot;
    if (draw.start < draw.minimum || draw.start > draw.maximum) draw.start = 0.5 * (draw.minimum + draw.maximum);
    bool held = false;
    for (Rod::Actuator& a : one.actuators) {
      if (!is_inside(a, begin)) continue;
      held = held || a.by_length;
      a.minimum = a.maximum = 0.0;
    }
    if (!held && draw.minimum <= draw.maximum) windows.push_back(std::move(one));
  }
  return windows;
}

}  // namespace tendril
