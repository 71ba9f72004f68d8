#pragma once

#include <span>
#include <vector>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"
#include "tendril/hyper_dual.hpp"

namespace tendril {

/// What an objective term reads. Core hands over, and differentiates through, nothing else.
struct Reads {
  bool tip_position = false;        ///< of the tip, units of L
  bool tip_angle = false;           ///< of the tip, rad
  bool bending_energy = false;      ///< half the integral of EI (kappa - kappa0)^2, units of EI0/L
  bool moments = false;             ///< of the actuators, units of EI0/L
  bool tensions = false;            ///< of tendons, units of EI0/L^2; the rod must have one
  bool shortenings = false;         ///< of tendons, units of L; the rod must have one
  bool contact_point = false;       ///< where the rod touches, units of L
  bool contact_gap = false;         ///< distance of that point to the obstacle, units of L
  bool contact_normal = false;      ///< unit normal out of the obstacle there
  bool contact_force = false;       ///< normal force, units of EI0/L^2
  bool contact_arc_length = false;  ///< where along the rod it touches, units of L
  bool insertion = false;           ///< how much of the rod is out of its port, units of L, which is out at most
  bool palm_distance = false;       ///< from the palm to the object's centre, units of L; grasps only
  bool tip_deviations = false;      ///< where uncertain numbers take the tip, units of L; the scene must have some
  bool target = false;              ///< the scene must have a [target]
  /// the term means a grasp whose other finger is the mirror image of the one that it sees, as the square of the force
  /// on the object does: it is refused where both fingers are planned
  bool mirrored = false;
  /// arc lengths s/L in [0,1] of backbone samples: 0 is where the rod is clamped, wherever its base is moved to, and
  /// points of a rod that is drawn in lie straight behind its port
  std::vector<double> samples{};

  /// Whether anything of a contact is read.
  bool any_contact() const {
    return contact_point || contact_gap || contact_normal || contact_force || contact_arc_length;
  }
};

/// A backbone point. Dimensionless; angle in rad; curvature times L.
template <class T>
struct BackboneQuantities {
  T x{};          ///< units of L
  T y{};          ///< units of L
  T angle{};      ///< rad
  T curvature{};  ///< times L
  T strain{};     ///< eps, of samples of a rod that stretches
};

/// One planned contact. The normal points out of the obstacle.
template <class T>
struct ContactQuantities {
  T x{};            ///< of the point, units of L
  T y{};            ///< of the point, units of L
  T gap{};          ///< distance to the obstacle, units of L
  T normal_x{};     ///< unit vector out of the obstacle
  T normal_y{};     ///< unit vector out of the obstacle
  T force{};        ///< along the normal on the rod, units of EI0/L^2
  T arc_length{};   ///< units of L
  T reference_x{};  ///< the obstacle's reference point, a circle's centre (P_o of the paper)
  T reference_y{};  ///< likewise
};

/// Where the tip goes, to first order, with what is uncertain, one standard deviation of it.
template <class T>
struct TipDeviation {
  T x{};  ///< units of L
  T y{};  ///< units of L
};

/// The pose asked for, dimensionless.
struct Target {
  Vec2 position{};            ///< of the tip, units of L
  double angle = 0.0;         ///< of the tip, rad
  bool has_position = false;  ///< whether a position is asked for
  bool has_angle = false;     ///< whether an angle is asked for
  /// Whether the same is asked for, in the same numbers.
  bool operator==(const Target&) const = default;
};

/// Everything a term may read of one finger, dimensionless (docs/model.md section 1). What Reads did not ask for is
/// zero, or empty. A pose has one finger, and so has a grasp whose other finger is its mirror image. In a grasp points
/// are measured from the object's centre, x along the axis of symmetry; the palm is at x = -palm_distance. Where both
/// fingers are planned the term is asked for each in turn, for the lower one in its mirror image, and the values are
/// added. Units are those of the scene's rod, whatever the fingers are like.
template <class T>
struct Quantities {
  BackboneQuantities<T> tip{};                       ///< the rod's end
  std::span<const BackboneQuantities<T>> samples{};  ///< in the order of Reads::samples
  /// interior ones in order along the rod, then those at the tip
  std::span<const ContactQuantities<T>> contacts{};
  std::span<const T> moments{};   ///< one per actuator, units of EI0/L
  std::span<const T> tensions{};  ///< one per tendon, in the order of the actuators, units of EI0/L^2
  /// one per tendon, units of L: by what its way along the rod is shorter than along the straight rod
  std::span<const T> shortenings{};
  /// under held moments, contacts closed: one for each number of the scene with an error bar, or for as many sums of
  /// those that are correlated, each of which is independent of the others; squares add up to the variance
  std::span<const TipDeviation<T>> tip_deviations{};
  T bending_energy{};  ///< units of EI0/L
  T insertion{};       ///< units of L, which is out at most; 1 of a rod that is not drawn in or out
  T palm_distance{};   ///< units of L
  Target target{};     ///< what the scene asks for
};

/// Collects what a term contributes: the cost is  sum of residuals squared + smooth part.
template <class T>
class Contribution {
 public:
  /// Core's: `residuals` is where residuals are kept; those beyond its end are counted only.
  explicit Contribution(std::span<T> residuals) : residuals_(residuals) {}

  /// Adds r^2 to the cost. Backends that know least squares see r itself.
  void residual(const T& r) {
    if (count_ < residuals_.size()) residuals_[count_] = r;
    ++count_;
  }
  /// Adds v to the cost: any part that is no square. It may be 0, or left out, wherever it likes.
  void smooth(const T& v) { smooth_ += v; }

  /// Residuals added so far.
  std::size_t residual_count() const { return count_; }
  /// Sum of the smooth parts.
  const T& smooth_part() const { return smooth_; }

 private:
  std::span<T> residuals_;
  std::size_t count_ = 0;
  T smooth_{};
};

/// One weighted term of the objective. Write it with ObjectiveBase; core does derivatives and the chain rule. The
/// scalar weight is core's: the term returns its unweighted value.
class TENDRIL_API ObjectiveTerm {
 public:
  virtual ~ObjectiveTerm();
  /// What the term is handed. Asked whenever a program is assembled; must not change.
  virtual Reads reads() const = 0;
  /// A number that the term can never go below, whatever it is given; -infinity if there is none.
  /// 0 by default is right for a sum of squares. Core uses it to leave out modes that cannot win.
  virtual double lower_bound() const;
  /// Adds the term's value at x to `out`. Must not allocate.
  virtual void evaluate(const Quantities<double>& x, Contribution<double>& out) const = 0;
  /// The same with derivatives along two directions.
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
  /// Calls the template.
  void evaluate(const Quantities<double>& x, Contribution<double>& out) const final {
    static_cast<const Term&> (*this)(x, out);
  }
  /// Calls the template.
  void evaluate(const Quantities<HyperDual>& x, Contribution<HyperDual>& out) const final {
    static_cast<const Term&> (*this)(x, out);
  }
};

}  // namespace tendril
