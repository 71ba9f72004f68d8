#include "extremes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "scenes.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"
#include "workload.hpp"

namespace tendril::bench {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Long enough for every case by far: who reaches it hangs.
constexpr double time_limit = 5.0;
/// Hundreds of coordinates take longer.
constexpr double long_time_limit = 60.0;

/// A plan or an execution, or why there is none.
struct Result {
  Verdict verdict;
  Plan plan;
  double seconds = 0.0;
  int pieces = 0, snaps = 0;
};

Verdict verdict_of(const Plan& plan) {
  const bool extended =
      std::any_of(plan.contacts.begin(), plan.contacts.end(), [](const PlannedContact& c) { return c.extended; });
  return extended ? "extended" : std::string(to_string(plan.status));
}

Result planned(plugins::Registry& registry, const Scene& scene) {
  Result out;
  const double begin = now();
  try {
    out.plan = timed_plan(registry, scene).plan;
    out.verdict = verdict_of(out.plan);
  } catch (const Error& error) {
    out.verdict = "refused";
    out.plan.message = error.what();
  }
  out.seconds = now() - begin;
  return out;
}

Result carried_out(plugins::Registry& registry, const Scene& scene, const std::vector<double>& moments,
                   const std::vector<double>& before) {
  Result out;
  const double begin = now();
  try {
    const auto obstacles = plugins::make_obstacles(registry, scene);
    ExecuteControl control;
    control.time_limit = time_limit;
    Execution first;
    if (!before.empty()) {
      first = execute(scene, obstacles, before, control);
      control.start = &first.result;
    }
    Execution last = execute(scene, obstacles, moments, control);
    out.verdict = verdict_of(last.result);
    out.pieces = last.pieces;
    out.snaps = static_cast<int>(last.snaps.size());
    out.plan = std::move(last.result);
  } catch (const Error& error) {
    out.verdict = "refused";
    out.plan.message = error.what();
  }
  out.seconds = now() - begin;
  return out;
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
  if (c.spread) return "no single point contact: extended, several points that are each convex, or not solved";
  std::string text = c.verdict;
  if (c.known.tip) text += fmt::format(", tip ({:.6g}, {:.6g}) L", c.known.tip->x, c.known.tip->y);
  if (c.known.arc_length) text += fmt::format(", contact at {:.6g} L", *c.known.arc_length);
  if (c.known.force) text += fmt::format(", force {:.6g}", *c.known.force);
  if (!c.same_as.empty()) text += ", the same plan as the family's first";
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
    // Every model with every backend; refined models with the scene's own.
    for (const ExtremeModel& model : extent_.quick ? defaults_ : refined_) {
      for (const std::string& backend : backends_) {
        if (!model.option.empty() && backend != scene->solver.plugin) continue;
        if (extent_.stopped()) return;
        Scene own = with_model(*scene, model);
        if (own.solver.plugin != backend) own.solver.options.clear();
        own.solver.plugin = backend;
        row.model = model.name;
        row.backend = backend;
        judge(c, own, planned(registry_, own), row);
        rows_.push_back(row);
      }
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
        judge(c, scene, planned(registry_, scene), row);
        rows_.push_back(row);
      }
    }
  }

  std::vector<ExtremeRow> take() { return std::move(rows_); }

 private:
  void judge(const ExtremeCase& c, const Scene& scene, const Result& out, ExtremeRow& row) {
    const Plan& plan = out.plan;
    row.seconds = out.seconds;
    row.error = row.accuracy = none;
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
    if (c.spread) {
      const bool several = plan.contacts.size() > 1 && plan.certificate.contact_convexity > 0.0;
      const bool right = out.verdict == "solved" ? several : out.verdict != "extended" || plan.contacts.size() > 1;
      row.got += fmt::format(", least convexity {:.3g}", plan.certificate.contact_convexity);
      row.why = plan.message;
      row.outcome = right ? Outcome::met : Outcome::not_met;
      return;
    }
    if (out.verdict != c.verdict) {
      row.why = plan.message;
      return;
    }
    if (out.verdict == "extended") {
      row.outcome = plan.contacts.size() > 1 ? Outcome::met : Outcome::not_met;
      return;
    }
    // A defect of the local moment balance turns the rod by at most itself over margin and stiffness.
    const double defect = plan.certificate.moment_balance / (plan.certificate.stability * c.stiffness_least);
    row.accuracy = c.known.digits + (std::isfinite(defect) && defect > 0.0 ? defect : 0.0);
    std::vector<std::string> wrong;
    const auto compare = [&](const char* what, double error, double unit) {
      row.error = std::isnan(row.error) ? error / unit : std::max(row.error, error / unit);
      if (!(error <= row.accuracy * unit)) wrong.push_back(fmt::format("{} off by {:.1e}", what, error));
    };
    if (c.known.tip) compare("tip", norm(tip - *c.known.tip), 1.0);
    const double force = contact != nullptr ? contact->force / scale.force() : 0.0;
    // A force answers a defect by the stiffness of the rod between base and contact.
    if (c.known.force) compare("force", std::abs(force - *c.known.force), std::max(10.0, *c.known.force));
    if (c.known.arc_length) {
      if (contact == nullptr) {
        wrong.emplace_back("no contact");
      } else {
        compare("contact", std::abs(contact->arc_length / scale.length - *c.known.arc_length), 10.0);
      }
    }
    if (c.against_execution) against_execution(scene, plan, scale, compare, wrong);
    if (!c.same_as.empty()) {
      auto& first = families_[c.same_as + '\n' + row.model + '\n' + row.backend];
      if (first.empty()) first = plan.coordinates;
      double apart = first.size() == plan.coordinates.size() ? 0.0 : infinity;
      for (std::size_t i = 0; i < first.size() && i < plan.coordinates.size(); ++i) {
        apart = std::max(apart, std::abs(first[i] - plan.coordinates[i]));
      }
      row.got += fmt::format(", coordinates {:.0e} from the first", apart);
      // Not the model's accuracy: the same program has the same solution, to what the polish leaves.
      if (!(apart <= 1e-8)) wrong.push_back(fmt::format("coordinates {:.1e} from the family's first", apart));
    }
    if (c.overlaps) {
      if (plan.self_overlap) {
        row.got += fmt::format(", covers itself at {:.4g} and {:.4g} L", plan.self_overlap->first / scale.length,
                               plan.self_overlap->second / scale.length);
      } else {
        wrong.emplace_back("self-overlap not reported");
      }
    }
    for (const std::string& what : wrong) row.why += (row.why.empty() ? "" : "; ") + what;
    row.outcome = wrong.empty() ? Outcome::met : Outcome::not_met;
  }

  template <class Compare>
  void against_execution(const Scene& scene, const Plan& plan, const Scale& scale, Compare&& compare,
                         std::vector<std::string>& wrong) {
    const Result fine = carried_out(registry_, scene, plan.moments, {});
    if (fine.verdict != "solved") {
      wrong.push_back("carried out: " + fine.verdict + ", " + fine.plan.message);
      return;
    }
    compare("tip against the execution",
            std::hypot(plan.tip_x - fine.plan.tip_x, plan.tip_y - fine.plan.tip_y) / scale.length, 1.0);
    double sum = 0.0;
    double sum_fine = 0.0;
    for (const PlannedContact& p : plan.contacts) sum += p.force / scale.force();
    for (const PlannedContact& p : fine.plan.contacts) sum_fine += p.force / scale.force();
    compare("force against the execution", std::abs(sum - sum_fine), std::max(10.0, sum_fine));
  }

  plugins::Registry& registry_;
  const Extent& extent_;
  std::vector<ExtremeModel> defaults_, refined_;
  std::vector<std::string> backends_;
  std::vector<ExtremeRow> rows_;
  std::map<std::string, std::vector<double>> families_;
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
  for (const ExtremeCase& c : extreme_cases()) {
    if (extent.stopped()) break;
    if (extent.quick && !c.quick) continue;
    const double begin = now();
    rows.add(c);
    fmt::print(stderr, "{}: {}, {}: {:.2f} s\n", c.group, c.name, c.executed ? "carried out" : "planned",
               now() - begin);
  }
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
      "Every case with every coordinate model and every backend. Error: of what is known, in L; forces and places "
      "relative to 10. Accuracy: what the model can have here, from its own local moment balance and the digits of "
      "the source. Everything dimensionless",
      {"group", "case", "model", "backend", "expected", "source", "got", "error", "accuracy", "residuals", "time (ms)",
       "outcome", "why"},
      {}};
  std::map<Outcome, int> counts;
  double slowest = 0.0;
  for (const ExtremeRow& row : rows) {
    ++counts[row.outcome];
    slowest = std::max(slowest, row.seconds);
    table.rows.push_back({row.group, row.name, row.model, row.backend, row.expected, row.source, row.got, row.error,
                          row.accuracy, row.residuals, 1e3 * row.seconds, to_string(row.outcome), row.why});
  }
  section.prose.push_back(fmt::format(
      "{} rows: {} met, {} explained by a limit of double precision that was measured, {} not met. The slowest took "
      "{:.2g} s. Every row compares with a known answer or a known verdict.",
      rows.size(), counts[Outcome::met], counts[Outcome::explained], counts[Outcome::not_met], slowest));
  section.prose.emplace_back(
      "A plan is held to the accuracy that its model can have: the defect of the local moment balance over the "
      "stability margin, measured by the certificate, bounds how far its shape can be from the exact one. Executions "
      "use the fine basis, whose order and pieces adapt to the shape; the row says which it took.");
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
