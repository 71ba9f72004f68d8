#include "tendril/estimate.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/deadline.hpp"
#include "estimate/estimate_fit.hpp"
#include "estimate/significance.hpp"
#include "scene/make_rod.hpp"

namespace tendril {
namespace {

/// A force is a number only if its standard deviation is within this fraction of it, and a place only if it is known to
/// this part of the rod's length (model.md section 6).
constexpr double largest_relative_error = 0.1;
/// A contact is shown by the data if they would look like it without one less often than this.
constexpr double significance = 0.01;
/// Residuals larger than this often by chance alone mean that the model does not fit.
constexpr double least_fit_probability = 1e-6;
/// Another local minimum within this much of chi-square (three standard deviations) explains the data as well.
constexpr double equally_good = 9.0;
/// Orders of the Legendre functions, each tried until the points stay where they are (units of L).
constexpr int first_order = 8;
constexpr int orders[] = {12, 18, 26, 38};
constexpr double order_tolerance = 1e-10;
constexpr int most_refining_steps = 200;

std::string text(double value) { return shown(value, 3); }

/// The scene made dimensionless.
struct Input {
  Scale scale;
  Rod rod;
  std::vector<double> moments;
  MeasuredShape measured;
  int most_contacts = 1;
};

std::vector<double> known_moments(const Scene& scene) {
  const std::vector<ActuatorSpec>& actuators = scene.rod.actuators;
  if (!scene.measurement.moments.empty()) {
    if (scene.measurement.moments.size() != actuators.size()) {
      throw SceneError("measurement.moments", "found " + std::to_string(scene.measurement.moments.size()) +
                                                  " moments, expected one for each of the rod's " +
                                                  std::to_string(actuators.size()) + " actuators");
    }
    return scene.measurement.moments;
  }
  std::vector<double> moments;
  for (std::size_t a = 0; a < actuators.size(); ++a) {
    if (actuators[a].minimum != actuators[a].maximum) {
      throw SceneError("measurement", "the moment of actuator " + std::to_string(a + 1) +
                                          " while the points were measured is not known, expected moments = [...] in "
                                          "[measurement], or an actuator whose min and max are equal");
    }
    moments.push_back(actuators[a].minimum);
  }
  return moments;
}

Input read(const Scene& scene) {
  validate(scene);
  Input in;
  in.scale = scale_of(scene);
  in.rod = make_rod(scene, in.scale);
  for (const double m : known_moments(scene)) {
    if (!std::isfinite(m)) throw SceneError("measurement.moments", "a known moment must be finite");
    in.moments.push_back(in.scale.to_dimensionless(m, dimension::moment));
  }
  in.most_contacts = scene.contact.count;
  if (in.most_contacts > 2) {
    throw SceneError("contact.count",
                     "found " + std::to_string(in.most_contacts) + " contacts to be estimated, expected 1 or 2");
  }
  const MeasurementSpec& measurement = scene.measurement;
  if (measurement.points.empty()) {
    throw SceneError("measurement",
                     "there are no measured points, expected points = [...] or file = \"...\" in "
                     "[measurement]");
  }
  std::vector<MeasuredPoint> points = measurement.points;
  std::stable_sort(points.begin(), points.end(),
                   [](const MeasuredPoint& a, const MeasuredPoint& b) { return a.arc_length < b.arc_length; });
  in.measured.points.resize(2 * static_cast<Eigen::Index>(points.size()));
  Eigen::Index i = 0;
  for (const MeasuredPoint& p : points) {
    const double s = p.arc_length / in.scale.length;
    // A part in 1e9 is the rounding of units.
    if (!(s > 0.0 && s <= 1.0 + 1e-9)) {
      throw SceneError("measurement", "a measured point is at arc length " + text(p.arc_length) +
                                          " m, expected more than 0 and at most the rod's length, " +
                                          text(in.scale.length) + " m");
    }
    in.measured.arc_lengths.push_back(std::min(1.0, s));
    for (const double coordinate : {p.position.x, p.position.y}) {
      if (!std::isfinite(coordinate)) throw SceneError("measurement", "a measured coordinate is not finite");
      in.measured.points[i++] = in.scale.to_dimensionless(coordinate, dimension::length);
    }
  }
  if (std::isnan(measurement.noise) || measurement.noise < 0.0 || !std::isfinite(measurement.noise)) {
    throw SceneError("measurement.noise", "the noise must be a positive length");
  }
  in.measured.noise = measurement.noise / in.scale.length;
  // The noise itself needs residuals to be estimated from.
  const int least = 2 * in.most_contacts + (measurement.noise > 0.0 ? 0 : 2);
  if (in.measured.points.size() < least) {
    throw SceneError("measurement", "found " + std::to_string(points.size()) + " measured points, expected at least " +
                                        std::to_string((least + 1) / 2) + " for " + std::to_string(in.most_contacts) +
                                        (in.most_contacts == 1 ? " contact" : " contacts") +
                                        (measurement.noise > 0.0 ? "" : " and unknown noise"));
  }
  return in;
}

/// All local minima with one number of contacts, best first; the test against one contact less.
struct Level {
  std::vector<ShapeFit> fits;
  ContactTest test;
};

/// Whether `fit` improves on the best fit with one contact less by more than noise does.
void test_improvement(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fewer, Level& level) {
  // Fine enough for the length of a smooth curve.
  const std::vector<double> places = spread_places(120);
  const double curve =
      curve_length(rod.influence(fewer.shape, measured.arc_lengths, places), fewer.response.rates, 1e-3);
  const double variance = measured.variance(level.fits.front().sum, level.test.contacts);
  const int degrees = measured.noise > 0.0 ? 0 : level.test.degrees_of_freedom;
  level.test.probability = improvement_probability((fewer.sum - level.fits.front().sum) / variance, curve, degrees);
  level.test.supported = level.test.probability < significance;
}

/// Repeats the best fit with more functions per piece until its points stay.
struct Refined {
  std::unique_ptr<LoadedRod> rod;
  ShapeFit fit;
  double change = infinity;
};

Refined refine(const Input& in, const LoadedRod& coarse, const ShapeFit& fit, double turn, const Deadline& deadline,
               int& solves) {
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

void report_contacts(const Input& in, const Refined& refined, const std::vector<ShapeFit>& fits, Estimate& out) {
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

void conclude(const Input& in, Estimate& out) {
  const std::string noun[] = {"no contact", "1 contact", "2 contacts"};
  if (out.fit_probability < least_fit_probability) {
    out.status = EstimateStatus::poor_fit;
    out.message = "the residuals are larger than the noise (chi-square " + text(out.chi_square) + " with " +
                  std::to_string(out.degrees_of_freedom) +
                  " degrees of freedom): the noise, the moments or the rod are " +
                  "not what the scene says, or there are more contacts than " + std::to_string(in.most_contacts);
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
std::vector<Level> fit_levels(const Input& in, const LoadedRod& rod, const Deadline& deadline, int& starts) {
  const LoadedRod::Curvature curvature = measured_curvature(in.rod, in.measured);
  std::vector<Level> levels;
  for (int contacts = 0; contacts <= in.most_contacts; ++contacts) {
    Level level;
    level.test.contacts = contacts;
    level.test.degrees_of_freedom = in.measured.degrees_of_freedom(contacts);
    const ShapeFit none;
    const ShapeFit& fewer = contacts == 0 || levels.back().fits.empty() ? none : levels.back().fits.front();
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
    if (contacts > 0 && level.test.converged && !levels.back().fits.empty()) {
      test_improvement(rod, in.measured, fewer, level);
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

/// What the points say with the number of contacts that they support.
void report_fit(const Input& in, const Refined& refined, const std::vector<ShapeFit>& fits, Estimate& out) {
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

std::vector<LeftOut> left_out_of(const Scene& scene) {
  std::vector<LeftOut> out;
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
  const Input in = read(scene);
  Estimate out;
  out.moments = known_moments(scene);
  out.left_out = left_out_of(scene);
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
    if (!level.fits.empty()) variance = in.measured.variance(level.fits.front().sum, level.test.contacts);
  }
  for (const Level& level : levels) {
    out.tests.push_back(level.test);
    out.tests.back().chi_square = level.fits.empty() ? infinity : level.fits.front().sum / variance;
  }
  if (chosen == nullptr) {
    out.message = "no equilibrium near the measured points was found, whatever the contacts";
    return finish();
  }

  const Refined refined = refine(in, rod, chosen->fits.front(), turn, deadline, out.solves);
  if (deadline.over()) return finish();
  if (!refined.rod) {
    out.message = "the fit did not converge with more functions per piece";
    return finish();
  }
  report_fit(in, refined, chosen->fits, out);
  conclude(in, out);
  return finish();
}

Description describe_estimate(const Scene& scene) {
  const Input in = read(scene);
  Description out;
  out.left_out = left_out_of(scene);
  out.energies.push_back("bending");
  if (in.rod.has_gravity()) out.energies.push_back("gravity");
  if (in.rod.has_tip_force()) out.energies.push_back("tip force");
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
