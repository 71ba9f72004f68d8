#pragma once

#include <array>
#include <memory>
#include <vector>

#include "program/pose_program.hpp"

namespace tendril {

/// A point of either finger that must not pass the other along a direction: normal . (P_upper - P_lower) is not below
/// the sum of their bodies' radii there. Two
/// points on the right sides of a line are more than two curves that do not cross need: fingers that hook behind each
/// other are not found.
struct FingerSeparation {
  int upper_piece = 0;       ///< of the upper finger's chain
  double upper_sigma = 1.0;  ///< place on the piece, in (0,1]
  int lower_piece = 0;       ///< of the lower finger's chain
  double lower_sigma = 1.0;  ///< likewise
  Vec2 normal{0.0, 1.0};     ///< unit vector from the lower to the upper finger, in the palm's frame
};

/// Everything that a grasp of two fingers is assembled from. The first entry of each pair is the upper finger, the
/// second one the lower, described in its mirror image: as an upper finger, with loads mirrored at the axis.
struct GraspProgramSpec {
  /// Each in units of its own rod, with `term_units` in those of the grasp, one contact, and a palm whose range is set
  /// by the two below.
  std::array<PoseProgramSpec, 2> fingers;
  double palm_minimum = 0.0;                  ///< of the palm distance, units of the grasp
  double palm_maximum = 0.0;                  ///< equal to the minimum: the distance is fixed, and no variable
  Vec2 load{};                                ///< on the object, in the palm's frame; units of the grasp
  std::vector<FingerSeparation> separations;  ///< a row each; none: the fingers are not kept apart
};

/// Both fingers of a grasp as one program (model.md section 6). x = (upper finger, lower finger, contact force, palm
/// distance): coordinates, moments and contact arc length of each in units of its own rod, then what they share in
/// units of the grasp; no palm distance where it is fixed. One contact each presses on a round object, so that no force
/// is left on it exactly if both forces are equal, which the shared variable sees to, and the normals are opposite: one
/// row, the sum of their parts along the axis. (Its other root, normals on the same side, leaves a force across the
/// axis, which the certificate finds. Forces of their own would make that row, the balance across the axis and the
/// limits of both forces dependent at every solution.) Forces without friction pass through the centre: no moment is
/// left either. Nor do tangential forces that are as large: they share their ratio too, and the row is the sum of the
/// pushes. An object that is loaded needs forces of their own, which are then variables of the fingers, and rows for
/// the force along the axis and across it, and with friction for the moment.
class TENDRIL_API GraspProgram : public NonlinearProgram {
 public:
  /// Throws Error for fingers that do not have one contact each.
  explicit GraspProgram(const GraspProgramSpec& spec);
  ~GraspProgram() override;

  const GraspProgramSpec& spec() const;  ///< What it was assembled from.
  /// The program of one finger (0: upper, 1: lower), which knows nothing of the other.
  PoseProgram& finger(int which);
  const PoseProgram& finger(int which) const;  ///< Likewise.
  /// That program's variables at x.
  Eigen::VectorXd finger_point(int which, ConstVectorRef x) const;
  /// A start of these shapes; the palm distance is the mean of theirs, the force the smaller one.
  Eigen::VectorXd start_from(const StartShape& upper, const StartShape& lower) const;
  double force(ConstVectorRef x) const;          ///< Of either contact, units of the grasp; of an object without load.
  double palm_distance(ConstVectorRef x) const;  ///< Units of the grasp.
  int palm_variable() const;                     ///< -1: the distance is fixed.
  int balance_row() const;                       ///< The first one: along the axis.
  int first_separation() const;                  ///< Row; one per separation.

  std::string row_name(int row) const override;
  std::string variable_name(int variable) const override;  ///< Name of the finger and of its variable.

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override;
  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override;

 private:
  struct Data;
  explicit GraspProgram(std::unique_ptr<Data> data);
  std::unique_ptr<Data> data_;
};

/// What the contacts of both fingers leave on the object at the points computed last, in the palm's frame, without its
/// load; units of the grasp.
TENDRIL_API Vec2 net_force(const GraspProgram& program);
/// Their moment about the object's centre, per its radius.
TENDRIL_API double net_moment(const GraspProgram& program);

}  // namespace tendril
