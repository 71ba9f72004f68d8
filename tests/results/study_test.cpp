// The files of a study: means and deviations are those of its cases, the tables are those of the JSON, and a case's
// numbers are those of its plan and of what was executed.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "command.hpp"
#include "consistency.hpp"
#include "tendril/app/scene_reader.hpp"
#include "text_consistency.hpp"

namespace tendril::results {
namespace {

using app::test::read_file;
using app::test::TemporaryDirectory;
using Rows = std::vector<std::map<std::string, std::string>>;

/// Rows of a table by the names of its columns. Only a last column is quoted, and holds what is left of the line.
Rows rows_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::vector<std::string> names;
  Rows rows;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    const std::string plain = line.substr(0, line.find('"'));
    std::istringstream text(plain + (plain.empty() || plain.back() == ',' ? " " : ""));
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell == " " ? "" : cell);
    if (plain.size() < line.size()) cells.back() = line.substr(plain.size());
    if (names.empty()) {
      names = cells;
      continue;
    }
    EXPECT_EQ(cells.size(), names.size()) << line;
    for (std::size_t i = 0; i < std::min(cells.size(), names.size()); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[names[i]] = cells[i];
    }
  }
  return rows;
}

/// A cell is empty for null and what is not there, and else the number, to its last digit.
void expect_cell(const std::map<std::string, std::string>& row, const std::string& column, const Json& value) {
  const auto found = row.find(column);
  ASSERT_NE(found, row.end()) << column;
  if (value.is_number()) {
    ASSERT_NE(found->second, "") << column;
    EXPECT_EQ(std::stod(found->second), value.get<double>()) << column;
  } else {
    EXPECT_EQ(found->second, value.is_string() ? value.get<std::string>() : "") << column;
  }
}

Json entry(const Json& object, const char* key, std::size_t i) {
  const auto found = object.find(key);
  return found == object.end() || !found->is_array() || found->size() <= i ? Json() : (*found)[i];
}

/// "mean", "standard_deviation" (of a sample) and "cases" of a group, from the values of its cases.
void expect_statistic(const Json& group, const char* key, const std::vector<double>& values) {
  SCOPED_TRACE(key);
  const Json& said = group.at(key);
  const auto n = static_cast<double>(values.size());
  EXPECT_EQ(said.at("cases"), values.size());
  if (values.empty()) {
    EXPECT_TRUE(said.at("mean").is_null());
    return;
  }
  double sum = 0.0;
  for (const double v : values) sum += v;
  double squares = 0.0;
  for (const double v : values) squares += (v - sum / n) * (v - sum / n);
  EXPECT_NEAR(said.at("mean").get<double>(), sum / n, 1e-14 * std::abs(sum));
  if (values.size() < 2) {
    EXPECT_TRUE(said.at("standard_deviation").is_null());
  } else {
    EXPECT_NEAR(said.at("standard_deviation").get<double>(), std::sqrt(squares / (n - 1.0)), 1e-12 * std::abs(sum));
  }
}

void expect_groups(const Json& study) {
  std::size_t next = 0;
  for (const Json& group : study.at("groups")) {
    SCOPED_TRACE(group.at("mode").dump() + " " + group.at("limit").dump());
    std::map<std::string, std::vector<double>> values;
    std::size_t solved = 0;
    std::size_t cases = 0;
    std::size_t loaded = 0;
    std::size_t arrived = 0;
    for (; next < study.at("cases").size(); ++next, ++cases) {
      const Json& one = study.at("cases").at(next);
      if (one.at("limit") != group.at("limit") || one.at("mode") != group.at("mode")) break;
      const auto add = [&](const char* key) {
        if (one.contains(key) && one.at(key).is_number()) values[key].push_back(one.at(key).get<double>());
      };
      add("model_error");
      if (one.at("status") != "solved") continue;
      ++solved;
      add("contact_force");
      add("tip_error");
      double largest = 0.0;
      for (const Json& m : one.at("moments")) largest = std::max(largest, std::abs(m.get<double>()));
      values["moment"].push_back(largest);
      const Json& same = one.at("execution").at("start_leads_to_plan");
      loaded += same.is_boolean() ? 1 : 0;
      arrived += same == true ? 1 : 0;
    }
    EXPECT_EQ(group.at("cases"), cases);
    EXPECT_EQ(group.at("solved"), solved);
    EXPECT_EQ(group.at("loaded_from_start"), loaded);
    EXPECT_EQ(group.at("arrived_from_start"), arrived);
    for (const char* key : {"moment", "contact_force", "tip_error", "model_error"})
      expect_statistic(group, key, values[key]);
    const std::vector<double>& errors = values["model_error"];
    const Json largest = errors.empty() ? Json() : Json(*std::max_element(errors.begin(), errors.end()));
    EXPECT_EQ(group.at("largest_model_error"), largest);
  }
  EXPECT_EQ(next, study.at("cases").size());
}

void expect_group_table(const std::string& directory, const Json& study) {
  const Rows groups = rows_of(read_file(directory + "/groups.csv"));
  ASSERT_EQ(groups.size(), study.at("groups").size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Json& group = study.at("groups").at(i);
    expect_cell(groups[i], "limit_Nm", group.at("limit"));
    expect_cell(groups[i], "mode", group.at("mode"));
    for (const auto& [column, key] :
         {std::pair("cases", "cases"), std::pair("solved", "solved"),
          std::pair("model_error_largest_m", "largest_model_error"),
          std::pair("loaded_from_start", "loaded_from_start"), std::pair("arrived_from_start", "arrived_from_start")}) {
      expect_cell(groups[i], column, group.at(key));
    }
    for (const auto& [column, key] : {std::pair("moment", "moment"), std::pair("contact_force", "contact_force"),
                                      std::pair("tip_error", "tip_error"), std::pair("model_error", "model_error")}) {
      const std::string name = column;
      const std::string unit = name == "moment" ? "_Nm" : name == "contact_force" ? "_N" : "_m";
      expect_cell(groups[i], name + "_mean" + unit, group.at(key).at("mean"));
      if (name != "model_error") expect_cell(groups[i], name + "_sd" + unit, group.at(key).at("standard_deviation"));
    }
  }
}

void expect_tables(const std::string& directory, const Json& study) {
  const Rows cases = rows_of(read_file(directory + "/cases.csv"));
  ASSERT_EQ(cases.size(), study.at("cases").size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE("case " + std::to_string(i));
    const Json& one = study.at("cases").at(i);
    expect_cell(cases[i], "index", one.at("index"));
    expect_cell(cases[i], "limit_Nm", one.at("limit"));
    expect_cell(cases[i], "mode", one.at("mode"));
    expect_cell(cases[i], "status", one.at("status"));
    for (const auto& [column, key, k] : {std::tuple("target_x_m", "target", 0U), std::tuple("target_y_m", "target", 1U),
                                         std::tuple("tip_x_m", "tip", 0U), std::tuple("tip_y_m", "tip", 1U),
                                         std::tuple("moment_1_Nm", "moments", 0U)}) {
      expect_cell(cases[i], column, entry(one, key, k));
    }
    for (const auto& [column, key] :
         {std::pair("tip_error_m", "tip_error"), std::pair("contact_force_N", "contact_force"),
          std::pair("model_error_m", "model_error")}) {
      expect_cell(cases[i], column, one.value(key, Json()));
    }
    EXPECT_EQ(cases[i].at("message").empty(), one.at("message") == "");
    for (const auto& [column, key] :
         {std::pair("diameter_m", "diameter"), std::pair("force_limit_N", "force_limit"),
          std::pair("moment_change_Nm", "moment_change"), std::pair("palm_distance_m", "palm_distance"),
          std::pair("axial_force_N", "axial_force"), std::pair("lateral_force_N", "lateral_force"),
          std::pair("axial_stiffness_N_per_m", "axial_stiffness")}) {
      if (one.contains("diameter")) expect_cell(cases[i], column, one.value(key, Json()));
    }
    if (one.contains("pressures")) {
      for (std::size_t p = 0; p < one.at("pressures").size(); ++p) {
        expect_cell(cases[i], "pressure_" + std::to_string(p + 1) + "_Pa", one.at("pressures").at(p));
      }
    }
  }
  const Rows times = rows_of(read_file(directory + "/times.csv"));
  ASSERT_EQ(times.size(), cases.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i].at("index"), std::to_string(i));
  expect_group_table(directory, study);
}

double force_of(const Json& contacts) {
  double sum = 0.0;
  for (const Json& contact : contacts) sum += contact.at("force").get<double>();
  return sum;
}

/// A case of poses against its own plan and executions.
void expect_case(const Json& one) {
  SCOPED_TRACE("case " + one.at("index").dump());
  EXPECT_EQ(one.at("moments"), one.at("plan").at("moments"));
  if (one.at("status") != "solved") return;
  const bool meets = one.at("mode") == "ignore_then_execute";
  const Json& own = one.at("execution").at("from_plan");
  const Json& reached = meets ? one.at("execution").at("from_start") : own;
  const auto tip = [](const Json& state, const char* axis) { return state.at("tip").at(axis).get<double>(); };
  EXPECT_EQ(one.at("tip"), Json({tip(reached, "x"), tip(reached, "y")}));
  const double x = tip(reached, "x") - one.at("target").at(0).get<double>();
  const double y = tip(reached, "y") - one.at("target").at(1).get<double>();
  EXPECT_NEAR(one.at("tip_error").get<double>(), std::hypot(x, y), 1e-14);
  EXPECT_EQ(one.at("contact_force").get<double>(), force_of(reached.at("contacts")));
  EXPECT_NEAR(one.at("model_error").get<double>(),
              std::hypot(tip(own, "x") - tip(one.at("plan"), "x"), tip(own, "y") - tip(one.at("plan"), "y")), 1e-14);
  // Drawn points are sums of a series, the tip is the integral itself: rounding of a few lengths.
  const Json& drawn = one.at("lines").at(0).back();
  for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(drawn.at(i).get<double>(), one.at("tip").at(i).get<double>(), 1e-14);
}

std::string joined_words(const std::string& text) {
  std::istringstream words(text);
  std::string all;
  for (std::string word; words >> word;) all += word + ' ';
  return all;
}

/// A row of the report of a study of poses: means and deviations to four digits.
void expect_row(const std::string& report, const Json& group, const Scene& scene) {
  const auto four = [](double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", v);
    return std::string(text);
  };
  const auto spread = [&](const char* key, double size, const std::string& of) {
    const Json& s = group.at(key);
    if (s.at("mean").is_null()) return std::string("-");
    const std::string mean = four(s.at("mean").get<double>() / size) + " " + of;
    if (s.at("standard_deviation").is_null()) return mean;
    return mean + " +- " + four(s.at("standard_deviation").get<double>() / size) + " " + of;
  };
  const std::string row = group.at("mode").get<std::string>() + " " + group.at("solved").dump() + " of " +
                          group.at("cases").dump() + " " +
                          spread("moment", moment_unit_of(scene).size, moment_unit_of(scene).name);
  EXPECT_NE(report.find(row), std::string::npos) << row << '\n' << report;
  const std::string errors = spread("tip_error", unit_of(scene).size, unit_of(scene).name);
  EXPECT_NE(report.find(errors), std::string::npos) << errors << '\n' << report;
}

TEST(StudyOfPoses, AgreesWithItsCasesAndItsTables) {
  // Three metres long, so that no length is a number of millimetres. The weak actuator cannot press as hard as the
  // third paradigm asks for.
  std::string text = read_file(app::test::scene_path("brace.toml"));
  const auto put = [&](const char* old_text, const char* new_text) {
    for (std::size_t at = 0; (at = text.find(old_text, at)) != std::string::npos; at += std::string(new_text).size())
      text.replace(at, std::string(old_text).size(), new_text);
  };
  put("4.9e-4 N m^2", "0.441 N m^2");
  put("84 g/m", "2.8 g/m");
  put(" mm\"", " cm\"");
  put("\"100 cm\"", "\"3 m\"");
  put("\"60 cm\"", "\"1.8 m\"");
  put("\"8 cm\"", "\"0.24 m\"");
  put("\"97 cm\", \"20 cm\"", "2.91, 0.6");
  put("mode = \"allow\"", "min_force = \"0.15 N\"");
  text +=
      "[study]\nlimits = [0.02, 0.3]\nmodes = [\"ignore_then_execute\", \"avoid\", \"require\"]\n"
      "targets = [[2.85, 0.48], [2.6, 1.2]]\n";
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", text);
  const std::string out = directory / "out";
  const app::test::CommandRun run = app::test::tendril({"study", scene, "--output", out});
  EXPECT_EQ(run.exit_code, 1) << run.err << run.out;
  const Json study = Json::parse(read_file(out + "/study.json"));
  EXPECT_EQ(study.at("status"), "some cases are not solved");
  std::size_t unsolved = 0;
  for (const Json& one : study.at("cases")) {
    unsolved += one.at("status") == "solved" ? 0 : 1;
    expect_case(one);
    const std::string said = "case " + one.at("index").dump() + ": " + one.at("status").get<std::string>() + ": ";
    EXPECT_EQ(run.out.find(said) == std::string::npos, one.at("status") == "solved") << said;
  }
  EXPECT_EQ(unsolved, 2U);
  expect_groups(study);
  expect_tables(out, study);
  EXPECT_EQ(read_file(out + "/table.txt"), run.out);
  const std::string report = joined_words(run.out);
  const Scene read = app::read_scene(app::Document::read(scene), std::make_shared<app::Units>());
  for (const Json& group : study.at("groups")) expect_row(report, group, read);
}

// One arc is all that a heavy arm is planned with. Where it is asked to reach up with a strong actuator it settles 1.5
// m from its plan, far beyond the 5 % of its length that are let pass; else within 0.1 m.
TEST(StudyOfPoses, CountsNoCaseThatExecutionRefutes) {
  const TemporaryDirectory directory;
  const std::string scene = directory.write("s.toml", R"(
title = "A heavy arm in one arc"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[rod]
length = "3 m"
bending_stiffness = "0.441 N m^2"
linear_density = "60 g/m"
[[rod.actuator]]
limit = "1 N m"
[coordinates]
plugin = "pcc"
[target]
position = [2.9, 0]
[[objective]]
plugin = "tip_pose"
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
[solver]
plugin = ")" TENDRIL_TEST_SOLVER R"("
[study]
limits = [0.5, 2]
targets = [[2, -1], [2.5, 0.5]]
)");
  const std::string out = directory / "out";
  const app::test::CommandRun run = app::test::tendril({"study", scene, "--output", out});
  EXPECT_EQ(run.exit_code, 1) << run.err << run.out;
  const Json study = Json::parse(read_file(out + "/study.json"));
  const Json& refuted = study.at("cases").at(3);
  EXPECT_EQ(refuted.at("status"), "not_converged");
  EXPECT_EQ(refuted.at("message"), "execution does not confirm the plan: the rod settles elsewhere");
  EXPECT_GT(refuted.at("model_error").get<double>(), 0.15);
  EXPECT_NE(run.out.find("case 3: not_converged: execution does not confirm the plan"), std::string::npos) << run.out;
  for (const Json& one : study.at("cases")) expect_case(one);
  expect_groups(study);
  expect_tables(out, study);
}

TEST(StudyOfGrasps, AgreesWithItsCasesAndItsTables) {
  const TemporaryDirectory directory;
  const std::string text = read_file(app::test::scene_path("grasp_60mm.toml")) +
                           "\n[study]\ndiameters = [\"50 mm\", \"60 mm\"]\nmoments = [\"-5 N mm\", \"5 N mm\"]\n";
  const std::string scene_file = directory.write("s.toml", text);
  const std::string out = directory / "out";
  const app::test::CommandRun run = app::test::tendril({"study", scene_file, "--output", out});
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
  const Json study = Json::parse(read_file(out + "/study.json"));
  expect_tables(out, study);
  const Scene scene = app::read_scene(app::Document::read(scene_file), std::make_shared<app::Units>());
  const std::string report = joined_words(run.out);
  ASSERT_EQ(study.at("cases").size(), 4U);
  for (const Json& one : study.at("cases")) {
    SCOPED_TRACE("case " + one.at("index").dump());
    EXPECT_EQ(one.at("diameter").get<double>(), one.at("index").get<int>() < 2 ? 0.05 : 0.06);
    const double change = one.at("moment_change").get<double>();
    EXPECT_NEAR(one.at("moments").at(1).get<double>(), one.at("planned_moment").get<double>() + change, 1e-15);
    EXPECT_EQ(one.at("moments").at(0), one.at("plan").at("moments").at(0));
    EXPECT_EQ(one.at("palm_distance"), one.at("plan").at("palm_distance"));
    EXPECT_EQ(one.at("planned_axial_force"), one.at("plan").at("grasp").at("axial_force"));
    EXPECT_EQ(one.at("axial_stiffness"), one.at("plan").at("grasp").at("axial_stiffness"));
    for (std::size_t i = 0; i < 2; ++i) {
      const double moment = one.at("moments").at(i).get<double>();
      EXPECT_NEAR(one.at("pressures").at(i).get<double>() * scene.rod.actuators[i].moment_per_pressure, moment, 1e-14);
    }
    // Both lines are mirror images at the axis, y = 0.
    for (std::size_t i = 0; i < one.at("lines").at(0).size(); ++i) {
      const Json& above = one.at("lines").at(0).at(i);
      const Json& below = one.at("lines").at(1).at(i);
      EXPECT_NEAR(above.at(0).get<double>(), below.at(0).get<double>(), 1e-15);
      EXPECT_NEAR(above.at(1).get<double>(), -below.at(1).get<double>(), 1e-15);
    }
    const std::string row = length_text(one.at("palm_distance").get<double>(), scene) + " " +
                            moment_text(one.at("moments").at(0).get<double>(), scene) + ", " +
                            moment_text(one.at("moments").at(1).get<double>(), scene) + " ";
    EXPECT_NE(report.find(row), std::string::npos) << row << '\n' << run.out;
  }
}

}  // namespace
}  // namespace tendril::results
