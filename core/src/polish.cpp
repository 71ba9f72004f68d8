#include "tendril/polish.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "tendril/multipliers.hpp"

namespace tendril {
namespace {

enum class Side : signed char { inactive = 0, lower = -1, upper = 1, equal = 2 };

class Polisher {
 public:
  Polisher(NonlinearProgram& program, ConstVectorRef x, const PolishOptions& options)
      : program_(program),
        options_(options),
        x_(x),
        y_(Eigen::VectorXd::Zero(program.row_count())),
        rows_(static_cast<std::size_t>(program.row_count()), Side::inactive),
        bounds_(static_cast<std::size_t>(program.variable_count()), Side::inactive) {}

  PolishReport run(const Eigen::VectorXd& multipliers) {
    x_ = x_.cwiseMax(program_.lower()).cwiseMin(program_.upper());
    choose_active(multipliers);
    if (multipliers.size() == program_.row_count()) {
      for (int i = 0; i < program_.row_count(); ++i) y_[i] = row(i) == Side::inactive ? 0.0 : multipliers[i];
    } else {
      fit_multipliers();
    }
    std::set<std::vector<Side>> seen;
    while (report_.iterations < options_.max_iterations) {
      if (!newton()) return finish(false);
      std::vector<Side> signature = rows_;
      signature.insert(signature.end(), bounds_.begin(), bounds_.end());
      if (!seen.insert(signature).second) {
        report_.reason = "the active set cycles";
        return finish(false);
      }
      if (!correct_active()) return finish(true);
    }
    report_.reason = "too many steps";
    return finish(false);
  }

 private:
  Side row(int i) const { return rows_[static_cast<std::size_t>(i)]; }
  Side bound(int i) const { return bounds_[static_cast<std::size_t>(i)]; }

  void choose_active(const Eigen::VectorXd& multipliers) {
    const VectorView c = program_.constraints(x_);
    const bool known = multipliers.size() == program_.row_count();
    const double tolerance = options_.active_tolerance;
    for (int i = 0; i < program_.row_count(); ++i) {
      Side& side = rows_[static_cast<std::size_t>(i)];
      const double low = program_.row_lower()[i];
      const double high = program_.row_upper()[i];
      if (low == high) {
        side = Side::equal;
      } else if (c[i] <= low + tolerance && !(known && multipliers[i] == 0.0 && c[i] > low)) {
        side = Side::lower;
      } else if (c[i] >= high - tolerance && !(known && multipliers[i] == 0.0 && c[i] < high)) {
        side = Side::upper;
      }
    }
    for (int i = 0; i < program_.variable_count(); ++i) {
      Side& side = bounds_[static_cast<std::size_t>(i)];
      const double low = program_.lower()[i];
      const double high = program_.upper()[i];
      if (low == high) {
        side = Side::equal;
      } else if (x_[i] <= low + tolerance) {
        side = Side::lower;
      } else if (x_[i] >= high - tolerance) {
        side = Side::upper;
      }
    }
  }

  std::vector<int> active_rows() const {
    std::vector<int> active;
    for (int i = 0; i < program_.row_count(); ++i) {
      if (row(i) != Side::inactive) active.push_back(i);
    }
    return active;
  }

  std::vector<int> free_variables() const {
    std::vector<int> free;
    for (int i = 0; i < program_.variable_count(); ++i) {
      if (bound(i) == Side::inactive) free.push_back(i);
    }
    return free;
  }

  double row_target(int i) const { return row(i) == Side::upper ? program_.row_upper()[i] : program_.row_lower()[i]; }

  void pin_bounds() {
    for (int i = 0; i < program_.variable_count(); ++i) {
      if (bound(i) == Side::lower || bound(i) == Side::equal) x_[i] = program_.lower()[i];
      if (bound(i) == Side::upper) x_[i] = program_.upper()[i];
    }
  }

  void fit_multipliers() {
    pin_bounds();
    const std::vector<int> active = active_rows();
    const std::vector<int> free = free_variables();
    y_.setZero();
    if (active.empty() || free.empty()) return;
    const MatrixView jacobian = program_.jacobian(x_);
    const VectorView gradient = program_.gradient(x_);
    Eigen::MatrixXd a(free.size(), active.size());
    Eigen::VectorXd g(free.size());
    for (Eigen::Index v = 0; v < a.rows(); ++v) {
      g[v] = gradient[free[static_cast<std::size_t>(v)]];
      for (Eigen::Index r = 0; r < a.cols(); ++r) {
        a(v, r) = jacobian(active[static_cast<std::size_t>(r)], free[static_cast<std::size_t>(v)]);
      }
    }
    const Eigen::VectorXd fit = a.completeOrthogonalDecomposition().solve(-g);
    for (Eigen::Index r = 0; r < fit.size(); ++r) y_[active[static_cast<std::size_t>(r)]] = fit[r];
  }

  struct Residual {
    double rows = infinity;
    double slope = infinity;
    double merit() const { return std::max(rows, slope); }
  };

  /// Residual of the first-order conditions at x with multipliers y, and the gradient of the Lagrangian.
  Residual residual(const Eigen::VectorXd& x, const Eigen::VectorXd& y, const std::vector<int>& active,
                    const std::vector<int>& free, Eigen::VectorXd& slope) {
    const VectorView c = program_.constraints(x);
    const MatrixView jacobian = program_.jacobian(x);
    slope = program_.gradient(x);
    slope.noalias() += jacobian.transpose() * y;
    Residual r{0.0, 0.0};
    for (const int i : active) r.rows = std::max(r.rows, std::abs(c[i] - row_target(i)));
    for (const int i : free) r.slope = std::max(r.slope, std::abs(slope[i]));
    const double size = active.empty() ? 1.0 : 1.0 + y.cwiseAbs().maxCoeff();
    r.slope /= size;
    if (!std::isfinite(r.rows) || !std::isfinite(r.slope) || !slope.allFinite()) return {infinity, infinity};
    return r;
  }

  /// Newton on the current active set. False: no convergence.
  bool newton() {
    pin_bounds();
    const std::vector<int> active = active_rows();
    const std::vector<int> free = free_variables();
    const auto nf = static_cast<Eigen::Index>(free.size());
    const auto na = static_cast<Eigen::Index>(active.size());
    Eigen::VectorXd slope;
    Residual now = residual(x_, y_, active, free, slope);
    if (!std::isfinite(now.merit())) {
      report_.reason = "a value is not finite";
      return false;
    }
    Eigen::MatrixXd kkt(nf + na, nf + na);
    Eigen::VectorXd rhs(nf + na);
    double best = now.merit();
    int without_progress = 0;
    while (now.rows > options_.row_tolerance || now.slope > options_.slope_tolerance) {
      if (report_.iterations++ >= options_.max_iterations) {
        report_.reason = "too many steps";
        return false;
      }
      if (options_.stop && options_.stop()) {
        report_.reason = "stopped";
        return false;
      }
      // The order matters: hessian() moves the program to x.
      const MatrixView hessian = program_.hessian(x_, 1.0, y_);
      const MatrixView jacobian = program_.jacobian(x_);
      const VectorView c = program_.constraints(x_);
      kkt.setZero();
      for (Eigen::Index i = 0; i < nf; ++i) {
        const int vi = free[static_cast<std::size_t>(i)];
        rhs[i] = -slope[vi];
        for (Eigen::Index k = 0; k < nf; ++k) kkt(k, i) = hessian(free[static_cast<std::size_t>(k)], vi);
        for (Eigen::Index r = 0; r < na; ++r) {
          kkt(nf + r, i) = kkt(i, nf + r) = jacobian(active[static_cast<std::size_t>(r)], vi);
        }
      }
      for (Eigen::Index r = 0; r < na; ++r) {
        const int i = active[static_cast<std::size_t>(r)];
        rhs[nf + r] = row_target(i) - c[i];
      }
      Eigen::VectorXd step = kkt.partialPivLu().solve(rhs);
      const double scale = 1.0 + rhs.cwiseAbs().maxCoeff();
      if (!step.allFinite() || (kkt * step - rhs).cwiseAbs().maxCoeff() > 1e-8 * scale || step.head(nf).norm() > 1e3) {
        // Dependent rows or a flat direction: the shortest step that does as well as any.
        step = kkt.completeOrthogonalDecomposition().solve(rhs);
        if (!step.allFinite()) {
          report_.reason = "the KKT system has no solution";
          return false;
        }
      }
      bool accepted = false;
      double length = 1.0;
      Eigen::VectorXd x_new = x_;
      Eigen::VectorXd y_new = y_;
      Eigen::VectorXd slope_new;
      Residual next;
      for (int halving = 0; halving < 6 && !accepted; ++halving, length *= 0.5) {
        for (Eigen::Index i = 0; i < nf; ++i) {
          const int v = free[static_cast<std::size_t>(i)];
          x_new[v] = x_[v] + length * step[i];
        }
        for (Eigen::Index r = 0; r < na; ++r) {
          const int i = active[static_cast<std::size_t>(r)];
          y_new[i] = y_[i] + length * step[nf + r];
        }
        next = residual(x_new, y_new, active, free, slope_new);
        accepted = next.merit() < 0.95 * now.merit();
      }
      if (!accepted) {
        // At the floor of rounding a Newton step cannot make things better.
        if (now.rows <= 10.0 * options_.row_tolerance && now.slope <= 100.0 * options_.slope_tolerance) return true;
        report_.reason = "Newton steps do not reduce the residual";
        return false;
      }
      x_ = x_new;
      y_ = y_new;
      slope = slope_new;
      now = next;
      without_progress = now.merit() < 0.5 * best ? 0 : without_progress + 1;
      best = std::min(best, now.merit());
      if (without_progress > 8) {
        report_.reason = "slow convergence";
        return false;
      }
    }
    return true;
  }

  /// Adds what is violated, else drops the worst multiplier of the wrong sign. False: nothing to correct.
  bool correct_active() {
    constexpr double violated = 1e-10;
    const VectorView c = program_.constraints(x_);
    bool changed = false;
    for (int i = 0; i < program_.row_count(); ++i) {
      if (row(i) != Side::inactive) continue;
      Side& side = rows_[static_cast<std::size_t>(i)];
      if (c[i] < program_.row_lower()[i] - violated) side = Side::lower;
      if (c[i] > program_.row_upper()[i] + violated) side = Side::upper;
      changed = changed || side != Side::inactive;
    }
    for (int i = 0; i < program_.variable_count(); ++i) {
      if (bound(i) != Side::inactive) continue;
      Side& side = bounds_[static_cast<std::size_t>(i)];
      if (x_[i] < program_.lower()[i]) side = Side::lower;
      if (x_[i] > program_.upper()[i]) side = Side::upper;
      changed = changed || side != Side::inactive;
    }
    if (changed) return true;
    Eigen::VectorXd slope = program_.gradient(x_);
    slope.noalias() += program_.jacobian(x_).transpose() * y_;
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
    for (int i = 0; i < program_.row_count(); ++i) consider(rows_[static_cast<std::size_t>(i)], y_[i], i);
    for (int i = 0; i < program_.variable_count(); ++i) consider(bounds_[static_cast<std::size_t>(i)], -slope[i], -1);
    if (drop == nullptr) return false;
    *drop = Side::inactive;
    if (dropped_row >= 0) y_[dropped_row] = 0.0;
    return true;
  }

  PolishReport finish(bool converged) {
    report_.converged = converged;
    report_.x = x_;
    report_.multipliers = y_;
    Eigen::VectorXd slope = program_.gradient(x_);
    slope.noalias() += program_.jacobian(x_).transpose() * y_;
    report_.bound_multipliers = Eigen::VectorXd::Zero(program_.variable_count());
    report_.stationarity = 0.0;
    for (int i = 0; i < program_.variable_count(); ++i) {
      if (bound(i) == Side::inactive) {
        report_.stationarity = std::max(report_.stationarity, std::abs(slope[i]));
      } else {
        report_.bound_multipliers[i] = -slope[i];
      }
    }
    report_.infeasibility = infeasibility(program_, x_);
    return report_;
  }

  NonlinearProgram& program_;
  PolishOptions options_;
  Eigen::VectorXd x_, y_;
  std::vector<Side> rows_, bounds_;
  PolishReport report_;
};

}  // namespace

PolishReport polish(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                    const PolishOptions& options) {
  return Polisher(program, x, options).run(multipliers);
}

}  // namespace tendril
