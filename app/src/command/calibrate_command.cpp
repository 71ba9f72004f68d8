#include "command/calibrate_command.hpp"

#include <fmt/format.h>

#include "command/result_files.hpp"
#include "figure/backbones.hpp"
#include "figure/panels.hpp"
#include "result/calibration_report.hpp"
#include "system/output.hpp"

namespace tendril::app {

namespace {

/// A picture shows so many shapes, spread over the recordings.
constexpr std::size_t most_drawn = 24;

ShapePanel panel_of(const Scene& scene, const Calibration& calibration, bool checked) {
  ShapePanel panel;
  panel.title = checked ? "only checked" : "fitted";
  panel.targets_are = "measured";
  panel.clamp = {scene.rod.base_position, scene.rod.base_angle};
  std::vector<const CalibratedShape*> shapes;
  for (const CalibratedShape& shape : calibration.shapes) {
    if (shape.check_only == checked && !shape.backbone.empty()) shapes.push_back(&shape);
  }
  const std::size_t step = std::max<std::size_t>(1, (shapes.size() + most_drawn - 1) / most_drawn);
  for (std::size_t i = 0; i < shapes.size(); i += step) {
    panel.rods.push_back(line_of(shapes[i]->backbone));
    panel.targets.insert(panel.targets.end(), shapes[i]->measured.begin(), shapes[i]->measured.end());
    // From each point to where the fit has it: what is left, also of markers beside the backbone.
    for (std::size_t m = 0; m < shapes[i]->measured.size(); ++m) {
      panel.rods.push_back({shapes[i]->measured[m], shapes[i]->fitted[m]});
    }
  }
  return panel;
}

/// Mean and largest errors of tips, in percent of the length.
BarPanel bars_of(const Calibration& calibration) {
  BarPanel bars;
  bars.title = "distance of tips from where they were measured";
  bars.axis = "distance";
  bars.quantities = {{"mean", "% of L"}, {"median", "% of L"}, {"largest", "% of L"}};
  const auto add = [&](const char* name, const char* color, const TipErrors& tips) {
    if (tips.count == 0) return;
    const double percent = 100.0 / calibration.length;
    bars.series.push_back(
        {name, color, {percent * tips.mean, percent * tips.median, percent * tips.largest}, {0.0, 0.0, 0.0}});
  };
  add("fitted", "#1f4e8c", calibration.fitted);
  add("left out in turn", "#d98324", calibration.left_out);
  add("left out, beyond the others' loads", "#a23b3b", calibration.left_out_beyond);
  add("only checked", "#2e7d4f", calibration.checked);
  add("only checked, beyond the fitted loads", "#7a5195", calibration.checked_beyond);
  return bars;
}

void draw(const Scene& scene, const Calibration& calibration, StagedFiles& files, const std::string& stem,
          const std::vector<Picture>& pictures) {
  std::vector<ShapePanel> row{panel_of(scene, calibration, false)};
  if (ShapePanel checked = panel_of(scene, calibration, true); !checked.rods.empty()) row.push_back(std::move(checked));
  draw_panels(scene.title, {row}, {bars_of(calibration)}, {}, files, stem, pictures);
}

}  // namespace

std::vector<std::string> write_calibration(Session& session, const Calibration& calibration,
                                           const ResultPlaces& places) {
  const Scene& scene = session.scene();
  const ResultForms forms{[&] { return calibration_json(scene, calibration, session.run_info()); },
                          {},
                          {},
                          [&](StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
                            if (calibration.shapes.empty())
                              throw InputError("no figure: the calibration came to no shape");
                            draw(scene, calibration, files, stem, pictures);
                            return true;
                          }};
  if (places.output && !calibration.shapes.empty()) {
    StagedFiles files(*places.output);
    files.write("rod.toml", session.calibrated_rod(calibration));
    files.publish();
  }
  return write_result(places, forms, session);
}

int run_calibrate(Session& session, const ResultPlaces& places) {
  const Calibration calibration = session.calibrate();
  for (const std::string& text : write_calibration(session, calibration, places)) note(text);
  print(places.json ? calibration_json(session.scene(), calibration, session.run_info())
                    : calibration_report(session.scene(), calibration));
  return calibration.status == CalibrationStatus::solved ? 0 : 1;
}

}  // namespace tendril::app
