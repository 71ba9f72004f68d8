#include "solvers.hpp"

#include <filesystem>
#include <optional>

#include "tendril/plugins/registry.hpp"

namespace tendril::conformance {

namespace {

struct KnownFailure {
  const char* solver;
  const char* test;
  const char* reason;
};

const std::vector<KnownFailure> known_failures{};

struct Loaded {
  std::optional<plugins::Registry> registry;
  std::vector<std::string> names;
};

Loaded& loaded() {
  static Loaded instance;
  return instance;
}

}  // namespace

void load_solvers(std::vector<std::string>& arguments) {
  std::vector<std::string> rest;
  std::vector<std::string> wanted;
  std::vector<std::filesystem::path> directories;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--solver" && has_value) {
      wanted.push_back(arguments[++i]);
    } else if (arguments[i] == "--plugin-dir" && has_value) {
      directories.emplace_back(arguments[++i]);
    } else {
      rest.push_back(arguments[i]);
    }
  }
  arguments = rest;
  Loaded& all = loaded();
  all.registry.emplace(plugins::Catalog(plugins::search_places(directories)));
  all.names = wanted.empty() ? all.registry->names(ComponentKind::solver) : wanted;
  for (const std::string& name : all.names) all.registry->solver(name);
}

const std::vector<std::string>& solver_names() { return loaded().names; }

std::unique_ptr<Solver> make_solver(const std::string& name, const RawOptions& options) {
  const SolverComponent& component = loaded().registry->solver(name);
  return component.make(resolve_options(component.options, options, Scale{}, {}, "solver plugin '" + name + "'"));
}

std::string expected_failure(const std::string& solver, const std::string& test) {
  for (const KnownFailure& known : known_failures) {
    if (solver == known.solver && test == known.test) return known.reason;
  }
  return "";
}

}  // namespace tendril::conformance
