// What no backend can solve, and what one backend cannot take, in words.

#include "solver/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "solver/stop.hpp"

namespace tendril {

namespace {

/// "6 equilibrium rows, 1 contact_gap row": rows are counted by the name that stands before their number.
std::string count_rows(const NonlinearProgram& program, bool equalities) {
  std::vector<std::pair<std::string, int>> groups;
  for (int i = 0; i < program.row_count(); ++i) {
    if (program.is_equality(i) != equalities) continue;
    std::string group = program.row_name(i);
    const auto end = group.find_last_not_of("0123456789 ");
    if (end != std::string::npos) group.resize(end + 1);
    const std::string tail = " row";
    if (group.size() > tail.size() && group.ends_with(tail)) group.resize(group.size() - tail.size());
    const auto known = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == group; });
    if (known == groups.end()) {
      groups.emplace_back(group, 1);
    } else {
      ++known->second;
    }
  }
  std::string text;
  for (const auto& [group, count] : groups) {
    if (!text.empty()) text += ", ";
    text += std::to_string(count) + " ";
    if (group != "row") text += group + " ";
    text += count == 1 ? "row" : "rows";
  }
  return text;
}

}  // namespace

std::string contradiction(const NonlinearProgram& program) {
  const auto check = [](double lower, double upper) {
    return !(lower <= upper) || lower == infinity || upper == -infinity;
  };
  for (int i = 0; i < program.variable_count(); ++i) {
    if (check(program.lower()[i], program.upper()[i])) {
      return program.variable_name(i) + " must be at least " + shown(program.lower()[i], 3) + " and at most " +
             shown(program.upper()[i], 3);
    }
  }
  for (int i = 0; i < program.row_count(); ++i) {
    if (check(program.row_lower()[i], program.row_upper()[i])) {
      return program.row_name(i) + " must be at least " + shown(program.row_lower()[i], 3) + " and at most " +
             shown(program.row_upper()[i], 3);
    }
  }
  return "";
}

std::string Solver::refusal(const NonlinearProgram& program) const {
  const SolverCapabilities can = capabilities();
  if (!can.equalities) {
    const std::string rows = count_rows(program, true);
    if (!rows.empty()) return name() + " cannot take equality constraints: " + rows;
  }
  if (!can.inequalities) {
    const std::string rows = count_rows(program, false);
    if (!rows.empty()) return name() + " cannot take inequality constraints: " + rows;
  }
  if (can.needs_finite_bounds) {
    for (int i = 0; i < program.variable_count(); ++i) {
      if (!std::isfinite(program.lower()[i]) || !std::isfinite(program.upper()[i])) {
        return name() + " needs finite bounds: " + program.variable_name(i) + " has none on one side";
      }
    }
  }
  return "";
}

}  // namespace tendril
