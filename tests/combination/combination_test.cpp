// Everything with everything: every coordinate model, split and not, with every solver in every scene, and every choice
// of objectives. One case for each problem, so that one that fails has a name; what fails in it says with which solver.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>

#include "support.hpp"

namespace tendril::combination {
namespace {

const std::vector<std::string> scenes{"free",       "brace",      "avoid",         "two_pegs",
                                      "grasp_60mm", "tendon_arm", "extensible_arm"};

struct Coordinates {
  std::string name;
  std::string plugin;
  RawOptions options;
};

const Coordinates six{"legendre_6", "legendre", {{"order", {std::int64_t{6}}}}};

std::vector<Coordinates> all_coordinates() {
  std::vector<Coordinates> all;
  const auto with = [&](const std::string& plugin, const std::string& option, std::vector<std::int64_t> values) {
    for (const std::int64_t value : values) {
      all.push_back({plugin + "_" + std::to_string(value), plugin, {{option, {value}}}});
    }
  };
  for (const std::string& plugin : registry().names(ComponentKind::coordinates)) {
    if (plugin == "pcc") {
      with(plugin, "pieces", {3, 12});
    } else if (plugin == "legendre") {
      with(plugin, "order", {1, 2, 6, 24});  // psc has the three
    } else {
      all.push_back({plugin, plugin, {}});
    }
  }
  return all;
}

/// What is planned: one scene with one model, one solver and one treatment.
struct Combined {
  std::string scene;
  Coordinates coordinates;
  bool split = true;
  std::string solver;
  std::vector<std::string> objectives;  ///< empty: the scene's own
  Treatment treatment = Treatment::penalty;

  /// Of the problem that is solved; solvers and treatments only say how.
  std::string problem_name() const {
    std::string name = scene;
    for (const std::string& objective : objectives) name += "_" + objective;
    if (objectives.empty()) name += "_" + coordinates.name + (split ? "_split" : "_whole");
    return name;
  }
};

/// One problem and all ways to solve it: each is planned once and certified. With the scene's own objectives each
/// has to find what the first one found.
struct ProblemCase {
  std::string name;
  std::vector<Combined> ways;
};

std::ostream& operator<<(std::ostream& os, const ProblemCase& c) { return os << c.name; }

std::string name_of(const testing::TestParamInfo<ProblemCase>& info) { return info.param.name; }

#ifdef __SANITIZE_ADDRESS__
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

/// The whole product; under sanitizers, which are slow and look for other defects, a part of it in which every two
/// values that occur together in some case still do so.
std::vector<Combined> affordable(std::vector<Combined> all) {
  if (!sanitized) return all;
  using Pair = std::pair<std::string, std::string>;
  const auto pairs_of = [](const Combined& c) {
    std::string objectives;
    for (const std::string& objective : c.objectives) objectives += objective + "+";
    const std::vector<std::string> values{"scene " + c.scene,          "model " + c.coordinates.name,
                                          c.split ? "split" : "whole", "solver " + c.solver,
                                          "objectives " + objectives,  std::string(to_string(c.treatment))};
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t j = i + 1; j < values.size(); ++j) pairs.emplace_back(values[i], values[j]);
    }
    return pairs;
  };
  std::set<Pair> missing;
  for (const Combined& c : all) {
    for (const Pair& pair : pairs_of(c)) missing.insert(pair);
  }
  std::vector<Combined> chosen;
  while (!missing.empty()) {
    const auto gain = [&](const Combined& c) {
      const std::vector<Pair> pairs = pairs_of(c);
      return std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) { return missing.count(pair) > 0; });
    };
    const auto best = std::max_element(all.begin(), all.end(),
                                       [&](const Combined& a, const Combined& b) { return gain(a) < gain(b); });
    for (const Pair& pair : pairs_of(*best)) missing.erase(pair);
    chosen.push_back(*best);
  }
  return chosen;
}

/// In the order of their first way.
std::vector<ProblemCase> by_problem(const std::vector<Combined>& all) {
  std::vector<ProblemCase> cases;
  std::map<std::string, std::size_t> place;
  for (const Combined& c : all) {
    const auto [at, is_new] = place.emplace(c.problem_name(), cases.size());
    if (is_new) cases.push_back({c.problem_name(), {}});
    cases[at->second].ways.push_back(c);
  }
  return cases;
}

/// Treatments beside the penalty, where there are contacts that they treat.
std::vector<Treatment> treatments(const std::string& scene, const Coordinates& coordinates) {
  if ((scene == "brace" || scene == "two_pegs") && coordinates.name == six.name) {
    return {Treatment::penalty, Treatment::slack, Treatment::scholtes, Treatment::fischer_burmeister};
  }
  return {Treatment::penalty};
}

std::vector<Combined> all_models() {
  std::vector<Combined> all;
  for (const std::string& scene : scenes) {
    for (const Coordinates& coordinates : all_coordinates()) {
      for (const bool split : {true, false}) {
        for (const Treatment treatment : treatments(scene, coordinates)) {
          for (const std::string& solver : solvers_to_combine())
            all.push_back({scene, coordinates, split, solver, {}, treatment});
        }
      }
    }
  }
  return all;
}

/// Each objective alone, each pair, and all together; those that read tendons where there are some, none that reads
/// error bars: these scenes have none.
std::vector<std::vector<std::string>> choices_of_objectives(bool tendons) {
  std::vector<std::string> names = registry().names(ComponentKind::objective);
  std::erase_if(names, [tendons](const std::string& name) {
    const ObjectiveComponent& component = registry().objective(name);
    const Reads reads = component.make(resolve_options(component.options, {}, {}, {}, name))->reads();
    return reads.tip_deviations || (!tendons && (reads.tensions || reads.shortenings));
  });
  std::vector<std::vector<std::string>> choices;
  for (std::size_t i = 0; i < names.size(); ++i) {
    choices.push_back({names[i]});
    for (std::size_t j = i + 1; j < names.size(); ++j) choices.push_back({names[i], names[j]});
  }
  if (names.size() > 2) choices.push_back(names);
  return choices;
}

std::vector<Combined> all_objectives() {
  std::vector<Combined> all;
  for (const std::string& scene : scenes) {
    for (const std::vector<std::string>& objectives : choices_of_objectives(scene == "tendon_arm")) {
      for (const std::string& solver : solvers_to_combine()) all.push_back({scene, six, true, solver, objectives});
    }
  }
  return all;
}

Scene scene_of(const Combined& c) {
  Scene made = scene(c.scene);
  made.coordinates = {c.coordinates.plugin, c.split, made.coordinates.stretch_order, c.coordinates.options, {}};
  made.solver.plugin = c.solver;
  made.contact.treatment = c.treatment;
  if (c.objectives.empty()) return made;
  const std::vector<ObjectiveSpec> own = made.objectives;
  made.objectives.clear();
  for (const std::string& plugin : c.objectives) {
    const auto same = std::find_if(own.begin(), own.end(), [&](const ObjectiveSpec& o) { return o.plugin == plugin; });
    made.objectives.push_back(same != own.end() ? *same : ObjectiveSpec{.plugin = plugin, .options = {}});
  }
  return made;
}

class Combination : public testing::TestWithParam<ProblemCase> {};

TEST_P(Combination, IsSolvedByEverySolver) {
  std::optional<double> first;
  for (const Combined& way : GetParam().ways) {
    SCOPED_TRACE(way.solver + ", " + std::string(to_string(way.treatment)));
    std::optional<Problem> assembled;
    try {
      assembled.emplace(problem(scene_of(way)));
    } catch (const SceneError& e) {
      // Only an objective of this test's own choice may ask for what the scene has not.
      ASSERT_FALSE(way.objectives.empty()) << e.what();
      GTEST_SKIP() << e.what();
    }
    const Plan found = assembled->plan();
    EXPECT_TRUE(certified(found));
    double sum = 0.0;
    for (const auto& term : found.terms) sum += term.second;
    // Sums of a few numbers of the size of the largest.
    EXPECT_NEAR(sum, found.objective, 1e-12 * std::max(1.0, std::abs(found.objective)));
    // Some choices of objectives have several minima that are certified, and solvers end at different ones.
    if (!way.objectives.empty()) continue;
    if (!first) first = found.objective;
    // All are polished to the same point if they are on the same branch; a second minimum differs by far more.
    EXPECT_NEAR(found.objective, *first, 1e-6 * std::max(std::abs(*first), 1e-6));
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Combination, testing::ValuesIn(by_problem(affordable(all_models()))), name_of);
INSTANTIATE_TEST_SUITE_P(Objectives, Combination, testing::ValuesIn(by_problem(affordable(all_objectives()))), name_of);

}  // namespace
}  // namespace tendril::combination
