#include "curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace tendril::results {
namespace {

constexpr std::size_t width = 6;
/// (L) A row that is as close to a break stands on it.
constexpr double on_break = 1e-9;

/// Gauss-Legendre on [-1, 1], exact to degree 9.
constexpr std::array<std::pair<double, double>, 5> gauss{{{-0.9061798459386640, 0.2369268850561891},
                                                          {-0.5384693101056831, 0.4786286704993665},
                                                          {0.0, 0.5688888888888889},
                                                          {0.5384693101056831, 0.4786286704993665},
                                                          {0.9061798459386640, 0.2369268850561891}}};

template <class Value>
double lagrange(const std::vector<Curve::Row>& rows, const std::vector<std::size_t>& chosen, double s, Value value) {
  double sum = 0.0;
  for (const std::size_t i : chosen) {
    double factor = 1.0;
    for (const std::size_t k : chosen) {
      if (k != i) factor *= (s - rows[k].s) / (rows[i].s - rows[k].s);
    }
    sum += factor * value(rows[i]);
  }
  return sum;
}

}  // namespace

Curve::Curve(const nlohmann::json& rows, std::vector<double> breaks) : breaks_(std::move(breaks)) {
  for (const auto& row : rows) {
    rows_.push_back({row.at(0).get<double>(), row.at(1).get<double>(), row.at(2).get<double>(), row.at(3).get<double>(),
                     row.at(4).get<double>()});
  }
}

bool Curve::crosses_break(std::size_t i) const {
  const double slack = on_break * length();
  return std::any_of(breaks_.begin(), breaks_.end(),
                     [&](double b) { return b > rows_[i].s + slack && b < rows_[i + 1].s - slack; });
}

std::vector<std::size_t> Curve::stencil(std::size_t i, bool at_breaks) const {
  const double slack = on_break * length();
  const double middle = (rows_[i].s + rows_[i + 1].s) / 2.0;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  for (const double b : breaks_) (b <= middle ? low : high) = b <= middle ? std::max(low, b) : std::min(high, b);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const double s = rows_[k].s;
    const bool inside = at_breaks ? s >= low - slack && s <= high + slack : s > low + slack && s < high - slack;
    if (inside) chosen.push_back(k);
  }
  std::stable_sort(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(rows_[a].s - middle) < std::abs(rows_[b].s - middle);
  });
  if (chosen.size() > width) chosen.resize(width);
  return chosen;
}

double Curve::slope_error() const {
  double worst = 0.0;
  for (std::size_t i = 0; i + 1 < rows_.size(); ++i) {
    const std::vector<std::size_t> chosen = stencil(i, false);
    if (crosses_break(i) || chosen.size() < width) continue;
    const double half = (rows_[i + 1].s - rows_[i].s) / 2.0;
    double turned = 0.0;
    for (const auto& [place, weight] : gauss) {
      turned += weight * half *
                lagrange(rows_, chosen, rows_[i].s + half * (1.0 + place), [](const Row& r) { return r.curvature; });
    }
    const double error = std::abs(rows_[i + 1].angle - rows_[i].angle - turned);
    worst = error <= worst ? worst : error;  // what is not a number stays
  }
  return worst;
}

double Curve::unchecked_share() const {
  double length_left = 0.0;
  for (std::size_t i = 0; i + 1 < rows_.size(); ++i) {
    if (crosses_break(i) || stencil(i, false).size() < width) length_left += rows_[i + 1].s - rows_[i].s;
  }
  return length_left / length();
}

double Curve::angle_in(std::size_t i, double s) const {
  return lagrange(rows_, stencil(i, true), s, [](const Row& r) { return r.angle; });
}

Vec2 Curve::step(std::size_t i, double s) const {
  const double half = (s - rows_[i].s) / 2.0;
  Vec2 sum{};
  for (const auto& [place, weight] : gauss) {
    const double angle = angle_in(i, rows_[i].s + half * (1.0 + place));
    sum = sum + weight * half * Vec2{std::cos(angle), std::sin(angle)};
  }
  return sum;
}

double Curve::step_error() const {
  double worst = 0.0;
  for (std::size_t i = 0; i + 1 < rows_.size(); ++i) {
    if (crosses_break(i) || stencil(i, true).size() < width) continue;
    const Vec2 moved = step(i, rows_[i + 1].s);
    const double error = std::hypot(rows_[i + 1].x - rows_[i].x - moved.x, rows_[i + 1].y - rows_[i].y - moved.y);
    worst = error <= worst ? worst : error;
  }
  return worst;
}

std::size_t Curve::interval(double s) const {
  std::size_t i = 0;
  while (i + 2 < rows_.size() && rows_[i + 1].s <= s) ++i;
  return i;
}

double Curve::angle(double s) const { return angle_in(interval(s), s); }

Vec2 Curve::at(double s) const {
  const std::size_t i = interval(s);
  return Vec2{rows_[i].x, rows_[i].y} + step(i, s);
}

}  // namespace tendril::results
