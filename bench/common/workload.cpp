#include "common/workload.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <ctime>

#include "tendril/error.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {

std::vector<double> read_lengths(const std::string& text, const QuantityReader& read) {
  const std::string expected = "'" + text + "': expected FIRST:LAST:COUNT, for instance \"91 mm:99 mm:5\"";
  const std::size_t first = text.find(':');
  const std::size_t second = first == std::string::npos ? first : text.find(':', first + 1);
  if (second == std::string::npos) throw Error(expected);
  const double from = read(text.substr(0, first), dimension::length);
  const double to = read(text.substr(first + 1, second - first - 1), dimension::length);
  int count = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + second + 1, end, count);
  if (parsed.ec != std::errc() || parsed.ptr != end || count < 1 || count > 1000) throw Error(expected);
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) values.push_back(count == 1 ? from : from + (to - from) * i / (count - 1));
  return values;
}

double Uniform::operator()(double low, double high) {
  // SplitMix64 (Steele, Lea and Flood 2014).
  state_ += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  z ^= z >> 31U;
  return low + (high - low) * (static_cast<double>(z >> 11U) * 0x1.0p-53);
}

Plan random_start(Uniform& random, double length) {
  const double turn = random(-2.0, 2.0);
  const double slope = random(-1.5, 1.5);
  const double bow = random(-1.5, 1.5);
  Plan plan;
  constexpr int steps = 100;
  for (int i = 0; i <= steps; ++i) {
    const double z = 2.0 * i / steps - 1.0;
    // Legendre polynomials: neither slope nor bow turns the tip.
    const double curvature = turn + slope * z + bow * (1.5 * z * z - 0.5);
    plan.backbone.push_back({0.5 * (z + 1.0) * length, 0.0, 0.0, 0.0, curvature / length});
  }
  return plan;
}

std::string sides(const Plan& plan, const std::vector<Vec2>& references) {
  std::string text;
  for (const Vec2 reference : references) {
    double nearest = infinity;
    double side = 0.0;
    for (const BackbonePoint& p : plan.backbone) {
      const Vec2 away = p.position() - reference;
      if (norm(away) >= nearest) continue;
      nearest = norm(away);
      side = cross({std::cos(p.angle), std::sin(p.angle)}, away);
    }
    text += side >= 0.0 ? '+' : '-';
  }
  return text;
}

const ModeRecord* winning_mode(const Plan& plan) {
  const ModeRecord* best = nullptr;
  for (const ModeRecord& mode : plan.modes) {
    if (mode.certified && (best == nullptr || mode.objective < best->objective)) best = &mode;
  }
  return best;
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double processor_now() {
  timespec time{};
  if (::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) != 0) throw Error("this system does not tell processor times");
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Pace::beat() {
  using Matrix = Eigen::Matrix<double, 24, 24>;
  const double begin = processor_now();
  for (int round = 0; round < 40; ++round) {
    Matrix columns;
    for (int i = 0; i < columns.size(); ++i) columns.data()[i] = std::sin(0.1 * i + round) * std::cos(0.3 * i + kept_);
    const Matrix square = columns * columns.transpose() + Matrix::Identity();
    kept_ = 1e-3 * square.llt().matrixLLT()(23, 23);
  }
  seconds_.push_back(processor_now() - begin);
}

TimedPlan timed_plan(plugins::Registry& registry, const Scene& scene, const PlanControl& control) {
  TimedPlan timed;
  const double begin = processor_now();
  Problem problem(scene, plugins::make_components(registry, scene));
  timed.plan = problem.plan(control);
  timed.seconds = processor_now() - begin;
  for (const ModeRecord& mode : timed.plan.modes) {
    timed.evaluating += mode.seconds_evaluating;
    timed.solves += mode.solves;
    timed.iterations += mode.iterations;
    timed.evaluations += mode.evaluations;
  }
  return timed;
}

std::string ModelSweep::name() const {
  return plugin + (option.empty() ? "" : ", " + option) + (split ? ", split" : ", not split");
}

std::vector<ModelSweep> model_sweeps(plugins::Registry& registry, const std::vector<int>& values,
                                     std::vector<LeftOut>& left_out) {
  std::vector<ModelSweep> sweeps;
  for (const std::string& plugin : registry.names(ComponentKind::coordinates)) {
    const CoordinateComponent* component = nullptr;
    try {
      component = &registry.coordinates(plugin);
    } catch (const plugins::PluginError& error) {
      left_out.push_back({"coordinates '" + plugin + "'", error.what()});
      continue;
    }
    std::vector<ModelSweep> own;
    for (const OptionSpec& option : component->options) {
      if (option.type != OptionType::integer || option.minimum < 1.0) continue;
      ModelSweep sweep{plugin, option.name, {}, true};
      for (const int value : values) {
        if (value >= option.minimum && value <= option.maximum) sweep.values.push_back(value);
      }
      own.push_back(sweep);
    }
    if (own.empty()) own.push_back({plugin, "", {0}, true});
    for (const bool split : {true, false}) {
      for (ModelSweep sweep : own) {
        sweep.split = split;
        sweeps.push_back(std::move(sweep));
      }
    }
  }
  return sweeps;
}

Scene with_model(Scene scene, const ModelSweep& sweep, int value) {
  scene.coordinates.plugin = sweep.plugin;
  scene.coordinates.split_at_contact = sweep.split;
  scene.coordinates.options.clear();
  if (!sweep.option.empty()) scene.coordinates.options[sweep.option] = RawValue{std::int64_t{value}};
  return scene;
}

int coordinate_count(plugins::Registry& registry, const Scene& scene) {
  const Problem problem(scene, plugins::make_components(registry, scene));
  for (const Description::Count& variable : problem.describe().variables) {
    if (variable.name == "coordinates") return variable.count;
  }
  return 0;
}

}  // namespace tendril::bench
