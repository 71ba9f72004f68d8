// Damped Newton on the shooting's unknowns.

#include "support/rod_shooting.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

namespace tendril::support {

/// The fraction of `step` that keeps nine tenths of a knot's neighbours from being eaten at once.
double Shooting::longest_step(const Eigen::VectorXd& step) const {
  double fraction = 1.0;
  const auto move = [&](std::size_t knot) {
    return knots_[knot].contact ? step[arc_index_[*knots_[knot].contact]] : 0.0;
  };
  for (const Piece& p : pieces_) {
    const double width = place(p.right, unknowns_) - place(p.left, unknowns_);
    const double shrink = move(p.left) - move(p.right);
    if (shrink > 0.9 * width) fraction = std::min(fraction, 0.9 * width / shrink);
  }
  return fraction;
}

BvpSolution Shooting::run() {
  Eigen::MatrixXd jacobian;
  double last_fraction = 1.0;
  bool done = false;
  for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
    const Eigen::VectorXd r = assemble(unknowns_, &jacobian);
    if (!r.allFinite() || !jacobian.allFinite()) throw BvpError("the shooting residual is not finite");
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(jacobian);
    const Eigen::VectorXd step = -lu.solve(r);
    if (!step.allFinite()) throw BvpError("the shooting Jacobian is singular");
    const double size = scaled(step);
    if (done) {
      // One step beyond the tolerance: quadratic convergence takes it to rounding.
      if (size <= options_.tolerance) unknowns_ += step;
      double moment_rate = 0.0;
      if (free_actuator_) moment_rate = lu.solve(Eigen::VectorXd::Unit(r.size(), moment_index_))[moment_index_];
      return solution(iteration, moment_rate);
    }
    double fraction = std::min({longest_step(step), 2.0 * last_fraction, 1.0});
    // Damping by the natural level function: it does not care how rows are scaled.
    bool accepted = false;
    while (fraction >= 1e-6) {
      const Eigen::VectorXd trial = unknowns_ + fraction * step;
      Eigen::VectorXd trial_residual;
      bool finite = true;
      try {
        trial_residual = residual(trial);
        finite = trial_residual.allFinite();
      } catch (const BvpError&) {
        finite = false;  // a trial that turns too fast is simply too far
      }
      if (finite && (size < 1e-8 || scaled(lu.solve(trial_residual)) <= (1.0 - 0.25 * fraction) * size)) {
        unknowns_ = trial;
        accepted = true;
        break;
      }
      fraction *= 0.5;
    }
    if (!accepted) throw BvpError("damped Newton stalled at a step of " + std::to_string(size));
    last_fraction = fraction;
    done = fraction == 1.0 && size <= options_.tolerance;
  }
  throw BvpError("Newton did not converge in " + std::to_string(options_.max_iterations) + " iterations");
}

BvpSolution Shooting::solution(int iterations, double moment_rate) const {
  BvpSolution out;
  out.iterations = iterations;
  out.moment_rate = moment_rate;
  out.moments = moments_;
  if (free_actuator_) out.moments[*free_actuator_] = unknowns_[moment_index_];
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    out.arc_lengths.push_back(arc_index_[k] >= 0 ? unknowns_[arc_index_[k]] : rod_.length());
    out.forces.push_back(unknowns_[force_index_[k]]);
  }
  for (const Piece& p : pieces_) {
    const Field<double> f = field(p, unknowns_);
    const double h = interval_length(p, unknowns_);
    for (std::size_t i = 0; i < p.count; ++i) {
      out.intervals.push_back({place(p.left, unknowns_) + static_cast<double>(i) * h, h, f.stiffness, f.free_curvature,
                               f.weight, state(unknowns_, p.first + i)});
    }
  }
  const BvpState tip = out.at(rod_.length());
  out.tip_x = tip.x;
  out.tip_y = tip.y;
  out.tip_angle = tip.angle;
  return out;
}

}  // namespace tendril::support
