#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string_view>
#include <tuple>
#include <utility>

#include "campaign/ablation.hpp"
#include "campaign/best_known.hpp"
#include "campaign/campaign.hpp"
#include "campaign/completeness.hpp"
#include "campaign/random_scene.hpp"
#include "campaign/reach.hpp"
#include "campaign/relaxations.hpp"
#include "common/workload.hpp"
#include "report/parts.hpp"
#include "report/report.hpp"
#include "report/tolerance_sweep.hpp"
#include "search/parameters.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/version.hpp"

namespace {

using namespace tendril;

struct Arguments {
  std::vector<std::string> limits, solvers, plugin_directories, settings, search;
  std::string targets_x, targets_y, output, report, against;
  int starts = 0;
  bool treatments = false;
  std::string seeds = "1:1000";
  int executions = bench::CompletenessSetup{}.executions;
  int jobs = 1;
  double time_limit = bench::CampaignSetup{}.time_limit, share = bench::CampaignSetup{}.share;
  int targets = bench::ReachSetup{}.targets, way_points = bench::ReachSetup{}.way_points;
  double tolerance = bench::ReachSetup{}.tolerance;
  std::string relaxation;
  bool one = false, print_scene = false, ablation = false, relaxed = false, list_search = false, outlines = false;
  bool friction = false;
  bench::Extent extent;
};

plugins::Registry registry_of(const Arguments& arguments) {
  const std::vector<std::filesystem::path> places(arguments.plugin_directories.begin(),
                                                  arguments.plugin_directories.end());
  return plugins::Registry(plugins::Catalog(plugins::search_places(places)));
}

/// Prints sections and, if asked for, writes their files.
int show(const Arguments& arguments, const std::vector<bench::Section>& sections) {
  if (app::InterruptGuard::flag().load()) return 1;
  for (const bench::Section& section : sections) fmt::print("{}", bench::markdown(section));
  if (arguments.output.empty()) return 0;
  app::StagedFiles files(arguments.output);
  for (const bench::Section& section : sections) {
    bench::write_files(section, files);
    files.write(section.name + ".md", bench::markdown(section));
  }
  files.publish();
  return 0;
}

/// The comparison of the report, or the user's own scenes, targets and limits.
int solvers(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  std::vector<LeftOut> left_out;
  if (arguments.extent.scenes.empty()) {
    const bench::SolverComparisonSetup setup = bench::solver_setup(registry, arguments.extent, left_out);
    std::vector<bench::Section> sections{bench::solver_section(setup, bench::compare_solvers(registry, setup))};
    sections.front().left_out = left_out;
    for (const bench::BenchScene& scene : setup.scenes) {
      if (scene.name != "brace") continue;
      sections.push_back(bench::tolerance_section(registry, setup, scene, bench::tolerance_values(arguments.extent)));
    }
    return show(arguments, sections);
  }
  bench::SolverComparisonSetup setup;
  if (arguments.targets_x.empty() != arguments.targets_y.empty())
    throw Error("--targets-x and --targets-y go together");
  for (const std::string& file : arguments.extent.scenes) {
    for (bench::BenchScene& scene : bench::scenes_from_file(file, arguments.settings)) {
      if (!arguments.targets_x.empty()) {
        scene.targets.clear();
        for (const double x : bench::read_lengths(arguments.targets_x, scene.scene.read_quantity)) {
          for (const double y : bench::read_lengths(arguments.targets_y, scene.scene.read_quantity)) {
            scene.targets.push_back({Vec2{x, y}, std::nullopt});
          }
        }
      }
      setup.scenes.push_back(std::move(scene));
    }
  }
  for (const std::string& limit : arguments.limits) {
    setup.limits.push_back(setup.scenes.front().scene.read_quantity(limit, dimension::moment));
  }
  for (const std::string& solver : arguments.solvers) (void)registry.solver(solver);
  for (const bench::Contestant& contestant : bench::find_contestants(registry, left_out)) {
    const bool asked = arguments.solvers.empty() || std::find(arguments.solvers.begin(), arguments.solvers.end(),
                                                              contestant.solver) != arguments.solvers.end();
    const bool plain = contestant.options.empty() && contestant.treatment == Treatment::penalty;
    if (asked && (plain || (arguments.treatments && contestant.options.empty()))) {
      setup.contestants.push_back(contestant);
    }
  }
  setup.starts = arguments.starts;
  setup.seed = arguments.extent.seed;
  setup.repetitions = std::max(1, arguments.extent.repetitions);
  setup.tells_runs = true;
  setup.stop = arguments.extent.stop;
  bench::Section section = bench::solver_section(setup, bench::compare_solvers(registry, setup));
  section.left_out = left_out;
  return show(arguments, {section});
}

int accuracy(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  const bench::AccuracySetup setup = bench::accuracy_setup(registry, arguments.extent);
  return show(arguments, {bench::accuracy_section(setup, bench::measure_accuracy(registry, setup))});
}

int report(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  bench::ReportArguments how{arguments.report, arguments.extent, std::nullopt};
  if (!arguments.against.empty()) how.against = arguments.against;
  return bench::write_report(registry, how) ? 0 : 1;
}

/// "A:B", both included.
std::pair<std::uint64_t, std::uint64_t> read_seeds(const std::string& text) {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  char rest = 0;
  unsigned long long a = 0;
  unsigned long long b = 0;
  if (std::sscanf(text.c_str(), "%llu:%llu%c", &a, &b, &rest) == 2) {
    first = a;
    last = b;
  }
  if (first == 0 || last < first) throw Error("--seeds " + text + ": expected FIRST:LAST, for instance 1:1000");
  return {first, last};
}

int campaign(const Arguments& arguments) {
  for (const std::string& setting : arguments.search) {
    const std::size_t equals = std::min(setting.find('='), setting.size());
    set_search_parameter(setting.substr(0, equals), setting.substr(std::min(equals + 1, setting.size())));
  }
  if (arguments.list_search) {
    for (const SearchParameter& p : list_search_parameters())
      fmt::print("{:<24}{:>8}  {}\n", p.name, p.value, p.meaning);
    return 0;
  }
  bench::CampaignSetup setup;
  std::tie(setup.first, setup.last) = read_seeds(arguments.seeds);
  setup.solvers = arguments.solvers.empty() ? registry_of(arguments).names(ComponentKind::solver) : arguments.solvers;
  if (setup.solvers.empty()) throw Error("no solver was found");
  setup.time_limit = arguments.time_limit;
  setup.outlines = arguments.outlines;
  setup.friction = arguments.friction;
  setup.relaxation = arguments.relaxation;
  if (arguments.print_scene) {
    const std::set<std::string> names = bench::names_at_hand(registry_of(arguments));
    for (std::uint64_t seed = setup.first; seed <= setup.last; ++seed) {
      const bench::RandomScene scene =
          bench::random_scene(seed, setup.solvers.front(), setup.time_limit, names, setup.outlines, setup.friction);
      fmt::print("# seed {}: {}\n{}", seed, scene.summary, scene.text);
    }
    return 0;
  }
  if (arguments.one) {
    plugins::Registry registry = registry_of(arguments);
    fmt::print("{}\n", bench::campaign_line(registry, setup.first, setup));
    return 0;
  }
  setup.jobs = arguments.jobs;
  setup.share = arguments.share;
  setup.plugin_directories = arguments.plugin_directories;
  setup.stop = arguments.extent.stop;
  if (arguments.ablation) return show(arguments, {bench::ablation_section(setup, arguments.search)});
  setup.search = arguments.search;
  if (arguments.relaxed) {
    int violations = 0;
    const bench::Section section = bench::relaxation_section(setup, violations);
    return show(arguments, {section}) != 0 || violations > 0 ? 1 : 0;
  }
  const std::vector<bench::CampaignCase> cases = bench::run_campaign(setup);
  const int shown = show(arguments, {bench::campaign_section(setup, cases)});
  return shown != 0 || !bench::acceptable(setup, cases) ? 1 : 0;
}

int complete(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  bench::CompletenessSetup setup;
  std::tie(setup.first, setup.last) = read_seeds(arguments.seeds);
  setup.executions = arguments.executions;
  setup.time_limit = arguments.time_limit;
  setup.stop = arguments.extent.stop;
  std::vector<bench::Section> sections;
  bool false_claim = false;
  for (const std::string& solver :
       arguments.solvers.empty() ? registry.names(ComponentKind::solver) : arguments.solvers) {
    setup.solver = solver;
    const std::vector<bench::CompletenessCase> cases = bench::run_completeness(registry, setup);
    sections.push_back(bench::completeness_section(setup, cases));
    for (const bench::CompletenessCase& c : cases) false_claim = false_claim || (c.complete && c.found_more);
  }
  return show(arguments, sections) != 0 || false_claim ? 1 : 0;
}

int best_known(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  bench::BestKnownSetup setup;
  std::tie(setup.first, setup.last) = read_seeds(arguments.seeds);
  setup.solvers = arguments.solvers.empty() ? registry.names(ComponentKind::solver) : arguments.solvers;
  setup.starts = arguments.starts;
  setup.time_limit = arguments.time_limit;
  setup.stop = arguments.extent.stop;
  const std::vector<bench::BestKnownCase> cases = bench::run_best_known(registry, setup);
  const int shown = show(arguments, {bench::best_known_section(setup, cases)});
  return shown != 0 || !bench::finds_best(setup, cases, arguments.share) ? 1 : 0;
}

int reach(const Arguments& arguments) {
  plugins::Registry registry = registry_of(arguments);
  bench::ReachSetup setup;
  setup.scene = bench::scene_from_file(arguments.extent.scenes.front(), arguments.settings);
  setup.targets = arguments.targets;
  setup.seed = arguments.extent.seed;
  setup.tolerance = arguments.tolerance;
  setup.way_points = arguments.way_points;
  setup.stop = arguments.extent.stop;
  const std::vector<bench::ReachCase> cases = bench::run_reach(registry, setup);
  const auto reached = std::count_if(cases.begin(), cases.end(), [](const auto& c) { return c.reached; });
  const int shown = show(arguments, {bench::reach_section(setup, cases)});
  return shown != 0 || static_cast<double>(reached) < arguments.share * static_cast<double>(cases.size()) ? 1 : 0;
}

/// A command with what all commands take; with `output` also where its tables go.
CLI::App* add_command(CLI::App& program, Arguments& arguments, const char* name, const char* description,
                      bool output = true) {
  CLI::App* sub = program.add_subcommand(name, description);
  sub->add_option("--plugin-dir", arguments.plugin_directories,
                  "Directory to search for plugins first; may be repeated")
      ->expected(1)
      ->take_all();
  sub->add_flag("--quick", arguments.extent.quick, "A small selection, to see that everything works");
  sub->add_option("--repetitions", arguments.extent.repetitions, "Interleaved repetitions of what is timed")
      ->check(CLI::Range(1, 10000));
  if (output) sub->add_option("--output", arguments.output, "Directory for tables (CSV, JSON, Markdown) and figures");
  return sub;
}

void add_list(CLI::App* command, const char* name, std::vector<std::string>& to, const char* description) {
  command->add_option(name, to, description)->expected(1)->take_all();
}

CLI::App* add_solvers(CLI::App& program, Arguments& arguments) {
  CLI::App* command = add_command(program, arguments, "solvers",
                                  "Every solver, algorithm and treatment of complementarity on the same programs");
  command->add_option("SCENE", arguments.extent.scenes, "Scene files (TOML); without one: the scenes of the report");
  command->add_option("--targets-x", arguments.targets_x, "First, last, count, for instance \"91 mm:99 mm:5\"");
  command->add_option("--targets-y", arguments.targets_y, "The same for y");
  add_list(command, "--limit", arguments.limits, "Limit of every actuator's moment; may be repeated");
  add_list(command, "--solver", arguments.solvers, "Solver to compare, by default every one found; may be repeated");
  add_list(command, "--set", arguments.settings, "Sets a key of the scene: KEY=VALUE");
  command->add_flag("--treatments", arguments.treatments, "Every treatment of complementarity, too");
  command->add_option("--starts", arguments.starts, "Random starts per target; 0: the scene's own")
      ->check(CLI::Range(0, 100000));
  command->add_option("--seed", arguments.extent.seed, "Seed of the random starts");
  return command;
}

void add_only(CLI::App* command, Arguments& arguments) {
  command->add_option("--only", arguments.extent.only, "Of the extreme cases: those whose group or name holds this");
}

CLI::App* add_part(CLI::App& program, Arguments& arguments, const bench::Part& part) {
  CLI::App* command = add_command(program, arguments, part.name, part.description);
  if (std::string_view(part.name) == "extremes") {
    command->add_option("--held-out", arguments.extent.held_out,
                        "Seed of other numbers, each up to a tenth from those of the table");
    add_only(command, arguments);
  }
  return command;
}

CLI::App* add_campaign(CLI::App& program, Arguments& arguments) {
  CLI::App* command =
      add_command(program, arguments, "campaign", "Random scenes, every plan checked: nothing may crash, hang or lie");
  command->add_option("--seeds", arguments.seeds, "First and last seed, FIRST:LAST");
  add_list(command, "--solver", arguments.solvers, "Solver to plan with, by default every one found; may be repeated");
  command->add_option("--jobs", arguments.jobs, "Processes at a time")->check(CLI::Range(1, 1024));
  command->add_option("--time-limit", arguments.time_limit, "Seconds for one plan")->check(CLI::Range(1e-3, 1e6));
  command->add_option("--share", arguments.share, "Share of the cases that have to be met")
      ->check(CLI::Range(0.0, 1.0));
  add_list(command, "--search", arguments.search, "Sets a number that steers the search: NAME=VALUE; may be repeated");
  command->add_flag("--list-search", arguments.list_search, "Lists these numbers instead of planning");
  command->add_flag("--ablation", arguments.ablation,
                    "What each strategy of the search, or each --search, is worth, one at a time");
  command->add_flag("--relaxed", arguments.relaxed,
                    "Whether changes that allow more give no worse plan, and how often the best known plan is found");
  command->add_flag("--outlines", arguments.outlines,
                    "Obstacles that are not convex: stars, bars with notches, rooms, channels");
  command->add_flag("--friction", arguments.friction, "Contacts rub, and plans are made for any state, or the worst");
  std::vector<std::string> names;
  for (const bench::Relaxation& relaxation : bench::relaxations()) names.push_back(relaxation.name);
  command->add_option("--relaxation", arguments.relaxation, "Changes every scene by one of these first")
      ->check(CLI::IsMember(names));
  command->add_flag("--one", arguments.one, "Plans the first seed in this process: one line of JSON");
  command->add_flag("--print-scene", arguments.print_scene, "Prints the scenes instead of planning them");
  return command;
}

CLI::App* add_complete(CLI::App& program, Arguments& arguments) {
  CLI::App* command = add_command(program, arguments, "complete",
                                  "Whether plans that say they are complete are the best that executions come to");
  command->add_option("--seeds", arguments.seeds, "First and last seed of random scenes, FIRST:LAST");
  add_list(command, "--solver", arguments.solvers, "Solver to plan with, by default every one found; may be repeated");
  command->add_option("--executions", arguments.executions, "Of each scene")->check(CLI::Range(1, 1000000));
  return command;
}

CLI::App* add_best_known(CLI::App& program, Arguments& arguments) {
  CLI::App* command =
      add_command(program, arguments, "best-known", "How often a normal search finds the best plan that is known");
  command->add_option("--seeds", arguments.seeds, "First and last seed of random scenes, FIRST:LAST");
  add_list(command, "--solver", arguments.solvers, "Solver to plan with, by default every one found; may be repeated");
  add_list(command, "--search", arguments.search, "Sets a number that steers the search: NAME=VALUE; may be repeated");
  command->add_option("--starts", arguments.starts, "Random shapes to start from, of each scene")
      ->check(CLI::Range(0, 1000000));
  command->add_option("--time-limit", arguments.time_limit, "Seconds for one plan")->check(CLI::Range(1e-3, 1e6));
  command->add_option("--share", arguments.share, "Share of the scenes whose best known plan each solver has to find")
      ->check(CLI::Range(0.0, 1.0));
  return command;
}

CLI::App* add_reach(CLI::App& program, Arguments& arguments) {
  CLI::App* command =
      add_command(program, arguments, "reach", "Plans to random targets that the rod of a scene is known to reach");
  command->add_option("SCENE", arguments.extent.scenes, "Scene file (TOML) of a pose")->required()->expected(1);
  command->add_option("--targets", arguments.targets, "How many")->check(CLI::Range(1, 1000000));
  command->add_option("--seed", arguments.extent.seed, "Seed of the first target; the next one has the next seed");
  command->add_option("--tolerance", arguments.tolerance, "Of the rod's length: a tip within it is there")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--way-points", arguments.way_points, "Random inputs that lead the rod to each target in turn")
      ->check(CLI::Range(1, 100));
  command->add_option("--share", arguments.share, "Share of the targets that have to be reached")
      ->check(CLI::Range(0.0, 1.0));
  add_list(command, "--set", arguments.settings, "Sets a key of the scene: KEY=VALUE");
  return command;
}

void add_report(CLI::App& program, Arguments& arguments) {
  CLI::App* command =
      add_command(program, arguments, "report", "All of these as one page, with a recommendation", false);
  command->add_option("DIR", arguments.report, "Directory of the report")->required();
  command->add_option("SCENE", arguments.extent.scenes,
                      "Scene files (TOML) to put to the solvers, too, each with its own target");
  command->add_option("--against", arguments.against, "Directory of another report to compare with");
  command->add_option("--seed", arguments.extent.seed, "Seed of the random starts");
  add_only(command, arguments);
}

int run(int argc, char** argv) {
  CLI::App program("Compares what tendril is made of by error, effort and success.", "tendril-bench");
  program.require_subcommand(1);
  program.set_version_flag("--version", TENDRIL_VERSION);
  Arguments arguments;
  const CLI::App* accuracy_command =
      add_command(program, arguments, "accuracy", "Error against run time of every coordinate model that is found");
  const CLI::App* solvers_command = add_solvers(program, arguments);
  std::vector<const CLI::App*> part_commands;
  for (const bench::Part& part : bench::parts()) part_commands.push_back(add_part(program, arguments, part));
  const CLI::App* campaign_command = add_campaign(program, arguments);
  const CLI::App* complete_command = add_complete(program, arguments);
  const CLI::App* best_known_command = add_best_known(program, arguments);
  const CLI::App* reach_command = add_reach(program, arguments);
  add_report(program, arguments);
  try {
    program.parse(argc, argv);
    const app::InterruptGuard interrupt;
    arguments.extent.stop = &app::InterruptGuard::flag();
    if (accuracy_command->parsed()) return accuracy(arguments);
    if (solvers_command->parsed()) return solvers(arguments);
    if (campaign_command->parsed()) return campaign(arguments);
    if (complete_command->parsed()) return complete(arguments);
    if (best_known_command->parsed()) return best_known(arguments);
    if (reach_command->parsed()) return reach(arguments);
    for (std::size_t i = 0; i < part_commands.size(); ++i) {
      if (!part_commands[i]->parsed()) continue;
      plugins::Registry registry = registry_of(arguments);
      return show(arguments, bench::parts()[i].run(registry, arguments.extent));
    }
    return report(arguments);
  } catch (const CLI::Success& message) {
    return program.exit(message);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "tendril-bench: {}\n", error.what());
    return 2;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tendril-bench: %s\n", error.what());
    return 2;
  }
}
