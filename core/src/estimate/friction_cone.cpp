#include "estimate/friction_cone.hpp"

#include <algorithm>

namespace tendril {
namespace {

constexpr int most_steps_in_the_cone = 200;
/// From a state without friction to the edge of its cone: what the points allow is told to a sixth of the coefficient.
constexpr int steps = 6;

}  // namespace

std::vector<const ShapeFit*> ConeFits::allowed(double most) const {
  std::vector<bool> counts(fits.size());
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (fits[i].sum <= most) counts[i] = counts[before[i]] = true;
    if (fits[before[i]].sum <= most) counts[i] = true;
  }
  std::vector<const ShapeFit*> out{&best};
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (counts[i]) out.push_back(&fits[i]);
  }
  return out;
}

ConeFits fit_cone(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit, double friction,
                  double accuracy, const Deadline& deadline) {
  ConeFits out;
  out.fits.push_back(fit);
  out.before.push_back(0);
  out.best = fit;
  const int contacts = fit.contacts();
  if (friction == 0.0 || contacts == 0) return out;
  const int second = contacts == 1 ? 0 : 1;
  for (int a = -1; a <= 1; ++a) {
    for (int b = -second; b <= second; ++b) {
      if (a == 0 && b == 0) continue;
      std::size_t at = 0;
      for (int step = 1; step <= steps && !deadline.over(); ++step) {
        const LoadedRod::Shape& from = out.fits[at].shape;
        std::vector<NormalForce> forces = from.forces;
        for (std::size_t k = 0; k < forces.size(); ++k) forces[k].lean = friction * (k == 0 ? a : b) * step / steps;
        ShapeFit next = fit_shape(rod, measured, rod.solve(forces, from), accuracy, most_steps_in_the_cone, deadline);
        if (!next.converged) {
          out.whole = false;
          break;
        }
        out.before.push_back(at);
        at = out.fits.size();
        out.fits.push_back(std::move(next));
      }
    }
  }
  const auto nearest = std::min_element(out.fits.begin(), out.fits.end(),
                                        [](const ShapeFit& x, const ShapeFit& y) { return x.sum < y.sum; });
  out.best = fit_shape(rod, measured, nearest->shape, accuracy, most_steps_in_the_cone, deadline, friction);
  if (!out.best.converged) out.best = *nearest;
  return out;
}

}  // namespace tendril
