#include "report/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// Errors below this many times the reference's own bound say nothing of the model.
constexpr double above_floor = 10.0;
/// Asymptotic laws are read off from here on, where enough points are left.
constexpr int asymptotic_from = 4;
constexpr std::size_t fewest_points = 4;

const PlannedContact* active_contact(const Plan& plan) {
  for (const PlannedContact& contact : plan.contacts) {
    if (contact.force > 0.0) return &contact;
  }
  return nullptr;
}

double distance(const Plan& a, const Plan& b) { return std::hypot(a.tip_x - b.tip_x, a.tip_y - b.tip_y); }

/// Fine solutions of one scene at the moments that its plans ask for; nearly all ask for the same.
class References {
 public:
  References(plugins::Registry& registry, const KnownScene& known)
      : scene_(known.scene), obstacles_(plugins::make_obstacles(registry, known.scene)) {}

  const Plan& at(const std::vector<double>& moments) {
    const auto found = fine_.find(moments);
    if (found != fine_.end()) return found->second;
    return fine_.emplace(moments, execute(scene_, obstacles_, moments).result).first->second;
  }

 private:
  const Scene& scene_;
  std::vector<std::unique_ptr<Obstacle>> obstacles_;
  std::map<std::vector<double>, Plan> fine_;
};

/// Errors of a plan against its reference; empty, or why there are none.
std::string judge(const Plan& plan, const Plan& fine, double length, AccuracyPoint& point) {
  if (plan.status != PlanStatus::solved) return std::string("not certified: ") + plan.message;
  if (fine.status != PlanStatus::solved) return "its moment has no fine reference: " + fine.message;
  const PlannedContact* contact = active_contact(plan);
  const PlannedContact* exact = active_contact(fine);
  if ((contact == nullptr) != (exact == nullptr)) return "carried out, its moment ends with other contacts";
  point.tip = distance(plan, fine) / length;
  point.place = contact != nullptr ? std::abs(contact->arc_length - exact->arc_length) / length : undefined;
  point.force = contact != nullptr ? std::abs(contact->force / exact->force - 1.0) : undefined;
  return "";
}

double differences(plugins::Registry& registry, const Scene& scene, const Plan& plan, double length) {
  double largest = undefined;
  for (const std::string& solver : registry.names(ComponentKind::solver)) {
    if (solver == scene.solver.plugin) continue;
    Scene other = scene;
    other.solver.plugin = solver;
    other.solver.options.clear();
    const Plan second = timed_plan(registry, other).plan;
    if (second.status != PlanStatus::solved) continue;
    const double apart = distance(plan, second) / length;
    largest = std::isnan(largest) ? apart : std::max(largest, apart);
  }
  return largest;
}

ConvergenceOrder order_of(const Accuracy& accuracy, std::size_t scene, std::size_t sweep) {
  ConvergenceOrder order{scene, sweep, false, {}, 0, 0};
  const double floor = above_floor * accuracy.references[scene].bound;
  std::vector<const AccuracyPoint*> points, late;
  for (const AccuracyPoint& point : accuracy.points) {
    if (point.scene != scene || point.sweep != sweep || point.value == 0 || point.tip <= floor) continue;
    points.push_back(&point);
    if (point.value >= asymptotic_from) late.push_back(&point);
  }
  if (late.size() >= fewest_points) points = late;
  std::vector<double> n, error;
  for (const AccuracyPoint* point : points) {
    n.push_back(point->value);
    error.push_back(point->tip);
  }
  order.line = fit_line({}, {});
  if (n.empty()) return order;
  order.from = points.front()->value;
  order.to = points.back()->value;
  const Line power = fit_power(n, error);
  const Line exponential = fit_exponential(n, error);
  order.exponential = exponential.determination > power.determination;
  order.line = order.exponential ? exponential : power;
  return order;
}

}  // namespace

Accuracy measure_accuracy(plugins::Registry& registry, const AccuracySetup& setup) {
  Accuracy accuracy;
  accuracy.sweeps = model_sweeps(registry, setup.values, accuracy.left_out);
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  struct Run {
    Scene scene;
    std::vector<double> seconds, evaluating;
  };
  std::vector<Run> runs;
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    const KnownScene& known = setup.scenes[s];
    const double length = known.scene.rod.length();
    References references(registry, known);
    const Plan& exact = references.at({known.moment});
    AccuracyReference reference;
    // A defect of the moment balance turns the rod by at most its integral over the margin.
    reference.bound = exact.certificate.moment_balance / exact.certificate.stability;
    reference.to_table = std::hypot(exact.tip_x - known.tip.x, exact.tip_y - known.tip.y) / length;
    accuracy.references.push_back(reference);
    for (std::size_t k = 0; k < accuracy.sweeps.size(); ++k) {
      const ModelSweep& sweep = accuracy.sweeps[k];
      for (const int value : sweep.values) {
        if (stopped()) return accuracy;
        const Scene scene = with_model(known.scene, sweep, value);
        AccuracyPoint point;
        point.scene = s;
        point.sweep = k;
        point.value = value;
        const std::string what = known.name + ", " + sweep.name() + (value > 0 ? " " + std::to_string(value) : "");
        point.coordinates = coordinate_count(registry, scene);
        if (point.coordinates > setup.most_coordinates) {
          accuracy.left_out.push_back({what, std::to_string(point.coordinates) + " coordinates, the limit here is " +
                                                 std::to_string(setup.most_coordinates)});
          continue;
        }
        const TimedPlan first = timed_plan(registry, scene);
        const std::string problem = first.plan.status == PlanStatus::solved
                                        ? judge(first.plan, references.at(first.plan.moments), length, point)
                                        : judge(first.plan, exact, length, point);
        if (!problem.empty()) {
          accuracy.left_out.push_back({what, problem});
          continue;
        }
        point.at_known_moment =
            std::abs(first.plan.moments.front() - known.moment) <= tolerance::bounds * std::abs(known.moment);
        point.solves = first.solves;
        point.iterations = first.iterations;
        point.evaluations = first.evaluations;
        point.solvers_differ =
            point.coordinates <= setup.compared ? differences(registry, scene, first.plan, length) : undefined;
        accuracy.points.push_back(point);
        runs.push_back({scene, {}, {}});
      }
    }
  }
  Pace pace;
  for (int repetition = 0; repetition < setup.repetitions && !stopped(); ++repetition) {
    for (std::size_t i = 0; i < runs.size() && !stopped(); ++i) {
      pace.beat();
      const TimedPlan again = timed_plan(registry, runs[i].scene);
      runs[i].seconds.push_back(again.seconds);
      runs[i].evaluating.push_back(again.evaluating);
      AccuracyPoint& point = accuracy.points[i];
      point.repeatable =
          point.repeatable && again.iterations == point.iterations && again.evaluations == point.evaluations;
    }
  }
  accuracy.pace = pace.seconds();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    accuracy.points[i].seconds = quartiles(runs[i].seconds);
    accuracy.points[i].evaluating = quartiles(runs[i].evaluating);
  }
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    for (std::size_t k = 0; k < accuracy.sweeps.size(); ++k) {
      if (!accuracy.sweeps[k].option.empty()) accuracy.orders.push_back(order_of(accuracy, s, k));
    }
  }
  return accuracy;
}

std::vector<ModelChoice> model_choices(const Accuracy& accuracy, std::size_t scenes) {
  std::map<std::pair<std::size_t, int>, std::pair<ModelChoice, std::size_t>> models;
  for (const AccuracyPoint& point : accuracy.points) {
    auto& [choice, seen] = models[{point.sweep, point.value}];
    choice.sweep = point.sweep;
    choice.value = point.value;
    choice.coordinates = std::max(choice.coordinates, point.coordinates);
    choice.error = std::max(choice.error, point.tip);
    choice.seconds += point.seconds.median;
    ++seen;
  }
  std::vector<ModelChoice> choices;
  for (const auto& [key, model] : models) {
    const ModelChoice& one = model.first;
    // Two options of a plugin meet where one of them has its default.
    const bool met = std::any_of(choices.begin(), choices.end(), [&](const ModelChoice& other) {
      const ModelSweep& a = accuracy.sweeps[one.sweep];
      const ModelSweep& b = accuracy.sweeps[other.sweep];
      return a.plugin == b.plugin && a.split == b.split && one.coordinates == other.coordinates &&
             one.error == other.error;
    });
    if (model.second == scenes && !met) choices.push_back(one);
  }
  std::sort(choices.begin(), choices.end(), [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  return choices;
}

}  // namespace tendril::bench
