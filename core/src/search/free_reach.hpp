#pragma once

#include <functional>
#include <vector>

#include "program/equations.hpp"
#include "program/pose_program.hpp"

namespace tendril {

/// How near the tip of a rod that touches nothing can come to a point, whatever its moments within their limits.
///
/// Under loads that cannot buckle the rod its energy is convex: there is one equilibrium to each choice of moments, and
/// a change of these moves the tip no farther than a bound of the energy's curvature allows. So the equilibria at a few
/// moments stand for all others; more of them are looked at where that is not sharp enough.
class TENDRIL_API FreeReach {
 public:
  /// `spec`: of a program without contacts. Its pointers must outlive this.
  explicit FreeReach(PoseProgramSpec spec);

  /// A distance (units of L) from `point` that the tip is never nearer than, 0 where none is known: loads that may
  /// buckle the rod, moments without limits, properties that vary along it. It is made sharper until it is `enough`, or
  /// never will be.
  double least_distance(Vec2 point, const std::function<bool(double)>& enough);
  /// What it looks with.
  const NonlinearProgram& program() const { return program_; }

 private:
  /// Moments around those of an equilibrium.
  struct Cell {
    Eigen::VectorXd x;          ///< the equilibrium's variables: coordinates, moments
    std::vector<double> spans;  ///< half the width by each moment
    Vec2 tip{};
    double spread = 0.0;  ///< no tip of the cell is farther from `tip`
  };
  /// int ds / EI over a stretch, and what a unit of each moment bends there.
  struct Stretch {
    double compliance = 0.0;
    std::vector<double> levels;
  };

  /// The bound of the tip's motion by the energy norm of what moves it; infinity: there is none.
  static double flexibility(const Rod& rod);
  double spread(const std::vector<double>& spans) const;
  /// Whether the cell's equilibrium was found, from where its variables are.
  bool settle(Cell& cell);
  /// Cuts a cell in three by the moment that matters most.
  bool split(std::size_t cell);

  PoseProgram program_;
  Equations equations_;
  std::vector<Stretch> stretches_;
  double flexibility_ = infinity;
  std::vector<Cell> cells_;  ///< they cover what the limits allow; none: nothing is known
  Eigen::VectorXd step_;
};

}  // namespace tendril
