#include "search/task.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "rod/chain.hpp"
#include "rod/outline.hpp"
#include "scene/start_shape.hpp"
#include "search/contacts.hpp"
#include "search/follower.hpp"
#include "search/free_reach.hpp"
#include "search/parameters.hpp"
#include "search/sides.hpp"
#include "tendril/bounded_off_target.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

std::string contact_name(const ContactSetup& c, const std::vector<std::string>& obstacles, int stretches, int hidden) {
  const std::string on = "'" + obstacles[static_cast<std::size_t>(c.obstacle)] + "'";
  if (c.at_tip) return "tip contact with " + on;
  std::string name = "interior contact with " + on;
  if (stretches + hidden > 1) name += " on segment " + std::to_string(hidden + c.region + 1);
  return name;
}

/// Rows of a program before the exchange of check points adds some: enough for a dozen obstacles.
constexpr std::size_t most_first_checks = 48;

/// Keeps so many of the check points, those that the shape has next to their obstacles, in their order.
void keep_nearest(std::vector<CheckPoint>& checks, const PoseProgram& program, std::span<const double> knots,
                  const StartShape& shape) {
  constexpr int steps = 200;
  std::vector<OutlinePoint> line;
  outline(*program.spec().rod, shape.curvature, steps, line);
  std::vector<double> distances;
  distances.reserve(checks.size());
  for (const CheckPoint& c : checks) {
    const double s = program.chain().start(c.piece, knots) + c.sigma * program.chain().length(c.piece, knots);
    const double port = program.spec().rod->port();
    const auto nearest = static_cast<std::size_t>(std::lround(std::max(0.0, s - port) / (1.0 - port) * steps));
    distances.push_back(
        program.spec().obstacles[static_cast<std::size_t>(c.obstacle)]->at(line[nearest].position).distance);
  }
  std::vector<double> sorted = distances;
  const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(most_first_checks);
  std::nth_element(sorted.begin(), last, sorted.end());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < checks.size(); ++i) {
    if (distances[i] < *last) checks[kept++] = checks[i];
  }
  checks.resize(kept);
}

/// No point of the base is farther from Rod::base.
double most_shift(const Rod& rod) {
  double squares = 0.0;
  for (const Rod::Move& m : rod.moves) {
    const double most = std::max(std::abs(m.minimum), std::abs(m.maximum));
    if (m.kind == Rod::Move::Kind::shift) squares += most * most;
  }
  return std::sqrt(squares);
}

constexpr double full_turn = 2.0 * std::numbers::pi;

/// The angle that differs from `direction` by full turns and from `reference` by half a turn at most; of two that do,
/// as far as rounding can tell, the larger one.
double nearest_turn(double direction, double reference) {
  const double difference = std::remainder(direction - reference, full_turn);
  constexpr double rounding = 1e-9;
  return reference + (difference < rounding - 0.5 * full_turn ? difference + full_turn : difference);
}

}  // namespace

Task::Task() = default;
Task::~Task() = default;

void Task::take_target(const TargetSpec& wanted) {
  target = {};
  if (wanted.position) {
    target.position = {scale.to_dimensionless(wanted.position->x, dimension::length),
                       scale.to_dimensionless(wanted.position->y, dimension::length)};
    target.has_position = true;
  }
  direction.reset();
  if (!wanted.angle) return;
  target.has_angle = true;
  if (wanted.turns) {
    target.angle = round_to_12_digits(nearest_turn(*wanted.angle, rod.base_angle) + full_turn * *wanted.turns);
  } else {
    direction = *wanted.angle;
    face(start_tip_angle());
  }
}

void Task::take_start() {
  start_points = start_curvature(scene, scale, rod);
  if (!start_points) return;
  std::vector<OutlinePoint> line;
  outline(rod, start_points, search_parameters().outline_steps, line);
  scene.start_tip_angle = line.back().angle - rod.base_angle;
}

double Task::start_tip_angle() const {
  if (scene.start_tip_angle != 0.0) return rod.base_angle + scene.start_tip_angle;
  double angle = rod.base_angle;
  for (const Rod::Segment& s : rod.segments) angle += s.rest_turn();
  return angle;
}

void Task::face(double reference) {
  if (direction) target.angle = round_to_12_digits(nearest_turn(*direction, reference));
}

std::vector<double> Task::angles_near(double reference) const {
  if (!direction) return {};
  double low = -0.5 * full_turn;  // what gravity and contact may add
  double high = 0.5 * full_turn;
  for (const Rod::Actuator& a : rod.actuators) {
    for (const Rod::Segment& s : rod.segments) {
      const double turn = a.compliance(s);
      if (turn == 0.0) continue;
      const auto [least, most] = std::minmax({a.minimum * turn, a.maximum * turn});
      low += least;
      high += most;
    }
  }
  double rest = rod.base_angle;
  for (const Rod::Move& m : rod.moves) {
    if (m.kind != Rod::Move::Kind::turn) continue;
    low += m.minimum - rest;
    high += m.maximum - rest;
  }
  for (const Rod::Segment& s : rod.segments) rest += s.rest_turn();
  const double first = nearest_turn(*direction, reference);
  const double side = first > reference ? -full_turn : full_turn;
  std::vector<double> angles{round_to_12_digits(first)};
  const auto most = static_cast<std::size_t>(search_parameters().most_turns);
  for (int turns = 1; turns <= search_parameters().most_turns; ++turns) {
    for (const double other : {first + turns * side, first - turns * side}) {
      if (other >= rest + low && other <= rest + high && angles.size() < most)
        angles.push_back(round_to_12_digits(other));
    }
  }
  return angles;
}

bool Task::contact_planned() const {
  return needs_obstacles(scene) && max_force > 0.0 &&
         (scene.contact.mode == ContactModeName::allow || scene.contact.mode == ContactModeName::require);
}

double Task::least_cost(double distance) const {
  double least = 0.0;
  for (const PoseProgramTerm& t : terms) {
    double bound = t.term->lower_bound();
    if (const auto* off_target = dynamic_cast<const BoundedOffTarget*>(t.term);
        off_target != nullptr && distance > 0.0) {
      bound = off_target->lower_bound_off_target(distance);
    }
    least += t.weight * bound;
  }
  return least;
}

double Task::least_distance(const Mode& mode, const std::function<bool(double)>& enough) {
  // Nothing is asked of where the tip is, or terms are unknown that may gain by it, or the rod may grow.
  if (palm || rod.stretches() || !target.has_position || !(least_cost(1.0) > least_cost())) return 0.0;
  if (mode.contacts.empty()) {
    if (!rod.moves.empty()) return 0.0;
    if (!reach) reach = std::make_unique<FreeReach>(spec(mode, {}, 2 * nodes));
    return reach->least_distance(target.position, enough);
  }
  const std::vector<double> knots = rod.fixed_knots();
  double least = 0.0;
  for (const ContactSetup& c : mode.contacts) {
    const Obstacle& obstacle = *obstacles[static_cast<std::size_t>(c.obstacle)];
    // The obstacle's surface is so far from the target, and the tip no farther from it than the rod goes on behind the
    // contact, which the rod has to get to first.
    const double to_contact = std::max(c.at_tip ? 1.0 : knots[static_cast<std::size_t>(c.region)],
                                       obstacle.at(rod.base).distance - rod.most_radius() - most_shift(rod));
    const double behind = rod.most_radius() + std::max(0.0, 1.0 - to_contact);
    least = std::max(least, std::abs(obstacle.at(target.position).distance) - behind);
  }
  return least;
}

int Task::first_nodes() const {
  double angle = std::max(1.0, std::abs(scene.start_tip_angle));
  for (const Rod::Actuator& a : rod.actuators) {
    const double largest = std::max(std::abs(a.minimum), std::abs(a.maximum));
    if (std::isfinite(largest)) angle = std::max(angle, largest * (a.to - a.from));
  }
  return suggested_nodes(model->function_count(), std::min(angle, 30.0));
}

Mode Task::mode(std::vector<ContactSetup> contacts) const {
  const std::vector<double> knots = rod.fixed_knots();
  Mode mode;
  mode.contacts = std::move(contacts);
  for (const ContactSetup& c : mode.contacts) {
    if (!mode.name.empty()) mode.name += " and ";
    mode.name += contact_name(c, obstacle_names, static_cast<int>(knots.size()) - 1, rod.hidden);
    // A point at arc length s is at most s away from the base.
    const double farthest = c.at_tip ? 1.0 : knots[static_cast<std::size_t>(c.region) + 1];
    if (palm) {
      if (mode.skip.empty()) mode.skip = grip->obstruction(*this, farthest);
    } else if (!rod.stretches() && obstacles[static_cast<std::size_t>(c.obstacle)]->at(rod.base).distance >
                                       farthest + rod.most_radius() + most_shift(rod)) {
      mode.skip = "out of reach: the obstacle is farther from the base than this part of the rod is long";
    }
  }
  mode.name += port_name();
  return mode;
}

void Task::take_rod(const Rod& other) {
  rod = other;
  follower.reset();
  reach.reset();
  arcs.clear();
  beginnings.clear();
  modes.clear();
}

std::string Task::port_name() const {
  return windows.size() < 2 ? "" : ", port in segment " + std::to_string(rod.hidden + 1);
}

PoseProgramSpec Task::spec(const Mode& mode, const std::vector<int>& regions, int with_nodes) const {
  PoseProgramSpec s;
  s.rod = &rod;
  s.model = model;
  s.obstacles = obstacles;
  s.terms = terms;
  s.target = target;
  s.tolerance = tolerance;
  s.split = scene.coordinates.split_at_contact;
  s.contacts = mode.contacts;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) s.contacts[k].region = regions[k];
  s.nodes = with_nodes;
  s.min_force = min_force;
  s.max_force = max_force;
  s.palm = palm;
  s.friction = friction;
  s.carried = carried;
  // The margin of contacts that slip has no derivatives here.
  if (friction.empty()) s.least_margin = least_margin;
  s.least_convexity = least_convexity;
  s.term_units = term_units;
  s.uncertainties = uncertainties;
  s.tables = tables;
  return s;
}

std::vector<int> Task::regions_of(const Mode& mode, const std::vector<double>& arc_lengths) const {
  std::vector<int> regions;
  regions.reserve(mode.contacts.size());
  for (const ContactSetup& c : mode.contacts) regions.push_back(c.region);
  if (scene.coordinates.split_at_contact) return regions;
  const Chain chain(rod, *components.coordinates, {}, 1);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (!mode.contacts[k].at_tip) regions[k] = chain.piece_at(arc_lengths[k], {});
  }
  return regions;
}

int Task::coordinate_count(const Mode& mode) const {
  auto stretches = static_cast<int>(rod.fixed_knots().size()) - 1;
  if (scene.coordinates.split_at_contact) {
    stretches += static_cast<int>(
        std::count_if(mode.contacts.begin(), mode.contacts.end(), [](const ContactSetup& c) { return !c.at_tip; }));
  }
  return stretches * static_cast<int>(model->subdivision().size()) * (model->function_count() + rod.stretch_order);
}

std::vector<int> Task::pieces_of_stretch(int stretch) const {
  const auto parts = static_cast<int>(model->subdivision().size());
  std::vector<int> pieces(static_cast<std::size_t>(parts));
  std::iota(pieces.begin(), pieces.end(), stretch * parts);
  return pieces;
}

std::vector<CheckPoint> Task::first_checks(const PoseProgramSpec& spec, const StartShape& shape) const {
  if (obstacles.empty()) return {};
  const PoseProgram probe(spec);
  return first_checks(probe, probe.start_from(shape), shape);
}

std::vector<CheckPoint> Task::first_checks(const PoseProgram& probe, ConstVectorRef x, const StartShape& shape) const {
  std::vector<CheckPoint> checks;
  if (obstacles.empty()) return checks;
  const PoseProgramSpec& spec = probe.spec();
  const PoseProgram::Layout& at = probe.layout();
  const Chain& chain = probe.chain();
  const std::span<const double> knots = probe.knots(x);
  // Few points where the planner adds what is missing, but not so few that a rod without contact slips past an obstacle
  // between two of them; as many as asked for where the planner adds none.
  int count = 4;
  if (spec.contacts.empty()) {
    for (const Obstacle* o : obstacles) {
      count = std::max(count, static_cast<int>(std::ceil(std::min(16.0, 0.6 / o->smallest_radius()))));
    }
  }
  if (scene.contact.check_points > 0) count = scene.contact.check_points;
  const double first = chain.start(0, knots);
  for (int i = 1; i <= count; ++i) {
    const double s = first + (1.0 - first) * static_cast<double>(i) / count;
    bool near_contact = false;
    for (int k = 0; k < at.arc_lengths; ++k)
      near_contact = near_contact || std::abs(s - x[at.first_arc_length + k]) < 0.02;
    if (near_contact) continue;
    const int j = i == count ? chain.piece_count() - 1 : chain.piece_at(s, knots);
    const double sigma =
        i == count ? 1.0 : std::clamp((s - chain.start(j, knots)) / chain.length(j, knots), 0.02, 0.98);
    for (int o = 0; o < static_cast<int>(obstacles.size()); ++o) {
      // A tip that touches is a contact already.
      const bool tip_touches =
          i == count && std::any_of(spec.contacts.begin(), spec.contacts.end(),
                                    [o](const ContactSetup& c) { return c.at_tip && c.obstacle == o; });
      if (!tip_touches) checks.push_back({j, sigma, o});
    }
  }
  if (scene.contact.check_points == 0 && checks.size() > most_first_checks) keep_nearest(checks, probe, knots, shape);
  return checks;
}

/// One of the assignments with the most contacts, for its size.
Mode Task::largest_mode() const {
  const int stretches = static_cast<int>(rod.fixed_knots().size()) - 1;
  std::vector<ContactSetup> contacts;
  for (const ContactSetup& slot : contact_slots(stretches, contact_obstacles)) {
    if (static_cast<int>(contacts.size()) == scene.contact.count) break;
    if (!slot.at_tip || contacts.empty() || !contacts.back().at_tip) contacts.push_back(slot);
  }
  Mode largest = mode(contacts);
  largest.name = std::to_string(contacts.size()) + " contacts, as one of the assignments that a plan searches";
  return largest;
}

}  // namespace tendril
