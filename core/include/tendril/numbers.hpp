#pragma once

#include <Eigen/Core>
#include <limits>

namespace tendril {

/// An absent limit, or a value that is not known yet.
inline constexpr double infinity = std::numeric_limits<double>::infinity();

using VectorRef = Eigen::Ref<Eigen::VectorXd>;             ///< to be written
using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;  ///< to be read
using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;             ///< to be written; column-major
using ConstMatrixRef = Eigen::Ref<const Eigen::MatrixXd>;  ///< to be read; column-major

}  // namespace tendril
