#include "figure/drawing_numbers.hpp"

#include <fmt/format.h>

namespace tendril::app {

namespace {

void add_number(Json& numbers, const std::string& name, const std::optional<Reader>& value, const std::string& unit) {
  if (value && value->json().is_number()) numbers.push_back({{"name", name}, {"value", value->real()}, {"unit", unit}});
}

void add_tip(Json& numbers, const Reader& state) {
  const auto tip = state.optional("tip");
  if (!tip || !tip->json().is_object()) return;
  add_number(numbers, "tip x", tip->optional("x"), "m");
  add_number(numbers, "tip y", tip->optional("y"), "m");
  add_number(numbers, "tip angle", tip->optional("angle"), "rad");
}

void add_forces(Json& numbers, const Reader& state) {
  for (const Reader& contact : state.member("contacts").list()) {
    const auto obstacle = contact.optional("obstacle");
    const auto finger = contact.optional("finger");
    const std::string of = fmt::format("of {}{}", obstacle ? obstacle->text() : "a contact",
                                       finger ? ", " + finger->text() + " finger" : "");
    add_number(numbers, "force " + of, contact.optional("force"), "N");
    add_number(numbers, "force along the rod " + of, contact.optional("tangential_force"), "N");
  }
}

}  // namespace

Json plan_numbers(const Reader& plan) {
  Json numbers = Json::array();
  add_tip(numbers, plan);
  add_number(numbers, "distance to the target", plan.optional("target_error"), "m");
  if (const auto inputs = plan.optional("inputs")) {
    const std::vector<Reader> list = inputs->list();
    for (std::size_t i = 0; i < list.size(); ++i) {
      const auto finger = list[i].optional("finger");
      add_number(numbers,
                 fmt::format("{}{} {}", finger ? finger->text() + " " : "", list[i].member("kind").text(), i + 1),
                 list[i].optional("value"), list[i].member("unit").text());
      if (const auto where = list[i].optional("where"); where && where->text() != "inside" && !numbers.empty()) {
        numbers.back()["note"] = where->text();
      }
    }
  }
  add_forces(numbers, plan);
  if (const auto load = plan.optional("load")) add_number(numbers, "share of the loads", load->optional("reached"), "");
  add_number(numbers, "palm to object", plan.optional("palm_distance"), "m");
  if (const auto grasp = plan.optional("grasp")) {
    add_number(numbers, "each finger presses", grasp->optional("lateral_force"), "N");
    add_number(numbers, "net force along the axis", grasp->optional("axial_force"), "N");
  }
  add_number(numbers, "objective", plan.optional("objective"), "");
  if (const auto certificate = plan.optional("certificate")) {
    for (const char* name : {"stability", "equilibrium", "penetration", "complementarity", "stationarity"}) {
      add_number(numbers, std::string("certificate: ") + name, certificate->optional(name), "");
    }
  }
  add_number(numbers, "executed, the tip ends beside by", plan.optional("model_error"), "m");
  if (const auto method = plan.optional("method")) {
    numbers.push_back({{"name", "reached"}, {"text", method->text()}});
  }
  return numbers;
}

Json snap_numbers(const Reader& snap, const Reader& state) {
  Json numbers = Json::array();
  add_number(numbers, "share of the loads", snap.optional("load"), "");
  add_tip(numbers, state);
  add_forces(numbers, state);
  return numbers;
}

Json case_numbers(const Reader& one) {
  Json numbers = Json::array();
  const auto limited = one.optional("limit_unit");
  add_number(numbers, "limit", one.optional("limit"), limited ? limited->text() : "N m");
  add_number(numbers, "diameter", one.optional("diameter"), "m");
  add_number(numbers, "force limit", one.optional("force_limit"), "N");
  add_number(numbers, "change of the last moment", one.optional("moment_change"), "N m");
  add_number(numbers, "change of the last pressure", one.optional("pressure_change"), "Pa");
  add_number(numbers, "distance to the target", one.optional("tip_error"), "m");
  if (const auto moments = one.optional("moments")) {
    const std::vector<Reader> list = moments->list();
    for (std::size_t i = 0; i < list.size(); ++i) add_number(numbers, fmt::format("moment {}", i + 1), list[i], "N m");
  }
  add_number(numbers, "contact force", one.optional("contact_force"), "N");
  add_number(numbers, "net force along the axis", one.optional("axial_force"), "N");
  add_number(numbers, "executed, the tip ends beside by", one.optional("model_error"), "m");
  return numbers;
}

}  // namespace tendril::app
