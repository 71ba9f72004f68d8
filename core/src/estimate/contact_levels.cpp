#include "estimate/contact_levels.hpp"

#include <Eigen/QR>
#include <cmath>

#include "estimate/friction_cone.hpp"
#include "estimate/significance.hpp"

namespace tendril {

double chance_of_improvement(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fewer,
                             const ShapeFit& best) {
  // Fine enough for the length of a smooth curve.
  const std::vector<NormalForce> places = spread_places(120);
  const double curve = curve_length(influence_of(rod, measured, fewer, places), fewer.response.rates, 1e-3);
  const double variance = measured.variance(best.sum, best.contacts());
  const int degrees = measured.noise > 0.0 ? 0 : measured.degrees_of_freedom(best.contacts());
  return improvement_probability((fewer.sum - best.sum) / variance, curve, degrees);
}

std::vector<Level> fit_levels(const LoadedRod& rod, const MeasuredShape& measured, int most_contacts, double friction,
                              double most_chance, const Deadline& deadline, int& starts) {
  const LoadedRod::Curvature curvature = measured_curvature(rod.rod(), measured);
  std::vector<Level> levels;
  for (int contacts = 0; contacts <= most_contacts; ++contacts) {
    Level level;
    level.contacts = contacts;
    const ShapeFit none;
    const ShapeFit& fewer = contacts == 0 || levels.back().fits.empty() ? none : levels.back().best;
    if (contacts == 0) {
      level.fits = {fit_shape(rod, measured, rod.solve({}, curvature), search_accuracy, 1, deadline)};
    } else {
      level.fits = search(rod, measured, curvature, contacts, fewer, deadline, starts);
    }
    if (deadline.over()) return levels;
    std::erase_if(level.fits, [](const ShapeFit& f) { return !std::isfinite(f.sum); });
    // Without an equilibrium of fewer contacts only more of them can explain the shape.
    level.supported = level.converged();
    if (contacts > 0) level.probability = level.converged() ? 0.0 : 1.0;
    if (level.converged()) {
      level.best = fit_cone(rod, measured, level.fits.front(), friction, search_accuracy, deadline).best;
    }
    if (contacts > 0 && level.converged() && !levels.back().fits.empty()) {
      level.probability = chance_of_improvement(rod, measured, fewer, level.best);
      level.supported = level.probability < most_chance;
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

const Level* supported_level(const std::vector<Level>& levels) {
  const Level* out = nullptr;
  for (const Level& level : levels) {
    if (level.supported) out = &level;
  }
  return out;
}

Eigen::MatrixXd covariance_of(const ShapeFit& fit, double variance) {
  const Eigen::MatrixXd& j = fit.response.rates;
  // Columns differ in size by their units; the factorization should not see that.
  const Eigen::VectorXd size = j.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = j * size.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::Index n = j.cols();
  const Eigen::MatrixXd r = qr.matrixQR().topLeftCorner(n, n).triangularView<Eigen::Upper>();
  const Eigen::MatrixXd inverse =
      size.cwiseInverse().asDiagonal() * r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n)).eval();
  return variance * inverse * inverse.transpose();
}

}  // namespace tendril
