#include "counterexample_support.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "nlp/feasibility.hpp"
#include "nlp/polish.hpp"
#include "obstacle/circle.hpp"

namespace tendril::support {

Reads Wish::reads() const {
  Reads r;
  r.tip_position = true;
  r.moments = true;
  r.contact_force = true;
  return r;
}

int Pose::add(std::unique_ptr<Obstacle> obstacle) {
  obstacles.push_back(std::move(obstacle));
  return static_cast<int>(obstacles.size()) - 1;
}

void Pose::assemble() {
  spec.rod = &rod;
  spec.model = &basis;
  spec.obstacles.clear();
  for (const auto& o : obstacles) spec.obstacles.push_back(o.get());
  spec.terms = {{&wish, 1.0, "wish"}};
  spec.nodes = suggested_nodes(basis.function_count(), 3.0);
  program = std::make_unique<PoseProgram>(spec);
  for (int k = 0; k < program->layout().forces; ++k) program->set_branch(k, Branch::touching);
  if (x.size() != program->variable_count()) x = Eigen::VectorXd::Zero(program->variable_count());
}

Eigen::VectorXd Pose::meet(const Eigen::VectorXd& from, const std::vector<Demand>& demands) {
  const PoseProgram::Layout& at = program->layout();
  const int rows = at.coordinates + 2 * at.forces;
  Eigen::VectorXd target = Eigen::VectorXd::Zero(rows);
  std::vector<Demand> variables;
  for (const Demand& d : demands) {
    if (d.kind == Demand::row) target[d.index] = d.value;
    if (d.kind == Demand::variable) variables.push_back(d);
  }
  const auto pinned = static_cast<Eigen::Index>(variables.size());
  Eigen::VectorXd y = from;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(rows + pinned, program->variable_count());
  Eigen::VectorXd right(rows + pinned);
  for (int iteration = 0; iteration < 30; ++iteration) {
    system.topRows(rows) = program->jacobian(y).topRows(rows);
    right.head(rows) = target - program->constraints(y).head(rows);
    for (Eigen::Index i = 0; i < pinned; ++i) {
      const Demand& d = variables[static_cast<std::size_t>(i)];
      system(rows + i, d.index) = 1.0;
      right[rows + i] = d.value - y[d.index];
    }
    // Twice after rounding is reached costs nothing.
    const Eigen::VectorXd step = system.completeOrthogonalDecomposition().solve(right);
    y += step;
    if (step.norm() < 1e-13) break;
  }
  return y;
}

void Pose::plan() {
  const PolishReport report = polish(*program, restore_feasibility(*program, x, 1e-13).x, {});
  EXPECT_TRUE(report.converged) << "the plan to be disturbed was not found: " << report.reason;
  x = report.x;
  multipliers = report.multipliers;
  bound_multipliers = report.bound_multipliers;
}

Certificate Pose::judge(const Eigen::VectorXd& at, const Eigen::VectorXd* rows, const Eigen::VectorXd* bounds) const {
  Certificate c;
  Certifier(spec).certify(*program, at, c, rows, bounds);
  // A judge that may read the program itself says the same.
  Certificate own;
  Certifier(*program).certify(*program, at, own, rows, bounds);
  EXPECT_EQ(own.failures.size(), c.failures.size());
  EXPECT_EQ(own.stationarity_kind, c.stationarity_kind);
  if (!at.allFinite()) return c;
  EXPECT_NEAR(own.equilibrium, c.equilibrium, 1e-11);
  EXPECT_NEAR(own.penetration, c.penetration, 1e-10 + 2e-3 * c.penetration);
  EXPECT_NEAR(own.stationarity, c.stationarity, 1e-9);
  return c;
}

std::unique_ptr<Pose> braced_pose() {
  auto pose = std::make_unique<Pose>();
  pose->rod.segments[0].weight = 1.682;
  pose->rod.gravity = {0.0, -1.0};
  pose->rod.actuators[0] = {0.0, 1.0, -2.0, 2.0};
  pose->add(std::make_unique<Circle>(Vec2{0.6, 0.0}, 0.08));
  pose->spec.contacts = {{0, false, 0}};
  pose->wish.tip = {0.95, 0.25};
  pose->wish.tip_weight = 1.0;
  pose->wish.moment_weight = 0.1;
  pose->assemble();
  StartShape start = constant_curvature(0.4);
  start.moments = {0.5};
  start.arc_lengths = {0.6};
  start.forces = {1.4};
  pose->x = pose->program->start_from(start);
  pose->plan();
  return pose;
}

template <class F>
auto PlainRod::integral(double from, double to, const F& f) const {
  constexpr std::array<double, 5> places{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                                         0.9061798459386640};
  constexpr std::array<double, 5> weights{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                          0.4786286704993665, 0.2369268850561891};
  constexpr int panels = 24;  // per piece: h^10 of the rule is below rounding
  decltype(f(0.0)) sum{};
  double start = 0.0;
  for (const double end : ends) {
    const double low = std::max(from, start);
    const double high = std::min(to, end);
    start = end;
    if (!(high > low)) continue;
    const double half = 0.5 * (high - low) / panels;
    for (int i = 0; i < panels; ++i) {
      for (std::size_t g = 0; g < 5; ++g) sum += half * weights[g] * f(low + (2 * i + 1 + places[g]) * half);
    }
  }
  return sum;
}

double PlainRod::angle(const Eigen::VectorXd& q, double s) const {
  double phi = base_angle;
  double start = 0.0;
  for (std::size_t j = 0; j < ends.size(); ++j) {
    const auto first = static_cast<Eigen::Index>(j) * order;
    if (s >= ends[j] && j + 1 < ends.size()) {
      phi += q[first];  // only the first function does not vanish at the end of a piece
      start = ends[j];
      continue;
    }
    const double sigma = (s - start) / (ends[j] - start);
    phi += q[first] * sigma;
    for (int i = 2; i <= order; ++i) {
      const auto n = static_cast<unsigned>(i);
      const double z = 2.0 * sigma - 1.0;
      phi += q[first + i - 1] * (std::legendre(n, z) - std::legendre(n - 2, z)) / (2.0 * (2.0 * i - 1.0));
    }
    break;
  }
  return phi;
}

double PlainRod::curvature(const Eigen::VectorXd& q, double s) const {
  std::size_t j = 0;
  while (j + 1 < ends.size() && s >= ends[j]) ++j;
  const double start = j == 0 ? 0.0 : ends[j - 1];
  const double length = ends[j] - start;
  double sum = 0.0;
  for (int i = 1; i <= order; ++i) {
    const double z = 2.0 * (s - start) / length - 1.0;
    sum += q[static_cast<Eigen::Index>(j) * order + i - 1] * std::legendre(static_cast<unsigned>(i - 1), z);
  }
  return sum / length;
}

Vec2 PlainRod::point(const Eigen::VectorXd& q, double s) const {
  const auto x = integral(0.0, s, [&](double at) { return std::cos(angle(q, at)); });
  const auto y = integral(0.0, s, [&](double at) { return std::sin(angle(q, at)); });
  return base + Vec2{x, y};
}

double PlainRod::energy(const Eigen::VectorXd& q, double moment) const {
  const double bending = integral(0.0, 1.0, [&](double s) {
    const double kappa = curvature(q, s);
    return 0.5 * kappa * kappa;
  });
  // The weight beyond s pulls the tangent there along -y.
  const double weighing = integral(0.0, 1.0, [&](double s) { return weight * (1.0 - s) * std::sin(angle(q, s)); });
  return bending + weighing - moment * (angle(q, 1.0) - base_angle) - dot(tip_force, point(q, 1.0));
}

PlainRod plain(const Pose& pose, const Eigen::VectorXd& x) {
  PlainRod rod;
  rod.order = pose.basis.function_count();
  rod.weight = pose.rod.has_gravity() ? pose.rod.segments[0].weight : 0.0;
  rod.base = pose.rod.base;
  rod.base_angle = pose.rod.base_angle;
  rod.tip_force = pose.rod.tip_force;
  rod.ends.clear();
  if (pose.spec.split) {
    for (int k = 0; k < pose.program->layout().arc_lengths; ++k) rod.ends.push_back(x[pose.place() + k]);
  }
  rod.ends.push_back(1.0);
  return rod;
}

testing::AssertionResult certified(const Certificate& c) {
  if (c.valid()) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  failure << "refused:";
  for (const std::string& line : c.failures) failure << "\n  " << line;
  return failure;
}

testing::AssertionResult refused(const Certificate& c, const std::string& name, double value, double tolerance) {
  if (c.valid()) return testing::AssertionFailure() << "certified, although '" << name << "' is " << value;
  const std::string& line = c.failures.front();
  const double told = line.size() > name.size() ? std::strtod(line.c_str() + name.size(), nullptr) : 0.0;
  const bool one = c.failures.size() == 1 && line.compare(0, name.size(), name) == 0;
  if (one && std::abs(told - value) <= tolerance * std::abs(value)) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  failure << "expected one line '" << name << ' ' << value << "', found:";
  for (const std::string& each : c.failures) failure << "\n  " << each;
  return failure;
}

}  // namespace tendril::support
