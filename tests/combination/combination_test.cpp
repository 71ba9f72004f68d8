// Everything with everything: every coordinate model, split and not, with every solver in every scene, and every choice
// of objectives. One case each, so that a combination that fails has a name.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>

#include "support.hpp"

namespace tendril::combination {
namespace {

const std::vector<std::string> scenes{"free", "brace", "avoid", "two_pegs", "grasp_60mm"};

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
      with(plugin, "order", {1, 2, 3, 6, 12, 24});
    } else {
      all.push_back({plugin, plugin, {}});
    }
  }
  return all;
}

struct Case {
  std::string name;
  std::string scene;
  Coordinates coordinates;
  bool split = true;
  std::string solver;
  std::vector<std::string> objectives;  ///< empty: the scene's own
  Treatment treatment = Treatment::penalty;
};

std::ostream& operator<<(std::ostream& os, const Case& c) { return os << c.name; }

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }

#ifdef __SANITIZE_ADDRESS__
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

/// The whole product; under sanitizers, which are slow and look for other defects, a part of it in which every two
/// values that occur together in some case still do so.
std::vector<Case> affordable(std::vector<Case> all) {
  if (!sanitized) return all;
  using Pair = std::pair<std::string, std::string>;
  const auto pairs_of = [](const Case& c) {
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
  for (const Case& c : all) {
    for (const Pair& pair : pairs_of(c)) missing.insert(pair);
  }
  std::vector<Case> chosen;
  while (!missing.empty()) {
    const auto gain = [&](const Case& c) {
      const std::vector<Pair> pairs = pairs_of(c);
      return std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) { return missing.count(pair) > 0; });
    };
    const auto best =
        std::max_element(all.begin(), all.end(), [&](const Case& a, const Case& b) { return gain(a) < gain(b); });
    for (const Pair& pair : pairs_of(*best)) missing.erase(pair);
    chosen.push_back(*best);
  }
  return chosen;
}

std::vector<Case> all_models() {
  std::vector<Case> all;
  for (const std::string& scene : scenes) {
    for (const Coordinates& coordinates : all_coordinates()) {
      for (const bool split : {true, false}) {
        for (const std::string& solver : registry().names(ComponentKind::solver)) {
          const std::string name = scene + "_" + coordinates.name + (split ? "_split_" : "_whole_") + solver;
          all.push_back({name, scene, coordinates, split, solver, {}});
        }
      }
    }
  }
  return all;
}

/// Each objective alone, each pair, and all together.
std::vector<std::vector<std::string>> choices_of_objectives() {
  const std::vector<std::string> names = registry().names(ComponentKind::objective);
  std::vector<std::vector<std::string>> choices;
  for (std::size_t i = 0; i < names.size(); ++i) {
    choices.push_back({names[i]});
    for (std::size_t j = i + 1; j < names.size(); ++j) choices.push_back({names[i], names[j]});
  }
  if (names.size() > 2) choices.push_back(names);
  return choices;
}

std::vector<Case> all_objectives() {
  std::vector<Case> all;
  for (const std::string& scene : scenes) {
    for (const std::vector<std::string>& objectives : choices_of_objectives()) {
      for (const std::string& solver : registry().names(ComponentKind::solver)) {
        std::string name = scene;
        for (const std::string& objective : objectives) name += "_" + objective;
        all.push_back({name + "_" + solver, scene, six, true, solver, objectives});
      }
    }
  }
  return all;
}

Scene scene_of(const Case& c) {
  Scene made = scene(c.scene);
  made.coordinates = {c.coordinates.plugin, c.split, c.coordinates.options, {}};
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

class Combination : public testing::TestWithParam<Case> {};

TEST_P(Combination, IsSolvedAndCertified) {
  const Scene scene = scene_of(GetParam());
  std::optional<Problem> assembled;
  try {
    assembled.emplace(problem(scene));
  } catch (const SceneError& e) {
    // Only an objective of this test's own choice may ask for what the scene has not.
    ASSERT_FALSE(GetParam().objectives.empty()) << e.what();
    GTEST_SKIP() << e.what();
  }
  const Plan found = assembled->plan();
  EXPECT_TRUE(certified(found));
  double sum = 0.0;
  for (const auto& term : found.terms) sum += term.second;
  // Sums of a few numbers of the size of the largest.
  EXPECT_NEAR(sum, found.objective, 1e-12 * std::max(1.0, std::abs(found.objective)));
}

INSTANTIATE_TEST_SUITE_P(Models, Combination, testing::ValuesIn(affordable(all_models())), name_of);
INSTANTIATE_TEST_SUITE_P(Objectives, Combination, testing::ValuesIn(affordable(all_objectives())), name_of);

std::vector<Case> models_to_compare() {
  std::vector<Case> all = all_models();
  const std::string first = registry().names(ComponentKind::solver).front();
  std::erase_if(all, [&](const Case& c) { return c.solver == first; });
  return all;
}

std::vector<Case> treatments_to_compare() {
  std::vector<Case> all;
  for (const std::string scene : {"brace", "two_pegs"}) {
    for (const Treatment treatment : {Treatment::slack, Treatment::scholtes, Treatment::fischer_burmeister}) {
      for (const bool split : {true, false}) {
        for (const std::string& solver : registry().names(ComponentKind::solver)) {
          const std::string name =
              scene + "_" + std::string(to_string(treatment)) + (split ? "_split_" : "_whole_") + solver;
          all.push_back({name, scene, six, split, solver, {}, treatment});
        }
      }
    }
  }
  return all;
}

class Agreement : public testing::TestWithParam<Case> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Agreement);

TEST_P(Agreement, WithTheFirstSolverAndThePenalty) {
  // One process runs all of them if asked to; what the first solver found is then found once.
  static std::map<std::string, Plan> found_before;
  Case first = GetParam();
  first.solver = registry().names(ComponentKind::solver).front();
  first.treatment = Treatment::penalty;
  const std::string key = first.scene + first.coordinates.name + (first.split ? " split" : "");
  if (found_before.find(key) == found_before.end()) found_before[key] = plan(scene_of(first));
  const Plan& reference = found_before[key];
  const Plan other = plan(scene_of(GetParam()));
  ASSERT_TRUE(certified(reference)) << first.solver;
  ASSERT_TRUE(certified(other));
  // Both are polished to the same point if they are on the same branch; a second minimum differs by far more.
  EXPECT_NEAR(other.objective, reference.objective, 1e-6 * std::max(std::abs(reference.objective), 1e-6));
}

INSTANTIATE_TEST_SUITE_P(Models, Agreement, testing::ValuesIn(affordable(models_to_compare())), name_of);
INSTANTIATE_TEST_SUITE_P(Treatments, Agreement, testing::ValuesIn(affordable(treatments_to_compare())), name_of);

}  // namespace
}  // namespace tendril::combination
