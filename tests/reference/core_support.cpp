#include "core_support.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "nlp/feasibility.hpp"
#include "obstacle/circle.hpp"

namespace tendril::support {

void ConstantCurvature::evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first,
                                 MatrixRef second) const {
  for (std::size_t g = 0; g < sigma.size(); ++g) value(static_cast<Eigen::Index>(g), 0) = sigma[g];
  first.setOnes();
  second.setZero();
}

std::vector<double> ConstantCurvature::subdivision() const {
  return std::vector<double>(static_cast<std::size_t>(pieces_), 1.0);
}

void HalfPlane::bounding_box(Vec2& low, Vec2& high) const {
  low = {-infinity, -infinity};
  high = {infinity, infinity};
}

void HalfPlane::outline(std::span<Vec2> points, Vec2, Vec2) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = point_ + (static_cast<double>(i) - 0.5 * static_cast<double>(points.size())) * turned(normal_);
  }
}

Model legendre(int order, int pieces) { return std::make_shared<LegendreBasis>(order, pieces); }
Model psc() { return legendre(3); }
Model pcc(int pieces) { return std::make_shared<ConstantCurvature>(pieces); }

Rod core_rod(const RodBvp& bvp) {
  Rod rod;
  rod.segments.clear();
  const double g = std::hypot(bvp.gravity.x, bvp.gravity.y);
  double from = 0.0;
  for (const RodSection& s : bvp.sections) {
    rod.segments.push_back({from, from + s.length, s.stiffness, s.density * g, s.rest_curvature});
    from += s.length;
  }
  rod.segments.back().to = 1.0;
  for (const MomentSpan& a : bvp.actuators) rod.actuators.push_back({a.from, a.to});
  rod.base = {bvp.base.x, bvp.base.y};
  rod.base_angle = bvp.base_angle;
  if (g > 0.0) rod.gravity = {bvp.gravity.x / g, bvp.gravity.y / g};
  rod.payload = bvp.payload * g;
  rod.tip_force = {bvp.tip_force.x, bvp.tip_force.y};
  return rod;
}

Rod upright_rod(double weight, double load) {
  Rod rod;
  rod.actuators.resize(1);
  rod.base_angle = std::acos(0.0);
  if (weight != 0.0) rod.gravity = {0.0, -1.0};
  rod.segments[0].weight = weight;
  rod.tip_force = {0.0, -load};
  return rod;
}

std::unique_ptr<Obstacle> core_obstacle(const BvpContact& contact) {
  const Vec2 center{contact.center.x, contact.center.y};
  const Vec2 normal{contact.wall_normal.x, contact.wall_normal.y};
  if (normal == Vec2{}) return std::make_unique<Circle>(center, contact.radius);
  return std::make_unique<HalfPlane>(center, normal);
}

Equilibrium::Equilibrium(const Rod& rod, Model model, const std::vector<double>& moments,
                         const std::vector<const Obstacle*>& obstacles, const std::vector<ContactSetup>& contacts,
                         bool split, double turn)
    : rod_(std::make_shared<Rod>(rod)), model_(std::move(model)) {
  for (std::size_t a = 0; a < moments.size(); ++a) {
    rod_->actuators.at(a).minimum = rod_->actuators.at(a).maximum = moments[a];
  }
  spec.rod = rod_.get();
  spec.model = model_.get();
  spec.obstacles = obstacles;
  spec.contacts = contacts;
  spec.split = split;
  spec.nodes = suggested_nodes(model_->function_count(), turn);
  spec.min_force = -infinity;
  program = std::make_unique<PoseProgram>(spec);
  for (std::size_t k = 0; k < contacts.size(); ++k) program->set_branch(static_cast<int>(k), Branch::touching);
  x = Eigen::VectorXd::Zero(program->variable_count());
}

const Backbone& Equilibrium::moved() {
  program->constraints(x);
  return program->backbone();
}

double Equilibrium::newton(const Eigen::VectorXd& start, const std::vector<int>& rows,
                           const std::vector<int>& columns) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (rows.size() != columns.size()) throw std::logic_error("the system is not square");
  Eigen::VectorXd residual(n);
  const auto evaluate = [&] {
    const VectorView c = program->constraints(x);
    for (Eigen::Index i = 0; i < n; ++i) residual[i] = c[rows[static_cast<std::size_t>(i)]];
    return n == 0 ? 0.0 : residual.cwiseAbs().maxCoeff();
  };
  x = start;
  double worst = evaluate();
  Eigen::MatrixXd matrix(n, n);
  // Once below 1e-12 one more step takes what rounding leaves.
  bool last = false;
  for (int iteration = 0; iteration < 60 && std::isfinite(worst) && worst > 0.0; ++iteration) {
    const MatrixView jacobian = program->jacobian(x);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        matrix(i, j) = jacobian(rows[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(j)]);
      }
    }
    const Eigen::VectorXd before = x;
    const double worst_before = worst;
    const Eigen::VectorXd step = matrix.partialPivLu().solve(residual);
    for (Eigen::Index j = 0; j < n; ++j) x[columns[static_cast<std::size_t>(j)]] -= step[j];
    worst = evaluate();
    if (last || worst_before <= 1e-12) {
      if (!(worst < worst_before)) {
        x = before;
        worst = evaluate();
      }
      break;
    }
    last = worst <= 1e-12;
  }
  return worst;
}

double Equilibrium::solve(const StartShape& start) { return solve_from(program->start_from(start)); }

double Equilibrium::solve_from(const Eigen::VectorXd& start) {
  const PoseProgram::Layout& at = program->layout();
  std::vector<int> rows(static_cast<std::size_t>(at.coordinates));
  std::iota(rows.begin(), rows.end(), 0);
  std::vector<int> columns = rows;
  for (int k = 0; k < at.forces; ++k) {
    rows.push_back(at.first_gap + k);
    columns.push_back(program->force_variable(k));
    if (program->arc_length_variable(k) < 0) continue;
    rows.push_back(at.first_closest + k);
    columns.push_back(program->arc_length_variable(k));
  }
  return newton(restore_feasibility(*program, start, 1e-13).x, rows, columns);
}

double Equilibrium::solve_coordinates(const Eigen::VectorXd& start) {
  std::vector<int> rows(static_cast<std::size_t>(program->layout().coordinates));
  std::iota(rows.begin(), rows.end(), 0);
  return newton(start, rows, rows);
}

double Equilibrium::solve_at_tip_angle(const Eigen::VectorXd& start, double angle) {
  const int n = program->layout().coordinates;
  const int moment = program->moment_variable(0);
  const Chain& chain = program->chain();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n + 1, n + 1);
  for (int j = 0; j < chain.piece_count(); ++j) {
    matrix.block(n, j * chain.functions(), 1, chain.functions()) = chain.table().end.transpose();
  }
  Eigen::VectorXd residual(n + 1);
  x = start;
  double worst = infinity;
  for (int iteration = 0; iteration < 40; ++iteration) {
    const MatrixView jacobian = program->jacobian(x);
    matrix.topLeftCorner(n, n) = jacobian.topLeftCorner(n, n);
    matrix.col(n).head(n) = jacobian.col(moment).head(n);
    residual.head(n) = program->constraints(x).head(n);
    residual[n] = program->backbone().tip_angle() - angle;
    worst = residual.cwiseAbs().maxCoeff();
    if (worst <= 1e-13) break;
    const Eigen::VectorXd step = matrix.partialPivLu().solve(residual);
    x.head(n) -= step.head(n);
    x[moment] -= step[n];
  }
  return worst;
}

std::unique_ptr<Equilibrium> equilibrium_near(const RodBvp& bvp, const std::vector<double>& moments,
                                              const std::vector<BvpContact>& contacts,
                                              const std::vector<const Obstacle*>& obstacles, const BvpSolution& near,
                                              const Model& model, bool split) {
  const Rod rod = core_rod(bvp);
  const Chain chain(rod, *model, {}, 1);
  StartShape start;
  start.curvature = [&near](double s) { return near.at(s).curvature; };
  start.moments = moments;
  start.arc_lengths = near.arc_lengths;
  start.forces = near.forces;
  std::vector<ContactSetup> setups;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const int piece = chain.piece_at(near.arc_lengths[k], {});
    const int region = split ? chain.piece(piece).stretch : piece;
    setups.push_back({static_cast<int>(k), contacts[k].at_tip, region});
  }
  // The first contact's piece may be a neighbour of the one where the exact rod touches.
  for (const int shift : {0, -1, 1}) {
    if (split && shift != 0) break;
    std::vector<ContactSetup> tried = setups;
    if (!tried.empty()) tried[0].region += shift;
    if (!tried.empty() && (tried[0].region < 0 || tried[0].region >= chain.piece_count())) continue;
    auto candidate = std::make_unique<Equilibrium>(rod, model, moments, obstacles, tried, split);
    if (!(candidate->solve(start) <= 1e-11)) continue;
    bool inside = true;
    for (int k = 0; k < candidate->program->layout().arc_lengths; ++k) {
      const int variable = candidate->program->arc_length_variable(k);
      inside = inside && candidate->x[variable] >= candidate->program->lower()[variable] - 1e-12 &&
               candidate->x[variable] <= candidate->program->upper()[variable] + 1e-12;
    }
    if (inside) return candidate;
  }
  throw std::runtime_error("no equilibrium near the reference");
}

DimensionlessArm::DimensionlessArm() {
  rod.sections[0].density = 0.084 * 9.81 * length * length * length / stiffness;
  rod.gravity = {0.0, -1.0};
}

BvpSolution DimensionlessArm::brace(double moment) const {
  BvpGuess guess;
  guess.curvature = 0.4;
  guess.arc_lengths = {0.6};
  guess.forces = {1.4};
  return support::solve(rod, {moment}, {circle}, guess);
}

BvpContact table_circle(const ReferenceTable& table, std::size_t row) {
  return {{table.value(row, "x"), table.value(row, "y")}, table.value(row, "radius")};
}

BvpSolution press(const BvpContact& circle, double moment) {
  BvpGuess guess;
  guess.curvature = 0.7;
  guess.arc_lengths = {circle.center.x};
  guess.forces = {0.0};
  return follow(RodBvp{}, {0.7}, {moment}, {circle}, guess);
}

double printed(const ReferenceTable& table, std::size_t row, const std::string& column) {
  return 2.0 * table.rounding(row, column);
}

double order_of(double n1, double error1, double n2, double error2) {
  return std::log(error1 / error2) / std::log(n2 / n1);
}

}  // namespace tendril::support
