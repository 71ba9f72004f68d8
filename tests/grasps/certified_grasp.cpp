#include "certified_grasp.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "scene/make_rod.hpp"
#include "tendril/grasp.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::grasps {
namespace {

/// A variable this near to a limit stands at it.
constexpr double at_limit = 1e-9;

std::vector<int> free_variables(const NonlinearProgram& program, const Eigen::VectorXd& x) {
  std::vector<int> free;
  for (int i = 0; i < program.variable_count(); ++i) {
    if (x[i] > program.lower()[i] + at_limit && x[i] < program.upper()[i] - at_limit) free.push_back(i);
  }
  return free;
}

std::vector<int> equalities(const NonlinearProgram& program) {
  std::vector<int> rows;
  for (int i = 0; i < program.row_count(); ++i) {
    if (program.row_lower()[i] == program.row_upper()[i]) rows.push_back(i);
  }
  return rows;
}

std::string text_of(const Certificate& certificate) {
  std::string text;
  for (const std::string& line : certificate.failures) text += "\n  " + line;
  return text;
}

}  // namespace

Finger::Finger(const Scene& scene, const Plan& plan, bool mirrored)
    : parts(plugins::make_components(combination::registry(), scene)),
      scale(scale_of(scene)),
      rod(make_rod(scene, scale)),
      object_({0.0, 0.0}, 0.5 * scene.gripper->object_diameter / scale.length) {
  rod.base = {0.0, scene.gripper->half_palm / scale.length};
  rod.base_angle = scene.gripper->finger_angle;
  move_palm(0.0);
  spec.rod = &rod;
  spec.model = parts.coordinates.get();
  spec.obstacles = {&object_, palm_.get()};
  if (mirrored) {
    move_axis(0.0);
    spec.obstacles = {&object_, axis_.get(), palm_.get()};
  }
  spec.carried = 1;
  for (std::size_t i = 0; i < parts.terms.size(); ++i) {
    spec.terms.push_back({parts.terms[i].get(), scene.objectives[i].weight, scene.objectives[i].plugin});
  }
  const PlannedContact& contact = plan.contacts.at(0);
  const double s = contact.arc_length / scale.length;
  const std::vector<double> knots = rod.fixed_knots();
  const auto stretch = std::upper_bound(knots.begin() + 1, knots.end() - 1, s) - knots.begin() - 1;
  spec.contacts = {{0, contact.at_tip, contact.at_tip ? 0 : static_cast<int>(stretch)}};
  // Twice as many as planning uses: with twice these again no number of a certificate changes by more than rounding.
  spec.nodes = 48;
  spec.max_force = scene.contact.max_force / scale.force();
  spec.min_force = 1e-3 * spec.max_force;
  palm_distance = plan.grasp->palm_distance / scale.length;
  spec.palm = PalmSetup{{1.0, 0.0}, 0.5 * palm_distance, 2.0 * palm_distance, true};
  force = contact.force / scale.force();

  std::vector<double> values = plan.coordinates;
  for (const double u : plan.moments) values.push_back(u / scale.moment());
  if (!contact.at_tip) values.push_back(s);
  values.push_back(force);
  values.push_back(palm_distance);
  x = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void Finger::move_palm(double by) {
  palm_ = std::make_unique<Wall>(Vec2{by, 0.0}, Vec2{1.0, 0.0});
  if (!spec.obstacles.empty()) spec.obstacles.back() = palm_.get();
}

void Finger::move_axis(double by) {
  axis_ = std::make_unique<Wall>(Vec2{0.0, by}, Vec2{0.0, 1.0});
  if (spec.obstacles.size() == 3) spec.obstacles[1] = axis_.get();
}

std::unique_ptr<Finger> mirrored_grasp(const Scene& scene) {
  const Plan plan = combination::plan(scene);
  EXPECT_TRUE(combination::certified(plan));
  auto finger = std::make_unique<Finger>(scene, plan, true);
  PoseProgram program(finger->spec);
  program.set_branch(0, Branch::touching);
  finger->x = moved(program, finger->x);
  return finger;
}

Pair::Pair(const Scene& scene, const std::string& mode) {
  Problem problem = combination::problem(scene);
  PlanControl control;
  for (const Description::Mode& other : problem.describe().modes) {
    if (other.name != mode) control.without.push_back(other.name);
  }
  const Plan plan = problem.plan(control);
  EXPECT_TRUE(combination::certified(plan));
  const Scale whole = scale_of(scene);
  for (std::size_t which = 0; which < 2; ++which) {
    const FingerName name = which == 0 ? FingerName::upper : FingerName::lower;
    const Scene own = finger_of(scene, name);
    fingers[which] = std::make_unique<Finger>(own, plan_of_finger(scene, plan, name), false);
    Finger& f = *fingers[which];
    f.spec.term_units = {f.scale.length / whole.length, f.scale.force() / whole.force()};
    force_ = f.force * f.spec.term_units.force;
    palm_distance_ = plan.grasp->palm_distance / whole.length;
  }
  palm_minimum = 0.5 * palm_distance_;
  palm_maximum = 2.0 * palm_distance_;
}

GraspProgramSpec Pair::spec() const {
  GraspProgramSpec made;
  made.fingers = {fingers[0]->spec, fingers[1]->spec};
  made.palm_minimum = palm_minimum;
  made.palm_maximum = palm_maximum;
  made.separations = separations;
  return made;
}

Eigen::VectorXd Pair::x(const GraspProgram& program) const {
  // The fingers share force and palm distance, which come last.
  Eigen::VectorXd x(program.variable_count());
  Eigen::Index at = 0;
  for (const auto& finger : fingers) {
    const Eigen::Index own = finger->x.size() - 2;
    x.segment(at, own) = finger->x.head(own);
    at += own;
  }
  x[at] = force_;
  x[at + 1] = palm_distance_;
  return x;
}

int row_named(const NonlinearProgram& program, const std::string& name) {
  for (int i = 0; i < program.row_count(); ++i) {
    if (program.row_name(i) == name) return i;
  }
  ADD_FAILURE() << "no row is called '" << name << "'";
  return 0;
}

Eigen::VectorXd moved(NonlinearProgram& program, Eigen::VectorXd x, int row, double value) {
  const std::vector<int> free = free_variables(program, x);
  std::vector<int> rows = equalities(program);
  if (row >= 0 && std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(row);
  double left = infinity;
  for (int step = 0; step < 12; ++step) {
    Eigen::VectorXd wrong = program.constraints(x)(rows);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i] == row) wrong[static_cast<Eigen::Index>(i)] -= value;
    }
    left = wrong.cwiseAbs().maxCoeff();
    if (left < 1e-14) break;
    const Eigen::MatrixXd jacobian = program.jacobian(x)(rows, free);
    const Eigen::VectorXd change = jacobian.completeOrthogonalDecomposition().solve(wrong);
    for (std::size_t i = 0; i < free.size(); ++i) x[free[i]] -= change[static_cast<Eigen::Index>(i)];
  }
  EXPECT_LT(left, 1e-12) << "the rows could not be brought to their values";
  return x;
}

Eigen::VectorXd pushed_to_margin(const Eigen::VectorXd& x, double wanted,
                                 const std::function<Eigen::VectorXd(double push, const Eigen::VectorXd& from)>& pushed,
                                 const std::function<double(const Eigen::VectorXd& x)>& margin) {
  Eigen::VectorXd stable = x;
  double push = 0.0;
  double step = 1.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::VectorXd next = pushed(push + step, stable);
    const double value = margin(next);
    if (std::abs(value - wanted) <= 0.1 * tolerance::stability) return next;
    if (value > wanted) {
      stable = next;
      push += step;
    } else {
      step *= 0.5;
    }
  }
  ADD_FAILURE() << "no push leaves a margin of " << wanted << "; the last one was " << push;
  return stable;
}

double slope_left(NonlinearProgram& program, const Eigen::VectorXd& x) {
  const std::vector<int> free = free_variables(program, x);
  const std::vector<int> rows = equalities(program);
  const Eigen::MatrixXd normals = Eigen::MatrixXd(program.jacobian(x)(rows, free)).transpose();
  const Eigen::VectorXd slope = program.gradient(x)(free);
  return (slope - normals * normals.completeOrthogonalDecomposition().solve(slope)).cwiseAbs().maxCoeff();
}

std::vector<Refusal> refusals(const Certificate& certificate) {
  std::vector<Refusal> all;
  for (const std::string& line : certificate.failures) {
    const std::string margin = "unstable: the stability margin is ";
    const std::size_t above = line.find(" is above ");
    if (line.rfind(margin, 0) == 0) {
      all.push_back({"stability", std::stod(line.substr(margin.size()))});
    } else if (above != std::string::npos) {
      const std::size_t number = line.rfind(' ', above - 1);
      all.push_back({line.substr(0, number), std::stod(line.substr(number + 1))});
    } else {
      all.push_back({line, 0.0});
    }
  }
  return all;
}

void expect_refused(const Certificate& certificate, const std::vector<std::string>& names, double number,
                    double share) {
  const std::vector<Refusal> all = refusals(certificate);
  EXPECT_FALSE(certificate.valid());
  for (const std::string& name : names) {
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Refusal& r) { return r.name == name; }))
        << "expected '" << name << "' among the failures:" << text_of(certificate);
  }
  EXPECT_EQ(all.size(), names.size()) << text_of(certificate);
  for (const Refusal& r : all) {
    if (r.name != names.front()) continue;
    EXPECT_NEAR(r.number, number, share * std::abs(number)) << r.name;
  }
}

void expect_accepted(const Certificate& certificate) { EXPECT_TRUE(certificate.valid()) << text_of(certificate); }

}  // namespace tendril::grasps
