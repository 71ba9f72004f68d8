#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "tendril/export.hpp"

namespace tendril {

/// A local basis for the backbone angle on one piece of the rod (docs/model.md section 2):
///
///     phi(sigma) = phi(0) + sum_i q_i beta_i(sigma),   sigma in [0,1],   beta_i(0) = 0
///
/// All that a new coordinate model has to write. Everything is dimensionless, angles in radians.
class TENDRIL_API CoordinateModel {
 public:
  virtual ~CoordinateModel();

  /// Number of functions (coordinates) per piece, at least 1.
  virtual int function_count() const = 0;

  /// Fills row g with beta_i(sigma_g), its first and its second derivative in sigma. All three matrices are
  /// sigma.size() x function_count(). sigma is in [0,1] and ascending within one call is not promised.
  virtual void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value,
                        Eigen::Ref<Eigen::MatrixXd> first, Eigen::Ref<Eigen::MatrixXd> second) const = 0;

  /// Interior points of reduced smoothness in (0,1), ascending; quadrature is cut there. None by default.
  virtual std::vector<double> breaks() const;

  /// Lengths of the pieces that a stretch between two knots is cut into, as fractions that sum to 1. {1} by default.
  virtual std::vector<double> subdivision() const;

  /// Name and unit of coordinate i of a piece, for reports (paper, Table I). "q_1", "q_2", ... in rad by default.
  virtual std::string coordinate_name(int i) const;
};

/// The integrated Legendre functions beta_i(sigma) = int_0^sigma P_(i-1)(2t-1) dt, i = 1..order, by recurrence.
/// `psc` and `legendre` are thin plugins over this; certificate and execution use it as their fine basis.
class TENDRIL_API LegendreBasis : public CoordinateModel {
 public:
  /// order in 1..maximum_order, else Error. `pieces` >= 1 equal pieces per stretch.
  explicit LegendreBasis(int order, int pieces = 1);
  ~LegendreBasis() override;

  static constexpr const char* name = "legendre";  ///< of the basis, in results of execution and estimation
  static constexpr int maximum_order = 64;         ///< beyond it nothing was tried

  int function_count() const override;
  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override;
  std::vector<double> subdivision() const override;

 private:
  int order_;
  int pieces_;
};

}  // namespace tendril
