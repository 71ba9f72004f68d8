#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/backbone_point.hpp"
#include "tendril/calibration_unknown.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril {

// Calibration (docs/model.md section 13): numbers of the rod from shapes that were measured under known actuation and
// loads. SI units throughout.

/// Whose number it is, where recordings may have one each.
enum class CalibrationScope { all, group, recording };

/// A number that is looked for.
struct CalibrationUnknownSpec {
  CalibrationUnknown kind = CalibrationUnknown::stiffness;  ///< what it is
  int segment = 0;                                          ///< 1 is the first one; 0: all (factors), the only one
  int actuator = 1;                                         ///< 1 is the first one
  int degree = 1;                                           ///< of a law as a polynomial without a constant
  CalibrationScope per = CalibrationScope::all;  ///< of a base: one for all, for each group, for each recording
  std::optional<double> start{};                 ///< where the search begins; absent: the scene's value
  double minimum = -infinity;                    ///< likewise of a polynomial's first power only
  double maximum = infinity;                     ///< likewise
  std::optional<double> prior{};                 ///< what is believed without the measurements
  double prior_error = 0.0;                      ///< standard deviation of that, > 0 with a prior
};

/// What was seen of a rod at an arc length.
struct CalibrationMarker {
  double arc_length = 0.0;       ///< m
  std::optional<Vec2> position;  ///< m
  std::optional<double> angle;   ///< rad
  double along_normal = 0.0;     ///< m, how far beside the backbone it stands, positive: to the left
  double along_tangent = 0.0;    ///< m, how far ahead of its arc length
  double out_of_plane = 0.0;     ///< m, what its place has across the plane, as far as it is known
};

/// A shape that was measured, and what was known of it.
struct Recording {
  std::string name;                          ///< for messages and tables
  std::string group{};                       ///< a session, or whatever recordings may have in common; may be empty
  std::vector<double> inputs{};              ///< of each actuator, SI, in its own kind; may be empty without actuators
  std::vector<ActuatorKind> input_kinds{};   ///< of each of them
  std::optional<Vec2> gravity{};             ///< m/s^2; absent: the scene's
  Vec2 tip_force{};                          ///< N, besides the scene's
  double tip_moment = 0.0;                   ///< N m, dead
  std::vector<Vec2> load_forces{};           ///< N, one for each load of the scene's rod, besides its own; or empty
  std::vector<double> load_moments{};        ///< N m, likewise
  std::vector<CalibrationMarker> markers{};  ///< in ascending order of arc length
  bool check_only = false;                   ///< not fitted, only predicted
  std::string place{};                       ///< file and line, for messages
};

/// What is calibrated with what.
struct CalibrationSpec {
  std::vector<Recording> recordings;             ///< at least one
  std::vector<CalibrationUnknownSpec> unknowns;  ///< at least one
  double noise = 0.0;                            ///< m, standard deviation of a coordinate; 0: not known
  double angle_noise = 0.0;                      ///< rad, of an angle; 0: as the noise turns half the rod
  bool robust = false;                           ///< Huber's loss, so that single points that are wrong count less
  int folds = 5;                                 ///< of the cross-validation; 0: none
  bool fold_by_group = false;                    ///< whole groups are left out in turn, instead of recordings
  int starts = 4;                                ///< fits begun at most
};

/// A number that was looked for.
struct CalibratedNumber {
  CalibrationUnknownSpec spec;  ///< whose number
  int power = 1;                ///< of a law's polynomial
  std::string name;             ///< in words
  std::string unit;             ///< SI; empty: a factor
  double value = 0.0;           ///< SI
  double error = 0.0;           ///< standard deviation
  bool identifiable = false;    ///< else value and error must not be used
  bool at_bound = false;        ///< the fit ends at its minimum or maximum: its error says nothing
  std::string reason{};         ///< why it is not identifiable
};

/// A recording beside its fit.
struct CalibratedShape {
  std::string name;                      ///< of the recording
  bool check_only = false;               ///< it was not fitted
  std::vector<Vec2> measured;            ///< m, of the markers that have a position
  std::vector<Vec2> fitted;              ///< m, of the same in the fitted shape
  std::vector<BackbonePoint> backbone;   ///< of the fitted shape
  double rms = 0.0;                      ///< m, distance of markers from where they were seen, over the recording
  double tip_error = 0.0;                ///< m, the same of the marker nearest to the tip
  double left_out_tip_error = infinity;  ///< m, when it was left out of the fit; infinity: it never was
  double left_out_rms = infinity;        ///< m, likewise
  std::string beyond{};                  ///< what of its loads lies beyond those fitted when it was predicted
};

/// How errors of tips are spread.
struct TipErrors {
  int count = 0;         ///< of recordings
  double mean = 0.0;     ///< m
  double median = 0.0;   ///< m
  double largest = 0.0;  ///< m
};

/// What an actuator was told in the recordings that were fitted, SI.
struct CalibratedInput {
  ActuatorKind kind = ActuatorKind::moment;  ///< what it was told
  double least = 0.0;                        ///< of all of them
  double largest = 0.0;                      ///< likewise
};

/// The loads of the recordings that were fitted, along the rod's direction at its base and to the left of that.
struct CalibratedLoads {
  LoadRange gravity;             ///< m/s^2
  LoadRange tip_force;           ///< N, weights included
  std::vector<LoadRange> along;  ///< N, or N/m, of each load of the scene's rod, likewise
};

/// How a calibration ended.
enum class CalibrationStatus {
  solved,            ///< every number is identifiable
  not_identifiable,  ///< some are not
  not_converged,
  time_limit,
  interrupted
};
TENDRIL_API std::string_view to_string(CalibrationStatus status);  ///< The status as results write it.

/// Numbers of the rod with what is known of their accuracy.
struct Calibration {
  CalibrationStatus status = CalibrationStatus::not_converged;  ///< how it ended
  std::string message;                                          ///< why it is not solved
  std::vector<CalibratedNumber> numbers;                        ///< in the order of the unknowns, powers ascending
  Eigen::MatrixXd covariance;             ///< of all of them, SI; rows of those not identifiable are 0
  std::vector<std::string> undetermined;  ///< combinations that the shapes do not determine
  double noise = 0.0;                     ///< m, standard deviation of a coordinate
  bool noise_estimated = false;           ///< the residuals told it
  double repeatability = infinity;        ///< m, of a coordinate between recordings alike; infinity: none are
  double residual_rms = 0.0;              ///< m, of a coordinate
  int degrees_of_freedom = 0;             ///< measured numbers less unknowns
  std::vector<CalibratedShape> shapes;    ///< in the order of the recordings
  TipErrors fitted;                       ///< of recordings that were fitted
  TipErrors left_out;                     ///< when they were left out in turn, inside of the loads of the others
  TipErrors left_out_beyond;              ///< likewise, beyond the loads of the others
  TipErrors checked;                      ///< of those that were only predicted, inside of the loads fitted
  TipErrors checked_beyond;               ///< likewise, beyond
  std::vector<CalibratedInput> inputs;    ///< one per actuator; empty where recordings say nothing of them
  CalibratedLoads loads;                  ///< likewise, in numbers
  std::vector<std::string> ranges;        ///< of all these, in words
  std::vector<std::string> warnings;      ///< what its user would want to look at
  int folds = 0;                          ///< of the cross-validation
  int starts = 0;                         ///< fits that were begun
  int starts_agreed = 0;                  ///< of them, those that ended in the best one
  int solves = 0;                         ///< equilibria that were solved for
  int order = 0;                          ///< functions per piece
  double model_error = 0.0;               ///< m, largest change of a marker at the last refinement
  double length = 0.0;                    ///< m, of the rod
  double seconds = 0.0;                   ///< wall time, s
};

/// Fits numbers of the scene's rod to shapes: least squares with the equilibrium solved for each (model.md section
/// 15). Needs no plugin. Throws SceneError where the data cannot determine what is asked for, or make no sense.
TENDRIL_API Calibration calibrate(const Scene& scene, const CalibrationSpec& spec, const PlanControl& control = {});

}  // namespace tendril
