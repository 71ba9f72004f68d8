#pragma once

#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::files {

/// What a program says of a scene, as the command would.
app::SceneArguments arguments_of(const SceneSource& source);

/// Nobody ends a run that has no `stop` of its own: Ctrl-C is the program's.
inline const std::atomic<bool>& stop_of(const std::atomic<bool>* stop) {
  static const std::atomic<bool> never{false};
  return stop != nullptr ? *stop : never;
}

}  // namespace tendril::files
