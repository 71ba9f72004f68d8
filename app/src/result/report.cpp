#include "tendril/app/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "result/grasp_result.hpp"
#include "result/report_parts.hpp"
#include "result/uncertainty_result.hpp"
#include "system/tables.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::app {

std::string heading(const Scene& scene) {
  const std::string file = printable(scene.file);
  return scene.title.empty() ? file + "\n" : fmt::format("{} ({})\n", printable(scene.title), file);
}

std::string line(const std::string& name, const std::string& value) { return fmt::format("{:<15}{}\n", name, value); }

std::string note_lines(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += line("", printable(note));
  return text;
}

std::string left_out_text(const std::vector<LeftOut>& items) {
  if (items.empty()) return "";
  Grid grid;
  for (const LeftOut& item : items) grid.row({printable(item.what), printable(item.why)});
  return "\nleft out\n" + grid.text("  ");
}

namespace {

std::string shape_text(const Scene& scene, const Plan& plan, const DisplayUnits& units) {
  std::string text;
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    const std::string whose = finger.name.empty() ? "" : finger.name + ' ';
    text += line(whose + "tip",
                 units.point({finger.state.tip_x, finger.state.tip_y}) + ", " + angle(finger.state.tip_angle));
    if (const auto& base = finger.state.place.base) {
      text += line(whose + "base", units.point(base->position) + ", " + angle(base->angle));
    }
  }
  if (plan.place.insertion) text += line("insertion", units.lengths(*plan.place.insertion));
  if (plan.target_error) text += line("target error", units.lengths(*plan.target_error));
  std::string terms;
  for (const auto& [name, value] : plan.terms)
    terms += fmt::format("{}{} {:.6g}", terms.empty() ? "" : " + ", name, value);
  if (!terms.empty()) text += line("objective", fmt::format("{:.6g} = {}", plan.objective, terms));
  return text;
}

std::string verification_text(const Plan& plan) {
  return plan.verification.empty() ? "" : line("execution", printable(plan.verification));
}

/// A table of the actuators that it is about: what each is at, and between which limits. `more`: heads of further
/// columns.
template <class IsIn, class Cells>
std::string actuator_table(const std::vector<ShownActuator>& actuators, const char* head,
                           const std::vector<std::string>& more, const IsIn& is_in, const Cells& cells) {
  Grid grid;
  for (const ShownActuator& a : actuators) {
    if (!is_in(a)) continue;
    std::vector<std::string> row{head, "value", "from", "to", "where"};
    row.insert(row.end(), more.begin(), more.end());
    if (grid.empty()) grid.row(std::move(row));
    row = {(a.finger.empty() ? "" : a.finger + " ") + std::to_string(a.number)};
    for (std::string& cell : cells(a)) row.push_back(std::move(cell));
    row.insert(row.begin() + 4, a.where);
    grid.row(std::move(row));
  }
  return grid.empty() ? std::string() : '\n' + grid.text("");
}

std::string moments_text(const Scene& scene, const Plan& plan, const DisplayUnits& units) {
  const std::vector<ShownActuator> actuators = shown_actuators(scene, plan);
  const auto limited = [](double value, double low, double high, const auto& shown) {
    const auto limit = [&](double v) { return std::isfinite(v) ? shown(v) : std::string("no limit"); };
    return std::vector<std::string>{shown(value), limit(low), limit(high)};
  };
  const auto told = [&](const ShownActuator& a, const auto& shown) {
    const auto [from, to] = std::minmax({a.input_of(a.lowest), a.input_of(a.highest)});
    return limited(a.input_of(a.moment), from, to, shown);
  };
  const auto lengths = [&](double v) { return units.lengths(v); };
  return actuator_table(
             actuators, "moment", {}, [](const ShownActuator& a) { return !a.is(ActuatorKind::tendon); },
             [&](const ShownActuator& a) {
               return limited(a.moment + 0.0, a.lowest + 0.0, a.highest + 0.0,
                              [&](double v) { return units.moment(v); });
             }) +
         actuator_table(
             actuators, "pressure", {}, [](const ShownActuator& a) { return a.is(ActuatorKind::pressure); },
             [&](const ShownActuator& a) { return told(a, [&](double v) { return units.pressure(v); }); }) +
         actuator_table(
             actuators, "tension", {"shortening"},
             [](const ShownActuator& a) { return a.is(ActuatorKind::tendon) && !a.spec.by_length; },
             [&](const ShownActuator& a) {
               std::vector<std::string> cells = told(a, [](double v) { return force(v); });
               cells.push_back(lengths(a.shortening));
               return cells;
             }) +
         actuator_table(
             actuators, "shortening", {"tension"}, [](const ShownActuator& a) { return a.spec.by_length; },
             [&](const ShownActuator& a) {
               std::vector<std::string> cells =
                   limited(a.shortening, a.spec.least_shortening, a.spec.most_shortening, lengths);
               cells.push_back(force(a.input_of(a.moment)));
               return cells;
             });
}

/// Contacts in a row that stand for the stretch along which the rod lies on one obstacle are one line: from where to
/// where, the sum of their forces, the largest gap. `whose`: stands before the obstacle's name.
void add_contacts(Grid& grid, const std::string& whose, const std::vector<PlannedContact>& all,
                  const DisplayUnits& units) {
  for (std::size_t first = 0, next = 0; first < all.size(); first = next) {
    const PlannedContact& contact = all[first];
    double sum = contact.force;
    double gap = contact.gap;
    for (next = first + 1; contact.extended && next < all.size(); ++next) {
      if (!all[next].extended || all[next].obstacle != contact.obstacle) break;
      sum += all[next].force;
      if (std::abs(all[next].gap) > std::abs(gap)) gap = all[next].gap;
    }
    const PlannedContact& last = all[next - 1];
    const std::string name = whose + printable(contact.obstacle_name) + (last.at_tip ? " (tip)" : "");
    if (grid.empty()) grid.row({"contact", "arc length", "force", "gap", "point"});
    if (next - first == 1) {
      const std::string across =
          contact.tangential != 0.0 ? ", " + force(contact.tangential) + " along the rod" : std::string();
      grid.row({name + (contact.extended ? " (extended)" : ""), units.lengths(contact.arc_length),
                force(contact.force) + across, units.lengths(contact.gap), units.point(contact.point)});
      continue;
    }
    grid.row({name + fmt::format(" (extended, {} points)", next - first),
              units.lengths(contact.arc_length) + " to " + units.lengths(last.arc_length), force(sum),
              units.lengths(gap), units.point(contact.point) + " to " + units.point(last.point)});
  }
}

std::string contacts_text(const Scene& scene, const Plan& plan, const DisplayUnits& units) {
  Grid grid;
  std::string left;
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    const std::string whose = finger.name + (finger.name.empty() ? "" : " with ");
    std::vector<PlannedContact> made = finger.state.contacts;
    std::erase_if(made, [&](const PlannedContact& c) {
      if (touches(scene, c)) return false;
      left += (left.empty() ? "" : ", ") + whose + printable(c.obstacle_name) + " (gap " + units.lengths(c.gap) + ')';
      return true;
    });
    add_contacts(grid, whose, made, units);
  }
  return (grid.empty() ? "" : '\n' + grid.text("")) + (left.empty() ? "" : '\n' + line("not touched", left));
}

/// What friction can do to the plan, whatever its state: intervals over all states that were followed.
std::string friction_text(const Scene& scene, const Plan& plan, const DisplayUnits& units) {
  if (plan.friction.empty()) return "";
  const FrictionState state = scene.contact.friction_state;
  const auto interval = [&](const auto& value, const auto& text) {
    const auto [low, high] = std::minmax_element(plan.friction.begin(), plan.friction.end(),
                                                 [&](const auto& a, const auto& b) { return value(a) < value(b); });
    return text(value(*low)) + " to " + text(value(*high));
  };
  const auto length = [&](double v) { return units.lengths(v); };
  const auto x = [](const FrictionRange& r) { return r.tip_x; };
  const auto y = [](const FrictionRange& r) { return r.tip_y; };
  const auto turn = [](const FrictionRange& r) { return r.tip_angle; };
  const auto margin = [](const FrictionRange& r) { return r.stability; };
  const auto pure = [](double v) { return shown(v, 3); };
  std::string text = "\nwhatever friction does, at these inputs";
  if (state == FrictionState::worst) text += ", which are those for the worst of it: the plan shows that";
  if (state == FrictionState::any) text += "; the plan is for friction as the contacts have it";
  text += '\n';
  text += line("tip x", interval(x, length)) + line("tip y", interval(y, length));
  text += line("tip angle", interval(turn, [](double v) { return angle(v); }));
  if (plan.friction.front().target_error) {
    text += line("target error", interval([](const FrictionRange& r) { return r.target_error.value_or(0.0); }, length));
  }
  if (plan.grasp) {
    const auto left = [&](const FrictionRange& r) { return norm(force_on_object(scene, plan, r)); };
    text += line("force left", "on the object, held where it is: " + interval(left, [](double v) { return force(v); }));
  }
  const std::vector<PlannedContact>& contacts = plan.friction.front().contacts;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    // Fingers keep their contacts; a rod may lose one to another state.
    const auto pressed = [&](const FrictionRange& r) {
      const auto same = std::find_if(r.contacts.begin(), r.contacts.end(), [&](const PlannedContact& c) {
        return c.obstacle == contacts[k].obstacle && c.at_tip == contacts[k].at_tip;
      });
      return plan.grasp ? r.contacts[k].force : same == r.contacts.end() ? 0.0 : same->force;
    };
    const bool lower = plan.grasp && k >= plan.contacts.size();
    const std::string name = printable(contacts[k].obstacle_name) + (lower ? " (lower finger)" : "");
    text += line("force", name + ": " + interval(pressed, [](double v) { return force(v); }));
  }
  return text + line("stability", interval(margin, pure));
}

/// The model lets a rod pass through itself; what cannot be made has to be said.
std::string overlap_text(const Scene& scene, const Plan& plan, const DisplayUnits& units) {
  std::string text;
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    const auto& overlap = finger.state.self_overlap;
    if (!overlap) continue;
    text += line("self-overlap", fmt::format("the {} crosses or covers itself: its arc lengths {} and {} meet",
                                             finger.name.empty() ? "rod" : finger.name + " finger",
                                             units.lengths(overlap->first), units.lengths(overlap->second)));
  }
  return text;
}

std::string certificate_text(const Certificate& certificate) {
  Grid grid;
  grid.row({"certificate", "value", "required", ""});
  const auto entry = [&](const char* name, double value, const std::string& required, bool good) {
    grid.row({name, std::isfinite(value) ? fmt::format("{:.3g}", value) : "none", required, good ? "ok" : "FAILS"});
  };
  // Moments that were given may lie beyond their limits: no equilibrium is worse for it.
  const bool held = certificate.valid() && certificate.bounds > tolerance::bounds;
  const auto at_most = [&](const char* name, double value, double limit) {
    entry(name, value, fmt::format("<= {:g}", limit), value <= limit);
  };
  at_most("equilibrium", certificate.equilibrium, tolerance::equilibrium);
  if (held) {
    grid.row({"bounds", fmt::format("{:.3g}", certificate.bounds), fmt::format("<= {:g}", tolerance::bounds),
              "BEYOND: held there"});
  } else {
    at_most("bounds", certificate.bounds, tolerance::bounds);
  }
  at_most("penetration", certificate.penetration, tolerance::penetration);
  at_most("complementarity", certificate.complementarity, tolerance::complementarity);
  at_most("closest point", certificate.closest_point, tolerance::closest_point);
  if (certificate.balance > 0.0) at_most("force balance", certificate.balance, tolerance::balance);
  if (certificate.friction) at_most("friction cones", *certificate.friction, tolerance::friction);
  at_most("stationarity", certificate.stationarity, tolerance::stationarity);
  grid.row({"  kind", certificate.stationarity_kind, "S", certificate.stationarity_kind == "S" ? "ok" : "FAILS"});
  entry(certificate.held_lengths > 0 ? "stability, lengths held" : "stability", certificate.stability,
        fmt::format("> {:g}", tolerance::stability), certificate.stability > tolerance::stability);
  if (certificate.out_of_plane && certificate.guided_in_plane) {
    grid.row({"out of plane", fmt::format("{:.3g}", *certificate.out_of_plane), "(guided)", ""});
  } else if (certificate.out_of_plane) {
    entry("out of plane", *certificate.out_of_plane, fmt::format(">= {:g}", -tolerance::out_of_plane),
          *certificate.out_of_plane >= -tolerance::out_of_plane);
  }
  const auto information = [&](const char* name, double value, const char* what) {
    if (std::isfinite(value)) grid.row({name, fmt::format("{:.3g}", value), what, ""});
  };
  information("convexity", certificate.contact_convexity,
              fmt::format("> {:g} at contacts", tolerance::convexity).c_str());
  if (certificate.least_stretch < 1.0) {
    entry("least stretch", certificate.least_stretch, "> 0", certificate.least_stretch > 0.0);
  }
  information("moment balance", certificate.moment_balance, "(model error)");
  information("quadrature", certificate.quadrature, "(proven bound, or change if doubled)");
  std::string text = '\n' + grid.text("");
  for (const std::string& failure : certificate.failures) text += "  " + printable(failure) + '\n';
  return text;
}

std::string counts_text(const std::vector<Description::Count>& counts) {
  Grid grid;
  int sum = 0;
  for (const Description::Count& count : counts) {
    grid.row({count.name, std::to_string(count.count), count.kind});
    sum += count.count;
  }
  grid.row({"together", std::to_string(sum)});
  return grid.text("  ");
}

int total(const std::vector<Description::Count>& counts) {
  int sum = 0;
  for (const Description::Count& count : counts) sum += count.count;
  return sum;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + printable(word);
  return text.empty() ? "none" : text;
}

/// What all equilibria over the box of moments say of the plan: evidence to a resolution, no proof.
std::string scan_text(const Scene& scene, const Plan& plan) {
  if (!plan.scan || plan.status != PlanStatus::solved) return "";
  const PlanScan& scan = *plan.scan;
  const DisplayUnits units(scene);
  std::string steps;
  for (const double step : scan.steps) steps += (steps.empty() ? "" : ", ") + units.moment(step);
  const std::string to = steps.empty() ? "" : " in steps of " + steps;
  if (scan.complete())
    return fmt::format("\ncomplete to a resolution: {} equilibria{}, none leads to a better plan\n", scan.equilibria,
                       to);
  std::string text = fmt::format("\nnot complete: of {} equilibria{}", scan.equilibria, to);
  if (scan.unresolved > 0) text += fmt::format(" {} cost less and led to no plan;", scan.unresolved);
  if (scan.lost > 0) text += fmt::format(" {} could not be followed on;", scan.lost);
  if (!scan.whole) text += " not all were looked at;";
  text.back() = '\n';
  return text;
}

/// Plans that differ; nothing where there is only one.
std::string minima_text(const Scene& scene, const Plan& plan) {
  std::string scanned = scan_text(scene, plan);
  if (plan.minima.size() < 2) return scanned;
  Grid grid;
  for (const PlanMinimum& minimum : plan.minima) {
    std::string sides;
    for (std::size_t o = 0; o < minimum.sides.size() && o < scene.obstacles.size(); ++o) {
      if (minimum.sides[o].empty()) continue;
      sides +=
          fmt::format("{}'{}' {}", sides.empty() ? "" : ", ", printable(scene.obstacles[o].name), minimum.sides[o]);
    }
    grid.row({fmt::format("{:.6g}", minimum.objective), printable(minimum.mode), sides});
  }
  return fmt::format("\nbest of {} plans found: objective, contact, side of obstacles\n", plan.minima.size()) +
         grid.text("  ") + scanned;
}

}  // namespace

std::string plan_report(const Scene& scene, const Plan& plan, const RunInfo& run) {
  const DisplayUnits units(scene);
  std::string text = heading(scene) + '\n';
  // A plan that time cut short is certified all the same; that a better one may exist belongs beside its status.
  const bool cut = plan.search_cut && plan.status == PlanStatus::solved;
  text += line("status", std::string(to_string(plan.status)) +
                             (cut ? ", but time ended the search before it was done: a better plan may exist" : ""));
  if (!plan.message.empty()) text += line("", printable(plan.message));
  text += note_lines(plan.notes);
  // Without a shape there is nothing to tell of it.
  const bool has_shape = !plan.backbone.empty();
  if (has_shape) text += shape_text(scene, plan, units) + overlap_text(scene, plan, units);
  if (!run.uncertainties.empty()) text += uncertainty_text(scene, run.uncertainties.front());
  text += friction_text(scene, plan, units);
  text += verification_text(plan);
  text += line("coordinates", fmt::format("{}, order {}, {} values{}", plan.coordinates_name, plan.order,
                                          plan.coordinates.size(), plan.split_at_contact ? ", split at contact" : ""));
  const bool asked =
      std::any_of(plan.modes.begin(), plan.modes.end(), [](const ModeRecord& mode) { return mode.solves > 0; });
  text +=
      line("solver", asked ? fmt::format("{}: {} ({}), {} iterations, {} evaluations", plan.solver_name,
                                         to_string(plan.solver.status),
                                         plan.solver.native_status.empty() ? "-" : printable(plan.solver.native_status),
                                         plan.solver.iterations, plan.solver.evaluations.values)
                           : plan.solver_name + ": not called");
  if (has_shape)
    text += moments_text(scene, plan, units) + contacts_text(scene, plan, units) + grasp_text(scene, plan) +
            certificate_text(plan.certificate);
  if (!plan.modes.empty()) {
    Grid modes;
    for (const ModeRecord& mode : plan.modes) {
      modes.row({printable(mode.mode), printable(mode.outcome),
                 fmt::format("{} solves, {} polishes", mode.solves, mode.polishes)});
    }
    text += "\nways of being in contact\n" + modes.text("  ");
  }
  text += minima_text(scene, plan);
  text += left_out_text(plan.left_out);
  text += fmt::format("\ntime: read {}, open plugins {}, assemble {}, solve {}, certify {}\n",
                      seconds(run.seconds_read), seconds(run.seconds_open), seconds(plan.seconds_assemble),
                      seconds(plan.seconds_solve), seconds(plan.seconds_certify));
  return text;
}

std::string execution_report(const Scene& scene, const Execution& execution, const RunInfo& run) {
  const DisplayUnits units(scene);
  const Plan& plan = execution.result;
  std::string text = heading(scene) + '\n';
  text += line("status", std::string(to_string(plan.status)));
  if (!plan.message.empty()) text += line("", printable(plan.message));
  const bool has_shape = !plan.backbone.empty();
  if (has_shape) text += shape_text(scene, plan, units) + overlap_text(scene, plan, units);
  if (!run.uncertainties.empty()) text += uncertainty_text(scene, run.uncertainties.front());
  text += line("path", fmt::format("load fraction {:.9g} reached in {} steps, {} contacts made or released{}",
                                   execution.load, execution.steps, execution.contact_changes,
                                   execution.tendon_changes == 0
                                       ? ""
                                       : fmt::format(", {} tendons drawn taut or slack", execution.tendon_changes)));
  text += line("basis", fmt::format("{} pieces of {} functions", execution.pieces, plan.order));
  if (!execution.snaps.empty()) {
    Grid snaps;
    snaps.row({"snap", "load fraction", "moments", "tip before", "tip after", "stability after"});
    for (const Snap& snap : execution.snaps) {
      std::string moments;
      for (const double m : snap.moments) moments += (moments.empty() ? "" : ", ") + units.moment(m);
      const auto tip = [&](const std::vector<BackbonePoint>& shape) {
        return shape.empty() ? std::string("-") : units.point(shape.back().position());
      };
      snaps.row({std::string(to_string(snap.kind)), fmt::format("{:.9g}", snap.load), moments, tip(snap.before),
                 tip(snap.after), fmt::format("{:.3g}", snap.stability_after)});
    }
    text += '\n' + snaps.text("");
  }
  if (has_shape)
    text += moments_text(scene, plan, units) + contacts_text(scene, plan, units) + grasp_text(scene, plan) +
            certificate_text(plan.certificate);
  text += left_out_text(plan.left_out);
  text += fmt::format("\ntime: read {}, open plugins {}, execute {}, certify {}\n", seconds(run.seconds_read),
                      seconds(run.seconds_open), seconds(plan.seconds_solve), seconds(plan.seconds_certify));
  return text;
}

std::string description_report(const Scene& scene, const Description& description, const RunInfo& run) {
  const DisplayUnits units(scene);
  std::string text = heading(scene) + '\n';
  text += "variables\n" + counts_text(description.variables);
  text += "\nrows\n" + counts_text(description.rows);
  text += '\n' + line("terms", joined(description.terms)) + line("energies", joined(description.energies));
  text += line("units", fmt::format("lengths in {}, forces in {}", units.lengths(description.length_unit),
                                    force(description.force_unit)));
  Grid modes;
  for (const Description::Mode& mode : description.modes) {
    modes.row({printable(mode.name), fmt::format("{} variables, {} rows", total(mode.variables), total(mode.rows))});
  }
  if (!modes.empty()) text += "\nways of being in contact\n" + modes.text("  ");
  Grid plugins;
  for (const UsedComponent& component : run.components)
    plugins.row({component.kind, component.name, printable(component.file)});
  if (!plugins.empty()) text += "\nplugins opened\n" + plugins.text("  ");
  return text + left_out_text(description.left_out);
}

}  // namespace tendril::app
