#include "scene/plan_report.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "certificate/clearance.hpp"
#include "rod/kernels.hpp"
#include "rod/outline.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

BackboneSampler::BackboneSampler(const Chain& chain) : pieces_(static_cast<std::size_t>(chain.piece_count())) {}

BackboneSampler::Piece::Piece(const Chain& chain, int steps)
    : samples(*chain.curve_tables(), steps),
      value(steps + 1, chain.bends()),
      first(steps + 1, chain.bends()),
      x(steps + 1),
      y(steps + 1),
      angle(steps + 1),
      slope(steps + 1) {
  std::vector<double> sigma;
  for (int i = 0; i <= steps; ++i) sigma.push_back(samples.sigma(i));
  Eigen::MatrixXd second(steps + 1, chain.bends());
  chain.model().evaluate(sigma, value, first, second);
}

void BackboneSampler::sample(const PoseProgram& program, const Curve& curve, double length,
                             std::vector<BackbonePoint>& out) {
  const Chain& chain = program.chain();
  const Backbone& shape = program.backbone();
  const int n = chain.bends();
  constexpr double total = 100.0;
  constexpr double slack = 1.25;
  out.clear();
  for (int j = 0; j < chain.piece_count(); ++j) {
    Piece& piece = pieces_[static_cast<std::size_t>(j)];
    const int wanted = std::max(4, static_cast<int>(std::ceil(total * shape.length(j))));
    if (!piece.samples.fit(*chain.curve_tables()) || wanted > slack * piece.samples.steps() ||
        piece.samples.steps() > slack * wanted) {
      piece = Piece(chain, wanted);
    }
    const int count = piece.samples.steps() + 1;
    curve.positions(j, piece.samples, piece.x, piece.y);
    const auto sum = [&](const Eigen::MatrixXd& basis, Eigen::VectorXd& to) {
      to.setZero();
      kernels::add_weighted_columns(count, count, n, basis.data(), shape.coordinates(j), 1, to.data());
    };
    sum(piece.value, piece.angle);
    sum(piece.first, piece.slope);
    for (int i = j == 0 ? 0 : 1; i < count; ++i) {
      out.push_back({(shape.start(j) + piece.samples.sigma(i) * shape.length(j)) * length, piece.x[i] * length,
                     piece.y[i] * length, shape.knot_angle(j) + piece.angle[i],
                     piece.slope[i] / shape.length(j) / length});
    }
  }
}

std::vector<BackbonePoint> sampled_backbone(const PoseProgram& program, double length) {
  std::vector<BackbonePoint> out;
  Curve curve(program.chain().curve_tables());
  curve.follow(program.backbone());
  BackboneSampler(program.chain()).sample(program, curve, length, out);
  return out;
}

std::vector<PlannedContact> planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names,
                                             const Scale& scale) {
  std::vector<PlannedContact> contacts;
  planned_contacts(program, obstacle_names, scale, contacts);
  return contacts;
}

void planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names, const Scale& scale,
                      std::vector<PlannedContact>& contacts) {
  contacts.resize(static_cast<std::size_t>(program.layout().forces));
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const PoseProgram::ContactState& c = program.contacts()[k];
    const ContactSetup& setup = program.spec().contacts[k];
    PlannedContact& p = contacts[k];
    p.obstacle = setup.obstacle;
    p.obstacle_name = obstacle_names[static_cast<std::size_t>(setup.obstacle)];
    p.at_tip = setup.at_tip;
    p.arc_length = c.arc_length * scale.length;
    p.point = scale.length * c.point;
    p.normal = c.surface.normal;
    p.force = c.force * scale.force();
    // c.lean and c.shear go with the turned normal, which may point towards the base.
    const double side = dot(turned(c.surface.normal), c.tangent) < 0.0 ? -1.0 : 1.0;
    p.tangent = side * turned(c.surface.normal);
    p.tangential = side * (c.lean * p.force + c.shear * scale.force());
    const int lean = program.layout().first_lean + static_cast<int>(k);
    const bool inside = program.layout().leans > 0 && std::abs(c.lean) < program.upper()[lean] - tolerance::bounds;
    p.sticks = setup.sticks || inside;
    p.gap = c.surface.distance * scale.length;
    p.extended = false;
  }
}

RodPlace place_of(const PoseProgram& program, ConstVectorRef x, const Scale& scale) {
  const Rod& rod = *program.spec().rod;
  const Backbone& shape = program.backbone();
  RodPlace place;
  if (rod.draws()) place.insertion = (1.0 - x[program.layout().first_arc_length - 1]) * scale.length;
  if (rod.base_moves()) place.base = {scale.length * shape.base(), shape.knot_angle(0)};
  return place;
}

RodPlace place_on_palm(const Scene& scene, RodPlace place) {
  if (!scene.gripper || !place.base) return place;
  const GripperSpec& gripper = *scene.gripper;
  const double c = std::cos(gripper.angle);
  const double s = std::sin(gripper.angle);
  const Vec2 from_palm = place.base->position - gripper.position;
  place.base = {{c * from_palm.x + s * from_palm.y, c * from_palm.y - s * from_palm.x},
                place.base->angle - gripper.angle};
  return place;
}

std::vector<double> moves_of(const Rod& rod, const Scale& scale, const RodPlace& place, std::vector<double> otherwise) {
  for (std::size_t i = 0; i < rod.moves.size(); ++i) {
    const Rod::Move& m = rod.moves[i];
    if (m.kind == Rod::Move::Kind::draw) {
      if (place.insertion) otherwise[i] = 1.0 - *place.insertion / scale.length;
    } else if (place.base) {
      const Vec2 shift = (1.0 / scale.length) * place.base->position - rod.base;
      otherwise[i] = m.kind == Rod::Move::Kind::turn ? place.base->angle : dot(shift, m.along);
    }
  }
  return otherwise;
}

std::vector<BackbonePoint> outline(const StartShape& shape, const Rod& rod, double length) {
  std::vector<OutlinePoint> line;
  outline(rod, shape.curvature, 100, line);
  std::vector<BackbonePoint> points;
  points.reserve(line.size());
  for (const OutlinePoint& p : line) {
    points.push_back({p.s * length, p.position.x * length, p.position.y * length, p.angle, p.curvature / length});
  }
  return points;
}

std::function<double(double)> curvature_of(const Plan& plan, double length) {
  std::vector<std::pair<double, double>> table;
  for (const BackbonePoint& p : plan.backbone) table.emplace_back(p.s / length, p.curvature * length);
  return [table = std::move(table)](double s) {
    const auto after =
        std::lower_bound(table.begin(), table.end(), s, [](const auto& entry, double at) { return entry.first < at; });
    if (after == table.begin()) return table.front().second;
    if (after == table.end()) return table.back().second;
    const auto before = after - 1;
    const double span = after->first - before->first;
    const double t = span > 0.0 ? (s - before->first) / span : 0.0;
    return (1.0 - t) * before->second + t * after->second;
  };
}

std::vector<std::string> obstacle_names(const Scene& scene) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const std::string& name = scene.obstacles[i].name;
    names.push_back(name.empty() ? "obstacle " + std::to_string(i + 1) : name);
  }
  return names;
}

}  // namespace tendril
