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
    int balance = 0;          ///< row of the finger's program
    int residual = 0;         ///< first one in the whole
    double force_unit = 1.0;  ///< of the finger's program in that of the grasp
    double length_unit = 1.0;
    bool palm = false;  ///< its program has a variable for the palm distance
    Eigen::VectorXd x, multipliers;

    void move(ConstVectorRef whole, int force, int distance) {
      x.head(own_variables) = whole.segment(first_variable, own_variables);
      x[own_variables] = whole[force] / force_unit;
      if (palm) x[own_variables + 1] = whole[distance] / length_unit;
    }
  };

  GraspProgramSpec spec;
  std::vector<std::unique_ptr<Wall>> directions;
  std::array<Finger, 2> fingers;
  int variables = 0, rows = 0, residuals = 0;
  int force_variable = 0, palm_variable = -1;
  int first_separation = 0, balance = 0;
};

GraspProgram::Data::Data(const GraspProgramSpec& s) : spec(s) {
  const bool fixed = spec.palm_minimum == spec.palm_maximum;
  for (int which = 0; which < 2; ++which) {
    Finger& f = fingers[static_cast<std::size_t>(which)];
    PoseProgramSpec& own = spec.fingers[static_cast<std::size_t>(which)];
    if (own.contacts.size() != 1 || !own.palm) throw Error("a finger of a grasp needs one contact and a palm");
    f.force_unit = own.term_units.force;
    f.length_unit = own.term_units.length;
    own.palm->minimum = spec.palm_minimum / f.length_unit;
    own.palm->maximum = spec.palm_maximum / f.length_unit;
    own.palm->balance = true;
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
    f.own_variables = at.first_force;
    f.palm = at.palm >= 0;
    if (f.palm == fixed) throw Error("the palm of a grasp stands still for one finger only");
    f.own_rows = f.separation = at.first_check + static_cast<int>(own.checks.size());
    f.balance = at.first_balance;
    f.first_variable = variables;
    f.first_row = rows;
    f.residual = residuals;
    variables += f.own_variables;
    rows += f.own_rows;
    residuals += f.program->residual_count();
    f.x.setZero(f.program->variable_count());
    f.multipliers.setZero(f.program->row_count());
  }
  force_variable = variables++;
  if (!fixed) palm_variable = variables++;
  first_separation = rows;
  rows += static_cast<int>(spec.separations.size());
  balance = rows++;
}

GraspProgram::GraspProgram(const GraspProgramSpec& spec) : GraspProgram(std::make_unique<Data>(spec)) {}

GraspProgram::GraspProgram(std::unique_ptr<Data> data)
    : NonlinearProgram(data->variables, data->rows, data->residuals), data_(std::move(data)) {
  Data& d = *data_;
  lower_[d.force_variable] = 0.0;
  upper_[d.force_variable] = infinity;
  for (const Data::Finger& f : d.fingers) {
    const PoseProgram& program = *f.program;
    lower_.segment(f.first_variable, f.own_variables) = program.lower().head(f.own_variables);
    upper_.segment(f.first_variable, f.own_variables) = program.upper().head(f.own_variables);
    row_lower_.segment(f.first_row, f.own_rows) = program.row_lower().head(f.own_rows);
    row_upper_.segment(f.first_row, f.own_rows) = program.row_upper().head(f.own_rows);
    double& low = lower_[d.force_variable];
    double& high = upper_[d.force_variable];
    low = std::max(low, program.lower()[f.own_variables] * f.force_unit);
    high = std::min(high, program.upper()[f.own_variables] * f.force_unit);
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
  f.move(x, data_->force_variable, data_->palm_variable);
  return f.x;
}

Eigen::VectorXd GraspProgram::start_from(const StartShape& upper, const StartShape& lower) const {
  const Data& d = *data_;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(variable_count());
  double force = infinity;
  for (int which = 0; which < 2; ++which) {
    const Data::Finger& f = d.fingers[static_cast<std::size_t>(which)];
    const Eigen::VectorXd own = f.program->start_from(which == 0 ? upper : lower);
    x.segment(f.first_variable, f.own_variables) = own.head(f.own_variables);
    force = std::min(force, own[f.own_variables] * f.force_unit);
    if (f.palm) x[d.palm_variable] += 0.5 * own[f.own_variables + 1] * f.length_unit;
  }
  x[d.force_variable] = force;
  return x.cwiseMax(lower_).cwiseMin(upper_);
}

std::string GraspProgram::row_name(int row) const {
  const Data& d = *data_;
  if (row == d.balance) return "force_balance row 1";
  if (row >= d.first_separation) return "finger_clearance row " + std::to_string(row - d.first_separation + 1);
  const std::size_t which = row < d.fingers[1].first_row ? 0 : 1;
  return finger_names[which] + d.fingers[which].program->row_name(row - d.fingers[which].first_row);
}

std::string GraspProgram::variable_name(int variable) const {
  const Data& d = *data_;
  if (variable == d.force_variable) return "contact force";
  if (variable == d.palm_variable) return "palm distance";
  const std::size_t which = variable < d.fingers[1].first_variable ? 0 : 1;
  return finger_names[which] + d.fingers[which].program->variable_name(variable - d.fingers[which].first_variable);
}

void GraspProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  Data& d = *data_;
  const auto separations = static_cast<Eigen::Index>(d.spec.separations.size());
  out.cost = 0.0;
  out.rest = 0.0;
  out.constraints.tail(separations + 1).setZero();
  for (Data::Finger& f : d.fingers) {
    PoseProgram& program = *f.program;
    f.move(x, d.force_variable, d.palm_variable);
    // Derivatives bring the values along.
    if (derivatives) (void)program.jacobian(f.x);
    const VectorView c = program.constraints(f.x);
    out.cost += program.cost(f.x);
    out.rest += program.rest(f.x);
    out.constraints.segment(f.first_row, f.own_rows) = c.head(f.own_rows);
    out.constraints.segment(d.first_separation, separations) += f.length_unit * c.segment(f.separation, separations);
    out.constraints[d.balance] += c[f.balance];
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
    // Columns of the finger's program: its own variables side by side, then the shared ones.
    const auto column = [&](Eigen::Index from, Eigen::Index to, Eigen::Index count, double factor) {
      out.jacobian.block(f.first_row, to, f.own_rows, count) += factor * jacobian.block(0, from, f.own_rows, count);
      out.jacobian.block(d.first_separation, to, separations, count) +=
          (factor * f.length_unit) * jacobian.block(f.separation, from, separations, count);
      out.jacobian.block(d.balance, to, 1, count) += factor * jacobian.block(f.balance, from, 1, count);
      out.gradient.segment(to, count) += factor * gradient.segment(from, count);
      out.rest_gradient.segment(to, count) += factor * rest.segment(from, count);
      out.residual_jacobian.block(f.residual, to, residual.rows(), count) += factor * residual.middleCols(from, count);
    };
    column(0, f.first_variable, f.own_variables, 1.0);
    column(f.own_variables, d.force_variable, 1, 1.0 / f.force_unit);
    if (f.palm) column(f.own_variables + 1, d.palm_variable, 1, 1.0 / f.length_unit);
  }
}

void GraspProgram::do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) {
  Data& d = *data_;
  const auto separations = static_cast<Eigen::Index>(d.spec.separations.size());
  out.hessian.setZero();
  for (Data::Finger& f : d.fingers) {
    f.move(x, d.force_variable, d.palm_variable);
    f.multipliers.setZero();
    f.multipliers.head(f.own_rows) = multipliers.segment(f.first_row, f.own_rows);
    f.multipliers.segment(f.separation, separations) =
        f.length_unit * multipliers.segment(d.first_separation, separations);
    f.multipliers[f.balance] = multipliers[d.balance];
    const MatrixView h = f.program->hessian(f.x, sigma, f.multipliers);
    struct Part {
      Eigen::Index from, to, count;
      double factor;
    };
    const std::array<Part, 3> parts{Part{0, f.first_variable, f.own_variables, 1.0},
                                    Part{f.own_variables, d.force_variable, 1, 1.0 / f.force_unit},
                                    Part{f.own_variables + 1, d.palm_variable, f.palm ? 1 : 0, 1.0 / f.length_unit}};
    for (const Part& a : parts) {
      for (const Part& b : parts) {
        if (a.count == 0 || b.count == 0) continue;
        out.hessian.block(a.to, b.to, a.count, b.count) +=
            (a.factor * b.factor) * h.block(a.from, b.from, a.count, b.count);
      }
    }
  }
}

Vec2 net_force(const GraspProgram& program) {
  Vec2 sum{};
  for (int which = 0; which < 2; ++which) {
    const double unit = program.spec().fingers[static_cast<std::size_t>(which)].term_units.force;
    for (const PoseProgram::ContactState& c : program.finger(which).contacts()) {
      const Vec2 n = c.surface.normal;
      sum += -unit * c.force * (which == 0 ? n : Vec2{n.x, -n.y});
    }
  }
  return sum;
}

}  // namespace tendril
