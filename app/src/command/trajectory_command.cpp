#include "command/trajectory_command.hpp"

#include <algorithm>

#include "command/result_files.hpp"
#include "result/trajectory_result.hpp"
#include "system/output.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

int run_trajectory(Session& session, const PlanArguments& arguments) {
  if (arguments.start) throw InputError("--start: a trajectory starts from its scene, expected no --start");
  Trajectory trajectory = session.plan_trajectory();
  if (arguments.verify) session.verify(trajectory);
  return give_trajectory(session, trajectory, arguments.places, arguments.strict);
}

int give_trajectory(Session& session, const Trajectory& trajectory, const ResultPlaces& places, bool strict) {
  if (trajectory.interrupted) {
    note(std::to_string(trajectory.steps.size()) + " steps were finished before the interruption");
  }
  give_result(places,
              {[&] { return trajectory_json(session.scene(), trajectory, session.run_info()); },
               [&] { return trajectory_report(session.scene(), trajectory); }, "no step came to a shape"},
              session);
  const bool cut = std::any_of(trajectory.steps.begin(), trajectory.steps.end(),
                               [](const TrajectoryStep& step) { return step.plan.search_cut; });
  return trajectory.solved() && !(strict && cut) ? 0 : 1;
}

}  // namespace tendril::app
