#include "estimate/truth.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tendril::test {

using support::BvpSolution;
using support::Point;

BvpSolution Truth::solve() const { return support::solve(rod, moments, circles, guess); }

Eigen::VectorXd parameters(const Truth& truth, const BvpSolution& solution) {
  Eigen::VectorXd out(2 * static_cast<Eigen::Index>(truth.circles.size()));
  for (std::size_t k = 0; k < truth.circles.size(); ++k) {
    const double s = solution.arc_lengths[k];
    const support::BvpState state = solution.at(s);
    const double nx = state.x - truth.circles[k].center.x;
    const double ny = state.y - truth.circles[k].center.y;
    const double side = -std::sin(state.angle) * nx + std::cos(state.angle) * ny;
    out[2 * static_cast<Eigen::Index>(k)] = std::copysign(1.0, side) * solution.forces[k];
    out[2 * static_cast<Eigen::Index>(k) + 1] = s;
  }
  return out;
}

Eigen::VectorXd exact_points(const Truth& truth, const BvpSolution& solution, int count) {
  Eigen::VectorXd out(2 * static_cast<Eigen::Index>(count));
  for (int i = 0; i < count; ++i) {
    const support::BvpState p = solution.at(truth.length() * (i + 1) / count);
    out[2 * i] = p.x;
    out[2 * i + 1] = p.y;
  }
  return out;
}

Scene scene_of(const Truth& truth, const Eigen::VectorXd& points, double noise, int contacts) {
  Scene scene;
  scene.problem = ProblemKind::estimate;
  const support::RodBvp& rod = truth.rod;
  for (const support::RodSection& s : rod.sections) {
    scene.rod.segments.push_back({s.length, s.stiffness, s.density, s.rest_curvature});
  }
  for (const support::MomentSpan& a : rod.actuators) scene.rod.actuators.push_back({a.from, a.to});
  scene.rod.base_position = {rod.base.x, rod.base.y};
  scene.rod.base_angle = rod.base_angle;
  if (rod.gravity.x != 0.0 || rod.gravity.y != 0.0) scene.gravity = Vec2{rod.gravity.x, rod.gravity.y};
  scene.tip_load = {rod.payload, {rod.tip_force.x, rod.tip_force.y}};
  scene.contact.count = contacts;
  scene.measurement.noise = noise;
  scene.measurement.moments = truth.moments;
  const Eigen::Index count = points.size() / 2;
  for (Eigen::Index i = 0; i < count; ++i) {
    scene.measurement.points.push_back(
        {truth.length() * static_cast<double>(i + 1) / static_cast<double>(count), {points[2 * i], points[2 * i + 1]}});
  }
  return scene;
}

Eigen::MatrixXd cramer_rao(const Truth& truth, int points, double noise) {
  const BvpSolution centre = truth.solve();
  const auto unknowns = 2 * static_cast<Eigen::Index>(truth.circles.size());
  Eigen::MatrixXd point_rates(2 * points, unknowns);
  Eigen::MatrixXd parameter_rates(unknowns, unknowns);
  const double step = 1e-5 * truth.length();
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    Eigen::VectorXd p[2];
    Eigen::VectorXd q[2];
    for (int side = 0; side < 2; ++side) {
      Truth moved = truth;
      moved.guess = centre.guess();
      Point& c = moved.circles[static_cast<std::size_t>(i / 2)].center;
      (i % 2 == 0 ? c.x : c.y) += side == 0 ? -step : step;
      const BvpSolution solution = moved.solve();
      p[side] = exact_points(moved, solution, points);
      q[side] = parameters(moved, solution);
    }
    point_rates.col(i) = (p[1] - p[0]) / (2.0 * step);
    parameter_rates.col(i) = (q[1] - q[0]) / (2.0 * step);
  }
  const Eigen::MatrixXd rates = point_rates * parameter_rates.inverse();
  // Force and length differ in size; the inverse should not see that.
  const Eigen::VectorXd size = rates.colwise().norm();
  const Eigen::MatrixXd scaled = rates * size.cwiseInverse().asDiagonal();
  return noise * noise * size.cwiseInverse().asDiagonal() * (scaled.transpose() * scaled).inverse() *
         size.cwiseInverse().asDiagonal();
}

double NormalNumbers::uniform() {
  // 53 bits, never 0.
  return (static_cast<double>(bits_() >> 11U) + 0.5) * 0x1p-53;
}

double NormalNumbers::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Eigen::VectorXd noisy(const Eigen::VectorXd& points, double noise, std::uint64_t seed) {
  NormalNumbers normal(seed);
  Eigen::VectorXd out = points;
  for (double& v : out) v += noise * normal();
  return out;
}

std::string measurement_file() {
  const Truth arm = braced_arm();
  constexpr int count = 20;
  const Eigen::VectorXd points = noisy(exact_points(arm, arm.solve(), count), 5e-5, 1);
  std::string out =
      "# Exact shape of the braced arm (boundary-value problem) with normal noise of 0.05 mm on x and y.\n"
      "s [mm], x [mm], y [mm]\n";
  for (int i = 0; i < count; ++i) {
    char line[80];
    std::snprintf(line, sizeof line, "%g, %.3f, %.3f\n", 1e3 * arm.length() * (i + 1) / count, 1e3 * points[2 * i],
                  1e3 * points[2 * i + 1]);
    out += line;
  }
  return out;
}

Truth braced_arm() {
  Truth t;
  t.rod.sections = {{0.1, 4.9e-4, 0.084, 0.0}};
  t.rod.actuators = {{0.0, 0.1}};
  t.rod.gravity = {0.0, -9.81};
  t.moments = {2.5e-3};
  t.circles = {{{0.06, 0.0}, 0.008}};
  t.guess.curvature = 4.0;
  t.guess.arc_lengths = {0.06};
  t.guess.forces = {0.07};
  return t;
}

Truth held_from_above() {
  Truth t;
  t.moments = {2.0};
  t.circles = {{{0.55, 0.35}, 0.1}};
  t.guess.curvature = 1.0;
  t.guess.arc_lengths = {0.6};
  t.guess.forces = {2.0};
  return t;
}

Truth stepped_finger() {
  Truth t;
  t.rod.sections = {{0.07, 0.01, 0.15, 0.0}, {0.03, 0.006, 0.1, 3.0}};
  t.rod.actuators = {{0.0, 0.07}, {0.07, 0.1}};
  t.rod.gravity = {3.0, -8.0};
  t.rod.base = {0.02, -0.01};
  t.rod.base_angle = 0.7;
  t.rod.payload = 0.01;
  t.moments = {0.08, 0.05};
  // On the inner side of the bent finger.
  const BvpSolution free = support::solve(t.rod, t.moments);
  const support::BvpState at = free.at(0.082);
  const double radius = 0.01;
  const double deep = 0.004;
  t.circles = {{{at.x - (radius - deep) * std::sin(at.angle), at.y + (radius - deep) * std::cos(at.angle)}, radius}};
  t.guess = free.guess();
  t.guess.arc_lengths = {0.082};
  t.guess.forces = {0.5};
  return t;
}

namespace {

Truth between_circles(double first, double second, double deep) {
  Truth t;
  t.moments = {1.0};
  t.rod.gravity = {0.0, -1.0};
  t.rod.sections = {{1.0, 1.0, 0.5, 0.0}};
  const BvpSolution free = support::solve(t.rod, t.moments);
  const double radius = 0.08;
  const auto circle = [&](double s, double side) {
    const support::BvpState at = free.at(s);
    const double off = side * (radius - deep);
    return support::BvpContact{{at.x - off * std::sin(at.angle), at.y + off * std::cos(at.angle)}, radius};
  };
  t.circles = {circle(first, 1.0), circle(second, -1.0)};
  t.guess = free.guess();
  t.guess.arc_lengths = {first, second};
  t.guess.forces = {5.0, 5.0};
  return t;
}

}  // namespace

Truth two_pegs() { return between_circles(0.4, 0.8, 0.05); }

Truth close_pegs() { return between_circles(0.5, 0.56, 0.002); }

Campaign run_campaign(const Truth& truth, int points, double noise, bool noise_given, int contacts, int runs,
                      std::uint64_t first_seed) {
  const BvpSolution solution = truth.solve();
  const Eigen::VectorXd exact = exact_points(truth, solution, points);
  const Eigen::VectorXd right = parameters(truth, solution);
  const Eigen::VectorXd bound = cramer_rao(truth, points, noise).diagonal().cwiseSqrt();
  const Eigen::Index n = right.size();
  Campaign out;
  out.runs = runs;
  out.mean = out.deviation = out.within_1 = out.within_2 = Eigen::VectorXd::Zero(n);
  int counted = 0;
  for (int run = 0; run < runs; ++run) {
    const Eigen::VectorXd measured = noisy(exact, noise, first_seed + static_cast<std::uint64_t>(run));
    const Estimate estimate = tendril::estimate(scene_of(truth, measured, noise_given ? noise : 0.0, contacts));
    if (estimate.status == EstimateStatus::solved) ++out.solved;
    if (static_cast<Eigen::Index>(2 * estimate.contacts.size()) != n) {
      ++out.wrong_count;
      continue;
    }
    ++counted;
    for (Eigen::Index i = 0; i < n; ++i) {
      const EstimatedContact& c = estimate.contacts[static_cast<std::size_t>(i / 2)];
      const bool force = i % 2 == 0;
      const double side = -std::sin(solution.at(right[2 * (i / 2) + 1]).angle) * c.normal.x +
                          std::cos(solution.at(right[2 * (i / 2) + 1]).angle) * c.normal.y;
      const double value = force ? std::copysign(c.force, side) : c.arc_length;
      const double off = value - right[i];
      const double error = force ? c.force_error : c.arc_length_error;
      out.mean[i] += off / bound[i];
      out.deviation[i] += off * off / (bound[i] * bound[i]);
      out.within_1[i] += std::abs(off) <= error ? 1.0 : 0.0;
      out.within_2[i] += std::abs(off) <= 1.959963984540054 * error ? 1.0 : 0.0;
    }
  }
  if (counted < 2) return out;
  out.mean /= counted;
  out.deviation = ((out.deviation - counted * out.mean.cwiseAbs2()) / (counted - 1)).cwiseSqrt();
  out.within_1 /= counted;
  out.within_2 /= counted;
  return out;
}

std::string Campaign::text() const {
  std::string out = "runs " + std::to_string(runs) + ", solved " + std::to_string(solved) +
                    ", other number of contacts " + std::to_string(wrong_count) + '\n';
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    char line[160];
    std::snprintf(line, sizeof line, "  %s %d: mean %+.3f, deviation %.3f, within one error %.3f, within 1.96 %.3f\n",
                  i % 2 == 0 ? "force" : "place", static_cast<int>(i / 2) + 1, mean[i], deviation[i], within_1[i],
                  within_2[i]);
    out += line;
  }
  return out;
}

}  // namespace tendril::test
