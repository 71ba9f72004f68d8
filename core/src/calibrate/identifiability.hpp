#pragma once

#include <Eigen/Core>
#include <vector>

#include "tendril/export.hpp"

namespace tendril {

/// What normal equations say of their unknowns.
struct Identifiability {
  Eigen::MatrixXd covariance;                 ///< rows and columns of what is not determined are 0
  std::vector<Eigen::VectorXd> undetermined;  ///< directions of unit length, the least determined first
  std::vector<bool> determined;               ///< of each unknown
};

/// `normal`: J^T J, J by unknowns that are of a size around 1; `variance`: of the residuals. A direction along which
/// the standard deviation is above `largest_error` is not determined, nor is an unknown that has a share in one.
/// Unknowns that are not `free` are known.
TENDRIL_API Identifiability identify(const Eigen::MatrixXd& normal, double variance, const std::vector<bool>& free,
                                     double largest_error);

}  // namespace tendril
