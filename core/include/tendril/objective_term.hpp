#pragma once

#include <span>
#include <vector>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"
#include "tendril/hyper_dual.hpp"

namespace tendril {

/// What an objective term reads. Core hands over, and differentiates through, nothing else.
struct Reads {
  bool tip_position = false;
  bool tip_angle = false;
  bool bending_energy = false;
  bool moments = false;
  bool contact_point = false;
  bool contact_gap = false;
  bool contact_normal = false;
  bool contact_force = false;
  bool contact_arc_length = false;
  bool palm_distance = false;
  bool target = false;            ///< the scene must have a [target]
  std::vector<double> samples{};  ///< arc lengths s/L in [0,1] of backbone samples

  bool any_contact() const {
    return contact_point || contact_gap || contact_normal || contact_force || contact_arc_length;
  }
};

/// A backbone point. Dimensionless; angle in rad; curvature times L.
template <class T>
struct BackboneQuantities {
  T x{};
  T y{};
  T angle{};
  T curvature{};
};

/// One planned contact. The normal points out of the obstacle.
template <class T>
struct ContactQuantities {
  T x{};
  T y{};
  T gap{};
  T normal_x{};
  T normal_y{};
  T force{};
  T arc_length{};
  T reference_x{};  ///< the obstacle's reference point, a circle's centre (P_o of the paper)
  T reference_y{};
};

/// What a term may read of one finger; empty or zero where it was not asked for.
template <class T>
struct FingerQuantities {
  BackboneQuantities<T> tip{};
  std::span<const BackboneQuantities<T>> samples{};  ///< in the order of Reads::samples
  std::span<const ContactQuantities<T>> contacts{};
  std::span<const T> moments{};
  T bending_energy{};
};

/// The pose asked for, dimensionless.
struct Target {
  Vec2 position{};
  double angle = 0.0;
  bool has_position = false;
  bool has_angle = false;
};

/// Everything a term may read, dimensionless (model.md section 1). What Reads did not ask for is zero.
/// A pose has one finger, and so has a grasp whose other finger is its mirror image. In a grasp points are measured
/// from the object's centre, x along the axis of symmetry; the palm is at x = -palm_distance.
template <class T>
struct Quantities {
  std::span<const FingerQuantities<T>> fingers{};
  T palm_distance{};
  Target target{};
};

/// Collects what a term contributes: the cost is  sum of residuals squared + linear part + smooth part.
template <class T>
class Contribution {
 public:
  explicit Contribution(std::span<T> residuals) : residuals_(residuals) {}

  /// Adds r^2 to the cost. Backends that know least squares see r itself.
  void residual(const T& r) {
    if (count_ < residuals_.size()) residuals_[count_] = r;
    ++count_;
  }
  /// Adds a part that is linear in the quantities (its second derivatives vanish).
  void linear(const T& v) { linear_ += v; }
  /// Adds any smooth part.
  void smooth(const T& v) { smooth_ += v; }

  std::size_t residual_count() const { return count_; }
  const T& linear_part() const { return linear_; }
  const T& smooth_part() const { return smooth_; }

 private:
  std::span<T> residuals_;
  std::size_t count_ = 0;
  T linear_{};
  T smooth_{};
};

/// One weighted term of the objective. Write it with ObjectiveBase; core does derivatives and the chain rule. The
/// scalar weight is core's: the term returns its unweighted value.
class TENDRIL_API ObjectiveTerm {
 public:
  virtual ~ObjectiveTerm();
  virtual Reads reads() const = 0;
  /// A number that the term can never go below, whatever it is given; -infinity if there is none.
  /// 0 by default is right for a sum of squares. Core uses it to leave out modes that cannot win.
  virtual double lower_bound() const;
  virtual void evaluate(const Quantities<double>& x, Contribution<double>& out) const = 0;
  virtual void evaluate(const Quantities<HyperDual>& x, Contribution<HyperDual>& out) const = 0;
};

/// Base of a term written as one template
///
///     template <class T> void operator()(const tendril::Quantities<T>& x, tendril::Contribution<T>& out) const;
///
/// in `Term`. It is instantiated for double and HyperDual only. The number of residuals must not depend on the values.
template <class Term>
class ObjectiveBase : public ObjectiveTerm {
 public:
  void evaluate(const Quantities<double>& x, Contribution<double>& out) const final {
    static_cast<const Term&> (*this)(x, out);
  }
  void evaluate(const Quantities<HyperDual>& x, Contribution<HyperDual>& out) const final {
    static_cast<const Term&> (*this)(x, out);
  }
};

}  // namespace tendril
