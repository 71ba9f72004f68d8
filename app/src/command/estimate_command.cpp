#include "command/estimate_command.hpp"

#include "result/estimate_report.hpp"
#include "system/output.hpp"
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
  draw_figure(figure, drawn(estimate), files, stem, pictures);
}

bool has_shape(const Estimate& estimate) {
  if (estimate.backbone.empty()) note("no figure: the estimate came to no shape");
  return !estimate.backbone.empty();
}

}  // namespace

int run_estimate(Session& session, const PlanArguments& arguments) {
  if (arguments.start) throw InputError("--start: an estimate starts from the measured points, expected no --start");
  const Estimate estimate = session.estimate();
  const Scene& scene = session.scene();
  const RunInfo run = session.run_info();
  const std::string json = arguments.json || arguments.output ? estimate_json(scene, estimate, run) : "";
  if (arguments.output) {
    {
      StagedFiles files(*arguments.output);
      files.write("result.json", json);
      files.publish();
    }
    // A result without its picture is still a result.
    try {
      if (has_shape(estimate)) {
        StagedFiles files(*arguments.output);
        draw(scene, estimate, files, "figure", {Picture::svg, Picture::png});
        files.publish();
      }
    } catch (const InputError& error) {
      note(error.what());
    }
  }
  if (arguments.figure && has_shape(estimate)) {
    StagedFiles files(arguments.figure->parent_path());
    draw(scene, estimate, files, arguments.figure->stem().string(), {picture_of(*arguments.figure)});
    files.publish();
  }
  print(arguments.json ? json : estimate_report(scene, estimate));
  return estimate.status == EstimateStatus::solved ? 0 : 1;
}

}  // namespace tendril::app
