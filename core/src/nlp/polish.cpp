#include "nlp/polish.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nlp/multipliers.hpp"

namespace tendril {
namespace {

/// A step that left this share of the residual is followed by one with the same factorization, whose error shrinks by
/// about that share again: it costs an evaluation instead of a Hessian and a factorization too.
constexpr double chord_share = 1e-2;
/// Where such a step ended, tolerances count this much: Newton's own would have gone on to rounding.
constexpr double chord_accuracy = 1e-2;
/// Lengths of a step that are tried, each half of the one before.
constexpr int most_trials = 6;

}  // namespace

class Polisher::Newton {
 public:
  void keep() { keeps_ = true; }
  const PolishReport& run(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                          const PolishOptions& options) {
    program_ = &program;
    options_ = options;
    report_.iterations = 0;
    report_.reason = "";
    rows_.assign(static_cast<std::size_t>(program.row_count()), Side::inactive);
    bounds_.assign(static_cast<std::size_t>(program.variable_count()), Side::inactive);
    seen_.clear();
    x_ = x.cwiseMax(program.lower()).cwiseMin(program.upper());
    y_.setZero(program.row_count());
    choose_active(multipliers);
    if (multipliers.size() == program.row_count()) {
      for (int i = 0; i < program.row_count(); ++i) y_[i] = row(i) == Side::inactive ? 0.0 : multipliers[i];
    } else {
      fit_multipliers();
    }
    while (report_.iterations < options_.max_iterations) {
      if (!newton()) return finish(false);
      if (seen_before()) {
        report_.reason = "the active set cycles";
        return finish(false);
      }
      if (correct_active()) continue;
      if (!options_.descends || curves_upwards()) return finish(true);
      report_.reason = "no minimum";
      return finish(false);
    }
    report_.reason = "too many steps";
    return finish(false);
  }

 private:
  enum class Side : signed char { inactive = 0, lower = -1, upper = 1, equal = 2 };

  Side row(int i) const { return rows_[static_cast<std::size_t>(i)]; }
  Side bound(int i) const { return bounds_[static_cast<std::size_t>(i)]; }

  void choose_active(const Eigen::VectorXd& multipliers) {
    (void)program_->jacobian(x_);  // brings the values along, and is needed next
    const VectorView c = program_->constraints(x_);
    const bool known = multipliers.size() == program_->row_count();
    const double tolerance = options_.active_tolerance;
    for (int i = 0; i < program_->row_count(); ++i) {
      Side& side = rows_[static_cast<std::size_t>(i)];
      const double low = program_->row_lower()[i];
      const double high = program_->row_upper()[i];
      if (low == high) {
        side = Side::equal;
      } else if (c[i] <= low + tolerance && !(known && multipliers[i] == 0.0 && c[i] > low)) {
        side = Side::lower;
      } else if (c[i] >= high - tolerance && !(known && multipliers[i] == 0.0 && c[i] < high)) {
        side = Side::upper;
      }
    }
    for (int i = 0; i < program_->variable_count(); ++i) {
      Side& side = bounds_[static_cast<std::size_t>(i)];
      const double low = program_->lower()[i];
      const double high = program_->upper()[i];
      if (low == high) {
        side = Side::equal;
      } else if (x_[i] <= low + tolerance) {
        side = Side::lower;
      } else if (x_[i] >= high - tolerance) {
        side = Side::upper;
      }
    }
  }

  void collect() {
    active_.clear();
    free_.clear();
    for (int i = 0; i < program_->row_count(); ++i) {
      if (row(i) != Side::inactive) active_.push_back(i);
    }
    for (int i = 0; i < program_->variable_count(); ++i) {
      if (bound(i) == Side::inactive) free_.push_back(i);
    }
  }

  /// Whether Newton has ended on this active set before; remembers it.
  bool seen_before() {
    const std::size_t size = rows_.size() + bounds_.size();
    const auto matches = [&](std::size_t from) {
      const auto begin = seen_.begin() + static_cast<std::ptrdiff_t>(from);
      return std::equal(rows_.begin(), rows_.end(), begin) &&
             std::equal(bounds_.begin(), bounds_.end(), begin + static_cast<std::ptrdiff_t>(rows_.size()));
    };
    for (std::size_t from = 0; from + size <= seen_.size() && size > 0; from += size) {
      if (matches(from)) return true;
    }
    seen_.insert(seen_.end(), rows_.begin(), rows_.end());
    seen_.insert(seen_.end(), bounds_.begin(), bounds_.end());
    return false;
  }

  double row_target(int i) const { return row(i) == Side::upper ? program_->row_upper()[i] : program_->row_lower()[i]; }

  void pin_bounds() {
    for (int i = 0; i < program_->variable_count(); ++i) {
      if (bound(i) == Side::lower || bound(i) == Side::equal) x_[i] = program_->lower()[i];
      if (bound(i) == Side::upper) x_[i] = program_->upper()[i];
    }
  }

  void fit_multipliers() {
    pin_bounds();
    collect();
    y_.setZero();
    if (active_.empty() || free_.empty()) return;
    const MatrixView jacobian = program_->jacobian(x_);
    const VectorView gradient = program_->gradient(x_);
    Eigen::MatrixXd a(free_.size(), active_.size());
    Eigen::VectorXd g(free_.size());
    for (Eigen::Index v = 0; v < a.rows(); ++v) {
      g[v] = gradient[free_[static_cast<std::size_t>(v)]];
      for (Eigen::Index r = 0; r < a.cols(); ++r) {
        a(v, r) = jacobian(active_[static_cast<std::size_t>(r)], free_[static_cast<std::size_t>(v)]);
      }
    }
    const Eigen::VectorXd fit = a.completeOrthogonalDecomposition().solve(-g);
    for (Eigen::Index r = 0; r < fit.size(); ++r) y_[active_[static_cast<std::size_t>(r)]] = fit[r];
  }

  struct Residual {
    double rows = infinity;
    double slope = infinity;
    double merit() const { return std::max(rows, slope); }
  };

  /// Residual of the first-order conditions at x with multipliers y, and the gradient of the Lagrangian.
  Residual residual(const Eigen::VectorXd& x, const Eigen::VectorXd& y, Eigen::VectorXd& slope) {
    // Derivatives first: they bring the values along.
    slope = program_->gradient(x);
    slope.noalias() += program_->jacobian(x).transpose() * y;
    const VectorView c = program_->constraints(x);
    Residual r{0.0, 0.0};
    for (const int i : active_) r.rows = std::max(r.rows, std::abs(c[i] - row_target(i)));
    for (const int i : free_) r.slope = std::max(r.slope, std::abs(slope[i]));
    const double size = active_.empty() ? 1.0 : 1.0 + y.cwiseAbs().maxCoeff();
    r.slope /= size;
    if (!std::isfinite(r.rows) || !std::isfinite(r.slope) || !slope.allFinite()) return {infinity, infinity};
    return r;
  }

  /// What a unit roundoff of every variable can change in a row: beside an obstacle of radius r the normal turns by 1/r
  /// times what the point moves, so that no step gets below that.
  double rounding() {
    const MatrixView jacobian = program_->jacobian(x_);
    double largest = 0.0;
    for (const int i : active_) {
      double sum = 0.0;
      for (Eigen::Index v = 0; v < x_.size(); ++v) sum += std::abs(jacobian(i, v) * x_[v]);
      largest = std::max(largest, sum);
    }
    return std::numeric_limits<double>::epsilon() * largest;
  }

  bool give_up(const char* reason) {
    report_.reason = reason;
    return false;
  }

  /// Whether the residual is below the tolerances, these times `share`.
  bool small(const Residual& r, double share) const {
    return r.rows <= share * options_.row_tolerance && r.slope <= share * options_.slope_tolerance;
  }

  /// Newton on the current active set. False: no convergence.
  bool newton() {
    pin_bounds();
    collect();
    Residual now = residual(x_, y_, slope_);
    if (!std::isfinite(now.merit())) return give_up("a value is not finite");
    double best = now.merit();
    int without_progress = 0;
    // Whether the factorization is an earlier point's.
    bool chord = keeps_ && regular_ && active_ == factored_rows_ && free_ == factored_variables_;
    while (!small(now, chord ? chord_accuracy : 1.0)) {
      if (report_.iterations++ >= options_.max_iterations) return give_up("too many steps");
      if (options_.stop && options_.stop()) return give_up("stopped");
      if (!chord) factorize();
      set_right_side();
      if (!solve()) return give_up("the KKT system has no solution");
      if (options_.descends && stop_at_bound()) {
        now = residual(x_, y_, slope_);
        if (!std::isfinite(now.merit())) return give_up("a value is not finite");
        best = now.merit();
        chord = false;
        continue;
      }
      const Residual next = search_along_step(now, chord ? 1 : most_trials);
      if (!(next.merit() < infinity)) {
        if (small(now, 1.0)) return true;
        if (chord) {
          chord = false;
          continue;
        }
        // At the floor of rounding a Newton step cannot make things better.
        const double floor = std::max(10.0 * options_.row_tolerance, rounding());
        if (now.rows <= floor && now.slope <= 100.0 * options_.slope_tolerance) return true;
        return give_up("Newton steps do not reduce the residual");
      }
      x_.swap(x_new_);
      y_.swap(y_new_);
      slope_.swap(slope_new_);
      chord = regular_ && next.merit() <= chord_share * now.merit();
      now = next;
      without_progress = now.merit() < 0.5 * best ? 0 : without_progress + 1;
      best = std::min(best, now.merit());
      if (without_progress > 8) return give_up("slow convergence");
    }
    return true;
  }

  /// The KKT matrix at x: free variables first, then active rows.
  void factorize() {
    const auto nf = static_cast<Eigen::Index>(free_.size());
    const auto na = static_cast<Eigen::Index>(active_.size());
    // The order matters: hessian() moves the program to x.
    const MatrixView hessian = program_->hessian(x_, 1.0, y_);
    const MatrixView jacobian = program_->jacobian(x_);
    kkt_.setZero(nf + na, nf + na);
    for (Eigen::Index i = 0; i < nf; ++i) {
      const int vi = free_[static_cast<std::size_t>(i)];
      for (Eigen::Index k = 0; k < nf; ++k) kkt_(k, i) = hessian(free_[static_cast<std::size_t>(k)], vi);
      for (Eigen::Index r = 0; r < na; ++r) {
        kkt_(nf + r, i) = kkt_(i, nf + r) = jacobian(active_[static_cast<std::size_t>(r)], vi);
      }
    }
    lu_.compute(kkt_);
    factored_rows_ = active_;
    factored_variables_ = free_;
  }

  /// What the next step has to take away, in the order of the matrix.
  void set_right_side() {
    const auto nf = static_cast<Eigen::Index>(free_.size());
    const VectorView c = program_->constraints(x_);
    rhs_.resize(nf + static_cast<Eigen::Index>(active_.size()));
    Eigen::Index k = 0;
    for (const int i : free_) rhs_[k++] = -slope_[i];
    for (const int i : active_) rhs_[k++] = row_target(i) - c[i];
  }

  /// The step that solves the system. False: there is none.
  bool solve() {
    left_.resize(rhs_.size());
    step_ = lu_.solve(rhs_);
    left_.noalias() = kkt_ * step_;
    left_ -= rhs_;
    const double scale = 1.0 + rhs_.cwiseAbs().maxCoeff();
    const auto nf = static_cast<Eigen::Index>(free_.size());
    regular_ = step_.allFinite() && left_.cwiseAbs().maxCoeff() <= 1e-8 * scale && step_.head(nf).norm() <= 1e3;
    if (regular_) return true;
    // Dependent rows or a flat direction: the shortest step that does as well as any.
    step_ = kkt_.completeOrthogonalDecomposition().solve(rhs_);
    return step_.allFinite();
  }

  /// Where a bound is in the way of the step, goes as far as that, and it becomes active.
  bool stop_at_bound() {
    double length = 1.0;
    int met = -1;
    Eigen::Index k = 0;
    for (const int i : free_) {
      const double move = step_[k++];
      const double room = (move < 0.0 ? program_->lower()[i] : program_->upper()[i]) - x_[i];
      if (move == 0.0 || !(room / move < length)) continue;
      length = room / move;
      met = i;
    }
    if (met < 0) return false;
    k = 0;
    for (const int i : free_) {
      if (i == met) bounds_[static_cast<std::size_t>(i)] = step_[k] < 0.0 ? Side::lower : Side::upper;
      x_[i] += length * step_[k++];
    }
    for (const int i : active_) y_[i] += length * step_[k++];
    pin_bounds();
    collect();
    return true;
  }

  /// Whether the Lagrangian curves upwards along the active rows, at the point of the last factorization.
  bool curves_upwards() {
    if (report_.iterations == 0 || active_ != factored_rows_ || free_ != factored_variables_) factorize();
    const auto nf = static_cast<Eigen::Index>(free_.size());
    const auto na = static_cast<Eigen::Index>(active_.size());
    if (na >= nf) return true;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(kkt_.topRightCorner(nf, na));
    const Eigen::MatrixXd along = qr.householderQ() * Eigen::MatrixXd::Identity(nf, nf).rightCols(nf - na);
    return (along.transpose() * kkt_.topLeftCorner(nf, nf) * along).llt().info() == Eigen::Success;
  }

  /// Above all multipliers, so that the step reduces exact_penalty().
  double weight_along_step() const {
    double largest = 0.0;
    auto k = static_cast<Eigen::Index>(free_.size());
    for (const int i : active_) largest = std::max(largest, std::abs(y_[i] + step_[k++]));
    return 2.0 * largest;
  }

  /// The objective with `weight` for each active row that is off: what falls on the way to a minimum from afar, while
  /// rows that the step keeps linearly come off by its square.
  double exact_penalty(const Eigen::VectorXd& x, double weight) {
    const VectorView c = program_->constraints(x);
    double off = 0.0;
    for (const int i : active_) off += std::abs(c[i] - row_target(i));
    return program_->cost(x) + weight * off;
  }

  /// Goes along the step, halved until the residual falls; infinite where it does not.
  Residual search_along_step(const Residual& now, int trials) {
    x_new_ = x_;
    y_new_ = y_;
    double length = 1.0;
    const double weight = options_.descends ? weight_along_step() : 0.0;
    const double value = options_.descends ? exact_penalty(x_, weight) : 0.0;
    for (int trial = 0; trial < trials; ++trial, length *= 0.5) {
      Eigen::Index k = 0;
      for (const int i : free_) x_new_[i] = x_[i] + length * step_[k++];
      for (const int i : active_) y_new_[i] = y_[i] + length * step_[k++];
      const Residual next = residual(x_new_, y_new_, slope_new_);
      if (next.merit() < 0.95 * now.merit()) return next;
      if (options_.descends && trials > 1 && next.merit() < infinity && exact_penalty(x_new_, weight) < value)
        return next;
    }
    return {};
  }

  /// Adds what is violated, else drops the worst multiplier of the wrong sign. False: nothing to correct.
  bool correct_active() {
    constexpr double violated = 1e-10;
    const VectorView c = program_->constraints(x_);
    bool changed = false;
    for (int i = 0; i < program_->row_count(); ++i) {
      if (row(i) != Side::inactive) continue;
      Side& side = rows_[static_cast<std::size_t>(i)];
      if (c[i] < program_->row_lower()[i] - violated) side = Side::lower;
      if (c[i] > program_->row_upper()[i] + violated) side = Side::upper;
      changed = changed || side != Side::inactive;
    }
    for (int i = 0; i < program_->variable_count(); ++i) {
      if (bound(i) != Side::inactive) continue;
      Side& side = bounds_[static_cast<std::size_t>(i)];
      if (x_[i] < program_->lower()[i]) side = Side::lower;
      if (x_[i] > program_->upper()[i]) side = Side::upper;
      changed = changed || side != Side::inactive;
    }
    if (changed) return true;
    // A multiplier counts as wrong only beyond the accuracy of the slopes themselves.
    double worst = 1e-9 * (1.0 + (y_.size() > 0 ? y_.cwiseAbs().maxCoeff() : 0.0));
    Side* drop = nullptr;
    int dropped_row = -1;
    const auto consider = [&](Side& side, double multiplier, int row_index) {
      const double wrong = side == Side::lower ? multiplier : side == Side::upper ? -multiplier : 0.0;
      if (wrong <= worst) return;
      worst = wrong;
      drop = &side;
      dropped_row = row_index;
    };
    for (int i = 0; i < program_->row_count(); ++i) consider(rows_[static_cast<std::size_t>(i)], y_[i], i);
    for (int i = 0; i < program_->variable_count(); ++i) consider(bounds_[static_cast<std::size_t>(i)], -slope_[i], -1);
    if (drop == nullptr) return false;
    *drop = Side::inactive;
    if (dropped_row >= 0) y_[dropped_row] = 0.0;
    return true;
  }

  const PolishReport& finish(bool converged) {
    report_.converged = converged;
    report_.x = x_;
    report_.multipliers = y_;
    report_.bound_multipliers.setZero(program_->variable_count());
    report_.stationarity = 0.0;
    for (int i = 0; i < program_->variable_count(); ++i) {
      if (bound(i) == Side::inactive) {
        report_.stationarity = std::max(report_.stationarity, std::abs(slope_[i]));
      } else {
        report_.bound_multipliers[i] = -slope_[i];
      }
    }
    report_.infeasibility = infeasibility(*program_, x_);
    return report_;
  }

  NonlinearProgram* program_ = nullptr;
  PolishOptions options_;
  Eigen::VectorXd x_, y_, slope_;
  Eigen::VectorXd x_new_, y_new_, slope_new_;  ///< of a step that is tried
  std::vector<Side> rows_, bounds_;
  std::vector<Side> seen_;                               ///< active sets on which Newton ended, one after the other
  std::vector<int> active_, free_;                       ///< rows and variables of the current active set
  std::vector<int> factored_rows_, factored_variables_;  ///< those of the matrix
  Eigen::MatrixXd kkt_;
  Eigen::VectorXd rhs_, step_, left_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  bool regular_ = false;  ///< the last step came from lu_
  bool keeps_ = false;    ///< lu_, from one run to the next
  PolishReport report_;
};

Polisher::Polisher() : newton_(std::make_unique<Newton>()) {}
Polisher::Polisher(Polisher&&) noexcept = default;
Polisher& Polisher::operator=(Polisher&&) noexcept = default;
Polisher::~Polisher() = default;
void Polisher::keep_factorization() { newton_->keep(); }

const PolishReport& Polisher::run(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                                  const PolishOptions& options) {
  return newton_->run(program, x, multipliers, options);
}

PolishReport polish(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                    const PolishOptions& options) {
  return Polisher().run(program, x, multipliers, options);
}

}  // namespace tendril
