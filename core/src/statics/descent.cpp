#include "statics/descent.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr int fine_order = 6;                                  ///< functions per piece of the fine basis
constexpr int pieces_per_rod = 8;                              ///< at least, of the fine basis
constexpr int checks_per_rod = 160;                            ///< at least, per obstacle
constexpr int coarse_order = 6;                                ///< functions per stretch, where arcs are let go
constexpr double coarse_stiffness = 1e3, coarse_step = 1.0;    ///< there
constexpr double coarse_end = 0.01;                            ///< there: a step so short is the last one
constexpr int coarse_checks = 40;                              ///< there
constexpr int first_stride = 4;                                ///< of the arcs that are let go whatever the others do
constexpr double same_floor = 0.05;                            ///< two are one, in the metric of the bending energy
constexpr double first_stiffness = 1e4, last_stiffness = 1e7;  ///< of the penalty, energy per length squared
constexpr double longest_step = 0.25;   ///< of the trust region, in the metric of the bending energy
constexpr int most_steps = 600;         ///< per stiffness
constexpr double flat = 1e-9;           ///< gradient in that metric at which a round ends
constexpr double downward = -1e-7;      ///< a lower eigenvalue is a way down
constexpr double rigid_enough = 1e-10;  ///< depth of a check point (L) below which multipliers hold it
constexpr double lying = 1e-5;          ///< distance (L) that a rod which lies along an obstacle does not exceed
constexpr double near_enough = 0.05;    ///< gap (L) that no penalty or multiplier presses at
constexpr int most_rounds = 40;         ///< of multipliers

class Valley {
 public:
  Valley(const LoadPath& path, double load, std::shared_ptr<const CoordinateModel> basis, int checks = checks_per_rod)
      : path_(path), basis_(std::move(basis)), program_(std::make_unique<PoseProgram>(spec(load, checks))) {
    program_->set_loads(path.loads(load));
    const Chain& chain = program_->chain();
    const int functions = chain.functions();
    n_ = chain.coordinate_count();
    held_ = Eigen::VectorXd::Zero(program_->layout().checks + program_->layout().shortenings);
    x_ = Eigen::VectorXd::Zero(program_->variable_count());
    for (int a = 0; a < static_cast<int>(path.rod().actuators.size()); ++a) {
      x_[program_->moment_variable(a)] = path.moment(static_cast<std::size_t>(a), load);
    }
    for (int l = 0; l < program_->layout().moves; ++l) {
      x_[program_->layout().first_move + l] = path.move(static_cast<std::size_t>(l), load);
    }
    program_->constraints(x_);
    // q = T y makes the bending energy |y|^2 / 2.
    scale_ = Eigen::MatrixXd::Zero(n_, n_);
    for (int j = 0; j < chain.piece_count(); ++j) {
      const auto [inverse, factor] = program_->sections().unit(j);
      scale_.block(j * functions, j * functions, functions, functions) = factor * inverse;
    }
  }

  void start(const Curvature& curvature) {
    x_.head(n_) = program_->chain().coordinates_of(curvature, program_->knots(x_), curvature.stretch);
  }

  void start(const Eigen::VectorXd& coordinates) { x_.head(n_) = coordinates; }
  Eigen::VectorXd coordinates() const { return x_.head(n_); }
  /// In the metric of the bending energy.
  double distance(const Eigen::VectorXd& coordinates) const {
    return scale_.partialPivLu().solve(coordinates - x_.head(n_)).norm();
  }

  /// Energy with the penalty at the coordinates kept, moved by `step` in scaled coordinates.
  double energy(const Eigen::VectorXd* step, double stiffness) {
    Eigen::VectorXd x = x_;
    if (step != nullptr) x.head(n_) += scale_ * *step;
    const Eigen::VectorXd rows = program_->constraints(x);
    double sum = program_->potential(x);
    for (int i = 0; i < held_.size(); ++i) {
      const double depth = std::min(0.0, rows[row_of(i)] - held_[i] / stiffness);
      sum += 0.5 * stiffness * depth * depth;
    }
    return sum;
  }

  void derivatives(double stiffness, Eigen::VectorXd& gradient, Eigen::MatrixXd& hessian) {
    const Eigen::VectorXd rows = program_->constraints(x_);
    const MatrixView whole = program_->jacobian(x_);
    const auto jacobian = whole.leftCols(n_);  // of many check points a copy would cost most
    Eigen::VectorXd g = -rows.head(n_);
    Eigen::MatrixXd h = -jacobian.topRows(n_);
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(rows.size());
    bool touches = false;
    for (int i = 0; i < held_.size(); ++i) {
      const int row = row_of(i);
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
    for (int i = 0; i < held_.size(); ++i) {
      const double gap = rows[row_of(i)];
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

  /// Every check point that presses, marked where the rod does not leave the obstacle up to the one beside it.
  std::vector<PointContact> points() {
    const Eigen::VectorXd rows = program_->constraints(x_);
    std::vector<PointContact> all;
    double farthest = infinity;
    for (int i = 0; i < program_->layout().checks; ++i) {
      PointContact c = contact_at(i);
      if (!all.empty() && all.back().setup.obstacle != c.setup.obstacle) farthest = infinity;
      farthest = std::max(farthest, rows[program_->layout().first_check + i]);
      if (!(held_[i] > tolerance::force)) continue;
      c.force = held_[i];
      c.extended = farthest < lying;
      if (c.extended) all.back().extended = true;
      all.push_back(c);
      farthest = 0.0;
    }
    return all;
  }
  void move(const Eigen::VectorXd& step) { x_.head(n_) += scale_ * step; }
  int size() const { return n_; }

  Curvature curvature() {
    program_->constraints(x_);
    return curvature_of(basis_, program_->backbone(), x_.head(n_));
  }

  /// Stretches of check points that the penalty presses on.
  std::vector<PointContact> runs(double stiffness) {
    const PoseProgram::Layout& at = program_->layout();
    const Eigen::VectorXd rows = program_->constraints(x_);
    std::vector<PointContact> all;
    for (int o = 0; o < static_cast<int>(path_.obstacles().size()); ++o) {
      int previous = -3;
      int station = -1;
      for (int i = 0; i < at.checks; ++i) {
        const PointContact c = contact_at(i);
        if (c.setup.obstacle != o) continue;
        ++station;
        const double force = -stiffness * rows[at.first_check + i];
        if (!(force > 0.0)) continue;
        if (station > previous + 2) all.push_back({{o, false, 0}, 0.0, 0.0});
        previous = station;
        PointContact& run = all.back();
        run.s = (run.s * run.force + c.s * force) / (run.force + force);
        run.force += force;
        // At the tip nothing lies beyond: a run that presses hardest there ends there.
        run.setup.at_tip = c.setup.at_tip && force > 0.5 * run.force;
      }
    }
    return all;
  }

  /// Tendons held by their length that the penalty keeps from being longer.
  std::vector<TautTendon> tendons(double stiffness) {
    const Eigen::VectorXd rows = program_->constraints(x_);
    std::vector<TautTendon> all;
    for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
      const int row = program_->shortening_row(a);
      if (row < 0) continue;
      const double held = held_[program_->layout().checks + row - program_->layout().first_shortening];
      const double moment = held - stiffness * rows[row];
      if (moment > 0.0) all.push_back({a, path_.rod().actuators[static_cast<std::size_t>(a)].side() * moment});
    }
    return all;
  }

 private:
  /// Of what is kept from one side: check points, and behind them tendons held by their length.
  int row_of(int i) const {
    const PoseProgram::Layout& at = program_->layout();
    return i < at.checks ? at.first_check + i : at.first_shortening + i - at.checks;
  }

  PointContact contact_at(int check) const {
    const Backbone& rod = program_->backbone();
    const CheckPoint& c = program_->spec().checks[static_cast<std::size_t>(check)];
    const bool tip = c.piece == rod.chain().piece_count() - 1 && c.sigma == 1.0;
    return {{c.obstacle, tip, 0}, rod.start(c.piece) + c.sigma * rod.length(c.piece), 0.0};
  }

  PoseProgramSpec spec(double load, int checks) const {
    PoseProgramSpec s;
    s.rod = &path_.rod();
    s.model = basis_.get();
    s.obstacles = path_.obstacles();
    s.checked_from = near_enough;
    s.nodes = suggested_nodes(basis_->function_count(), 4.0);
    const Chain chain(path_.rod(), *basis_, {}, 1);
    for (int o = 0; o < static_cast<int>(s.obstacles.size()); ++o) {
      const auto at = static_cast<std::size_t>(o);
      const bool far = s.obstacles[at]->at(path_.rod().base).distance > 1.0 + path_.rod().most_radius();
      if (far && !path_.rod().stretches() && path_.rod().moves.empty()) continue;
      for (int j = 0; j < chain.piece_count(); ++j) {
        const double wanted = chain.length0()[j] * std::max<double>(checks, 2.0 / path_.smallest_radius(at, load));
        const int count = std::clamp(static_cast<int>(std::ceil(wanted)), 2, 200);
        for (int i = 1; i <= count; ++i) s.checks.push_back({j, static_cast<double>(i) / count, o});
      }
    }
    return s;
  }

  const LoadPath& path_;
  std::shared_ptr<const CoordinateModel> basis_;
  std::unique_ptr<PoseProgram> program_;
  int n_ = 0;
  Eigen::VectorXd x_;
  Eigen::VectorXd held_;  ///< forces that the penalty does not have to bring up
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

/// One stiffness: steps of a trust-region Newton method until the valley's floor, or until a step down to it is no
/// longer than `near`. Why not, or null.
const char* minimize(Valley& valley, double stiffness, double& radius, double longest, double near,
                     const std::function<bool()>& must_stop, Eigen::VectorXd& gradient) {
  Eigen::MatrixXd hessian;
  Eigen::LLT<Eigen::MatrixXd> factor;
  for (int step = 0; step < most_steps; ++step) {
    if (must_stop()) return "stopped";
    valley.derivatives(stiffness, gradient, hessian);
    if (!gradient.allFinite() || !hessian.allFinite()) return "the energy is not finite";
    const bool convex = factor.compute(hessian).info() == Eigen::Success;
    Eigen::VectorXd down;
    if (convex) down = -factor.solve(gradient);
    // Modes are needed only where the model is not convex, or its minimum too far.
    std::optional<Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>> modes;
    const auto bends = [&]() -> const Eigen::VectorXd& {
      if (!modes) modes.emplace(hessian);
      return modes->eigenvalues();
    };
    const bool is_flat = gradient.norm() <= flat * (1.0 + std::sqrt(stiffness) * 1e-3);
    if ((is_flat && (convex || bends()[0] > downward)) || (convex && down.norm() <= near)) return nullptr;
    const double before = valley.energy(nullptr, stiffness);
    for (;;) {
      Eigen::VectorXd moved = down;
      if (!convex || down.norm() > radius) {
        const Eigen::VectorXd& along = bends();
        moved = modes->eigenvectors() * trust_step(modes->eigenvectors().transpose() * gradient, along, radius);
      }
      const double promised = -(gradient.dot(moved) + 0.5 * moved.dot(hessian * moved));
      const double gained = before - valley.energy(&moved, stiffness);
      // Below the rounding of the energy the model is better than the difference.
      const bool rounding = promised <= 1e-13 * (1.0 + std::abs(before));
      if (gained >= 0.1 * promised || (rounding && std::abs(gained) <= 1e-12 * (1.0 + std::abs(before)))) {
        valley.move(moved);
        if (gained > 0.7 * promised) radius = std::min(longest, 2.0 * radius);
        break;
      }
      radius *= 0.25;
      if (radius >= 1e-10) continue;
      radius = 1e-6;
      return nullptr;
    }
    radius = std::max(radius, 1e-6);
  }
  return "the way down does not end";
}

Descent go_down(Valley& valley, const std::function<bool()>& must_stop, bool rigid) {
  Descent result;
  Eigen::VectorXd gradient;
  double radius = 0.1;
  result.stiffness = first_stiffness;
  for (int round = 0; round < most_rounds;) {
    if (const char* reason = minimize(valley, result.stiffness, radius, longest_step, 0.0, must_stop, gradient)) {
      result.reason = reason;
      return result;
    }
    result.gradient = gradient.norm();
    if (result.stiffness < last_stiffness) {
      result.stiffness *= 10.0;
      continue;
    }
    // The multipliers of a stiff penalty converge by a digit or more per round.
    if (!rigid || valley.hold(result.stiffness) <= rigid_enough) break;
    ++round;
  }
  result.converged = true;
  result.state = {valley.curvature(), rigid ? valley.points() : valley.runs(result.stiffness), 0.0,
                  valley.tendons(result.stiffness)};
  if (rigid) result.depth = valley.depth();
  result.energy = valley.energy(nullptr, result.stiffness);
  return result;
}

}  // namespace

Descent descend(const LoadPath& path, double load, const Curvature& curvature, const std::function<bool()>& must_stop,
                bool rigid) {
  const auto stretches = static_cast<int>(path.rod().fixed_knots().size()) - 1;
  const auto basis =
      std::make_shared<const LegendreBasis>(fine_order, std::max(1, (pieces_per_rod + stretches - 1) / stretches));
  Valley valley(path, load, basis);
  valley.start(curvature);
  Descent result = go_down(valley, must_stop, rigid);
  result.basis = basis;
  return result;
}

std::vector<Descent> descend_from_arcs(const LoadPath& path, double load, double widest, int arcs,
                                       const std::function<bool()>& must_stop) {
  const auto basis = std::make_shared<const LegendreBasis>(coarse_order, 1);
  Valley valley(path, load, basis, coarse_checks);
  std::vector<Eigen::VectorXd> floors;
  std::vector<int> below(static_cast<std::size_t>(arcs), -1);  // of each arc: its floor
  const auto relax = [&](int arc) {
    const double bent = widest * ((2.0 * arc + 1.0) / arcs - 1.0);
    valley.start(Curvature([bent](double) { return bent; }));
    Eigen::VectorXd gradient;
    double radius = coarse_step;
    if (minimize(valley, coarse_stiffness, radius, coarse_step, coarse_end, must_stop, gradient) != nullptr) return;
    const auto same = [&](const Eigen::VectorXd& floor) { return valley.distance(floor) < same_floor; };
    const auto found = std::find_if(floors.begin(), floors.end(), same);
    below[static_cast<std::size_t>(arc)] = static_cast<int>(found - floors.begin());
    if (found == floors.end()) floors.push_back(valley.coordinates());
  };
  for (int stride = first_stride; stride >= 1; stride /= 2) {
    const int apart = stride == first_stride ? stride : 2 * stride;
    for (int arc = stride == first_stride ? 0 : stride; arc < arcs; arc += apart) {
      const auto at = static_cast<std::size_t>(arc);
      const auto by = static_cast<std::size_t>(stride);
      const bool between = stride < first_stride && arc + stride < arcs;
      if (between && below[at - by] == below[at + by]) {
        below[at] = below[at - by];
      } else {
        relax(arc);
      }
    }
  }
  std::vector<Descent> out;
  for (const Eigen::VectorXd& floor : floors) {
    valley.start(floor);
    Descent down = go_down(valley, must_stop, false);
    down.basis = basis;
    if (down.converged) out.push_back(std::move(down));
  }
  return out;
}

Descent descend_in(const CoordinateModel& model, const LoadPath& path, double load, const Curvature& curvature,
                   const std::function<bool()>& must_stop) {
  Valley valley(path, load, {std::shared_ptr<const CoordinateModel>(), &model});
  valley.start(curvature);
  return go_down(valley, must_stop, false);
}

}  // namespace tendril
