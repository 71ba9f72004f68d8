#pragma once

#include <memory>
#include <vector>

#include "program/pose_state.hpp"
#include "program/row_block.hpp"

namespace tendril {

/// Everything that a pose program knows beside its bounds.
struct PoseProgram::Data : PoseState {
  explicit Data(PoseProgramSpec s);

  std::vector<std::unique_ptr<RowBlock>> blocks;  ///< in the order of rows
  Eigen::MatrixXd mixed;                          ///< second derivatives by coordinates and arc lengths
  std::vector<double> moments;                    ///< of actuators

  // Another target changes what terms give, not the rod: there only they are evaluated anew.
  Eigen::VectorXd evaluated_at;  ///< variables of the last evaluation
  bool evaluated = false;        ///< rows and state are those of that point
  bool differentiated = false;   ///< their derivatives, too
  bool kept = false;             ///< only the target has changed since
};

}  // namespace tendril
