#include "program/grasp_program.hpp"

#include <algorithm>
#include <cmath>

#include "obstacle/wall.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

constexpr std::array<const char*, 2> finger_names{"upper finger: ", "lower finger: "};

}  // namespace

struct GraspProgram::Data {
  explicit Data(const GraspProgramSpec& s);

  /// A finger's own program and where it stands in the whole.
  struct Finger {
    std::unique_ptr<PoseProgram> program;
    int first_variable = 0;   ///< of its own ones in the whole
    int own_variables = 0;    ///< coordinates, moments and arc length: the first ones of the finger's program
    int first_row = 0;        ///< of its own ones in the whole
    int own_rows = 0;         ///< the first ones of the finger's program
    int separation = 0;       ///< first row of the finger's program that is half of a separation
    int balance = 0;          ///< first row of the finger's program
    int residual = 0;         ///< first one in the whole
    double force_unit = 1.0;  ///< of the finger's program in that of the grasp
    double length_unit = 1.0;
    /// Variables of the finger's program, and where they stand in the whole, in this unit.
    struct Part {
      int from = 0, to = 0, count = 0;
      double unit = 1.0;
    };
    std::vector<Part> parts;
    std::array<double, 3> shares{};  ///< of its rows of balance in those of the whole
    Eigen::VectorXd x, multipliers;

    void move(ConstVectorRef whole) {
      for (const Part& p : parts) x.segment(p.from, p.count) = whole.segment(p.to, p.count) / p.unit;
    }
  };

  GraspProgramSpec spec;
  std::vector<std::unique_ptr<Wall>> directions;
  std::array<Finger, 2> fingers;
  int variables = 0, rows = 0, residuals = 0;
  int force_variable = -1, lean_variable = -1, palm_variable = -1;
  int first_separation = 0, balance = 0, balances = 1;

 private:
  void share_variables(bool fixed);
};

GraspProgram::Data::Data(const GraspProgramSpec& s) : spec(s) {
  const bool fixed = spec.palm_minimum == spec.palm_maximum;
  const bool loaded = norm(spec.load) != 0.0;
  const bool rubs = !spec.fingers[0].friction.empty();
  if (loaded) balances = rubs ? 3 : 2;
  for (int which = 0; which < 2; ++which) {
    Finger& f = fingers[static_cast<std::size_t>(which)];
    PoseProgramSpec& own = spec.fingers[static_cast<std::size_t>(which)];
    if (own.contacts.size() != 1 || !own.palm) throw Error("a finger of a grasp needs one contact and a palm");
    f.force_unit = own.term_units.force;
    f.length_unit = own.term_units.length;
    own.palm->minimum = spec.palm_minimum / f.length_unit;
    own.palm->maximum = spec.palm_maximum / f.length_unit;
    own.palm->balance = true;
    own.palm->loaded = loaded;
    own.palm->load = 0.0;
    own.palm->parts = balances;
    PoseProgramSpec with_separations = own;
    for (const FingerSeparation& separation : spec.separations) {
      // Across the axis the lower finger is mirrored, and it lies on the other side.
      const Vec2 n = separation.normal;
      directions.push_back(std::make_unique<Wall>(Vec2{}, which == 0 ? n : Vec2{-n.x, n.y}));
      with_separations.obstacles.push_back(directions.back().get());
      with_separations.checks.push_back({which == 0 ? separation.upper_piece : separation.lower_piece,
                                         which == 0 ? separation.upper_sigma : separation.lower_sigma,
                                         static_cast<int>(with_separations.obstacles.size()) - 1});
      ++with_separations.carried;
      ++with_separations.measures;
    }
    f.program = std::make_unique<PoseProgram>(with_separations);
    f.program->set_branch(0, Branch::touching);
    const PoseProgram::Layout& at = f.program->layout();
    f.own_variables = loaded ? at.first_lean + at.leans : at.first_force;
    if ((at.palm >= 0) == fixed) throw Error("the palm of a grasp stands still for one finger only");
    f.own_rows = f.separation = at.first_check + static_cast<int>(own.checks.size());
    f.balance = at.first_balance;
    // Directions count alike; across the axis and about the centre the lower finger's image is turned round.
    const double side = which == 0 ? 1.0 : -1.0;
    f.shares = {loaded ? f.force_unit : 1.0, side * f.force_unit, side * f.force_unit};
    f.first_variable = variables;
    f.first_row = rows;
    f.residual = residuals;
    variables += f.own_variables;
    rows += f.own_rows;
    residuals += f.program->residual_count();
    f.x.setZero(f.program->variable_count());
    f.multipliers.setZero(f.program->row_count());
  }
  share_variables(fixed);
  first_separation = rows;
  rows += static_cast<int>(spec.separations.size());
  balance = rows;
  rows += balances;
}

void GraspProgram::Data::share_variables(bool fixed) {
  if (balances == 1) force_variable = variables++;
  if (balances == 1 && !spec.fingers[0].friction.empty()) lean_variable = variables++;
  if (!fixed) palm_variable = variables++;
  for (Finger& f : fingers) {
    const PoseProgram::Layout& at = f.program->layout();
    f.parts.push_back({0, f.first_variable, f.own_variables, 1.0});
    if (force_variable >= 0) f.parts.push_back({at.first_force, force_variable, 1, f.force_unit});
    if (lean_variable >= 0) f.parts.push_back({at.first_lean, lean_variable, 1, 1.0});
    if (palm_variable >= 0) f.parts.push_back({at.palm, palm_variable, 1, f.length_unit});
  }
}

GraspProgram::GraspProgram(const GraspProgramSpec& spec) : GraspProgram(std::make_unique<Data>(spec)) {}

GraspProgram::GraspProgram(std::unique_ptr<Data> data)
    : NonlinearProgram(data->variables, data->rows, data->residuals), data_(std::move(data)) {
  Data& d = *data_;
  for (const int shared : {d.force_variable, d.lean_variable}) {
    if (shared < 0) continue;
    lower_[shared] = -infinity;
    upper_[shared] = infinity;
  }
  for (const Data::Finger& f : d.fingers) {
    const PoseProgram& program = *f.program;
    lower_.segment(f.first_variable, f.own_variables) = program.lower().head(f.own_variables);
    upper_.segment(f.first_variable, f.own_variables) = program.upper().head(f.own_variables);
    row_lower_.segment(f.first_row, f.own_rows) = program.row_lower().head(f.own_rows);
    row_upper_.segment(f.first_row, f.own_rows) = program.row_upper().head(f.own_rows);
    for (const Data::Finger::Part& p : f.parts) {
      if (p.to != d.force_variable && p.to != d.lean_variable) continue;
      lower_[p.to] = std::max(lower_[p.to], program.lower()[p.from] * p.unit);
      upper_[p.to] = std::min(upper_[p.to], program.upper()[p.from] * p.unit);
    }
  }
  if (d.palm_variable >= 0) {
    lower_[d.palm_variable] = d.spec.palm_minimum;
    upper_[d.palm_variable] = d.spec.palm_maximum;
  }
  row_upper_.segment(d.first_separation, static_cast<Eigen::Index>(d.spec.separations.size())).setConstant(infinity);
}

GraspProgram::~GraspProgram() = default;

const GraspProgramSpec& GraspProgram::spec() const { return data_->spec; }
PoseProgram& GraspProgram::finger(int which) { return *data_->fingers[static_cast<std::size_t>(which)].program; }
const PoseProgram& GraspProgram::finger(int which) const {
  return *data_->fingers[static_cast<std::size_t>(which)].program;
}
int GraspProgram::palm_variable() const { return data_->palm_variable; }
int GraspProgram::balance_row() const { return data_->balance; }
int GraspProgram::first_separation() const { return data_->first_separation; }
double GraspProgram::force(ConstVectorRef x) const { return x[data_->force_variable]; }

double GraspProgram::palm_distance(ConstVectorRef x) const {
  return data_->palm_variable < 0 ? data_->spec.palm_minimum : x[data_->palm_variable];
}

Eigen::VectorXd GraspProgram::finger_point(int which, ConstVectorRef x) const {
  Data::Finger& f = data_->fingers[static_cast<std::size_t>(which)];
  f.move(x);
  return f.x;
}

Eigen::VectorXd GraspProgram::start_from(const StartShape& upper, const StartShape& lower) const {
  const Data& d = *data_;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(variable_count());
  double force = infinity;
  for (int which = 0; which < 2; ++which) {
    const Data::Finger& f = d.fingers[static_cast<std::size_t>(which)];
    const PoseProgram::Layout& at = f.program->layout();
    const Eigen::VectorXd own = f.program->start_from(which == 0 ? upper : lower);
    x.segment(f.first_variable, f.own_variables) = own.head(f.own_variables);
    force = std::min(force, own[at.first_force] * f.force_unit);
    if (d.lean_variable >= 0) x[d.lean_variable] += 0.5 * own[at.first_lean];
    if (d.palm_variable >= 0) x[d.palm_variable] += 0.5 * own[at.palm] * f.length_unit;
  }
  if (d.force_variable >= 0) x[d.force_variable] = force;
  return x.cwiseMax(lower_).cwiseMin(upper_);
}

std::string GraspProgram::row_name(int row) const {
  const Data& d = *data_;
  if (row >= d.balance) return "force_balance row " + std::to_string(row - d.balance + 1);
  if (row >= d.first_separation) return "finger_clearance row " + std::to_string(row - d.first_separation + 1);
  const std::size_t which = row < d.fingers[1].first_row ? 0 : 1;
  return finger_names[which] + d.fingers[which].program->row_name(row - d.fingers[which].first_row);
}

std::string GraspProgram::variable_name(int variable) const {
  const Data& d = *data_;
  if (variable == d.force_variable) return "contact force";
  if (variable == d.lean_variable) return "tangential ratio";
  if (variable == d.palm_variable) return "palm distance";
  const std::size_t which = variable < d.fingers[1].first_variable ? 0 : 1;
  return finger_names[which] + d.fingers[which].program->variable_name(variable - d.fingers[which].first_variable);
}

void GraspProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  Data& d = *data_;
  const auto separations = static_cast<Eigen::Index>(d.spec.separations.size());
  out.cost = 0.0;
  out.rest = 0.0;
  out.constraints.tail(separations + d.balances).setZero();
  const std::array<double, 3> load{d.spec.load.x, d.spec.load.y, 0.0};
  for (int part = 0; part < d.balances; ++part)
    out.constraints[d.balance + part] = -load[static_cast<std::size_t>(part)];
  for (Data::Finger& f : d.fingers) {
    PoseProgram& program = *f.program;
    f.move(x);
    // Derivatives bring the values along.
    if (derivatives) (void)program.jacobian(f.x);
    const VectorView c = program.constraints(f.x);
    out.cost += program.cost(f.x);
    out.rest += program.rest(f.x);
    out.constraints.segment(f.first_row, f.own_rows) = c.head(f.own_rows);
    out.constraints.segment(d.first_separation, separations) += f.length_unit * c.segment(f.separation, separations);
    for (int part = 0; part < d.balances; ++part) {
      out.constraints[d.balance + part] += f.shares[static_cast<std::size_t>(part)] * c[f.balance + part];
    }
    out.residuals.segment(f.residual, program.residual_count()) = program.residuals(f.x);
  }
  if (!derivatives) return;
  out.jacobian.setZero();
  out.gradient.setZero();
  out.rest_gradient.setZero();
  out.residual_jacobian.setZero();
  for (Data::Finger& f : d.fingers) {
    PoseProgram& program = *f.program;
    const MatrixView jacobian = program.jacobian(f.x);
    const VectorView gradient = program.gradient(f.x);
    const VectorView rest = program.rest_gradient(f.x);
    const MatrixView residual = program.residual_jacobian(f.x);
    for (const auto& [from, to, count, unit] : f.parts) {
      const double factor = 1.0 / unit;
      out.jacobian.block(f.first_row, to, f.own_rows, count) += factor * jacobian.block(0, from, f.own_rows, count);
      out.jacobian.block(d.first_separation, to, separations, count) +=
          (factor * f.length_unit) * jacobian.block(f.separation, from, separations, count);
      for (int part = 0; part < d.balances; ++part) {
        out.jacobian.block(d.balance + part, to, 1, count) +=
            (factor * f.shares[static_cast<std::size_t>(part)]) * jacobian.block(f.balance + part, from, 1, count);
      }
      out.gradient.segment(to, count) += factor * gradient.segment(from, count);
      out.rest_gradient.segment(to, count) += factor * rest.segment(from, count);
      out.residual_jacobian.block(f.residual, to, residual.rows(), count) += factor * residual.middleCols(from, count);
    }
  }
}

void GraspProgram::do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) {
  Data& d = *data_;
  const auto separations = static_cast<Eigen::Index>(d.spec.separations.size());
  out.hessian.setZero();
  for (Data::Finger& f : d.fingers) {
    f.move(x);
    f.multipliers.setZero();
    f.multipliers.head(f.own_rows) = multipliers.segment(f.first_row, f.own_rows);
    f.multipliers.segment(f.separation, separations) =
        f.length_unit * multipliers.segment(d.first_separation, separations);
    for (int part = 0; part < d.balances; ++part) {
      f.multipliers[f.balance + part] = f.shares[static_cast<std::size_t>(part)] * multipliers[d.balance + part];
    }
    const MatrixView h = f.program->hessian(f.x, sigma, f.multipliers);
    for (const Data::Finger::Part& a : f.parts) {
      for (const Data::Finger::Part& b : f.parts) {
        out.hessian.block(a.to, b.to, a.count, b.count) +=
            ((1.0 / a.unit) * (1.0 / b.unit)) * h.block(a.from, b.from, a.count, b.count);
      }
    }
  }
}

Vec2 net_force(const GraspProgram& program) {
  Vec2 sum{};
  for (int which = 0; which < 2; ++which) {
    const double unit = program.spec().fingers[static_cast<std::size_t>(which)].term_units.force;
    for (const PoseProgram::ContactState& c : program.finger(which).contacts()) {
      const Vec2 n = c.push;
      sum += -unit * c.force * (which == 0 ? n : Vec2{n.x, -n.y});
    }
  }
  return sum;
}

double net_moment(const GraspProgram& program) {
  double sum = 0.0;
  for (int which = 0; which < 2; ++which) {
    const double unit = program.spec().fingers[static_cast<std::size_t>(which)].term_units.force;
    for (const PoseProgram::ContactState& c : program.finger(which).contacts()) {
      sum += (which == 0 ? -unit : unit) * c.force * c.lean;
    }
  }
  return sum;
}

}  // namespace tendril
