#include "plan_report.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tendril/clearance.hpp"

namespace tendril {

std::vector<BackbonePoint> sampled_backbone(const PoseProgram& program, double length) {
  const Chain& chain = program.chain();
  const Backbone& shape = program.backbone();
  Curve curve(std::make_shared<CurveTables>(chain.rule()));
  curve.follow(shape);
  const int n = chain.functions();
  constexpr int total = 100;
  std::vector<BackbonePoint> out;
  for (int j = 0; j < chain.piece_count(); ++j) {
    const int steps = std::max(4, static_cast<int>(std::ceil(total * shape.length(j))));
    std::vector<double> sigma;
    for (int i = j == 0 ? 0 : 1; i <= steps; ++i) sigma.push_back(static_cast<double>(i) / steps);
    const auto rows = static_cast<Eigen::Index>(sigma.size());
    Eigen::MatrixXd value(rows, n);
    Eigen::MatrixXd first(rows, n);
    Eigen::MatrixXd second(rows, n);
    chain.model().evaluate(sigma, value, first, second);
    const Eigen::Map<const Eigen::VectorXd> q(shape.coordinates(j), n);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double at = sigma[static_cast<std::size_t>(i)];
      const Vec2 p = curve.position(j, at);
      out.push_back({(shape.start(j) + at * shape.length(j)) * length, p.x * length, p.y * length,
                     shape.knot_angle(j) + value.row(i).dot(q), first.row(i).dot(q) / shape.length(j) / length});
    }
  }
  return out;
}

std::vector<PlannedContact> planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names,
                                             const Scale& scale) {
  std::vector<PlannedContact> contacts;
  for (int k = 0; k < program.layout().forces; ++k) {
    const PoseProgram::ContactState& c = program.contacts()[static_cast<std::size_t>(k)];
    const ContactSetup& setup = program.spec().contacts[static_cast<std::size_t>(k)];
    PlannedContact p;
    p.obstacle = setup.obstacle;
    p.obstacle_name = obstacle_names[static_cast<std::size_t>(setup.obstacle)];
    p.at_tip = setup.at_tip;
    p.arc_length = c.arc_length * scale.length;
    p.point = scale.length * c.point;
    p.normal = c.surface.normal;
    p.force = c.force * scale.force();
    p.gap = c.surface.distance * scale.length;
    contacts.push_back(p);
  }
  return contacts;
}

std::vector<BackbonePoint> outline(const StartShape& shape, const Rod& rod, double length) {
  constexpr int steps = 100;
  std::vector<BackbonePoint> points;
  points.reserve(steps + 1);
  Vec2 at = rod.base;
  double angle = rod.base_angle;
  for (int i = 0; i <= steps; ++i) {
    const double s = static_cast<double>(i) / steps;
    points.push_back({s * length, at.x * length, at.y * length, angle, shape.curvature(s) / length});
    const double middle = angle + 0.5 / steps * shape.curvature(s + 0.25 / steps);
    at += 1.0 / steps * Vec2{std::cos(middle), std::sin(middle)};
    angle += shape.curvature(s + 0.5 / steps) / steps;
  }
  return points;
}

std::function<double(double)> curvature_of(const Plan& plan, double length) {
  std::vector<std::pair<double, double>> table;
  for (const BackbonePoint& p : plan.backbone) table.emplace_back(p[0] / length, p[4] * length);
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
