#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "combination/support.hpp"
#include "obstacle/circle.hpp"
#include "obstacle/wall.hpp"
#include "program/grasp_program.hpp"

/// Planned grasps as points of programs that are assembled here, from the model alone: what a test disturbs, and asks
/// the certificate about.
namespace tendril::grasps {

/// What rounding leaves beside a defect of 1e-9, and the three digits of a message.
inline constexpr double three_digits = 0.01;
/// The clearance bound is sharp to a tenth of what is asked for.
inline constexpr double as_sharp_as_clearance = 0.06;

/// The rod, the bodies and the program of one finger, the object's centre at the origin and the axis along x. All units
/// are the finger's own.
class Finger {
 public:
  /// `scene`: of one finger (finger_of()), with the gripper at the origin, and `plan`: what was planned of it.
  Finger(const Scene& scene, const Plan& plan, bool mirrored);
  Finger(const Finger&) = delete;
  Finger& operator=(const Finger&) = delete;

  /// Moves the wall of the palm, or that of the axis, by so much towards the finger.
  void move_palm(double by);
  void move_axis(double by);

  Components parts;
  Scale scale;
  Rod rod;
  PoseProgramSpec spec;
  /// Coordinates, moments, arc length, force, palm distance.
  Eigen::VectorXd x;
  double force = 0.0, palm_distance = 0.0;

 private:
  Circle object_;
  std::unique_ptr<Wall> axis_, palm_;
};

/// A grasp of one mirrored finger, planned.
std::unique_ptr<Finger> mirrored_grasp(const Scene& scene);

/// A grasp of both fingers, planned.
struct Pair {
  /// `mode`: the pair of ways of touching that is planned, alone.
  Pair(const Scene& scene, const std::string& mode);
  std::array<std::unique_ptr<Finger>, 2> fingers;
  GraspProgramSpec spec() const;
  std::vector<FingerSeparation> separations{};
  double palm_minimum = 0.0, palm_maximum = 0.0;  ///< units of the grasp
  /// The point of a program with `spec()`.
  Eigen::VectorXd x(const GraspProgram& program) const;

 private:
  double force_ = 0.0, palm_distance_ = 0.0;
};

/// The row of this name.
int row_named(const NonlinearProgram& program, const std::string& name);

/// Near x, where all equality rows hold, but `row` has the value `value` (a row that is no equality: it and the others
/// together); variables at a limit stay there. Newton on the least change; fails the test where it does not get there.
Eigen::VectorXd moved(NonlinearProgram& program, Eigen::VectorXd x, int row = -1, double value = 0.0);

/// The point where `margin` is `wanted` to a tenth of the limit of stability, or as near as a push can be told: from x,
/// a grasp without push, the push grows until the margin is gone.
Eigen::VectorXd pushed_to_margin(const Eigen::VectorXd& x, double wanted,
                                 const std::function<Eigen::VectorXd(double push, const Eigen::VectorXd& from)>& pushed,
                                 const std::function<double(const Eigen::VectorXd& x)>& margin);

/// Largest entry that is left of the cost's slope along x of equality rows and variables at a limit: least squares of
/// this file's own.
double slope_left(NonlinearProgram& program, const Eigen::VectorXd& x);

/// What a certificate says: a name for each failure ("stability" for the stability margin), and the number with it.
struct Refusal {
  std::string name;
  double number = 0.0;
};
std::vector<Refusal> refusals(const Certificate& certificate);

/// Expects one failure of each name and no others, the first of them with this number up to a share of it.
void expect_refused(const Certificate& certificate, const std::vector<std::string>& names, double number, double share);
void expect_accepted(const Certificate& certificate);

}  // namespace tendril::grasps
