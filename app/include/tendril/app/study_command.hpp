#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tendril/app/session.hpp"

namespace tendril::app {

struct StudyArguments {
  SceneArguments scene;
  std::optional<std::filesystem::path> output;  ///< a directory; without it nothing can be resumed
  std::optional<std::filesystem::path> figure;  ///< file of the figure alone
  std::optional<std::filesystem::path> movie;   ///< file of a movie, a frame for each case
  int jobs = 1;
  std::string shard;    ///< "i/N"; empty: all cases
  bool merge = false;   ///< only join the shards in `output`
  bool worker = false;  ///< be a worker of another process
  bool json = false;
  std::vector<std::string> words;  ///< the command line, from the command's name on, for workers
};

/// `tendril study`: 0 if every case has a certified plan, 1 if not or if interrupted. Throws InputError.
int run_study(const StudyArguments& arguments);

}  // namespace tendril::app
