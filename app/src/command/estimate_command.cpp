#include "command/estimate_command.hpp"

#include "command/result_files.hpp"
#include "result/estimate_report.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

int run_estimate(Session& session, const PlanArguments& arguments) {
  if (arguments.start) throw InputError("--start: an estimate starts from the measured points, expected no --start");
  if (arguments.verify) {
    throw InputError(
        "--verify: the obstacles of an estimate are not known, so nothing can be carried out against them; its shape "
        "is "
        "the rod's equilibrium under the forces that were found; expected no --verify");
  }
  const Estimate estimate = session.estimate();
  const Scene& scene = session.scene();
  give_result(arguments.places,
              {[&] { return estimate_json(scene, estimate, session.run_info()); },
               [&] { return estimate_report(scene, estimate); }, "the estimate came to no shape"},
              session);
  return estimate.status == EstimateStatus::solved ? 0 : 1;
}

}  // namespace tendril::app
