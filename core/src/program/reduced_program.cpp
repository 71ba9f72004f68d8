#include "program/reduced_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nlp/newton.hpp"

namespace tendril {
namespace {

/// Newton's method on the equations: every bound on its steps keeps it on its branch.
constexpr int most_corrections = 25;
constexpr double small = 1e-6;       ///< correction, relative to 1 + the largest variable, that is followed by one more
constexpr double contraction = 0.5;  ///< a correction larger than this of the one before does not converge
constexpr double farthest = 0.5;     ///< first correction, relative to 1 + the largest variable
/// Of a step along the branch, each variable relative to 1 + itself.
constexpr double longest_step = 0.5;
constexpr double largest_correction = 0.5;  ///< what the correction may be of the step
constexpr double settling = 1e-7;           ///< ... and besides: the start is given to this
/// A way to other moments is cut into halves as often as this before the branch counts as ended.
constexpr double shortest_way = 1e-4;
constexpr double anchor_spacing = 0.5;  ///< of the grid of moments (EI/L)

bool is_equation(const PoseProgram& program, int row) { return program.row_lower()[row] == program.row_upper()[row]; }

}  // namespace

ReducedProgram::Parts ReducedProgram::parts_of(const PoseProgram& program) {
  Parts parts;
  const PoseProgram::Layout& at = program.layout();
  std::vector<int> ratios;
  for (int i = 0; i < program.variable_count(); ++i) {
    // A force with one value is a condition on what is chosen.
    const bool force = i >= at.first_force && i < at.first_force + at.forces;
    if (program.lower()[i] == program.upper()[i] && !force) continue;
    if (i >= at.first_lean && i < at.first_lean + at.leans) {
      ratios.push_back(i);
    } else if (i == at.palm || (i >= at.first_moment && i < at.first_arc_length)) {
      parts.chosen.push_back(i);
    } else {
      parts.following.push_back(i);
      const bool bounded = std::isfinite(program.lower()[i]) || std::isfinite(program.upper()[i]);
      if (bounded) parts.limited.push_back(static_cast<int>(parts.following.size()) - 1);
    }
  }
  parts.ratios = static_cast<int>(ratios.size());
  parts.chosen.insert(parts.chosen.end(), ratios.begin(), ratios.end());
  // Behind the check points rows ask for something.
  for (int i = 0; i < program.row_count(); ++i) {
    (is_equation(program, i) && i < at.first_check ? parts.equations : parts.others).push_back(i);
  }
  return parts;
}

bool ReducedProgram::applies(const PoseProgram& program) {
  for (int k = 0; k < program.layout().forces; ++k) {
    if (program.branch(k) == Branch::open) return false;
  }
  const Parts parts = parts_of(program);
  return !parts.chosen.empty() && parts.equations.size() == parts.following.size();
}

ReducedProgram::ReducedProgram(PoseProgram& program, ConstVectorRef x)
    : ReducedProgram(program, x, parts_of(program)) {}

ReducedProgram::ReducedProgram(PoseProgram& program, ConstVectorRef x, Parts parts)
    : NonlinearProgram(static_cast<int>(parts.chosen.size()),
                       static_cast<int>(parts.others.size() + parts.limited.size()), program.residual_count()),
      program_(program),
      parts_(std::move(parts)),
      alone_(Equations::alone(program.spec())),
      equations_(alone_, parts_.equations, parts_.following),
      x_(x) {
  const auto chosen = static_cast<Eigen::Index>(parts_.chosen.size());
  const auto following = static_cast<Eigen::Index>(parts_.following.size());
  for (int k = 0; k < program.layout().forces; ++k) alone_.set_branch(k, program.branch(k));
  reached_at_ = Eigen::VectorXd::Constant(chosen, std::numeric_limits<double>::quiet_NaN());
  start_.resize(chosen);
  for (int j = 0; j < chosen; ++j) {
    const int i = parts_.chosen[static_cast<std::size_t>(j)];
    lower_[j] = program.lower()[i];
    upper_[j] = program.upper()[i];
    start_[j] = std::clamp(x[i], lower_[j], upper_[j]);
    x_[i] = start_[j];
  }
  const auto others = static_cast<int>(parts_.others.size());
  for (int r = 0; r < others; ++r) {
    row_lower_[r] = program.row_lower()[parts_.others[static_cast<std::size_t>(r)]];
    row_upper_[r] = program.row_upper()[parts_.others[static_cast<std::size_t>(r)]];
  }
  for (std::size_t r = 0; r < parts_.limited.size(); ++r) {
    const int i = parts_.following[static_cast<std::size_t>(parts_.limited[r])];
    row_lower_[others + static_cast<int>(r)] = program.lower()[i];
    row_upper_[others + static_cast<int>(r)] = program.upper()[i];
  }
  slope_.setZero(following, chosen);
  residual_.setZero(following);
  correction_.setZero(following);
  step_.setZero(program.variable_count());
  adjoint_.setZero(following);
  full_multipliers_.setZero(program.row_count());
  tangent_.setZero(program.variable_count(), chosen);
  for (int j = 0; j < chosen; ++j) tangent_(parts_.chosen[static_cast<std::size_t>(j)], j) = 1.0;
  bent_.setZero(program.variable_count(), chosen);
  predicted_ = x_;
  middle_ = start_;
  cell_.assign(parts_.chosen.size(), 0);
  Anchor& first = anchors_[cell_];
  if (!correct()) return;
  find_slopes();
  first = {x_, slope_, sign_};
}

ReducedProgram::~ReducedProgram() = default;

bool ReducedProgram::correct() {
  if (equations_.size() == 0) return equations_.evaluate(x_);
  double before = infinity;
  const auto correction = [&](const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
    if (!equations_.evaluate(x)) return infinity;
    correction_ = equations_.factor().solve(equations_.residual());
    double size = 1.0;
    for (int i = 0; i < equations_.size(); ++i) {
      dx[equations_.unknown(i)] = -correction_[i];
      size = std::max(size, std::abs(x[equations_.unknown(i)]));
    }
    return correction_.cwiseAbs().maxCoeff() / size;
  };
  // What does not converge at first has left its branch; after a small correction the next one is rounding, however
  // large that is.
  const auto share = [&](const Eigen::VectorXd& /*x*/, const Eigen::VectorXd& /*dx*/, double size) {
    const double most = before == infinity ? farthest : contraction * before;
    const bool converges = size <= most || before <= small;
    before = size;
    return converges ? 1.0 : 0.0;
  };
  return newton(x_, step_, most_corrections, small, correction, share).converged;
}

void ReducedProgram::find_slopes() {
  equations_.evaluate(x_);
  equations_.factor();
  equations_.find_rates(x_, parts_.chosen, slope_);
  sign_ = equations_.sign();
  for (int r = 0; r < equations_.size(); ++r) tangent_.row(equations_.unknown(r)) = slope_.row(r);
}

double ReducedProgram::distance(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  double largest = 0.0;
  for (const int i : parts_.following)
    largest = std::max(largest, std::abs(to[i] - from[i]) / (1.0 + std::abs(from[i])));
  return largest;
}

bool ReducedProgram::follow(ConstVectorRef u) {
  if (!u.allFinite()) return false;
  for (Eigen::Index j = 0; j < u.size(); ++j) {
    // Beyond any number of cells that could be followed through, one is as good as another.
    const double cells = std::clamp((u[j] - start_[j]) / anchor_spacing, -1e6, 1e6);
    cell_[static_cast<std::size_t>(j)] = static_cast<int>(std::lround(cells));
  }
  return follow(anchor(cell_), u);
}

const ReducedProgram::Anchor& ReducedProgram::anchor(const std::vector<int>& cell) {
  if (const auto known = anchors_.find(cell); known != anchors_.end()) return known->second;
  std::vector<int> nearer = cell;
  for (int& i : nearer) i /= 2;
  const Anchor& from = anchor(nearer);
  for (std::size_t j = 0; j < cell.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    middle_[i] = std::clamp(start_[i] + anchor_spacing * cell[j], lower_[i], upper_[i]);
  }
  Anchor& made = anchors_[cell];
  if (follow(from, middle_)) {
    made = {x_, slope_, sign_};
  } else {
    made = from;
  }
  return made;
}

bool ReducedProgram::follow(const Anchor& from, ConstVectorRef u) {
  if (from.sign == 0) return false;
  const auto variable = [&](Eigen::Index j) { return parts_.chosen[static_cast<std::size_t>(j)]; };
  at_ = from;
  double left = 1.0;  // of the way
  for (double share = 1.0; share >= shortest_way;) {
    const bool whole = share >= left;
    predicted_ = at_.x;
    for (Eigen::Index j = 0; j < u.size(); ++j) {
      const double way = u[j] - at_.x[variable(j)];
      const double moved = whole ? way : share / left * way;
      predicted_[variable(j)] = whole ? u[j] : at_.x[variable(j)] + moved;
      for (Eigen::Index c = 0; c < at_.slope.rows(); ++c) {
        predicted_[parts_.following[static_cast<std::size_t>(c)]] += at_.slope(c, j) * moved;
      }
    }
    // On its own branch the rod is found near where its slopes point to, if these point no farther than they hold, and
    // the determinant of the equations keeps its sign.
    const double pointed = distance(at_.x, predicted_);
    x_ = predicted_;
    bool found =
        pointed <= longest_step && correct() && distance(predicted_, x_) <= largest_correction * pointed + settling;
    if (found) {
      find_slopes();
      found = sign_ == from.sign;
    }
    if (!found) {
      share *= 0.5;
      continue;
    }
    if (whole) return true;
    at_.x = x_;
    at_.slope = slope_;
    left -= share;
    share *= 2.0;
  }
  return false;
}

const Eigen::VectorXd& ReducedProgram::full(ConstVectorRef u) {
  cost(u);
  return x_;
}

void ReducedProgram::do_evaluate(ConstVectorRef u, bool derivatives, Workspace& out) {
  if (!reached_ || reached_at_ != u) {
    reached_ = follow(u);
    reached_at_ = u;
  }
  const auto others = static_cast<int>(parts_.others.size());
  if (!reached_) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    x_.setConstant(none);
    out.cost = out.rest = none;
    out.constraints.setConstant(none);
    out.residuals.setConstant(none);
    if (!derivatives) return;
    out.gradient.setConstant(none);
    out.rest_gradient.setConstant(none);
    out.jacobian.setConstant(none);
    out.residual_jacobian.setConstant(none);
    return;
  }
  out.cost = program_.cost(x_);
  out.rest = program_.rest(x_);
  out.residuals = program_.residuals(x_);
  const VectorView rows = program_.constraints(x_);
  for (int r = 0; r < others; ++r) out.constraints[r] = rows[parts_.others[static_cast<std::size_t>(r)]];
  for (std::size_t r = 0; r < parts_.limited.size(); ++r) {
    out.constraints[others + static_cast<int>(r)] = x_[parts_.following[static_cast<std::size_t>(parts_.limited[r])]];
  }
  if (!derivatives) return;
  out.gradient.noalias() = tangent_.transpose() * program_.gradient(x_);
  out.rest_gradient.noalias() = tangent_.transpose() * program_.rest_gradient(x_);
  out.residual_jacobian.noalias() = program_.residual_jacobian(x_) * tangent_;
  const MatrixView jacobian = program_.jacobian(x_);
  for (int r = 0; r < others; ++r) {
    out.jacobian.row(r).noalias() = jacobian.row(parts_.others[static_cast<std::size_t>(r)]) * tangent_;
  }
  for (std::size_t r = 0; r < parts_.limited.size(); ++r) {
    out.jacobian.row(others + static_cast<int>(r)) = slope_.row(parts_.limited[r]);
  }
}

void ReducedProgram::do_hessian(ConstVectorRef /*u*/, double sigma, ConstVectorRef multipliers, Workspace& out) {
  if (!reached_) {
    out.hessian.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  // Multipliers of the equations, for which the Lagrangian does not change with what follows.
  const auto others = static_cast<int>(parts_.others.size());
  const auto n = static_cast<Eigen::Index>(parts_.following.size());
  const VectorView gradient = program_.gradient(x_);
  const MatrixView jacobian = program_.jacobian(x_);
  for (Eigen::Index c = 0; c < n; ++c) {
    const int i = parts_.following[static_cast<std::size_t>(c)];
    double sum = sigma * gradient[i];
    for (int r = 0; r < others; ++r) {
      sum += multipliers[r] * jacobian(parts_.others[static_cast<std::size_t>(r)], i);
    }
    residual_[c] = sum;
  }
  for (std::size_t r = 0; r < parts_.limited.size(); ++r) {
    residual_[parts_.limited[r]] += multipliers[others + static_cast<int>(r)];
  }
  if (n > 0) adjoint_ = equations_.factors().transpose().solve(residual_);
  for (Eigen::Index r = 0; r < n; ++r) full_multipliers_[parts_.equations[static_cast<std::size_t>(r)]] = -adjoint_[r];
  for (int r = 0; r < others; ++r) full_multipliers_[parts_.others[static_cast<std::size_t>(r)]] = multipliers[r];
  bent_.noalias() = program_.hessian(x_, sigma, full_multipliers_) * tangent_;
  out.hessian.noalias() = tangent_.transpose() * bent_;
}

std::string ReducedProgram::row_name(int row) const {
  const auto others = static_cast<int>(parts_.others.size());
  if (row < others) return program_.row_name(parts_.others[static_cast<std::size_t>(row)]);
  return program_.variable_name(
      parts_.following[static_cast<std::size_t>(parts_.limited[static_cast<std::size_t>(row - others)])]);
}

std::string ReducedProgram::variable_name(int variable) const {
  return program_.variable_name(parts_.chosen[static_cast<std::size_t>(variable)]);
}

}  // namespace tendril
