#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tendril/execute.hpp"
#include "tendril/plan.hpp"
#include "tendril/problem.hpp"
#include "tendril/scene.hpp"
#include "tendril/trajectory.hpp"
#include "tendril/uncertainty.hpp"

namespace tendril::app {

/// A plugin or built-in component that was used. `file` is empty for what core brings along.
struct UsedComponent {
  std::string kind;
  std::string name;
  std::string file;
};

/// What the command did around the planner.
struct RunInfo {
  std::vector<UsedComponent> components;
  double seconds_read = 0.0;  ///< reading and checking the scene
  double seconds_open = 0.0;  ///< finding and opening plugins, making components
  /// Where numbers of the scene have error bars: what these make of each plan of the result.
  std::vector<Uncertainty> uncertainties{};
};

/// One JSON document, schema 1. SI units, except objective, terms, coordinates.values and certificate, which are
/// dimensionless. Numbers that are not finite become null. Ends in a line feed.
std::string plan_json(const Scene& scene, const Plan& plan, const RunInfo& run);
/// The same for an execution, with "snaps", "load" and "basis".
std::string execution_json(const Scene& scene, const Execution& execution, const RunInfo& run);
std::string description_json(const Scene& scene, const Description& description, const RunInfo& run);

/// The plan in a file that plan_json() has written, as a start for `scene`. Throws InputError if it is not such a file
/// or belongs to another rod; `what` the file is to be, for messages. Contacts with obstacles that the scene does not
/// have are left out.
Plan read_start(const std::filesystem::path& path, const Scene& scene, const std::string& what = "start");
/// The same from the text of a file; `file` is its name, for messages.
Plan parse_start(const std::string& text, const std::string& file, const Scene& scene,
                 const std::string& what = "start");

/// An earlier result as a start, and what became of it.
struct JudgedPlan {
  Plan plan;                         ///< as a start, with its margin of stability, and solved if it was
  bool executed = false;             ///< given moments were carried out; else it was planned
  std::optional<TargetSpec> step{};  ///< of a trajectory: what it is a step to, with obstacles where they were
};
/// `step`: of a trajectory's result, from 1 on. Throws InputError as read_start() does.
JudgedPlan parse_judged(const std::string& text, const std::string& file, const Scene& scene,
                        const std::optional<int>& step);

/// Targets and moments of the steps in what trajectory_json() has written; empty: it holds one plan, or nothing that
/// can be read. Throws InputError as read_start() does.
std::vector<TrajectoryStep> parse_steps(const std::string& text, const std::string& file, const Scene& scene);

}  // namespace tendril::app
