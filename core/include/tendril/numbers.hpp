#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>

#include "tendril/export.hpp"

namespace tendril {

/// An absent limit, or a value that is not known yet.
inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// A number as messages show it: so many significant digits and no more characters than they need ("0.25", "1e-09").
TENDRIL_API std::string shown(double value, int digits = 6);
/// Always with all digits and an exponent ("2.00e-09"), for numbers whose size is what counts.
TENDRIL_API std::string shown_with_exponent(double value, int digits = 3);

using VectorRef = Eigen::Ref<Eigen::VectorXd>;             ///< to be written
using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;  ///< to be read
using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;             ///< to be written; column-major
using ConstMatrixRef = Eigen::Ref<const Eigen::MatrixXd>;  ///< to be read; column-major

}  // namespace tendril
