#pragma once

#include <string>
#include <vector>

#include "search/steps.hpp"
#include "tendril/certificate.hpp"
#include "tendril/plan.hpp"
#include "tendril/solver.hpp"

/// What a search came to: how each way of being in contact reads, and the status of the whole. Poses, grasps and pairs
/// of fingers are judged alike.
namespace tendril {

/// A point of some program, with its certificate.
struct Judged {
  Certificate certificate;
  double objective = infinity;  ///< scaled
  OptimalityReport solver;      ///< of the solve that led here
  bool has_point = false;
  bool certified() const { return has_point && certificate.valid(); }
};

/// One way of being in contact: what is known of it.
struct Way : Attempt {
  Way() = default;
  Way(Way&&) = default;
  Way(const Way&) = delete;
  Way& operator=(Way&&) = default;
  Way& operator=(const Way&) = delete;
  virtual ~Way() = default;
  /// The best point so far.
  virtual const Judged& judged() const = 0;

  std::string skip;       ///< why it need not be solved, known before anything is
  bool left_out = false;  ///< on request: not tried, which proves nothing
  bool deferred = false;  ///< the last start was left to times without any plan
  int stationary_with_margins =
      0;                     ///< starts that ended where the violation of the rows, stability among them, is stationary
  double dearer = infinity;  ///< least objective of points that cost more than the plan and were not completed
  /// From enough starts no stable plan is near: its rows have none, or none that is stable.
  bool infeasible() const;
};

using Ways = std::vector<Way*>;

/// Fills the record of each way and lists them in the plan. `untried`: how those read that were never started.
void tell_outcomes(const Ways& ways, double objective_scale, const std::string& untried, Plan& plan);

/// The way that fails least, then costs least; null where none has a point.
Way* nearest_way(const Ways& ways);

/// What the verdict stands on beside the ways.
struct Grounds {
  const ProgramSearch* search = nullptr;
  double time_limit = 0.0;  ///< s
  bool solved = false;      ///< some way is certified
  bool everything = true;   ///< all ways there are were looked at
  bool rod_lies = false;    ///< `chosen` fails because the rod lies along an obstacle
  bool grasp = false;
  const Judged* chosen = nullptr;  ///< what the plan shows; null: nothing
  std::string unfit;               ///< a term that gave no number, in words
  std::string unit;                ///< what a way is called, in messages
};

/// Status, message and solver of a plan.
void judge(const Ways& ways, const Grounds& grounds, Plan& plan);

}  // namespace tendril
