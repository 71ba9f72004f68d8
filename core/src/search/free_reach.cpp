#include "search/free_reach.hpp"

#include <algorithm>
#include <cmath>

#include "nlp/newton.hpp"

namespace tendril {
namespace {

constexpr int most_cuts = 16;               ///< for one point
constexpr std::size_t most_cells = 1000;    ///< for all points together
constexpr int steps_per_stretch = 16;       ///< of an upper sum of loads
constexpr double rounding = 1e-7;           ///< units of L: of equilibria and of their quadrature
constexpr double equilibrium_found = 1e-9;  ///< largest residual, EI/L

/// Size of all dead forces beyond arc length s, which falls along the rod.
double pull_beyond(const Rod& rod, double s) {
  double weight = rod.payload;
  double pull = norm(rod.tip_force);
  for (const Rod::Segment& segment : rod.segments) {
    if (segment.to > s) weight += segment.whole_weight() - segment.weight_up_to(std::max(s, segment.from));
  }
  for (const Rod::Load& load : rod.loads) {
    if (load.to < s) continue;
    weight += load.weight;
    pull += norm(load.force) * (load.at_point() ? 1.0 : load.to - std::max(s, load.from));
  }
  return pull + norm(rod.gravity) * weight;
}

}  // namespace

// With C(s) = int_0^s ds/EI a change psi of the angle is at most sqrt(C(s)) times its energy norm, so that the loads
// beyond s take at most int |F| C ds of the bending energy's curvature, and leave `steadiness` of it. The tip moves by
// at most int |psi| ds <= sqrt(int (1 - s)^2 / EI ds) times that norm.
double FreeReach::flexibility(const Rod& rod) {
  const std::vector<double> knots = rod.fixed_knots();
  double compliance = 0.0;
  double steadiness = 1.0;
  double square = 0.0;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double stiffness = rod.segment_at(0.5 * (knots[k] + knots[k + 1])).stiffness;
    square += (std::pow(1.0 - knots[k], 3) - std::pow(1.0 - knots[k + 1], 3)) / (3.0 * stiffness);
    const double h = (knots[k + 1] - knots[k]) / steps_per_stretch;
    for (int i = 0; i < steps_per_stretch; ++i) {
      compliance += h / stiffness;
      steadiness -= h * pull_beyond(rod, knots[k] + i * h) * compliance;
    }
  }
  return steadiness > 0.0 ? std::sqrt(square) / steadiness : infinity;
}

FreeReach::FreeReach(PoseProgramSpec spec)
    : program_(Equations::alone(std::move(spec))), equations_(Equations::of_equilibrium(program_)) {
  const Rod& rod = *program_.spec().rod;
  const PoseProgram::Layout& at = program_.layout();
  for (const Rod::Segment& segment : rod.segments) {
    if (!segment.bends_evenly() || !segment.weighs_evenly()) return;
  }
  Cell whole{Eigen::VectorXd::Zero(program_.variable_count()), {}};
  for (int i = at.first_moment; i < at.first_moment + at.moments; ++i) {
    const double low = program_.lower()[i];
    const double high = program_.upper()[i];
    if (!std::isfinite(high - low)) return;
    whole.x[i] = 0.5 * (low + high);
    whole.spans.push_back(0.5 * (high - low));
  }
  const std::vector<double> knots = rod.fixed_knots();
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double middle = 0.5 * (knots[k] + knots[k + 1]);
    Stretch& stretch = stretches_.emplace_back();
    stretch.compliance = (knots[k + 1] - knots[k]) / rod.segment_at(middle).stiffness;
    for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
      if (rod.actuators[a].varies()) return;
      if (program_.moment_variable(static_cast<int>(a)) >= 0) {
        stretch.levels.push_back(std::abs(rod.actuators[a].at(middle)));
      }
    }
  }
  flexibility_ = flexibility(rod);
  if (flexibility_ < infinity && settle(whole)) cells_.push_back(std::move(whole));
}

double FreeReach::spread(const std::vector<double>& spans) const {
  double square = 0.0;
  for (const Stretch& stretch : stretches_) {
    double bend = 0.0;
    for (std::size_t a = 0; a < spans.size(); ++a) bend += spans[a] * stretch.levels[a];
    square += stretch.compliance * bend * bend;
  }
  return flexibility_ * std::sqrt(square);
}

bool FreeReach::settle(Cell& cell) {
  constexpr int most_steps = 20;
  constexpr double small = 1e-6;
  const int n = equations_.size();
  step_.setZero(cell.x.size());
  const auto correct = [&](const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
    if (!equations_.evaluate(x)) return infinity;
    dx.head(n) = -equations_.factor().solve(equations_.residual());
    return dx.head(n).cwiseAbs().maxCoeff() / (1.0 + x.head(n).cwiseAbs().maxCoeff());
  };
  const auto whole = [](const Eigen::VectorXd&, const Eigen::VectorXd&, double) { return 1.0; };
  if (!newton(cell.x, step_, most_steps, small, correct, whole).converged) return false;
  if (!(equations_.residual_at(cell.x).cwiseAbs().maxCoeff() <= equilibrium_found)) return false;
  cell.tip = program_.backbone().tip();
  cell.spread = spread(cell.spans);
  return true;
}

bool FreeReach::split(std::size_t index) {
  Cell middle = cells_[index];
  std::size_t widest = 0;
  double most = -1.0;
  for (std::size_t a = 0; a < middle.spans.size(); ++a) {
    std::vector<double> alone(middle.spans.size(), 0.0);
    alone[a] = middle.spans[a];
    if (spread(alone) > most) widest = a;
    most = std::max(most, spread(alone));
  }
  if (!(most > 0.0)) return false;
  middle.spans[widest] /= 3.0;
  middle.spread = spread(middle.spans);
  for (const double side : {-2.0, 2.0}) {
    Cell other = middle;
    other.x[program_.layout().first_moment + static_cast<int>(widest)] += side * middle.spans[widest];
    if (!settle(other)) return false;
    cells_.push_back(std::move(other));
  }
  cells_[index] = std::move(middle);
  return true;
}

double FreeReach::least_distance(Vec2 point, const std::function<bool(double)>& enough) {
  const auto to_tip = [&](const Cell& cell) { return norm(cell.tip - point); };
  const auto bound = [&](const Cell& cell) { return to_tip(cell) - cell.spread; };
  for (int cuts = 0; !cells_.empty(); ++cuts) {
    const auto nearest = std::min_element(cells_.begin(), cells_.end(),
                                          [&](const Cell& a, const Cell& b) { return bound(a) < bound(b); });
    const double least = std::max(0.0, bound(*nearest) - rounding);
    const bool can_be = std::all_of(cells_.begin(), cells_.end(), [&](const Cell& c) { return enough(to_tip(c)); });
    if (enough(least) || !can_be || cuts == most_cuts || cells_.size() > most_cells) return least;
    if (!split(static_cast<std::size_t>(nearest - cells_.begin()))) cells_.clear();
  }
  return 0.0;
}

}  // namespace tendril
