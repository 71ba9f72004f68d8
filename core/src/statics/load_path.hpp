#pragma once

#include <vector>

#include "program/pose_program.hpp"

namespace tendril {

/// Moments, loads, moves of the rod and sizes of obstacles as functions of the load fraction: everything is affine in
/// it, so that rates are exact differences.
class TENDRIL_API LoadPath {
 public:
  struct Ends {
    /// Moments at load 0 and 1, one per actuator of the rod; with `holds_lengths` of tendons told their length their
    /// shortenings over the size of their largest offsets.
    std::vector<double> first, last;
    bool loads_grow = true;      ///< gravity and tip force start from 0; else they act from the beginning
    bool holds_lengths = false;  ///< of tendons told their length; else their tensions
    std::vector<double> first_moves{}, last_moves{};  ///< of Rod::moves at load 0 and 1
  };
  LoadPath(Rod rod, const std::vector<const Obstacle*>& obstacles, Ends ends);

  /// Obstacle o starts `by` smaller and grows back with the load.
  void grow(std::size_t o, double by) { shrink_[o] = by; }
  /// Contacts with obstacle o push along its normal and with this tangential part, at load 0 and at load 1.
  void rub(std::size_t o, double first, double ratio) {
    first_friction_.resize(obstacles_.size()), first_friction_[o] = first;
    friction_.resize(obstacles_.size()), friction_[o] = ratio;
  }
  bool has_friction() const { return !friction_.empty(); }
  /// Contacts with obstacle o stick and slip at this coefficient of friction.
  void roughen(std::size_t o, double coefficient) {
    coefficients_.resize(obstacles_.size()), coefficients_[o] = coefficient;
  }
  double coefficient(int o) const { return is_rough() ? coefficients_[static_cast<std::size_t>(o)] : 0.0; }
  bool is_rough() const { return !coefficients_.empty(); }  ///< anything is
  /// What the square of a change of the load counts beside the bending energy, in which steps are measured: little
  /// friction changes little.
  double weight() const;
  /// The rod under its final loads.
  const Rod& rod() const { return rod_; }
  const std::vector<const Obstacle*>& obstacles() const { return obstacles_; }
  Loads loads(double load) const;
  /// Whether the actuator is a tendon that is held by its length: its moment follows.
  bool holds_length(std::size_t actuator) const { return rod_.actuators[actuator].by_length; }
  /// Of such a tendon, where the path begins.
  void begin_at(std::size_t actuator, double shortening) { ends_.first[actuator] = shortening; }
  /// What is held at a load: moment, or shortening.
  double held(std::size_t actuator, double load) const {
    return (1.0 - load) * ends_.first[actuator] + load * ends_.last[actuator];
  }
  double held_rate(std::size_t actuator) const { return ends_.last[actuator] - ends_.first[actuator]; }
  /// 0 where a length is held.
  double moment(std::size_t actuator, double load) const { return holds_length(actuator) ? 0.0 : held(actuator, load); }
  double move(std::size_t i, double load) const {
    return (1.0 - load) * ends_.first_moves[i] + load * ends_.last_moves[i];
  }
  double move_rate(std::size_t i) const { return ends_.last_moves[i] - ends_.first_moves[i]; }
  /// d distance / d load of an obstacle at fixed points.
  double distance_rate(int o) const { return -shrink_[static_cast<std::size_t>(o)]; }
  double smallest_radius(std::size_t o, double load) const {
    return obstacles_[o]->smallest_radius() - (1.0 - load) * shrink_[o];
  }
  /// The rows of equilibrium change with the load at fixed moments.
  bool loads_grow() const {
    return has_friction() ||
           (ends_.loads_grow && (rod_.has_gravity() || rod_.has_tip_force() || rod_.has_dead_loads()));
  }

 private:
  Rod rod_;
  std::vector<const Obstacle*> obstacles_;
  Ends ends_;
  std::vector<double> shrink_, first_friction_, friction_, coefficients_;
};

}  // namespace tendril
