#include "tendril/sensitivity.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "nlp/polish.hpp"
#include "problem/scene_numbers.hpp"
#include "problem/uncertainties.hpp"
#include "program/equations.hpp"
#include "program/motion.hpp"
#include "program/stability.hpp"
#include "rod/places.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "search/contacts.hpp"
#include "search/earlier_plan.hpp"
#include "search/task.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/error.hpp"
#include "tendril/numbers.hpp"
#include "tendril/problem.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// The backbone's points of which derivatives are told, beside its base.
constexpr int shape_points = 20;
/// Reciprocal condition of a system below which it has no solution that means anything.
constexpr double singular_below = 1e-15;
/// A plan's own point moves by no more than rounding where Newton's method is run on it.
constexpr double same_point = 1e-6;
/// A multiplier or a force smaller than that holds nothing: whether it acts is not decided.
constexpr double weak = 1e-7;
/// A row is active within this.
constexpr double active_within = 1e-9;

/// A plan's point in a program of its own, which is differentiated.
struct PlanPoint {
  const Scene& scene;
  const Scale& scale;
  const Rod& rod;
  PoseProgram& program;
  Eigen::VectorXd x;
  double objective_scale = 1.0;
  std::vector<int> term_of{};  ///< of each objective of the scene; -1: left out
};

/// Derivatives of a program's point by numbers of its scene.
class Differentiator {
 public:
  explicit Differentiator(PlanPoint& point)
      : p_(point),
        at_(point.program.layout()),
        places_(point.rod, point.program.chain(), at_.arc_lengths),
        multipliers_(Eigen::VectorXd::Zero(point.program.row_count())),
        stability_(point.program) {
    find_shape();
  }

  /// Held moments: the equations alone decide. In words why they do not; empty: they do.
  std::string hold();
  /// Planned anew: the first-order conditions of the active set at given multipliers.
  std::string replan(const PolishReport& polished);
  void describe(Sensitivity& out) const;
  Sensitivity::Column column(const SceneEntry& entry);

 private:
  void find_shape();
  std::string find_rates(const SceneChange& change, ProgramRates& rates);
  void add_rod_rates(const SceneChange& change, ProgramRates& rates);
  /// In words why there are none; empty: there are.
  std::string add_objective_rates(const SceneChange& change, ProgramRates& rates);
  /// Rates of all variables.
  Eigen::VectorXd follow(const SceneChange& change, const ProgramRates& rates);
  double bound_rate(const SceneChange& change, int variable) const;
  double turning(const Motion& base, const Eigen::VectorXd& rate);

  PlanPoint& p_;
  const PoseProgram::Layout& at_;
  Places places_;
  int tip_ = 0;
  std::vector<int> shape_;
  Eigen::VectorXd row_, multipliers_;
  Eigen::MatrixXd shape_rows_;               ///< of x and y of the shape's points in turn, by the variables
  std::vector<int> free_, active_, pinned_;  ///< variables, rows, variables at a bound
  std::vector<bool> at_upper_;               ///< of the pinned ones
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::MatrixXd hessian_;
  std::optional<Equations> equations_;
  std::unique_ptr<MotionRates> moving_;
  Stability stability_;
  Eigen::VectorXd margin_slope_;
  double margin_ = infinity;
  bool replanned_ = false;
};

/// Places that stay in their pieces, all at once; where a piece moves with a contact they are taken back along the rod
/// to their arc lengths.
void Differentiator::find_shape() {
  const Chain& chain = p_.program.chain();
  const std::span<const double> knots = p_.program.knots(p_.x);
  std::vector<Places::Station> stations;
  std::vector<double> sigma;
  for (int i = 1; i < shape_points; ++i) {
    const double s = static_cast<double>(i) / shape_points;
    const int piece = chain.piece_at(s, knots);
    sigma.push_back((s - chain.start(piece, knots)) / chain.length(piece, knots));
    stations.push_back({piece, sigma.back()});
  }
  shape_ = places_.add_stations(stations);
  tip_ = places_.add_tip();
  places_.move(p_.x.head(at_.coordinates),
               {p_.x.data() + at_.first_arc_length, static_cast<std::size_t>(at_.arc_lengths)});
  places_.differentiate();
  const auto count = static_cast<Eigen::Index>(sigma.size());
  Eigen::MatrixXd value(count, chain.bends()), first = value, second = value;
  chain.model().evaluate(sigma, value, first, second);
  row_.setZero(p_.program.variable_count());
  shape_rows_.resize(p_.program.variable_count(), 2 * count + 2);
  for (Eigen::Index i = 0; i <= count; ++i) {
    const bool at_tip = i == count;
    const int place = at_tip ? tip_ : shape_[static_cast<std::size_t>(i)];
    const int piece = at_tip ? 0 : stations[static_cast<std::size_t>(i)].piece;
    const double angle = at_tip ? 0.0
                                : places_.backbone().knot_angle(piece) +
                                      value.row(i).dot(p_.x.segment(piece * chain.functions(), chain.bends()));
    for (const int axis : {0, 1}) {
      row_.setZero();
      places_.row(place, axis == 0 ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0},
                  {row_.data(), row_.data() + at_.first_arc_length});
      const double along = axis == 0 ? std::cos(angle) : std::sin(angle);
      for (int l = 0; l < at_.arc_lengths && !at_tip; ++l) {
        row_[at_.first_arc_length + l] -= along * places_.running(place, l);
      }
      shape_rows_.col(2 * i + axis) = row_;
    }
  }
  shape_.push_back(tip_);
}

std::string Differentiator::hold() {
  equations_.emplace(Equations::of_contacts(p_.program));
  if (!equations_->evaluate(p_.x)) return "the plan's equations are not finite";
  if (equations_->size() > 0 && !(equations_->residual().cwiseAbs().maxCoeff() <= same_point)) {
    return "it is no equilibrium of this scene";
  }
  for (int k = 0; k < at_.forces; ++k) {
    if (!(p_.x[p_.program.force_variable(k)] > weak)) {
      return "contact " + std::to_string(k + 1) + " touches without pressing: one side's derivative is not the other's";
    }
  }
  if (equations_->size() > 0 && !(equations_->factor().rcond() > singular_below)) {
    return "the equilibrium is at a fold: it has no derivative";
  }
  margin_slope_.setZero(p_.program.variable_count());
  if (p_.program.has_friction()) {
    margin_ = stability_.margin(p_.program, p_.x);
    return "";
  }
  margin_ = stability_.margin(p_.program, p_.x, margin_slope_);
  multipliers_ = stability_.multipliers();
  return "";
}

std::string Differentiator::replan(const PolishReport& polished) {
  replanned_ = true;
  multipliers_ = polished.multipliers;
  const double size = 1.0 + (multipliers_.size() > 0 ? multipliers_.cwiseAbs().maxCoeff() : 0.0);
  const VectorView c = p_.program.constraints(p_.x);
  const auto undecided = [](const std::string& what) {
    return what + " is met, but holds nothing: one side's derivative is not the other's";
  };
  for (int i = 0; i < p_.program.row_count(); ++i) {
    const bool equation = p_.program.is_equality(i);
    const bool met =
        c[i] <= p_.program.row_lower()[i] + active_within || c[i] >= p_.program.row_upper()[i] - active_within;
    if (!equation && !met) continue;
    if (!equation && !(std::abs(multipliers_[i]) > weak * size)) return undecided(p_.program.row_name(i));
    active_.push_back(i);
  }
  for (int v = 0; v < p_.program.variable_count(); ++v) {
    const double low = p_.program.lower()[v];
    const double high = p_.program.upper()[v];
    if (p_.x[v] > low + active_within && p_.x[v] < high - active_within) {
      free_.push_back(v);
      continue;
    }
    if (low != high && !(std::abs(polished.bound_multipliers[v]) > weak * size)) {
      return undecided("the limit of " + p_.program.variable_name(v));
    }
    pinned_.push_back(v);
    at_upper_.push_back(p_.x[v] >= high - active_within);
  }
  hessian_ = p_.program.hessian(p_.x, 1.0, multipliers_);
  const MatrixView jacobian = p_.program.jacobian(p_.x);
  const auto nf = static_cast<Eigen::Index>(free_.size());
  const auto na = static_cast<Eigen::Index>(active_.size());
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(nf + na, nf + na);
  for (Eigen::Index i = 0; i < nf; ++i) {
    const int v = free_[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < nf; ++k) kkt(k, i) = hessian_(free_[static_cast<std::size_t>(k)], v);
    for (Eigen::Index r = 0; r < na; ++r) {
      kkt(nf + r, i) = kkt(i, nf + r) = jacobian(active_[static_cast<std::size_t>(r)], v);
    }
  }
  if (nf + na > 0) factors_.compute(kkt);
  if (nf + na > 0 && !(factors_.rcond() > singular_below)) {
    return "other moments are as good as these: the plan has no derivative (an objective that weighs the moments makes "
           "them one)";
  }
  return "";
}

void Differentiator::add_rod_rates(const SceneChange& change, ProgramRates& rates) {
  const std::vector<PoseProgramTerm>& terms = p_.program.spec().terms;
  const bool terms_see_it =
      std::any_of(terms.begin(), terms.end(), [](const PoseProgramTerm& t) { return t.term->reads().bending_energy; });
  const auto add = [&](double share, double factor) {
    const Rod rod = change.rod(share);
    PoseProgramSpec spec = p_.program.spec();
    if (!terms_see_it) spec.terms.clear();
    spec.rod = &rod;
    PoseProgram changed(spec);
    rates.rows += factor * changed.constraints(p_.x);
    if (!replanned_ && !std::isfinite(margin_)) return;
    rates.slope.noalias() += factor * (changed.jacobian(p_.x).transpose() * multipliers_);
    if (replanned_) {
      rates.slope += factor * changed.gradient(p_.x);
      rates.cost += factor * changed.cost(p_.x);
      return;
    }
    for (int k = 0; k < at_.forces; ++k) {
      if (p_.program.spec().contacts[static_cast<std::size_t>(k)].at_tip) continue;
      rates.convexities[k] += factor * (changed.contact_convexity(k) - p_.program.contact_convexity(k));
    }
    rates.energy += factor * (stability_.energy(changed) - stability_.energy(p_.program));
  };
  if (terms_see_it) {
    add(1.0, 0.5 / change.step);
    add(-1.0, -0.5 / change.step);
    return;
  }
  add(1.0, 1.0 / change.step);
  rates.rows -= (1.0 / change.step) * p_.program.constraints(p_.x);
  rates.slope.noalias() -= (1.0 / change.step) * (p_.program.jacobian(p_.x).transpose() * multipliers_);
}

std::string Differentiator::add_objective_rates(const SceneChange& change, ProgramRates& rates) {
  if (change.objective >= 0) {
    // The sum of terms is linear in their weights.
    PoseProgramSpec spec = p_.program.spec();
    const int term = p_.term_of[static_cast<std::size_t>(change.objective)];
    spec.terms = {spec.terms[static_cast<std::size_t>(term)]};
    spec.terms.front().weight = 1.0 / p_.objective_scale;
    PoseProgram alone(spec);
    rates.slope += alone.gradient(p_.x);
    rates.cost += alone.cost(p_.x);
  }
  if (change.target == Vec2{} && change.target_angle == 0.0) return "";
  // Of terms that are quadratic in the target the gradient is affine in it, and both differences are exact.
  Eigen::VectorXd bend = -2.0 * p_.program.gradient(p_.x);
  const Target target = p_.program.spec().target;
  const auto add = [&](double share, double factor) {
    Target moved = target;
    moved.position += share * change.target;
    moved.angle += share * change.target_angle;
    p_.program.set_target(moved);
    rates.slope += factor * p_.program.gradient(p_.x);
    rates.cost += factor * p_.program.cost(p_.x);
    bend += p_.program.gradient(p_.x);
  };
  const double step = 1.0 / std::max(norm(change.target), std::abs(change.target_angle));
  add(step, 0.5 / step);
  add(-step, -0.5 / step);
  p_.program.set_target(target);
  const bool affine = bend.cwiseAbs().maxCoeff() <= 1e-9 * (1.0 + p_.program.gradient(p_.x).cwiseAbs().maxCoeff());
  return affine ? "" : "an objective is not quadratic in the target";
}

std::string Differentiator::find_rates(const SceneChange& change, ProgramRates& rates) {
  rates.slope.setZero(p_.program.variable_count());
  rates.rows.setZero(p_.program.row_count());
  rates.cost = 0.0;
  rates.convexities.setZero(replanned_ ? 0 : at_.forces);
  if (change.moves) {
    if (!moving_) {
      moving_ = std::make_unique<MotionRates>(p_.program.spec());
      moving_->move(p_.x);
      moving_->weigh(multipliers_);
    }
    if (std::string why = moving_->add(change.motion, rates); !why.empty()) return why;
  }
  if (change.rod) add_rod_rates(change, rates);
  return replanned_ ? add_objective_rates(change, rates) : "";
}

double Differentiator::bound_rate(const SceneChange& change, int variable) const {
  const auto i = static_cast<std::size_t>(std::find(pinned_.begin(), pinned_.end(), variable) - pinned_.begin());
  if (variable >= at_.first_force) return at_upper_[i] ? change.most_force : change.least_force;
  if (variable >= at_.first_arc_length) return 0.0;
  for (std::size_t a = 0; a < p_.rod.actuators.size(); ++a) {
    if (p_.program.moment_variable(static_cast<int>(a)) != variable) continue;
    const std::vector<double>& rates = at_upper_[i] ? change.highest : change.lowest;
    return rates.empty() ? 0.0 : rates[a];
  }
  return 0.0;
}

Eigen::VectorXd Differentiator::follow(const SceneChange& change, const ProgramRates& rates) {
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(p_.program.variable_count());
  const MatrixView jacobian = p_.program.jacobian(p_.x);
  if (!replanned_) {
    const double unit = change.length - change.stiffness;
    for (std::size_t a = 0; a < p_.rod.actuators.size(); ++a) {
      const int v = p_.program.moment_variable(static_cast<int>(a));
      if (v < 0) continue;
      rate[v] = unit * p_.x[v] + (change.actuator == static_cast<int>(a) ? change.held : 0.0);
    }
    const Eigen::VectorXd rows = rates.rows + jacobian * rate;
    Eigen::VectorXd right(equations_->size());
    for (int r = 0; r < equations_->size(); ++r) right[r] = -rows[equations_->row(r)];
    if (right.size() > 0) right = equations_->factors().solve(right);
    for (int r = 0; r < equations_->size(); ++r) rate[equations_->unknown(r)] = right[r];
    return rate;
  }
  for (const int v : pinned_) rate[v] = bound_rate(change, v);
  const Eigen::VectorXd slope = rates.slope + hessian_ * rate;
  const Eigen::VectorXd rows = rates.rows + jacobian * rate;
  const auto nf = static_cast<Eigen::Index>(free_.size());
  Eigen::VectorXd right(nf + static_cast<Eigen::Index>(active_.size()));
  for (Eigen::Index i = 0; i < nf; ++i) right[i] = -slope[free_[static_cast<std::size_t>(i)]];
  for (Eigen::Index r = nf; r < right.size(); ++r) right[r] = -rows[active_[static_cast<std::size_t>(r - nf)]];
  if (right.size() > 0) right = factors_.solve(right);
  for (Eigen::Index i = 0; i < nf; ++i) rate[free_[static_cast<std::size_t>(i)]] = right[i];
  return rate;
}

double Differentiator::turning(const Motion& base, const Eigen::VectorXd& rate) {
  row_.setZero();
  places_.angle_row(tip_, {row_.data(), row_.data() + at_.first_arc_length});
  return base.turn + row_.dot(rate);
}

void Differentiator::describe(Sensitivity& out) const {
  const Scale& scale = p_.scale;
  const auto add = [&](std::string name, const char* unit, double value) {
    out.quantities.push_back({std::move(name), unit, value});
  };
  const Vec2 tip = scale.length * places_.point(tip_);
  add("tip.x", "m", tip.x);
  add("tip.y", "m", tip.y);
  add("tip.angle", "rad", places_.angle(tip_));
  for (int k = 0; k < at_.forces; ++k) {
    const std::string contact = "contacts[" + std::to_string(k) + "].";
    add(contact + "force", "N", scale.force() * p_.x[p_.program.force_variable(k)]);
    const int s = p_.program.arc_length_variable(k);
    if (s >= 0) add(contact + "arc_length", "m", scale.length * p_.x[s]);
  }
  out.margin = margin_;
  for (int i = 1; i <= shape_points; ++i) {
    out.arc_lengths.push_back(scale.length * static_cast<double>(i) / shape_points);
  }
  if (!replanned_) return;
  for (std::size_t a = 0; a < p_.rod.actuators.size(); ++a) {
    const int v = p_.program.moment_variable(static_cast<int>(a));
    if (v >= 0) add("moments[" + std::to_string(a) + "]", "N m", scale.moment() * p_.x[v]);
  }
  add("objective", "", p_.objective_scale * p_.program.cost(p_.x));
}

Sensitivity::Column Differentiator::column(const SceneEntry& entry) {
  Sensitivity::Column out;
  out.number = entry.number;
  const SceneChange change = entry.change();
  out.trouble = change.trouble;
  if (!out.trouble.empty()) return out;
  ProgramRates rates;
  out.trouble = find_rates(change, rates);
  if (!out.trouble.empty()) return out;
  const Eigen::VectorXd rate = follow(change, rates);
  const Scale& scale = p_.scale;
  const Motion& base = change.motion.base;
  // What is known in units that follow the number.
  const auto si = [&](const Dimension& d, double value, double by) {
    const double unit_rate = d.length * change.length + d.force * (change.stiffness - 2.0 * change.length);
    return scale.unit(d) * (by + unit_rate * value);
  };
  const Eigen::VectorXd moving = shape_rows_.transpose() * rate;
  const double metre = scale.unit(dimension::length);
  for (std::size_t i = 0; i < shape_.size(); ++i) {
    const Vec2 point = places_.point(shape_[i]);
    const auto row = static_cast<Eigen::Index>(2 * i);
    out.shape.push_back(metre * (base.at(point) + Vec2{moving[row], moving[row + 1]} + change.length * point));
  }
  const Vec2 tip = out.shape.back();
  out.rates = {tip.x, tip.y, turning(base, rate)};
  for (int k = 0; k < at_.forces; ++k) {
    const int f = p_.program.force_variable(k);
    out.rates.push_back(si(dimension::force, p_.x[f], rate[f]));
    const int s = p_.program.arc_length_variable(k);
    if (s >= 0) out.rates.push_back(si(dimension::length, p_.x[s], rate[s]));
  }
  if (std::isfinite(margin_)) out.margin = margin_slope_.dot(rate) + stability_.rate(rates);
  if (!replanned_) return out;
  for (std::size_t a = 0; a < p_.rod.actuators.size(); ++a) {
    const int v = p_.program.moment_variable(static_cast<int>(a));
    if (v >= 0) out.rates.push_back(si(dimension::moment, p_.x[v], rate[v]));
  }
  out.rates.push_back(p_.objective_scale * (rates.cost + p_.program.gradient(p_.x).dot(rate)));
  return out;
}

void add_columns(Differentiator& point, const std::vector<SceneEntry>& entries, const std::vector<std::string>& keys,
                 Sensitivity& out) {
  point.describe(out);
  for (const std::string& key : keys) {
    if (std::none_of(entries.begin(), entries.end(), [&](const SceneEntry& e) { return e.number.key == key; })) {
      throw Error("the scene has no number '" + key + "' to differentiate by");
    }
  }
  for (const SceneEntry& entry : entries) {
    const bool asked = keys.empty() || std::find(keys.begin(), keys.end(), entry.number.key) != keys.end();
    if (asked) out.columns.push_back(point.column(entry));
  }
}

void add_held_moments(std::vector<SceneEntry>& entries, const PlanPoint& point) {
  for (std::size_t a = 0; a < point.rod.actuators.size(); ++a) {
    const int v = point.program.moment_variable(static_cast<int>(a));
    if (v < 0) continue;
    entries.push_back(
        held_moment(point.scene, point.scale, point.rod, static_cast<int>(a), point.scale.moment() * point.x[v]));
  }
}

/// The scene with its rod clamped where a result has moved it to: while that is held nothing tells it from this one.
Scene standing(const Scene& scene, const Plan& plan) {
  Scene out = scene;
  out.rod.base_position_range.reset();
  out.rod.base_angle_range.reset();
  if (!plan.place.base) return out;
  out.rod.base_position = plan.place.base->position;
  out.rod.base_angle = plan.place.base->angle;
  return out;
}

/// Why a result is not differentiated, whatever the program says.
std::string refused(const Plan& plan, const Rod& rod) {
  if (plan.status != PlanStatus::solved) return "the result is not solved, so that there is nothing to differentiate";
  if (plan.grasp) return "grasps are not differentiated";
  if (std::any_of(plan.contacts.begin(), plan.contacts.end(),
                  [](const PlannedContact& c) { return c.sticks || c.tangential != 0.0; })) {
    return "contacts that stick or slip are not differentiated: the path by which they came counts";
  }
  if (const std::string why = undifferentiated(rod); !why.empty()) return why;
  if (plan.place.insertion) return "rods that are drawn into a port are not differentiated";
  if (plan.certificate.stability < tolerance::held_margin * 1.5) {
    return "the margin of stability is " + shown(plan.certificate.stability) +
           ": at the limit of stability results have no derivative";
  }
  return "";
}

Sensitivity differentiate_held(PlanPoint point, const std::vector<std::string>& keys) {
  Sensitivity out;
  out.kind = SensitivityKind::held;
  for (int k = 0; k < point.program.layout().forces; ++k) point.program.set_branch(k, Branch::touching);
  Differentiator differentiator(point);
  out.trouble = differentiator.hold();
  if (!out.trouble.empty()) return out;
  std::vector<SceneEntry> entries = scene_entries(point.scene, point.scale, point.rod, keys);
  add_held_moments(entries, point);
  add_columns(differentiator, entries, keys, out);
  return out;
}

/// Newton's method on the equations; false: it does not end next to where it began.
bool settle(PoseProgram& program, Eigen::VectorXd& x) {
  Equations equations = Equations::of_contacts(program);
  const Eigen::VectorXd start = x;
  for (int i = 0; i < 4; ++i) {
    if (!equations.evaluate(x)) return false;
    const Eigen::VectorXd step = equations.factor().solve(equations.residual());
    for (int r = 0; r < equations.size(); ++r) x[equations.unknown(r)] -= step[r];
  }
  return x.allFinite() && (x - start).cwiseAbs().maxCoeff() <= same_point * (1.0 + start.cwiseAbs().maxCoeff());
}

}  // namespace

std::string_view to_string(SensitivityKind kind) { return kind == SensitivityKind::held ? "held" : "replanned"; }

const Sensitivity::Column* Sensitivity::find(std::string_view key) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.number.key == key; });
  return found == columns.end() ? nullptr : &*found;
}

Sensitivity Problem::sensitivity(const Plan& plan, SensitivityKind kind, const std::vector<std::string>& keys) {
  Task& d = *task_;
  Sensitivity out;
  out.kind = kind;
  out.trouble = refused(plan, d.rod);
  if (!out.trouble.empty()) return out;
  d.face(plan.tip_angle);
  // What holds a plan back decides nothing where its moments are held.
  const std::optional<FollowedPoint> found = followed_point(d, plan, kind == SensitivityKind::replanned);
  if (!found) {
    out.trouble = "the plan is not of this scene, or a contact touches without pressing";
    return out;
  }
  PoseProgramSpec spec = d.spec(found->mode, found->regions, d.nodes);
  spec.checks = found->checks;
  std::vector<int> term_of;
  int next = 0;
  for (const ObjectiveSpec& objective : d.scene.objectives) term_of.push_back(needs_term(objective) ? next++ : -1);
  if (kind == SensitivityKind::held) {
    const Scene held = standing(d.scene, plan);
    const Rod rod = make_rod(held, d.scale);
    spec.rod = &rod;
    PoseProgram alone(Equations::alone(spec));
    // What the base is moved by is no variable any more.
    const PoseProgram::Layout& at = alone.layout();
    Eigen::VectorXd x(alone.variable_count());
    x << found->x.head(at.first_move), found->x.tail(x.size() - at.first_move);
    return differentiate_held({held, d.scale, rod, alone, x}, keys);
  }
  if (!d.rod.moves.empty()) {
    out.trouble = "plans that choose where the base stands are differentiated with all held only";
    return out;
  }
  if (d.uncertainties) {
    out.trouble = "an objective reads the error bars, by which plans are not differentiated";
    return out;
  }
  PoseProgram program(spec);
  for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, Branch::touching);
  const PolishReport polished = polish(program, found->x, {});
  if (!polished.converged ||
      !((polished.x - found->x).cwiseAbs().maxCoeff() <= same_point * (1.0 + found->x.cwiseAbs().maxCoeff()))) {
    out.trouble = "the plan is no isolated optimum of its active set, so that it has no derivative";
    return out;
  }
  if (spec.tolerance.any()) {
    out.trouble = "the target has a tolerance, by which plans are not differentiated";
    return out;
  }
  PlanPoint point{d.scene, d.scale, d.rod, program, polished.x, d.objective_scale, term_of};
  Differentiator differentiator(point);
  out.trouble = differentiator.replan(polished);
  if (out.trouble.empty()) add_columns(differentiator, scene_entries(d.scene, d.scale, d.rod, keys), keys, out);
  return out;
}

Sensitivity sensitivity_of(const Scene& as_written, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                           const Plan& executed, const std::vector<std::string>& keys) {
  Sensitivity out;
  const Scene scene = standing(as_written, executed);
  out.kind = SensitivityKind::held;
  const Scale scale = scale_of(scene);
  const Rod rod = make_rod(scene, scale);
  out.trouble = refused(executed, rod);
  const bool extended = std::any_of(executed.contacts.begin(), executed.contacts.end(),
                                    [](const PlannedContact& c) { return c.extended; });
  if (out.trouble.empty() && extended) out.trouble = "the rod lies along an obstacle, which is not differentiated";
  if (!out.trouble.empty()) return out;
  PoseProgramSpec spec;
  spec.rod = &rod;
  for (const std::unique_ptr<Obstacle>& o : obstacles) spec.obstacles.push_back(o.get());
  const std::vector<double> knots = rod.fixed_knots();
  std::size_t stretches = knots.size() - 1;
  for (const PlannedContact& c : executed.contacts) {
    ContactSetup setup;
    setup.obstacle = c.obstacle;
    setup.at_tip = c.at_tip;
    if (!c.at_tip) {
      setup.region = stretch_at(rod, c.arc_length / scale.length);
      ++stretches;
    }
    spec.contacts.push_back(setup);
  }
  const auto pieces = executed.coordinates.size() / (static_cast<std::size_t>(executed.order) * stretches);
  const LegendreBasis basis(executed.order, std::max(1, static_cast<int>(pieces)));
  spec.model = &basis;
  spec.nodes = suggested_nodes(executed.order, 4.0);
  spec.tables = std::make_shared<TableStore>();
  PoseProgram program(spec);
  const PoseProgram::Layout& at = program.layout();
  if (at.coordinates != static_cast<int>(executed.coordinates.size())) throw Error("the result is not of this scene");
  Eigen::VectorXd x = Eigen::VectorXd::Zero(program.variable_count());
  std::copy(executed.coordinates.begin(), executed.coordinates.end(), x.data());
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    const int v = program.moment_variable(static_cast<int>(a));
    if (v >= 0) x[v] = executed.moments[a] / scale.moment();
  }
  for (int k = 0; k < at.forces; ++k) {
    const PlannedContact& c = executed.contacts[static_cast<std::size_t>(k)];
    x[program.force_variable(k)] = c.force / scale.force();
    if (!c.at_tip) x[program.arc_length_variable(k)] = c.arc_length / scale.length;
    program.set_branch(k, Branch::touching);
  }
  if (!settle(program, x)) {
    out.trouble = "the result's equations have no solution next to it";
    return out;
  }
  return differentiate_held({scene, scale, rod, program, x}, keys);
}

}  // namespace tendril
