#include "program/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tendril/tolerances.hpp"

namespace tendril {

namespace {

/// Of small factors the blocks of a large product cost more than the product.
template <class A, class B>
void multiply(const A& a, const B& b, Eigen::MatrixXd& out) {
  constexpr Eigen::Index small = 16;
  if (a.cols() <= small) {
    out = a.lazyProduct(b);
  } else {
    out.noalias() = a * b;
  }
}

/// Of a symmetric tridiagonal matrix, by Laguerre's method from below Gershgorin's circles, which never passes the
/// smallest of real roots. The characteristic polynomial is the product of Sturm's quotients q.
double smallest_eigenvalue(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside) {
  // Comparisons pass over what is no number: of such a matrix nothing is known.
  if (!diagonal.allFinite() || !beside.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Index n = diagonal.size();
  double at = std::numeric_limits<double>::infinity();
  double size = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double radius = (i > 0 ? std::abs(beside[i - 1]) : 0.0) + (i + 1 < n ? std::abs(beside[i]) : 0.0);
    at = std::min(at, diagonal[i] - radius);
    size = std::max(size, std::abs(diagonal[i]) + radius);
  }
  const double rounding = std::numeric_limits<double>::epsilon() * size;
  constexpr int most_steps = 100;
  for (int step = 0; step < most_steps; ++step) {
    double first = 0.0;   // of the quotients, sum of -q'/q
    double second = 0.0;  // its derivative
    double q = 1.0, slope = 0.0, bend = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double back = i > 0 ? beside[i - 1] * beside[i - 1] / q : 0.0;
      const double bend_now = back * (bend - 2.0 * slope * slope);
      const double slope_now = back * slope - 1.0;
      q = diagonal[i] - at - back;
      if (!(q > 0.0)) return at;
      slope = slope_now / q;
      bend = bend_now / q;
      first -= slope;
      second += slope * slope - bend;
    }
    const auto count = static_cast<double>(n);
    const double root = std::sqrt(std::max(0.0, (count - 1.0) * (count * second - first * first)));
    const double taken = count / (first + root);
    at += taken;
    if (!(taken > rounding)) break;
  }
  return at;
}

}  // namespace

Stability::Stability(const PoseProgram& program) {
  const int coordinates = program.layout().coordinates;
  turning_.resize(coordinates);
  direction_.resize(coordinates);
  reflection_.resize(coordinates);
  hessian_.resize(coordinates, coordinates);
  convexity_.resize(program.variable_count());
  touching_.reserve(program.spec().contacts.size());
  sticking_.reserve(program.spec().contacts.size());
  taut_.reserve(program.spec().rod->actuators.size());
}

bool Stability::leans_on_end(const PoseProgram& program, int contact) {
  return !program.spec().contacts[static_cast<std::size_t>(contact)].at_tip &&
         program.contacts()[static_cast<std::size_t>(contact)].arc_length >= 1.0 - 2.0 * knot_clearance;
}

void Stability::second_variation(PoseProgram& program, ConstVectorRef x, Eigen::MatrixXd& h) {
  const int n = program.layout().coordinates;
  // dh_e/dq is minus the second derivative of Pi plus the turning of the contact forces, all at frozen knots.
  h = -program.jacobian(x).topLeftCorner(n, n);
  for (int k = 0; k < program.layout().forces; ++k) {
    const PoseProgram::ContactState& c = program.contacts()[static_cast<std::size_t>(k)];
    if (program.spec().contacts[static_cast<std::size_t>(k)].at_tip || !(std::abs(c.force) > tolerance::force))
      continue;
    if (ends_hold_ && leans_on_end(program, k)) continue;
    // How the closest-point row changes at frozen knots.
    turning_ = program.jacobian(x).row(program.layout().first_closest + k).head(n);
    if (!program.dissipates(k)) {
      const double share = c.force / program.contact_convexity(k);
      h.noalias() += share * turning_ * turning_.transpose();
    } else {
      program.sliding_force(k, reflection_);
      h.noalias() += (1.0 / program.contact_convexity(k)) * reflection_ * turning_.transpose();
    }
  }
}

// Coordinates y = U q with K = U^T U.
void Stability::scale_to_energy(const PoseProgram& program, Eigen::MatrixXd& h) {
  const Chain& chain = program.chain();
  const int functions = chain.functions();
  for (int j = 0; j < chain.piece_count(); ++j) {
    const auto [inverse, factor] = program.sections().unit(j);
    multiply(h.middleCols(j * functions, functions), inverse, block_);
    h.middleCols(j * functions, functions) = factor * block_;
  }
  for (int j = 0; j < chain.piece_count(); ++j) {
    const auto [inverse, factor] = program.sections().unit(j);
    multiply(inverse.transpose(), h.middleRows(j * functions, functions), block_);
    h.middleRows(j * functions, functions) = factor * block_;
  }
}

void Stability::scale_to_energy(const PoseProgram& program, const Eigen::VectorXd& row,
                                Eigen::Ref<Eigen::VectorXd> out) const {
  const int functions = program.chain().functions();
  for (int j = 0; j < program.chain().piece_count(); ++j) {
    const auto [inverse, factor] = program.sections().unit(j);
    out.segment(j * functions, functions).noalias() =
        factor * (inverse.transpose() * row.segment(j * functions, functions));
  }
}

void Stability::find_held(PoseProgram& program, ConstVectorRef x) {
  touching_.clear();
  sticking_.clear();
  taut_.clear();
  for (int k = 0; k < program.layout().forces; ++k) {
    if (!(program.contacts()[static_cast<std::size_t>(k)].force > tolerance::force)) continue;
    touching_.push_back(k);
    if (program.shear_variable(k) >= 0) sticking_.push_back(program.shear_variable(k));
  }
  for (const int k : touching_) {
    if (program.layout().leans == 0) break;
    const int lean = program.layout().first_lean + k;
    if (std::abs(x[lean]) < program.upper()[lean] - tolerance::bounds) sticking_.push_back(lean);
  }
  const std::vector<Rod::Actuator>& actuators = program.spec().rod->actuators;
  for (std::size_t a = 0; a < actuators.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    if (actuators[a].by_length && variable >= 0 && actuators[a].side() * x[variable] > tolerance::force) {
      taut_.push_back(variable);
    }
  }
}

void Stability::fill_held(PoseProgram& program, ConstVectorRef x) {
  const Eigen::Index n = hessian_.rows();
  normals_.resize(n, held_count());
  Eigen::Index i = 0;
  for (const int k : touching_) {
    turning_ = program.jacobian(x).row(program.layout().first_gap + k).head(n);
    scale_to_energy(program, turning_, normals_.col(i++));
  }
  // A tangential force works along what slides, a moment along the shortening of its tendon.
  for (const std::vector<int>* variables : {&sticking_, &taut_}) {
    for (const int variable : *variables) {
      turning_ = program.jacobian(x).col(variable).head(n);
      scale_to_energy(program, turning_, normals_.col(i++));
    }
  }
}

bool Stability::drop_dependent() {
  constexpr double independent = 1e-9;
  for (std::size_t i = 0; i < taut_.size(); ++i) {
    const auto column = held_count() - static_cast<Eigen::Index>(taut_.size() - i);
    const bool beyond = column >= normals_.rows();
    if (!beyond && std::abs(qr_.matrixQR()(column, column)) > independent * normals_.col(column).norm()) continue;
    taut_.erase(taut_.begin() + static_cast<std::ptrdiff_t>(i));
    return true;
  }
  return false;
}

/// Disturbed by y the contacts keep closed, D y = 0, and their forces change along what they do, B: H y = mu y + B f.
/// With Z and W across D and B the eigenvalues are those of (W^T Z)^-1 W^T H Z. Q = [Q_1 Z] is at hand, and W = Z + Q_1
/// C makes W^T Z the unit matrix. `h`: Q^T H Q.
double Stability::slipping_margin(PoseProgram& program, ConstVectorRef x, const Eigen::MatrixXd& h) {
  const Eigen::Index n = h.rows();
  const Eigen::Index count = held_count();
  pushed_ = normals_;
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    turning_ = program.jacobian(x).col(program.force_variable(touching_[i])).head(n);
    scale_to_energy(program, turning_, pushed_.col(static_cast<Eigen::Index>(i)));
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto essential = qr_.matrixQR().col(k).tail(n - k - 1);
    pushed_.bottomRows(n - k).applyHouseholderOnTheLeft(essential, qr_.hCoeffs()[k], reflection_.data());
  }
  free_ = h.bottomRightCorner(n - count, n - count);
  if (count > 0) {
    lu_.compute(pushed_.topRows(count).transpose());
    share_ = lu_.solve(pushed_.bottomRows(n - count).transpose());
    free_.noalias() -= share_.transpose() * h.topRightCorner(count, n - count);
  }
  if (!free_.allFinite()) return -infinity;
  eigenvalues_.compute(free_, false);
  return eigenvalues_.eigenvalues().real().minCoeff();
}

double Stability::smallest_eigenvalue_of(const Eigen::MatrixXd& h) {
  if (h.rows() == 1) return h(0, 0);
  tridiagonal_.compute(h);
  diagonal_ = tridiagonal_.diagonal();
  beside_ = tridiagonal_.subDiagonal();
  return smallest_eigenvalue(diagonal_, beside_);
}

double Stability::margin(PoseProgram& program, ConstVectorRef x) {
  const int n = program.layout().coordinates;
  Eigen::MatrixXd& h = hessian_;
  second_variation(program, x, h);
  find_held(program, x);
  scale_to_energy(program, h);
  if (!h.allFinite()) return -infinity;
  const bool slips = program.has_friction();
  if (held_count() == 0 && !slips) return smallest_eigenvalue_of(h);
  do {
    fill_held(program, x);
    qr_.compute(normals_);
  } while (!taut_.empty() && drop_dependent());
  const Eigen::Index count = held_count();
  const Eigen::Index left = n - count;
  if (left <= 0) return infinity;
  // The orthogonal complement of the rows spans what the contacts leave free: Q^T H Q, one reflection after the other.
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto essential = qr_.matrixQR().col(k).tail(n - k - 1);
    h.bottomRows(n - k).applyHouseholderOnTheLeft(essential, qr_.hCoeffs()[k], reflection_.data());
    h.rightCols(n - k).applyHouseholderOnTheRight(essential, qr_.hCoeffs()[k], reflection_.data());
  }
  if (slips) return slipping_margin(program, x, h);
  free_ = h.bottomRightCorner(left, left);
  return smallest_eigenvalue_of(free_);
}

/// Inverse iteration. The shift lies off the eigenvalue by what rounding leaves of it, so that the system can be
/// solved.
void Stability::find_eigenvector(double eigenvalue) {
  const Eigen::Index count = held_count();
  const Eigen::Index left = hessian_.rows() - count;
  shifted_ = hessian_.bottomRightCorner(left, left);
  const double size = std::max(1.0, shifted_.cwiseAbs().maxCoeff());
  shifted_.diagonal().array() -= eigenvalue - 16.0 * std::numeric_limits<double>::epsilon() * size;
  lu_.compute(shifted_);
  vector_.resize(left);
  // Any start with a part along every eigenvector.
  for (Eigen::Index i = 0; i < left; ++i) vector_[i] = 1.0 + 0.3 * std::cos(1.7 * static_cast<double>(i));
  for (int iteration = 0; iteration < 4; ++iteration) {
    next_ = lu_.solve(vector_);
    vector_ = next_ / next_.norm();
  }
}

/// The eigenvector in coordinates q, with v^T K v = 1: out of what contacts leave free, then out of y = U q.
void Stability::find_direction(const PoseProgram& program) {
  const Chain& chain = program.chain();
  const Eigen::Index n = hessian_.rows();
  const Eigen::Index count = held_count();
  next_.resize(n);
  next_.head(count).setZero();
  next_.tail(n - count) = vector_;
  for (Eigen::Index k = count - 1; k >= 0; --k) {
    const auto essential = qr_.matrixQR().col(k).tail(n - k - 1);
    next_.tail(n - k).applyHouseholderOnTheLeft(essential, qr_.hCoeffs()[k], reflection_.data());
  }
  const int functions = chain.functions();
  for (int j = 0; j < chain.piece_count(); ++j) {
    const auto [inverse, factor] = program.sections().unit(j);
    direction_.segment(j * functions, functions).noalias() =
        factor * (inverse * next_.segment(j * functions, functions));
  }
}

/// (H - mu K) v = D lambda, D the rows that contacts hold: the part of Q^T H Q that the reflections left above.
void Stability::find_multipliers() {
  const Eigen::Index count = held_count();
  const Eigen::Index left = hessian_.rows() - count;
  holding_.noalias() = hessian_.topRightCorner(count, left) * vector_;
  if (count == 0) return;
  qr_.matrixQR().topLeftCorner(count, count).triangularView<Eigen::Upper>().solveInPlace(holding_);
}

/// d mu = v^T dH v - mu v^T dK v - 2 lambda^T dD^T v. All but a few terms are one product with second derivatives that
/// the program has: of the equilibrium rows along v, of the closest-point rows (sliding) and of the gaps (D).
void Stability::sum_gradient(PoseProgram& program, ConstVectorRef x, double eigenvalue, VectorRef gradient) {
  const PoseProgram::Layout& at = program.layout();
  const Chain& chain = program.chain();
  const int n = at.coordinates;
  eigenvalue_ = eigenvalue;
  by_convexity_.setZero(at.forces);
  multipliers_.head(n) = -direction_;
  gradient.setZero();
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    const int k = touching_[i];
    multipliers_[at.first_gap + k] = -2.0 * holding_[static_cast<Eigen::Index>(i)];
    if (program.spec().contacts[static_cast<std::size_t>(k)].at_tip) continue;
    const double force = program.contacts()[static_cast<std::size_t>(k)].force;
    const double convexity = program.contact_convexity(k, convexity_);
    const double slide = program.jacobian(x).row(at.first_closest + k).head(n).dot(direction_);
    multipliers_[at.first_closest + k] = 2.0 * force / convexity * slide;
    const double square = slide * slide / convexity;
    gradient[program.force_variable(k)] += square;
    by_convexity_[k] = -force * square / convexity;
    gradient += by_convexity_[k] * convexity_;
  }
  const MatrixView second = program.hessian(x, 0.0, multipliers_);
  gradient.noalias() += second.leftCols(n) * direction_;
  // Rows of tendons change with their profiles' places alone: second derivatives of the equilibrium by their moments.
  for (std::size_t i = 0; i < taut_.size(); ++i) {
    const double along = 2.0 * holding_[static_cast<Eigen::Index>(touching_.size() + i)];
    gradient.segment(at.first_move, at.slides()) += along * second.col(taut_[i]).segment(at.first_move, at.slides());
  }
  const auto first_knot = program.knots(x).data() - x.data();
  for (int j = 0; j < chain.piece_count(); ++j) {
    const double* own = direction_.data() + j * chain.functions();
    for (int l = 0; l < chain.knot_count(); ++l) {
      gradient[first_knot + l] -= program.sections().stretching(j, eigenvalue, own, l);
    }
  }
}

double Stability::margin(PoseProgram& program, ConstVectorRef x, VectorRef gradient) {
  const double eigenvalue = margin(program, x);
  multipliers_.setZero(program.row_count());
  if (!std::isfinite(eigenvalue)) {
    gradient.setZero();
    return eigenvalue;
  }
  find_eigenvector(eigenvalue);
  find_multipliers();
  find_direction(program);
  sum_gradient(program, x, eigenvalue, gradient);
  return eigenvalue;
}

double Stability::rate(const ProgramRates& rates) const {
  if (multipliers_.isZero(0.0)) return 0.0;
  return rates.slope.head(direction_.size()).dot(direction_) + by_convexity_.dot(rates.convexities) -
         eigenvalue_ * rates.energy;
}

double Stability::energy(const PoseProgram& program) const {
  const int functions = program.chain().functions();
  double sum = 0.0;
  for (int j = 0; j < program.chain().piece_count(); ++j) {
    const auto [inverse, factor] = program.sections().unit(j);
    sum += (inverse.partialPivLu().solve(direction_.segment(j * functions, functions)) / factor).squaredNorm();
  }
  return sum;
}

}  // namespace tendril
