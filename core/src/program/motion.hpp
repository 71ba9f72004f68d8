#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "program/pose_program.hpp"

namespace tendril {

/// How a body moves with a number: velocities of its points, which turn about the origin and are stretched away from
/// it, and of its surface, which may move outward besides. Dimensionless, per unit of the number.
struct Motion {
  Vec2 shift{};
  double turn = 0.0;
  double stretch = 0.0;
  double growth = 0.0;

  Vec2 at(Vec2 point) const { return shift + turn * turned(point) + stretch * point; }
  friend Motion operator-(const Motion& a, const Motion& b) {
    return {a.shift - b.shift, a.turn - b.turn, a.stretch - b.stretch, a.growth - b.growth};
  }
};

/// A turn about a point.
inline Motion turn_about(Vec2 point, double turn) { return {-turn * turned(point), turn}; }

/// How what a pose program is assembled from moves with a number.
struct ProgramMotion {
  Motion base{};                    ///< of the rod with its base, which neither stretches nor grows; loads stand still
  std::vector<Motion> obstacles{};  ///< one per obstacle; empty: they stand still

  /// Of the rod against an obstacle.
  Motion against(int obstacle) const {
    return obstacles.empty() ? base : base - obstacles[static_cast<std::size_t>(obstacle)];
  }
};

/// Partial derivatives of a program by a number at a point and multipliers that are held.
struct ProgramRates {
  Eigen::VectorXd slope;          ///< of the gradient of  f + multipliers . c, by variables
  Eigen::VectorXd rows;           ///< of c
  double cost = 0.0;              ///< of f
  Eigen::VectorXd convexities{};  ///< of d_ss of contacts; empty: not asked for
  double energy = 0.0;            ///< of the elastic energy of some displacement
};

/// How the programs of one spec change where bodies move: at one point of them, with one set of multipliers. Not of
/// programs with a palm, nor of rows that keep a plan stable or at its target. Without terms nothing allocates after
/// construction.
class MotionRates {
 public:
  explicit MotionRates(const PoseProgramSpec& spec);
  ~MotionRates();
  MotionRates(const MotionRates&) = delete;
  MotionRates& operator=(const MotionRates&) = delete;

  /// To a point, where multipliers are zero, or those of before.
  void move(ConstVectorRef x);
  /// `multipliers`: of the program's rows, at this point.
  void weigh(ConstVectorRef multipliers);
  /// Adds the rates under a motion. In words why there are none; empty: there are.
  std::string add(const ProgramMotion& motion, ProgramRates& out);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace tendril
