#pragma once

#include <Eigen/Core>

#include "tendril/export.hpp"

// Not part of what is installed; exported for its tests.
namespace tendril {

/// Probability that a sum of squares of `degrees` (even, or 0) independent standard normal numbers is at least `value`.
TENDRIL_API double chi_square_probability(double value, int degrees);

/// Probability that Student's t with `degrees` >= 1 degrees of freedom is beyond +-sqrt(square).
TENDRIL_API double t_square_probability(double square, int degrees);

/// Length of the curve that the normalized columns of `columns` trace, in order, once what the columns of `known`
/// explain is taken out of them. Columns of which less than `least` (a fraction of their length) is left are skipped.
/// Opposite vectors count as the same.
TENDRIL_API double curve_length(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& known, double least);

/// Bound on the probability that the best of a curve of directions explains by chance what `improvement` says:
/// Hotelling's tube, in the form of Davies (1987) for a parameter that exists only under the alternative.
///
/// `improvement`: decrease of the sum of squares over the variance of the noise; `degrees`: of freedom from which that
/// variance was estimated, 0 if it is known.
TENDRIL_API double improvement_probability(double improvement, double curve, int degrees);

/// Probability that independent residuals of points, x and y in turn in the order of the points, change as little from
/// one point to the next as these do: von Neumann's ratio in its normal approximation.
TENDRIL_API double smooth_probability(const Eigen::VectorXd& residuals);

}  // namespace tendril
