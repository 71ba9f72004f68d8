#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/deadline.hpp"
#include "estimate/contact_levels.hpp"
#include "estimate/random_walk.hpp"

namespace tendril {

/// A measured frame of a sequence, dimensionless but for its time.
struct SequenceFrame {
  double time = 0.0;
  std::vector<double> moments;  ///< one per actuator of the rod
  MeasuredShape shape;
};

/// What a frame tells once those before it are known.
struct TrackedFrame {
  ShapeFit fit;               ///< the likeliest shape
  std::vector<int> before;    ///< of each contact, which of the frame before it is; -1: none
  std::vector<int> contacts;  ///< numbers of the contacts, from 1 on as they were made
  bool found = false;         ///< There is an equilibrium.
  bool explained = false;     ///< The points look like it.
  double squares = 0.0;       ///< of residuals, had these contacts forces and places as these points alone want them
  int degrees = 0;            ///< of freedom of these
  double conflict = 0.0;      ///< by how much more the squares are with what was known before; that included
  int conflict_degrees = 0;
};

/// What its points alone say, with this variance of a coordinate. `step`: time since the frame before.
FrameEvidence evidence_of(const TrackedFrame& frame, Eigen::Index coordinates, double step, double variance);

/// Follows contacts from frame to frame: an iterated extended Kalman filter over force and arc length of each, whose
/// update is the fit of a single shape, with what is known before among the residuals. A contact is made where the
/// points show one more than there are, as they do in a single shape; it is broken where its force cannot be told from
/// 0. Where points contradict what is known of a contact it ends, and another one may begin.
class ContactTracker {
 public:
  struct Settings {
    int most_contacts = 1;
    double most_chance = significance;  ///< of taking noise for a change, in each frame
    /// Where the noise is known. Without them every frame stands alone, but begins where the one before ends.
    std::optional<WalkRates> rates{};
    double accuracy = final_accuracy;  ///< of the fits
  };
  /// `rod` and `deadline` must outlive this.
  ContactTracker(LoadedRod& rod, Settings settings, const Deadline& deadline)
      : rod_(rod), settings_(settings), deadline_(deadline) {}

  /// The next frame; times ascend. `near`: what it told by itself, of the same rod, to begin there; or null.
  const TrackedFrame& follow(const SequenceFrame& frame, const TrackedFrame* near = nullptr);
  int starts() const { return starts_; }  ///< fits of single shapes that were begun

 private:
  TrackedFrame explain(const SequenceFrame& frame);
  TrackedFrame keep(const SequenceFrame& frame, std::span<const int> stay) const;
  TrackedFrame alone(const SequenceFrame& frame);
  ShapeFit add_contacts(const MeasuredShape& measured, ShapeFit fit, std::vector<int>& before) const;
  TrackedFrame judged(const SequenceFrame& frame, ShapeFit fit, std::vector<int> before) const;
  double variance(const SequenceFrame& frame, const TrackedFrame& tracked) const;
  bool contradicts(const SequenceFrame& frame, const TrackedFrame& tracked) const;
  std::vector<int> lasting(const SequenceFrame& frame, const TrackedFrame& tracked) const;

  LoadedRod& rod_;
  Settings settings_;
  const Deadline& deadline_;
  TrackedFrame last_;
  const TrackedFrame* near_ = nullptr;
  ContactState state_;    ///< of its contacts
  double time_ = 0.0;     ///< of it
  double squares_ = 0.0;  ///< of all residuals so far, which tell the noise where it is not known
  int degrees_ = 0;
  int made_ = 0;
  int starts_ = 0;
};

}  // namespace tendril
