#include "extremes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "exact_state.hpp"
#include "scenes.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/rod.hpp"
#include "tendril/tolerances.hpp"
#include "tendril/trajectory.hpp"
#include "workload.hpp"

namespace tendril::bench {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Long enough for every case by far, also on a busy machine: who reaches it hangs.
constexpr double time_limit = 20.0;
/// Hundreds of coordinates take longer.
constexpr double long_time_limit = 60.0;
/// (L, and relative for forces above 1) A model whose error stays below this resolves its shape; what the fine basis
/// promises of executions. Ten times what a penetration of tolerance::penetration moves.
constexpr double resolved = 1e-8;
/// A coarser model is to gain at least this much of its error for every part that it is refined by: half the error for
/// twice the coordinates. Piecewise constant curvature gains a quarter where it resolves the shape, all others more.
constexpr double least_order = 1.0;
/// Values of a counted option, or parts of the rod's segments, that a coarse model is refined by.
constexpr int refinements[] = {12, 24, 48};
constexpr int parts[] = {3, 5, 9};
constexpr int most_refinements = 2;
/// (L) Where a run of check points begins: their distance.
constexpr double check_point_distance = 2.0 / 160.0;
/// Force on a stretch, relative: what check points make of a distributed force.
constexpr double stretch_force = 1e-2;
/// What the boundary-value problem itself leaves, beside the digits of a source.
constexpr double exact_digits = 1e-11;

/// A plan or an execution, or why there is none.
struct Result {
  Verdict verdict;
  Plan plan;
  double seconds = 0.0;
  int pieces = 0, snaps = 0;
  std::vector<Plan> earlier{};  ///< what an execution started from, or the steps of a trajectory but the last
};

Verdict verdict_of(const Plan& plan) {
  const bool extended =
      std::any_of(plan.contacts.begin(), plan.contacts.end(), [](const PlannedContact& c) { return c.extended; });
  return extended && plan.status != PlanStatus::solved ? "extended" : std::string(to_string(plan.status));
}

template <class Work>
Result timed(Work&& work) {
  Result out;
  const double begin = now();
  try {
    work(out);
    out.verdict = verdict_of(out.plan);
  } catch (const Error& error) {
    out.verdict = "refused";
    out.plan.message = error.what();
  }
  out.seconds = now() - begin;
  return out;
}

Result planned(plugins::Registry& registry, const Scene& scene) {
  return timed([&](Result& out) { out.plan = timed_plan(registry, scene).plan; });
}

/// The tip led along `targets`, each plan from the one before.
Result led(plugins::Registry& registry, const Scene& scene, const std::vector<Vec2>& targets) {
  return timed([&](Result& out) {
    Problem problem(scene, plugins::make_components(registry, scene));
    std::vector<TargetSpec> all;
    all.reserve(targets.size());
    for (const Vec2 at : targets) all.push_back({scene.rod.length() * at, std::nullopt});
    Trajectory trajectory = plan_trajectory(all, {}, [&](const TargetSpec& target, const Plan* start, bool follow) {
      problem.set_target(target);
      PlanControl control;
      control.start = start;
      control.follow = follow;
      return problem.plan(control);
    });
    out.earlier.reserve(trajectory.steps.size());
    for (TrajectoryStep& step : trajectory.steps) out.earlier.push_back(std::move(step.plan));
    out.plan = std::move(out.earlier.back());
    out.earlier.pop_back();
  });
}

Result carried_out(plugins::Registry& registry, const Scene& scene, const std::vector<double>& moments,
                   const std::vector<double>& before) {
  return timed([&](Result& out) {
    const auto obstacles = plugins::make_obstacles(registry, scene);
    ExecuteControl control;
    control.time_limit = time_limit;
    if (!before.empty()) {
      out.earlier.push_back(execute(scene, obstacles, before, control).result);
      control.start = &out.earlier.front();
    }
    Execution last = execute(scene, obstacles, moments, control);
    out.pieces = last.pieces;
    out.snaps = static_cast<int>(last.snaps.size());
    out.plan = std::move(last.result);
  });
}

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

class Rows {
 public:
  Rows(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out)
      : registry_(registry),
        extent_(extent),
        defaults_(extreme_models(registry, false, left_out)),
        refined_(extreme_models(registry, true, left_out)),
        backends_(registry.names(ComponentKind::solver)) {}

  void add(const ExtremeCase& c) {
    std::optional<Scene> scene;
    ExtremeRow row{c.group, c.name, "-", "-", expected_of(c), c.source, "", "", none, none, 0.0, Outcome::not_met};
    try {
      scene = scene_from_text(c.text, c.name, registry_);
    } catch (const Error& error) {
      row.got = "refused";
      row.outcome = c.verdict == "refused" ? Outcome::met : Outcome::not_met;
      row.why = error.what();
      rows_.push_back(row);
      return;
    }
    if (c.executed) {
      const Result out = carried_out(registry_, *scene, c.moments, c.before);
      row.model =
          out.pieces > 0 ? fmt::format("fine basis, order {}, {} pieces", out.plan.order, out.pieces) : "fine basis";
      judge(c, *scene, out, row);
      rows_.push_back(row);
      return;
    }
    scene->solver.time_limit = time_limit;
    scene->coordinates.split_at_contact = c.split;
    // Every model with every backend; refined models with the scene's own.
    for (const ExtremeModel& model : extent_.quick ? defaults_ : refined_) {
      const std::size_t first = rows_.size();
      for (const std::string& backend : backends_) {
        if (!model.option.empty() && backend != scene->solver.plugin) continue;
        if (extent_.stopped()) return;
        Scene own = with_model(*scene, model);
        if (own.solver.plugin != backend) own.solver.options.clear();
        own.solver.plugin = backend;
        row.model = model.name;
        row.backend = backend;
        judge(c, own, c.targets.empty() ? planned(registry_, own) : led(registry_, own, c.targets), row, &model);
        rows_.push_back(row);
      }
      explain_verdicts(c, with_model(*scene, model), model, first);
    }
  }

  /// Known tips with every order and number of pieces.
  void add_orders(const std::vector<int>& values) {
    for (const KnownScene& known : known_scenes(registry_)) {
      ExtremeCase c;
      c.group = "orders";
      c.source = "exact table";
      const Scale scale = scale_of(known.scene);
      c.known.tip = (1.0 / scale.length) * known.tip;
      if (known.arc_length) c.known.arc_length = *known.arc_length / scale.length;
      if (known.force) c.known.force = *known.force / scale.force();
      c.known.digits = 1e-9;
      for (const ExtremeModel& model : counted_models(registry_, values)) {
        if (extent_.stopped()) return;
        Scene scene = with_model(known.scene, model);
        scene.solver.time_limit = long_time_limit;
        ExtremeRow row{c.group, known.name, model.name, scene.solver.plugin, expected_of(c), c.source, "", "",
                       none,    none,       0.0,        Outcome::not_met};
        judge(c, scene, planned(registry_, scene), row, &model);
        rows_.push_back(row);
      }
    }
  }

  std::vector<ExtremeRow> take() { return std::move(rows_); }

 private:
  /// Where no backend comes to the verdict with this model, but the same model refined does, the verdict is the
  /// model's limit. Where one backend does, the others have missed it.
  void explain_verdicts(const ExtremeCase& c, const Scene& scene, const ExtremeModel& model, std::size_t first) {
    const auto misses = [&](const ExtremeRow& row) {
      return row.outcome == Outcome::not_met && row.got.rfind(c.verdict, 0) != 0;
    };
    const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first);
    if (begin == rows_.end() || c.verdict == "refused" || !std::all_of(begin, rows_.end(), misses)) return;
    for (std::size_t level = 0; level < std::size(refinements); ++level) {
      const std::optional<Scene> finer = refined(scene, model, static_cast<int>(level));
      if (!finer || extent_.stopped()) continue;
      ExtremeRow row;
      judge(c, *finer, planned(registry_, *finer), row, nullptr);
      if (row.got.rfind(c.verdict, 0) != 0) continue;
      const double error = std::isnan(row.error) ? 0.0 : row.error;
      if (error > tolerance::model_error) continue;
      for (auto missed = begin; missed != rows_.end(); ++missed) {
        missed->outcome = Outcome::explained;
        missed->why = fmt::format("limit of the model, with {} coordinates: {}; as it is: {}",
                                  coordinate_count(registry_, *finer), row.got, missed->why);
      }
      return;
    }
  }

  /// What is wrong with a row, collected.
  struct Findings {
    std::vector<std::string> wrong;
    /// `error` of what the source or a second computation says of `what`.
    void compare(const char* what, double error, double allowed) {
      if (!(error <= allowed))
        wrong.push_back(fmt::format("{} off by {:.1e}, {:.1e} is allowed", what, error, allowed));
    }
  };

  /// `model`: null for an execution.
  void judge(const ExtremeCase& c, const Scene& scene, const Result& out, ExtremeRow& row,
             const ExtremeModel* model = nullptr) {
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

  /// A rod that lies along an obstacle: never solved, with the reason; where and how heavily it lies.
  static void judge_extended(const ExtremeCase& c, const Plan& plan, const Scale& scale, ExtremeRow& row,
                             Findings& found) {
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

  void judge_solved(const ExtremeCase& c, const Scene& scene, const Result& out, ExtremeRow& row, Findings& found,
                    const ExtremeModel* model) {
    const Plan& plan = out.plan;
    const Scale scale = scale_of(scene);
    ExactState exact = exact_of(scene, plan);
    row.allowed = resolved;
    if (exact.found) {
      row.error = distance(scene, plan, exact);
      for (const Plan& earlier : out.earlier) {
        if (earlier.status != PlanStatus::solved) found.wrong.push_back("on the way: " + earlier.message);
        const ExactState on_the_way = exact_of(scene, earlier);
        if (!on_the_way.found) found.wrong.push_back("on the way: no exact state, " + on_the_way.why);
        if (on_the_way.found) row.error = std::max(row.error, distance(scene, earlier, on_the_way));
      }
      against_source(c, exact, scale, found);
      weigh_error(c, scene, plan, row, model);
    } else {
      found.wrong.push_back("no exact state: " + exact.why);
    }
    if (c.against_execution) against_execution(scene, plan, exact, scale, found);
    if (!c.same_as.empty()) {
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
    if (c.overlaps) {
      if (plan.self_overlap) {
        row.got += fmt::format(", covers itself at {:.4g} and {:.4g} L", plan.self_overlap->first / scale.length,
                               plan.self_overlap->second / scale.length);
      } else {
        found.wrong.emplace_back("self-overlap not reported");
      }
    }
  }

  /// The exact state from the plan's own shape, or else from what the fine basis makes of it.
  ExactState exact_of(const Scene& scene, const Plan& plan) {
    const auto obstacles = plugins::make_obstacles(registry_, scene);
    ExactState exact = exact_state(scene, obstacles, plan, plan);
    if (exact.found) return exact;
    ExecuteControl control;
    control.time_limit = time_limit;
    control.start = &plan;
    control.with_obstacles = needs_obstacles(scene);
    const Plan settled = execute(scene, obstacles, plan.moments, control).result;
    if (settled.status != PlanStatus::solved) return exact;
    return exact_state(scene, obstacles, plan, settled);
  }

  /// Whether the state is the one that the source knows of, and the source is right.
  static void against_source(const ExtremeCase& c, const ExactState& exact, const Scale&, Findings& found) {
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

  /// Met: resolved, or the coarse model's own error and falling as it has to; explained: the same, but so large that
  /// the model says little here.
  void weigh_error(const ExtremeCase& c, const Scene& scene, const Plan& plan, ExtremeRow& row,
                   const ExtremeModel* model) {
    if (row.error <= resolved) {
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
    const Decay& decay = decay_of(c, scene, plan, row.error, *model);
    row.why = decay.text;
    if (!decay.as_expected) return;
    row.outcome = row.error <= tolerance::model_error ? Outcome::met : Outcome::explained;
    if (row.outcome == Outcome::explained) row.why = "limit of the model, " + row.why;
  }

  /// How the error of a coarse model falls while it is refined.
  struct Decay {
    bool as_expected = false;
    std::string text{};
  };

  const Decay& decay_of(const ExtremeCase& c, const Scene& scene, const Plan& plan, double error,
                        const ExtremeModel& model) {
    const std::string key = c.group + '\n' + c.name + '\n' + model.name;
    const auto known = decays_.find(key);
    if (known != decays_.end()) return known->second;
    Decay decay;
    decay.text = fmt::format("model's own error {:.1e} with {} coordinates", error, plan.coordinates.size());
    int done = 0;
    for (std::size_t level = 0; level < std::size(refinements) && done < most_refinements; ++level) {
      const std::optional<Scene> finer = refined(scene, model, static_cast<int>(level));
      if (!finer) continue;
      if (extent_.stopped()) break;
      const Result out = planned(registry_, *finer);
      if (out.verdict != "solved") continue;
      const ExactState exact = exact_of(*finer, out.plan);
      if (!exact.found) continue;
      ++done;
      const double left = distance(*finer, out.plan, exact);
      const double ratio =
          static_cast<double>(out.plan.coordinates.size()) / static_cast<double>(plan.coordinates.size());
      decay.text += fmt::format(", {:.1e} with {}", left, out.plan.coordinates.size());
      decay.as_expected = left <= resolved || left <= error * std::pow(ratio, -least_order);
      if (left <= resolved) break;
    }
    // The finest of all, and a contact inside a piece, whose error depends on where in the piece it happens to lie:
    // what half as many left.
    if (!decay.as_expected && model.value > 1) {
      ExtremeModel half = model;
      half.value = model.value / 2;
      const Scene coarser = with_model(scene, half);
      const Result out = planned(registry_, coarser);
      const ExactState exact = out.verdict == "solved" ? exact_of(coarser, out.plan) : ExactState{};
      if (exact.found) {
        const double left = distance(coarser, out.plan, exact);
        const double ratio =
            static_cast<double>(plan.coordinates.size()) / static_cast<double>(out.plan.coordinates.size());
        decay.text += fmt::format(", {:.1e} with {}", left, out.plan.coordinates.size());
        decay.as_expected = error <= left * std::pow(ratio, -least_order);
      }
    }
    return decays_.emplace(key, std::move(decay)).first->second;
  }

  /// The scene with a finer model: a larger value of what the plugin counts, or, where it counts nothing, with segments
  /// cut into parts, and every piece with them. None: it is finer already.
  std::optional<Scene> refined(const Scene& scene, const ExtremeModel& model, int level) {
    std::string option = model.option;
    for (const ExtremeModel& counted : counted_models(registry_, {refinements[level]})) {
      if (counted.plugin == model.plugin && option.empty()) option = counted.option;
    }
    Scene finer = scene;
    finer.solver.time_limit = long_time_limit;
    if (finer.solver.plugin != registry_default(scene)) {
      finer.solver.plugin = registry_default(scene);
      finer.solver.options.clear();
    }
    if (!option.empty()) {
      const int value = refinements[level];
      if (value <= model.value) return std::nullopt;
      return with_model(finer, {model.name, model.plugin, option, value});
    }
    // Every stretch between two fixed knots, so that pieces beside an actuator's end are cut, too.
    const std::vector<double> knots = make_rod(scene, scale_of(scene)).fixed_knots();
    std::vector<SegmentSpec> cut;
    std::size_t segment = 0;
    double end = scene.rod.segments[0].length;
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
      const double middle = 0.5 * (knots[k] + knots[k + 1]) * scene.rod.length();
      while (middle > end && segment + 1 < scene.rod.segments.size()) end += scene.rod.segments[++segment].length;
      for (int i = 0; i < parts[level]; ++i) {
        cut.push_back(scene.rod.segments[segment]);
        cut.back().length = (knots[k + 1] - knots[k]) * scene.rod.length() / parts[level];
      }
    }
    finer.rod.segments = std::move(cut);
    return finer;
  }

  /// The backend that every model is refined with: errors of models are not those of solvers.
  std::string registry_default(const Scene& scene) const {
    const std::string wanted = SolverSpec{}.plugin;
    return std::find(backends_.begin(), backends_.end(), wanted) != backends_.end() ? wanted : scene.solver.plugin;
  }

  void against_execution(const Scene& scene, const Plan& plan, const ExactState& exact, const Scale& scale,
                         Findings& found) {
    const Result fine = carried_out(registry_, scene, plan.moments, {});
    if (fine.verdict != "solved") {
      found.wrong.push_back("carried out: " + fine.verdict + ", " + fine.plan.message);
      return;
    }
    if (!exact.found) return;
    found.compare("exact tip against the execution",
                  norm(1.0 / scale.length * Vec2{fine.plan.tip_x, fine.plan.tip_y} - exact.tip), resolved);
    double sum = 0.0;
    double sum_fine = 0.0;
    for (const double f : exact.forces) sum += f;
    for (const PlannedContact& p : fine.plan.contacts) sum_fine += p.force / scale.force();
    found.compare("exact force against the execution", std::abs(sum - sum_fine), resolved * std::max(1.0, sum_fine));
  }

  plugins::Registry& registry_;
  const Extent& extent_;
  std::vector<ExtremeModel> defaults_, refined_;
  std::vector<std::string> backends_;
  std::vector<ExtremeRow> rows_;
  std::map<std::string, std::vector<double>> families_;
  std::map<std::string, Decay> decays_;
};

}  // namespace

std::string to_string(Outcome outcome) {
  return outcome == Outcome::met ? "met" : outcome == Outcome::explained ? "explained" : "not met";
}

std::vector<ExtremeModel> extreme_models(plugins::Registry& registry, bool refined, std::vector<LeftOut>& left_out) {
  std::vector<ExtremeModel> models;
  for (const std::string& plugin : registry.names(ComponentKind::coordinates)) {
    try {
      (void)registry.coordinates(plugin);
    } catch (const plugins::PluginError& error) {
      if (!refined) left_out.push_back({"coordinates '" + plugin + "'", error.what()});
      continue;
    }
    models.push_back({plugin, plugin, "", 0});
    if (!refined) continue;
    for (ExtremeModel& model : counted_models(registry, {12})) {
      if (model.plugin == plugin) models.push_back(std::move(model));
    }
  }
  return models;
}

std::vector<ExtremeModel> counted_models(plugins::Registry& registry, const std::vector<int>& values) {
  std::vector<ExtremeModel> models;
  std::vector<LeftOut> ignored;
  for (const ModelSweep& sweep : model_sweeps(registry, values, ignored)) {
    if (!sweep.split || sweep.option.empty()) continue;
    for (const int value : sweep.values) {
      models.push_back(
          {fmt::format("{}, {} = {}", sweep.plugin, sweep.option, value), sweep.plugin, sweep.option, value});
    }
  }
  return models;
}

Scene with_model(Scene scene, const ExtremeModel& model) {
  scene.coordinates.plugin = model.plugin;
  scene.coordinates.options.clear();
  if (!model.option.empty()) scene.coordinates.options[model.option] = RawValue{std::int64_t{model.value}};
  return scene;
}

std::vector<ExtremeRow> extreme_rows(plugins::Registry& registry, const Extent& extent,
                                     std::vector<LeftOut>& left_out) {
  Rows rows(registry, extent, left_out);
  for (const ExtremeCase& c : extreme_cases(extent.held_out)) {
    if (extent.stopped()) break;
    if (extent.quick && !c.quick) continue;
    if ((c.group + ", " + c.name).find(extent.only) == std::string::npos) continue;
    const double begin = now();
    rows.add(c);
    fmt::print(stderr, "{}: {}, {}: {:.2f} s\n", c.group, c.name, c.executed ? "carried out" : "planned",
               now() - begin);
  }
  if (!extent.only.empty()) return rows.take();
  rows.add_orders(extent.quick ? std::vector<int>{1, 8} : std::vector<int>{1, 2, 4, 8, 16, 32, 64});
  std::vector<ExtremeRow> all = rows.take();
  for (const auto& part : {instability_rows, conditioning_rows}) {
    if (extent.stopped()) break;
    for (ExtremeRow& row : part(registry, extent)) all.push_back(std::move(row));
  }
  return all;
}

Section extremes_section(plugins::Registry& registry, const Extent& extent) {
  Section section;
  section.name = "extremes";
  section.title = "Stiff and extreme cases";
  const std::vector<ExtremeRow> rows = extreme_rows(registry, extent, section.left_out);
  Table table{
      "extremes",
      "Every case with every coordinate model and every backend. Error: of the model, against the exact state under "
      "the "
      "same moments with the same contacts: tip and places in L, forces relative to the larger of 1 and their size. "
      "Everything dimensionless",
      {"group", "case", "model", "backend", "expected", "source", "got", "error", "allowed", "residuals", "time (ms)",
       "outcome", "why"},
      {}};
  std::map<Outcome, int> counts;
  double slowest = 0.0;
  for (const ExtremeRow& row : rows) {
    ++counts[row.outcome];
    slowest = std::max(slowest, row.seconds);
    table.rows.push_back({row.group, row.name, row.model, row.backend, row.expected, row.source, row.got, row.error,
                          row.allowed, row.residuals, 1e3 * row.seconds, to_string(row.outcome), row.why});
  }
  section.prose.push_back(fmt::format(
      "{} rows: {} met, {} explained by a measured limit of the model, {} not met. The slowest took {:.2g} s.",
      rows.size(), counts[Outcome::met], counts[Outcome::explained], counts[Outcome::not_met], slowest));
  section.prose.push_back(fmt::format(
      "Everything solved is compared with the exact rod: a boundary-value problem in the strong form of the equations, "
      "under the moments that were found, with those contacts closed that press. A source that knows the answer "
      "beforehand is held against that state. A model is done with an error of {:.0e}. Where its error is larger, it "
      "is "
      "planned with more coordinates, too: the row is met if the error falls at least in proportion to them and is at "
      "most {:.0e}, the bound for coarse models that verification has; beyond that bound it is explained: the model "
      "has "
      "too few coordinates for the shape, and the row shows how many do.",
      resolved, tolerance::model_error));
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
