#include "program/equations.hpp"

#include <numeric>
#include <utility>

namespace tendril {
namespace {

void append(std::vector<int>& list, int first, int count) {
  const auto before = static_cast<std::ptrdiff_t>(list.size());
  list.resize(list.size() + static_cast<std::size_t>(count));
  std::iota(list.begin() + before, list.end(), first);
}

}  // namespace

Equations::Equations(PoseProgram& program, std::vector<int> rows, std::vector<int> unknowns)
    : program_(program), rows_(std::move(rows)), unknowns_(std::move(unknowns)), factors_(size()) {
  residual_.setZero(size());
  jacobian_.setZero(size(), size());
}

Equations Equations::of_contacts(PoseProgram& program, const std::vector<int>& taut) {
  const PoseProgram::Layout& at = program.layout();
  std::vector<int> rows, unknowns;
  append(rows, 0, at.coordinates);
  append(rows, at.first_closest, at.arc_lengths);
  append(unknowns, 0, at.coordinates);
  append(unknowns, at.first_arc_length, at.arc_lengths);
  for (int k = 0; k < at.forces; ++k) {
    if (program.branch(k) == Branch::separated) continue;
    rows.push_back(at.first_gap + k);
    unknowns.push_back(at.first_force + k);
  }
  for (const int tendon : taut) {
    rows.push_back(program.shortening_row(tendon));
    unknowns.push_back(program.moment_variable(tendon));
  }
  append(rows, at.first_stick, at.shears);
  append(unknowns, at.first_shear, at.shears);
  return {program, std::move(rows), std::move(unknowns)};
}

Equations Equations::of_equilibrium(PoseProgram& program) {
  std::vector<int> coordinates;
  append(coordinates, 0, program.layout().coordinates);
  return {program, coordinates, coordinates};
}

PoseProgramSpec Equations::alone(PoseProgramSpec spec) {
  spec.tolerance = {};
  spec.least_margin.reset();
  spec.least_convexity.reset();
  spec.checks.clear();
  spec.terms.clear();
  return spec;
}

const Eigen::VectorXd& Equations::residual_at(ConstVectorRef x) {
  const VectorView rows = program_.constraints(x);
  for (int r = 0; r < size(); ++r) residual_[r] = rows[row(r)];
  return residual_;
}

bool Equations::evaluate(ConstVectorRef x) {
  const MatrixView jacobian = program_.jacobian(x);
  residual_at(x);
  for (int c = 0; c < size(); ++c) {
    for (int r = 0; r < size(); ++r) jacobian_(r, c) = jacobian(row(r), unknown(c));
  }
  return residual_.allFinite() && jacobian_.allFinite();
}

const Eigen::PartialPivLU<Eigen::MatrixXd>& Equations::factor() {
  if (size() > 0) factors_.compute(jacobian_);
  return factors_;
}

int Equations::sign() const {
  int sign = size() > 0 ? static_cast<int>(factors_.permutationP().determinant()) : 1;
  for (int r = 0; r < size(); ++r) {
    const double pivot = factors_.matrixLU()(r, r);
    sign = pivot > 0.0 ? sign : pivot < 0.0 ? -sign : 0;
  }
  return sign;
}

void Equations::find_rates(ConstVectorRef x, const std::vector<int>& variables, Eigen::MatrixXd& out) {
  const MatrixView jacobian = program_.jacobian(x);
  right_.resize(size(), static_cast<Eigen::Index>(variables.size()));
  for (Eigen::Index c = 0; c < right_.cols(); ++c) {
    for (int r = 0; r < size(); ++r) right_(r, c) = -jacobian(row(r), variables[static_cast<std::size_t>(c)]);
  }
  out.resize(right_.rows(), right_.cols());
  if (right_.size() > 0) out = factors_.solve(right_);
}

}  // namespace tendril
