#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "certificate/certifier.hpp"
#include "program/pose_program.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"

/// Plans that are right but for one thing, and other means of computing what a certificate says of them.
namespace tendril::support {

/// Squares of the tip's distance to a point and of the moment's to a value, and multiples of moment and force.
class Wish : public ObjectiveBase<Wish> {
 public:
  Vec2 tip{};
  double tip_weight = 0.0, moment = 0.0, moment_weight = 0.0, per_moment = 0.0, per_force = 0.0;
  Reads reads() const override;
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.smooth(tip_weight * ((x.tip.x - tip.x) * (x.tip.x - tip.x) + (x.tip.y - tip.y) * (x.tip.y - tip.y)));
    for (const T& u : x.moments) {
      out.smooth(moment_weight * (u - moment) * (u - moment));
      out.smooth(per_moment * u);
    }
    for (const ContactQuantities<T>& c : x.contacts) out.smooth(per_force * c.force);
  }
};

/// A value asked of a row or a variable of a program.
struct Demand {
  enum Kind { row, variable } kind = row;
  int index = 0;
  double value = 0.0;
};

/// One pose program with what it points to. Contacts touch.
struct Pose {
  explicit Pose(int order = 8) : basis(order) { rod.actuators.resize(1); }
  Pose(const Pose&) = delete;
  Pose& operator=(const Pose&) = delete;

  /// Builds the program of `rod`, `obstacles`, `contacts` and `spec`'s other entries; x keeps its value if it fits.
  void assemble();
  /// The nearest point at which equilibrium, gaps and closest points are met but for what is demanded otherwise.
  Eigen::VectorXd meet(const Eigen::VectorXd& from, const std::vector<Demand>& demands = {});
  /// From there to a minimum of the wish.
  void plan();
  Certificate judge(const Eigen::VectorXd& at, const Eigen::VectorXd* multipliers = nullptr,
                    const Eigen::VectorXd* bound_multipliers = nullptr) const;
  int force() const { return program->layout().first_force; }
  int place() const { return program->layout().first_arc_length; }
  int moment() const { return program->layout().first_moment; }
  int gap() const { return program->layout().first_gap; }
  int closest() const { return program->layout().first_closest; }
  int add(std::unique_ptr<Obstacle> obstacle);

  Rod rod;
  LegendreBasis basis;
  std::vector<std::unique_ptr<Obstacle>> obstacles;
  Wish wish;
  PoseProgramSpec spec;
  std::unique_ptr<PoseProgram> program;
  Eigen::VectorXd x, multipliers, bound_multipliers;  ///< the plan and its multipliers
};

/// A heavy arm that rests on a peg: the braced arm of model.md section 6 in round numbers.
std::unique_ptr<Pose> braced_pose();

/// A uniform rod of one or two Legendre pieces by textbook formulas: std::legendre and a composite Gauss rule of five
/// points, nothing of the library.
struct PlainRod {
  int order = 0;
  double weight = 0.0;  ///< along -y
  Vec2 base{}, tip_force{};
  double base_angle = 0.0;
  std::vector<double> ends{1.0};  ///< of the pieces

  double angle(const Eigen::VectorXd& q, double s) const;
  double curvature(const Eigen::VectorXd& q, double s) const;
  Vec2 point(const Eigen::VectorXd& q, double s) const;
  /// Pi of model.md section 3 with one actuator over the whole rod.
  double energy(const Eigen::VectorXd& q, double moment) const;

 private:
  template <class F>
  auto integral(double from, double to, const F& f) const;
};
/// The rod of a pose as it lies at x.
PlainRod plain(const Pose& pose, const Eigen::VectorXd& x);

/// Valid, or what is wrong.
testing::AssertionResult certified(const Certificate& c);
/// Refused by exactly one line that begins with `name` and holds `value` to a share of `tolerance`.
testing::AssertionResult refused(const Certificate& c, const std::string& name, double value, double tolerance = 0.02);

}  // namespace tendril::support
