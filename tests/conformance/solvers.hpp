#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tendril/options.hpp"
#include "tendril/solver.hpp"

namespace tendril::conformance {

/// Opens the plugins that are to be tested: those named in `arguments` (--solver NAME, --plugin-dir DIRECTORY; what is
/// understood is taken out), else every solver on the plugin path. Before InitGoogleTest. Throws where a plugin cannot
/// be had.
void load_solvers(std::vector<std::string>& arguments);

/// Names of what was loaded, sorted.
const std::vector<std::string>& solver_names();

/// A new solver; what `options` leave open is the plugin's default.
std::unique_ptr<Solver> make_solver(const std::string& name, const RawOptions& options = {});

/// Why `solver` is known to fail `test`; empty if it has to pass. A listed test that passes is reported, so that the
/// table stays true.
std::string expected_failure(const std::string& solver, const std::string& test);

}  // namespace tendril::conformance
