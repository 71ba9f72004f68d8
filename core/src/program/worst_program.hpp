#pragma once

#include <string>
#include <vector>

#include "program/reduced_program.hpp"

namespace tendril {

/// One set of moments for several states of a rod, which differ by the tangential ratios of its contacts, so that the
/// largest cost of any of them is least. x = (moments, t), the cost is t, and the rows are, for each state in turn,
/// t - cost / unit >= 0 and those of its reduced program. Exact first and second derivatives.
class TENDRIL_API WorstProgram : public NonlinearProgram {
 public:
  struct State {
    ReducedProgram* program = nullptr;  ///< borrowed, and this state's own
    Eigen::VectorXd ratios{};           ///< its last variables
  };
  /// At least one state; all have the same moments. `unit`: of t, > 0.
  WorstProgram(std::vector<State> states, double unit);

  /// The variables of a state's reduced program at x.
  const Eigen::VectorXd& point(std::size_t state, ConstVectorRef x);
  /// x at these moments, with t as large as the cost of any state.
  Eigen::VectorXd start(ConstVectorRef moments);

  std::string row_name(int row) const override;
  std::string variable_name(int variable) const override;  ///< "moment 1" and so on, then "worst cost".

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override;
  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override;

 private:
  std::vector<State> states_;
  double unit_;
  int moments_;                              ///< variables before t
  std::vector<int> first_;                   ///< row of each state, and behind the last
  Eigen::VectorXd variables_, multipliers_;  ///< of one state
};

}  // namespace tendril
