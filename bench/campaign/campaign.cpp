#include "campaign/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "campaign/random_scene.hpp"
#include "campaign/relaxations.hpp"
#include "check/plan_check.hpp"
#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "tendril/app/process.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {
namespace {

using Json = nlohmann::json;

/// A plan may take this much longer than its time limit, and 20 ms for a machine that has other things to do.
constexpr double over_limit = 1.1;
constexpr double scheduling = 0.02;
/// A process that takes longer than this many time limits and 10 s hangs.
constexpr double patience = 3.0;

constexpr const char* mark = "{\"campaign\":";

double real(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number() ? json[key].get<double>() : std::nan("");
}

CampaignCase run_case(const CampaignSetup& setup, const std::set<std::string>& plugins, const std::string& solver,
                      std::uint64_t seed) {
  CampaignCase result;
  result.seed = seed;
  result.solver = solver;
  result.summary = random_scene(seed, solver, setup.time_limit, plugins, setup.outlines, setup.friction).summary;
  std::vector<std::string> arguments{"campaign", "--seeds",      fmt::format("{0}:{0}", seed),        "--solver",
                                     solver,     "--time-limit", fmt::format("{}", setup.time_limit), "--one"};
  for (const std::string& directory : setup.plugin_directories) {
    arguments.insert(arguments.end(), {"--plugin-dir", directory});
  }
  if (setup.outlines) arguments.push_back("--outlines");
  if (setup.friction) arguments.push_back("--friction");
  if (!setup.relaxation.empty()) arguments.insert(arguments.end(), {"--relaxation", setup.relaxation});
  for (const std::string& setting : setup.search) arguments.insert(arguments.end(), {"--search", setting});
  const double most = patience * setup.time_limit + 10.0;
  const app::ProcessResult run = app::run_process(plugins::executable_path().string(), arguments, "/", most);
  const std::size_t at = run.output.rfind(mark);
  const auto failed = [&](const char* verdict, const std::string& reason) {
    result.verdict = verdict;
    result.reason = reason;
    result.grave = true;
    return result;
  };
  if (run.timed_out) return failed("hang", fmt::format("no answer within {:.0f} s", most));
  const Json json = at == std::string::npos ? Json() : Json::parse(run.output.substr(at), nullptr, false);
  if (run.exit_code != 0 || !json.is_object()) {
    const std::size_t keep = std::min<std::size_t>(run.output.size(), 200);
    const std::string end = run.output.substr(run.output.size() - keep);
    return failed(run.exit_code < 0 ? "crash" : "refused", end);
  }
  result.verdict = json.value("status", "");
  result.reason = json.value("message", "");
  result.cut = json.value("cut", "");
  result.seconds = real(json, "seconds");
  result.cpu_seconds = real(json, "cpu_seconds");
  result.objective = real(json, "objective");
  result.scale = real(json, "scale");
  result.equilibrium = real(json, "equilibrium");
  result.penetration = real(json, "penetration");
  result.margin = real(json, "margin");
  if (const std::string defects = json.value("defects", ""); !defects.empty()) return failed("false plan", defects);
  if (result.seconds > over_limit * setup.time_limit + scheduling) {
    return failed("time limit missed", fmt::format("{:.2f} s, {}", result.seconds, result.reason));
  }
  // A plan without friction that does not stand every state of it: the answer is how far it does.
  const bool gives_way = setup.friction && result.verdict == "unstable" &&
                         result.reason.starts_with("under friction ") &&
                         result.reason.find("the rod gives way") != std::string::npos;
  result.met =
      result.verdict == "solved" || result.verdict == "infeasible" || gives_way || result.verdict == nothing_to_relax;
  return result;
}

}  // namespace

std::set<std::string> names_at_hand(const plugins::Registry& registry) {
  std::set<std::string> names;
  for (const ComponentKind kind : {ComponentKind::coordinates, ComponentKind::objective}) {
    for (const std::string& name : registry.names(kind)) names.insert(name);
  }
  return names;
}

double scale_of_objective(const Scene& scene) {
  double scale = 1.0;
  for (const ObjectiveSpec& term : scene.objectives) scale = std::max(scale, term.weight);
  return scale;
}

std::string campaign_line(plugins::Registry& registry, std::uint64_t seed, const CampaignSetup& setup) {
  const std::string& solver = setup.solvers.front();
  const RandomScene random =
      random_scene(seed, solver, setup.time_limit, names_at_hand(registry), setup.outlines, setup.friction);
  Scene scene = scene_from_text(random.text, fmt::format("seed {}", seed), registry);
  if (scene.solver.plugin != solver) throw Error("the solver '" + solver + "' was not found");
  Json json;
  json["campaign"] = seed;
  for (const Relaxation& r : relaxations()) {
    if (r.name != setup.relaxation || r.apply(scene)) continue;
    json["status"] = nothing_to_relax;
    return json.dump();
  }
  Problem problem(scene, plugins::make_components(registry, scene));
  const double begin = now();
  const double cpu_begin = processor_now();
  const Plan plan = problem.plan();
  json["seconds"] = now() - begin;
  json["cpu_seconds"] = processor_now() - cpu_begin;
  json["status"] = to_string(plan.status);
  json["message"] = plan.message;
  json["cut"] = plan.search_cut ? "cut" : "";
  json["objective"] = plan.objective;
  json["scale"] = scale_of_objective(scene);
  if (plan.status == PlanStatus::solved) {
    const PlanCheck check = check_plan(scene, plan);
    json["equilibrium"] = check.equilibrium;
    json["penetration"] = check.penetration;
    json["margin"] = check.margin;
    std::string defects;
    for (const std::string& defect : check.defects) defects += (defects.empty() ? "" : "; ") + defect;
    json["defects"] = defects;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<CampaignCase> run_campaign(const CampaignSetup& setup) {
  std::vector<CampaignCase> cases;
  const std::vector<std::filesystem::path> places(setup.plugin_directories.begin(), setup.plugin_directories.end());
  const plugins::Registry registry(plugins::Catalog(plugins::search_places(places)));
  const std::set<std::string> plugins = names_at_hand(registry);
  std::mutex mutex;
  std::size_t next = 0;
  const std::size_t seeds = setup.last - setup.first + 1;
  const auto work = [&] {
    while (true) {
      std::size_t index = 0;
      {
        const std::lock_guard lock(mutex);
        if (next == seeds * setup.solvers.size() || (setup.stop != nullptr && setup.stop->load())) return;
        index = next++;
      }
      CampaignCase result = run_case(setup, plugins, setup.solvers[index / seeds], setup.first + index % seeds);
      const std::lock_guard lock(mutex);
      if (!result.met) {
        fmt::print(stderr, "{} seed {}: {}: {}\n", result.solver, result.seed, result.verdict, result.reason);
      }
      cases.push_back(std::move(result));
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(setup.jobs));
  for (int i = 0; i < setup.jobs; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  const auto rank = [&](const CampaignCase& c) {
    return std::pair(std::find(setup.solvers.begin(), setup.solvers.end(), c.solver), c.seed);
  };
  std::sort(cases.begin(), cases.end(),
            [&](const CampaignCase& a, const CampaignCase& b) { return rank(a) < rank(b); });
  return cases;
}

bool acceptable(const CampaignSetup& setup, const std::vector<CampaignCase>& cases) {
  std::map<std::string, std::pair<int, int>> counts;  // all, met
  for (const CampaignCase& c : cases) {
    if (c.grave) return false;
    ++counts[c.solver].first;
    if (c.met) ++counts[c.solver].second;
  }
  return std::all_of(counts.begin(), counts.end(),
                     [&setup](const auto& entry) { return entry.second.second >= setup.share * entry.second.first; });
}

Section campaign_section(const CampaignSetup& setup, const std::vector<CampaignCase>& cases) {
  Section section;
  section.name = "campaign";
  section.title = "Random scenes";
  section.prose.push_back(fmt::format(
      "Each seed from {} to {} draws a scene: sizes, units, loads, segments, actuators, obstacles {}, target, "
      "coordinate model and treatment of complementarity. Each is planned in a process of its own with a time limit of "
      "{} s. A case is met if its plan is solved and confirmed by a second computation from the plan's own numbers, or "
      "if the scene is infeasible by a bound or from the stated number of starts{}. At least {} % have to be met; a "
      "crash, a hang, a plan that is not confirmed, or a time limit missed by more than 10 % is never allowed.",
      setup.first, setup.last,
      std::string(setup.outlines ? "that are not convex" : "of every kind") + (setup.friction ? " that rub" : ""),
      setup.time_limit,
      setup.friction ? ", or if it says in which state of friction the plan made without gives way" : "",
      100.0 * setup.share));

  Table counts{"campaign_counts",
               "Outcomes",
               {"solver", "cases", "met", "%", "outcomes", "median (s)", "longest (s)"},
               {},
               true};
  Table failures{
      "campaign_failures", "Cases that are not met", {"solver", "seed", "outcome", "scene", "reason", "s"}, {}, true};
  Table all{"campaign_cases",
            "Every case",
            {"solver", "seed", "outcome", "met", "objective", "equilibrium", "penetration", "margin", "seconds",
             "cpu seconds", "scene", "reason"},
            {},
            false};
  for (const std::string& solver : setup.solvers) {
    std::map<std::string, int> outcomes;
    std::vector<double> seconds;
    std::int64_t met = 0;
    for (const CampaignCase& c : cases) {
      if (c.solver != solver) continue;
      ++outcomes[c.verdict];
      seconds.push_back(c.seconds);
      if (c.met) ++met;
      const auto seed = static_cast<std::int64_t>(c.seed);
      if (!c.met) failures.rows.push_back({solver, seed, c.verdict, c.summary, c.reason, c.seconds});
      all.rows.push_back({solver, seed, c.verdict, std::int64_t{c.met ? 1 : 0}, c.objective, c.equilibrium,
                          c.penetration, c.margin, c.seconds, c.cpu_seconds, c.summary, c.reason});
    }
    if (seconds.empty()) continue;
    std::sort(seconds.begin(), seconds.end());
    std::string list;
    for (const auto& [verdict, count] : outcomes)
      list += fmt::format("{}{} {}", list.empty() ? "" : ", ", count, verdict);
    const auto count = static_cast<std::int64_t>(seconds.size());
    counts.rows.push_back({solver, count, met, 100.0 * static_cast<double>(met) / static_cast<double>(count), list,
                           seconds[seconds.size() / 2], seconds.back()});
  }
  section.tables = {counts, failures, all};
  return section;
}

}  // namespace tendril::bench
