#include "statics/statics.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "nlp/newton.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr int most_newton_steps = 30;
/// A Newton step may turn the rod by this much in the metric of the bending energy.
constexpr double longest_newton_step = 1.0;
constexpr double newton_small = 1e-9;  ///< residual, and step in the metric, after which one more step follows

std::vector<int> actuators_of(const std::vector<TautTendon>& tendons) {
  std::vector<int> actuators;
  actuators.reserve(tendons.size());
  for (const TautTendon& t : tendons) actuators.push_back(t.actuator);
  return actuators;
}

PoseProgramSpec spec_of(const LoadPath& path, const LegendreBasis& basis, std::vector<PointContact> contacts,
                        int nodes) {
  sort_contacts(contacts);
  PoseProgramSpec spec;
  spec.rod = &path.rod();
  spec.model = &basis;
  spec.obstacles = path.obstacles();
  for (const PointContact& c : contacts) spec.contacts.push_back(c.setup);
  spec.nodes = nodes;
  return spec;
}

}  // namespace

Statics::Statics(const LoadPath& path, std::shared_ptr<const LegendreBasis> basis, std::vector<PointContact> contacts,
                 int nodes, const std::vector<TautTendon>& tendons)
    : path_(path),
      basis_(std::move(basis)),
      program_(spec_of(path, *basis_, contacts, nodes)),
      taut_(actuators_of(tendons)),
      certifier_(program_.spec()),
      equations_(Equations::of_contacts(program_, taut_)) {
  for (int k = 0; k < contact_count(); ++k) program_.set_branch(k, Branch::touching);
  int shear = coordinates() + program_.layout().arc_lengths + hold_count();
  for (int k = 0; k < contact_count(); ++k) shear_indices_.push_back(contact(k).sticks ? shear++ : -1);
  if (program_.layout().shears > 0) {
    sort_contacts(contacts);
    for (const PointContact& c : contacts) anchors_.push_back(c.anchor);
  }
  x_.setZero(program_.variable_count());
  rate_.setZero(size());
}

Eigen::VectorXd Statics::full(const Eigen::VectorXd& y) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(program_.variable_count());
  for (int i = 0; i < size(); ++i) x[equations_.unknown(i)] = y[i];
  return x;
}

void Statics::place(const Eigen::VectorXd& z) {
  x_ = full(z);
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    // The moment of a tendon that is held by its length is an unknown, or 0.
    if (path_.holds_length(static_cast<std::size_t>(a))) continue;
    if (const int variable = program_.moment_variable(a); variable >= 0) {
      x_[variable] = path_.moment(static_cast<std::size_t>(a), z[size()]);
    }
  }
  for (int l = 0; l < program_.layout().moves; ++l) {
    x_[program_.layout().first_move + l] = path_.move(static_cast<std::size_t>(l), z[size()]);
  }
}

Eigen::VectorXd Statics::given_rates() const {
  Eigen::VectorXd rates = Eigen::VectorXd::Zero(program_.variable_count());
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    const int variable = program_.moment_variable(a);
    if (variable < 0 || path_.holds_length(static_cast<std::size_t>(a))) continue;
    rates[variable] = path_.held_rate(static_cast<std::size_t>(a));
  }
  for (int l = 0; l < program_.layout().moves; ++l) {
    rates[program_.layout().first_move + l] = path_.move_rate(static_cast<std::size_t>(l));
  }
  return rates;
}

std::span<const double> Statics::knots(const Eigen::VectorXd& z) {
  place(z);
  return program_.knots(x_);
}

Loads Statics::loads(double load) const {
  Loads all = path_.loads(load);
  all.anchors = anchors_;
  return all;
}

void Statics::set_load(double load) {
  if (load_ != load) program_.set_loads(loads(load_ = load));
}

void Statics::anchor(const Eigen::VectorXd& z) {
  if (anchors_.empty()) return;
  at(z);
  for (int k = 0; k < contact_count(); ++k) {
    if (contact(k).sticks) anchors_[static_cast<std::size_t>(k)] = program_.anchor(k);
  }
  load_ = certified_load_ = std::nan("");
}

double Statics::sliding(const Eigen::VectorXd& z, const Eigen::VectorXd& direction, int k) {
  evaluate(z);
  Eigen::VectorXd row(program_.variable_count());
  program_.sliding_row(k, row);
  return row.dot(full(direction) + direction[size()] * given_rates());
}

std::pair<int, double> Statics::slides_with_friction(const Eigen::VectorXd& z) {
  std::pair<int, double> worst{-1, 0.0};
  const Eigen::VectorXd along = tangent(z);
  for (int k = 0; k < contact_count(); ++k) {
    if (contact(k).lean == 0.0) continue;
    const double with = sliding(z, along, k) * (contact(k).lean < 0.0 ? -1.0 : 1.0);
    if (with > worst.second) worst = {k, with};
  }
  return worst;
}

PoseProgram& Statics::at(const Eigen::VectorXd& z) {
  place(z);
  set_load(z[size()]);
  program_.constraints(x_);
  return program_;
}

bool Statics::evaluate(const Eigen::VectorXd& z) {
  place(z);
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(program_.row_count());
  if (path_.loads_grow()) {
    // Rows are affine in the dead loads: the difference between all and none of them is their rate.
    set_load(1.0);
    rate.head(coordinates()) = program_.constraints(x_).head(coordinates());
    set_load(0.0);
    rate.head(coordinates()) -= program_.constraints(x_).head(coordinates());
  }
  set_load(z[size()]);
  const bool finite = equations_.evaluate(x_);
  rate += program_.jacobian(x_) * given_rates();
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    if (!path_.holds_length(static_cast<std::size_t>(a))) continue;
    rate[program_.shortening_row(a)] -= path_.held_rate(static_cast<std::size_t>(a));
  }
  const int first_gap = program_.layout().first_gap;
  for (int k = 0; k < contact_count(); ++k) rate[first_gap + k] += path_.distance_rate(contact(k).obstacle);
  for (int r = 0; r < size(); ++r) rate_[r] = rate[equations_.row(r)];
  return finite && rate_.allFinite();
}

void Statics::fill(Eigen::MatrixXd& system) const {
  system.resize(size() + 1, size() + 1);
  system.topLeftCorner(size(), size()) = equations_.jacobian();
  system.topRightCorner(size(), 1) = rate_;
}

Eigen::VectorXd Statics::point(const State& state) {
  std::vector<PointContact> contacts = state.contacts;
  sort_contacts(contacts);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(size() + 1);
  for (int k = 0; k < contact_count(); ++k) {
    const PointContact& c = contacts[static_cast<std::size_t>(k)];
    if (!contact(k).at_tip) z[arc_length_index(k)] = c.s;
    z[force_index(k)] = c.force;
    if (shear_index(k) >= 0) z[shear_index(k)] = c.shear;
  }
  for (std::size_t i = 0; i < std::min(taut_.size(), state.tendons.size()); ++i) {
    z[force_index(contact_count() + static_cast<int>(i))] = state.tendons[i].moment;
  }
  z[size()] = state.load;
  z.head(coordinates()) = program_.chain().coordinates_of(state.curvature, knots(z), state.curvature.stretch);
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
    PointContact& c = s.contacts.emplace_back(PointContact{contact(k), index < 0 ? 1.0 : z[index], z[force_index(k)]});
    if (shear_index(k) < 0) continue;
    c.shear = z[shear_index(k)];
    c.anchor = anchors_[static_cast<std::size_t>(k)];
  }
  for (int k = contact_count(); k < hold_count(); ++k) {
    s.tendons.push_back({taut_[static_cast<std::size_t>(k - contact_count())], z[force_index(k)]});
  }
  s.load = z[size()];
  return s;
}

std::pair<double, double> Statics::bounds(const Eigen::VectorXd& z, int k) const {
  const std::vector<double>& knots = program_.chain().fixed_knots();
  const auto stretch = static_cast<std::size_t>(contact(k).region);
  double low =
      stretch == 0 && path_.rod().draws() ? path_.move(path_.rod().moves.size() - 1, z[size()]) : knots[stretch];
  double high = knots[stretch + 1];
  if (k > 0) low = std::max(low, z[arc_length_index(k - 1)]);
  if (k + 1 < program_.layout().arc_lengths) high = std::min(high, z[arc_length_index(k + 1)]);
  return {low, high};
}

double Statics::length(const Eigen::VectorXd& z, const Eigen::VectorXd& a) {
  return std::sqrt(std::max(0.0, metric(z, a).dot(a)));
}

Eigen::VectorXd Statics::metric(const Eigen::VectorXd& z, const Eigen::VectorXd& a) {
  const Chain& chain = program_.chain();
  const std::span<const double> knots = this->knots(z);
  const int n = chain.functions();
  Eigen::VectorXd m = Eigen::VectorXd::Zero(size() + 1);
  for (int j = 0; j < chain.piece_count(); ++j) {
    m.segment(j * n, n) = chain.table().stiffness * a.segment(j * n, n) / chain.length(j, knots);
  }
  m[size()] = path_.weight() * a[size()];
  return m;
}

Statics::NewtonResult Statics::solve(Eigen::VectorXd& z, const Eigen::VectorXd& row, double value, double clearance) {
  NewtonResult result;
  Eigen::MatrixXd system;
  Eigen::VectorXd right(size() + 1);
  const auto correct = [&](const Eigen::VectorXd& at, Eigen::VectorXd& dz) {
    const bool finite = evaluate(at);
    result.residual = equations_.residual().cwiseAbs().maxCoeff();
    if (!finite) return infinity;
    fill(system);
    system.row(size()) = row;
    right << -equations_.residual(), value - row.dot(at);
    dz = system.partialPivLu().solve(right);
    return dz.allFinite() ? std::max(length(at, dz), result.residual) : infinity;
  };
  const auto share = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& dz, double /*size*/) {
    double factor = std::min(1.0, longest_newton_step / length(at, dz));
    for (int k = 0; k < program_.layout().arc_lengths; ++k) {
      const int i = arc_length_index(k);
      const auto [low, high] = bounds(at, k);
      const double room = dz[i] > 0.0 ? high - at[i] : at[i] - low;
      if (std::abs(dz[i]) * factor < 0.9 * room) continue;
      if (room <= clearance) {
        result.leaning = k;
        result.upward = dz[i] > 0.0;
        return 0.0;
      }
      // Two thirds of the room at a time: the walk to the end of a stretch is short, and none is left by accident.
      factor = 0.667 * room / std::abs(dz[i]);
    }
    return factor;
  };
  Eigen::VectorXd step;
  if (!newton(z, step, most_newton_steps, newton_small, correct, share).converged) return result;
  evaluate(z);
  result.residual = equations_.residual().cwiseAbs().maxCoeff();
  result.converged = result.residual <= newton_small;
  return result;
}

Statics::NewtonResult Statics::solve_at_load(Eigen::VectorXd& z, double load, double clearance) {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(size() + 1);
  row[size()] = 1.0;
  z[size()] = load;
  return solve(z, row, load, clearance);
}

Eigen::VectorXd Statics::tangent(const Eigen::VectorXd& z) {
  evaluate(z);
  Eigen::VectorXd t(size() + 1);
  t << equations_.factor().solve(-rate_), 1.0;
  return t / length(z, t);
}

Eigen::VectorXd Statics::weakest_direction(const Eigen::VectorXd& z) {
  evaluate(z);
  // Inverse iteration on A^T A.
  const Eigen::PartialPivLU<Eigen::MatrixXd>& lu = equations_.factor();
  Eigen::VectorXd v = Eigen::VectorXd::Zero(size() + 1);
  v.head(coordinates()).setOnes();
  v /= length(z, v);
  for (int i = 0; i < 6; ++i) {
    v.head(size()) = lu.solve(lu.transpose().solve(v.head(size())).eval()).eval();
    v /= length(z, v);
    if (!v.allFinite()) break;
  }
  return v;
}

/// Newton's method on F = 0 and g = 0, g the corner of the bordered matrix's inverse: zero where dF/dy is singular.
/// Its gradient is -w^T d2F v, from the program's exact Hessian with w as multipliers (Govaerts, Numerical Methods for
/// Bifurcations of Dynamical Equilibria, 2000, chapter 4).
bool Statics::solve_fold(Eigen::VectorXd& z, Eigen::VectorXd& null_vector) {
  const Eigen::VectorXd c = weakest_direction(z).head(size()).normalized();
  const Eigen::VectorXd b = equations_.factors().transpose().solve(c).normalized();
  if (!c.allFinite() || !b.allFinite()) return false;
  Eigen::MatrixXd bordered(size() + 1, size() + 1);
  Eigen::MatrixXd system;
  Eigen::VectorXd right(size() + 1);
  Eigen::VectorXd v;
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size() + 1, size());
  const auto correct = [&](const Eigen::VectorXd& at, Eigen::VectorXd& dz) {
    if (!evaluate(at)) return infinity;
    bordered << equations_.jacobian(), b, c.transpose(), 0.0;
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(bordered);
    v = lu.solve(unit);
    const Eigen::VectorXd w = lu.transpose().solve(unit);
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(program_.row_count());
    for (int r = 0; r < size(); ++r) multipliers[equations_.row(r)] = w[r];
    const Eigen::VectorXd turning = program_.hessian(x_, 0.0, multipliers) * full(v);
    double rate = turning.dot(given_rates());
    if (path_.loads_grow()) {
      const auto weak = [&](double load) {
        set_load(load);
        return multipliers.dot(program_.jacobian(x_) * full(v));
      };
      rate += weak(1.0) - weak(0.0);
    }
    fill(system);
    for (int i = 0; i < size(); ++i) system(size(), i) = -turning[equations_.unknown(i)];
    system(size(), size()) = -rate;
    right << -equations_.residual(), -v[size()];
    dz = system.partialPivLu().solve(right);
    return dz.allFinite() ? std::max(length(at, dz), right.head(size()).cwiseAbs().maxCoeff()) : infinity;
  };
  const auto share = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& dz, double /*size*/) {
    const double factor = std::min(1.0, 0.5 / length(at, dz));
    const Eigen::VectorXd moved = at + factor * dz;
    for (int k = 0; k < program_.layout().arc_lengths; ++k) {
      const auto [low, high] = bounds(moved, k);
      if (!(moved[arc_length_index(k)] > low && moved[arc_length_index(k)] < high)) return 0.0;
    }
    return factor;
  };
  Eigen::VectorXd step;
  if (!newton(z, step, most_newton_steps, newton_small, correct, share).converged) return false;
  null_vector = v;
  null_vector[size()] = 0.0;
  null_vector /= length(z, null_vector);
  return true;
}

Certifier& Statics::certifier(const Eigen::VectorXd& z) {
  at(z);
  if (certified_load_ != load_) certifier_.set_loads(loads(certified_load_ = load_));
  return certifier_;
}

double Statics::margin(const Eigen::VectorXd& z) { return certifier(z).stability(x_); }
double Statics::moment_balance(const Eigen::VectorXd& z) { return certifier(z).moment_balance(x_); }
double Statics::convexity(const Eigen::VectorXd& z, int k) { return certifier(z).contact_convexity(x_, k); }
Certificate Statics::certify(const Eigen::VectorXd& z) { return certifier(z).certify(program_, x_); }

double Statics::hold_force(const Eigen::VectorXd& z, int k) const {
  const double force = z[force_index(k)];
  if (k < contact_count()) return force;
  const auto a = static_cast<std::size_t>(taut_[static_cast<std::size_t>(k - contact_count())]);
  return path_.rod().actuators[a].side() * force;
}

double Statics::slack(const Eigen::VectorXd& z, int actuator) {
  if (!path_.holds_length(static_cast<std::size_t>(actuator))) return infinity;
  if (std::find(taut_.begin(), taut_.end(), actuator) != taut_.end()) return infinity;
  at(z);
  return program_.constraints(x_)[program_.shortening_row(actuator)];
}

bool Statics::lengths_hold(const Eigen::VectorXd& z, int actuator) {
  constexpr double dependent = 1e-9;
  at(z);
  const auto row = [&](int a) -> Eigen::VectorXd {
    return program_.jacobian(x_).row(program_.shortening_row(a)).head(coordinates()).transpose();
  };
  Eigen::MatrixXd held(coordinates(), std::find(taut_.begin(), taut_.end(), actuator) - taut_.begin());
  if (held.cols() == 0) return false;
  for (Eigen::Index i = 0; i < held.cols(); ++i) held.col(i) = row(taut_[static_cast<std::size_t>(i)]);
  const Eigen::VectorXd own = row(actuator);
  const Eigen::VectorXd left = own - held * held.completeOrthogonalDecomposition().solve(own);
  return left.norm() <= dependent * own.norm();
}

double Statics::tip_slope(const Eigen::VectorXd& z) {
  double slope = -1.0;
  const PoseProgram& program = at(z);
  for (int k = 0; k < contact_count(); ++k) {
    const PoseProgram::ContactState& c = program.contacts()[static_cast<std::size_t>(k)];
    if (contact(k).at_tip) slope = std::max(slope, dot(c.tangent, c.surface.normal) - c.radius.slope);
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
