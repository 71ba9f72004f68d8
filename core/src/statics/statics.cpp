#include "statics/statics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr int most_newton_steps = 30;
/// A Newton step may turn the rod by this much in the metric of the bending energy.
constexpr double longest_newton_step = 1.0;
constexpr double newton_residual = 1e-9;  ///< a residual above it does not count as converged; one more step follows
constexpr double newton_step = 1e-9;      ///< likewise for the last step in the metric

}  // namespace

Statics::Statics(const LoadPath& path, std::shared_ptr<const LegendreBasis> basis, std::vector<PointContact> contacts,
                 int nodes)
    : path_(path), basis_(std::move(basis)) {
  sort_contacts(contacts);
  PoseProgramSpec spec;
  spec.rod = &path.rod();
  spec.model = basis_.get();
  spec.obstacles = path.obstacles();
  for (const PointContact& c : contacts) spec.contacts.push_back(c.setup);
  spec.nodes = nodes;
  program_ = std::make_unique<PoseProgram>(spec);
  certifier_ = std::make_unique<Certifier>(spec);
  const PoseProgram::Layout& at = program_->layout();
  for (int k = 0; k < at.forces; ++k) program_->set_branch(k, Branch::touching);
  for (int i = 0; i < at.coordinates; ++i) columns_.push_back(i);
  for (int i = 0; i < at.arc_lengths; ++i) columns_.push_back(at.first_arc_length + i);
  for (int i = 0; i < at.forces; ++i) columns_.push_back(at.first_force + i);
  for (int i = 0; i < at.coordinates; ++i) rows_.push_back(i);
  for (int i = 0; i < at.arc_lengths; ++i) rows_.push_back(at.first_closest + i);
  for (int i = 0; i < at.forces; ++i) rows_.push_back(at.first_gap + i);
  size_ = static_cast<int>(columns_.size());
  x_.setZero(program_->variable_count());
  residual_.resize(size_);
  jacobian_.resize(size_, size_ + 1);
}

Eigen::VectorXd Statics::full(const Eigen::VectorXd& y) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(program_->variable_count());
  for (int i = 0; i < size_; ++i) x[columns_[static_cast<std::size_t>(i)]] = y[i];
  return x;
}

void Statics::place(const Eigen::VectorXd& z) {
  x_ = full(z);
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    if (const int variable = program_->moment_variable(a); variable >= 0) {
      x_[variable] = path_.moment(static_cast<std::size_t>(a), z[size_]);
    }
  }
}

void Statics::set_load(double load) {
  if (load_ != load) program_->set_loads(path_.loads(load_ = load));
}

PoseProgram& Statics::at(const Eigen::VectorXd& z) {
  place(z);
  set_load(z[size_]);
  program_->constraints(x_);
  return *program_;
}

void Statics::evaluate(const Eigen::VectorXd& z) {
  place(z);
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(program_->row_count());
  if (path_.loads_grow()) {
    // Rows are affine in the dead loads: the difference between all and none of them is their rate.
    set_load(1.0);
    rate.head(coordinates()) = program_->constraints(x_).head(coordinates());
    set_load(0.0);
    rate.head(coordinates()) -= program_->constraints(x_).head(coordinates());
  }
  set_load(z[size_]);
  const MatrixView full_jacobian = program_->jacobian(x_);
  const VectorView rows = program_->constraints(x_);
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    const int variable = program_->moment_variable(a);
    if (variable >= 0) rate += path_.moment_rate(static_cast<std::size_t>(a)) * full_jacobian.col(variable);
  }
  for (int c = 0; c < size_; ++c) {
    for (int r = 0; r < size_; ++r) {
      jacobian_(r, c) = full_jacobian(rows_[static_cast<std::size_t>(r)], columns_[static_cast<std::size_t>(c)]);
    }
  }
  const int first_gap = program_->layout().first_gap;
  for (int k = 0; k < contact_count(); ++k) rate[first_gap + k] += path_.distance_rate(contact(k).obstacle);
  for (int r = 0; r < size_; ++r) {
    residual_[r] = rows[rows_[static_cast<std::size_t>(r)]];
    jacobian_(r, size_) = rate[rows_[static_cast<std::size_t>(r)]];
  }
}

Eigen::VectorXd Statics::point(const State& state) const {
  std::vector<PointContact> contacts = state.contacts;
  sort_contacts(contacts);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(size_ + 1);
  for (int k = 0; k < contact_count(); ++k) {
    const PointContact& c = contacts[static_cast<std::size_t>(k)];
    if (!contact(k).at_tip) z[arc_length_index(k)] = c.s;
    z[force_index(k)] = c.force;
  }
  const Chain& chain = program_->chain();
  const std::span<const double> knots(z.data() + coordinates(), static_cast<std::size_t>(chain.knot_count()));
  z.head(coordinates()) = chain.coordinates_of(state.curvature, knots);
  z[size_] = state.load;
  return z;
}

Curvature Statics::curvature(const Eigen::VectorXd& z, const Eigen::VectorXd& direction) {
  return curvature_of(basis_, at(z).backbone(), direction.head(coordinates()));
}

State Statics::state(const Eigen::VectorXd& z) {
  State s;
  s.curvature = curvature(z, z);
  for (int k = 0; k < contact_count(); ++k) {
    const int index = arc_length_index(k);
    s.contacts.push_back({contact(k), index < 0 ? 1.0 : z[index], z[force_index(k)]});
  }
  s.load = z[size_];
  return s;
}

std::pair<double, double> Statics::bounds(const Eigen::VectorXd& z, int k) const {
  const std::vector<double>& knots = program_->chain().fixed_knots();
  const auto stretch = static_cast<std::size_t>(contact(k).region);
  double low = knots[stretch];
  double high = knots[stretch + 1];
  if (k > 0) low = std::max(low, z[arc_length_index(k - 1)]);
  if (k + 1 < program_->layout().arc_lengths) high = std::min(high, z[arc_length_index(k + 1)]);
  return {low, high};
}

Eigen::VectorXd Statics::metric(const Eigen::VectorXd& z, const Eigen::VectorXd& a) const {
  const Chain& chain = program_->chain();
  const std::span<const double> knots(z.data() + coordinates(), static_cast<std::size_t>(chain.knot_count()));
  const int n = chain.functions();
  Eigen::VectorXd m = Eigen::VectorXd::Zero(size_ + 1);
  for (int j = 0; j < chain.piece_count(); ++j) {
    m.segment(j * n, n) = chain.table().stiffness * a.segment(j * n, n) / chain.length(j, knots);
  }
  m[size_] = a[size_];
  return m;
}

Statics::NewtonResult Statics::solve(Eigen::VectorXd& z, const Eigen::VectorXd& row, double value, double clearance) {
  NewtonResult result;
  Eigen::MatrixXd system(size_ + 1, size_ + 1);
  Eigen::VectorXd right(size_ + 1);
  bool last = false;
  for (int step = 0; step < most_newton_steps; ++step) {
    evaluate(z);
    result.residual = residual_.cwiseAbs().maxCoeff();
    if (!residual_.allFinite() || !jacobian_.allFinite()) return result;
    system.topRows(size_) = jacobian_;
    system.row(size_) = row;
    right.head(size_) = -residual_;
    right[size_] = value - row.dot(z);
    const Eigen::VectorXd dz = system.partialPivLu().solve(right);
    if (!dz.allFinite()) return result;
    double factor = 1.0;
    const double moved = std::sqrt(std::max(0.0, metric(z, dz).dot(dz)));
    if (moved > longest_newton_step) factor = longest_newton_step / moved;
    for (int k = 0; k < program_->layout().arc_lengths; ++k) {
      const int i = arc_length_index(k);
      const auto [low, high] = bounds(z, k);
      const double room = dz[i] > 0.0 ? high - z[i] : z[i] - low;
      if (std::abs(dz[i]) * factor < 0.9 * room) continue;
      if (room <= clearance) {
        result.leaning = k;
        result.upward = dz[i] > 0.0;
        return result;
      }
      // Two thirds of the room at a time: the walk to the end of a stretch is short, and none is left by accident.
      factor = 0.667 * room / std::abs(dz[i]);
    }
    z += factor * dz;
    if (factor == 1.0 && last) {
      evaluate(z);
      result.residual = residual_.cwiseAbs().maxCoeff();
      result.converged = result.residual <= newton_residual;
      return result;
    }
    last = factor == 1.0 && moved <= newton_step && result.residual <= newton_residual;
  }
  return result;
}

Statics::NewtonResult Statics::solve_at_load(Eigen::VectorXd& z, double load, double clearance) {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(size_ + 1);
  row[size_] = 1.0;
  z[size_] = load;
  return solve(z, row, load, clearance);
}

Eigen::VectorXd Statics::tangent(const Eigen::VectorXd& z) {
  evaluate(z);
  Eigen::VectorXd t(size_ + 1);
  t.head(size_) = jacobian_.leftCols(size_).partialPivLu().solve(-jacobian_.col(size_));
  t[size_] = 1.0;
  return t / std::sqrt(metric(z, t).dot(t));
}

Eigen::VectorXd Statics::weakest_direction(const Eigen::VectorXd& z) {
  evaluate(z);
  // Inverse iteration on A^T A.
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(jacobian_.leftCols(size_));
  Eigen::VectorXd v = Eigen::VectorXd::Zero(size_ + 1);
  v.head(coordinates()).setOnes();
  v /= std::sqrt(metric(z, v).dot(v));
  for (int i = 0; i < 6; ++i) {
    v.head(size_) = lu.solve(lu.transpose().solve(v.head(size_)).eval()).eval();
    v /= std::sqrt(metric(z, v).dot(v));
    if (!v.allFinite()) break;
  }
  return v;
}

/// Newton's method on F = 0 and g = 0, g the corner of the bordered matrix's inverse: zero where dF/dy is singular.
/// Its gradient is -w^T d2F v, from the program's exact Hessian with w as multipliers (Govaerts, Numerical Methods for
/// Bifurcations of Dynamical Equilibria, 2000, chapter 4).
bool Statics::solve_fold(Eigen::VectorXd& z, Eigen::VectorXd& null_vector) {
  Eigen::VectorXd b;
  Eigen::VectorXd c;
  {
    evaluate(z);
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(jacobian_.leftCols(size_));
    c = weakest_direction(z).head(size_);
    if (!c.allFinite()) return false;
    c.normalize();
    b = lu.transpose().solve(c);
    if (!b.allFinite()) return false;
    b.normalize();
  }
  Eigen::MatrixXd bordered(size_ + 1, size_ + 1);
  Eigen::MatrixXd system(size_ + 1, size_ + 1);
  Eigen::VectorXd right(size_ + 1);
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size_ + 1, size_);
  for (int step = 0; step < most_newton_steps; ++step) {
    evaluate(z);
    if (!residual_.allFinite() || !jacobian_.allFinite()) return false;
    bordered << jacobian_.leftCols(size_), b, c.transpose(), 0.0;
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(bordered);
    const Eigen::VectorXd v = lu.solve(unit);
    const Eigen::VectorXd w = lu.transpose().solve(unit);
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(program_->row_count());
    for (int r = 0; r < size_; ++r) multipliers[rows_[static_cast<std::size_t>(r)]] = w[r];
    const Eigen::VectorXd turning = program_->hessian(x_, 0.0, multipliers) * full(v);
    double rate = 0.0;
    if (path_.loads_grow()) {
      const auto weak = [&](double load) {
        set_load(load);
        return multipliers.dot(program_->jacobian(x_) * full(v));
      };
      rate = weak(1.0) - weak(0.0);
    }
    system.topRows(size_) = jacobian_;
    for (int i = 0; i < size_; ++i) system(size_, i) = -turning[columns_[static_cast<std::size_t>(i)]];
    system(size_, size_) = -rate;
    right.head(size_) = -residual_;
    right[size_] = -v[size_];
    Eigen::VectorXd dz = system.partialPivLu().solve(right);
    if (!dz.allFinite()) return false;
    const double moved = std::sqrt(std::max(0.0, metric(z, dz).dot(dz)));
    if (moved > 0.5) dz *= 0.5 / moved;
    z += dz;
    for (int k = 0; k < program_->layout().arc_lengths; ++k) {
      const auto [low, high] = bounds(z, k);
      if (!(z[arc_length_index(k)] > low && z[arc_length_index(k)] < high)) return false;
    }
    if (moved <= newton_step && right.head(size_).cwiseAbs().maxCoeff() <= newton_residual) {
      null_vector = Eigen::VectorXd::Zero(size_ + 1);
      null_vector.head(size_) = v.head(size_);
      null_vector /= std::sqrt(metric(z, null_vector).dot(null_vector));
      return true;
    }
  }
  return false;
}

Certifier& Statics::certifier(const Eigen::VectorXd& z) {
  at(z);
  if (certified_load_ != load_) certifier_->set_loads(path_.loads(certified_load_ = load_));
  return *certifier_;
}

double Statics::margin(const Eigen::VectorXd& z) { return certifier(z).stability(x_); }
double Statics::moment_balance(const Eigen::VectorXd& z) { return certifier(z).moment_balance(x_); }
double Statics::convexity(const Eigen::VectorXd& z, int k) { return certifier(z).contact_convexity(x_, k); }
Certificate Statics::certify(const Eigen::VectorXd& z) { return certifier(z).certify(*program_, x_); }

double Statics::tip_slope(const Eigen::VectorXd& z) {
  double slope = -1.0;
  const PoseProgram& program = at(z);
  for (int k = 0; k < contact_count(); ++k) {
    const PoseProgram::ContactState& c = program.contacts()[static_cast<std::size_t>(k)];
    if (contact(k).at_tip) slope = std::max(slope, dot(c.tangent, c.surface.normal));
  }
  return slope;
}

std::vector<Certifier::Approach> Statics::penetrations(const Eigen::VectorXd& z) {
  // A tenth of the depth that the certificate allows: what is found is left outside by a clear margin.
  return approaches(z, -0.1 * tolerance::penetration);
}

std::vector<Certifier::Approach> Statics::approaches(const Eigen::VectorXd& z, double level) {
  return certifier(z).approaches(x_, level);
}

}  // namespace tendril
