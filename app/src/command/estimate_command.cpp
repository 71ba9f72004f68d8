#include "command/estimate_command.hpp"

#include "command/result_files.hpp"
#include "result/estimate_report.hpp"
#include "tendril/app/figure.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// An estimate as a figure knows it: a shape with forces.
Plan drawn(const Estimate& estimate) {
  Plan plan;
  plan.backbone = estimate.backbone;
  for (const EstimatedContact& c : estimate.contacts) {
    if (!c.identifiable) continue;
    PlannedContact contact;
    contact.arc_length = c.arc_length;
    contact.point = c.point;
    contact.normal = c.normal;
    contact.force = c.force;
    plan.contacts.push_back(contact);
  }
  return plan;
}

void draw(const Scene& scene, const Estimate& estimate, StagedFiles& files, const std::string& stem,
          const std::vector<Picture>& pictures) {
  FigureScene figure = figure_scene(scene, {});
  figure.target.reset();
  figure.target_angle.reset();
  for (const MeasuredPoint& p : scene.measurement.points) figure.measured.push_back(p.position);
  if (estimate.status != EstimateStatus::solved) figure.doubt = to_string(estimate.status);
  draw_figure(figure, drawn(estimate), files, stem, pictures);
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
  const Estimate estimate = session.estimate();
  const Scene& scene = session.scene();
  ResultForms forms{[&] { return estimate_json(scene, estimate, session.run_info()); },
                    [&] { return estimate_report(scene, estimate); },
                    {},
                    "the estimate came to no shape"};
  if (!estimate.backbone.empty()) {
    forms.draw = [&](StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
      draw(scene, estimate, files, stem, pictures);
    };
  }
  give_result(arguments.places, forms, session);
  return estimate.status == EstimateStatus::solved ? 0 : 1;
}

}  // namespace tendril::app
