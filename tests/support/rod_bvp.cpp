#include "support/rod_bvp.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <optional>

namespace tendril::support {
namespace {

using Interval = BvpSolution::Interval;
using Complex = std::complex<double>;

// Order of the state everywhere below.
enum Component : Eigen::Index { kAngle, kX, kY, kMoment, kForceX, kForceY, kStates };

template <class T>
using State = std::array<T, kStates>;

constexpr int kOrder = 28;
constexpr double kComplexStep = 1e-40;

double real(double v) { return v; }
double real(const Complex& v) { return v.real(); }

/// What the vector field depends on besides the state.
template <class T>
struct Field {
  double stiffness;
  T free_curvature;
  Point weight;
};

template <class T>
State<T> rate(const Field<T>& f, const State<T>& z) {
  using std::cos;
  using std::sin;
  const T c = cos(z[kAngle]);
  const T s = sin(z[kAngle]);
  return {f.free_curvature + z[kMoment] / f.stiffness,
          c,
          s,
          s * z[kForceX] - c * z[kForceY],
          T(-f.weight.x),
          T(-f.weight.y)};
}

/// The state after `length`: Taylor series of fixed order, in as many steps as the decay of the series allows.
template <class T>
State<T> flow(const Field<T>& f, State<T> z, double length) {
  using std::cos;
  using std::sin;
  using Series = std::array<T, kOrder + 1>;
  double remaining = length;
  while (remaining > 0.0) {
    Series angle{}, c{}, s{}, moment{};
    angle[0] = z[kAngle];
    c[0] = cos(angle[0]);
    s[0] = sin(angle[0]);
    moment[0] = z[kMoment];
    for (std::size_t k = 0; k < kOrder; ++k) {
      const double next = static_cast<double>(k + 1);
      angle[k + 1] = (moment[k] / f.stiffness + (k == 0 ? f.free_curvature : T(0.0))) / next;
      T c_sum(0.0), s_sum(0.0);
      for (std::size_t j = 0; j <= k; ++j) {
        const T turn = static_cast<double>(k + 1 - j) * angle[k + 1 - j];
        c_sum -= s[j] * turn;
        s_sum += c[j] * turn;
      }
      c[k + 1] = c_sum / next;
      s[k + 1] = s_sum / next;
      T torque = s[k] * z[kForceX] - c[k] * z[kForceY];
      if (k > 0) torque += c[k - 1] * f.weight.y - s[k - 1] * f.weight.x;
      moment[k + 1] = torque / next;
    }
    // The last two terms must not matter; both, since one of them may vanish by symmetry.
    double step = remaining;
    for (const Series* series : {&angle, &c, &s, &moment}) {
      const double size = std::max(1.0, std::abs(real(series->front())));
      for (std::size_t k : {std::size_t{kOrder} - 1, std::size_t{kOrder}}) {
        const double a = std::abs(real((*series)[k]));
        if (a > 0.0) step = std::min(step, std::pow(1e-18 * size / a, 1.0 / static_cast<double>(k)));
      }
    }
    if (!(step > 1e-9 * length)) throw BvpError("the rod turns too fast for the integrator");
    State<T> end = z;
    T x(0.0), y(0.0);
    T da(0.0), dm(0.0);
    for (std::size_t k = kOrder; k >= 1; --k) {
      da = (da + angle[k]) * step;
      dm = (dm + moment[k]) * step;
      x = (x + c[k - 1] / static_cast<double>(k)) * step;
      y = (y + s[k - 1] / static_cast<double>(k)) * step;
    }
    end[kAngle] += da;
    end[kMoment] += dm;
    end[kX] += x;
    end[kY] += y;
    end[kForceX] -= f.weight.x * step;
    end[kForceY] -= f.weight.y * step;
    z = end;
    remaining -= step;
  }
  return z;
}

bool is_wall(const BvpContact& c) { return c.wall_normal.x != 0.0 || c.wall_normal.y != 0.0; }

/// Outward normal and gap of an obstacle seen from (x, y).
template <class T>
struct Surface {
  T nx, ny, gap;
};

template <class T>
Surface<T> surface(const BvpContact& c, const T& x, const T& y) {
  using std::sqrt;
  const T dx = x - c.center.x;
  const T dy = y - c.center.y;
  if (is_wall(c)) return {T(c.wall_normal.x), T(c.wall_normal.y), dx * c.wall_normal.x + dy * c.wall_normal.y};
  const T distance = sqrt(dx * dx + dy * dy);
  return {dx / distance, dy / distance, distance - c.radius};
}

/// A knot at a constant arc length or at an interior contact.
struct Knot {
  double place = 0.0;
  std::optional<std::size_t> contact;
};

/// The rod between two knots, cut into `count` shooting intervals of equal length.
struct Piece {
  std::size_t left;
  std::size_t right;
  std::size_t count;
  std::size_t first;  ///< index of the first interval
  RodSection section;
  std::vector<bool> spanned;  ///< per actuator
};

class Shooting {
 public:
  Shooting(const RodBvp& rod, std::vector<double> moments, const std::vector<BvpContact>& contacts,
           const BvpGuess& guess, const BvpOptions& options, std::optional<std::size_t> free_actuator, double tip_angle)
      : rod_(rod),
        moments_(std::move(moments)),
        contacts_(contacts),
        options_(options),
        free_actuator_(free_actuator),
        tip_angle_(tip_angle) {
    check(guess);
    lay_out(guess);
    start(guess);
  }

  BvpSolution run();

 private:
  void check(const BvpGuess& guess) const;
  void lay_out(const BvpGuess& guess);
  void start(const BvpGuess& guess);

  double place(std::size_t knot, const Eigen::VectorXd& u) const {
    const Knot& k = knots_[knot];
    return k.contact ? u[arc_index_[*k.contact]] : k.place;
  }
  double interval_length(const Piece& p, const Eigen::VectorXd& u) const {
    return (place(p.right, u) - place(p.left, u)) / static_cast<double>(p.count);
  }
  Field<double> field(const Piece& p, const Eigen::VectorXd& u) const {
    double moment = 0.0;
    for (std::size_t j = 0; j < moments_.size(); ++j) {
      if (p.spanned[j]) moment += free_actuator_ == j ? u[moment_index_] : moments_[j];
    }
    return {p.section.stiffness,
            p.section.rest_curvature + moment / p.section.stiffness,
            {p.section.density * rod_.gravity.x, p.section.density * rod_.gravity.y}};
  }
  static State<double> state(const Eigen::VectorXd& u, std::size_t interval) {
    State<double> z;
    for (std::size_t i = 0; i < kStates; ++i) z[i] = u[static_cast<Eigen::Index>(kStates * interval + i)];
    return z;
  }
  Eigen::VectorXd residual(const Eigen::VectorXd& u) const { return assemble(u, nullptr); }
  Eigen::VectorXd assemble(const Eigen::VectorXd& u, Eigen::MatrixXd* jacobian) const;
  double scaled(const Eigen::VectorXd& step) const {
    return (step.array().abs() / unknowns_.array().abs().max(1.0)).maxCoeff();
  }
  double longest_step(const Eigen::VectorXd& step) const;
  BvpSolution solution(int iterations, double moment_rate) const;

  RodBvp rod_;
  std::vector<double> moments_;
  std::vector<BvpContact> contacts_;
  BvpOptions options_;
  std::optional<std::size_t> free_actuator_;
  double tip_angle_;

  std::vector<Knot> knots_;
  std::vector<Piece> pieces_;
  std::size_t interval_count_ = 0;
  std::vector<Eigen::Index> arc_index_;    ///< per contact, -1 at the tip
  std::vector<Eigen::Index> force_index_;  ///< per contact
  Eigen::Index moment_index_ = -1;
  Eigen::VectorXd unknowns_;
};

void Shooting::check(const BvpGuess& guess) const {
  if (moments_.size() != rod_.actuators.size()) throw BvpError("one moment per actuator is needed");
  if (guess.arc_lengths.size() != contacts_.size() || guess.forces.size() != contacts_.size()) {
    throw BvpError("one guessed arc length and force per contact are needed");
  }
  if (free_actuator_ && *free_actuator_ >= moments_.size()) throw BvpError("there is no such actuator");
  for (const RodSection& s : rod_.sections) {
    if (!(s.length > 0.0) || !(s.stiffness > 0.0)) throw BvpError("section lengths and stiffnesses must be positive");
  }
  for (const BvpContact& c : contacts_) {
    if (!is_wall(c) && !(c.radius > 0.0)) throw BvpError("radii must be positive");
  }
}

void Shooting::lay_out(const BvpGuess& guess) {
  const double length = rod_.length();
  std::vector<double> fixed{0.0, length};
  double end = 0.0;
  for (const RodSection& s : rod_.sections) fixed.push_back(std::min(end += s.length, length));
  for (const MomentSpan& a : rod_.actuators) {
    for (double p : {a.from, a.to}) {
      if (!(p >= 0.0) || p > length * (1.0 + 1e-12)) throw BvpError("an actuator ends outside the rod");
      fixed.push_back(std::min(p, length));
    }
  }
  std::sort(fixed.begin(), fixed.end());
  for (double p : fixed) {
    if (knots_.empty() || p - knots_.back().place > 1e-12 * length) knots_.push_back({p, {}});
  }
  arc_index_.assign(contacts_.size(), -1);
  force_index_.assign(contacts_.size(), -1);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].at_tip) continue;
    const double s = guess.arc_lengths[k];
    if (!(s > 0.0 && s < length)) throw BvpError("a guessed arc length lies outside the rod");
    for (const Knot& knot : knots_) {
      if (std::abs(knot.place - s) < 1e-9 * length) throw BvpError("a guessed arc length lies on another knot");
    }
    knots_.push_back({s, k});
    std::sort(knots_.begin(), knots_.end(), [](const Knot& a, const Knot& b) { return a.place < b.place; });
  }
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    const double a = knots_[k].place;
    const double b = knots_[k + 1].place;
    const double middle = 0.5 * (a + b);
    std::size_t section = 0;
    double section_end = rod_.sections[0].length;
    while (section_end < middle && section + 1 < rod_.sections.size()) section_end += rod_.sections[++section].length;
    Piece p;
    p.left = k;
    p.right = k + 1;
    p.count = static_cast<std::size_t>(std::max(1.0, std::ceil((b - a) / length * options_.intervals - 1e-9)));
    p.first = interval_count_;
    p.section = rod_.sections[section];
    for (const MomentSpan& span : rod_.actuators) p.spanned.push_back(span.from < middle && middle < span.to);
    interval_count_ += p.count;
    pieces_.push_back(p);
  }
  auto next = static_cast<Eigen::Index>(kStates * interval_count_);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!contacts_[k].at_tip) arc_index_[k] = next++;
    force_index_[k] = next++;
  }
  if (free_actuator_) moment_index_ = next++;
  unknowns_ = Eigen::VectorXd::Zero(next);
}

/// Every node gets the guessed angle, the point that follows from it, and the loads that follow from statics.
/// Integrating the moment from the tip keeps the start sensible where shooting from the base would run away.
void Shooting::start(const BvpGuess& guess) {
  const double length = rod_.length();
  const auto angle = [&](double s) { return guess.angle ? guess.angle(s) : rod_.base_angle + guess.curvature * s; };
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (arc_index_[k] >= 0) unknowns_[arc_index_[k]] = guess.arc_lengths[k];
    unknowns_[force_index_[k]] = guess.forces[k];
  }
  if (free_actuator_) unknowns_[moment_index_] = moments_[*free_actuator_];

  constexpr int kCuts = 8;
  double x = rod_.base.x;
  double y = rod_.base.y;
  for (const Piece& p : pieces_) {
    const double h = interval_length(p, unknowns_);
    for (std::size_t i = 0; i < p.count; ++i) {
      const double begin = place(p.left, unknowns_) + static_cast<double>(i) * h;
      const auto at = static_cast<Eigen::Index>(kStates * (p.first + i));
      unknowns_[at + kAngle] = angle(begin);
      unknowns_[at + kX] = x;
      unknowns_[at + kY] = y;
      for (int g = 0; g < kCuts; ++g) {
        const double a = angle(std::min(begin + (g + 0.5) * h / kCuts, length));
        x += std::cos(a) * h / kCuts;
        y += std::sin(a) * h / kCuts;
      }
    }
  }

  Point force{rod_.tip_force.x + rod_.payload * rod_.gravity.x, rod_.tip_force.y + rod_.payload * rod_.gravity.y};
  const auto add_contact = [&](std::size_t k, double px, double py) {
    const Surface<double> o = surface(contacts_[k], px, py);
    if (!std::isfinite(o.nx)) throw BvpError("the guessed rod passes through an obstacle's centre");
    force.x += unknowns_[force_index_[k]] * o.nx;
    force.y += unknowns_[force_index_[k]] * o.ny;
  };
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].at_tip) add_contact(k, x, y);
  }
  double moment = 0.0;
  for (std::size_t j = pieces_.size(); j-- > 0;) {
    const Piece& p = pieces_[j];
    const double h = interval_length(p, unknowns_);
    const Point weight = field(p, unknowns_).weight;
    for (std::size_t i = p.count; i-- > 0;) {
      const double begin = place(p.left, unknowns_) + static_cast<double>(i) * h;
      for (int g = kCuts - 1; g >= 0; --g) {
        const double a = angle(begin + (g + 0.5) * h / kCuts);
        const double fx = force.x + 0.5 * weight.x * h / kCuts;
        const double fy = force.y + 0.5 * weight.y * h / kCuts;
        moment += (std::cos(a) * fy - std::sin(a) * fx) * h / kCuts;
        force.x += weight.x * h / kCuts;
        force.y += weight.y * h / kCuts;
      }
      const auto at = static_cast<Eigen::Index>(kStates * (p.first + i));
      unknowns_[at + kMoment] = moment;
      unknowns_[at + kForceX] = force.x;
      unknowns_[at + kForceY] = force.y;
    }
    if (const auto k = knots_[p.left].contact) {
      const auto at = static_cast<Eigen::Index>(kStates * p.first);
      add_contact(*k, unknowns_[at + kX], unknowns_[at + kY]);
    }
  }
}

Eigen::VectorXd Shooting::assemble(const Eigen::VectorXd& u, Eigen::MatrixXd* jacobian) const {
  const Eigen::Index size = u.size();
  Eigen::VectorXd r = Eigen::VectorXd::Zero(size);
  if (jacobian) jacobian->setZero(size, size);
  const auto put = [&](Eigen::Index row, Eigen::Index column, double value) {
    if (jacobian) (*jacobian)(row, column) += value;
  };
  // Derivatives of an obstacle's normal and gap in the point.
  const auto surface_derivatives = [&](const BvpContact& c, double x, double y) {
    Eigen::Matrix<double, 3, 2> d;
    for (int i = 0; i < 2; ++i) {
      const Surface<Complex> o =
          surface<Complex>(c, {x, i == 0 ? kComplexStep : 0.0}, {y, i == 1 ? kComplexStep : 0.0});
      d.col(i) << o.nx.imag(), o.ny.imag(), o.gap.imag();
    }
    return Eigen::Matrix<double, 3, 2>(d / kComplexStep);
  };

  r[0] = u[kAngle] - rod_.base_angle;
  r[1] = u[kX] - rod_.base.x;
  r[2] = u[kY] - rod_.base.y;
  put(0, kAngle, 1.0);
  put(1, kX, 1.0);
  put(2, kY, 1.0);
  Eigen::Index row = 3;

  State<double> end{};
  for (const Piece& p : pieces_) {
    const Field<double> f = field(p, u);
    const double h = interval_length(p, u);
    for (std::size_t i = 0; i < p.count; ++i) {
      const std::size_t interval = p.first + i;
      const bool last = interval + 1 == interval_count_;
      const State<double> z = state(u, interval);
      end = flow(f, z, h);
      // Rows of this interval's end: all six states at an interior node; at the tip moment and force, then the angle.
      const auto target_row = [&](Eigen::Index component) -> Eigen::Index {
        if (!last) return row + component;
        return component >= kMoment ? row + component - kMoment : -1;
      };
      const auto column = static_cast<Eigen::Index>(kStates * interval);
      const auto add_end = [&](Eigen::Index unknown, const State<double>& derivative) {
        for (Eigen::Index c = 0; c < kStates; ++c) {
          const double value = derivative[static_cast<std::size_t>(c)];
          if (target_row(c) >= 0) put(target_row(c), unknown, value);
          if (last && c == kAngle && free_actuator_) put(moment_index_, unknown, value);
        }
        if (!last) return;
        for (std::size_t k = 0; k < contacts_.size(); ++k) {
          if (!contacts_[k].at_tip) continue;
          const Eigen::Matrix<double, 3, 2> d = surface_derivatives(contacts_[k], end[kX], end[kY]);
          const Eigen::Vector3d change = d * Eigen::Vector2d(derivative[kX], derivative[kY]);
          put(row + 1, unknown, -u[force_index_[k]] * change[0]);
          put(row + 2, unknown, -u[force_index_[k]] * change[1]);
          put(force_index_[k], unknown, change[2]);
        }
      };
      if (jacobian) {
        const Field<Complex> fc{f.stiffness, f.free_curvature, f.weight};
        const auto imaginary = [](const State<Complex>& v) {
          State<double> d;
          for (std::size_t c = 0; c < kStates; ++c) d[c] = v[c].imag() / kComplexStep;
          return d;
        };
        for (std::size_t c = 0; c < kStates; ++c) {
          State<Complex> zc;
          std::copy(z.begin(), z.end(), zc.begin());
          zc[c] += Complex(0.0, kComplexStep);
          add_end(column + static_cast<Eigen::Index>(c), imaginary(flow(fc, zc, h)));
        }
        if (free_actuator_ && p.spanned[*free_actuator_]) {
          State<Complex> zc;
          std::copy(z.begin(), z.end(), zc.begin());
          Field<Complex> moved = fc;
          moved.free_curvature += Complex(0.0, kComplexStep / f.stiffness);
          add_end(moment_index_, imaginary(flow(moved, zc, h)));
        }
        const State<double> speed = rate(f, end);
        for (const auto& [knot, sign] : {std::pair{p.left, -1.0}, std::pair{p.right, 1.0}}) {
          if (!knots_[knot].contact) continue;
          State<double> d = speed;
          for (double& v : d) v *= sign / static_cast<double>(p.count);
          add_end(arc_index_[*knots_[knot].contact], d);
        }
      }
      if (last) break;
      const State<double> next = state(u, interval + 1);
      for (Eigen::Index c = 0; c < kStates; ++c) {
        r[row + c] = end[static_cast<std::size_t>(c)] - next[static_cast<std::size_t>(c)];
        put(row + c, column + kStates + c, -1.0);
      }
      const auto contact = i + 1 == p.count ? knots_[p.right].contact : std::nullopt;
      if (contact) {
        // The point of the node beyond the contact stands for the contact point: both sides agree at the solution.
        const std::size_t k = *contact;
        const Surface<double> o = surface(contacts_[k], next[kX], next[kY]);
        const double force = u[force_index_[k]];
        r[row + kForceX] -= force * o.nx;
        r[row + kForceY] -= force * o.ny;
        const double tx = std::cos(next[kAngle]);
        const double ty = std::sin(next[kAngle]);
        const Eigen::Index gap = arc_index_[k];
        const Eigen::Index tangency = force_index_[k];
        r[gap] = o.gap;
        r[tangency] = tx * o.nx + ty * o.ny;
        if (jacobian) {
          const Eigen::Matrix<double, 3, 2> d = surface_derivatives(contacts_[k], next[kX], next[kY]);
          put(row + kForceX, force_index_[k], -o.nx);
          put(row + kForceY, force_index_[k], -o.ny);
          for (Eigen::Index c = 0; c < 2; ++c) {
            const Eigen::Index point = column + kStates + kX + c;
            put(row + kForceX, point, -force * d(0, c));
            put(row + kForceY, point, -force * d(1, c));
            put(gap, point, d(2, c));
            put(tangency, point, tx * d(0, c) + ty * d(1, c));
          }
          put(tangency, column + kStates + kAngle, -ty * o.nx + tx * o.ny);
        }
      }
      row += kStates;
    }
  }

  r[row] = end[kMoment];
  r[row + 1] = end[kForceX] - rod_.tip_force.x - rod_.payload * rod_.gravity.x;
  r[row + 2] = end[kForceY] - rod_.tip_force.y - rod_.payload * rod_.gravity.y;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!contacts_[k].at_tip) continue;
    const Surface<double> o = surface(contacts_[k], end[kX], end[kY]);
    r[row + 1] -= u[force_index_[k]] * o.nx;
    r[row + 2] -= u[force_index_[k]] * o.ny;
    put(row + 1, force_index_[k], -o.nx);
    put(row + 2, force_index_[k], -o.ny);
    r[force_index_[k]] = o.gap;
  }
  if (free_actuator_) r[moment_index_] = end[kAngle] - tip_angle_;
  return r;
}

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

}  // namespace

double RodBvp::length() const {
  return std::accumulate(sections.begin(), sections.end(), 0.0,
                         [](double sum, const RodSection& s) { return sum + s.length; });
}

BvpState BvpSolution::at(double s) const {
  auto it = std::upper_bound(intervals.begin(), intervals.end(), s,
                             [](double value, const Interval& interval) { return value < interval.begin; });
  if (it != intervals.begin()) --it;
  const Field<double> f{it->stiffness, it->free_curvature, it->weight};
  const State<double> z = flow(f, it->state, s - it->begin);
  return {z[kX], z[kY], z[kAngle], rate(f, z)[kAngle], z[kMoment], {z[kForceX], z[kForceY]}};
}

BvpGuess BvpSolution::guess() const {
  BvpGuess g;
  g.angle = [copy = *this](double s) { return copy.at(s).angle; };
  g.arc_lengths = arc_lengths;
  g.forces = forces;
  return g;
}

BvpSolution solve(const RodBvp& rod, const std::vector<double>& moments, const std::vector<BvpContact>& contacts,
                  const BvpGuess& guess, const BvpOptions& options) {
  return Shooting(rod, moments, contacts, guess, options, std::nullopt, 0.0).run();
}

BvpSolution solve_tip_angle(const RodBvp& rod, const std::vector<double>& moments, std::size_t free_actuator,
                            double tip_angle, const std::vector<BvpContact>& contacts, const BvpGuess& guess,
                            const BvpOptions& options) {
  return Shooting(rod, moments, contacts, guess, options, free_actuator, tip_angle).run();
}

BvpSolution follow(const RodBvp& rod, const std::vector<double>& first, const std::vector<double>& last,
                   const std::vector<BvpContact>& contacts, const BvpGuess& guess, const BvpOptions& options) {
  if (first.size() != last.size()) throw BvpError("both ends of the way need one moment per actuator");
  BvpSolution here = solve(rod, first, contacts, guess, options);
  double done = 0.0;
  double step = 0.125;
  while (done < 1.0) {
    const double next = std::min(1.0, done + step);
    std::vector<double> moments;
    for (std::size_t j = 0; j < first.size(); ++j) moments.push_back((1.0 - next) * first[j] + next * last[j]);
    try {
      here = solve(rod, moments, contacts, here.guess(), options);
      done = next;
      step *= 2.0;
    } catch (const BvpError&) {
      step *= 0.5;
      if (step < 1e-4) throw;
    }
  }
  return here;
}

}  // namespace tendril::support
