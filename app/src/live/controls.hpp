#pragma once

#include <string>
#include <vector>

#include "result/result_object.hpp"
#include "tendril/app/session.hpp"

namespace tendril::app {

/// Something of a scene that the live page may change. The page is offered these and can change nothing else: no text
/// is taken from it, no file is named by it.
struct Control {
  enum class Kind { number, whole, flag, choice, points };
  std::string key;  ///< as for --set
  Kind kind = Kind::number;
  std::string unit{};      ///< that numbers are written with in the scene; empty: none
  double size = 1.0;       ///< of the unit, SI
  Json value{};            ///< as the scene has it, in the unit; points: a list of [x, y]
  bool one_point = false;  ///< written as [x, y] and not as a list of such
  double minimum = -infinity;
  std::vector<std::string> choices{};
  int line = 0, table = 0;  ///< of the scene's file, where it and its table are; 0: not written there
  std::string moves{};      ///< what is dragged by these points: "target", "base", "obstacle 2"
};

/// What can be changed of the scene of a session, in the order of the reference page.
std::vector<Control> controls_of(Session& session);

/// For the page.
Json controls_json(const std::vector<Control>& controls);

/// What the page asks for, {key: value}, as settings of the command. Throws InputError for a key that is not offered
/// and for a value that is none of its kind.
std::vector<Override> overrides_of(const std::vector<Control>& controls, const Json& settings);

}  // namespace tendril::app
