#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/accuracy.hpp"

namespace tendril::bench {

namespace {

constexpr double one_millisecond = 1e-3;

std::string model_name(const Accuracy& accuracy, std::size_t sweep, int value) {
  const ModelSweep& s = accuracy.sweeps[sweep];
  return s.plugin + (s.option.empty() ? "" : fmt::format(", {} {}", s.option, value)) +
         (s.split ? ", split" : ", not split");
}

/// Without obstacles, splitting at contacts does nothing.
bool told_apart(const AccuracySetup& setup, std::size_t scene, const ModelSweep& sweep) {
  return sweep.split || !setup.scenes[scene].scene.obstacles.empty();
}

/// Plugins and options have a colour each; not split is dashed.
struct Look {
  int color = 0, dash = 0;
};
Look look_of(const Accuracy& accuracy, std::size_t sweep) {
  std::vector<std::string> seen;
  const auto key = [&](std::size_t k) { return accuracy.sweeps[k].plugin + ' ' + accuracy.sweeps[k].option; };
  for (std::size_t k = 0; k < sweep; ++k) {
    if (std::find(seen.begin(), seen.end(), key(k)) == seen.end()) seen.push_back(key(k));
  }
  const auto own = std::find(seen.begin(), seen.end(), key(sweep)) - seen.begin();
  return {static_cast<int>(own), accuracy.sweeps[sweep].split ? 0 : 1};
}

template <class X, class Y>
std::vector<app::ChartSeries> lines(const AccuracySetup& setup, const Accuracy& accuracy, std::size_t scene, bool bars,
                                    X x, Y y) {
  std::vector<app::ChartSeries> series;
  for (std::size_t k = 0; k < accuracy.sweeps.size(); ++k) {
    if (!told_apart(setup, scene, accuracy.sweeps[k])) continue;
    const Look look = look_of(accuracy, k);
    app::ChartSeries line;
    line.name = accuracy.sweeps[k].name();
    line.color = look.color;
    line.dash = look.dash;
    for (const AccuracyPoint& point : accuracy.points) {
      if (point.scene != scene || point.sweep != k) continue;
      line.x.push_back(x(point));
      line.y.push_back(y(point));
      if (!bars) continue;
      line.x_low.push_back(1e3 * point.seconds.low);
      line.x_high.push_back(1e3 * point.seconds.high);
    }
    if (!line.x.empty()) series.push_back(std::move(line));
  }
  return series;
}

/// Rounding leaves errors of 0 here and there, which a logarithmic axis cannot show.
double shown(double error) { return std::max(error, 1e-17); }

void add_figures(const AccuracySetup& setup, const Accuracy& accuracy, Section& section) {
  const auto milliseconds = [](const AccuracyPoint& p) { return 1e3 * p.seconds.median; };
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    std::string stem = setup.scenes[s].name;
    std::replace(stem.begin(), stem.end(), ' ', '_');
    const double floor = accuracy.references[s].bound;
    const std::string unsplit = setup.scenes[s].scene.obstacles.empty() ? "" : " Dashed: not split at the contact.";
    const std::vector<app::ChartLevel> level{{floor, "bound of the reference's own error"}};
    section.figures.push_back(
        {"accuracy_" + stem,
         "Error of the tip against the time of a whole plan, one line per model, one point per value of its option. "
         "Bars: quartiles of the repetitions. Left and low is good." +
             unsplit,
         {setup.scenes[s].name + ": error against run time", "time of a plan (ms)", "error of the tip (L)", true, true,
          lines(setup, accuracy, s, true, milliseconds, [](const auto& p) { return shown(p.tip); }), level}});
    section.figures.push_back(
        {"convergence_" + stem,
         "Error of the tip against the number of coordinates. Straight lines are powers." + unsplit,
         {setup.scenes[s].name + ": convergence", "coordinates of the rod", "error of the tip (L)", true, true,
          lines(
              setup, accuracy, s, false, [](const auto& p) { return static_cast<double>(p.coordinates); },
              [](const auto& p) { return shown(p.tip); }),
          level}});
    if (!setup.scenes[s].force) continue;
    section.figures.push_back(
        {"force_" + stem,
         "Error of the contact force against the time of a whole plan." + unsplit,
         {setup.scenes[s].name + ": error of the contact force",
          "time of a plan (ms)",
          "relative error of the force",
          true,
          true,
          lines(setup, accuracy, s, true, milliseconds, [](const auto& p) { return shown(p.force); }),
          {}}});
  }
}

Table reference_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{"accuracy_references",
              "What the errors are measured against: the fine split Legendre basis, carried out at each plan's own "
              "moment. Its bound is its local moment balance over its margin of stability",
              {"scene", "bound of its error (L)", "distance of its tip from the exact table (L)",
               "last digit of the table (L)"},
              {}};
  for (std::size_t s = 0; s < accuracy.references.size(); ++s) {
    table.rows.push_back(
        {setup.scenes[s].name, accuracy.references[s].bound, accuracy.references[s].to_table, setup.scenes[s].digits});
  }
  return table;
}

Table order_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{
      "accuracy_orders",
      "How the tip's error falls with the option n that is swept, fitted above ten times the reference's bound. "
      "Power: error ~ n^exponent. Exponential: error ~ 10^(exponent n). The better fit is shown",
      {"scene", "model", "law", "exponent", "R^2", "points", "n from", "to"},
      {}};
  for (const ConvergenceOrder& order : accuracy.orders) {
    if (!told_apart(setup, order.scene, accuracy.sweeps[order.sweep])) continue;
    const bool known = std::isfinite(order.line.slope);
    table.rows.push_back({setup.scenes[order.scene].name, accuracy.sweeps[order.sweep].name(),
                          std::string(!known              ? "too few points above the bound"
                                      : order.exponential ? "exponential"
                                                          : "power"),
                          order.line.slope, order.line.determination, std::int64_t{order.line.points},
                          std::int64_t{order.from}, std::int64_t{order.to}});
  }
  return table;
}

Table millisecond_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{
      "accuracy_one_millisecond",
      "The least error that each model reaches within 1 ms of planning (median)",
      {"scene", "model", "coordinates", "tip (L)", "contact place (L)", "contact force (relative)", "time (ms)"},
      {}};
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    for (std::size_t k = 0; k < accuracy.sweeps.size(); ++k) {
      if (!told_apart(setup, s, accuracy.sweeps[k])) continue;
      const AccuracyPoint* best = nullptr;
      bool any = false;
      for (const AccuracyPoint& point : accuracy.points) {
        if (point.scene != s || point.sweep != k) continue;
        any = true;
        if (point.seconds.median <= one_millisecond && (best == nullptr || point.tip < best->tip)) best = &point;
      }
      if (best != nullptr) {
        table.rows.push_back({setup.scenes[s].name, model_name(accuracy, k, best->value),
                              std::int64_t{best->coordinates}, best->tip, best->place, best->force,
                              1e3 * best->seconds.median});
      } else if (any) {
        table.rows.push_back({setup.scenes[s].name, accuracy.sweeps[k].name() + ": none within 1 ms", std::string("-"),
                              std::string("-"), std::string("-"), std::string("-"), std::string("-")});
      }
    }
  }
  return table;
}

Table goal_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{"accuracy_goals",
              "The cheapest model for a given error of the tip on all of these scenes; time: sum over the scenes",
              {"goal (L)", "model", "coordinates at most", "largest error of the tip (L)", "time (ms)"},
              {}};
  const std::vector<ModelChoice> choices = model_choices(accuracy, setup.scenes.size());
  for (const double goal : {1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12}) {
    const auto found =
        std::find_if(choices.begin(), choices.end(), [&](const ModelChoice& c) { return c.error <= goal; });
    if (found == choices.end()) {
      table.rows.push_back(
          {goal, std::string("none of those measured"), std::string("-"), std::string("-"), std::string("-")});
    } else {
      table.rows.push_back({goal, model_name(accuracy, found->sweep, found->value), std::int64_t{found->coordinates},
                            found->error, 1e3 * found->seconds});
    }
  }
  return table;
}

Table point_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{"accuracy",
              "Every model on every scene, with quartiles",
              {"scene",           "plugin",         "option",       "value",          "split",
               "coordinates",     "tip_L",          "place_L",      "force_relative", "solvers_differ_L",
               "seconds_low",     "seconds_median", "seconds_high", "evaluating_low", "evaluating_median",
               "evaluating_high", "solves",         "iterations",   "evaluations",    "repeatable"},
              {},
              false};
  for (const AccuracyPoint& p : accuracy.points) {
    const ModelSweep& sweep = accuracy.sweeps[p.sweep];
    table.rows.push_back({setup.scenes[p.scene].name,
                          sweep.plugin,
                          sweep.option,
                          std::int64_t{p.value},
                          std::int64_t{sweep.split},
                          std::int64_t{p.coordinates},
                          p.tip,
                          p.place,
                          p.force,
                          p.solvers_differ,
                          p.seconds.low,
                          p.seconds.median,
                          p.seconds.high,
                          p.evaluating.low,
                          p.evaluating.median,
                          p.evaluating.high,
                          std::int64_t{p.solves},
                          std::int64_t{p.iterations},
                          p.evaluations,
                          std::int64_t{p.repeatable}});
  }
  return table;
}

Table time_table(const AccuracySetup& setup, const Accuracy& accuracy) {
  Table table{"accuracy_time",
              "Where the time of a plan goes (medians): evaluations, and everything else, which is the solver's own "
              "work, assembly, polish and certificate",
              {"scene", "model", "coordinates", "evaluations", "evaluating (ms)", "all else (ms)", "plan (ms)",
               "quartiles (ms)", "solvers differ by (L)"},
              {}};
  for (const AccuracyPoint& p : accuracy.points) {
    if (!told_apart(setup, p.scene, accuracy.sweeps[p.sweep])) continue;
    if (p.value != 0 && p.value != 3 && p.value != 6 && p.value != 12 && p.value != 48) continue;
    table.rows.push_back(
        {setup.scenes[p.scene].name, model_name(accuracy, p.sweep, p.value), std::int64_t{p.coordinates}, p.evaluations,
         1e3 * p.evaluating.median, 1e3 * (p.seconds.median - p.evaluating.median), 1e3 * p.seconds.median,
         fmt::format("{:.3g} .. {:.3g}", 1e3 * p.seconds.low, 1e3 * p.seconds.high), p.solvers_differ});
  }
  return table;
}

}  // namespace

Section accuracy_section(const AccuracySetup& setup, const Accuracy& accuracy) {
  Section section;
  section.name = "accuracy";
  section.title = "Error against run time";
  double differ = 0.0;
  int unrepeatable = 0;
  int elsewhere = 0;
  for (const AccuracyPoint& point : accuracy.points) {
    if (std::isfinite(point.solvers_differ)) differ = std::max(differ, point.solvers_differ);
    unrepeatable += point.repeatable ? 0 : 1;
    elsewhere += point.at_known_moment ? 0 : 1;
  }
  section.prose.push_back(
      "Every coordinate model that was found plans scenes whose solution is known, over every option that counts "
      "something (functions, pieces), split at the contact and not. In these scenes the target is out of reach, so the "
      "moment ends at its limit and all models answer the same question. The error is that of the model alone: each "
      "plan is polished until its rows hold to 1e-11 and is compared with the fine reference at its own moment.");
  section.prose.push_back(elsewhere == 0
                              ? std::string("All plans end at the moment for which the exact table holds.")
                              : fmt::format("{} of {} plans end at another moment than that of the exact table.",
                                            elsewhere, accuracy.points.size()));
  section.prose.push_back(fmt::format(
      "The solver's part: the tips that different solvers find on one and the same model lie at most {:.1e} L apart "
      "(models of up to {} coordinates), which is what the solver leaves.",
      differ, setup.compared));
  section.prose.push_back(fmt::format(
      "Times are of whole plans (components, assembly, every way of being in contact, polish, certificate), median of "
      "{} repetitions that run through all models in turn. Iterations and evaluations were the same in every "
      "repetition{}.",
      setup.repetitions, unrepeatable == 0 ? "" : fmt::format(", except on {} models", unrepeatable)));
  add_figures(setup, accuracy, section);
  section.tables = {reference_table(setup, accuracy),
                    order_table(setup, accuracy),
                    millisecond_table(setup, accuracy),
                    goal_table(setup, accuracy),
                    time_table(setup, accuracy),
                    point_table(setup, accuracy),
                    pace_table("accuracy_pace", accuracy.pace)};
  section.left_out = accuracy.left_out;
  return section;
}

}  // namespace tendril::bench
