#include "tendril/estimate.hpp"

#include <algorithm>
#include <cmath>

#include "base/deadline.hpp"
#include "estimate/contact_levels.hpp"
#include "estimate/significance.hpp"
#include "problem/calibrated_range.hpp"
#include "problem/estimate_parts.hpp"

namespace tendril {
namespace {

constexpr int most_refining_steps = 200;

/// Repeats the best fit with more functions per piece until its points stay.
struct RefinedFit {
  std::unique_ptr<LoadedRod> rod;
  ShapeFit fit;
  double change = infinity;
};

RefinedFit refine(const EstimateInput& in, const LoadedRod& coarse, const ShapeFit& fit, double turn,
                  const Deadline& deadline, int& solves) {
  RefinedFit out;
  out.fit = fit;
  const LoadedRod* source = &coarse;
  for (const int order : finer_orders) {
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

void report_contacts(const EstimateInput& in, const RefinedFit& refined, const std::vector<ShapeFit>& fits,
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
    EstimatedContact c = contact_of(in.scale, fit.shape.forces[static_cast<std::size_t>(k)],
                                    points[static_cast<std::size_t>(k)], out.covariance.block<2, 2>(2 * k, 2 * k));
    if (c.identifiable && rival != nullptr) {
      c.reason = "contacts elsewhere explain the points as well, one of them at " +
                 shown(rival->shape.forces[static_cast<std::size_t>(k)].arc_length * in.scale.length, 3) + " m";
    }
    c.identifiable = c.reason.empty();
    out.contacts.push_back(std::move(c));
  }
}

/// `why`: the fit explains too little.
void report_poor_fit(const EstimateInput& in, const std::string& why, const Deadline& deadline, Estimate& out) {
  const std::string hint = hint_of(in, in.measured, in.moments, deadline);
  out.status = EstimateStatus::poor_fit;
  out.message = why;
  out.message += hint.empty() ? ": the noise, the moments or the rod are not what the scene says, or there are more "
                                "contacts than " +
                                    std::to_string(in.most_contacts)
                              : hint;
}

void conclude(const EstimateInput& in, const ShapeFit& fit, const Deadline& deadline, Estimate& out) {
  const std::string noun[] = {"no contact", "1 contact", "2 contacts"};
  if (const std::string why = misfit(in.measured, in.scale.length, fit.residual, fit.contacts()); !why.empty()) {
    report_poor_fit(in, why, deadline, out);
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
                  " would be no better than chance (probability " + shown(next.probability, 3) +
                  "), so a further one, if there is any, is not identifiable";
  }
  if (out.noise_estimated) return;
  const std::string doubt = doubt_of_noise(out.chi_square, out.degrees_of_freedom);
  if (!doubt.empty()) out.message += (out.message.empty() ? "" : "; ") + doubt;
}

/// What the points say with the number of contacts that they support.
void report_fit(const EstimateInput& in, const RefinedFit& refined, const std::vector<ShapeFit>& fits, Estimate& out) {
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
  out.backbone = backbone_of(in.scale, *refined.rod, fit.shape);
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
    end(deadline, scene.solver.time_limit, begin, out);
    return out;
  };

  const double turn = most_turn(in.rod, in.measured);
  const LoadedRod rod(in.rod, in.moments, first_order, turn);
  const std::vector<Level> levels =
      fit_levels(rod, in.measured, in.most_contacts, in.friction, significance, deadline, out.starts);
  if (deadline.over()) return finish();
  out.solves = rod.solve_count();

  const Level* chosen = supported_level(levels);
  double variance = 0.0;
  for (const Level& level : levels) {
    if (level.converged()) variance = in.measured.variance(level.best.sum, level.contacts);
  }
  for (const Level& level : levels) {
    out.tests.push_back({level.contacts, level.converged() ? level.best.sum / variance : infinity,
                         in.measured.degrees_of_freedom(level.contacts), level.probability, level.supported,
                         level.converged()});
  }
  if (chosen == nullptr) {
    const std::string hint = hint_of(in, in.measured, in.moments, deadline);
    if (!hint.empty()) out.status = EstimateStatus::poor_fit;
    out.message = "no equilibrium near the measured points was found, whatever the contacts" + hint;
    return finish();
  }

  RefinedFit refined = refine(in, rod, chosen->fits.front(), turn, deadline, out.solves);
  if (deadline.over()) return finish();
  if (!refined.rod) {
    const std::string why = misfit(in.measured, in.scale.length, refined.fit.residual, refined.fit.contacts());
    if (why.empty()) {
      out.message =
          "the fit did not converge with more functions per piece" + hint_of(in, in.measured, in.moments, deadline);
    } else {
      report_poor_fit(in, why, deadline, out);
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
  if (!out.contacts.empty()) out.assumed = assumption(in.friction);
  for (int k = 0; in.friction > 0.0 && k < cone.best.contacts(); ++k) {
    out.contacts[static_cast<std::size_t>(k)].friction = friction_of(in, in.measured, cone, k);
  }
  tell_beyond_calibration(scene, out.moments, std::vector<double>(out.moments.size(), unknown_turn),
                          scene.rod.base_angle, "", out.notes);
  conclude(in, refined.fit, deadline, out);
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
