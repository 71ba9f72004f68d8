#pragma once

#include <string>

#include "tendril/app/session.hpp"

namespace tendril::app {

/// Plans and executes one case of a study and gives what came of it as JSON on one line, without times. `scene` is the
/// scene of the file. What a case throws belongs to its record: status "failed" with the message.
std::string run_case(Session& session, const Scene& scene, const StudySpec& study, const StudyCase& one);

/// The record of a case that came to nothing.
std::string failed_case(const StudyCase& one, const std::string& message);

/// What stands above the table of a study: the scene's title, or its file without the directory.
std::string study_heading(const Scene& scene);

}  // namespace tendril::app
