#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "estimate/friction_cone.hpp"
#include "problem/estimate_input.hpp"
#include "tendril/estimate.hpp"

namespace tendril {

/// Points say nothing of how much shorter a tendon is.
inline constexpr double unknown_turn = std::numeric_limits<double>::quiet_NaN();

/// Orders of the Legendre functions, each tried until the points stay where they are (units of L).
inline constexpr int first_order = 8;
inline constexpr int finer_orders[] = {12, 18, 26, 38};
inline constexpr double order_tolerance = 1e-10;

/// Angle that a piece may turn by: somewhat more than the noisy chords of the whole rod show.
inline double most_turn(const Rod& rod, const MeasuredShape& measured) {
  return std::min(30.0, measured_turn(rod, measured) + 1.0);
}

/// Why a shape does not explain points from which it is off by `residual`; empty: it does, as far as that tells.
std::string misfit(const MeasuredShape& measured, double length, const Eigen::VectorXd& residual, int contacts);

/// What about points that are not explained does not go with the rod, or their axes, in words that follow "; ". Empty:
/// nothing catches the eye.
std::string hint_of(const EstimateInput& in, const MeasuredShape& seen, const std::vector<double>& moments,
                    const Deadline& deadline);

/// What is to be asked where residuals are far smaller than the noise that the scene states; empty: nothing.
std::string doubt_of_noise(double chi_square, int degrees);

/// A contact in SI units; `covariance` of force and place, too. `at`: of the rod there.
EstimatedContact contact_of(const Scale& scale, const NormalForce& force, const LoadedRod::Point& at,
                            const Eigen::Matrix2d& covariance);

/// What an estimate takes for granted about friction of its contacts, in a line.
std::string assumption(double friction);

/// What contact `k` of fits may be over the states of friction that explain the points as well as the best of them
/// does.
EstimatedFriction friction_of(const EstimateInput& in, const MeasuredShape& measured, const ConeFits& cone, int k);

/// Another local minimum, or another state of friction, within this much of chi-square (three standard deviations)
/// explains the data as well.
inline constexpr double equally_good = 9.0;

/// The shape in SI units.
std::vector<BackbonePoint> backbone_of(const Scale& scale, const LoadedRod& rod, const LoadedRod::Shape& shape);

std::vector<LeftOut> left_out_of(const Scene& scene, const EstimateInput& in);

/// Ends an estimate, of one shape or of several: whether its time was over, and how long it took.
template <class AnyEstimate>
void end(const Deadline& deadline, double limit, double begin, AnyEstimate& out) {
  if (deadline.interrupted()) {
    out.status = EstimateStatus::interrupted;
    out.message = "interrupted";
  } else if (deadline.over()) {
    out.status = EstimateStatus::time_limit;
    out.message = "the time limit of " + shown(limit, 3) + " s was reached";
  }
  out.seconds = now() - begin;
}

}  // namespace tendril
