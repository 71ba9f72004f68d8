#include "extremes/model_decay.hpp"

#include <fmt/format.h>

#include <cmath>

#include "extremes/row.hpp"
#include "extremes/runs.hpp"

namespace tendril::bench {

namespace {

/// A coarser model is to gain at least this much of its error for every part that it is refined by: half the error for
/// twice the coordinates. Piecewise constant curvature gains a quarter where it resolves the shape, all others more.
constexpr double least_order = 1.0;
constexpr int most_refinements = 2;

}  // namespace

const Decay& ModelDecays::of(const std::string& name, const Scene& scene, const Plan& plan, double error,
                             const ExtremeModel& model) {
  const std::string key = name + '\n' + model.name;
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  return known_.emplace(key, measured(scene, plan, error, model)).first->second;
}

Decay ModelDecays::measured(const Scene& scene, const Plan& plan, double error, const ExtremeModel& model) {
  Decay decay;
  decay.text = fmt::format("model's own error {:.1e} with {} coordinates", error, plan.coordinates.size());
  int done = 0;
  for (int level = 0; level < refinement_levels && done < most_refinements; ++level) {
    const std::optional<Scene> finer = refined(registry_, scene, model, level);
    if (!finer) continue;
    if (extent_.stopped()) break;
    const CaseRun out = planned(registry_, *finer);
    if (out.verdict != "solved") continue;
    const ExactState exact = exact_of(registry_, *finer, out.plan);
    if (!exact.found) continue;
    ++done;
    const double left = distance(*finer, out.plan, exact);
    const double ratio =
        static_cast<double>(out.plan.coordinates.size()) / static_cast<double>(plan.coordinates.size());
    decay.text += fmt::format(", {:.1e} with {}", left, out.plan.coordinates.size());
    decay.as_expected = left <= resolved_error || left <= error * std::pow(ratio, -least_order);
    if (left <= resolved_error) break;
  }
  // The finest of all, and a contact inside a piece, whose error depends on where in the piece it happens to lie:
  // what half as many left.
  if (!decay.as_expected && model.value > 1) {
    ExtremeModel half = model;
    half.value = model.value / 2;
    const Scene coarser = with_model(scene, half);
    const CaseRun out = planned(registry_, coarser);
    const ExactState exact = out.verdict == "solved" ? exact_of(registry_, coarser, out.plan) : ExactState{};
    if (exact.found) {
      const double left = distance(coarser, out.plan, exact);
      const double ratio =
          static_cast<double>(plan.coordinates.size()) / static_cast<double>(out.plan.coordinates.size());
      decay.text += fmt::format(", {:.1e} with {}", left, out.plan.coordinates.size());
      decay.as_expected = error <= left * std::pow(ratio, -least_order);
    }
  }
  return decay;
}

}  // namespace tendril::bench
