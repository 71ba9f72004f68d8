#include "report/report.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/machine.hpp"
#include "report/against.hpp"
#include "report/parts.hpp"
#include "report/recommendation.hpp"
#include "report/tolerance_sweep.hpp"
#include "tendril/app/document.hpp"

namespace tendril::bench {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* style =
    "body{font:16px/1.5 sans-serif;color:#222;max-width:72em;margin:2em auto;padding:0 1em}"
    "h1,h2{line-height:1.2}h2{margin-top:2.2em;border-bottom:1px solid #ccc}"
    "figure{margin:1.5em 0}figure img{max-width:100%}figcaption{color:#555;font-size:90%}"
    "table{border-collapse:collapse;font-size:88%;margin:1.2em 0}caption{text-align:left;font-weight:bold;padding:.4em "
    "0}"
    "th,td{border:1px solid #ddd;padding:.2em .6em;text-align:left;vertical-align:top}"
    "td.number{text-align:right;font-variant-numeric:tabular-nums}th{background:#f4f4f4}.wide{overflow-x:auto}";

Table facts_table(const std::string& name, const std::string& caption, const Facts& facts) {
  Table table{name, caption, {"what", "value"}, {}};
  for (const auto& [what, value] : facts) table.rows.push_back({what, value});
  return table;
}

Json object(const Facts& facts) {
  Json out = Json::object();
  for (const auto& [what, value] : facts) out[what] = value;
  return out;
}

/// Files are put to the solvers as they are: with their own target, coordinates and objectives.
void add_files(plugins::Registry& registry, const std::vector<std::string>& files, SolverComparisonSetup& setup,
               std::vector<LeftOut>& left_out) {
  for (const std::string& file : files) {
    const std::string name = std::filesystem::path(file).filename().string();
    BenchScene one{name, scene_from_file(file, {}), {}};
    const ProblemKind problem = one.scene.problem;
    if (problem == ProblemKind::trajectory || problem == ProblemKind::execute || problem == ProblemKind::estimate) {
      left_out.push_back(
          {"scene '" + name + "'", "it does not ask for one plan, which is what the solvers are put to"});
      continue;
    }
    try {
      (void)timed_plan(registry, one.scene);
      setup.scenes.push_back(std::move(one));
    } catch (const Error& error) {
      left_out.push_back({"scene '" + name + "'", error.what()});
    }
  }
}

void say(const std::string& what) { fmt::print(stderr, "{}\n", what); }

}  // namespace

AccuracySetup accuracy_setup(const plugins::Registry& registry, const Extent& extent) {
  AccuracySetup setup;
  setup.scenes = known_scenes(registry);
  setup.values = extent.quick ? std::vector<int>{1, 2, 3, 4, 6, 8, 12}
                              : std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 32, 48, 64};
  setup.most_coordinates = extent.quick ? 48 : 128;
  setup.compared = extent.quick ? 6 : 24;
  setup.repetitions = extent.repetitions_of_timed();
  setup.stop = extent.stop;
  return setup;
}

SolverComparisonSetup solver_setup(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out) {
  SolverComparisonSetup setup;
  setup.scenes = bench_scenes(registry, extent.quick ? 2 : 3);
  if (extent.quick) setup.scenes.resize(3);
  add_files(registry, extent.scenes, setup, left_out);
  setup.starts = extent.quick ? 1 : 2;
  setup.seed = extent.seed;
  setup.repetitions = extent.quick ? 1 : 5;
  // Far above what anybody needs here: a limit of time that bites would make counts depend on the machine.
  setup.time_limit = 10.0;
  setup.stop = extent.stop;
  const std::vector<Contestant> all = find_contestants(registry, left_out);
  // Without an obstacle, and with one to brace on.
  const std::vector<BenchScene> trial = bench_scenes(registry, 1);
  std::vector<Scene> scenes;
  for (const BenchScene& one : trial) {
    if (one.name != "free" && one.name != "brace") continue;
    scenes.push_back(with_target(one, 0));
  }
  setup.contestants = able_contestants(registry, all, scenes, 5.0, left_out);
  return setup;
}

std::vector<double> tolerance_values(const Extent& extent) {
  return extent.quick ? std::vector<double>{1e-3, 1e-6, 1e-9}
                      : std::vector<double>{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
}

bool write_report(plugins::Registry& registry, const ReportArguments& arguments) {
  const Extent& extent = arguments.extent;
  const double begin = now();
  const double processor_begin = processor_now();
  app::StagedFiles files(arguments.directory);

  say("accuracy ...");
  const AccuracySetup how = accuracy_setup(registry, extent);
  const Accuracy accuracy = measure_accuracy(registry, how);
  if (extent.stopped()) return false;
  say("solvers ...");
  std::vector<LeftOut> left_out;
  const SolverComparisonSetup contest = solver_setup(registry, extent, left_out);
  const SolverComparison comparison = compare_solvers(registry, contest);
  if (extent.stopped()) return false;
  const Recommendation recommendation = recommend(registry, how, accuracy, contest, comparison);
  std::vector<Section> sections{recommendation_section(recommendation, how, accuracy, contest, comparison),
                                accuracy_section(how, accuracy), solver_section(contest, comparison)};
  sections.back().left_out.insert(sections.back().left_out.end(), left_out.begin(), left_out.end());
  say("tolerances ...");
  for (const BenchScene& scene : contest.scenes) {
    if (scene.name == "brace") {
      sections.push_back(tolerance_section(registry, contest, scene, tolerance_values(extent)));
    }
  }
  for (const Part& part : parts()) {
    say(part.name + std::string(" ..."));
    const std::vector<Section> more = part.run(registry, extent);
    sections.insert(sections.end(), more.begin(), more.end());
    if (extent.stopped()) return false;
  }

  Section origin;
  origin.name = "origin";
  origin.title = "Where these numbers come from";
  const Facts here = machine();
  const Facts built = versions(registry);
  origin.prose.push_back(fmt::format(
      "Measured in {:.0f} s, one thread, {}, seed {}. Times of plans are processor times, so that what else the "
      "machine "
      "does hardly counts; this process had a processor for {:.0f} % of the time. Times of single solves and "
      "evaluations, "
      "which are too short to be interrupted often, are wall times, of which medians are shown. Counts and errors do "
      "not "
      "depend on the machine's load: the same commit gives the same counts.",
      now() - begin, extent.quick ? "quick: few values and repetitions, whose times decide nothing" : "in full",
      extent.seed, 100.0 * (processor_now() - processor_begin) / (now() - begin)));
  origin.tables = {facts_table("machine", "Machine", here), facts_table("versions", "Versions", built)};
  sections.push_back(origin);

  Json json;
  json["schema"] = 1;
  json["machine"] = object(here);
  json["versions"] = object(built);
  json["extent"] = extent.quick ? "quick" : "full";
  json["seed"] = extent.seed;
  json["sections"] = Json::array();
  for (const Section& section : sections) json["sections"].push_back(Json::parse(bench::json(section)));
  if (arguments.against) {
    sections.insert(sections.begin() + 1, against_section(json.dump(), *arguments.against));
    json["sections"].push_back(Json::parse(bench::json(sections[1])));
  }

  const std::string title = "tendril-bench report";
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + title +
                     "</title><style>" + style + "</style></head><body>\n<h1>" + title + "</h1>\n";
  std::string text = "# " + title + "\n\n";
  for (const Section& section : sections) {
    page += html(section, write_files(section, files));
    text += markdown(section);
  }
  files.write("report.html", page + "</body></html>\n");
  files.write("report.md", text);
  files.write("report.json", json.dump(1) + '\n');
  files.publish();
  fmt::print("{}", markdown(sections.front()));
  if (arguments.against) fmt::print("{}", markdown(sections[1]));
  return true;
}

}  // namespace tendril::bench
