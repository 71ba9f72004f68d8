#pragma once

#include <memory>

#include "program/pose_state.hpp"

namespace tendril {

/// Rows of a pose program that say one thing. A block reads the state that all of them share, and writes its own rows.
/// Nothing allocates after construction.
class RowBlock {
 public:
  /// Rows [first, first + count) of the program; messages call them `name`. Their bounds are these, if bounds() does
  /// not tell others.
  RowBlock(const char* name, int first, int count, double lower = 0.0, double upper = 0.0)
      : name_(name), first_(first), count_(count), lower_(lower), upper_(upper) {}
  virtual ~RowBlock() = default;
  RowBlock(const RowBlock&) = delete;
  RowBlock& operator=(const RowBlock&) = delete;

  const char* name() const { return name_; }
  int first() const { return first_; }
  int count() const { return count_; }

  /// count() entries each, for the branches of contacts chosen last.
  virtual void bounds(VectorRef lower, VectorRef upper) const {
    lower.setConstant(lower_);
    upper.setConstant(upper_);
  }
  /// Values at the point that the state was moved to; with `derivatives` count() x variables `rows` as well. These
  /// arrive as they were left, zero at first.
  virtual void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) = 0;
  /// Adds second derivatives of multipliers . values: by base quantities, by what acts on places, or to `hessian`.
  virtual void add_second(ConstVectorRef /*multipliers*/, Eigen::MatrixXd& /*hessian*/) {}

 private:
  const char* name_;
  int first_, count_;
  double lower_, upper_;
};

///@{
/// The blocks, in the order of rows, where the layout has such rows. The state is borrowed.
std::unique_ptr<RowBlock> equilibrium_rows(PoseState& state);
std::unique_ptr<RowBlock> gap_rows(PoseState& state);
std::unique_ptr<RowBlock> closest_point_rows(PoseState& state);
std::unique_ptr<RowBlock> clearance_rows(PoseState& state);
std::unique_ptr<RowBlock> order_rows(PoseState& state);
std::unique_ptr<RowBlock> balance_rows(PoseState& state);
std::unique_ptr<RowBlock> target_rows(PoseState& state);
std::unique_ptr<RowBlock> stability_rows(PoseState& state);
std::unique_ptr<RowBlock> convexity_rows(PoseState& state);
std::unique_ptr<RowBlock> shortening_rows(PoseState& state);
std::unique_ptr<RowBlock> stick_rows(PoseState& state);
///@}

///@{
/// As PoseProgram has them.
void sliding_row(const PoseState& state, int contact, VectorRef out);
Anchor anchor(const PoseState& state, int contact);
///@}

/// d_ss of contact k with the curvature on one side of it.
double convexity(const PoseState& state, int contact, const Places::Side& side);
/// Its derivatives by all variables.
void convexity_gradient(const PoseState& state, int contact, const Places::Side& side, VectorRef gradient);
/// Of d_ss where the rod moves against the contact's obstacle at this velocity and this turn, and is stretched away
/// from it as Motion::stretch.
double convexity_rate(const PoseState& state, int contact, Vec2 velocity, double turn, double stretch);
/// The side of contact k with the larger d_ss.
Places::Side convex_side(const PoseState& state, int contact);

}  // namespace tendril
