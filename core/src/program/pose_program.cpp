#include "program/pose_program.hpp"

#include <algorithm>
#include <cmath>

#include "program/pose_program_data.hpp"

namespace tendril {

PoseProgram::Data::Data(PoseProgramSpec s) : PoseState(std::move(s)) {
  const auto add = [this](int count, auto make) {
    if (count > 0) blocks.push_back(make(*this));
  };
  add(layout.coordinates, equilibrium_rows);
  add(layout.forces, gap_rows);
  add(layout.forces, closest_point_rows);
  add(layout.shortenings, shortening_rows);
  add(layout.checks, clearance_rows);
  add(layout.orders, order_rows);
  add(layout.balances, balance_rows);
  add(layout.targets, target_rows);
  add(layout.margins, stability_rows);
  add(layout.convexities, convexity_rows);
  add(layout.shears, stick_rows);
  pushes.on.resize(static_cast<std::size_t>(places.count()));
  mixed.setZero(layout.coordinates, layout.slides());
  moments.resize(moment_variable.size());
  evaluated_at.setZero(variables);
}

PoseProgram::~PoseProgram() = default;

PoseProgram::PoseProgram(PoseProgramSpec spec) : PoseProgram(std::make_unique<Data>(std::move(spec))) {}

PoseProgram::PoseProgram(std::unique_ptr<Data> data)
    : NonlinearProgram(data->variables, data->layout.first_stick + data->layout.shears,
                       data->base.terms.residual_count()),
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
  for (int l = 0; l < at.moves; ++l) {
    lower_[at.first_move + l] = s.rod->moves[static_cast<std::size_t>(l)].minimum;
    upper_[at.first_move + l] = s.rod->moves[static_cast<std::size_t>(l)].maximum;
  }
  if (at.palm >= 0) {
    lower_[at.palm] = s.palm->minimum;
    upper_[at.palm] = s.palm->maximum;
  }
  for (int k = 0; k < at.forces; ++k) set_branch(k, Branch::open);
  set_row_bounds();
}

void PoseProgram::set_row_bounds() {
  for (const std::unique_ptr<RowBlock>& block : data_->blocks) {
    block->bounds(row_lower_.segment(block->first(), block->count()),
                  row_upper_.segment(block->first(), block->count()));
  }
}

const PoseProgram::Layout& PoseProgram::layout() const { return data_->layout; }
const PoseProgramSpec& PoseProgram::spec() const { return data_->spec; }
const Chain& PoseProgram::chain() const { return data_->chain; }
const Backbone& PoseProgram::backbone() const { return data_->places.backbone(); }

const Sections& PoseProgram::sections() const { return data_->places.sections(); }
Vec2 PoseProgram::base_shift() const { return data_->shift; }
const std::vector<PoseProgram::ContactState>& PoseProgram::contacts() const { return data_->contacts; }
Branch PoseProgram::branch(int contact) const { return data_->branches[static_cast<std::size_t>(contact)]; }
double PoseProgram::term_value(int i) const { return data_->base.terms[static_cast<std::size_t>(i)].value(); }

std::span<const double> PoseProgram::knots(ConstVectorRef x) const {
  const Layout& at = data_->layout;
  const auto count = static_cast<std::size_t>(data_->chain.knot_count());
  // Contacts that are not split have no knots.
  return {x.data() + at.first_arc_length - (data_->spec.rod->draws() ? 1 : 0), count};
}

double PoseProgram::palm_distance(ConstVectorRef x) const {
  if (!data_->spec.palm) return 0.0;
  return data_->layout.palm >= 0 ? x[data_->layout.palm] : data_->spec.palm->minimum;
}

int PoseProgram::moment_variable(int actuator) const {
  return data_->moment_variable[static_cast<std::size_t>(actuator)];
}

int PoseProgram::shortening_row(int actuator) const {
  const std::vector<Rod::Actuator>& all = data_->spec.rod->actuators;
  const auto until = all.begin() + actuator;
  if (!until->limits_length()) return -1;
  return data_->layout.first_shortening +
         static_cast<int>(std::count_if(all.begin(), until, [](const Rod::Actuator& a) { return a.limits_length(); }));
}

int PoseProgram::arc_length_variable(int contact) const {
  return data_->spec.contacts[static_cast<std::size_t>(contact)].at_tip ? -1 : data_->layout.first_arc_length + contact;
}

void PoseProgram::set_branch(int contact, Branch branch) {
  const Layout& at = data_->layout;
  const PoseProgramSpec& s = data_->spec;
  data_->branches[static_cast<std::size_t>(contact)] = branch;
  data_->base.set_branch(contact, branch);
  lower_[at.first_force + contact] = branch == Branch::separated ? 0.0 : s.min_force;
  upper_[at.first_force + contact] = branch == Branch::separated ? 0.0 : s.max_force;
  if (at.leans > 0) {
    // Without a force its direction means nothing.
    const auto obstacle = static_cast<std::size_t>(s.contacts[static_cast<std::size_t>(contact)].obstacle);
    upper_[at.first_lean + contact] = branch == Branch::separated ? 0.0 : s.friction[obstacle];
    lower_[at.first_lean + contact] = -upper_[at.first_lean + contact];
  }
  set_row_bounds();
  data_->evaluated = data_->kept = false;
  invalidate();
}

void PoseProgram::set_target(const Target& target) {
  data_->spec.target = target;
  data_->base.terms.set_target(target);
  // Rows that hold the rod to its target are evaluated with all others.
  data_->kept = data_->evaluated && data_->layout.targets == 0;
  invalidate();
}

void PoseProgram::set_loads(const Loads& loads) {
  data_->loads = loads;
  data_->evaluated = data_->kept = false;
  invalidate();
}

const Loads& PoseProgram::loads() const { return data_->loads; }

int PoseProgram::shear_variable(int contact) const { return data_->shear_variables[static_cast<std::size_t>(contact)]; }

void PoseProgram::sliding_row(int contact, VectorRef out) const { tendril::sliding_row(*data_, contact, out); }
Anchor PoseProgram::anchor(int contact) const { return tendril::anchor(*data_, contact); }

std::string PoseProgram::row_name(int row) const {
  const auto holds = [row](const auto& block) { return row < block->first() + block->count(); };
  const RowBlock& block = **std::find_if(data_->blocks.begin(), data_->blocks.end(), holds);
  return std::string(block.name()) + " row " + std::to_string(row - block.first() + 1);
}

std::string PoseProgram::variable_name(int variable) const {
  const Layout& at = data_->layout;
  const auto numbered = [](const char* name, int i) { return std::string(name) + " " + std::to_string(i + 1); };
  if (variable < at.first_moment) return numbered("coordinate", variable);
  if (variable < at.first_move) return numbered("moment", variable - at.first_moment);
  if (variable < at.first_arc_length) {
    const Rod::Move& move = data_->spec.rod->moves[static_cast<std::size_t>(variable - at.first_move)];
    if (move.kind == Rod::Move::Kind::shift) return move.along.x != 0.0 ? "base x" : "base y";
    return move.kind == Rod::Move::Kind::turn ? "base angle" : "drawn-in length";
  }
  if (variable < at.first_force) return numbered("contact arc length", variable - at.first_arc_length);
  if (variable == at.palm) return "palm distance";
  if (variable >= at.first_shear) return numbered("tangential contact force", variable - at.first_shear);
  if (variable >= at.first_lean) return numbered("tangential ratio", variable - at.first_lean);
  return numbered("contact force", variable - at.first_force);
}

void PoseProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  Data& d = *data_;
  const bool same = d.kept && (d.differentiated || !derivatives) && x == d.evaluated_at;
  d.kept = false;
  if (!same) {
    d.evaluated = false;
    d.move(x);
    if (derivatives) d.differentiate();
    for (const std::unique_ptr<RowBlock>& block : d.blocks) {
      block->evaluate(x, derivatives, out.constraints.segment(block->first(), block->count()),
                      out.jacobian.middleRows(block->first(), block->count()));
    }
    d.evaluated = true;
    d.differentiated = derivatives;
    d.evaluated_at = x;
  }
  d.base.terms.evaluate(d.base.values, out.cost, out.rest, out.residuals);
  if (derivatives) d.base.differentiate_terms(out.gradient, out.rest_gradient, out.residual_jacobian);
}

/// Terms and rows are functions of a few base quantities, whose outer second derivatives are pulled back by rows. What
/// the quantities bend themselves is first derivatives times second ones of places, and that of the rod alone.
void PoseProgram::do_hessian(ConstVectorRef /*x*/, double sigma, ConstVectorRef multipliers, Workspace& out) {
  Data& d = *data_;
  Eigen::MatrixXd& h = out.hessian;
  h.setZero();
  d.base.start_second(sigma);
  std::fill(d.pushes.on.begin(), d.pushes.on.end(), Push{});
  for (const std::unique_ptr<RowBlock>& block : d.blocks) {
    block->add_second(multipliers.segment(block->first(), block->count()), h);
  }
  d.base.add_deviations_second(h);
  d.base.add_pushes(d.pushes);
  d.base.pull_back(h);
  const int q = d.layout.coordinates;
  const int s = d.layout.slides();
  const int first = d.layout.first_move;
  d.mixed.setZero();
  const SecondPart by{h.topLeftCorner(q, q), d.mixed, h.block(first, first, s, s)};
  d.places.second_pull_back(d.pushes, &d.forces, by);
  d.places.add_energy_second(d.base.energy_slope(), multipliers.data(), by);
  for (const BaseIndex::Tendon& t : d.base.index.tendons) {
    if (t.turn >= 0) d.places.add_turn_second(t.actuator, d.base.gradient[t.turn], by);
  }
  h.block(0, first, q, s) += d.mixed;
  h.block(first, 0, s, q) += d.mixed.transpose();
}

double PoseProgram::potential(ConstVectorRef x) {
  constraints(x);
  Data& d = *data_;
  Eigen::VectorXd pulled = Eigen::VectorXd::Zero(d.layout.coordinates);
  for (std::size_t a = 0; a < d.moment_variable.size(); ++a) {
    const int actuator = static_cast<int>(a);
    const int i = d.moment_variable[a];
    if (i >= 0) d.places.pull_back_moment(actuator, x[i], d.chain.pull(actuator, x[i]).value, pulled.data());
  }
  return d.places.energy() - d.places.work({{}, d.forces.tip, d.forces.gravity, d.forces.payload, d.forces.dead}) -
         pulled.dot(x.head(d.layout.coordinates));
}

double PoseProgram::turn_along(int actuator) const { return data_->places.turn_along(actuator); }

double PoseProgram::moment_defect(ConstVectorRef x, const Curve& curve) {
  constraints(x);
  Data& d = *data_;
  for (std::size_t a = 0; a < d.moments.size(); ++a) {
    d.moments[a] = d.moment_variable[a] < 0 ? 0.0 : x[d.moment_variable[a]];
  }
  return std::max(d.places.moment_defect(d.forces, d.moments, curve), d.places.stretch_defect(d.forces, d.moments));
}

void PoseProgram::sliding_force(int contact, VectorRef out) const {
  const Data& d = *data_;
  const ContactState& c = d.contacts[static_cast<std::size_t>(contact)];
  const auto turning = d.base.row(d.base.index.contacts[static_cast<std::size_t>(contact)].point.angle);
  const int n = d.layout.coordinates;
  const Vec2 tau = turned(c.surface.normal);
  const double along = c.surface.curvature * dot(tau, c.tangent);
  const double tangential = c.force * c.lean + c.shear;
  const Vec2 force = c.force * c.surface.normal + tangential * tau;
  out = d.contact_row(contact, along * turned(force)).head(n);
  out += (dot(turned(c.tangent), force) - tangential * c.radius.slope) * turning.head(n).transpose();
  const double couple = -tangential * c.radius.value;
  if (couple == 0.0 && d.chain.stretches() == 0) return;
  Eigen::VectorXd bending = Eigen::VectorXd::Zero(d.variables);
  const int place = d.contact_places[static_cast<std::size_t>(contact)];
  const Places::Side side = convex_side(d, contact);
  d.places.add_curvature_row(place, side, couple / side.stretch, d.part(bending.data()));
  if (d.chain.stretches() > 0) {
    d.places.add_stretch_row(place, side, dot(c.tangent, force) / side.stretch, d.part(bending.data()));
  }
  out += bending.head(n);
}

bool PoseProgram::dissipates(int contact) const {
  const ContactState& c = data_->contacts[static_cast<std::size_t>(contact)];
  // How far a thick body rolls depends on how it was bent on the way, and one that stretches on how it was stretched.
  const bool by_history = c.radius.value != 0.0 || data_->chain.stretches() > 0;
  return (c.lean != 0.0 && c.force != 0.0) || (c.shear != 0.0 && by_history);
}

bool PoseProgram::has_friction() const {
  for (int k = 0; k < data_->layout.forces; ++k) {
    if (dissipates(k)) return true;
  }
  return false;
}

double PoseProgram::contact_convexity(int contact) const {
  if (data_->spec.contacts[static_cast<std::size_t>(contact)].at_tip) return infinity;
  return convexity(*data_, contact, convex_side(*data_, contact));
}

double PoseProgram::contact_convexity(int contact, VectorRef gradient) const {
  const Places::Side side = convex_side(*data_, contact);
  convexity_gradient(*data_, contact, side, gradient);
  return convexity(*data_, contact, side);
}

}  // namespace tendril
