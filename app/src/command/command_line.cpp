#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>

#include "command/new_command.hpp"
#include "command/reference.hpp"
#include "live/live.hpp"
#include "session/inputs.hpp"
#include "tendril/app/commands.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/study_command.hpp"
#include "tendril/version.hpp"

namespace tendril::app {

namespace {

constexpr int wrong_input = 2;

/// Options that change the scene; every one is a setting of one of its keys.
struct SceneOptions {
  std::string scene;
  std::vector<std::string> plugin_directories;
  std::vector<Override> overrides;

  void add_to(CLI::App& command) {
    command.add_option("SCENE", scene, "Scene file (TOML); - reads it from standard input")->required();
    add_plugin_directory(command, plugin_directories);
    setting(command, "--coordinates", "NAME", "coordinates.plugin", "Coordinate plugin instead of the scene's", true);
    setting(command, "--order", "N", "coordinates.order", "Functions per piece", false);
    setting(command, "--pieces", "N", "coordinates.pieces", "Pieces per actuated segment", false);
    command.add_flag_callback(
        "--split",
        [this] {
          overrides.push_back({"--split", "coordinates.split_at_contact", "true"});
        },
        "Put a knot at each contact point");
    command
        .add_flag_callback(
            "--no-split",
            [this] {
              overrides.push_back({"--no-split", "coordinates.split_at_contact", "false"});
            },
            "Put no knot at contact points")
        ->excludes("--split");
    setting(command, "--solver", "NAME", "solver.plugin", "Solver plugin instead of the scene's", true);
    command
        .add_option_function<std::vector<std::string>>(
            "--set", [this](const std::vector<std::string>& settings) { add_settings(settings); },
            "Sets a key of the scene, for instance contact.max_force=\"0.5 N\", rod.actuator.0.limit=0.01")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
  }

  SceneArguments arguments() const {
    return {scene, overrides, {plugin_directories.begin(), plugin_directories.end()}};
  }

  static void add_plugin_directory(CLI::App& command, std::vector<std::string>& directories) {
    command.add_option("--plugin-dir", directories, "Directory to search for plugins first; may be repeated")
        ->type_name("DIR")
        ->expected(1)
        ->take_all();
  }

 private:
  void setting(CLI::App& command, const std::string& option, const std::string& value, const std::string& key,
               const std::string& description, bool literal) {
    command
        .add_option_function<std::string>(
            option,
            [this, option, key, literal](const std::string& text) {
              overrides.push_back({option + ' ' + text, key, text, literal});
            },
            description)
        ->type_name(value);
  }

  void add_settings(const std::vector<std::string>& settings) {
    for (const std::string& text : settings) {
      const auto equals = text.find('=');
      if (equals == std::string::npos || equals == 0) {
        throw InputError("--set " + text + ": expected KEY=VALUE, for instance --set contact.max_force=\"0.5 N\"");
      }
      overrides.push_back({"--set " + text, text.substr(0, equals), text.substr(equals + 1)});
    }
  }
};

void require_name(const CLI::App& command, const char* option, const std::string& value) {
  if (command.count(option) > 0 && value.empty()) throw InputError(std::string(option) + ": found an empty name");
}

void add_json(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "One JSON document on standard output and nothing else");
}

void add_movie(CLI::App& command, std::string& movie) {
  command.add_option("--movie", movie, "Movie of all steps, states beside snaps, or cases: .gif, or .mp4 with ffmpeg")
      ->type_name("FILE");
}

std::optional<std::filesystem::path> optional_path(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<std::filesystem::path>(text);
}

/// Where a result comes from and goes to.
struct ResultOptions {
  std::string start, output, figure, movie;
  bool json = false;

  void add_to(CLI::App& command, const char* what) {
    command.add_option("--start", start, "Earlier result to start from")->type_name("RESULT.json");
    command.add_option("--output", output, "Directory for result.json and figure.svg, .png, .gnuplot, .dat")
        ->type_name("DIR");
    command.add_option("--figure", figure, std::string("Picture of the ") + what + ", .svg, .png, .pdf or .html")
        ->type_name("FILE");
    add_movie(command, movie);
    add_json(command, json);
  }
  void check(const CLI::App& command) const {
    require_name(command, "--start", start);
    require_name(command, "--output", output);
    require_name(command, "--figure", figure);
    require_name(command, "--movie", movie);
  }
  ResultPlaces places() const { return {optional_path(output), optional_path(figure), optional_path(movie), json}; }
};

/// Names and text of a scene appear in messages; they must not steer the terminal.
std::string harmless(std::string text) {
  for (char& c : text) {
    if ((c >= 0 && c < ' ' && c != '\n') || c == 127) c = '?';
  }
  return text;
}

/// CLI11 says only that something was not expected; this adds what may have been meant.
std::string meant(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2) return "";
  std::vector<std::string> commands;
  const CLI::App* chosen = nullptr;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) commands.push_back(command->get_name());
    if (command->get_name() == argv[1]) chosen = command;
  }
  if (chosen == nullptr) {
    return argv[1][0] == '-' ? ""
                             : "found the command '" + std::string(argv[1]) + "'" + did_you_mean(argv[1], commands);
  }
  std::vector<std::string> options;
  for (const CLI::Option* option : chosen->get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (!word.starts_with("--") || std::find(options.begin(), options.end(), word) != options.end()) continue;
    return "found the option '" + word + "'" + did_you_mean(word, options);
  }
  return "";
}

/// What the reference pages say of the command, taken from what the command itself parses with.
std::vector<CommandSpec> command_specs(const CLI::App& app) {
  std::vector<CommandSpec> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    CommandSpec spec{command->get_name(), command->get_description(), {}};
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_group().empty() || option == command->get_help_ptr()) continue;
      const bool positional = option->get_positional();
      spec.options.push_back({option->get_name(positional),
                              positional || option->get_items_expected_max() == 0 ? "" : option->get_type_name(),
                              option->get_description(), positional, option->get_required()});
    }
    commands.push_back(std::move(spec));
  }
  return commands;
}

int run_reference(const CLI::App& app, const std::string& page, const std::vector<std::string>& directories) {
  const std::vector<std::string> pages{"keys", "man", "bash"};
  if (page == "keys") {
    std::cout << key_page({directories.begin(), directories.end()});
  } else if (page == "man") {
    std::cout << manual_page(command_specs(app));
  } else if (page == "bash") {
    std::cout << bash_completion(command_specs(app));
  } else {
    throw InputError("reference: found the page '" + page + "', expected keys, man or bash" +
                     did_you_mean(page, pages));
  }
  return 0;
}

/// A command as it is parsed, and what it does then. What it parses into lives as long as it.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

Command plan_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    ResultOptions result;
    bool verify = false, strict = false;
  };
  CLI::App* plan =
      app.add_subcommand("plan", "Plan a pose; exit code 0: solved, 1: no acceptable plan, 2: wrong input");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*plan);
  parsed->result.add_to(*plan, "plan");
  plan->add_flag("--verify", parsed->verify, "Execute the plan on a fine basis; its verdict depends on it");
  plan->add_flag("--strict", parsed->strict, "Exit code 1, too, where time ended the search before it was done");
  return {plan, [plan, parsed] {
            const ResultOptions& result = parsed->result;
            result.check(*plan);
            return run_plan({parsed->scene.arguments(), optional_path(result.start), result.places(), parsed->verify,
                             parsed->strict});
          }};
}

Command execute_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    ResultOptions result;
    files::Inputs inputs;
    std::string plan;
  };
  CLI::App* execute = app.add_subcommand(
      "execute", "What the rod does under given moments; exit code 0: a stable equilibrium, 1: none, 2: wrong input");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*execute);
  parsed->result.add_to(*execute, "shape");
  CLI::Option* from_plan =
      execute->add_option("--plan", parsed->plan, "Result whose moments are executed")->type_name("RESULT.json");
  std::vector<CLI::Option*> given{from_plan};
  const auto inputs = [&](files::InputKind kind, const char* type, const char* what) {
    CLI::Option* option = execute->add_option_function<std::string>(
        option_of(kind),
        [parsed, kind](const std::string& text) {
          parsed->inputs.kind = kind;
          parsed->inputs.text = text;
        },
        what);
    option->type_name(type);
    for (CLI::Option* other : given) option->excludes(other);
    given.push_back(option);
  };
  inputs(files::InputKind::moments, "\"M, ...\"",
         "One per actuator, in N m or with units; lists between ';' are way points");
  inputs(files::InputKind::pressures, "\"P, ...\"", "One per actuator, in Pa or with units");
  inputs(files::InputKind::each, "\"V, ...\"",
         "One per actuator, in the unit of its kind: a moment, a pressure where the scene has moment_per_pressure, a "
         "tension");
  execute
      ->add_option("--insertion", parsed->inputs.insertion,
                   "Length of the rod that is out of its port, in m or with a unit; moments are those of --start where "
                   "none are given")
      ->type_name("\"L\"");
  execute->add_option("--base", parsed->inputs.base, "Where the rod is clamped, in m and rad or with units; likewise")
      ->type_name("\"X, Y, ANGLE\"");
  return {execute, [execute, parsed] {
            const ResultOptions& result = parsed->result;
            result.check(*execute);
            require_name(*execute, "--plan", parsed->plan);
            return run_execute({parsed->scene.arguments(), parsed->inputs, optional_path(parsed->plan),
                                optional_path(result.start), result.places()});
          }};
}

Command calibrate_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    std::string output, figure;
    bool json = false;
  };
  CLI::App* calibrate = app.add_subcommand("calibrate",
                                           "Find numbers of the rod from measured shapes; exit code 0: all are "
                                           "identifiable, 1: not all, 2: wrong input");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*calibrate);
  calibrate
      ->add_option(
          "--output", parsed->output,
          "Directory for result.json, figure.svg, .png, .gnuplot, .dat, and rod.toml, which scenes can include")
      ->type_name("DIR");
  calibrate->add_option("--figure", parsed->figure, "Picture of the shapes, .svg, .png or .pdf")->type_name("FILE");
  add_json(*calibrate, parsed->json);
  return {calibrate, [calibrate, parsed] {
            require_name(*calibrate, "--output", parsed->output);
            require_name(*calibrate, "--figure", parsed->figure);
            return run_calibrate({parsed->scene.arguments(),
                                  {optional_path(parsed->output), optional_path(parsed->figure), {}, parsed->json}});
          }};
}

Command sensitivity_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    std::vector<std::string> keys;
    std::string moments, plan;
    std::optional<int> step;
    bool held = false, json = false;
  };
  CLI::App* sensitivity = app.add_subcommand(
      "sensitivity",
      "How a plan follows the numbers of its scene; exit code 0: it has derivatives, 1: none, 2: wrong input");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*sensitivity);
  sensitivity->add_option("KEY", parsed->keys, "Numbers such as obstacle[0].radius, by default all of the scene");
  sensitivity->add_flag("--held", parsed->held,
                        "What the rod does under the plan's moments, held, instead of another plan");
  sensitivity
      ->add_option("--moments", parsed->moments,
                   "What the rod does under these, one per actuator, in N m or with units")
      ->type_name("\"M, ...\"")
      ->excludes("--held");
  CLI::Option* plan =
      sensitivity->add_option("--plan", parsed->plan, "Result of this scene that is taken as it is; nothing is planned")
          ->type_name("RESULT.json")
          ->excludes("--moments");
  sensitivity->add_option("--step", parsed->step, "Which step of the trajectory in --plan, from 1 on")
      ->type_name("N")
      ->needs(plan);
  add_json(*sensitivity, parsed->json);
  return {sensitivity, [sensitivity, parsed] {
            require_name(*sensitivity, "--plan", parsed->plan);
            files::SensitivityWishes wishes{parsed->keys, {files::InputKind::moments, parsed->moments}, parsed->held};
            if (!parsed->plan.empty()) wishes.plan = {read_input(parsed->plan, "plan", largest_result), parsed->plan};
            wishes.step = parsed->step;
            return run_sensitivity({parsed->scene.arguments(), wishes, parsed->json});
          }};
}

Command study_command(CLI::App& app, std::vector<std::string> words) {
  struct Parsed {
    SceneOptions scene;
    StudyArguments arguments;
    std::string output, figure, movie;
  };
  CLI::App* study = app.add_subcommand(
      "study", "Every combination of the sweeps in [study]; exit code 0: all solved, 1: not all, 2: wrong input");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*study);
  StudyArguments& arguments = parsed->arguments;
  arguments.words = std::move(words);
  study->add_option("--output", parsed->output, "Directory for results; run again with it, an unfinished study goes on")
      ->type_name("DIR");
  study->add_option("--figure", parsed->figure, "Picture of the study, .svg, .png, .pdf or .html")->type_name("FILE");
  add_movie(*study, parsed->movie);
  study->add_option("--jobs", arguments.jobs, "Worker processes")->type_name("N")->check(CLI::Range(1, 1024));
  study->add_option("--shard", arguments.places.shard, "Only the i-th of N parts of the cases")->type_name("i/N");
  study->add_flag("--merge", arguments.places.merge, "Join the parts that are in the output directory");
  study->add_flag("--worker", arguments.worker)->group("");
  add_json(*study, arguments.json);
  return {study, [study, parsed] {
            require_name(*study, "--output", parsed->output);
            require_name(*study, "--figure", parsed->figure);
            parsed->arguments.scene = parsed->scene.arguments();
            require_name(*study, "--movie", parsed->movie);
            StudyPlaces& places = parsed->arguments.places;
            places.output = optional_path(parsed->output);
            places.figure = optional_path(parsed->figure);
            places.movie = optional_path(parsed->movie);
            return run_study(parsed->arguments);
          }};
}

Command describe_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    bool json = false;
  };
  CLI::App* describe = app.add_subcommand("describe", "Show the assembled program and what was left out");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*describe);
  add_json(*describe, parsed->json);
  return {describe, [parsed] { return run_describe(parsed->scene.arguments(), parsed->json); }};
}

Command live_command(CLI::App& app) {
  struct Parsed {
    SceneOptions scene;
    int port = 0;
    bool no_browser = false;
  };
  CLI::App* live = app.add_subcommand(
      "live", "A page on this machine: drag the target, obstacles and the base, and see the rod find its way");
  const auto parsed = std::make_shared<Parsed>();
  parsed->scene.add_to(*live);
  live->add_option("--port", parsed->port, "Port of the loopback interface, by default any that is free")
      ->type_name("N")
      ->check(CLI::Range(1, 65535));
  live->add_flag("--no-browser", parsed->no_browser, "Only print the address");
  return {live, [parsed] {
            LiveArguments arguments;
            arguments.scene = parsed->scene.arguments();
            arguments.control.port = parsed->port;
            arguments.control.open_browser = !parsed->no_browser;
            return run_live(arguments);
          }};
}

Command view_command(CLI::App& app) {
  struct Parsed {
    std::string result, output;
    std::vector<std::string> directories;
  };
  CLI::App* view = app.add_subcommand("view", "Show a result: a page that any browser opens, a picture, or a movie");
  const auto parsed = std::make_shared<Parsed>();
  view->add_option("RESULT.json", parsed->result, "What plan, execute or study has written")->required();
  view->add_option("--output", parsed->output,
                   "What to write, .html, .svg, .png, .pdf, .gif or .mp4; by default a page named like the result")
      ->type_name("FILE");
  SceneOptions::add_plugin_directory(*view, parsed->directories);
  return {
      view, [view, parsed] {
        require_name(*view, "--output", parsed->output);
        return run_view(
            {parsed->result, optional_path(parsed->output), {parsed->directories.begin(), parsed->directories.end()}});
      }};
}

Command plugins_command(CLI::App& app) {
  struct Parsed {
    std::vector<std::string> directories;
    bool json = false;
  };
  CLI::App* plugins = app.add_subcommand("plugins", "List what is loadable, with options, and what was refused");
  const auto parsed = std::make_shared<Parsed>();
  SceneOptions::add_plugin_directory(*plugins, parsed->directories);
  add_json(*plugins, parsed->json);
  return {plugins, [parsed] {
            return run_plugins({parsed->directories.begin(), parsed->directories.end()}, parsed->json);
          }};
}

Command new_command(CLI::App& app) {
  struct Parsed {
    NewArguments arguments;
    std::string directory;
  };
  CLI::App* make = app.add_subcommand("new", "Write a plugin project that builds, plans and passes its tests as it is");
  const auto parsed = std::make_shared<Parsed>();
  make->add_option("KIND", parsed->arguments.kind, "coordinates, objective, obstacle or solver")->required();
  make->add_option("NAME", parsed->arguments.name, "Lower-case letters, digits and '_'")->required();
  make->add_option("DIR", parsed->directory, "Directory to make, by default NAME");
  return {make, [make, parsed] {
            if (make->count("DIR") > 0 && parsed->directory.empty()) {
              throw InputError("new: found an empty directory name");
            }
            parsed->arguments.directory = optional_path(parsed->directory);
            return run_new(parsed->arguments);
          }};
}

Command reference_command(CLI::App& app) {
  struct Parsed {
    std::string page;
    std::vector<std::string> directories;
  };
  CLI::App* reference = app.add_subcommand(
      "reference", "Write reference pages: all scene keys and options, a manual page, a completion for bash");
  const auto parsed = std::make_shared<Parsed>();
  reference->add_option("PAGE", parsed->page, "keys, man or bash")->required();
  SceneOptions::add_plugin_directory(*reference, parsed->directories);
  return {reference, [&app, parsed] { return run_reference(app, parsed->page, parsed->directories); }};
}

int parse_and_run(int argc, const char* const* argv) {
  CLI::App app("Plans poses of soft continuum robots that use contact.", "tendril");
  app.require_subcommand(1);
  app.set_version_flag("--version", TENDRIL_VERSION);
  app.get_formatter()->column_width(34);
  const std::vector<Command> commands{
      plan_command(app),      execute_command(app),     study_command(app, {argv + std::min(argc, 1), argv + argc}),
      calibrate_command(app), sensitivity_command(app), describe_command(app),
      live_command(app),      view_command(app),        plugins_command(app),
      new_command(app),       reference_command(app)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string better = meant(app, argc, argv);
    std::cerr << "tendril: " << harmless(better.empty() ? error.what() : better) << "; see 'tendril --help'\n";
    return wrong_input;
  }
  const auto asked =
      std::find_if(commands.begin(), commands.end(), [](const Command& command) { return command.app->parsed(); });
  return asked->run();
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const Error& error) {
    std::cerr << "tendril: " << harmless(error.what()) << '\n';
    return wrong_input;
  } catch (const std::exception& error) {
    std::cerr << "tendril: internal error: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace tendril::app
