#pragma once

#include "tendril/app/session.hpp"

namespace tendril::app {

struct LiveArguments {
  SceneArguments scene;
  int port = 0;  ///< 0: any that is free
  bool open_browser = true;
};

/// `tendril live`: serves the page until Ctrl-C; returns 0. Throws InputError.
int run_live(const LiveArguments& arguments);

}  // namespace tendril::app
