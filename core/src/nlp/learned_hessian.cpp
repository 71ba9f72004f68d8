#include "nlp/learned_hessian.hpp"

#include <cmath>

namespace tendril {
namespace {

/// Steps below it tell nothing about second derivatives: rounding of the gradients is as large.
constexpr double shortest_step = 1e-7;
/// An update is left out where its denominator is below this share of its factors.
constexpr double sound_update = 1e-8;

}  // namespace

LearnedHessian::LearnedHessian(int variables, double longest_step) : longest_step_(longest_step) {
  x_.setZero(variables);
  gradient_.setZero(variables);
  step_.setZero(variables);
  defect_.setZero(variables);
  hessian_.setZero(variables, variables);
}

void LearnedHessian::learn(ConstVectorRef x, ConstVectorRef gradient) {
  if (!gradient.allFinite()) return;
  if (has_point_) {
    step_ = x - x_;
    const double length = step_.norm();
    if (!(length > shortest_step)) return;
    defect_ = gradient - gradient_;
    defect_.noalias() -= hessian_ * step_;
    const double along = defect_.dot(step_);
    if (!(length <= longest_step_)) {
      hessian_.setZero();
    } else if (std::abs(along) > sound_update * defect_.norm() * length) {
      hessian_.noalias() += (1.0 / along) * defect_ * defect_.transpose();
    }
  }
  x_ = x;
  gradient_ = gradient;
  has_point_ = true;
}

}  // namespace tendril
