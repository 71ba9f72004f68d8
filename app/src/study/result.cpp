#include "study/result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>

#include "study/case.hpp"
#include "study/grasp.hpp"
#include "system/tables.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/scale.hpp"

namespace tendril::app {

namespace {

/// Collects values one by one.
class Sample {
 public:
  void add(const Json& json, const char* key) {
    const auto found = json.find(key);
    if (found != json.end() && found->is_number()) values_.push_back(found->get<double>());
  }
  void add(double value) { values_.push_back(value); }
  Statistic statistic() const {
    Statistic s;
    s.count = static_cast<int>(values_.size());
    if (s.count == 0) return s;
    for (const double v : values_) s.mean += v / s.count;
    for (const double v : values_) s.deviation += (v - s.mean) * (v - s.mean);
    s.deviation = s.count > 1 ? std::sqrt(s.deviation / (s.count - 1)) : 0.0;
    return s;
  }
  double largest() const { return values_.empty() ? 0.0 : *std::max_element(values_.begin(), values_.end()); }

 private:
  std::vector<double> values_;
};

bool is_solved(const Json& value) { return value.value("status", "") == to_string(PlanStatus::solved); }

void count_arrival(const Json& value, StudyGroup& group) {
  const auto execution = value.find("execution");
  if (execution == value.end() || !execution->is_object()) return;
  const auto same = execution->find("start_leads_to_plan");
  if (same == execution->end() || !same->is_boolean()) return;
  ++group.loaded;
  if (same->get<bool>()) ++group.arrived;
}

/// Why loading from the start did not lead to solved plans: cases of one reason in a line.
std::string arrival_text(const StudyResult& result) {
  std::vector<std::pair<std::string, std::string>> reasons;  // and the cases, in their order
  for (std::size_t i = 0; i < result.cases.size(); ++i) {
    const auto execution = result.values[i].find("execution");
    if (!is_solved(result.values[i]) || execution == result.values[i].end() || !execution->is_object()) continue;
    const auto same = execution->find("start_leads_to_plan");
    if (same == execution->end() || (same->is_boolean() && same->get<bool>())) continue;
    const auto loaded = execution->find("from_start");
    if (loaded == execution->end() || !loaded->is_object()) continue;
    const std::string message = loaded->value("message", "");
    const bool at_rest = loaded->value("status", "") == to_string(PlanStatus::solved);
    if (at_rest && same->is_null()) continue;
    const std::string reason = at_rest ? "the rod comes to rest elsewhere" : printable(message);
    const auto known = std::find_if(reasons.begin(), reasons.end(), [&](const auto& r) { return r.first == reason; });
    if (known == reasons.end()) {
      reasons.emplace_back(reason, fmt::format("{}", result.cases[i].index));
    } else {
      known->second += fmt::format(", {}", result.cases[i].index);
    }
  }
  std::string text;
  for (const auto& [reason, cases] : reasons)
    text += fmt::format("loaded from the start, case {}: {}\n", cases, reason);
  return text;
}

Json statistic_json(const Statistic& s) {
  return {{"cases", s.count},
          {"mean", s.count > 0 ? number(s.mean) : Json(nullptr)},
          {"standard_deviation", s.count > 1 ? number(s.deviation) : Json(nullptr)}};
}

std::string mode_text(const std::optional<StudyMode>& mode) { return mode ? std::string(to_string(*mode)) : "-"; }

std::string plain(double value) { return fmt::format("{}", value); }
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return out + '"';
}

std::string limit_column(const StudyResult& result) {
  std::string unit(result.cases.empty() ? dimension::moment.unit : result.cases.front().limited.unit);
  std::erase(unit, ' ');
  return "limit_" + unit;
}

/// Where the rod is, as far as a sweep moves it.
std::string place_columns(const StudyResult& result) {
  if (result.cases.empty()) return "";
  const StudyCase& one = result.cases.front();
  return std::string(one.insertion ? ",insertion_m" : "") + (one.base_position ? ",base_x_m,base_y_m" : "") +
         (one.base_angle ? ",base_angle_rad" : "") + (one.shift ? ",shift_x_m,shift_y_m" : "") +
         (one.turn ? ",turn_rad" : "");
}

std::string place_cells(const StudyCase& swept, const StudyCase& one) {
  std::string text;
  if (swept.insertion) text += ',' + plain(*one.insertion);
  if (swept.base_position) text += ',' + plain(one.base_position->x) + ',' + plain(one.base_position->y);
  if (swept.base_angle) text += ',' + plain(*one.base_angle);
  if (swept.shift) text += ',' + plain(one.shift->x) + ',' + plain(one.shift->y);
  if (swept.turn) text += ',' + plain(*one.turn);
  return text;
}

std::size_t moment_count(const StudyResult& result) {
  std::size_t most = 0;
  for (const Json& value : result.values) {
    const auto found = value.find("moments");
    if (found != value.end()) most = std::max(most, found->size());
  }
  return most;
}

}  // namespace

StudyResult study_result(const StudySpec& study, const std::map<int, StudyRecord>& records) {
  StudyResult result;
  result.cases = study_cases(study);
  std::vector<std::array<Sample, 4>> samples;
  for (const StudyCase& one : result.cases) {
    const StudyRecord& record = records.at(one.index);
    Json value = Json::parse(record.payload, nullptr, false);
    if (value.is_discarded() || !value.is_object()) {
      throw InputError(fmt::format("the record of case {} holds no result", one.index));
    }
    if (result.groups.empty() || result.groups.back().limit != one.limit || result.groups.back().mode != one.mode) {
      StudyGroup& fresh = result.groups.emplace_back();
      fresh.limit = one.limit;
      fresh.limited = one.limited;
      fresh.mode = one.mode;
      samples.emplace_back();
    }
    StudyGroup& group = result.groups.back();
    ++group.cases;
    auto& [moment, contact, tip, model] = samples.back();
    // A plan that execution refuses for its model error must not hide it.
    model.add(value, "model_error");
    if (is_solved(value)) {
      ++group.solved;
      double largest = 0.0;
      for (const Json& m : value["moments"])
        largest = std::max(largest, m.is_number() ? std::abs(m.get<double>()) : 0.0);
      moment.add(largest);
      contact.add(value, "contact_force");
      tip.add(value, "tip_error");
      count_arrival(value, group);
    }
    result.records.push_back(record);
    result.values.push_back(std::move(value));
  }
  for (std::size_t i = 0; i < result.groups.size(); ++i) {
    const auto& [moment, contact, tip, model] = samples[i];
    result.groups[i].moment = moment.statistic();
    result.groups[i].contact_force = contact.statistic();
    result.groups[i].tip_error = tip.statistic();
    result.groups[i].model_error = model.statistic();
    result.groups[i].largest_model_error = model.largest();
  }
  return result;
}

std::string limit_text(const DisplayUnits& units, double limit, const Dimension& limited) {
  return limited.unit == dimension::pressure.unit ? units.pressure(limit)
         : limited.unit == dimension::force.unit  ? force(limit)
                                                  : units.moment(limit);
}

bool all_solved(const StudyResult& result) {
  return std::all_of(result.values.begin(), result.values.end(), is_solved);
}

std::string study_json(const Scene& scene, const StudyResult& result) {
  Json head;
  head["schema"] = 1;
  head["scene"] = std::filesystem::path(scene.file).filename().string();
  head["title"] = scene.title;
  head["problem"] = "study";
  head["status"] = all_solved(result) ? "solved" : "some cases are not solved";
  Json groups = Json::array();
  for (const StudyGroup& group : result.groups) {
    groups.push_back(
        {{"limit", group.limit ? number(*group.limit) : Json(nullptr)},
         {"limit_unit", group.limit ? Json(group.limited.unit) : Json(nullptr)},
         {"mode", group.mode ? Json(to_string(*group.mode)) : Json(nullptr)},
         {"cases", group.cases},
         {"solved", group.solved},
         {"moment", statistic_json(group.moment)},
         {"contact_force", statistic_json(group.contact_force)},
         {"tip_error", statistic_json(group.tip_error)},
         {"model_error", statistic_json(group.model_error)},
         {"largest_model_error", group.model_error.count > 0 ? number(group.largest_model_error) : Json(nullptr)},
         {"loaded_from_start", group.loaded},
         {"arrived_from_start", group.arrived}});
  }
  head["groups"] = std::move(groups);
  add_surroundings(head, scene);
  if (scene.contact.friction_state == FrictionState::any) head["friction_state"] = "any";
  head["versions"] = versions_json();
  // The records go in as they stand, one on each line.
  std::string text = written(head);
  text.erase(text.find_last_of('}'));
  while (text.back() == '\n' || text.back() == ' ') text.pop_back();
  text += ",\n  \"cases\": [";
  for (std::size_t i = 0; i < result.records.size(); ++i) text += (i > 0 ? ",\n" : "\n") + result.records[i].payload;
  return text + "\n]}\n";
}

std::string csv_number(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? plain(found->get<double>()) : "";
}

std::string csv_number(const Json& json, const char* key, std::size_t i) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() <= i || !(*found)[i].is_number()) return "";
  return plain((*found)[i].get<double>());
}

std::string cases_csv(const StudyResult& result) {
  const std::size_t moments = moment_count(result);
  std::string text = "index," + limit_column(result) +
                     ",mode,target_x_m,target_y_m,status,tip_x_m,tip_y_m,tip_error_m,contact_force_N,model_error_m";
  for (std::size_t i = 0; i < moments; ++i) text += fmt::format(",moment_{}_Nm", i + 1);
  text += place_columns(result) + grasp_columns(result) + ",message\n";
  for (std::size_t i = 0; i < result.cases.size(); ++i) {
    const StudyCase& one = result.cases[i];
    const Json& value = result.values[i];
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}", one.index, one.limit ? plain(*one.limit) : "",
                        one.mode ? to_string(*one.mode) : "", one.target ? plain(one.target->x) : "",
                        one.target ? plain(one.target->y) : "", value.value("status", ""), csv_number(value, "tip", 0),
                        csv_number(value, "tip", 1), csv_number(value, "tip_error"), csv_number(value, "contact_force"),
                        csv_number(value, "model_error"));
    for (std::size_t m = 0; m < moments; ++m) text += ',' + csv_number(value, "moments", m);
    text += place_cells(result.cases.front(), one) + grasp_cells(result, i);
    const std::string message = value.value("message", "");
    text += ',' + (message.empty() ? "" : quoted(message)) + '\n';
  }
  return text;
}

std::string groups_csv(const StudyResult& result) {
  std::string text =
      limit_column(result) +
      ",mode,cases,solved,moment_mean_Nm,moment_sd_Nm,contact_force_mean_N,contact_force_sd_N,tip_error_mean_m,"
      "tip_error_sd_m,model_error_mean_m,model_error_largest_m,"
      "loaded_from_start,arrived_from_start\n";
  const auto pair = [](const Statistic& s) {
    return fmt::format("{},{}", s.count > 0 ? plain(s.mean) : "", s.count > 1 ? plain(s.deviation) : "");
  };
  for (const StudyGroup& g : result.groups) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", g.limit ? plain(*g.limit) : "",
                        g.mode ? to_string(*g.mode) : "", g.cases, g.solved, pair(g.moment), pair(g.contact_force),
                        pair(g.tip_error), g.model_error.count > 0 ? plain(g.model_error.mean) : "",
                        g.model_error.count > 0 ? plain(g.largest_model_error) : "", g.loaded, g.arrived);
  }
  return text;
}

std::string times_csv(const StudyResult& result) {
  std::string text = "index,seconds\n";
  for (const StudyRecord& record : result.records) text += fmt::format("{},{:.6f}\n", record.index, record.seconds);
  return text;
}

std::string study_report(const Scene& scene, const StudyResult& result) {
  if (scene.problem == ProblemKind::grasp) return grasp_study_report(scene, result);
  const DisplayUnits units(scene);
  const auto spread = [](const Statistic& s, const std::function<std::string(double)>& text) {
    if (s.count == 0) return std::string("-");
    return text(s.mean) + (s.count > 1 ? " +- " + text(s.deviation) : "");
  };
  const auto length = [&](double v) { return fmt::format("{:.4g} {}", v / units.length.size, units.length.name); };
  const auto moment = [&](double v) {
    return fmt::format("{:.4g} {}", v / units.moment_unit.size, units.moment_unit.name);
  };
  const double grazing = grazing_force * scale_of(scene).force();
  double largest_force = 0.0;
  for (const StudyGroup& g : result.groups) largest_force = std::max(largest_force, g.contact_force.mean);
  const auto newton = [&](double v) {
    return largest_force >= 1.0 ? fmt::format("{:.4g} N", v) : fmt::format("{:.4g} mN", v * 1e3);
  };
  bool grazes = false;
  Grid grid;
  grid.row(
      {"limit", "mode", "solved", "moment", "contact force", "tip error", "largest model error", "reached from start"});
  for (const StudyGroup& g : result.groups) {
    const bool none = g.contact_force.count > 0 && g.contact_force.mean < grazing;
    grazes = grazes || (none && g.contact_force.mean > 0.0);
    grid.row({g.limit ? limit_text(units, *g.limit, g.limited) : "-", mode_text(g.mode),
              fmt::format("{} of {}", g.solved, g.cases), spread(g.moment, moment),
              none ? "none" : spread(g.contact_force, newton), spread(g.tip_error, length),
              g.model_error.count > 0
                  ? fmt::format("{:.2g} {}", g.largest_model_error / units.length.size, units.length.name)
                  : "-",
              g.loaded > 0 ? fmt::format("{} of {}", g.arrived, g.loaded) : "-"});
  }
  std::string text =
      study_heading(scene) + grid.text("") + "\nmean +- sample standard deviation over the solved cases\n";
  if (grazes) text += fmt::format("none: rods that graze an obstacle with less than {}\n", force(grazing));
  for (std::size_t i = 0; i < result.cases.size(); ++i) {
    const std::string message = printable(result.values[i].value("message", ""));
    if (is_solved(result.values[i]) && message.empty()) continue;
    text += fmt::format("case {}: {}: {}\n", result.cases[i].index, result.values[i].value("status", ""), message);
  }
  return text + arrival_text(result);
}

}  // namespace tendril::app
