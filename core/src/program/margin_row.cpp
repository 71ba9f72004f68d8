#include "program/margin_row.hpp"

#include "program/equations_alone.hpp"

namespace tendril {
namespace {

/// With nothing left free there is nothing to be unstable: the margin of a rod without loads.
double bounded(double margin) { return margin == infinity ? 1.0 : margin; }

}  // namespace

MarginRow::MarginRow(const PoseProgramSpec& spec)
    : program_(equations_alone(spec)), stability_(program_), learned_(program_.variable_count()) {
  gradient_.setZero(program_.variable_count());
}

double MarginRow::value(ConstVectorRef x) { return bounded(stability_.margin(program_, x)); }

double MarginRow::differentiate(ConstVectorRef x) {
  const double margin = bounded(stability_.margin(program_, x, gradient_));
  learned_.learn(x, gradient_);
  return margin;
}

}  // namespace tendril
