#include <cmath>

#include "grasp/frames.hpp"
#include "program/equations.hpp"

namespace tendril {
namespace {

constexpr double singular_below = 1e-15;  ///< reciprocal condition of the equations

/// How the held finger answers when the object or a moment moves: derivatives of the force that one finger exerts along
/// an axis.
struct Response {
  double by_object = 0.0;           ///< of -sum f n . axis, by a move of the object along the axis
  std::vector<double> by_moment{};  ///< by each actuator's moment
};

/// The equilibrium of one finger at given moments and place is G(z, p) = 0 with z = (coordinates, places, forces); the
/// object moves along `axis`.
Response response_of(PoseProgramSpec spec, Vec2 axis, double shift, ConstVectorRef x, const PoseProgram& original) {
  // The base stays where it is; a variable of its own moves it against the object along the axis.
  Rod rod = *spec.rod;
  rod.base += original.base_shift() + shift * axis;
  spec.rod = &rod;
  spec.checks.clear();
  spec.terms.clear();
  PalmSetup palm;
  palm.axis = axis;
  palm.minimum = shift - 1.0;
  palm.maximum = shift + 1.0;
  palm.loaded = original.spec().palm->loaded;
  spec.palm = palm;
  PoseProgram program(spec);
  const PoseProgram::Layout& at = program.layout();
  Eigen::VectorXd y(program.variable_count());
  y.head(at.palm) = x.head(at.palm);
  y[at.palm] = shift;
  Equations equations = Equations::of_contacts(program);
  equations.evaluate(y);
  const bool singular = !(equations.factor().rcond() > singular_below);
  const MatrixView jacobian = program.jacobian(y);
  Eigen::MatrixXd rates;
  // The row of one contact is the direction of its push alone (balance_rows.cpp): the force is another factor.
  const bool alone = at.forces == 1 && !palm.loaded;
  const double force = alone ? y[at.first_force] : 1.0;
  const double direction = alone ? program.constraints(y)[at.first_balance] : 0.0;
  const auto derivative = [&](int variable) {
    if (singular) return std::nan("");
    equations.find_rates(y, {variable}, rates);
    double sum = force * jacobian(at.first_balance, variable);
    for (int i = 0; i < equations.size(); ++i) {
      const int unknown = equations.unknown(i);
      sum +=
          (force * jacobian(at.first_balance, unknown) + (unknown == at.first_force ? direction : 0.0)) * rates(i, 0);
    }
    return -sum;
  };
  Response out;
  out.by_object = derivative(at.palm);
  for (std::size_t a = 0; a < spec.rod->actuators.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    out.by_moment.push_back(variable < 0 ? 0.0 : derivative(variable));
  }
  return out;
}

}  // namespace

FingerResponse finger_response(PoseProgram& program, ConstVectorRef x, const Scale& scale) {
  program.constraints(x);
  const Response axial = response_of(program.spec(), {1.0, 0.0}, 0.0, x, program);
  const Response lateral = response_of(program.spec(), {0.0, 1.0}, 0.0, x, program);
  FingerResponse out;
  const double stiffness = scale.force() / scale.length;
  out.axial_stiffness = -axial.by_object * stiffness;
  out.lateral_stiffness = -lateral.by_object * stiffness;
  for (std::size_t a = 0; a < axial.by_moment.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    const double one_percent = variable < 0 ? 0.0 : 0.01 * x[variable];
    out.force_by_moment.push_back(
        {axial.by_moment[a] * one_percent * scale.force(), lateral.by_moment[a] * one_percent * scale.force()});
  }
  return out;
}

void add_finger(GraspQuality& quality, FingerName name, const FingerResponse& response,
                const std::vector<PlannedContact>& contacts, double max_force) {
  quality.axial_stiffness += response.axial_stiffness;
  quality.lateral_stiffness += response.lateral_stiffness;
  // The lower finger's own direction across the axis is the mirror image.
  const double across = name == FingerName::upper ? 1.0 : -1.0;
  for (const Vec2 f : response.force_by_moment) quality.force_by_moment.push_back({f.x, across * f.y});
  for (const PlannedContact& c : contacts) quality.force_margins.push_back(max_force - c.force);
}

}  // namespace tendril
