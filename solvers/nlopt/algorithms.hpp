#pragma once

#include <nlopt.h>

#include <string>
#include <string_view>
#include <vector>

namespace tendril::nlopt_plugin {

/// What one of NLopt's algorithms can take; NLopt itself only tells by failing in the middle of a solve.
struct Algorithm {
  std::string_view name;
  nlopt_algorithm id;
  bool gradient = false;
  bool equalities = false;
  bool inequalities = false;
  bool finite_bounds = false;
  bool bounds = true;
  bool has_inner = false;    ///< runs `local_algorithm` inside
  bool random = false;       ///< needs a seed to be reproducible
  bool halves_step = false;  ///< shortens its step where the cost is infinite
  int least_variables = 1;
};

/// By NLopt's own name without "NLOPT_"; null if there is none.
const Algorithm* find_algorithm(std::string_view name);
std::vector<std::string> algorithm_names();

}  // namespace tendril::nlopt_plugin
