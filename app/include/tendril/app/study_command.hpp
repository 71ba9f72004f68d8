#pragma once

#include <string>
#include <vector>

#include "tendril/app/session.hpp"
#include "tendril/files/study_file.hpp"

namespace tendril::app {

using files::StudyPlaces;

struct StudyArguments {
  SceneArguments scene;
  StudyPlaces places;
  int jobs = 1;
  bool worker = false;  ///< be a worker of another process
  bool json = false;
  std::vector<std::string> words;  ///< the command line, from the command's name on, for workers
};

/// `tendril study`: 0 if every case has a certified plan, 1 if not or if interrupted. Throws InputError.
int run_study(const StudyArguments& arguments);

}  // namespace tendril::app
