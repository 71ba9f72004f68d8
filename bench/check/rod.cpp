#include "check/rod.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "check/gauss_rule.hpp"
#include "tendril/error.hpp"

namespace tendril::bench {
namespace {

/// Places along the rod are data too (model.md section 1). Unrounded ones would differ by 1e-12, and the curvature of a
/// short piece by that over its length.
double rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.11e", value);
  return std::strtod(text.data(), nullptr);
}

/// Values (or slopes) of the local basis at sigma: the integrated Legendre polynomials of model.md section 2.
void basis(int order, double sigma, bool slope, Eigen::Ref<Eigen::VectorXd> out) {
  const double x = std::clamp(2.0 * sigma - 1.0, -1.0, 1.0);
  for (int i = 1; i <= order; ++i) {
    const auto n = static_cast<unsigned>(i);
    if (slope) {
      out[i - 1] = std::legendre(n - 1, x);
    } else {
      out[i - 1] = i == 1 ? sigma : (std::legendre(n, x) - std::legendre(n - 2, x)) / (2.0 * (2.0 * i - 1.0));
    }
  }
}

}  // namespace

Loaded::Loaded(const Scene& scene, const Plan& plan) {
  const double length = scene.rod.length();
  const double stiffness = scene.rod.segments.front().bending_stiffness;
  const double unit_force = stiffness / (length * length);
  double at = 0.0;
  const double g = scene.gravity ? norm(*scene.gravity) : 0.0;
  if (g > 0.0) gravity = (1.0 / g) * *scene.gravity;
  for (const SegmentSpec& s : scene.rod.segments) {
    const double to = rounded(at + s.length / length);
    const double weight = s.linear_density * g * length / unit_force;
    segments.push_back({at, to, s.bending_stiffness / stiffness, weight, s.rest_curvature * length});
    loads += weight * (to - at) + std::abs(segments.back().rest) * segments.back().stiffness;
    at = to;
  }
  for (std::size_t a = 0; a < scene.rod.actuators.size(); ++a) {
    const ActuatorSpec& spec = scene.rod.actuators[a];
    actuators.push_back(
        {rounded(spec.from / length), rounded(spec.to / length), plan.moments.at(a) / (unit_force * length)});
    loads += std::abs(actuators.back().moment);
  }
  base = (1.0 / length) * scene.rod.base_position;
  base_angle = scene.rod.base_angle;
  tip_force = (1.0 / unit_force) * scene.tip_load.force + (scene.tip_load.mass * g / unit_force) * gravity;
  loads += norm(tip_force);
}

std::vector<double> Loaded::knots() const {
  std::vector<double> ends{0.0, 1.0};
  for (const Stretch& s : segments) ends.push_back(s.to);
  for (const Span& a : actuators) ends.insert(ends.end(), {a.from, a.to});
  std::sort(ends.begin(), ends.end());
  // What the rounding of sums leaves apart is one knot.
  ends.erase(std::unique(ends.begin(), ends.end(), [](double a, double b) { return b - a < 1e-9; }), ends.end());
  ends.front() = 0.0;
  ends.back() = 1.0;
  return ends;
}

RodShape::RodShape(const Loaded& rod, const std::vector<double>& moving, Eigen::Index coordinates, int order)
    : rod_(rod), order_(order) {
  std::vector<double> knots = rod_.knots();
  knots.insert(knots.end(), moving.begin(), moving.end());
  std::sort(knots.begin(), knots.end());
  const auto total = static_cast<std::size_t>(coordinates / order_);
  const std::size_t stretches = knots.size() - 1;
  if (total == 0 || total % stretches != 0) throw Error("the plan's coordinates do not fit its pieces");
  const std::size_t parts = total / stretches;
  for (std::size_t r = 0; r < stretches; ++r) {
    const double h = (knots[r + 1] - knots[r]) / static_cast<double>(parts);
    for (std::size_t p = 0; p < parts; ++p) {
      Piece piece{knots[r] + h * static_cast<double>(p), h, 0};
      const double middle = piece.from + 0.5 * h;
      while (piece.segment + 1 < rod_.segments.size() && rod_.segments[piece.segment].to < middle) ++piece.segment;
      pieces_.push_back(piece);
    }
  }
}

RodShape::Grid RodShape::grid(const Eigen::VectorXd& q, const std::vector<double>& cuts) const {
  Grid g;
  double angle = rod_.base_angle;
  Vec2 at = rod_.base;
  std::vector<Eigen::VectorXd> slopes;
  Eigen::VectorXd value(order_);
  Eigen::VectorXd slope(order_);
  for (std::size_t j = 0; j < pieces_.size(); ++j) {
    const Piece& piece = pieces_[j];
    const Eigen::VectorXd own = q.segment(static_cast<Eigen::Index>(j) * order_, order_);
    const int panels = 4 + order_ / 5 + static_cast<int>(std::min(200.0, own.cwiseAbs().sum()));
    std::vector<double> ends;
    for (int i = 0; i <= panels; ++i) ends.push_back(static_cast<double>(i) / panels);
    for (const double cut : cuts) {
      const double sigma = (cut - piece.from) / piece.length;
      if (sigma > 1e-12 && sigma < 1.0 - 1e-12) ends.push_back(sigma);
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      const double width = ends[e + 1] - ends[e];
      if (!(width > 0.0)) continue;
      const double h = width * piece.length;
      std::array<Vec2, rule_size> tangent;
      for (std::size_t i = 0; i < rule_size; ++i) {
        const double sigma = ends[e] + width * rule().node[i];
        basis(order_, sigma, false, value);
        basis(order_, sigma, true, slope);
        g.s.push_back(piece.from + sigma * piece.length);
        g.weight.push_back(h * rule().weight[i]);
        g.angle.push_back(angle + own.dot(value));
        g.curvature.push_back(own.dot(slope) / piece.length);
        g.piece.push_back(j);
        slopes.emplace_back(slope / piece.length);
        tangent[i] = {std::cos(g.angle.back()), std::sin(g.angle.back())};
      }
      Vec2 whole{};
      for (std::size_t i = 0; i < rule_size; ++i) {
        Vec2 partial{};
        for (std::size_t k = 0; k < rule_size; ++k) {
          partial += rule().to_node(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * tangent[k];
        }
        g.at.push_back(at + h * partial);
        whole += rule().weight[i] * tangent[i];
      }
      at += h * whole;
    }
    basis(order_, 1.0, false, value);
    angle += own.dot(value);
  }
  g.tip = at;
  g.tip_angle = angle;
  g.slopes.resize(order_, static_cast<Eigen::Index>(slopes.size()));
  for (std::size_t i = 0; i < slopes.size(); ++i) g.slopes.col(static_cast<Eigen::Index>(i)) = slopes[i];
  add_weight(g);
  return g;
}

/// From the tip to the base: the weight beyond each node and its first moment.
void RodShape::add_weight(Grid& g) const {
  g.load.resize(g.s.size());
  g.load_moment.resize(g.s.size());
  double beyond = 0.0;
  Vec2 moment_beyond{};
  for (std::size_t panel = g.s.size() / rule_size; panel-- > 0;) {
    const std::size_t first = panel * rule_size;
    const double rho = rod_.segments[pieces_[g.piece[first]].segment].weight;
    double h = 0.0;
    for (std::size_t i = 0; i < rule_size; ++i) h += g.weight[first + i];
    for (std::size_t i = 0; i < rule_size; ++i) {
      double weight = 0.0;
      Vec2 moment{};
      for (std::size_t k = 0; k < rule_size; ++k) {
        const double w =
            h * rho * (rule().weight[k] - rule().to_node(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
        weight += w;
        moment += w * g.at[first + k];
      }
      g.load[first + i] = beyond + weight;
      g.load_moment[first + i] = moment_beyond + moment;
    }
    for (std::size_t k = 0; k < rule_size; ++k) {
      beyond += h * rho * rule().weight[k];
      moment_beyond += (h * rho * rule().weight[k]) * g.at[first + k];
    }
  }
}

RodShape::Point RodShape::point(const Eigen::VectorXd& q, double s) const {
  Point p{rod_.base, rod_.base_angle};
  Eigen::VectorXd value(order_);
  for (std::size_t j = 0; j < pieces_.size(); ++j) {
    const Piece& piece = pieces_[j];
    const bool last = s <= piece.from + piece.length || j + 1 == pieces_.size();
    const double end = last ? (s - piece.from) / piece.length : 1.0;
    const Eigen::VectorXd own = q.segment(static_cast<Eigen::Index>(j) * order_, order_);
    const int panels = 2 + order_ / 5 + static_cast<int>(std::min(200.0, own.cwiseAbs().sum()));
    for (int e = 0; e < panels; ++e) {
      const double width = end / panels;
      for (std::size_t i = 0; i < rule_size; ++i) {
        basis(order_, width * (e + rule().node[i]), false, value);
        const double angle = p.angle + own.dot(value);
        p.at += (piece.length * width * rule().weight[i]) * Vec2{std::cos(angle), std::sin(angle)};
      }
    }
    basis(order_, end, false, value);
    p.angle += own.dot(value);
    if (last) break;
  }
  return p;
}

}  // namespace tendril::bench
