#include "command/estimate_command.hpp"

#include <optional>

#include "command/result_files.hpp"
#include "figure/sequence_figure.hpp"
#include "result/estimate_report.hpp"
#include "result/sequence_report.hpp"
#include "session/sequence.hpp"
#include "system/progress.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/interrupt.hpp"

namespace tendril::app {

namespace {

int run_sequence(Session& session, const SequenceSpec& spec, const ResultPlaces& places) {
  SequenceEstimate estimate;
  {
    const InterruptGuard guard;
    std::optional<Progress> progress;
    estimate = estimate_sequence(session, spec, InterruptGuard::flag(), [&](std::size_t done, std::size_t all) {
      if (done == 1) progress.emplace("estimate", "frames", all, 0);
      progress->step(false);
    });
  }
  const Scene& scene = session.scene();
  give_result(places,
              {[&] { return sequence_json(scene, spec, estimate, session.run_info()); },
               [&] { return sequence_report(scene, estimate); },
               {},
               [&](StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
                 draw_sequence(scene.title, estimate, scene.rod.length(), files, stem, pictures);
                 return true;
               }},
              session);
  return estimate.status == EstimateStatus::solved ? 0 : 1;
}

}  // namespace

int run_estimate(Session& session, const PlanArguments& arguments) {
  if (arguments.start) throw InputError("--start: an estimate starts from the measured points, expected no --start");
  if (arguments.verify) {
    throw InputError(
        "--verify: the obstacles of an estimate are not known, so nothing can be carried out against them; its shape "
        "is "
        "the rod's equilibrium under the forces that were found; expected no --verify");
  }
  if (const std::optional<SequenceSpec> sequence = sequence_of(session)) {
    return run_sequence(session, *sequence, arguments.places);
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
