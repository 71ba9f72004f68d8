#include "program/pose_program.hpp"

#include <algorithm>
#include <cmath>

#include "program/pose_program_data.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

std::vector<int> knot_stretches(const PoseProgramSpec& spec) {
  std::vector<int> stretches;
  if (!spec.split) return stretches;
  for (const ContactSetup& c : spec.contacts) {
    if (!c.at_tip) stretches.push_back(c.region);
  }
  return stretches;
}

std::vector<WeightedTerm> weighted_terms(const PoseProgramSpec& spec) {
  std::vector<WeightedTerm> terms;
  for (const PoseProgramTerm& t : spec.terms) terms.push_back({t.term, t.weight, t.name, t.fault});
  return terms;
}

int interior_count(const PoseProgramSpec& spec) {
  return static_cast<int>(
      std::count_if(spec.contacts.begin(), spec.contacts.end(), [](const ContactSetup& c) { return !c.at_tip; }));
}

}  // namespace

PoseProgram::Data::Data(PoseProgramSpec s)
    : spec(std::move(s)),
      loads{spec.rod->gravity, spec.rod->tip_force, std::vector<double>(spec.obstacles.size(), 0.0)},
      chain(*spec.rod, *spec.model, knot_stretches(spec), spec.nodes, spec.tables.get()),
      backbone(chain, spec.rod->base, spec.rod->base_angle),
      terms(weighted_terms(spec), spec.target, static_cast<int>(spec.contacts.size()),
            static_cast<int>(spec.rod->actuators.size()), spec.term_units),
      sums(chain, false),
      gram_sums(chain, true) {
  pieces = chain.piece_count();
  n = chain.functions();
  nodes = chain.nodes();
  q_count = chain.coordinate_count();
  gravity = spec.rod->has_gravity();
  const int contact_count = static_cast<int>(spec.contacts.size());
  s_count = interior_count(spec);

  layout.coordinates = q_count;
  layout.first_moment = q_count;
  for (const Rod::Actuator& a : spec.rod->actuators) {
    moment_variable.push_back(a.fixed_at_zero() ? -1 : layout.first_moment + layout.moments++);
  }
  layout.first_arc_length = layout.first_moment + layout.moments;
  layout.arc_lengths = s_count;
  layout.first_force = layout.first_arc_length + s_count;
  layout.forces = contact_count;
  x_count = layout.first_force + contact_count;
  if (spec.palm && spec.palm->minimum != spec.palm->maximum) layout.palm = x_count++;
  layout.first_gap = q_count;
  layout.first_closest = q_count + contact_count;
  layout.first_check = layout.first_closest + contact_count;
  layout.checks = static_cast<int>(spec.checks.size());
  layout.first_order = layout.first_check + layout.checks;
  for (int k = 0; k + 1 < s_count; ++k) {
    if (spec.contacts[static_cast<std::size_t>(k)].region == spec.contacts[static_cast<std::size_t>(k) + 1].region) {
      ++layout.orders;
    }
  }
  layout.first_balance = layout.first_order + layout.orders;
  layout.balances = spec.palm && spec.palm->balance && contact_count > 0 ? 1 : 0;
  layout.first_margin = layout.first_balance + layout.balances;
  layout.margins = spec.least_margin ? 1 : 0;
  layout.first_convexity = layout.first_margin + layout.margins;
  layout.convexities = spec.least_convexity ? 2 * s_count : 0;
  for (int i = 0; i < layout.convexities; ++i) convex.emplace_back(x_count);
  if (spec.least_margin) margin = std::make_unique<MarginRow>(spec);
  branches.assign(spec.contacts.size(), Branch::open);

  length_rate.setZero(pieces, s_count);
  start_rate.setZero(pieces, s_count);
  if (spec.split && s_count > 0) {
    length_rate = chain.length_rate();
    start_rate = chain.start_rate();
  }
  mass_rate.setZero(pieces, s_count);
  for (int j = pieces - 2; j >= 0; --j) {
    mass_rate.row(j) = mass_rate.row(j + 1) + chain.piece(j + 1).weight * length_rate.row(j + 1);
  }

  for (int k = 0; k < contact_count; ++k) {
    const ContactSetup& c = spec.contacts[static_cast<std::size_t>(k)];
    const bool own_point = !c.at_tip && !spec.split;
    contact_moving.push_back(own_point ? static_cast<int>(moving.size()) : -1);
    contact_piece.push_back(c.at_tip ? pieces - 1 : spec.split ? chain.piece_before_knot(k) : c.region);
    if (own_point) {
      moving.emplace_back(chain);
      moving_variable.push_back(k);
      moving_arc_length.push_back(0.0);
    }
  }
  contacts.resize(spec.contacts.size());

  const std::vector<double> samples = terms.sample_arc_lengths();
  const std::size_t first_sample = moving.size();
  for (const double at : samples) {
    moving.emplace_back(chain);
    moving_variable.push_back(-1);
    moving_arc_length.push_back(at);
  }

  // Base quantities: dense rows first, then variables.
  int next = 0;
  const auto point = [&next] {
    BaseIndex::Point p;
    p.x = next++;
    p.y = next++;
    p.angle = next++;
    return p;
  };
  for (int k = 0; k < contact_count; ++k) index.contacts.push_back({point(), -1, -1});
  if (terms.reads_tip()) index.tip = point();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    BaseIndex::Point p = point();
    p.curvature = next++;
    index.samples.push_back(p);
  }
  if (terms.reads_energy()) index.energy = next++;
  dense_count = next;
  for (const int variable : moment_variable) {
    index.moments.push_back(variable < 0 ? -1 : next);
    if (variable < 0) continue;
    unit_variable.push_back(variable);
    ++next;
  }
  for (int k = 0; k < contact_count; ++k) {
    index.contacts[static_cast<std::size_t>(k)].force = next++;
    unit_variable.push_back(layout.first_force + k);
  }
  for (int k = 0; k < s_count; ++k) {
    index.contacts[static_cast<std::size_t>(k)].arc_length = next++;
    unit_variable.push_back(layout.first_arc_length + k);
  }
  if (layout.palm >= 0) {
    index.palm = next++;
    unit_variable.push_back(layout.palm);
  } else if (spec.palm) {
    values.palm = spec.palm->minimum;
  }
  index.count = next;
  terms.bind(index);
  (void)first_sample;

  values.base.setZero(index.count);
  values.surfaces.resize(spec.contacts.size());
  for (const ContactSetup& c : spec.contacts) {
    values.references.push_back(
        c.obstacle < 0 ? Vec2{} : spec.obstacles[static_cast<std::size_t>(c.obstacle)]->reference_point());
  }
  delta_row = dense_count;
  rows.setZero(dense_count + 2 * contact_count, x_count);
  term_gradient.setZero(index.count);
  term_rest_gradient.setZero(index.count);
  term_jacobian.setZero(terms.residual_count(), index.count);

  // Check points, grouped by piece and sigma.
  stations.resize(static_cast<std::size_t>(pieces));
  for (int row = 0; row < layout.checks; ++row) {
    const CheckPoint& c = spec.checks[static_cast<std::size_t>(row)];
    if (c.piece < 0 || c.piece >= pieces || !(c.sigma > 0.0 && c.sigma <= 1.0)) {
      throw Error("a check point lies outside its piece");
    }
    CheckStations& at = stations[static_cast<std::size_t>(c.piece)];
    const auto found = std::find(at.sigma.begin(), at.sigma.end(), c.sigma);
    at.station.push_back(static_cast<int>(found - at.sigma.begin()));
    if (found == at.sigma.end()) at.sigma.push_back(c.sigma);
    at.rows.push_back(row);
  }
  std::vector<double> weights(static_cast<std::size_t>(nodes));
  for (CheckStations& at : stations) {
    const auto count = static_cast<Eigen::Index>(at.sigma.size());
    at.by_node.setZero(count, nodes);
    at.turned.setZero(2 * n, count);
    at.chord_x.setZero(count);
    at.chord_y.setZero(count);
    at.adjoint_x.setZero(count);
    at.adjoint_y.setZero(count);
    for (std::size_t i = 0; i < at.sigma.size(); ++i) {
      chain.rule().partial_weights(at.sigma[i], weights);
      for (int g = 0; g < nodes; ++g)
        at.by_node(static_cast<Eigen::Index>(i), g) = weights[static_cast<std::size_t>(g)];
    }
  }
  check_surface.resize(spec.checks.size());
  check_point.resize(spec.checks.size());

  mass_beyond.setZero(pieces);
  force.setZero(2, pieces);
  force_normal.setZero(nodes, pieces);
  force_tangent.setZero(nodes, pieces);
  node_buffer.setZero(nodes);
  check_buffer.setZero(nodes);
  vector_buffer.setZero(std::max(q_count, s_count + 1));
  for (int l = 0; l < s_count; ++l) rate_sums.emplace_back(chain, false);
  psi.setZero(nodes, pieces);
  psi_knot.setZero(pieces + 1);
  virtual_chord.setZero(2, pieces);
  virtual_turn.setZero(2, pieces + 1);
  virtual_sum.setZero(2 * n, pieces);
  base_hessian.setZero(index.count + 2 * contact_count, index.count + 2 * contact_count);
  base_gradient.setZero(index.count);
  adjoint.setZero(2, pieces);
  virtual_adjoint.setZero(2, pieces);
  row_buffer.setZero(x_count);
  const int others = s_count + (layout.palm >= 0 ? 1 : 0);
  check_rows.setZero(q_count + others, layout.checks);
  scaled_rows.setZero(layout.checks, q_count + others);
  third.setZero(n);
}

PoseProgram::~PoseProgram() = default;

PoseProgram::PoseProgram(PoseProgramSpec spec) : PoseProgram(std::make_unique<Data>(std::move(spec))) {}

PoseProgram::PoseProgram(std::unique_ptr<Data> data)
    : NonlinearProgram(data->x_count, data->layout.first_convexity + data->layout.convexities,
                       data->terms.residual_count()),
      data_(std::move(data)) {
  const Layout& at = data_->layout;
  const PoseProgramSpec& s = data_->spec;
  lower_.setConstant(-infinity);
  upper_.setConstant(infinity);
  for (std::size_t a = 0; a < s.rod->actuators.size(); ++a) {
    const int variable = data_->moment_variable[a];
    if (variable < 0) continue;
    lower_[variable] = s.rod->actuators[a].minimum;
    upper_[variable] = s.rod->actuators[a].maximum;
  }
  const std::vector<double>& knots = data_->chain.fixed_knots();
  for (int k = 0; k < at.arc_lengths; ++k) {
    const int region = s.contacts[static_cast<std::size_t>(k)].region;
    double low = 0.0;
    double high = 1.0;
    if (s.split) {
      low = knots[static_cast<std::size_t>(region)];
      high = knots[static_cast<std::size_t>(region) + 1];
    } else {
      low = data_->chain.start0()[region];
      high = low + data_->chain.length0()[region];
    }
    // A knot must not run into another; inside one piece there is none, but the base is no place for a contact.
    const double margin = std::min(knot_clearance, 0.25 * (high - low));
    const bool soft_low = !s.split && region > 0;
    const bool soft_high = !s.split;
    lower_[at.first_arc_length + k] = soft_low ? low : low + margin;
    upper_[at.first_arc_length + k] = soft_high ? high : high - margin;
  }
  if (at.palm >= 0) {
    lower_[at.palm] = s.palm->minimum;
    upper_[at.palm] = s.palm->maximum;
  }
  row_lower_.setZero();
  row_upper_.setZero();
  for (int k = 0; k < at.forces; ++k) set_branch(k, Branch::open);
  for (int i = 0; i < at.checks; ++i) row_upper_[at.first_check + i] = infinity;
  for (int i = 0; i < at.orders; ++i) {
    row_lower_[at.first_order + i] = knot_clearance;
    row_upper_[at.first_order + i] = infinity;
  }
  if (at.margins > 0) {
    row_lower_[at.first_margin] = *s.least_margin;
    row_upper_[at.first_margin] = infinity;
  }
}

const PoseProgram::Layout& PoseProgram::layout() const { return data_->layout; }
const PoseProgramSpec& PoseProgram::spec() const { return data_->spec; }
const Chain& PoseProgram::chain() const { return data_->chain; }
const Backbone& PoseProgram::backbone() const { return data_->backbone; }
Vec2 PoseProgram::base_shift() const { return data_->shift; }
const std::vector<PoseProgram::ContactState>& PoseProgram::contacts() const { return data_->contacts; }
Branch PoseProgram::branch(int contact) const { return data_->branches[static_cast<std::size_t>(contact)]; }
double PoseProgram::term_value(int i) const { return data_->terms[static_cast<std::size_t>(i)].value(); }

double PoseProgram::palm_distance(ConstVectorRef x) const {
  if (!data_->spec.palm) return 0.0;
  return data_->layout.palm >= 0 ? x[data_->layout.palm] : data_->spec.palm->minimum;
}

int PoseProgram::moment_variable(int actuator) const {
  return data_->moment_variable[static_cast<std::size_t>(actuator)];
}

int PoseProgram::arc_length_variable(int contact) const {
  return data_->spec.contacts[static_cast<std::size_t>(contact)].at_tip ? -1 : data_->layout.first_arc_length + contact;
}

void PoseProgram::set_branch(int contact, Branch branch) {
  const Layout& at = data_->layout;
  const PoseProgramSpec& s = data_->spec;
  data_->branches[static_cast<std::size_t>(contact)] = branch;
  const bool at_tip = s.contacts[static_cast<std::size_t>(contact)].at_tip;
  row_upper_[at.first_gap + contact] = branch == Branch::touching ? 0.0 : infinity;
  lower_[at.first_force + contact] = branch == Branch::separated ? 0.0 : s.min_force;
  upper_[at.first_force + contact] = branch == Branch::separated ? 0.0 : s.max_force;
  // t.n = 0 inside, t.n <= 0 at the tip. Where the tip does not touch, no point needs to be closest.
  row_lower_[at.first_closest + contact] = at_tip ? -infinity : 0.0;
  row_upper_[at.first_closest + contact] = at_tip && branch == Branch::separated ? infinity : 0.0;
  for (int side = 0; side < 2 && contact < at.convexities / 2; ++side) {
    const int row = at.first_convexity + 2 * contact + side;
    row_lower_[row] = branch == Branch::touching ? *s.least_convexity : -infinity;
    row_upper_[row] = infinity;
  }
  invalidate();
}

void PoseProgram::set_target(const Target& target) {
  data_->terms.set_target(target);
  invalidate();
}

void PoseProgram::set_loads(const Loads& loads) {
  data_->loads = loads;
  if (data_->margin) data_->margin->set_loads(loads);
  invalidate();
}

const Loads& PoseProgram::loads() const { return data_->loads; }

std::string PoseProgram::row_name(int row) const {
  const Layout& at = data_->layout;
  const auto numbered = [](const char* name, int i) { return std::string(name) + " row " + std::to_string(i + 1); };
  if (row < at.coordinates) return numbered("equilibrium", row);
  if (row < at.first_closest) return numbered("contact_gap", row - at.first_gap);
  if (row < at.first_check) return numbered("closest_point", row - at.first_closest);
  if (row < at.first_order) return numbered("non_penetration", row - at.first_check);
  if (row < at.first_balance) return numbered("contact_order", row - at.first_order);
  if (row < at.first_margin) return numbered("force_balance", row - at.first_balance);
  if (row < at.first_convexity) return numbered("stability", row - at.first_margin);
  return numbered("point_contact", row - at.first_convexity);
}

std::string PoseProgram::variable_name(int variable) const {
  const Layout& at = data_->layout;
  const auto numbered = [](const char* name, int i) { return std::string(name) + " " + std::to_string(i + 1); };
  if (variable < at.first_moment) return numbered("coordinate", variable);
  if (variable < at.first_arc_length) return numbered("moment", variable - at.first_moment);
  if (variable < at.first_force) return numbered("contact arc length", variable - at.first_arc_length);
  if (variable == at.palm) return "palm distance";
  return numbered("contact force", variable - at.first_force);
}

void PoseProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  Data& d = *data_;
  d.evaluate_shape(x);
  d.evaluate_forces(x);
  d.evaluate_rows(x, out.constraints);
  d.fill_base(x);
  d.terms.evaluate(d.values, out.cost, out.rest, out.residuals);
  if (d.margin) {
    const int row = d.layout.first_margin;
    out.constraints[row] = derivatives ? d.margin->differentiate(x) : d.margin->value(x);
    if (derivatives) out.jacobian.row(row) = d.margin->gradient().transpose();
  }
  if (d.layout.convexities > 0 && !derivatives) d.convexity_rows(x, false, out);
  if (!derivatives) return;
  d.backbone.sum_normals();
  d.base_rows();
  d.mark_palm_column();
  d.equilibrium_jacobian(x, out.jacobian);
  d.contact_jacobian(out.jacobian);
  d.check_jacobian(out.jacobian);
  d.balance_jacobian(out.jacobian);
  if (d.layout.convexities > 0) d.convexity_rows(x, true, out);
  d.terms.differentiate(d.values, d.term_gradient, d.term_rest_gradient, d.term_jacobian);
  out.gradient.setZero();
  out.rest_gradient.setZero();
  out.residual_jacobian.setZero();
  const auto residuals = static_cast<int>(d.term_jacobian.rows());
  for (int b = 0; b < d.index.count; ++b) {
    const double g = d.term_gradient[b];
    const double rest = d.term_rest_gradient[b];
    if (b >= d.dense_count) {
      const int variable = d.unit_variable[static_cast<std::size_t>(b - d.dense_count)];
      out.gradient[variable] += g;
      out.rest_gradient[variable] += rest;
      for (int r = 0; r < residuals; ++r) out.residual_jacobian(r, variable) += d.term_jacobian(r, b);
      continue;
    }
    const double* row = d.rows.row(b).data();
    if (g != 0.0) {
      for (int i = 0; i < d.x_count; ++i) out.gradient[i] += g * row[i];
    }
    if (rest != 0.0) {
      for (int i = 0; i < d.x_count; ++i) out.rest_gradient[i] += rest * row[i];
    }
    for (int r = 0; r < residuals; ++r) {
      const double value = d.term_jacobian(r, b);
      if (value == 0.0) continue;
      for (int i = 0; i < d.x_count; ++i) out.residual_jacobian(r, i) += value * row[i];
    }
  }
}

void PoseProgram::contact_rows(int contact, VectorRef x, VectorRef y, VectorRef angle) const {
  const BaseIndex::Point& p = data_->index.contacts[static_cast<std::size_t>(contact)].point;
  x = data_->rows.row(p.x).head(data_->q_count).transpose();
  y = data_->rows.row(p.y).head(data_->q_count).transpose();
  angle = data_->rows.row(p.angle).head(data_->q_count).transpose();
}

}  // namespace tendril
