#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::app {

/// Where a user wants a result.
struct ResultPlaces {
  std::optional<std::filesystem::path> output;  ///< directory of result.json and of a figure in all formats
  std::optional<std::filesystem::path> figure;  ///< file of the figure alone
  std::optional<std::filesystem::path> movie;   ///< file of a movie
  bool json = false;                            ///< on standard output
};

struct PlanArguments {
  SceneArguments scene;
  std::optional<std::filesystem::path> start;
  ResultPlaces places;
  bool verify = false;
  bool strict = false;  ///< a search that time cut short is no success
};

struct ExecuteArguments {
  SceneArguments scene;
  files::Inputs inputs;
  std::optional<std::filesystem::path> plan;  ///< a result to take the moments from, instead
  std::optional<std::filesystem::path> start;
  ResultPlaces places;
};

struct ViewArguments {
  std::filesystem::path result;
  std::optional<std::filesystem::path>
      output;  ///< the page, picture or movie; else a page named like the result, in the current directory
  std::vector<std::filesystem::path> plugin_directories;
};

struct CalibrateArguments {
  SceneArguments scene;
  ResultPlaces places;
};

struct SensitivityArguments {
  SceneArguments scene;
  files::SensitivityWishes wishes{};
  bool json = false;
};

/// Each runs one command and returns its exit code: 0 solved, 1 no acceptable plan. What a user can repair is thrown as
/// InputError. Results go to standard output, notes to standard error.
int run_plan(const PlanArguments& arguments);
int run_execute(const ExecuteArguments& arguments);
int run_calibrate(const CalibrateArguments& arguments);
int run_sensitivity(const SensitivityArguments& arguments);
int run_describe(const SceneArguments& arguments, bool json);
int run_view(const ViewArguments& arguments);
/// Only writes what run_view() writes of a result's text; `name` is what messages call the result. Returns what is to
/// be known of it. `stop` ends a movie.
std::vector<std::string> write_view(const files::ResultText& result, const std::filesystem::path& file,
                                    plugins::Registry& registry, const std::atomic<bool>* stop = nullptr);
int run_plugins(const std::vector<std::filesystem::path>& plugin_directories, bool json);

/// The whole command: reads the arguments, runs, prints errors. Exit code 2 for wrong input of any kind.
int run_command_line(int argc, const char* const* argv);

}  // namespace tendril::app
