#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/problem.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// How an estimate ended.
enum class EstimateStatus {
  solved,            ///< every contact that the data show is identifiable; there may be none
  not_identifiable,  ///< the data show contacts whose force or place they do not determine
  poor_fit,          ///< no number of contacts allowed explains the points within their noise
  not_converged,
  time_limit,
  interrupted
};
TENDRIL_API std::string_view to_string(EstimateStatus status);  ///< The status as results write it.

/// From the lowest to the highest value.
struct Interval {
  double low = 0.0;   ///< the lowest
  double high = 0.0;  ///< the highest
};

/// What a contact may be, whatever the state of its friction, at the best fit of each: noise comes on top. SI units.
struct EstimatedFriction {
  Interval ratio;             ///< of tangential to normal force, as far as the points allow it
  Interval force;             ///< N, along the normal
  Interval tangential_force;  ///< N, along the rod towards its tip
  Interval arc_length;        ///< m
  bool whole = true;          ///< every state of the cone was fitted; else fits ended inside it
};

/// A contact seen through the rod's shape alone. SI units; errors are standard deviations.
struct EstimatedContact {
  double arc_length = 0.0;        ///< m
  double force = 0.0;             ///< N, >= 0, along `normal`
  double tangential_force = 0.0;  ///< N, along the rod towards its tip; not 0 only where points show friction
  Vec2 point{};                   ///< m
  Vec2 normal{};                  ///< the backbone's normal on the side to which the force pushes
  double force_error = 0.0;       ///< N
  double arc_length_error = 0.0;  ///< m
  double correlation = 0.0;       ///< of force and arc length
  bool at_tip = false;        ///< the fit ends at the tip, where the force may have another direction than the normal
  bool identifiable = false;  ///< else the values above must not be used
  std::string reason{};       ///< why it is not
  std::optional<EstimatedFriction> friction{};  ///< where the scene states a coefficient
};

/// Whether the points need one contact more.
struct ContactTest {
  int contacts = 0;            ///< with this many
  double chi_square = 0.0;     ///< sum of squared residuals over the squared noise
  int degrees_of_freedom = 0;  ///< measured coordinates less two per contact
  double probability = 1.0;    ///< at most: of such an improvement without this contact; 1 for none
  bool supported = false;      ///< The points show that many contacts: the test is passed.
  bool converged = false;      ///< A fit with that many was found.
};

/// Contacts that explain measured points, with what is known of their accuracy.
struct Estimate {
  EstimateStatus status = EstimateStatus::not_converged;  ///< how it ended
  std::string message;                                    ///< why it is not solved
  std::string assumed;                                    ///< about the contacts' friction, in a line
  std::vector<std::string> notes;                         ///< what to know before it is used
  std::vector<double> moments;                            ///< N m, the known ones
  std::vector<EstimatedContact> contacts;                 ///< in ascending order of arc length
  /// Of force and arc length of each contact in turn, in N and m.
  Eigen::MatrixXd covariance;
  double noise = 0.0;                   ///< m, standard deviation of a coordinate
  bool noise_estimated = false;         ///< `noise` was told by the residuals
  double residual_rms = 0.0;            ///< m, of a coordinate
  double chi_square = 0.0;              ///< sum of squared residuals over the squared noise
  int degrees_of_freedom = 0;           ///< measured coordinates less two per contact
  double fit_probability = 1.0;         ///< of residuals at least this large; 1 if the noise was estimated from them
  std::vector<ContactTest> tests;       ///< in ascending order of contacts
  int order = 0;                        ///< functions per piece of the last refinement
  double model_error = 0.0;             ///< m, largest change of a point at that refinement
  int starts = 0;                       ///< fits that were begun
  int solves = 0;                       ///< equilibria that were solved for
  std::vector<BackbonePoint> backbone;  ///< of the fitted shape
  std::vector<LeftOut> left_out;        ///< what the scene could have needed and did not
  double seconds = 0.0;                 ///< wall time, s
};

/// Forces and places of contacts whose obstacles are not known, from measured backbone points and known moments
/// (docs/model.md section 6): least squares over force and arc length of each contact, with the equilibrium solved for
/// the shape. Throws SceneError if the scene has no measurement that determines anything.
TENDRIL_API Estimate estimate(const Scene& scene, const PlanControl& control = {});

/// What estimate() would solve, for `describe`; throws the same errors.
TENDRIL_API Description describe_estimate(const Scene& scene);

}  // namespace tendril
