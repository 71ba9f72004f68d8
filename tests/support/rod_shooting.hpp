#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "support/rod_bvp.hpp"
#include "support/rod_flow.hpp"

namespace tendril::support {

inline bool is_wall(const BvpContact& c) { return c.wall_normal.x != 0.0 || c.wall_normal.y != 0.0; }

/// Outward normal and gap of an obstacle seen from (x, y).
template <class T>
struct Surface {
  T nx, ny, gap;
};

template <class T>
Surface<T> surface(const BvpContact& c, const T& x, const T& y) {
  using std::sqrt;
  const T dx = x - c.center.x;
  const T dy = y - c.center.y;
  if (is_wall(c)) return {T(c.wall_normal.x), T(c.wall_normal.y), dx * c.wall_normal.x + dy * c.wall_normal.y};
  const T distance = sqrt(dx * dx + dy * dy);
  return {dx / distance, dy / distance, distance - c.radius};
}

/// A knot at a constant arc length or at an interior contact.
struct Knot {
  double place = 0.0;
  std::optional<std::size_t> contact;
};

/// The rod between two knots, cut into `count` shooting intervals of equal length.
struct Piece {
  std::size_t left;
  std::size_t right;
  std::size_t count;
  std::size_t first;  ///< index of the first interval
  RodSection section;
  std::vector<bool> spanned;  ///< per actuator
};

/// The boundary-value problem by multiple shooting: the unknowns are the states at the intervals' begins, then each
/// contact's arc length and force, then the moment of a free actuator.
class Shooting {
 public:
  Shooting(const RodBvp& rod, std::vector<double> moments, const std::vector<BvpContact>& contacts,
           const BvpGuess& guess, const BvpOptions& options, std::optional<std::size_t> free_actuator, double tip_angle)
      : rod_(rod),
        moments_(std::move(moments)),
        contacts_(contacts),
        options_(options),
        free_actuator_(free_actuator),
        tip_angle_(tip_angle) {
    check(guess);
    lay_out(guess);
    start(guess);
  }

  BvpSolution run();

 private:
  void check(const BvpGuess& guess) const;
  void lay_out(const BvpGuess& guess);
  void start(const BvpGuess& guess);

  double place(std::size_t knot, const Eigen::VectorXd& u) const {
    const Knot& k = knots_[knot];
    return k.contact ? u[arc_index_[*k.contact]] : k.place;
  }
  double interval_length(const Piece& p, const Eigen::VectorXd& u) const {
    return (place(p.right, u) - place(p.left, u)) / static_cast<double>(p.count);
  }
  Field<double> field(const Piece& p, const Eigen::VectorXd& u) const {
    double moment = 0.0;
    for (std::size_t j = 0; j < moments_.size(); ++j) {
      if (p.spanned[j]) moment += free_actuator_ == j ? u[moment_index_] : moments_[j];
    }
    return {p.section.stiffness,
            p.section.rest_curvature + moment / p.section.stiffness,
            {p.section.density * rod_.gravity.x, p.section.density * rod_.gravity.y}};
  }
  static State<double> state(const Eigen::VectorXd& u, std::size_t interval) {
    State<double> z;
    for (std::size_t i = 0; i < kStates; ++i) z[i] = u[static_cast<Eigen::Index>(kStates * interval + i)];
    return z;
  }
  Eigen::VectorXd residual(const Eigen::VectorXd& u) const { return assemble(u, nullptr); }
  Eigen::VectorXd assemble(const Eigen::VectorXd& u, Eigen::MatrixXd* jacobian) const;
  double scaled(const Eigen::VectorXd& step) const {
    return (step.array().abs() / unknowns_.array().abs().max(1.0)).maxCoeff();
  }
  double longest_step(const Eigen::VectorXd& step) const;
  BvpSolution solution(int iterations, double moment_rate) const;

  RodBvp rod_;
  std::vector<double> moments_;
  std::vector<BvpContact> contacts_;
  BvpOptions options_;
  std::optional<std::size_t> free_actuator_;
  double tip_angle_;

  std::vector<Knot> knots_;
  std::vector<Piece> pieces_;
  std::size_t interval_count_ = 0;
  std::vector<Eigen::Index> arc_index_;    ///< per contact, -1 at the tip
  std::vector<Eigen::Index> force_index_;  ///< per contact
  Eigen::Index moment_index_ = -1;
  Eigen::VectorXd unknowns_;
};

}  // namespace tendril::support
