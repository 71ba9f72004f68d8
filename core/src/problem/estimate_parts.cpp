#include "problem/estimate_parts.hpp"

#include <algorithm>
#include <cmath>

#include "base/deadline.hpp"
#include "estimate/contact_levels.hpp"
#include "estimate/significance.hpp"

namespace tendril {
namespace {

/// A force is a number only if its standard deviation is within this fraction of it, and a place only if it is known to
/// this part of the rod's length (model.md section 6).
constexpr double largest_relative_error = 0.1;
/// Residuals larger than this often by chance alone mean that the model does not fit.
constexpr double least_fit_probability = 1e-6;
/// Residuals as many times smaller than the noise, and that so seldom by chance, are asked about.
constexpr double least_doubt_of_noise = 2.0;
/// Where the noise is not known, residuals as large as this (units of L) are none, and from this on a row of them that
/// is too smooth to be noise is told.
constexpr double no_noise = 0.05;
constexpr double least_misfit = 1e-3;

/// Other axes that explain points which those of the scene do not, in words that follow "; ". Empty: none do.
std::string axes_hint(const EstimateInput& in, const MeasuredShape& seen, const std::vector<double>& moments,
                      const Deadline& deadline) {
  for (const OtherAxes& axes : other_axes) {
    MeasuredShape shape = seen;
    shape.before = {};
    for (Eigen::Index i = 0; i < shape.points.size(); i += 2) {
      const Vec2 p = in.rod.base + axes.seen(Vec2{seen.points[i], seen.points[i + 1]} - in.rod.base);
      shape.points.segment<2>(i) << p.x, p.y;
    }
    const LoadedRod rod(in.rod, moments, first_order, most_turn(in.rod, shape));
    int starts = 0;
    const std::vector<Level> levels =
        fit_levels(rod, shape, in.most_contacts, in.friction, significance, deadline, starts);
    const Level* chosen = supported_level(levels);
    if (deadline.over()) return "";
    if (chosen == nullptr || !misfit(shape, in.scale.length, chosen->best.residual, chosen->contacts).empty()) continue;
    return std::string("; as if ") + axes.name + " they are explained: are their axes right ('y_down')?";
  }
  return "";
}

}  // namespace

std::string misfit(const MeasuredShape& measured, double length, const Eigen::VectorXd& residual, int contacts) {
  const double sum = residual.squaredNorm();
  const double rms = std::sqrt(sum / static_cast<double>(residual.size()));
  if (measured.noise > 0.0) {
    const int degrees = measured.degrees_of_freedom(contacts);
    const double chi_square = sum / measured.variance(sum, contacts);
    if (chi_square_probability(chi_square, degrees) >= least_fit_probability) return "";
    return "the residuals are larger than the noise (chi-square " + shown(chi_square, 3) + " with " +
           std::to_string(degrees) + " degrees of freedom)";
  }
  const std::string size = "the residuals of " + shown(rms * length, 3) + " m ";
  if (rms > no_noise) return size + "are too large for noise";
  if (rms > least_misfit && smooth_probability(residual) < least_fit_probability) {
    return size + "change too smoothly along the rod to be noise";
  }
  return "";
}

std::string hint_of(const EstimateInput& in, const MeasuredShape& seen, const std::vector<double>& moments,
                    const Deadline& deadline) {
  const std::string axes = axes_hint(in, seen, moments, deadline);
  return axes.empty() ? misfit_hint(in.rod, seen, moments, in.equal_spacing, in.scale.length) : axes;
}

std::string doubt_of_noise(double chi_square, int degrees) {
  const double times = std::sqrt(static_cast<double>(degrees) / chi_square);
  if (degrees < 1 || times < least_doubt_of_noise) return "";
  if (1.0 - chi_square_probability(chi_square, degrees) >= least_fit_probability) return "";
  return "the residuals are " + shown(times, 3) +
         " times smaller than the noise: is 'noise' right? What is smaller than it counts as chance";
}

EstimatedContact contact_of(const Scale& scale, const NormalForce& force, const LoadedRod::Point& at,
                            const Eigen::Matrix2d& covariance) {
  const double side = force.force < 0.0 ? -1.0 : 1.0;
  EstimatedContact c;
  c.arc_length = force.arc_length * scale.length;
  c.force = std::abs(force.force) * scale.force();
  c.tangential_force = force.lean * force.force * scale.force();
  c.at_tip = force.arc_length > 1.0 - 2.0 * LoadedRod::knot_clearance;
  c.point = scale.length * at.position;
  c.normal = side * turned({std::cos(at.angle), std::sin(at.angle)});
  c.force_error = std::sqrt(covariance(0, 0));
  c.arc_length_error = std::sqrt(covariance(1, 1));
  c.correlation = covariance(0, 1) / (c.force_error * c.arc_length_error);
  if (!(c.force_error <= largest_relative_error * c.force)) {
    c.reason = "the standard deviation of its force would be " + shown(100.0 * c.force_error / c.force, 3) +
               " % of the force, more than 10 %";
  } else if (!(c.arc_length_error <= largest_relative_error * scale.length)) {
    c.reason = "the standard deviation of its place would be " + shown(100.0 * c.arc_length_error / scale.length, 3) +
               " % of the rod's length, more than 10 %";
  }
  c.identifiable = c.reason.empty();
  return c;
}

std::string assumption(double friction) {
  return friction == 0.0
             ? "no friction: each force is along the rod's normal ([contact] friction gives the range under "
               "it)"
             : "friction of up to " + shown(friction) + " times the normal force, in an unknown state";
}

EstimatedFriction friction_of(const EstimateInput& in, const MeasuredShape& measured, const ConeFits& cone, int k) {
  const double most = cone.best.sum + equally_good * measured.variance(cone.best.sum, cone.best.contacts());
  EstimatedFriction of;
  of.whole = cone.whole;
  of.ratio = of.force = of.tangential_force = of.arc_length = {infinity, -infinity};
  const auto add = [](Interval& to, double value) { to = {std::min(to.low, value), std::max(to.high, value)}; };
  for (const ShapeFit* fit : cone.allowed(most)) {
    const NormalForce& f = fit->shape.forces[static_cast<std::size_t>(k)];
    add(of.ratio, f.force < 0.0 ? -f.lean : f.lean);
    add(of.force, std::abs(f.force) * in.scale.force());
    add(of.tangential_force, f.lean * f.force * in.scale.force());
    add(of.arc_length, f.arc_length * in.scale.length);
  }
  return of;
}

std::vector<BackbonePoint> backbone_of(const Scale& scale, const LoadedRod& rod, const LoadedRod::Shape& shape) {
  constexpr std::size_t drawn = 101;
  std::vector<double> places(drawn);
  for (std::size_t i = 0; i < drawn; ++i) places[i] = static_cast<double>(i) / (drawn - 1);
  std::vector<BackbonePoint> out;
  const std::vector<LoadedRod::Point> points = rod.points(shape, places);
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.push_back({places[i] * scale.length, scale.length * points[i].position.x, scale.length * points[i].position.y,
                   points[i].angle, points[i].curvature / scale.length});
  }
  return out;
}

std::vector<LeftOut> left_out_of(const Scene& scene, const EstimateInput& in) {
  std::vector<LeftOut> out;
  if (in.at_base > 0) {
    out.push_back({in.at_base == 1 ? "the measured point at the base"
                                   : std::to_string(in.at_base) + " measured points at the base",
                   "the rod is clamped there, whatever touches it"});
  }
  out.push_back({"coordinates plugin", "an estimate uses Legendre functions whose order it chooses itself"});
  out.push_back({"solver plugin", "an estimate is a small least-squares problem that needs none"});
  if (!scene.obstacles.empty()) out.push_back({"obstacles", "an estimate does not use what touches the rod"});
  if (!scene.objectives.empty()) out.push_back({"objectives", "the residuals of the points are the objective"});
  if (scene.target.position || scene.target.angle) out.push_back({"target", "an estimate has none"});
  if (!scene.gravity) out.push_back({"gravity term", "the scene has no gravity"});
  out.push_back({"stability", "it depends on the curvature of the obstacles, which are not known"});
  return out;
}

}  // namespace tendril
