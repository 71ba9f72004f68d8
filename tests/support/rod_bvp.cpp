#include "support/rod_bvp.hpp"

#include <algorithm>
#include <numeric>

#include "support/rod_flow.hpp"
#include "support/rod_shooting.hpp"

namespace tendril::support {

double RodBvp::length() const {
  return std::accumulate(sections.begin(), sections.end(), 0.0,
                         [](double sum, const RodSection& s) { return sum + s.length; });
}

BvpState BvpSolution::at(double s) const {
  auto it = std::upper_bound(intervals.begin(), intervals.end(), s,
                             [](double value, const Interval& interval) { return value < interval.begin; });
  if (it != intervals.begin()) --it;
  const Field<double> f{it->stiffness, it->free_curvature, it->weight};
  const State<double> z = flow(f, it->state, s - it->begin);
  return {z[kX], z[kY], z[kAngle], rate(f, z)[kAngle], z[kMoment], {z[kForceX], z[kForceY]}};
}

BvpGuess BvpSolution::guess() const {
  BvpGuess g;
  g.angle = [copy = *this](double s) { return copy.at(s).angle; };
  g.arc_lengths = arc_lengths;
  g.forces = forces;
  return g;
}

BvpSolution solve(const RodBvp& rod, const std::vector<double>& moments, const std::vector<BvpContact>& contacts,
                  const BvpGuess& guess, const BvpOptions& options) {
  return Shooting(rod, moments, contacts, guess, options, std::nullopt, 0.0).run();
}

BvpSolution solve_tip_angle(const RodBvp& rod, const std::vector<double>& moments, std::size_t free_actuator,
                            double tip_angle, const std::vector<BvpContact>& contacts, const BvpGuess& guess,
                            const BvpOptions& options) {
  return Shooting(rod, moments, contacts, guess, options, free_actuator, tip_angle).run();
}

BvpSolution follow(const RodBvp& rod, const std::vector<double>& first, const std::vector<double>& last,
                   const std::vector<BvpContact>& contacts, const BvpGuess& guess, const BvpOptions& options) {
  if (first.size() != last.size()) throw BvpError("both ends of the way need one moment per actuator");
  BvpSolution here = solve(rod, first, contacts, guess, options);
  double done = 0.0;
  double step = 0.125;
  while (done < 1.0) {
    const double next = std::min(1.0, done + step);
    std::vector<double> moments;
    for (std::size_t j = 0; j < first.size(); ++j) moments.push_back((1.0 - next) * first[j] + next * last[j]);
    try {
      here = solve(rod, moments, contacts, here.guess(), options);
      done = next;
      step *= 2.0;
    } catch (const BvpError&) {
      step *= 0.5;
      if (step < 1e-4) throw;
    }
  }
  return here;
}

}  // namespace tendril::support
