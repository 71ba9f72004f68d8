// z solves F(z, u, p) = 0, z the shape, places and forces of contacts, u the moments that are held. A number p moves z
// by -F_z^-1 F_p, and the tip P by t = P_z dz/dp + P_p. With multipliers m = F_z^-T P_z and v = (dz/dp, du/dp) the
// gradient of t is that of  v . (P - m . F)' - m . F_p  at constant m and v: second derivatives that the program has.

#include "program/tip_deviations.hpp"

#include <limits>

namespace tendril {

struct TipDeviations::Other {
  Other(const Rod& changed, PoseProgramSpec spec) : rod(changed), program(with_rod(std::move(spec))) {}
  PoseProgramSpec with_rod(PoseProgramSpec spec) const {
    spec.rod = &rod;
    return spec;
  }
  Rod rod;
  PoseProgram program;
};

namespace {

/// Of what second derivatives are learned from; farther off the squares' own lead there better.
constexpr double learned_within = 0.05;

/// A coordinate of the tip as a term: along the target, which can be another one at any time.
class TipAlongTarget : public ObjectiveBase<TipAlongTarget> {
 public:
  Reads reads() const override { return {.tip_position = true, .target = true}; }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.smooth(x.target.position.x * x.tip.x + x.target.position.y * x.tip.y);
  }
};

PoseProgramSpec with_term(PoseProgramSpec spec, const ObjectiveTerm& term) {
  spec.terms = {{&term, 1.0, "tip"}};
  spec.term_units = {};
  return spec;
}

}  // namespace

TipDeviations::TipDeviations(const PoseProgramSpec& spec)
    : uncertain_(spec.uncertainties),
      tip_(std::make_unique<TipAlongTarget>()),
      program_(with_term(Equations::alone(spec), *tip_)) {
  const PoseProgramSpec bare = Equations::alone(spec);
  for (const UncertainNumber& number : uncertain_->numbers) {
    others_.push_back(number.rod ? std::make_unique<Other>(*number.rod, bare) : nullptr);
    moment_variables_.push_back(number.actuator < 0 ? -1 : program_.moment_variable(number.actuator));
    if (number.moves && !motion_) motion_ = std::make_unique<MotionRates>(bare);
  }
  const int variables = program_.variable_count();
  const int deviations = uncertain_->deviations();
  values_.setZero(2 * deviations);
  pulled_.setZero(variables);
  multipliers_.setZero(program_.row_count());
  along_.setZero(variables, deviations);
  tip_rows_.setZero(variables, 2);
  rows_.setZero(2 * deviations, variables);
  bent_.setZero(variables, deviations);
  rates_.slope.setZero(variables);
  rates_.rows.setZero(program_.row_count());
  start();
}

TipDeviations::~TipDeviations() = default;

void TipDeviations::set_branch(int contact, Branch branch) {
  if (program_.branch(contact) == branch) return;
  program_.set_branch(contact, branch);
  start();
}

void TipDeviations::start() {
  equations_.emplace(Equations::of_contacts(program_));
  adjoint_.setZero(equations_->size());
  right_.setZero(equations_->size(), along_.cols());
  x_.setConstant(program_.variable_count(), std::numeric_limits<double>::quiet_NaN());
  learned_.assign(static_cast<std::size_t>(values_.size()), LearnedHessian(program_.variable_count(), learned_within));
}

void TipDeviations::set_axis(int axis) {
  Target target;
  target.has_position = true;
  target.position = axis == 0 ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0};
  program_.set_target(target);
}

void TipDeviations::find_rates(int number, bool slopes) {
  const auto j = static_cast<std::size_t>(number);
  const UncertainNumber& changing = uncertain_->numbers[j];
  rates_.rows.setZero();
  rates_.slope.setZero();
  if (changing.moves) motion_->add(changing.motion, rates_);
  if (!others_[j]) return;
  PoseProgram& other = others_[j]->program;
  const double factor = 1.0 / changing.step;
  rates_.rows += factor * (other.constraints(x_) - program_.constraints(x_));
  if (!slopes) return;
  rates_.slope.noalias() += factor * (other.jacobian(x_).transpose() * multipliers_);
  rates_.slope.noalias() -= factor * (program_.jacobian(x_).transpose() * multipliers_);
}

const Eigen::VectorXd& TipDeviations::values_at(ConstVectorRef x) {
  if (x == x_) return values_;
  x_ = x;
  solved_ = equations_->evaluate(x_);
  differentiated_ = false;
  if (solved_) {
    solve();
  } else {
    values_.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return values_;
}

void TipDeviations::solve() {
  equations_->factor();
  const PoseProgram::Layout& at = program_.layout();
  Vec2 tip;
  for (const int axis : {0, 1}) {
    set_axis(axis);
    (axis == 0 ? tip.x : tip.y) = program_.cost(x_);
    tip_rows_.col(axis) = program_.gradient(x_);
  }
  if (motion_) motion_->move(x_);
  const MatrixView jacobian = program_.jacobian(x_);
  along_.setZero();
  right_.setZero();
  values_.setZero();
  for (std::size_t j = 0; j < others_.size(); ++j) {
    const UncertainNumber& number = uncertain_->numbers[j];
    find_rates(static_cast<int>(j), false);
    const Vec2 moved = number.motion.base.at(tip) + number.length * tip;
    for (Eigen::Index m = 0; m < along_.cols(); ++m) {
      const double share = uncertain_->shares(m, static_cast<Eigen::Index>(j));
      for (int r = 0; r < equations_->size(); ++r) right_(r, m) -= share * rates_.rows[equations_->row(r)];
      const double unit = number.length - number.stiffness;
      along_.col(m).segment(at.first_moment, at.moments) += share * unit * x_.segment(at.first_moment, at.moments);
      const int v = moment_variables_[j];
      if (v >= 0) along_(v, m) += share * number.held(x_[v]).value;
      values_[2 * m] += share * moved.x;
      values_[2 * m + 1] += share * moved.y;
    }
  }
  for (Eigen::Index m = 0; m < along_.cols(); ++m) {
    for (int v = at.first_moment; v < at.first_moment + at.moments; ++v) {
      for (int r = 0; r < equations_->size() && along_(v, m) != 0.0; ++r) {
        right_(r, m) -= jacobian(equations_->row(r), v) * along_(v, m);
      }
    }
    if (equations_->size() > 0) adjoint_ = equations_->factors().solve(right_.col(m));
    for (int r = 0; r < equations_->size(); ++r) along_(equations_->unknown(r), m) = adjoint_[r];
    values_[2 * m] += tip_rows_.col(0).dot(along_.col(m));
    values_[2 * m + 1] += tip_rows_.col(1).dot(along_.col(m));
  }
}

const Eigen::MatrixXd& TipDeviations::rows() {
  if (differentiated_) return rows_;
  differentiated_ = true;
  if (!solved_) {
    rows_.setConstant(std::numeric_limits<double>::quiet_NaN());
    return rows_;
  }
  const PoseProgram::Layout& at = program_.layout();
  for (const int axis : {0, 1}) {
    for (int r = 0; r < equations_->size(); ++r) adjoint_[r] = tip_rows_(equations_->unknown(r), axis);
    // P K = L U, so that K^T = U^T L^T P, one after the other in place: Eigen's own solution copies the matrix.
    const Eigen::PartialPivLU<Eigen::MatrixXd>& lu = equations_->factors();
    multipliers_.setZero();
    if (equations_->size() > 0) {
      lu.matrixLU().triangularView<Eigen::Upper>().transpose().solveInPlace(adjoint_);
      lu.matrixLU().triangularView<Eigen::UnitLower>().transpose().solveInPlace(adjoint_);
    }
    for (int r = 0; r < equations_->size(); ++r) {
      multipliers_[equations_->row(r)] = -adjoint_[lu.permutationP().indices()[r]];
    }
    set_axis(axis);
    bent_.noalias() = program_.hessian(x_, 1.0, multipliers_) * along_;
    // What a unit of a moment does to the tip.
    pulled_ = tip_rows_.col(axis);
    pulled_.noalias() += program_.jacobian(x_).transpose() * multipliers_;
    if (motion_) motion_->weigh(multipliers_);
    for (std::size_t j = 0; j < others_.size(); ++j) {
      const UncertainNumber& number = uncertain_->numbers[j];
      find_rates(static_cast<int>(j), true);
      const double unit = number.length - number.stiffness;
      rates_.slope.segment(at.first_moment, at.moments) += unit * pulled_.segment(at.first_moment, at.moments);
      const int v = moment_variables_[j];
      if (v >= 0) rates_.slope[v] += pulled_[v] * number.held(x_[v]).slope;
      const Motion& base = number.motion.base;
      rates_.slope += (base.stretch + number.length) * tip_rows_.col(axis);
      rates_.slope += (axis == 0 ? -base.turn : base.turn) * tip_rows_.col(1 - axis);
      for (Eigen::Index m = 0; m < bent_.cols(); ++m) {
        bent_.col(m) += uncertain_->shares(m, static_cast<Eigen::Index>(j)) * rates_.slope;
      }
    }
    for (Eigen::Index m = 0; m < bent_.cols(); ++m) rows_.row(2 * m + axis) = bent_.col(m).transpose();
  }
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    pulled_ = rows_.row(static_cast<Eigen::Index>(i)).transpose();
    learned_[i].learn(x_, pulled_);
  }
  return rows_;
}

void TipDeviations::add_second(ConstVectorRef slopes, Eigen::MatrixXd& hessian) const {
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    const double slope = slopes[static_cast<Eigen::Index>(i)];
    if (slope != 0.0) hessian += slope * learned_[i].matrix();
  }
}

}  // namespace tendril
