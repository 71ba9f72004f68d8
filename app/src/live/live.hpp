#pragma once

#include "tendril/app/session.hpp"

namespace tendril::app {

/// The library of the page's server, which nothing else of the command needs; empty: it was not there when this was
/// built.
std::string live_server();

struct LiveArguments {
  SceneArguments scene;
  int port = 0;  ///< 0: any that is free
  bool open_browser = true;
  std::string server = live_server();
};

/// `tendril live`: serves the page until Ctrl-C; returns 0. Throws InputError.
int run_live(const LiveArguments& arguments);

}  // namespace tendril::app
