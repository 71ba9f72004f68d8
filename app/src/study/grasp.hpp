#pragma once

#include "study/result.hpp"

namespace tendril::app {

/// Plans the grasp of one case, carries it out with the object where it was planned and, if the case says so, with
/// another moment of the last actuator. `scene`: of the case. Adds to `json` what a study keeps.
void run_grasp_case(Session& session, const StudyCase& one, Json& json);

/// Further columns of cases.csv, empty for studies that are not of a grasp; each begins with a comma.
std::string grasp_columns(const StudyResult& result);
std::string grasp_cells(const StudyResult& result, std::size_t index);

/// The table of a study of grasps: one row for each case.
std::string grasp_study_report(const Scene& scene, const StudyResult& result);

/// Shapes, and moments or pressures over the diameter; or forces over the moment that is swept.
void draw_grasp_study(const Scene& scene, const StudyResult& result, const Json& drawing, StagedFiles& files,
                      const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
