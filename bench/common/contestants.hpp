#pragma once

#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// A way of solving: a solver with its options, and a treatment of complementarity.
struct Contestant {
  std::string name;  ///< "solver", "solver, slack", "solver, option = CHOICE"
  std::string solver;
  RawOptions options;
  Treatment treatment = Treatment::penalty;
};

/// The scene for one contestant: everything else stays the same.
Scene with_contestant(Scene scene, const Contestant& contestant);

/// Every solver that is found: as it is, with every treatment, and with every choice of every option that offers words
/// to choose from (algorithms). Solvers that cannot be opened are left out.
std::vector<Contestant> find_contestants(plugins::Registry& registry, std::vector<LeftOut>& left_out);

/// Those that can solve something: out of the choices that an option offers, whoever has no certified plan of any
/// `trial` within `time_limit` (s), or does not take the programs of one, is left out with the reason, and so is one
/// that does the same as an earlier one, to the last bit. Solvers as they are and treatments stay in.
std::vector<Contestant> able_contestants(plugins::Registry& registry, const std::vector<Contestant>& all,
                                         const std::vector<Scene>& trial, double time_limit,
                                         std::vector<LeftOut>& left_out);

}  // namespace tendril::bench
