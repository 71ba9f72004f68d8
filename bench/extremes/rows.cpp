#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "extremes/extremes.hpp"
#include "extremes/judge.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

/// The rows of cases, with every model and every backend.
class CaseRows {
 public:
  CaseRows(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out)
      : registry_(registry),
        extent_(extent),
        judge_(registry, extent),
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
      const CaseRun out = carried_out(registry_, *scene, c.moments, c.before);
      row.model =
          out.pieces > 0 ? fmt::format("fine basis, order {}, {} pieces", out.plan.order, out.pieces) : "fine basis";
      judge_.judge(c, *scene, out, row);
      rows_.push_back(row);
      return;
    }
    scene->solver.time_limit = case_time_limit;
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
        judge_.judge(c, own, c.targets.empty() ? planned(registry_, own) : led(registry_, own, c.targets), row, &model);
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
        scene.solver.time_limit = refined_time_limit;
        ExtremeRow row{c.group, known.name, model.name, scene.solver.plugin, expected_of(c), c.source, "", "",
                       none,    none,       0.0,        Outcome::not_met};
        judge_.judge(c, scene, planned(registry_, scene), row, &model);
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
    for (int level = 0; level < refinement_levels; ++level) {
      const std::optional<Scene> finer = refined(registry_, scene, model, level);
      if (!finer || extent_.stopped()) continue;
      ExtremeRow row;
      judge_.judge(c, *finer, planned(registry_, *finer), row, nullptr);
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

  plugins::Registry& registry_;
  const Extent& extent_;
  ExtremeJudge judge_;
  std::vector<ExtremeModel> defaults_, refined_;
  std::vector<std::string> backends_;
  std::vector<ExtremeRow> rows_;
};

}  // namespace

std::vector<ExtremeRow> extreme_rows(plugins::Registry& registry, const Extent& extent,
                                     std::vector<LeftOut>& left_out) {
  CaseRows rows(registry, extent, left_out);
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

}  // namespace tendril::bench
