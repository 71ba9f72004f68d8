#include "text_consistency.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>

#include "consistency.hpp"

namespace tendril::results {
namespace {

std::string format(const char* how, double value) {
  char text[64];
  std::snprintf(text, sizeof text, how, value);
  return text;
}

std::string point_text(const Json& point, const Scene& scene) {
  const WrittenUnit unit = unit_of(scene);
  return "(" + six_digits(point.at(0).get<double>() / unit.size) + ", " +
         six_digits(point.at(1).get<double>() / unit.size) + ") " + unit.name;
}

std::string angle_text(double rad) {
  return six_digits(rad) + " rad (" + format("%.4g", rad * 180.0 / std::numbers::pi) + " deg)";
}

/// Words of a line with one space between them, so that columns of any width compare.
std::set<std::string> lines_of(const std::string& text) {
  std::set<std::string> lines;
  std::string line;
  for (const char c : text + '\n') {
    if (c == '\n') {
      while (!line.empty() && line.back() == ' ') line.pop_back();
      lines.insert(line);
      line.clear();
    } else if (c != ' ' || (!line.empty() && line.back() != ' ')) {
      line += c;
    }
  }
  return lines;
}

std::string joined(const std::vector<std::string>& cells) {
  std::string line;
  for (const std::string& cell : cells) line += (line.empty() || cell.empty() ? "" : " ") + cell;
  return line;
}

using Lines = std::vector<std::string>;

void add_moments(const Json& result, const Scene& scene, Lines& expected) {
  for (const ShownRod& shown : shown_rods(result, scene)) {
    const std::size_t first = shown.name == "lower" ? result.at("fingers").at(0).at("moments").size() : 0;
    for (std::size_t i = 0; i < shown.rod.actuators.size(); ++i) {
      const ActuatorSpec& actuator = shown.rod.actuators[i];
      const double moment = result.at("moments").at(first + i).get<double>();
      const auto limit = [&](double v) { return std::isfinite(v) ? moment_text(v, scene) : "no limit"; };
      // model.md section 7: 1e-9 EI/L.
      const double close =
          1e-9 * (shown.rod.segments.front().bending_stiffness / shown.rod.length() + std::abs(moment));
      const double to_limit = std::min(moment - actuator.minimum, actuator.maximum - moment);
      const char* where = to_limit > close ? "inside" : to_limit < -close ? "beyond its limit" : "at its limit";
      expected.push_back(joined({shown.name, std::to_string(i + 1), moment_text(moment, scene), limit(actuator.minimum),
                                 limit(actuator.maximum), where}));
      if (actuator.moment_per_pressure == 0.0) continue;
      const double per = actuator.moment_per_pressure;
      const auto pressure = [&](double v) {
        return std::isfinite(v) ? six_digits(1e-3 * v + 0.0) + " kPa" : std::string("no limit");
      };
      const auto [low, high] = std::minmax({actuator.minimum / per, actuator.maximum / per});
      expected.push_back(joined({shown.name, std::to_string(i + 1), pressure(result.at("pressures").at(first + i)),
                                 pressure(low), pressure(high), where}));
    }
  }
}

void add_contacts(const Json& result, const Scene& scene, Lines& expected) {
  for (const Json& contact : result.at("contacts")) {
    if (contact.contains("extended")) continue;  // a run of them is one line
    const std::string finger = contact.value("finger", "");
    const double stiffness = scene.rod.segments.front().bending_stiffness;
    const double length = scene.rod.length();
    if (contact.at("gap").get<double>() > 1e-9 * length &&
        contact.at("force").get<double>() <= 1e-9 * stiffness / (length * length)) {
      continue;  // planned, but not made
    }
    expected.push_back(joined(
        {finger.empty() ? "" : finger + " with",
         contact.at("obstacle").get<std::string>() + (contact.at("at_tip").get<bool>() ? " (tip)" : ""),
         length_text(contact.at("arc_length").get<double>(), scene), force_text(contact.at("force").get<double>()),
         length_text(contact.at("gap").get<double>(), scene), point_text(contact.at("point"), scene)}));
  }
}

void add_shape(const Json& result, const Scene& scene, Lines& expected) {
  const std::vector<ShownRod> rods = shown_rods(result, scene);
  for (std::size_t i = 0; i < rods.size(); ++i) {
    const Json& tip = (rods.size() == 1 ? result : result.at("fingers").at(i)).at("tip");
    expected.push_back(joined({rods[i].name, "tip", point_text({tip.at("x"), tip.at("y")}, scene) + ",",
                               angle_text(tip.at("angle").get<double>())}));
  }
  if (result.at("target_error").is_number()) {
    expected.push_back("target error " + length_text(result.at("target_error").get<double>(), scene));
  }
  // Read back, JSON has its keys sorted; a report has them in the order of the scene.
  std::string terms;
  for (const ObjectiveSpec& term : scene.objectives) {
    if (!result.at("terms").contains(term.plugin)) continue;
    terms +=
        (terms.empty() ? "" : " + ") + term.plugin + " " + six_digits(result.at("terms").at(term.plugin).get<double>());
  }
  if (!terms.empty()) {
    expected.push_back("objective " + six_digits(result.at("objective").get<double>()) + " = " + terms);
  }
}

void add_certificate(const Json& certificate, Lines& expected) {
  struct Row {
    const char* key;
    const char* text;
    double limit;  ///< model.md section 7
  };
  for (const Row& row : {Row{"equilibrium", "<= 1e-09", 1e-9}, Row{"bounds", "<= 1e-09", 1e-9},
                         Row{"penetration", "<= 1e-09", 1e-9}, Row{"complementarity", "<= 1e-09", 1e-9},
                         Row{"closest_point", "<= 1e-08", 1e-8}, Row{"stationarity", "<= 1e-06", 1e-6}}) {
    const Json& value = certificate.at(row.key);
    std::string name = row.key;
    std::replace(name.begin(), name.end(), '_', ' ');
    const bool known = value.is_number();
    expected.push_back(joined({name, known ? format("%.3g", value.get<double>()) : "none", row.text,
                               known && value.get<double>() <= row.limit ? "ok" : "FAILS"}));
  }
  if (certificate.at("stability").is_number()) {
    const double margin = certificate.at("stability").get<double>();
    expected.push_back(joined({"stability", format("%.3g", margin), "> 1e-06", margin > 1e-6 ? "ok" : "FAILS"}));
  }
  if (certificate.contains("out_of_plane")) {
    expected.push_back(joined({"out of plane", format("%.3g", certificate.at("out_of_plane").get<double>())}));
  }
  for (const Json& failure : certificate.at("failures")) expected.push_back(failure.get<std::string>());
}

void add_grasp(const Json& result, const Scene& scene, Lines& expected) {
  const auto newtons = [](const Json& f) { return six_digits(f.get<double>()) + " N"; };
  const Json& grasp = result.at("grasp");
  expected.push_back("palm distance " + length_text(result.at("palm_distance").get<double>(), scene));
  expected.push_back("net force " + newtons(grasp.at("axial_force")) +
                     " along the axis (positive: away from the palm)");
  expected.push_back("each finger presses " + newtons(grasp.at("lateral_force")) + " across the axis");
  if (!grasp.contains("axial_stiffness")) return;
  const Json& moved = grasp.at("force_by_1_mm_of_place");
  expected.push_back("1 mm of its place " + newtons(moved.at(0)) + " along, " + newtons(moved.at(1)) +
                     " across the axis");
}

void add_plan(const Json& result, Lines& expected) {
  const Json& coordinates = result.at("coordinates");
  expected.push_back("coordinates " + coordinates.at("name").get<std::string>() + ", order " +
                     coordinates.at("order").dump() + ", " + coordinates.at("dimension").dump() + " values" +
                     (coordinates.at("split_at_contact").get<bool>() ? ", split at contact" : ""));
  for (const Json& mode : result.at("modes")) {
    expected.push_back(joined({mode.at("mode").get<std::string>(), mode.at("outcome").get<std::string>(),
                               mode.at("solves").dump() + " solves, " + mode.at("polishes").dump() + " polishes"}));
  }
}

void add_steps(const Json& result, const Scene& scene, Lines& expected) {
  const Json& steps = result.at("steps");
  std::size_t solved = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Json& step = steps[i];
    solved += step.at("status") == "solved" ? 1 : 0;
    std::string contacts;
    double force = 0.0;
    for (const Json& contact : step.at("contacts")) {
      if (contact.at("force").get<double>() <= 0.0) continue;
      contacts += (contacts.empty() ? "" : ", ") + contact.at("obstacle").get<std::string>() +
                  (contact.at("at_tip").get<bool>() ? " (tip)" : "");
      force += contact.at("force").get<double>();
    }
    std::string moments;
    for (const Json& m : step.at("moments")) moments += (moments.empty() ? "" : ", ") + moment_text(m, scene);
    const std::string method = step.at("method") == "subdivided"
                                   ? "over " + step.at("intermediate_targets").dump() + " intermediate targets"
                                   : step.at("method").get<std::string>();
    expected.push_back(joined({std::to_string(i + 1), point_text(step.at("target").at("position"), scene),
                               point_text({step.at("tip").at("x"), step.at("tip").at("y")}, scene),
                               length_text(step.at("target_error").get<double>(), scene), moments,
                               contacts.empty() ? "-" : contacts, contacts.empty() ? "-" : force_text(force),
                               format("%.3g", step.at("certificate").at("stability").get<double>()), method,
                               step.at("status").get<std::string>()}));
  }
  const auto followed =
      std::count_if(steps.begin(), steps.end(), [](const Json& s) { return s["method"] == "followed"; });
  expected.push_back(std::to_string(solved) + " of " + std::to_string(steps.size()) + " steps solved, " +
                     std::to_string(followed) + " without a call of the solver");
}

void add_estimate(const Json& result, const Scene& scene, Lines& expected) {
  for (std::size_t k = 0; k < result.at("contacts").size(); ++k) {
    const Json& c = result.at("contacts").at(k);
    if (!c.at("identifiable").get<bool>()) continue;
    const double force = c.at("force").get<double>();
    expected.push_back(joined({std::to_string(k + 1), force_text(force),
                               format("%.2g", 100.0 * c.at("force_error").get<double>() / force) + " %",
                               length_text(c.at("arc_length").get<double>(), scene),
                               length_text(c.at("arc_length_error").get<double>(), scene),
                               format("%.4f", c.at("correlation").get<double>()), point_text(c.at("point"), scene),
                               "(" + format("%.4f", c.at("normal").at(0).get<double>()) + ", " +
                                   format("%.4f", c.at("normal").at(1).get<double>()) + ")"}));
  }
  expected.push_back("points " + result.at("points").dump() + ", residuals " +
                     length_text(result.at("residual_rms").get<double>(), scene) + " (rms of a coordinate)");
  for (const Json& test : result.at("tests")) {
    const bool none = test.at("contacts") == 0;
    expected.push_back(
        joined({test.at("contacts").dump(), six_digits(test.at("chi2").get<double>()),
                test.at("degrees_of_freedom").dump(), none ? "" : format("%.2g", test.at("probability").get<double>()),
                none                               ? ""
                : test.at("supported").get<bool>() ? "yes"
                                                   : "no"}));
  }
}

Lines expected_lines(const Json& result, const Scene& scene) {
  Lines expected{scene.title + " (" + scene.file + ")"};
  if (result.contains("steps")) {
    add_steps(result, scene, expected);
    return expected;
  }
  expected.push_back("status " + result.at("status").get<std::string>());
  if (result.at("message") != "") expected.push_back(result.at("message").get<std::string>());
  for (const Json& item : result.at("left_out")) {
    expected.push_back(joined({item.at("what").get<std::string>(), item.at("why").get<std::string>()}));
  }
  if (result.at("problem") == "estimate") {
    add_estimate(result, scene, expected);
    return expected;
  }
  if (result.at("problem") == "execute") {
    char load[32];
    std::snprintf(load, sizeof load, "%.9g", result.at("load").at("reached").get<double>());
    expected.push_back(std::string("path load fraction ") + load + " reached in " +
                       result.at("load").at("steps").dump() + " steps, " +
                       result.at("load").at("contact_changes").dump() + " contacts made or released");
  } else {
    add_plan(result, expected);
  }
  if (result.at("backbone").empty()) return expected;
  add_shape(result, scene, expected);
  add_moments(result, scene, expected);
  add_contacts(result, scene, expected);
  add_certificate(result.at("certificate"), expected);
  if (result.contains("grasp")) add_grasp(result, scene, expected);
  return expected;
}

}  // namespace

std::string six_digits(double value) { return format("%.6g", value); }

WrittenUnit unit_of(const Scene& scene) {
  if (const auto written = scene.units.find("m"); written != scene.units.end()) return written->second;
  const double length = scene.rod.length();
  return length < 2e-3 ? WrittenUnit{"um", 1e-6} : length < 2.0 ? WrittenUnit{"mm", 1e-3} : WrittenUnit{"m", 1.0};
}

WrittenUnit moment_unit_of(const Scene& scene) {
  if (const auto written = scene.units.find("N m"); written != scene.units.end()) return written->second;
  const WrittenUnit length = unit_of(scene);
  return {"N " + length.name, length.size};
}

std::string length_text(double si, const Scene& scene) {
  const WrittenUnit unit = unit_of(scene);
  return six_digits(si / unit.size) + " " + unit.name;
}

std::string moment_text(double si, const Scene& scene) {
  const WrittenUnit unit = moment_unit_of(scene);
  return six_digits(si / unit.size + 0.0) + " " + unit.name;
}

std::string force_text(double si) {
  const double size = std::abs(si);
  if (size >= 1.0 || size == 0.0) return six_digits(si) + " N";
  return size >= 1e-3 ? six_digits(si * 1e3) + " mN" : six_digits(si * 1e6) + " uN";
}

std::vector<std::string> lines_missing(const std::string& text, const Json& result, const Scene& scene) {
  const std::set<std::string> lines = lines_of(text);
  Lines missing;
  for (const std::string& line : expected_lines(result, scene)) {
    if (!lines.contains(line)) missing.push_back(line);
  }
  return missing;
}

}  // namespace tendril::results
