#pragma once

#include <string>

#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::app {

/// The library of the page's server, which nothing else of the command needs; empty: it was not there when this was
/// built.
std::string live_server();

struct LiveArguments {
  SceneArguments scene;
  files::LiveControl control{};
  std::string server = live_server();
};

/// `tendril live`: serves the page until it is ended; returns 0. Throws InputError.
int run_live(const LiveArguments& arguments);

}  // namespace tendril::app
