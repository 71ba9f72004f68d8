#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tendril/estimate.hpp"

namespace tendril {

/// What was seen at once.
struct MeasuredFrame {
  double time = 0.0;                  ///< s, or the number of the frame
  std::vector<MeasuredPoint> points;  ///< where the backbone was
  std::vector<double> moments;        ///< N m, one per actuator; empty: those of the scene
  bool equal_spacing = false;         ///< as MeasurementSpec::equal_spacing
};

/// Measured shapes one after the other.
struct SequenceSpec {
  std::vector<MeasuredFrame> frames;  ///< times ascending
  bool timed = false;                 ///< they have times in s; else numbers
  /// Standard deviations of what the force (N) and the place (m) of a contact change by in 1 s, or from one frame to
  /// the next where they have numbers; nothing: the largest that the frames allow.
  std::optional<double> force_rate{};
  std::optional<double> place_rate{};  ///< likewise
};

/// A contact that is followed from frame to frame.
struct FollowedContact {
  int number = 0;             ///< from 1 on, as they were made; the same in all its frames
  EstimatedContact all{};     ///< as all frames tell it
  EstimatedContact so_far{};  ///< as this frame and those before it do
};

/// What a frame of a sequence tells once others are known. Numbers of a contact that is not identifiable stand with
/// their errors, unlike those of a single shape.
struct EstimatedFrame {
  double time = 0.0;                                      ///< s, or the number of the frame
  EstimateStatus status = EstimateStatus::not_converged;  ///< solved, poor_fit or not_converged
  std::vector<double> moments;                            ///< N m, the known ones
  std::vector<FollowedContact> contacts;                  ///< in ascending order of arc length
  std::vector<int> made;                                  ///< numbers of contacts that begin here
  std::vector<int> broken;                                ///< and of those of the frame before that are not there
  double residual_rms = 0.0;                              ///< m, of a coordinate
  double chi_square = 0.0;            ///< of the points, had these contacts what these points alone want them to have
  int degrees_of_freedom = 0;         ///< measured coordinates less two per contact
  double fit_probability = 1.0;       ///< of residuals at least this large
  double surprise = 0.0;              ///< chi-square of what was known before against the points
  int surprise_degrees = 0;           ///< two per contact that was there before
  double surprise_probability = 1.0;  ///< of a surprise at least this large
};

/// Contacts that explain a sequence of measured shapes. What is not of a frame is of all of them.
struct SequenceEstimate {
  EstimateStatus status = EstimateStatus::not_converged;  ///< the first of its frames that is not solved says why
  std::string message;                                    ///< why it is not solved
  std::string assumed;                                    ///< about the contacts' friction, in a line
  std::vector<std::string> notes;                         ///< what to know before it is used
  std::vector<EstimatedFrame> frames;                     ///< as far as they were followed
  bool timed = false;                                     ///< frames have times in s; else numbers
  double force_rate = 0.0;              ///< N, standard deviation of what a force changes by in 1 s, or between frames
  double place_rate = 0.0;              ///< m, likewise
  bool rates_estimated = false;         ///< the frames told one of them, or both
  double noise = 0.0;                   ///< m, standard deviation of a coordinate
  bool noise_estimated = false;         ///< the residuals told it
  double residual_rms = 0.0;            ///< m, of a coordinate
  double chi_square = 0.0;              ///< of the points and the surprises of all frames
  int degrees_of_freedom = 0;           ///< likewise
  double fit_probability = 1.0;         ///< of chi-square at least this large; 1 if the noise was estimated
  int order = 0;                        ///< functions per piece
  double model_error = 0.0;             ///< m, largest change of a point with a higher order
  int starts = 0;                       ///< fits of single shapes that were begun
  int solves = 0;                       ///< equilibria that were solved for
  std::vector<BackbonePoint> backbone;  ///< of the last frame
  std::vector<LeftOut> left_out;        ///< what the scene could have needed and did not
  double seconds = 0.0;                 ///< wall time, s
};

/// Called when so many frames are done in a pass over them.
using SequenceProgress = std::function<void(std::size_t done, std::size_t all)>;

/// Follows contacts through a sequence of measured shapes by an iterated extended Kalman filter over force and arc
/// length of each, and smooths what it finds (docs/estimate.md). The scene's measurement gives the noise, and the
/// moments of frames without; its points are not read. Throws SceneError if a frame determines nothing.
TENDRIL_API SequenceEstimate estimate_sequence(const Scene& scene, const SequenceSpec& spec,
                                               const PlanControl& control = {}, const SequenceProgress& progress = {});

}  // namespace tendril
