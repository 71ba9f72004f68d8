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
};

}  // namespace tendril
