// A contact knows its obstacle by where the rod is seen from it. So a motion of an obstacle is the opposite motion of
// the places that touch it: their velocities, with the outer second derivatives that rows and terms have by base
// quantities, give all mixed derivatives.

#include "program/motion.hpp"

#include "obstacle/surface.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

/// How the normal turns where the point moves.
Vec2 normal_rate(const SurfacePoint& s, Vec2 velocity) {
  const Vec2 tau = turned(s.normal);
  return s.curvature * dot(tau, velocity) * tau;
}

}  // namespace

struct MotionRates::Data {
  /// Outer derivatives by base quantities.
  struct Outer {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd hessian;
  };

  explicit Data(const PoseProgramSpec& spec);

  void move(ConstVectorRef x);
  std::vector<int> add_checks();
  void differentiate_rows();
  void differentiate_terms();
  /// Velocities of a point's quantities, and what comes of the change of its rows.
  void move(const Outer& outer, const BaseIndex::Point& p, const Motion& motion, VectorRef slope);
  /// A gradient by base quantities as one by all variables.
  void pull_back(const Eigen::VectorXd& by_base, VectorRef slope) const;
  void add_contacts(const ProgramMotion& motion, ProgramRates& out);
  void add_checks(const ProgramMotion& motion, ProgramRates& out);
  void add_terms(const Motion& base, ProgramRates& out);
  std::string add_references(const std::vector<Motion>& obstacles, ProgramRates& out);

  PoseState state;
  std::vector<int> checks;  ///< places
  std::unique_ptr<RowBlock> gaps, closest, equilibrium;
  Eigen::VectorXd multipliers;
  Outer rows, terms;
  Eigen::VectorXd rates, by_base;  ///< of base quantities and displacements
  Eigen::VectorXd gradient, rest, residuals;
  Eigen::MatrixXd jacobian, by_variables;
};

MotionRates::Data::Data(const PoseProgramSpec& spec)
    : state(spec),
      checks(add_checks()),
      gaps(gap_rows(state)),
      closest(closest_point_rows(state)),
      equilibrium(equilibrium_rows(state)) {
  state.pushes.on.resize(static_cast<std::size_t>(state.places.count()));
  multipliers.setZero(state.layout.first_stick + state.layout.shears);
  rows = terms = {state.base.gradient, state.base.hessian};
  rates.setZero(state.base.hessian.rows());
  by_base = rates;
  gradient.setZero(state.variables);
  rest = gradient;
  residuals.setZero(state.base.terms.residual_count());
  jacobian.setZero(residuals.size(), state.variables);
  by_variables.setZero(state.variables, state.variables);
}

void MotionRates::Data::move(ConstVectorRef x) {
  state.move(x);
  state.differentiate();
  differentiate_terms();
}

std::vector<int> MotionRates::Data::add_checks() {
  std::vector<Places::Station> stations;
  for (const CheckPoint& c : state.spec.checks) stations.push_back({c.piece, c.sigma});
  return state.places.add_stations(stations);
}

void MotionRates::Data::differentiate_rows() {
  const PoseProgram::Layout& at = state.layout;
  state.base.start_second(0.0);
  if (at.forces > 0) {
    gaps->add_second(multipliers.segment(at.first_gap, at.forces), by_variables);
    closest->add_second(multipliers.segment(at.first_closest, at.forces), by_variables);
  }
  equilibrium->add_second(multipliers.head(at.coordinates), by_variables);
  rows.gradient = state.base.gradient;
  rows.hessian = state.base.hessian;
}

void MotionRates::Data::differentiate_terms() {
  double cost = 0.0;
  double smooth = 0.0;
  state.base.terms.evaluate(state.base.values, cost, smooth, residuals);
  state.base.differentiate_terms(gradient, rest, jacobian);
  state.base.start_second(1.0);
  terms.gradient = state.base.gradient;
  terms.hessian = state.base.hessian;
}

void MotionRates::Data::move(const Outer& outer, const BaseIndex::Point& p, const Motion& motion, VectorRef slope) {
  const Vec2 velocity = motion.at({state.base.values.base[p.x], state.base.values.base[p.y]});
  rates[p.x] = velocity.x;
  rates[p.y] = velocity.y;
  rates[p.angle] = motion.turn;
  const Vec2 pull{outer.gradient[p.x], outer.gradient[p.y]};
  const Vec2 along = motion.stretch * pull - motion.turn * turned(pull);
  slope += along.x * state.base.row(p.x).transpose() + along.y * state.base.row(p.y).transpose();
}

void MotionRates::Data::pull_back(const Eigen::VectorXd& by_base, VectorRef slope) const {
  const BaseQuantities& base = state.base;
  const auto through_row = [&](int b) { slope += by_base[b] * base.row(b).transpose(); };
  const auto point = [&](const BaseIndex::Point& p) {
    for (const int b : {p.x, p.y, p.angle, p.curvature, p.strain}) {
      if (b >= 0) through_row(b);
    }
  };
  for (int k = 0; k < state.layout.forces; ++k) {
    const BaseIndex::Contact& contact = base.index.contacts[static_cast<std::size_t>(k)];
    point(contact.point);
    slope[state.layout.first_force + k] += by_base[contact.force];
    if (contact.arc_length >= 0) slope[state.layout.first_arc_length + k] += by_base[contact.arc_length];
  }
  if (base.index.tip.x >= 0) point(base.index.tip);
  for (const BaseIndex::Point& sample : base.index.samples) point(sample);
  if (base.index.energy >= 0) through_row(base.index.energy);
  for (const BaseIndex::Tendon& t : base.index.tendons) {
    if (t.turn >= 0) through_row(t.turn);
  }
  for (std::size_t a = 0; a < base.index.moments.size(); ++a) {
    if (base.index.moments[a] >= 0) slope[state.moment_variable[a]] += by_base[base.index.moments[a]];
  }
  for (int b = base.index.count; b < static_cast<int>(by_base.size()); ++b) through_row(b);
}

void MotionRates::Data::add_contacts(const ProgramMotion& motion, ProgramRates& out) {
  const PoseProgram::Layout& at = state.layout;
  rates.setZero(rows.hessian.rows());
  for (int k = 0; k < at.forces; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const PoseProgram::ContactState& c = state.contacts[i];
    const Vec2 normal = c.surface.normal;
    const Motion by = motion.against(state.spec.contacts[i].obstacle);
    const Vec2 velocity = by.at(c.point);
    const Vec2 turns = normal_rate(c.surface, velocity);
    // A body that is stretched has its distances stretched too.
    out.rows[at.first_gap + k] +=
        dot(normal, velocity) + by.growth - by.stretch * (c.surface.distance + c.radius.value);
    out.slope -= by.stretch * multipliers[at.first_gap + k] * state.contact_row(k, normal).transpose();
    out.rows[at.first_closest + k] += by.turn * dot(turned(c.tangent), normal) + dot(c.tangent, turns);
    const Vec2 push = turns + c.lean * turned(turns) - by.turn * turned(c.push);
    out.rows.head(at.coordinates) += c.force * state.contact_row(k, push).head(at.coordinates).transpose();
    move(rows, state.base.index.contacts[i].point, by, out.slope);
    // Seen from its obstacle its virtual displacement turns too.
    const int dx = state.base.displacement(k);
    const Vec2 displacement = state.places.displacement(state.contact_places[i]);
    rates[dx] = -by.turn * displacement.y;
    rates[dx + 1] = by.turn * displacement.x;
    const Vec2 works = -by.turn * c.force * turned(c.push);
    out.slope += works.x * state.base.row(dx).transpose() + works.y * state.base.row(dx + 1).transpose();
    if (out.convexities.size() > 0 && !state.spec.contacts[i].at_tip)
      out.convexities[k] += convexity_rate(state, k, velocity, by.turn, by.stretch);
  }
  by_base.noalias() = rows.hessian * rates;
  pull_back(by_base, out.slope);
}

void MotionRates::Data::add_checks(const ProgramMotion& motion, ProgramRates& out) {
  const PoseProgram::Layout& at = state.layout;
  VectorRef row = gradient;
  for (std::size_t i = 0; i < checks.size(); ++i) {
    const int obstacle = state.spec.checks[i].obstacle;
    const Motion by = motion.against(obstacle);
    const Vec2 point = state.places.point(checks[i]);
    const SurfacePoint surface = state.surface(obstacle, point);
    const Vec2 velocity = by.at(point);
    const auto r = static_cast<Eigen::Index>(at.first_check) + static_cast<Eigen::Index>(i);
    out.rows[r] += dot(surface.normal, velocity) + by.growth - by.stretch * surface.distance;
    if (multipliers[r] == 0.0) continue;
    row.setZero();
    state.places.row(checks[i], normal_rate(surface, velocity) - by.turn * turned(surface.normal),
                     state.part(row.data()));
    out.slope += multipliers[r] * row;
  }
}

void MotionRates::Data::add_terms(const Motion& base, ProgramRates& out) {
  const BaseIndex& index = state.base.index;
  rates.setZero(terms.hessian.rows());
  for (const BaseIndex::Contact& contact : index.contacts) move(terms, contact.point, base, out.slope);
  for (const BaseIndex::Point& sample : index.samples) move(terms, sample, base, out.slope);
  if (index.tip.x >= 0) move(terms, index.tip, base, out.slope);
  out.cost += terms.gradient.dot(rates.head(terms.gradient.size()));
  by_base.noalias() = terms.hessian * rates;
  pull_back(by_base, out.slope);
}

std::string MotionRates::Data::add_references(const std::vector<Motion>& obstacles, ProgramRates& out) {
  bool read = false;
  for (const PoseProgramTerm& t : state.spec.terms) {
    const Reads reads = t.term->reads();
    if (reads.contact_gap || reads.contact_normal) {
      return "objective '" + t.name + "' sees the surface of obstacles, by which it is not differentiated";
    }
    read = read || reads.contact_point;
  }
  if (!read) return "";
  // Of terms that are quadratic in the reference points the gradient is affine in them: both differences are exact.
  std::vector<Vec2>& references = state.base.values.references;
  const std::vector<Vec2> at_first = references;
  Eigen::VectorXd slope = terms.gradient;
  Eigen::VectorXd rest = slope;
  Eigen::MatrixXd jacobian(state.base.terms.residual_count(), slope.size());
  Eigen::VectorXd residuals(jacobian.rows());
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(rows.hessian.rows());
  Eigen::VectorXd bend = -2.0 * terms.gradient;
  for (const double share : {1.0, -1.0}) {
    for (std::size_t k = 0; k < references.size(); ++k) {
      const auto o = static_cast<std::size_t>(state.spec.contacts[k].obstacle);
      references[k] = at_first[k] + share * obstacles[o].at(at_first[k]);
    }
    double cost = 0.0;
    double smooth = 0.0;
    state.base.terms.evaluate(state.base.values, cost, smooth, residuals);
    state.base.terms.differentiate(state.base.values, slope, rest, jacobian);
    out.cost += 0.5 * share * cost;
    rate.head(slope.size()) += 0.5 * share * slope;
    bend += slope;
  }
  references = at_first;
  if (!(bend.cwiseAbs().maxCoeff() <= 1e-9 * (1.0 + slope.cwiseAbs().maxCoeff()))) {
    return "an objective is not quadratic in the obstacles' reference points";
  }
  pull_back(rate, out.slope);
  return "";
}

MotionRates::MotionRates(const PoseProgramSpec& spec) : data_(std::make_unique<Data>(spec)) {}

void MotionRates::move(ConstVectorRef x) { data_->move(x); }

void MotionRates::weigh(ConstVectorRef multipliers) {
  data_->multipliers = multipliers;
  data_->differentiate_rows();
}

MotionRates::~MotionRates() = default;

std::string MotionRates::add(const ProgramMotion& motion, ProgramRates& out) {
  data_->add_contacts(motion, out);
  data_->add_checks(motion, out);
  data_->add_terms(motion.base, out);
  return motion.obstacles.empty() ? "" : data_->add_references(motion.obstacles, out);
}

}  // namespace tendril
