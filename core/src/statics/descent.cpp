#include "statics/descent.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr int fine_order = 6;                                  ///< functions per piece of the fine basis
constexpr int pieces_per_rod = 8;                              ///< at least, of the fine basis
constexpr int checks_per_rod = 160;                            ///< at least, per obstacle
constexpr double first_stiffness = 1e4, last_stiffness = 1e7;  ///< of the penalty, energy per length squared
constexpr double longest_step = 0.25;   ///< of the trust region, in the metric of the bending energy
constexpr int most_steps = 600;         ///< per stiffness
constexpr double flat = 1e-9;           ///< gradient in that metric at which a round ends
constexpr double downward = -1e-7;      ///< a lower eigenvalue is a way down
constexpr double rigid_enough = 1e-10;  ///< depth of a check point (L) below which multipliers hold it
constexpr double lying = 1e-5;          ///< distance (L) that a rod which lies along an obstacle does not exceed
constexpr int most_rounds = 40;         ///< of multipliers

class Valley {
 public:
  Valley(const LoadPath& path, std::shared_ptr<const CoordinateModel> basis)
      : path_(path), basis_(std::move(basis)), program_(std::make_unique<PoseProgram>(spec())) {
    const Chain& chain = program_->chain();
    const int functions = chain.functions();
    n_ = chain.coordinate_count();
    held_ = Eigen::VectorXd::Zero(program_->layout().checks);
    x_ = Eigen::VectorXd::Zero(program_->variable_count());
    for (int a = 0; a < static_cast<int>(path.rod().actuators.size()); ++a) {
      x_[program_->moment_variable(a)] = path.moment(static_cast<std::size_t>(a), path.load());
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(chain.table().stiffness);
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(functions, functions);
    const Eigen::MatrixXd block = llt.matrixU().solve(unit);
    // q = T y makes the bending energy |y|^2 / 2.
    scale_ = Eigen::MatrixXd::Zero(n_, n_);
    for (int j = 0; j < chain.piece_count(); ++j) {
      scale_.block(j * functions, j * functions, functions, functions) =
          std::sqrt(chain.length0()[j] / chain.piece(j).stiffness) * block;
    }
  }

  void start(const std::function<double(double)>& curvature) {
    const Chain& chain = program_->chain();
    std::vector<double> scaled(static_cast<std::size_t>(chain.nodes()));
    for (int j = 0; j < chain.piece_count(); ++j) {
      for (int g = 0; g < chain.nodes(); ++g) {
        scaled[static_cast<std::size_t>(g)] =
            chain.length0()[j] * curvature(chain.start0()[j] + chain.length0()[j] * chain.table().sigma[g]);
      }
      x_.segment(j * chain.functions(), chain.functions()) = chain.project(scaled);
    }
  }

  /// Energy with the penalty at the coordinates kept, moved by `step` in scaled coordinates.
  double energy(const Eigen::VectorXd* step, double stiffness) {
    Eigen::VectorXd x = x_;
    if (step != nullptr) x.head(n_) += scale_ * *step;
    const Eigen::VectorXd rows = program_->constraints(x);
    double sum = potential(x);
    for (int i = 0; i < program_->layout().checks; ++i) {
      const double depth = std::min(0.0, rows[program_->layout().first_check + i] - held_[i] / stiffness);
      sum += 0.5 * stiffness * depth * depth;
    }
    return sum;
  }

  void derivatives(double stiffness, Eigen::VectorXd& gradient, Eigen::MatrixXd& hessian) {
    const PoseProgram::Layout& at = program_->layout();
    const Eigen::VectorXd rows = program_->constraints(x_);
    const Eigen::MatrixXd jacobian = program_->jacobian(x_).leftCols(n_);
    Eigen::VectorXd g = -rows.head(n_);
    Eigen::MatrixXd h = -jacobian.topRows(n_);
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(rows.size());
    bool touches = false;
    for (int i = 0; i < at.checks; ++i) {
      const int row = at.first_check + i;
      const double depth = rows[row] - held_[i] / stiffness;
      if (!(depth < 0.0)) continue;
      touches = true;
      const Eigen::VectorXd slope = jacobian.row(row).transpose();
      multipliers[row] = stiffness * depth;
      g += multipliers[row] * slope;
      h += stiffness * slope * slope.transpose();
    }
    if (touches) h += program_->hessian(x_, 0.0, multipliers).topLeftCorner(n_, n_);
    gradient = scale_.transpose() * g;
    hessian = scale_.transpose() * (0.5 * (h + h.transpose())) * scale_;
  }

  /// Hands the penalty's forces over to the multipliers; returns what was wrong with them: depth, or force at a gap.
  double hold(double stiffness) {
    const Eigen::VectorXd rows = program_->constraints(x_);
    double worst = 0.0;
    for (int i = 0; i < program_->layout().checks; ++i) {
      const double gap = rows[program_->layout().first_check + i];
      worst = std::max(worst, std::abs(std::min(gap, held_[i] / stiffness)));
      held_[i] = std::max(0.0, held_[i] - stiffness * gap);
    }
    return worst;
  }

  double depth() {
    const PoseProgram::Layout& at = program_->layout();
    if (at.checks == 0) return 0.0;
    return std::max(0.0, -Eigen::VectorXd(program_->constraints(x_)).segment(at.first_check, at.checks).minCoeff());
  }

  std::vector<PressedPoint> points() {
    const Chain& chain = program_->chain();
    const Eigen::VectorXd rows = program_->constraints(x_);
    std::vector<PressedPoint> all;
    double farthest = infinity;
    for (int i = 0; i < program_->layout().checks; ++i) {
      const CheckPoint& c = program_->spec().checks[static_cast<std::size_t>(i)];
      if (!all.empty() && all.back().obstacle != c.obstacle) farthest = infinity;
      farthest = std::max(farthest, rows[program_->layout().first_check + i]);
      if (!(held_[i] > tolerance::force)) continue;
      const bool tip = c.piece == chain.piece_count() - 1 && c.sigma == 1.0;
      const double s = chain.start0()[c.piece] + c.sigma * chain.length0()[c.piece];
      all.push_back({c.obstacle, farthest < lying, s, held_[i], tip});
      farthest = 0.0;
    }
    return all;
  }
  void move(const Eigen::VectorXd& step) { x_.head(n_) += scale_ * step; }
  int size() const { return n_; }

  Shape shape() {
    program_->constraints(x_);
    return {basis_, program_->backbone(), x_.head(n_)};
  }

  std::vector<PressedRun> runs(double stiffness) {
    const PoseProgram::Layout& at = program_->layout();
    const Eigen::VectorXd rows = program_->constraints(x_);
    const Chain& chain = program_->chain();
    const std::vector<CheckPoint>& checks = program_->spec().checks;
    std::vector<PressedRun> all;
    for (int o = 0; o < static_cast<int>(path_.obstacles().size()); ++o) {
      int previous = -3;
      int station = -1;
      for (int i = 0; i < at.checks; ++i) {
        const CheckPoint& c = checks[static_cast<std::size_t>(i)];
        if (c.obstacle != o) continue;
        ++station;
        const double depth = -rows[at.first_check + i];
        if (!(depth > 0.0)) continue;
        const double s = chain.start0()[c.piece] + c.sigma * chain.length0()[c.piece];
        const bool tip = c.piece == chain.piece_count() - 1 && c.sigma == 1.0;
        if (station > previous + 2) {
          PressedRun run;
          run.contact.setup.obstacle = o;
          run.from = s;
          all.push_back(run);
        }
        previous = station;
        PressedRun& run = all.back();
        const double force = stiffness * depth;
        run.contact.s = (run.contact.s * run.contact.force + s * force) / (run.contact.force + force);
        run.contact.force += force;
        run.to = s;
        // At the tip nothing lies beyond: a run that presses hardest there ends there.
        run.contact.setup.at_tip = tip && force > 0.5 * run.contact.force;
      }
    }
    return all;
  }

 private:
  PoseProgramSpec spec() const {
    PoseProgramSpec s;
    s.rod = &path_.rod();
    s.model = basis_.get();
    s.obstacles = path_.obstacles();
    s.nodes = suggested_nodes(basis_->function_count(), 4.0);
    const Chain chain(path_.rod(), *basis_, {}, 1);
    for (int o = 0; o < static_cast<int>(s.obstacles.size()); ++o) {
      if (s.obstacles[static_cast<std::size_t>(o)]->at(path_.rod().base).distance > 1.0) continue;
      for (int j = 0; j < chain.piece_count(); ++j) {
        const double wanted =
            chain.length0()[j] *
            std::max<double>(checks_per_rod, 2.0 / s.obstacles[static_cast<std::size_t>(o)]->smallest_radius());
        const int count = std::clamp(static_cast<int>(std::ceil(wanted)), 2, 200);
        for (int i = 1; i <= count; ++i) s.checks.push_back({j, static_cast<double>(i) / count, o});
      }
    }
    return s;
  }

  /// Pi (model.md section 3), up to a constant, of the point computed last.
  double potential(const Eigen::VectorXd& x) {
    const Rod& rod = path_.rod();
    const Chain& chain = program_->chain();
    const Backbone& shape = program_->backbone();
    double sum = -dot(rod.tip_force, shape.tip());
    double mass = rod.payload;
    for (int j = chain.piece_count() - 1; j >= 0; --j) {
      const Chain::Piece& piece = chain.piece(j);
      const double h = shape.length(j);
      const Eigen::Map<const Eigen::VectorXd> q(shape.coordinates(j), chain.functions());
      double moment = piece.stiffness * piece.rest_curvature;
      for (int a = 0; a < chain.actuator_count(); ++a) {
        if (chain.actuated(a, j)) moment += x[program_->moment_variable(a)];
      }
      sum += 0.5 * piece.stiffness / h * q.dot(chain.table().stiffness * q) - moment * chain.table().end.dot(q);
      if (rod.gravity == Vec2{}) continue;
      for (int g = 0; g < chain.nodes(); ++g) {
        const double beyond = mass + piece.weight * h * (1.0 - chain.table().sigma[g]);
        sum -= h * chain.table().weight[g] * beyond * dot(rod.gravity, shape.tangent(j, g));
      }
      mass += piece.weight * h;
    }
    return sum;
  }

  const LoadPath& path_;
  std::shared_ptr<const CoordinateModel> basis_;
  std::unique_ptr<PoseProgram> program_;
  int n_ = 0;
  Eigen::VectorXd x_;
  Eigen::VectorXd held_;  ///< forces of the check points that the penalty does not have to bring up
  Eigen::MatrixXd scale_;
};

/// The minimizer of the quadratic model within the radius. With a flat slope along a way down the sign is free.
Eigen::VectorXd trust_step(const Eigen::VectorXd& slopes, const Eigen::VectorXd& bends, double radius) {
  const auto length = [&](double shift) { return (slopes.array() / (bends.array() + shift)).matrix().norm(); };
  const double lowest = bends[0];
  if (lowest > 0.0 && length(0.0) <= radius) return (-slopes.array() / bends.array()).matrix();
  double low = std::max(0.0, -lowest) + 1e-14 * (1.0 + std::abs(lowest));
  if (length(low) <= radius) {
    Eigen::VectorXd step = (-slopes.array() / (bends.array() + low)).matrix();
    step[0] += (slopes[0] > 0.0 ? -1.0 : 1.0) * std::sqrt(std::max(0.0, radius * radius - step.squaredNorm()));
    return step;
  }
  double high = low + slopes.norm() / radius + 1.0;
  for (int i = 0; i < 100 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (length(middle) > radius ? low : high) = middle;
  }
  return (-slopes.array() / (bends.array() + high)).matrix();
}

Descent go_down(Valley& valley, const std::function<bool()>& must_stop, bool rigid) {
  Descent result;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  double stiffness = first_stiffness;
  double radius = 0.1;
  for (int round = 0;;) {
    bool settled = false;
    for (int step = 0; step < most_steps && !settled; ++step) {
      if (must_stop()) {
        result.reason = "stopped";
        return result;
      }
      valley.derivatives(stiffness, gradient, hessian);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(hessian);
      if (eigen.info() != Eigen::Success || !gradient.allFinite()) {
        result.reason = "the energy is not finite";
        return result;
      }
      const Eigen::VectorXd slopes = eigen.eigenvectors().transpose() * gradient;
      if (gradient.norm() <= flat * (1.0 + std::sqrt(stiffness) * 1e-3) && eigen.eigenvalues()[0] > downward) {
        settled = true;
        break;
      }
      const double before = valley.energy(nullptr, stiffness);
      for (;;) {
        const Eigen::VectorXd in_modes = trust_step(slopes, eigen.eigenvalues(), radius);
        const double promised =
            -(slopes.dot(in_modes) + 0.5 * in_modes.dot(eigen.eigenvalues().cwiseProduct(in_modes)));
        const Eigen::VectorXd moved = eigen.eigenvectors() * in_modes;
        const double gained = before - valley.energy(&moved, stiffness);
        // Below the rounding of the energy the model is better than the difference.
        const bool rounding = promised <= 1e-13 * (1.0 + std::abs(before));
        if (gained >= 0.1 * promised || (rounding && std::abs(gained) <= 1e-12 * (1.0 + std::abs(before)))) {
          valley.move(moved);
          if (gained > 0.7 * promised) radius = std::min(longest_step, 2.0 * radius);
          break;
        }
        radius *= 0.25;
        if (radius < 1e-10) {
          settled = true;
          break;
        }
      }
      radius = std::max(radius, 1e-6);
    }
    if (!settled) {
      result.reason = "the way down does not end";
      return result;
    }
    result.gradient = gradient.norm();
    if (stiffness < last_stiffness) {
      stiffness *= 10.0;
      continue;
    }
    // The multipliers of a stiff penalty converge by a digit or more per round.
    if (!rigid || valley.hold(stiffness) <= rigid_enough || ++round >= most_rounds) break;
  }
  if (rigid) {
    result.points = valley.points();
    result.depth = valley.depth();
  }
  result.converged = true;
  result.stiffness = stiffness;
  result.shape = valley.shape();
  result.runs = valley.runs(stiffness);
  result.energy = valley.energy(nullptr, stiffness);
  return result;
}

}  // namespace

Descent descend(const LoadPath& path, const std::function<double(double)>& curvature,
                const std::function<bool()>& must_stop, bool rigid) {
  const auto stretches = static_cast<int>(path.rod().fixed_knots().size()) - 1;
  const auto basis =
      std::make_shared<const LegendreBasis>(fine_order, std::max(1, (pieces_per_rod + stretches - 1) / stretches));
  Valley valley(path, basis);
  valley.start(curvature);
  Descent result = go_down(valley, must_stop, rigid);
  result.basis = basis;
  return result;
}

Descent descend_in(const CoordinateModel& model, const LoadPath& path, const std::function<double(double)>& curvature,
                   const std::function<bool()>& must_stop) {
  Valley valley(path, {std::shared_ptr<const CoordinateModel>(), &model});
  valley.start(curvature);
  return go_down(valley, must_stop, false);
}

}  // namespace tendril
