#include "support/sample_programs.hpp"

#include <tuple>
#include <utility>

#include "obstacle/rounded_hull.hpp"
#include "program/tip_deviations.hpp"

namespace tendril::support {

Reads Everything::reads() const {
  Reads r;
  r.tip_position = r.tip_angle = r.bending_energy = r.moments = true;
  r.contact_point = r.contact_gap = r.contact_normal = r.contact_force = r.contact_arc_length = parts_.contacts;
  r.palm_distance = parts_.palm;
  r.tensions = r.shortenings = parts_.tendons;
  r.insertion = parts_.insertion;
  r.tip_deviations = parts_.deviations;
  r.target = parts_.target;
  r.samples = parts_.samples;
  return r;
}

namespace {

std::pair<std::unique_ptr<Obstacle>, std::unique_ptr<Obstacle>> obstacles_of(const std::string& shapes) {
  if (shapes == "circles") {
    return {std::make_unique<Circle>(Vec2{0.5, 0.6}, 0.2), std::make_unique<Circle>(Vec2{0.7, -0.5}, 0.15)};
  }
  if (shapes == "walls") {
    return {std::make_unique<Wall>(Vec2{0.5, 0.6}, Vec2{0.2, -0.9}),
            std::make_unique<Wall>(Vec2{0.7, -0.5}, Vec2{-0.3, 0.8})};
  }
  return {std::make_unique<RoundedHull>(std::vector<Vec2>{{0.3, 0.7}, {0.6, 0.6}}, 0.2),
          std::make_unique<RoundedHull>(std::vector<Vec2>{{0.6, -0.4}, {0.5, -0.8}, {0.9, -0.6}, {0.8, -0.5}}, 0.1)};
}

/// Of the rod's numbers, of where its base and the obstacles are, of both units, and of the law of an actuator: three
/// deviations, each of which moves all of them.
std::shared_ptr<const Uncertainties> uncertainties_of(const Rod& rod) {
  auto out = std::make_shared<Uncertainties>();
  const auto changed = [&](double step, auto change) {
    UncertainNumber number;
    number.rod = rod;
    number.step = step;
    change(*number.rod);
    return number;
  };
  out->numbers.push_back(changed(0.7, [](Rod& r) {
    r.segments[0].stiffness += 0.7;
    r.segments[1].weight += 0.35;
    r.segments[1].rest_curvature -= 0.2;
  }));
  out->numbers.push_back(changed(1.0, [](Rod& r) {
    r.gravity += -turned(r.gravity);
    r.tip_force += -turned(r.tip_force);
    for (Rod::Load& load : r.loads) load.force += -turned(load.force);
  }));
  out->numbers.back().moves = true;
  out->numbers.back().motion.base = turn_about(rod.base, 1.0);
  out->numbers.back().motion.base.shift += Vec2{0.3, -0.4};
  out->numbers.push_back(changed(-1.0, [](Rod& r) { r.tip_force += Vec2{0.2, 0.1}; }));
  out->numbers.back().length = 0.6;
  out->numbers.back().stiffness = -0.8;
  out->numbers.push_back(
      {.motion = {{}, {{{0.5, 0.2}, 0.3, -0.2, 0.1}, {{-0.1, 0.4}, -0.2, 0.0, 0.3}}}, .moves = true});
  UncertainNumber law;
  law.held = [](double u) { return Rod::Jet{0.2 + 0.5 * u + 0.3 * u * u, 0.5 + 0.6 * u}; };
  law.actuator = 1;
  out->numbers.push_back(law);
  out->shares.resize(3, 5);
  out->shares << 0.3, -0.1, 0.2, 0.4, -0.3, 0.1, 0.2, -0.2, 0.1, 0.5, -0.2, 0.3, 0.1, 0.2, 0.1;
  return out;
}

}  // namespace

SamplePose::SamplePose(const Setup& setup) : model(setup.model) {
  rod.segments = {{0.0, 0.45, 1.0, 2.0, 0.3}, {0.45, 1.0, 0.6, 1.1, -0.2}};
  if (setup.rod == "tapered" || setup.rod == "varied") {
    rod.segments[0].more_stiffness = {-0.3};
    rod.segments[0].more_weight = {0.4};
    rod.segments[1].more_stiffness = {-0.4, 0.2, 0.1, -0.05};
    rod.segments[1].more_weight = {-0.7, 0.3};
    rod.segments[1].more_rest_curvature = {0.5, -0.2};
  }
  if (setup.rod == "loaded" || setup.rod == "varied") {
    rod.loads = {{0.45, 0.45, {0.2, -0.3}, 0.25}, {0.45, 1.0, {-0.4, 0.3}, 0.0}, {0.0, 1.0, {0.1, 0.2}, 0.0}};
  }
  if (setup.rod == "thick" || setup.rod == "varied") {
    rod.segments[0].radius = 0.04;
    rod.segments[0].more_radius = {-0.01};
    rod.segments[1].radius = 0.03;
    rod.segments[1].more_radius = {0.02, -0.035};
  }
  rod.actuators = {{0.0, 1.0, -3.0, 3.0}, {0.45, 1.0, -2.0, 2.0}, {0.0, 0.45, 0.0, 0.0}};
  if (setup.profiles) {
    rod.actuators[0].profile = {{0.0, 0.45, {1.0, -0.7, 0.4}}, {0.45, 1.0, {0.8, 0.9, -1.7, 1.1}}};
    rod.actuators[1].profile = {{0.45, 1.0, {0.6, 0.5}}};
    // Tendons on either side, the first one told its length.
    rod.actuators[0].offset = 0.7;
    rod.actuators[0].by_length = true;
    rod.actuators[0].least_shortening = -3.0;
    rod.actuators[0].most_shortening = 2.0;
    rod.actuators[1].offset = -0.4;
  }
  if (setup.stretches) {
    rod.stretch_order = 3;
    rod.segments[0].axial = 0.7;
    rod.segments[1].axial = 1.2;
    if (setup.rod == "varied") {
      rod.segments[0].more_axial = {-0.2, 0.1};
      rod.segments[1].more_axial = {-0.4, 0.3, -0.2};
    }
    rod.actuators[0].thrust = -0.6;
    // A chamber whose axial force does not go with its moment: no tendon.
    rod.actuators[1].offset = 0.0;
    rod.actuators[1].pull = [](double u) {
      return Rod::Jet{u * (0.8 + u * (0.1 - 0.05 * u)), 0.8 + u * (0.2 - 0.15 * u), 0.2 - 0.3 * u};
    };
  }
  rod.gravity = {0.28, -0.96};
  rod.payload = 0.4;
  rod.tip_force = {0.3, -0.2};
  rod.base = {0.05, -0.02};
  rod.base_angle = 0.2;
  if (setup.moves) {
    using Kind = Rod::Move::Kind;
    rod.moves = {{Kind::shift, {1.0, 0.0}, -0.5, 0.5},
                 {Kind::shift, {0.0, 1.0}, -0.5, 0.5},
                 {Kind::turn, {}, -0.6, 0.7, 0.2},
                 {Kind::draw, {}, 0.0, 0.2, 0.1}};
  }
  spec.rod = &rod;
  spec.model = model.get();
  std::tie(upper, lower) = obstacles_of(setup.shapes);
  spec.obstacles = {upper.get(), lower.get()};
  everything =
      std::make_unique<Everything>(Everything::Parts{.contacts = setup.tip_contact || setup.interior_contacts > 0,
                                                     .palm = setup.palm,
                                                     .target = true,
                                                     .tendons = setup.profiles,
                                                     .insertion = setup.moves,
                                                     .deviations = setup.uncertain,
                                                     .samples = {0.23, 0.61, 0.97}});
  spec.terms = {{everything.get(), 1.3, "everything"}};
  spec.target = {{0.9, 0.2}, 0.0, true, false};
  spec.split = setup.split;
  // One of a rod that is drawn in is beside the knot that moves at its port.
  for (int k = 0; k < setup.interior_contacts; ++k) spec.contacts.push_back({k % 2, false, setup.moves ? k : 1});
  if (setup.tip_contact) spec.contacts.push_back({0, true, 0});
  spec.nodes = 34;
  if (setup.uncertain) spec.uncertainties = uncertainties_of(rod);
  spec.checks = {{0, 0.5, 0}, {0, 0.5, 1}, {1, 0.31, 1}, {1, 0.8, 0}};
  if (setup.palm) {
    spec.palm = PalmSetup{{0.8, -0.6}, -0.3, 0.4, true};
    carried = std::make_unique<Circle>(Vec2{-0.2, 0.3}, 0.1);
    spec.obstacles.push_back(carried.get());
    spec.carried = 1;
    spec.checks.push_back({1, 0.6, 2});
  }
}

SampleGrasp::SampleGrasp(const Setup& setup) {
  rods[0].segments = {{0.0, 0.4, 1.0, 2.0, 0.3}, {0.4, 1.0, 0.6, 1.1, -0.2}};
  rods[0].actuators = {{0.0, 1.0, -3.0, 3.0}, {0.4, 1.0, -2.0, 2.0}};
  rods[0].segments[1].radius = 0.03;
  rods[0].segments[1].more_radius = {0.01, -0.02};
  rods[0].gravity = {0.28, -0.96};
  rods[0].base = {0.0, 0.2};
  rods[0].base_angle = 0.1;
  rods[1].segments = {{0.0, 1.0, 1.0, 0.7, -0.4}};
  rods[1].segments[0].radius = 0.02;
  rods[1].actuators = {{0.0, 0.7, -3.0, 3.0}};
  rods[1].gravity = {0.28, 0.96};
  rods[1].payload = 0.3;
  rods[1].base = {0.0, 0.16};
  const TermUnits units[2] = {{1.2, 0.7}, {0.96, 1.9}};
  for (std::size_t which = 0; which < 2; ++which) {
    objects[which] = std::make_unique<Circle>(Vec2{}, 0.25 / units[which].length);
    PoseProgramSpec& own = spec.fingers[which];
    own.rod = &rods[which];
    own.model = which == 0 ? &fine : &coarse;
    own.obstacles = {objects[which].get(), &palm};
    own.carried = 1;
    own.terms = {{&everything, 1.3, "everything"}};
    const bool tip = which == 0 ? setup.upper_at_tip : setup.lower_at_tip;
    own.contacts = {{0, tip, which == 0 && !tip ? 1 : 0}};
    own.nodes = 30;
    own.min_force = 0.01;
    own.max_force = which == 0 ? 5.0 : 1.0;
    own.palm = PalmSetup{};
    own.term_units = units[which];
    own.checks = {{0, 0.6, 0}, {1, 0.7, 1}};
    if (which == 1 && tip) own.checks = {{0, 0.6, 0}, {0, 0.7, 1}};
  }
  spec.palm_minimum = 0.3;
  spec.palm_maximum = setup.free_palm ? 0.9 : 0.3;
  spec.separations = {{0, 0.9, 0, 0.8, {0.0, 1.0}}, {1, 1.0, 0, 1.0, {-0.6, 0.8}}};
}

}  // namespace tendril::support
