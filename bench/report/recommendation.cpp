#include "report/recommendation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "common/statistics.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

/// A certified plan may be off by 1e-9 L where it touches; a model that is worse than that would make the certificate
/// speak of the model and not of the rod.
constexpr double goal = tolerance::penetration;

/// Out of the models within `error` on all scenes; null: there is none. `choices` by time. In a class of times the
/// smallest model counts, which is the same at every repetition.
const ModelChoice* best_model(const std::vector<ModelChoice>& choices, double error) {
  const ModelChoice* fastest = nullptr;
  const ModelChoice* best = nullptr;
  for (const ModelChoice& c : choices) {
    if (c.error > error) continue;
    if (fastest == nullptr) fastest = &c;
    if (c.seconds <= same_class * fastest->seconds && (best == nullptr || c.coordinates < best->coordinates)) best = &c;
  }
  return best;
}

/// Those that miss no more programs than the one that misses fewest, by rank. A plan that is not there costs more than
/// any time.
const Standing* best_standing(const std::vector<Standing>& all) {
  const Standing* best = nullptr;
  for (const Standing& s : all) {
    if (s.certified > 0 && (best == nullptr || s.certified > best->certified)) best = &s;
  }
  return best;
}

/// What a scene that names nothing is planned with.
bool is_default_model(plugins::Registry& registry, const Scene& plain, const ModelSweep& model, int value) {
  if (model.plugin != plain.coordinates.plugin || model.split != plain.coordinates.split_at_contact) return false;
  for (const OptionSpec& option : registry.coordinates(model.plugin).options) {
    if (option.name != model.option) continue;
    const auto* standard = std::get_if<std::int64_t>(&option.default_value);
    return standard != nullptr && *standard == value;
  }
  return model.option.empty();
}

std::string words(const ModelSweep& model, int value) {
  return fmt::format("{}{}, {}", model.plugin,
                     model.option.empty() ? "" : fmt::format(" with {} {}", model.option, value),
                     model.split ? "split at the contact" : "not split at the contact");
}

std::string verdict(bool is_default) {
  return is_default ? "This is what `tendril plan` takes where a scene names nothing."
                    : "`tendril plan` takes something else where a scene names nothing.";
}

}  // namespace

Recommendation recommend(plugins::Registry& registry, const AccuracySetup& accuracy_setup, const Accuracy& accuracy,
                         const SolverComparisonSetup& solver_setup, const SolverComparison& comparison) {
  Recommendation r;
  const std::vector<ModelChoice> choices = model_choices(accuracy, accuracy_setup.scenes.size());
  const ModelChoice* model = best_model(choices, goal);
  const std::vector<Standing> all = standings(solver_setup, comparison);
  const Standing* best = best_standing(all);
  if (model == nullptr || best == nullptr) return r;
  r.found = true;
  r.model = accuracy.sweeps[model->sweep];
  r.value = model->value;
  r.contestant = solver_setup.contestants[best->contestant];
  const Scene& plain = accuracy_setup.scenes.front().scene;
  r.model_is_default = is_default_model(registry, plain, r.model, r.value);
  r.solver_is_default = r.contestant.solver == plain.solver.plugin && r.contestant.options.empty();
  r.treatment_is_default = r.contestant.treatment == plain.contact.treatment;
  return r;
}

Section recommendation_section(const Recommendation& r, const AccuracySetup& accuracy_setup, const Accuracy& accuracy,
                               const SolverComparisonSetup& solver_setup, const SolverComparison& comparison) {
  Section section;
  section.name = "recommendation";
  section.title = "What to use";
  if (!r.found) {
    section.prose.push_back(fmt::format(
        "These numbers recommend nothing: no model stays within {:g} L on all scenes, or no solver was certified.",
        goal));
    return section;
  }
  const std::vector<ModelChoice> choices = model_choices(accuracy, accuracy_setup.scenes.size());
  const auto of = [&](const ModelChoice& c) {
    return accuracy.sweeps[c.sweep].name() == r.model.name() && c.value == r.value;
  };
  const ModelChoice& model = *std::find_if(choices.begin(), choices.end(), of);
  section.prose.push_back(
      fmt::format("Coordinates: {}. Of the models whose tip is within {:g} L on every scene of the accuracy part it is "
                  "the one with the "
                  "fewest coordinates among the fastest, which are all within a factor of 1.5 ({:.1e} L, {:.3g} ms "
                  "over all scenes), "
                  "so that what the certificate promises to that size holds for the rod and not "
                  "only for its model. {}",
                  words(r.model, r.value), goal, model.error, 1e3 * model.seconds, verdict(r.model_is_default)));
  for (const double coarse : {1e-3, 1e-6}) {
    const ModelChoice* found = best_model(choices, coarse);
    if (found == nullptr) continue;
    section.prose.push_back(fmt::format("If an error of {:g} L is enough: {} ({:.1e} L), at {:.2g} times that time.",
                                        coarse, words(accuracy.sweeps[found->sweep], found->value), found->error,
                                        found->seconds / model.seconds));
  }
  const std::vector<Standing> all = standings(solver_setup, comparison);
  const Standing& first = *std::find_if(all.begin(), all.end(), [&](const Standing& s) {
    return solver_setup.contestants[s.contestant].name == r.contestant.name;
  });
  section.prose.push_back(fmt::format(
      "Solver: {}, with the treatment {}. Nobody was certified on more programs ({} of {}), and of those that were "
      "certified on as many it ranks first: {:.3g} ms and {:.3g} evaluations per plan (shifted geometric means). {}",
      r.contestant.name, to_string(r.contestant.treatment), first.certified, first.programs, 1e3 * first.seconds,
      first.evaluations, verdict(r.contestant_is_default())));
  std::string others;
  for (const Standing& s : all) {
    const Contestant& c = solver_setup.contestants[s.contestant];
    if (!c.options.empty() || c.treatment != r.contestant.treatment || c.solver == r.contestant.solver) continue;
    others += fmt::format("{}{}: {} of {} certified, {:.2g} times the time, {:.2g} times the evaluations",
                          others.empty() ? "" : "; ", c.name, s.certified, s.programs, s.seconds / first.seconds,
                          s.evaluations / first.evaluations);
  }
  if (!others.empty()) section.prose.push_back("The other solvers with the same treatment: " + others + ".");
  Table table{"recommendation",
              "The recommendation",
              {"what", "recommended", "default of `tendril plan`"},
              {{std::string("coordinates"), words(r.model, r.value), std::string(r.model_is_default ? "yes" : "no")},
               {std::string("solver"), r.contestant.name, std::string(r.solver_is_default ? "yes" : "no")},
               {std::string("treatment of complementarity"), std::string(to_string(r.contestant.treatment)),
                std::string(r.treatment_is_default ? "yes" : "no")}}};
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
