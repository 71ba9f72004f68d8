#include "tendril/pose_program.hpp"

#include <algorithm>
#include <cmath>

#include "kernels.hpp"
#include "pose_program_data.hpp"
#include "surface.hpp"
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
  for (const PoseProgramTerm& t : spec.terms) terms.push_back({t.term, t.weight, t.name});
  return terms;
}

int interior_count(const PoseProgramSpec& spec) {
  return static_cast<int>(
      std::count_if(spec.contacts.begin(), spec.contacts.end(), [](const ContactSetup& c) { return !c.at_tip; }));
}

}  // namespace

PoseProgram::Data::Data(PoseProgramSpec s)
    : spec(std::move(s)),
      chain(*spec.rod, *spec.model, knot_stretches(spec), spec.nodes, spec.tables.get()),
      backbone(chain, spec.rod->base, spec.rod->base_angle),
      terms(weighted_terms(spec), spec.target, static_cast<int>(spec.contacts.size()),
            static_cast<int>(spec.rod->actuators.size())),
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
    values.references.push_back(spec.obstacles[static_cast<std::size_t>(c.obstacle)]->reference_point());
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
    : NonlinearProgram(data->x_count, data->layout.first_balance + data->layout.balances, data->terms.residual_count()),
      data_(std::move(data)) {
  const Layout& at = data_->layout;
  const PoseProgramSpec& s = data_->spec;
  has_rest_ = data_->terms.has_rest();
  rest_is_linear_ = data_->terms.rest_is_linear();
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
  invalidate();
}

void PoseProgram::set_target(const Target& target) {
  data_->terms.set_target(target);
  invalidate();
}

std::string PoseProgram::row_name(int row) const {
  const Layout& at = data_->layout;
  const auto numbered = [](const char* name, int i) { return std::string(name) + " row " + std::to_string(i + 1); };
  if (row < at.coordinates) return numbered("equilibrium", row);
  if (row < at.first_closest) return numbered("contact_gap", row - at.first_gap);
  if (row < at.first_check) return numbered("closest_point", row - at.first_closest);
  if (row < at.first_order) return numbered("non_penetration", row - at.first_check);
  if (row < at.first_balance) return numbered("contact_order", row - at.first_order);
  return numbered("force_balance", row - at.first_balance);
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

// ---- values
// -----------------------------------------------------------------------------------------------------------

void PoseProgram::Data::evaluate_shape(ConstVectorRef x) {
  const double* s = x.data() + layout.first_arc_length;
  const std::span<const double> knots(s, spec.split ? static_cast<std::size_t>(s_count) : 0);
  if (spec.palm) {
    shift = -(layout.palm >= 0 ? x[layout.palm] : spec.palm->minimum) * spec.palm->axis;
    backbone.place(spec.rod->base + shift);
  }
  backbone.move(x.head(q_count), knots);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const int variable = moving_variable[i];
    if (variable >= 0) {
      moving[i].move(backbone, contact_piece[static_cast<std::size_t>(variable)], s[variable]);
    } else {
      const double at = moving_arc_length[i];
      int j = 0;
      while (j + 1 < pieces && at > backbone.start(j + 1)) ++j;
      moving[i].move(backbone, j, at);
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ContactState& c = contacts[k];
    const auto variable = static_cast<int>(k);
    c.force = x[layout.first_force + variable];
    if (contact_moving[k] >= 0) {
      const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
      c.point = m.position();
      c.angle = m.angle();
      c.tangent = m.tangent();
      c.arc_length = s[variable];
    } else {
      c.point = backbone.knot_point(contact_piece[k] + 1);
      c.angle = backbone.knot_angle(contact_piece[k] + 1);
      c.tangent = {std::cos(c.angle), std::sin(c.angle)};
      c.arc_length = spec.contacts[k].at_tip ? 1.0 : s[variable];
    }
    c.surface = spec.obstacles[static_cast<std::size_t>(spec.contacts[k].obstacle)]->at(c.point);
    values.surfaces[k] = c.surface;
  }
  for (int j = 0; j < pieces; ++j) {
    CheckStations& at = stations[static_cast<std::size_t>(j)];
    const auto count = static_cast<int>(at.sigma.size());
    if (count == 0) continue;
    at.chord_x.setZero();
    at.chord_y.setZero();
    kernels::add_weighted_columns(count, count, nodes, at.by_node.data(), backbone.cosines(j), 1, at.chord_x.data());
    kernels::add_weighted_columns(count, count, nodes, at.by_node.data(), backbone.sines(j), 1, at.chord_y.data());
    const Vec2 start = backbone.knot_point(j);
    const double h = length(j);
    for (std::size_t use = 0; use < at.rows.size(); ++use) {
      const int i = at.station[use];
      const auto row = static_cast<std::size_t>(at.rows[use]);
      check_point[row] = start + h * Vec2{at.chord_x[i], at.chord_y[i]};
      const int obstacle = spec.checks[row].obstacle;
      const Vec2 seen = carried(obstacle) ? check_point[row] - shift : check_point[row];
      check_surface[row] = spec.obstacles[static_cast<std::size_t>(obstacle)]->at(seen);
    }
  }
}

void PoseProgram::Data::evaluate_forces(ConstVectorRef x) {
  const BasisTable& table = chain.table();
  const double* weight = table.weight.data();
  const double* sigma = table.sigma.data();
  const Vec2 g = spec.rod->gravity;
  Vec2 transmitted = spec.rod->tip_force;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (spec.contacts[k].at_tip) transmitted += contacts[k].force * contacts[k].surface.normal;
  }
  double mass = spec.rod->payload;
  sums.set_zero();
  for (int j = pieces - 1; j >= 0; --j) {
    const double h = length(j);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!spec.contacts[k].at_tip && contact_moving[k] < 0 && contact_piece[k] == j) {
        transmitted += contacts[k].force * contacts[k].surface.normal;
      }
    }
    force(0, j) = transmitted.x;
    force(1, j) = transmitted.y;
    mass_beyond[j] = mass;
    const double own = chain.piece(j).weight * h;
    const double* c = backbone.cosines(j);
    const double* s = backbone.sines(j);
    double* normal = force_normal.col(j).data();
    double* tangent = force_tangent.col(j).data();
    double* z = node_buffer.data();
    if (gravity) {
      for (int i = 0; i < nodes; ++i) {
        const double m = mass + own * (1.0 - sigma[i]);
        const double fx = transmitted.x + m * g.x;
        const double fy = transmitted.y + m * g.y;
        normal[i] = fy * c[i] - fx * s[i];
        tangent[i] = fx * c[i] + fy * s[i];
        z[i] = h * weight[i] * normal[i];
      }
      backbone.add_nodes(sums, j, z);
    } else if (transmitted.x != 0.0 || transmitted.y != 0.0) {
      for (int i = 0; i < nodes; ++i) {
        normal[i] = transmitted.y * c[i] - transmitted.x * s[i];
        tangent[i] = transmitted.x * c[i] + transmitted.y * s[i];
        z[i] = h * weight[i] * normal[i];
      }
      backbone.add_nodes(sums, j, z);
    } else {
      std::fill_n(normal, nodes, 0.0);
      std::fill_n(tangent, nodes, 0.0);
    }
    mass += own;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (contact_moving[k] < 0 || contact_piece[k] != j) continue;
      const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
      const Vec2 f = contacts[k].force * contacts[k].surface.normal;
      for (int i = 0; i < m.node_count(); ++i) {
        sums.add_point(j, h * m.weight(i) * dot(f, turned(m.node_tangent(i))), m.node_beta(i));
      }
      transmitted += f;
    }
  }
  (void)x;
}

void PoseProgram::Data::evaluate_rows(ConstVectorRef x, Eigen::VectorXd& c) {
  const BasisTable& table = chain.table();
  c.head(q_count).setZero();
  backbone.spread(sums, c.data());
  for (int j = 0; j < pieces; ++j) {
    const Chain::Piece& p = chain.piece(j);
    const double* q = backbone.coordinates(j);
    double bend = p.stiffness * p.rest_curvature;
    for (std::size_t a = 0; a < moment_variable.size(); ++a) {
      if (moment_variable[a] >= 0 && chain.actuated(static_cast<int>(a), j)) bend += x[moment_variable[a]];
    }
    const double stiffness = p.stiffness / length(j);
    double* out = c.data() + j * n;
    for (int i = 0; i < n; ++i) {
      double sum = 0.0;
      const double* k = table.stiffness.col(i).data();
      for (int m = 0; m < n; ++m) sum += k[m] * q[m];
      out[i] += bend * table.end[i] - stiffness * sum;
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    c[layout.first_gap + i] = contacts[k].surface.distance;
    c[layout.first_closest + i] = dot(contacts[k].tangent, contacts[k].surface.normal);
  }
  for (std::size_t i = 0; i < check_surface.size(); ++i) {
    c[layout.first_check + static_cast<Eigen::Index>(i)] = check_surface[i].distance;
  }
  int order = layout.first_order;
  for (int k = 0; k + 1 < s_count; ++k) {
    if (spec.contacts[static_cast<std::size_t>(k)].region != spec.contacts[static_cast<std::size_t>(k) + 1].region)
      continue;
    c[order++] = x[layout.first_arc_length + k + 1] - x[layout.first_arc_length + k];
  }
  if (layout.balances > 0) {
    double sum = 0.0;
    for (const ContactState& contact : contacts) sum += contact.force * dot(contact.surface.normal, spec.palm->axis);
    c[layout.first_balance] = sum;
  }
}

void PoseProgram::Data::fill_base(ConstVectorRef x) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const BaseIndex::Point& p = index.contacts[k].point;
    values.base[p.x] = contacts[k].point.x;
    values.base[p.y] = contacts[k].point.y;
    values.base[p.angle] = contacts[k].angle;
  }
  if (index.tip.x >= 0) {
    values.base[index.tip.x] = backbone.tip().x;
    values.base[index.tip.y] = backbone.tip().y;
    values.base[index.tip.angle] = backbone.tip_angle();
  }
  const std::size_t first_sample = moving.size() - index.samples.size();
  for (std::size_t i = 0; i < index.samples.size(); ++i) {
    const MovingPoint& m = moving[first_sample + i];
    values.base[index.samples[i].x] = m.position().x;
    values.base[index.samples[i].y] = m.position().y;
    values.base[index.samples[i].angle] = m.angle();
    values.base[index.samples[i].curvature] = m.curvature();
  }
  if (index.energy >= 0) {
    const BasisTable& table = chain.table();
    double energy = 0.0;
    for (int j = 0; j < pieces; ++j) {
      const Chain::Piece& p = chain.piece(j);
      const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
      double bend = 0.0;
      for (int i = 0; i < n; ++i) bend += q[i] * table.stiffness.col(i).dot(q);
      energy += p.stiffness * (0.5 * bend / length(j) - p.rest_curvature * q.dot(table.end) +
                               0.5 * p.rest_curvature * p.rest_curvature * length(j));
    }
    values.base[index.energy] = energy;
  }
  for (std::size_t i = 0; i < unit_variable.size(); ++i) {
    values.base[dense_count + static_cast<Eigen::Index>(i)] = x[unit_variable[i]];
  }
}

// ---- first derivatives
// ------------------------------------------------------------------------------------------------

double PoseProgram::Data::own_rate(const MovingPoint& m, int variable, int l) const {
  // d(h sigma)/ds_l minus sigma dh/ds_l: how fast the point runs along its piece.
  return (variable == l ? 1.0 : 0.0) - start_rate(m.piece(), l) - m.sigma() * length_rate(m.piece(), l);
}

void PoseProgram::Data::point_row_of_moving(const MovingPoint& m, int variable, double* x, double* y, double* angle,
                                            double* curvature) {
  const int j = m.piece();
  const double h = length(j);
  const double* end = chain.table().end.data();
  backbone.row_before(j, m.position(), {1.0, 0.0}, x);
  backbone.row_before(j, m.position(), {0.0, 1.0}, y);
  m.own_rows(x + j * n, y + j * n);
  for (int i = 0; i < j * n; ++i) angle[i] = end[i % n];
  for (int i = 0; i < n; ++i) angle[j * n + i] = m.beta()[i];
  if (curvature != nullptr) {
    for (int i = 0; i < n; ++i) curvature[j * n + i] = m.beta1()[i] / h;
  }
  for (int l = 0; l < s_count; ++l) {
    Vec2 rate = length_rate(j, l) * m.chord() + own_rate(m, variable, l) * m.tangent();
    for (int i = 0; i < j; ++i) rate += length_rate(i, l) * backbone.chord(i);
    const double sigma_rate = own_rate(m, variable, l) / h;
    x[layout.first_arc_length + l] = rate.x;
    y[layout.first_arc_length + l] = rate.y;
    angle[layout.first_arc_length + l] = m.slope() * sigma_rate;
    if (curvature != nullptr) {
      curvature[layout.first_arc_length + l] = (m.bend() * sigma_rate - m.slope() * length_rate(j, l) / h) / h;
    }
  }
}

void PoseProgram::Data::base_rows() {
  const auto row = [this](int i) { return rows.row(i).data(); };
  const double* end = chain.table().end.data();
  const auto knot_point_rows = [&](int j, const BaseIndex::Point& p) {
    backbone.point_rows(j, row(p.x), row(p.y));
    double* angle = row(p.angle);
    for (int i = 0; i <= j; ++i) std::copy_n(end, n, angle + i * n);
    for (int l = 0; l < s_count; ++l) {
      Vec2 rate{};
      for (int i = 0; i <= j; ++i) rate += length_rate(i, l) * backbone.chord(i);
      row(p.x)[layout.first_arc_length + l] = rate.x;
      row(p.y)[layout.first_arc_length + l] = rate.y;
    }
  };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const BaseIndex::Point& p = index.contacts[k].point;
    if (contact_moving[k] < 0) {
      knot_point_rows(contact_piece[k], p);
    } else {
      const auto m = static_cast<std::size_t>(contact_moving[k]);
      point_row_of_moving(moving[m], moving_variable[m], row(p.x), row(p.y), row(p.angle), nullptr);
    }
  }
  if (index.tip.x >= 0) knot_point_rows(pieces - 1, index.tip);
  const std::size_t first_sample = moving.size() - index.samples.size();
  for (std::size_t i = 0; i < index.samples.size(); ++i) {
    // The piece that holds a fixed arc length may change when knots move.
    const BaseIndex::Point& p = index.samples[i];
    for (const int r : {p.x, p.y, p.angle, p.curvature}) rows.row(r).setZero();
    point_row_of_moving(moving[first_sample + i], -1, row(p.x), row(p.y), row(p.angle), row(p.curvature));
  }
  if (index.energy >= 0) {
    const BasisTable& table = chain.table();
    double* energy = row(index.energy);
    for (int l = 0; l < s_count; ++l) energy[layout.first_arc_length + l] = 0.0;
    for (int j = 0; j < pieces; ++j) {
      const Chain::Piece& p = chain.piece(j);
      const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
      const double h = length(j);
      double bend = 0.0;
      for (int i = 0; i < n; ++i) {
        const double kq = table.stiffness.col(i).dot(q);
        bend += q[i] * kq;
        energy[j * n + i] = p.stiffness * (kq / h - p.rest_curvature * end[i]);
      }
      const double along = 0.5 * p.stiffness * (p.rest_curvature * p.rest_curvature - bend / (h * h));
      for (int l = 0; l < s_count; ++l) energy[layout.first_arc_length + l] += along * length_rate(j, l);
    }
  }
}

void PoseProgram::Data::mark_palm_column() {
  if (layout.palm < 0) return;
  const auto mark = [this](const BaseIndex::Point& p) {
    rows(p.x, layout.palm) = -spec.palm->axis.x;
    rows(p.y, layout.palm) = -spec.palm->axis.y;
  };
  for (const BaseIndex::Contact& contact : index.contacts) mark(contact.point);
  if (index.tip.x >= 0) mark(index.tip);
  for (const BaseIndex::Point& sample : index.samples) mark(sample);
}

void PoseProgram::Data::equilibrium_jacobian(ConstVectorRef x, Eigen::MatrixXd& jacobian) {
  (void)x;
  const BasisTable& table = chain.table();
  const double* weight = table.weight.data();
  const Vec2 g = spec.rod->gravity;
  jacobian.topRows(q_count).setZero();

  // Turning of the transmitted force with the shape.
  gram_sums.set_zero();
  for (std::size_t l = 0; l < rate_sums.size(); ++l) rate_sums[l].set_zero();
  for (int j = 0; j < pieces; ++j) {
    const double h = length(j);
    const double* tangent = force_tangent.col(j).data();
    double* z = node_buffer.data();
    for (int i = 0; i < nodes; ++i) z[i] = -h * weight[i] * tangent[i];
    backbone.add_gram_nodes(gram_sums, j, z);
    const double* c = backbone.cosines(j);
    const double* s = backbone.sines(j);
    for (int l = 0; l < s_count; ++l) {
      const double rate = length_rate(j, l);
      const double mass = rate * mass_beyond[j] + h * mass_rate(j, l);
      if (rate == 0.0 && mass == 0.0) continue;
      const double own = 2.0 * chain.piece(j).weight * h * rate;
      const double fx0 = rate * force(0, j) + mass * g.x;
      const double fy0 = rate * force(1, j) + mass * g.y;
      for (int i = 0; i < nodes; ++i) {
        const double m = own * (1.0 - table.sigma[i]);
        z[i] = weight[i] * ((fy0 + m * g.y) * c[i] - (fx0 + m * g.x) * s[i]);
      }
      backbone.add_nodes(rate_sums[static_cast<std::size_t>(l)], j, z);
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (contact_moving[k] < 0) continue;
    const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
    const Vec2 f = contacts[k].force * contacts[k].surface.normal;
    for (int i = 0; i < m.node_count(); ++i) {
      gram_sums.add_gram_point(m.piece(), -length(m.piece()) * m.weight(i) * dot(f, m.node_tangent(i)), m.node_beta(i));
    }
    // An unsplit rod has no moving knots: only the contact itself runs along its piece.
    rate_sums[k].add_point(m.piece(), dot(f, m.normal()), m.beta());
  }
  backbone.spread_gram(gram_sums, jacobian.topLeftCorner(q_count, q_count));
  for (int l = 0; l < s_count; ++l) {
    backbone.spread(rate_sums[static_cast<std::size_t>(l)], jacobian.col(layout.first_arc_length + l).data());
  }

  for (int j = 0; j < pieces; ++j) {
    const Chain::Piece& p = chain.piece(j);
    const double h = length(j);
    const double* q = backbone.coordinates(j);
    const double stiffness = p.stiffness / h;
    for (int k = 0; k < n; ++k) {
      const double* column = table.stiffness.col(k).data();
      double* out = jacobian.col(j * n + k).data() + j * n;
      double sum = 0.0;
      for (int i = 0; i < n; ++i) {
        out[i] -= stiffness * column[i];
        sum += column[i] * q[i];
      }
      for (int l = 0; l < s_count; ++l) {
        jacobian(j * n + k, layout.first_arc_length + l) += stiffness / h * length_rate(j, l) * sum;
      }
    }
    for (std::size_t a = 0; a < moment_variable.size(); ++a) {
      if (moment_variable[a] < 0 || !chain.actuated(static_cast<int>(a), j)) continue;
      for (int i = 0; i < n; ++i) jacobian(j * n + i, moment_variable[a]) = table.end[i];
    }
  }

  // Contact forces act along normals that turn with the contact point.
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 normal = c.surface.normal;
    const Vec2 tau = turned(normal);
    const double* rx = rows.row(p.x).data();
    const double* ry = rows.row(p.y).data();
    double* along = row_buffer.data();
    for (int i = 0; i < x_count; ++i) along[i] = tau.x * rx[i] + tau.y * ry[i];
    double* by_force = jacobian.col(layout.first_force + static_cast<Eigen::Index>(k)).data();
    for (int i = 0; i < q_count; ++i) by_force[i] = normal.x * rx[i] + normal.y * ry[i];
    const double factor = c.force * c.surface.curvature;
    if (factor == 0.0) continue;
    for (int column = 0; column < x_count; ++column) {
      const double scaled = factor * along[column];
      if (scaled == 0.0) continue;
      double* out = jacobian.col(column).data();
      for (int i = 0; i < q_count; ++i) out[i] += scaled * along[i];
    }
  }
}

void PoseProgram::Data::contact_jacobian(Eigen::MatrixXd& jacobian) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 normal = c.surface.normal;
    const Vec2 tau = turned(normal);
    const double turn = dot(turned(c.tangent), normal);
    const double bend = c.surface.curvature * dot(tau, c.tangent);
    const double* rx = rows.row(p.x).data();
    const double* ry = rows.row(p.y).data();
    const double* ra = rows.row(p.angle).data();
    const Eigen::Index gap = layout.first_gap + static_cast<Eigen::Index>(k);
    const Eigen::Index closest = layout.first_closest + static_cast<Eigen::Index>(k);
    for (int i = 0; i < x_count; ++i) {
      jacobian(gap, i) = normal.x * rx[i] + normal.y * ry[i];
      jacobian(closest, i) = turn * ra[i] + bend * (tau.x * rx[i] + tau.y * ry[i]);
    }
  }
  int order = layout.first_order;
  for (int k = 0; k + 1 < s_count; ++k) {
    if (spec.contacts[static_cast<std::size_t>(k)].region != spec.contacts[static_cast<std::size_t>(k) + 1].region)
      continue;
    jacobian(order, layout.first_arc_length + k) = -1.0;
    jacobian(order++, layout.first_arc_length + k + 1) = 1.0;
  }
}

void PoseProgram::Data::balance_jacobian(Eigen::MatrixXd& jacobian) const {
  if (layout.balances == 0) return;
  jacobian.row(layout.first_balance).setZero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 tau = turned(c.surface.normal);
    const double turning = c.force * c.surface.curvature * dot(tau, spec.palm->axis);
    jacobian.row(layout.first_balance) += turning * (tau.x * rows.row(p.x) + tau.y * rows.row(p.y));
    jacobian(layout.first_balance, layout.first_force + static_cast<Eigen::Index>(k)) +=
        dot(c.surface.normal, spec.palm->axis);
  }
}

void PoseProgram::Data::check_row(int j, const CheckStations& at, std::size_t use, Vec2 direction, double* row,
                                  double* others) const {
  const auto check = static_cast<std::size_t>(at.rows[use]);
  const Vec2 point = check_point[check];
  backbone.row_before(j, point, direction, row);
  const double h = length(j);
  const double dx = h * direction.x;
  const double dy = h * direction.y;
  const double* sum = at.turned.col(at.station[use]).data();
  double* own = row + j * n;
  for (int i = 0; i < n; ++i) own[i] = dx * sum[i] + dy * sum[n + i];
  for (int l = 0; l < s_count; ++l) {
    Vec2 rate = length_rate(j, l) / h * (point - backbone.knot_point(j));
    for (int i = 0; i < j; ++i) rate += length_rate(i, l) * backbone.chord(i);
    others[l] = dot(direction, rate);
  }
  if (layout.palm >= 0) others[s_count] = carried(spec.checks[check].obstacle) ? 0.0 : -dot(direction, spec.palm->axis);
}

void PoseProgram::Data::check_jacobian(Eigen::MatrixXd& jacobian) {
  for (int j = 0; j < pieces; ++j) {
    CheckStations& at = stations[static_cast<std::size_t>(j)];
    at.turned.setZero();
    const auto stride = static_cast<int>(at.by_node.rows());
    for (int i = 0; i < stride; ++i) backbone.add_turned(j, at.by_node.data() + i, stride, at.turned.col(i).data());
    for (std::size_t use = 0; use < at.rows.size(); ++use) {
      const auto check = static_cast<std::size_t>(at.rows[use]);
      double* row = row_buffer.data();
      double* others = vector_buffer.data();
      check_row(j, at, use, check_surface[check].normal, row, others);
      const Eigen::Index r = layout.first_check + at.rows[use];
      const int active = (j + 1) * n;
      for (int i = 0; i < active; ++i) jacobian(r, i) = row[i];
      for (int l = 0; l < s_count; ++l) jacobian(r, layout.first_arc_length + l) = others[l];
      if (layout.palm >= 0) jacobian(r, layout.palm) = others[s_count];
    }
  }
}

void PoseProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  Data& d = *data_;
  d.evaluate_shape(x);
  d.evaluate_forces(x);
  d.evaluate_rows(x, out.constraints);
  d.fill_base(x);
  d.terms.evaluate(d.values, out.cost, out.rest, out.residuals);
  if (!derivatives) return;
  d.backbone.sum_normals();
  d.base_rows();
  d.mark_palm_column();
  d.equilibrium_jacobian(x, out.jacobian);
  d.contact_jacobian(out.jacobian);
  d.check_jacobian(out.jacobian);
  d.balance_jacobian(out.jacobian);
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
