#include "extremes/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tendril/tolerances.hpp"

namespace tendril::bench {

/// What is wrong with a row, collected.
struct Findings {
  std::vector<std::string> wrong;
  /// `error` of what the source or a second computation says of `what`.
  void compare(const char* what, double error, double allowed) {
    if (!(error <= allowed)) wrong.push_back(fmt::format("{} off by {:.1e}, {:.1e} is allowed", what, error, allowed));
  }
};

namespace {

/// (L) Where a run of check points begins: their distance.
constexpr double check_point_distance = 2.0 / 160.0;
/// Force on a stretch, relative: what check points make of a distributed force.
constexpr double stretch_force = 1e-2;
/// What the boundary-value problem itself leaves, beside the digits of a source.
constexpr double exact_digits = 1e-11;

int pressing(const Plan& plan, const Scale& scale) {
  return static_cast<int>(std::count_if(plan.contacts.begin(), plan.contacts.end(), [&](const PlannedContact& c) {
    return c.force > tolerance::force * scale.force();
  }));
}

/// The contact that presses hardest.
const PlannedContact* strongest(const Plan& plan) {
  const PlannedContact* best = nullptr;
  for (const PlannedContact& c : plan.contacts) {
    if (best == nullptr || c.force > best->force) best = &c;
  }
  return best;
}

std::string residuals_of(const Certificate& c) {
  if (!std::isfinite(c.equilibrium)) return "";
  return fmt::format("equilibrium {:.0e}, depth {:.0e}, min(g, f) {:.0e}, stationarity {:.0e}, margin {:.3g}",
                     c.equilibrium, c.penetration, c.complementarity, c.stationarity, c.stability);
}

/// A rod that lies along an obstacle: never solved, with the reason; where and how heavily it lies.
void judge_extended(const ExtremeCase& c, const Plan& plan, const Scale& scale, ExtremeRow& row, Findings& found) {
  row.outcome = Outcome::met;
  if (plan.message.find("contact spreads") == std::string::npos) found.wrong.push_back(plan.message);
  if (!c.stretch) return;
  double begin = infinity;
  double sum = 0.0;
  for (const PlannedContact& p : plan.contacts) {
    sum += p.force / scale.force();
    if (p.extended) begin = std::min(begin, p.arc_length / scale.length);
  }
  row.got += fmt::format(", from {:.4g} L on, force {:.6g}", begin, sum);
  row.error = std::abs(begin - c.stretch->begin);
  row.allowed = check_point_distance;
  found.compare("begin of the stretch", row.error, row.allowed);
  found.compare("force on the stretch, relative,", std::abs(sum / c.stretch->force - 1.0), stretch_force);
}

/// Whether the state is the one that the source knows of, and the source is right.
void against_source(const ExtremeCase& c, const ExactState& exact, Findings& found) {
  const double allowed = c.known.digits + exact_digits;
  if (c.known.tip) found.compare("exact tip against the source", norm(exact.tip - *c.known.tip), allowed);
  const auto strongest = std::max_element(exact.forces.begin(), exact.forces.end());
  const double force = strongest == exact.forces.end() ? 0.0 : *strongest;
  if (c.known.force) {
    found.compare("exact force against the source", std::abs(force - *c.known.force),
                  allowed * std::max(1.0, *c.known.force));
  }
  if (c.known.arc_length) {
    const double place = strongest == exact.forces.end()
                             ? none
                             : exact.arc_lengths[static_cast<std::size_t>(strongest - exact.forces.begin())];
    found.compare("exact place against the source", std::abs(place - *c.known.arc_length), allowed);
  }
}

}  // namespace

std::string expected_of(const ExtremeCase& c) {
  std::string text = c.verdict;
  if (c.known.tip) text += fmt::format(", tip ({:.6g}, {:.6g}) L", c.known.tip->x, c.known.tip->y);
  if (c.known.arc_length) text += fmt::format(", contact at {:.6g} L", *c.known.arc_length);
  if (c.known.force) text += fmt::format(", force {:.6g}", *c.known.force);
  if (!c.same_as.empty()) text += ", the same plan as the family's first";
  if (c.contacts) {
    text += fmt::format(", {}{} contact(s) that press",
                        c.contacts_before ? fmt::format("{}, then ", *c.contacts_before) : "", *c.contacts);
  }
  if (c.stretch) text += fmt::format(", from {:.4g} L on, force {:.4g}", c.stretch->begin, c.stretch->force);
  if (c.against_execution) text += ", tip and contacts as carried out";
  if (c.overlaps) text += ", self-overlap reported";
  return text;
}

void ExtremeJudge::judge(const ExtremeCase& c, const Scene& scene, const CaseRun& out, ExtremeRow& row,
                         const ExtremeModel* model) {
  const Plan& plan = out.plan;
  row.seconds = out.seconds;
  row.error = row.allowed = none;
  row.why.clear();
  row.outcome = Outcome::not_met;
  row.residuals = residuals_of(plan.certificate);
  row.got = out.verdict;
  if (out.verdict == "refused") {
    row.why = plan.message;
    if (c.verdict == "refused") row.outcome = Outcome::met;
    return;
  }
  const Scale scale = scale_of(scene);
  const Vec2 tip{plan.tip_x / scale.length, plan.tip_y / scale.length};
  const PlannedContact* contact = strongest(plan);
  row.got += fmt::format(", tip ({:.6g}, {:.6g}) L", tip.x, tip.y);
  if (contact != nullptr) {
    row.got += fmt::format(", {} contact(s), the strongest at {:.6g} L with force {:.6g}", plan.contacts.size(),
                           contact->arc_length / scale.length, contact->force / scale.force());
  }
  if (out.snaps > 0) row.got += fmt::format(", {} snap(s) on the way", out.snaps);
  if (out.verdict != c.verdict) {
    row.why = plan.message;
    return;
  }
  Findings found;
  if (out.verdict == "extended") {
    judge_extended(c, plan, scale, row, found);
  } else {
    judge_solved(c, scene, out, row, found, model);
  }
  if (c.contacts && pressing(plan, scale) != *c.contacts) {
    found.wrong.push_back(fmt::format("{} contact(s) press", pressing(plan, scale)));
  }
  if (c.contacts_before && (out.earlier.empty() || pressing(out.earlier.front(), scale) != *c.contacts_before)) {
    found.wrong.push_back(
        fmt::format("{} contact(s) press before", out.earlier.empty() ? -1 : pressing(out.earlier.front(), scale)));
  }
  for (const std::string& what : found.wrong) row.why += (row.why.empty() ? "" : "; ") + what;
  if (!found.wrong.empty()) row.outcome = Outcome::not_met;
}

void ExtremeJudge::judge_solved(const ExtremeCase& c, const Scene& scene, const CaseRun& out, ExtremeRow& row,
                                Findings& found, const ExtremeModel* model) {
  const Plan& plan = out.plan;
  const Scale scale = scale_of(scene);
  ExactState exact = exact_of(registry_, scene, plan);
  row.allowed = resolved_error;
  if (exact.found) {
    row.error = distance(scene, plan, exact);
    for (const Plan& earlier : out.earlier) {
      if (earlier.status != PlanStatus::solved) found.wrong.push_back("on the way: " + earlier.message);
      const ExactState on_the_way = exact_of(registry_, scene, earlier);
      if (!on_the_way.found) found.wrong.push_back("on the way: no exact state, " + on_the_way.why);
      if (on_the_way.found) row.error = std::max(row.error, distance(scene, earlier, on_the_way));
    }
    against_source(c, exact, found);
    weigh_error(c, scene, plan, row, model);
  } else {
    found.wrong.push_back("no exact state: " + exact.why);
  }
  if (c.against_execution) against_execution(scene, plan, exact, scale, found);
  if (!c.same_as.empty()) compare_family(c, plan, row, found);
  if (c.overlaps) {
    if (plan.self_overlap) {
      row.got += fmt::format(", covers itself at {:.4g} and {:.4g} L", plan.self_overlap->first / scale.length,
                             plan.self_overlap->second / scale.length);
    } else {
      found.wrong.emplace_back("self-overlap not reported");
    }
  }
}

void ExtremeJudge::compare_family(const ExtremeCase& c, const Plan& plan, ExtremeRow& row, Findings& found) {
  auto& first = families_[c.same_as + '\n' + row.model + '\n' + row.backend];
  if (first.empty()) first = plan.coordinates;
  double apart = first.size() == plan.coordinates.size() ? 0.0 : infinity;
  for (std::size_t i = 0; i < first.size() && i < plan.coordinates.size(); ++i) {
    apart = std::max(apart, std::abs(first[i] - plan.coordinates[i]));
  }
  row.got += fmt::format(", coordinates {:.0e} from the first", apart);
  // Not the model's accuracy: the same program has the same solution, to what the polish leaves.
  found.compare("coordinates from the family's first", apart, 1e-8);
}

/// Met: resolved, or the coarse model's own error and falling as it has to; explained: the same, but so large that
/// the model says little here.
void ExtremeJudge::weigh_error(const ExtremeCase& c, const Scene& scene, const Plan& plan, ExtremeRow& row,
                               const ExtremeModel* model) {
  if (row.error <= resolved_error) {
    row.outcome = Outcome::met;
    return;
  }
  if (model == nullptr || !c.targets.empty()) {
    row.why = fmt::format("error {:.1e} of a basis that adapts itself", row.error);
    if (model != nullptr) {
      // Along a trajectory the error of a coarse model is judged by its size alone.
      row.outcome = row.error <= tolerance::model_error ? Outcome::met : Outcome::not_met;
      row.why = fmt::format("model's own error {:.1e}, below {:.0e}", row.error, tolerance::model_error);
    }
    return;
  }
  const Decay& decay = decays_.of(c.group + '\n' + c.name, scene, plan, row.error, *model);
  row.why = decay.text;
  if (!decay.as_expected) return;
  row.outcome = row.error <= tolerance::model_error ? Outcome::met : Outcome::explained;
  if (row.outcome == Outcome::explained) row.why = "limit of the model, " + row.why;
}

void ExtremeJudge::against_execution(const Scene& scene, const Plan& plan, const ExactState& exact, const Scale& scale,
                                     Findings& found) {
  const CaseRun fine = carried_out(registry_, scene, plan.moments, {});
  if (fine.verdict != "solved") {
    found.wrong.push_back("carried out: " + fine.verdict + ", " + fine.plan.message);
    return;
  }
  if (!exact.found) return;
  found.compare("exact tip against the execution",
                norm(1.0 / scale.length * Vec2{fine.plan.tip_x, fine.plan.tip_y} - exact.tip), resolved_error);
  double sum = 0.0;
  double sum_fine = 0.0;
  for (const double f : exact.forces) sum += f;
  for (const PlannedContact& p : fine.plan.contacts) sum_fine += p.force / scale.force();
  found.compare("exact force against the execution", std::abs(sum - sum_fine),
                resolved_error * std::max(1.0, sum_fine));
}

}  // namespace tendril::bench
