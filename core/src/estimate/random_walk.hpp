#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tendril/export.hpp"

// Not part of what is installed; exported for its tests.
namespace tendril {

/// How fast contacts change where nothing is known of their motion: standard deviations of what a force and a place
/// change by in one unit of time, as random walks.
struct WalkRates {
  double force = 0.0;
  double place = 0.0;
};

/// Force and arc length of each contact in turn, and what is known of them.
struct ContactState {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

/// What the points of a frame alone say of its contacts, linearized: the negative logarithm of their likelihood is
/// x . information x / 2 - x . weighted.
struct FrameEvidence {
  double step = 0.0;        ///< time since the frame before
  std::vector<int> before;  ///< of each contact, which of the frame before it is; -1: none
  Eigen::MatrixXd information;
  Eigen::VectorXd weighted;
};

/// Those of `contacts` that stay, `step` later.
ContactState predicted(const ContactState& last, std::span<const int> stay, double step, const WalkRates& rates);

/// Kalman's filter over frames one after the other: what each and those before it say.
TENDRIL_API std::vector<ContactState> filtered(std::span<const FrameEvidence> frames, const WalkRates& rates);

/// What all frames say of each (Rauch, Tung and Striebel).
TENDRIL_API std::vector<ContactState> smoothed(std::span<const FrameEvidence> frames,
                                               std::vector<ContactState> filtered, const WalkRates& rates);

/// Logarithm of the likelihood of all frames, but for what does not depend on the rates.
TENDRIL_API double log_likelihood(std::span<const FrameEvidence> frames, const WalkRates& rates);

/// The rates that make the frames likeliest, by expectation and maximization (Shumway and Stoffer 1982); those that are
/// given stay. Nothing: no contact is there in two frames.
TENDRIL_API std::optional<WalkRates> likeliest_rates(std::span<const FrameEvidence> frames,
                                                     const std::optional<double>& force,
                                                     const std::optional<double>& place);

/// The largest rates that the frames allow (one-sided, 97.5 %), each beside the likeliest other one; those that are
/// given stay. Where frames tell little of how fast contacts change, errors had better be too large than too small.
TENDRIL_API WalkRates fastest_likely(std::span<const FrameEvidence> frames, const WalkRates& likeliest,
                                     bool force_given, bool place_given);

}  // namespace tendril
