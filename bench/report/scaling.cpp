#include "report/scaling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/scenes.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {

namespace {

/// Exponents are fitted over the upper half of a sweep: below it fixed costs hide them.
constexpr double upper_part = 0.25;

struct Sizes {
  std::vector<int> values;  ///< of every option that is swept
  int most_coordinates = 0, most_obstacles = 0;
};
Sizes sizes(const Extent& extent) {
  if (extent.quick) return {{1, 2, 4, 8}, 48, 8};
  return {{1, 2, 4, 8, 16, 32, 64}, 128, 32};
}

struct Point {
  int size = 0;
  Scene scene;
  std::vector<double> seconds{}, evaluation{};
  TimedPlan plan{};
};

struct Sweep {
  std::string name, unit;
  std::vector<Point> points;
};

std::string pegs(int count) {
  std::string text;
  // Two rows, above and below, both clear of the arm.
  for (int i = 0; i < count; ++i) {
    const int column = i / 2;
    const double x = 8.0 + 84.0 * column / std::max(1, (count + 1) / 2);
    text += fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [\"{:.6g} mm\", \"{} mm\"]\nradius = \"1 mm\"\n", x,
                        i % 2 == 0 ? -14 : 40);
  }
  return text;
}

std::vector<Sweep> sweeps(plugins::Registry& registry, const Sizes& setup, Section& section) {
  std::vector<Sweep> all;
  const std::string target = "[target]\nposition = [\"95 mm\", \"16 mm\"]\n";
  const std::string allow = "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n";
  const std::string avoid = "[contact]\nmode = \"avoid\"\n";
  const Scene brace =
      scene_from_text(gravity() + arm("2.5 N mm") + peg() + allow + target + objectives(), "brace", registry);
  for (const ModelSweep& model : model_sweeps(registry, setup.values, section.left_out)) {
    if (model.option.empty() || !model.split) continue;
    Sweep sweep{model.plugin + ", " + model.option, "value of the option", {}};
    for (const int value : model.values) {
      const Scene scene = with_model(brace, model, value);
      const int coordinates = coordinate_count(registry, scene);
      if (coordinates > setup.most_coordinates) {
        section.left_out.push_back(
            {fmt::format("{} {}", sweep.name, value),
             fmt::format("{} coordinates, the limit here is {}", coordinates, setup.most_coordinates)});
        continue;
      }
      sweep.points.push_back({value, scene});
    }
    all.push_back(std::move(sweep));
  }
  Sweep checks{"check points", "check points, fixed", {}};
  for (int n = 4; n <= 256; n *= 2) {
    Scene scene = brace;
    scene.contact.check_points = n;
    checks.points.push_back({n, scene});
  }
  all.push_back(std::move(checks));
  Sweep obstacles{"obstacles, avoided", "obstacles", {}};
  for (int n = 1; n <= setup.most_obstacles; n *= 2) {
    obstacles.points.push_back(
        {n, scene_from_text(gravity() + arm("10 N mm") + pegs(n) + avoid + target + objectives(), "pegs", registry)});
  }
  all.push_back(std::move(obstacles));
  Sweep touched{"obstacles, one contact allowed", "obstacles", {}};
  for (int n = 1; n <= std::min(8, setup.most_obstacles); n *= 2) {
    touched.points.push_back(
        {n, scene_from_text(gravity() + arm("10 N mm") + pegs(n) + allow + target + objectives(), "pegs", registry)});
  }
  all.push_back(std::move(touched));
  Sweep contacts{"contacts allowed, three pegs", "contacts at most", {}};
  for (int n = 1; n <= 3; ++n) {
    contacts.points.push_back({n, scene_from_text(gravity() + arm("10 N mm") + pegs(3) + allow +
                                                      fmt::format("count = {}\n", n) + target + objectives(),
                                                  "pegs", registry)});
  }
  all.push_back(std::move(contacts));
  Sweep actuators{"actuators, one behind the other", "actuators", {}};
  for (int n = 1; n <= 8; n *= 2) {
    Scene scene = brace;
    const ActuatorSpec whole = scene.rod.actuators.front();
    scene.rod.actuators.assign(static_cast<std::size_t>(n), whole);
    for (int i = 0; i < n; ++i) {
      ActuatorSpec& one = scene.rod.actuators[static_cast<std::size_t>(i)];
      one.from = i * scene.rod.length() / n;
      one.to = (i + 1) * scene.rod.length() / n;
    }
    actuators.points.push_back({n, scene});
  }
  all.push_back(std::move(actuators));
  return all;
}

Line exponent(const Sweep& sweep, bool evaluation) {
  std::vector<double> n, time;
  const double least = upper_part * sweep.points.back().size;
  for (const Point& p : sweep.points) {
    if (p.size < least || p.plan.plan.status != PlanStatus::solved) continue;
    n.push_back(p.size);
    time.push_back(median(evaluation ? p.evaluation : p.seconds));
  }
  return fit_power(n, time);
}

}  // namespace

Section scaling_section(plugins::Registry& registry, const Extent& extent) {
  Section section;
  section.name = "scaling";
  section.title = "How the cost grows";
  std::vector<Sweep> all = sweeps(registry, sizes(extent), section);
  all.erase(std::remove_if(all.begin(), all.end(), [](const Sweep& s) { return s.points.empty(); }), all.end());
  for (int repetition = -1; repetition < extent.repetitions_of_timed() && !extent.stopped(); ++repetition) {
    for (Sweep& sweep : all) {
      for (Point& point : sweep.points) {
        if (repetition >= 0 && point.plan.plan.status != PlanStatus::solved) continue;
        TimedPlan timed = timed_plan(registry, point.scene);
        if (repetition >= 0) {
          point.seconds.push_back(timed.seconds);
          if (timed.evaluations > 0)
            point.evaluation.push_back(timed.evaluating / static_cast<double>(timed.evaluations));
        } else {
          point.plan = std::move(timed);
        }
      }
    }
  }
  Table exponents{"scaling_exponents",
                  "Time ~ size^exponent, fitted over the upper part of each sweep (from a quarter of the largest size)",
                  {"sweep", "sizes up to", "exponent of an evaluation", "R^2", "exponent of a plan", "R^2"},
                  {}};
  Table points{"scaling",
               "Every size (medians; quartiles of a plan)",
               {"sweep", "size", "evaluations", "one evaluation (us)", "plan (ms)", "quartiles (ms)"},
               {}};
  app::Chart plan{"Time of a plan", "size of what is swept", "time of a plan (ms)", true, true, {}, {}};
  app::Chart evaluation{
      "Time of an evaluation", "size of what is swept", "time of an evaluation (us)", true, true, {}, {}};
  int color = 0;
  for (const Sweep& sweep : all) {
    app::ChartSeries a;
    a.name = sweep.name;
    a.color = color++;
    app::ChartSeries b = a;
    for (const Point& p : sweep.points) {
      if (p.plan.plan.status != PlanStatus::solved) {
        section.left_out.push_back(
            {fmt::format("{}, {}", sweep.name, p.size), "not certified: " + p.plan.plan.message});
        continue;
      }
      const Quartiles q = quartiles(p.seconds);
      points.rows.push_back({sweep.name, std::int64_t{p.size}, p.plan.evaluations, 1e6 * median(p.evaluation),
                             1e3 * q.median, fmt::format("{:.3g} .. {:.3g}", 1e3 * q.low, 1e3 * q.high)});
      a.x.push_back(p.size);
      a.y.push_back(1e3 * q.median);
      b.x.push_back(p.size);
      b.y.push_back(1e6 * median(p.evaluation));
    }
    plan.series.push_back(std::move(a));
    evaluation.series.push_back(std::move(b));
    const Line by_evaluation = exponent(sweep, true);
    const Line by_plan = exponent(sweep, false);
    exponents.rows.push_back({sweep.name, std::int64_t{sweep.points.back().size}, by_evaluation.slope,
                              by_evaluation.determination, by_plan.slope, by_plan.determination});
  }
  section.prose.push_back(
      "The braced arm with more functions or pieces, more fixed check points, more obstacles and more contacts. An "
      "evaluation is cost, gradient, rows and Jacobian inside a solver; a plan is everything. Solvers factor dense "
      "matrices, so a plan grows faster than an evaluation.");
  section.figures = {{"scaling_plan", "Median time of a whole plan.", plan},
                     {"scaling_evaluation", "Median time of one evaluation.", evaluation}};
  section.tables = {exponents, points};
  return section;
}

}  // namespace tendril::bench
