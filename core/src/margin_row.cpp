#include "margin_row.hpp"

#include <cmath>

namespace tendril {
namespace {

/// Steps below it tell nothing about second derivatives: rounding of the gradients is as large.
constexpr double shortest_step = 1e-7;
/// An update is left out where its denominator is below this share of its factors.
constexpr double sound_update = 1e-8;

PoseProgramSpec without_row(PoseProgramSpec spec) {
  spec.least_margin.reset();
  spec.checks.clear();
  spec.terms.clear();
  return spec;
}

/// With nothing left free there is nothing to be unstable: the margin of a rod without loads.
double bounded(double margin) { return margin == infinity ? 1.0 : margin; }

}  // namespace

MarginRow::MarginRow(const PoseProgramSpec& spec) : program_(without_row(spec)), stability_(program_) {
  const int n = program_.variable_count();
  gradient_.setZero(n);
  x_before_.setZero(n);
  gradient_before_.setZero(n);
  step_.setZero(n);
  defect_.setZero(n);
  hessian_.setZero(n, n);
}

double MarginRow::value(ConstVectorRef x) {
  program_.invalidate();
  return bounded(stability_.margin(program_, x));
}

double MarginRow::differentiate(ConstVectorRef x) {
  program_.invalidate();
  const double margin = bounded(stability_.margin(program_, x, gradient_));
  learn(x);
  return margin;
}

void MarginRow::learn(ConstVectorRef x) {
  if (!gradient_.allFinite()) return;
  if (has_before_) {
    step_ = x - x_before_;
    const double length = step_.norm();
    if (!(length > shortest_step)) return;
    defect_ = gradient_ - gradient_before_;
    defect_.noalias() -= hessian_ * step_;
    const double along = defect_.dot(step_);
    if (std::abs(along) > sound_update * defect_.norm() * length) {
      hessian_.noalias() += (1.0 / along) * defect_ * defect_.transpose();
    }
  }
  x_before_ = x;
  gradient_before_ = gradient_;
  has_before_ = true;
}

}  // namespace tendril
