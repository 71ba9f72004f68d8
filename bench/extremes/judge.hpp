#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/extent.hpp"
#include "extremes/cases.hpp"
#include "extremes/model_decay.hpp"
#include "extremes/models.hpp"
#include "extremes/row.hpp"
#include "extremes/runs.hpp"

namespace tendril::bench {

struct Findings;

/// Holds what came out of cases against what is known of them.
class ExtremeJudge {
 public:
  ExtremeJudge(plugins::Registry& registry, const Extent& extent) : registry_(registry), decays_(registry, extent) {}

  /// Fills in what `row` says of this run of the case. `model`: null for an execution, and where the error of the model
  /// is not to be followed.
  void judge(const ExtremeCase& c, const Scene& scene, const CaseRun& out, ExtremeRow& row,
             const ExtremeModel* model = nullptr);

 private:
  void judge_solved(const ExtremeCase& c, const Scene& scene, const CaseRun& out, ExtremeRow& row, Findings& found,
                    const ExtremeModel* model);
  void compare_family(const ExtremeCase& c, const Plan& plan, ExtremeRow& row, Findings& found);
  void weigh_error(const ExtremeCase& c, const Scene& scene, const Plan& plan, ExtremeRow& row,
                   const ExtremeModel* model);
  void against_execution(const Scene& scene, const Plan& plan, const ExactState& exact, const Scale& scale,
                         Findings& found);

  plugins::Registry& registry_;
  ModelDecays decays_;
  std::map<std::string, std::vector<double>> families_;  ///< coordinates of each family's first plan
};

/// What is known of the case, in words.
std::string expected_of(const ExtremeCase& c);

}  // namespace tendril::bench
