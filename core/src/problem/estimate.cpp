#include "tendril/estimate.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/deadline.hpp"
#include "estimate/estimate_fit.hpp"
#include "estimate/friction_cone.hpp"
#include "estimate/significance.hpp"
#include "problem/estimate_input.hpp"

namespace tendril {
namespace {

/// A force is a number only if its standard deviation is within this fraction of it, and a place only if it is known to
/// this part of the rod's length (model.md section 6).
constexpr double largest_relative_error = 0.1;
/// A contact is shown by the data if they would look like it without one less often than this.
constexpr double significance = 0.01;
/// Residuals larger than this often by chance alone mean that the model does not fit.
constexpr double least_fit_probability = 1e-6;
/// Where the noise is not known, residuals as large as this (units of L) are none, and from this on a row of them that
/// is too smooth to be noise is told.
constexpr double no_noise = 0.05;
constexpr double least_misfit = 1e-3;
/// Another local minimum within this much of chi-square (three standard deviations) explains the data as well.
constexpr double equally_good = 9.0;
/// Orders of the Legendre functions, each tried until the points stay where they are (units of L).
constexpr int first_order = 8;
constexpr int orders[] = {12, 18, 26, 38};
constexpr double order_tolerance = 1e-10;
constexpr int most_refining_steps = 200;

std::string text(double value) { return shown(value, 3); }

/// All local minima with one number of contacts, best first; the test against one contact less.
struct Level {
  std::vector<ShapeFit> fits;  ///< without friction
  ShapeFit best;               ///< with whatever friction is allowed
  ContactTest test;
};

/// Whether `fit` improves on the best fit with one contact less by more than noise does.
void test_improvement(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fewer, Level& level) {
  // Fine enough for the length of a smooth curve.
  const std::vector<NormalForce> places = spread_places(120);
  const double curve =
      curve_length(rod.influence(fewer.shape, measured.arc_lengths, places), fewer.response.rates, 1e-3);
  const double variance = measured.variance(level.best.sum, level.test.contacts);
  const int degrees = measured.noise > 0.0 ? 0 : level.test.degrees_of_freedom;
  level.test.probability = improvement_probability((fewer.sum - level.best.sum) / variance, curve, degrees);
  level.test.supported = level.test.probability < significance;
}

/// Repeats the best fit with more functions per piece until its points stay.
struct Refined {
  std::unique_ptr<LoadedRod> rod;
  ShapeFit fit;
  double change = infinity;
};

Refined refine(const EstimateInput& in, const LoadedRod& coarse, const ShapeFit& fit, double turn,
               const Deadline& deadline, int& solves) {
  Refined out;
  out.fit = fit;
  const LoadedRod* source = &coarse;
  for (const int order : orders) {
    auto rod = std::make_unique<LoadedRod>(in.rod, in.moments, order, turn);
    const LoadedRod::Shape start = rod->solve(out.fit.shape.forces, source->curvature(out.fit.shape));
    ShapeFit next = fit_shape(*rod, in.measured, start, final_accuracy, most_refining_steps, deadline);
    solves += rod->solve_count();
    if (!next.converged) return out;
    out.change = (next.response.points - out.fit.response.points).lpNorm<Eigen::Infinity>();
    out.fit = std::move(next);
    out.rod = std::move(rod);
    source = out.rod.get();
    if (out.change <= order_tolerance) break;
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

/// Another local minimum that the data cannot tell from the best one.
const ShapeFit* rival_of(const std::vector<ShapeFit>& fits, const Eigen::MatrixXd& covariance, double variance) {
  const std::vector<NormalForce>& best = fits.front().shape.forces;
  for (const ShapeFit& other : fits) {
    if (other.sum - fits.front().sum > equally_good * variance) break;
    for (std::size_t k = 0; k < best.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(2 * k);
      const double shift = std::abs(other.shape.forces[k].arc_length - best[k].arc_length);
      const double error = std::sqrt(covariance(i + 1, i + 1));
      if (shift > 0.02 && shift > 3.0 * error) return &other;
    }
  }
  return nullptr;
}

void report_contacts(const EstimateInput& in, const Refined& refined, const std::vector<ShapeFit>& fits,
                     Estimate& out) {
  const ShapeFit& fit = refined.fit;
  const int contacts = fit.contacts();
  if (contacts == 0) return;
  const double variance = in.measured.variance(fit.sum, contacts);
  const Eigen::MatrixXd covariance = covariance_of(fit, variance);
  const ShapeFit* rival = rival_of(fits, covariance, variance);
  std::vector<double> places;
  Eigen::VectorXd unit(2 * contacts);
  for (int k = 0; k < contacts; ++k) {
    const NormalForce& f = fit.shape.forces[static_cast<std::size_t>(k)];
    places.push_back(f.arc_length);
    // The report's force is positive along the normal of the side it pushes to.
    unit[2 * k] = (f.force < 0.0 ? -1.0 : 1.0) * in.scale.force();
    unit[2 * k + 1] = in.scale.length;
  }
  const std::vector<LoadedRod::Point> points = refined.rod->points(fit.shape, places);
  out.covariance = unit.asDiagonal() * covariance * unit.asDiagonal();
  for (int k = 0; k < contacts; ++k) {
    const NormalForce& f = fit.shape.forces[static_cast<std::size_t>(k)];
    const LoadedRod::Point& at = points[static_cast<std::size_t>(k)];
    const double side = f.force < 0.0 ? -1.0 : 1.0;
    EstimatedContact c;
    c.arc_length = f.arc_length * in.scale.length;
    c.force = std::abs(f.force) * in.scale.force();
    c.tangential_force = f.lean * f.force * in.scale.force();
    c.at_tip = f.arc_length > 1.0 - 2.0 * LoadedRod::knot_clearance;
    c.point = in.scale.length * at.position;
    c.normal = side * turned({std::cos(at.angle), std::sin(at.angle)});
    c.force_error = std::sqrt(out.covariance(2 * k, 2 * k));
    c.arc_length_error = std::sqrt(out.covariance(2 * k + 1, 2 * k + 1));
    c.correlation = out.covariance(2 * k, 2 * k + 1) / (c.force_error * c.arc_length_error);
    if (!(c.force_error <= largest_relative_error * c.force)) {
      c.reason = "the standard deviation of its force would be " + text(100.0 * c.force_error / c.force) +
                 " % of the force, more than 10 %";
    } else if (!(c.arc_length_error <= largest_relative_error * in.scale.length)) {
      c.reason = "the standard deviation of its place would be " + text(100.0 * c.arc_length_error / in.scale.length) +
                 " % of the rod's length, more than 10 %";
    } else if (rival != nullptr) {
      c.reason = "contacts elsewhere explain the points as well, one of them at " +
                 text(rival->shape.forces[static_cast<std::size_t>(k)].arc_length * in.scale.length) + " m";
    }
    c.identifiable = c.reason.empty();
    out.contacts.push_back(std::move(c));
  }
}

/// What each contact may be over the states of friction that explain the points as well as the best of them does.
void report_friction(const EstimateInput& in, const ConeFits& cone, Estimate& out) {
  const int contacts = cone.fits.front().contacts();
  if (contacts == 0) return;
  if (in.friction == 0.0) {
    out.assumed = "no friction: each force is along the rod's normal ([contact] friction gives the range under it)";
    return;
  }
  out.assumed = "friction of up to " + shown(in.friction) + " times the normal force, in an unknown state";
  const double most = cone.best.sum + equally_good * in.measured.variance(cone.best.sum, contacts);
  const std::vector<const ShapeFit*> allowed = cone.allowed(most);
  for (int k = 0; k < contacts; ++k) {
    EstimatedFriction of;
    of.whole = cone.whole;
    of.ratio = of.force = of.tangential_force = of.arc_length = {infinity, -infinity};
    const auto add = [](Interval& to, double value) { to = {std::min(to.low, value), std::max(to.high, value)}; };
    for (const ShapeFit* fit : allowed) {
      const NormalForce& f = fit->shape.forces[static_cast<std::size_t>(k)];
      add(of.ratio, f.force < 0.0 ? -f.lean : f.lean);
      add(of.force, std::abs(f.force) * in.scale.force());
      add(of.tangential_force, f.lean * f.force * in.scale.force());
      add(of.arc_length, f.arc_length * in.scale.length);
    }
    out.contacts[static_cast<std::size_t>(k)].friction = of;
  }
}

/// Why a shape does not explain the points; empty: it does, as far as the residuals tell.
std::string misfit(const EstimateInput& in, const ShapeFit& fit) {
  const int degrees = in.measured.degrees_of_freedom(fit.contacts());
  const double rms = std::sqrt(fit.sum / static_cast<double>(in.measured.points.size()));
  if (in.measured.noise > 0.0) {
    const double chi_square = fit.sum / in.measured.variance(fit.sum, fit.contacts());
    if (chi_square_probability(chi_square, degrees) >= least_fit_probability) return "";
    return "the residuals are larger than the noise (chi-square " + text(chi_square) + " with " +
           std::to_string(degrees) + " degrees of freedom)";
  }
  const std::string size = "the residuals of " + text(rms * in.scale.length) + " m ";
  if (rms > no_noise) return size + "are too large for noise";
  if (rms > least_misfit && smooth_probability(fit.residual) < least_fit_probability) {
    return size + "change too smoothly along the rod to be noise";
  }
  return "";
}

/// `why`: the fit explains too little.
void report_poor_fit(const EstimateInput& in, const std::string& why, Estimate& out) {
  const std::string hint = in.hint();
  out.status = EstimateStatus::poor_fit;
  out.message = why;
  out.message += hint.empty() ? ": the noise, the moments or the rod are not what the scene says, or there are more "
                                "contacts than " +
                                    std::to_string(in.most_contacts)
                              : hint;
}

void conclude(const EstimateInput& in, const ShapeFit& fit, Estimate& out) {
  const std::string noun[] = {"no contact", "1 contact", "2 contacts"};
  if (const std::string why = misfit(in, fit); !why.empty()) {
    report_poor_fit(in, why, out);
    for (EstimatedContact& c : out.contacts) {
      c.identifiable = false;
      c.reason = "the model does not fit the points";
    }
    return;
  }
  out.status = EstimateStatus::solved;
  for (const EstimatedContact& c : out.contacts) {
    if (!c.identifiable) out.status = EstimateStatus::not_identifiable;
  }
  const auto found = out.contacts.size();
  if (out.status == EstimateStatus::not_identifiable) {
    out.message = "the points show " + noun[found] + ", but do not determine " + (found == 1 ? "it" : "them all");
  } else if (static_cast<int>(found) < in.most_contacts) {
    const ContactTest& next = out.tests[found + 1];
    out.message = "the points show " + noun[found] + "; " + std::to_string(next.contacts) +
                  " would be no better than chance (probability " + text(next.probability) +
                  "), so a further one, if there is any, is not identifiable";
  }
}

/// Fits with no contact, one, and so on, each tested against the one before; fewer where time is over.
std::vector<Level> fit_levels(const EstimateInput& in, const LoadedRod& rod, const Deadline& deadline, int& starts) {
  const LoadedRod::Curvature curvature = measured_curvature(in.rod, in.measured);
  std::vector<Level> levels;
  for (int contacts = 0; contacts <= in.most_contacts; ++contacts) {
    Level level;
    level.test.contacts = contacts;
    level.test.degrees_of_freedom = in.measured.degrees_of_freedom(contacts);
    const ShapeFit none;
    const ShapeFit& fewer = contacts == 0 || levels.back().fits.empty() ? none : levels.back().best;
    if (contacts == 0) {
      level.fits = {fit_shape(rod, in.measured, rod.solve({}, curvature), search_accuracy, 1, deadline)};
    } else {
      level.fits = search(rod, in.measured, curvature, contacts, fewer, deadline, starts);
    }
    if (deadline.over()) return levels;
    std::erase_if(level.fits, [](const ShapeFit& f) { return !std::isfinite(f.sum); });
    // Without an equilibrium of fewer contacts only more of them can explain the shape.
    level.test.converged = level.test.supported = !level.fits.empty();
    if (contacts > 0) level.test.probability = level.test.converged ? 0.0 : 1.0;
    if (level.test.converged) {
      level.best = fit_cone(rod, in.measured, level.fits.front(), in.friction, search_accuracy, deadline).best;
    }
    if (contacts > 0 && level.test.converged && !levels.back().fits.empty()) {
      test_improvement(rod, in.measured, fewer, level);
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

/// What the points say with the number of contacts that they support.
void report_fit(const EstimateInput& in, const Refined& refined, const std::vector<ShapeFit>& fits, Estimate& out) {
  const ShapeFit& fit = refined.fit;
  out.order = refined.rod->order();
  out.model_error = refined.change * in.scale.length;
  const double variance = in.measured.variance(fit.sum, fit.contacts());
  out.noise_estimated = in.measured.noise == 0.0;
  out.noise = std::sqrt(variance) * in.scale.length;
  out.residual_rms = std::sqrt(fit.sum / static_cast<double>(in.measured.points.size())) * in.scale.length;
  out.chi_square = fit.sum / variance;
  out.degrees_of_freedom = in.measured.degrees_of_freedom(fit.contacts());
  if (!out.noise_estimated) out.fit_probability = chi_square_probability(out.chi_square, out.degrees_of_freedom);
  report_contacts(in, refined, fits, out);

  constexpr std::size_t drawn = 101;
  std::vector<double> places(drawn);
  for (std::size_t i = 0; i < drawn; ++i) places[i] = static_cast<double>(i) / (drawn - 1);
  const std::vector<LoadedRod::Point> points = refined.rod->points(fit.shape, places);
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.backbone.push_back({places[i] * in.scale.length, in.scale.length * points[i].position.x,
                            in.scale.length * points[i].position.y, points[i].angle,
                            points[i].curvature / in.scale.length});
  }
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

}  // namespace

std::string_view to_string(EstimateStatus status) {
  switch (status) {
    case EstimateStatus::solved:
      return "solved";
    case EstimateStatus::not_identifiable:
      return "not_identifiable";
    case EstimateStatus::poor_fit:
      return "poor_fit";
    case EstimateStatus::not_converged:
      return "not_converged";
    case EstimateStatus::time_limit:
      return "time_limit";
    case EstimateStatus::interrupted:
      return "interrupted";
  }
  return "?";
}

Estimate estimate(const Scene& scene, const PlanControl& control) {
  const double begin = now();
  const EstimateInput in(scene);
  Estimate out;
  out.moments = known_moments(scene);
  out.left_out = left_out_of(scene, in);
  const Deadline deadline(control.stop, scene.solver.time_limit);
  const auto finish = [&] {
    if (deadline.interrupted()) {
      out.status = EstimateStatus::interrupted;
      out.message = "interrupted";
    } else if (deadline.over()) {
      out.status = EstimateStatus::time_limit;
      out.message = "the time limit of " + text(scene.solver.time_limit) + " s was reached";
    }
    out.seconds = now() - begin;
    return out;
  };

  // A piece may turn by somewhat more than the noisy chords of the whole rod show.
  const double turn = std::min(30.0, measured_turn(in.rod, in.measured) + 1.0);
  const LoadedRod rod(in.rod, in.moments, first_order, turn);
  const std::vector<Level> levels = fit_levels(in, rod, deadline, out.starts);
  if (deadline.over()) return finish();
  out.solves = rod.solve_count();

  const Level* chosen = nullptr;
  double variance = 0.0;
  for (const Level& level : levels) {
    if (level.test.supported) chosen = &level;
    if (!level.fits.empty()) variance = in.measured.variance(level.best.sum, level.test.contacts);
  }
  for (const Level& level : levels) {
    out.tests.push_back(level.test);
    out.tests.back().chi_square = level.fits.empty() ? infinity : level.best.sum / variance;
  }
  if (chosen == nullptr) {
    const std::string hint = in.hint();
    if (!hint.empty()) out.status = EstimateStatus::poor_fit;
    out.message = "no equilibrium near the measured points was found, whatever the contacts" + hint;
    return finish();
  }

  Refined refined = refine(in, rod, chosen->fits.front(), turn, deadline, out.solves);
  if (deadline.over()) return finish();
  if (!refined.rod) {
    const std::string why = misfit(in, refined.fit);
    if (why.empty()) {
      out.message = "the fit did not converge with more functions per piece" + in.hint();
    } else {
      report_poor_fit(in, why, out);
    }
    return finish();
  }
  const ConeFits cone = fit_cone(*refined.rod, in.measured, refined.fit, in.friction, final_accuracy, deadline);
  if (deadline.over()) return finish();
  // What has no friction is told first, unless the points rule it out.
  const double best = cone.best.sum;
  if (refined.fit.sum - best > equally_good * in.measured.variance(best, refined.fit.contacts())) {
    refined.fit = cone.best;
  }
  report_fit(in, refined, chosen->fits, out);
  report_friction(in, cone, out);
  conclude(in, refined.fit, out);
  return finish();
}

Description describe_estimate(const Scene& scene) {
  const EstimateInput in(scene);
  Description out;
  out.left_out = left_out_of(scene, in);
  out.energies.push_back("bending");
  if (in.rod.has_gravity()) out.energies.push_back("gravity");
  if (in.rod.has_tip_force()) out.energies.push_back("tip force");
  if (in.rod.has_dead_loads()) out.energies.push_back("loads along the rod");
  out.terms.push_back("measurement_residuals");
  out.length_unit = in.scale.length;
  out.force_unit = in.scale.force();
  const auto stretches = static_cast<int>(in.rod.fixed_knots().size()) - 1;
  for (int contacts = 0; contacts <= in.most_contacts; ++contacts) {
    Description::Mode mode;
    mode.name = contacts == 0 ? "no contact" : contacts == 1 ? "1 contact" : std::to_string(contacts) + " contacts";
    const int coordinates = (stretches + contacts) * first_order;
    mode.variables.push_back({"coordinates", coordinates});
    if (contacts > 0) {
      mode.variables.push_back({"contact_arc_length", contacts});
      mode.variables.push_back({"contact_force", contacts});
    }
    mode.rows.push_back({"equilibrium", coordinates, "equality"});
    out.variables = mode.variables;
    out.rows = mode.rows;
    out.modes.push_back(std::move(mode));
  }
  return out;
}

}  // namespace tendril
