#pragma once

#include <map>
#include <string>
#include <vector>

#include "result/result_object.hpp"
#include "study/journal.hpp"
#include "system/tables.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"
#include "tendril/app/session.hpp"

namespace tendril::app {

/// Mean and sample standard deviation of the cases that have the quantity.
struct Statistic {
  int count = 0;
  double mean = 0.0;
  double deviation = 0.0;
};

/// All cases with the same limit and mode.
struct StudyGroup {
  std::optional<double> limit;
  Dimension limited = dimension::moment;  ///< what it limits
  std::optional<StudyMode> mode;
  int cases = 0;
  int solved = 0;
  Statistic moment;         ///< N m, the largest size of a case's moments
  Statistic contact_force;  ///< N, the sum over a case's contacts
  Statistic tip_error;      ///< m
  Statistic model_error;    ///< m
  double largest_model_error = 0.0;
  int loaded = 0;   ///< cases planned for what they meet whose moments were brought on from the scene's start
  int arrived = 0;  ///< of them, those that came to the plan's own state
};

/// A force (EI/L^2) below which a rod only grazes: execution allows no overlap, and answers to what a plan overlaps, by
/// tolerance::penetration and by its coordinates' error, with that depth times the stiffness of the rod.
inline constexpr double grazing_force = 1e-3;

/// The results of a study: the records' JSON with what follows from it.
struct StudyResult {
  std::vector<StudyCase> cases;
  std::vector<StudyRecord> records;  ///< by index of the case
  std::vector<Json> values;          ///< parsed, likewise
  std::vector<StudyGroup> groups;    ///< in the order of the cases
};
/// `records` has those of every case. Throws InputError if one is no JSON of a case.
StudyResult study_result(const StudySpec& study, const std::map<int, StudyRecord>& records);
/// A limit, for people.
std::string limit_text(const DisplayUnits& units, double limit, const Dimension& limited);
/// Every case has a certified plan.
bool all_solved(const StudyResult& result);

/// A number of a case for a table, in full; empty where there is none. `i`: the place in a list.
std::string csv_number(const Json& json, const char* key);
std::string csv_number(const Json& json, const char* key, std::size_t i);

std::string study_json(const Scene& scene, const StudyResult& result);
std::string cases_csv(const StudyResult& result);
std::string groups_csv(const StudyResult& result);
std::string times_csv(const StudyResult& result);
std::string study_report(const Scene& scene, const StudyResult& result);

/// The colour of the i-th series of a figure.
std::string series_color(std::size_t i);

/// The panels of all groups, from the frames of the study's drawing: a row for each limit, a column for each mode, and
/// means below. Throws InputError as draw_pictures() does.
void draw_study(const Scene& scene, const StudyResult& result, const Json& drawing, StagedFiles& files,
                const std::string& stem, const std::vector<Picture>& pictures);

}  // namespace tendril::app
