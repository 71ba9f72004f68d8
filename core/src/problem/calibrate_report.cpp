#include "problem/calibrate_report.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "calibrate/identifiability.hpp"
#include "problem/calibrated_range.hpp"

namespace tendril {
namespace {

/// Numbers known to no better than a tenth of what makes a difference are not reported: a tenth of a factor, of an
/// actuator's largest moment, of a radian, of the rod's length (as estimate() has it).
constexpr double largest_error = 0.1;
/// Loads beyond those that were fitted by less than this part of their range are rounding.
constexpr double range_tolerance = 1e-9;

/// Unknowns in terms of which the points are asked what they determine: unknowns = basis * asked. A factor counts
/// against itself. Of a law of a moment it is not its powers that matter but its values, at evenly spaced inputs,
/// against the largest one.
struct Asked {
  Eigen::MatrixXd basis;
  std::vector<std::string> names;
};

/// Powers of a law, by their places among the unknowns.
std::vector<Eigen::Index> powers_of(const CalibrationInput& in, CalibrationUnknown law, int actuator) {
  std::vector<Eigen::Index> out;
  for (std::size_t i = 0; i < in.problem.unknowns.size(); ++i) {
    const Sought& u = in.problem.unknowns[i];
    if (u.kind == law && u.index == actuator) out.push_back(static_cast<Eigen::Index>(i));
  }
  return out;
}

void ask_for_values(const CalibrationInput& in, const Eigen::VectorXd& found, const std::vector<Eigen::Index>& powers,
                    Asked& out) {
  constexpr double least = 1e-3;  // EI/L, EI/L^2
  const auto degree = static_cast<Eigen::Index>(powers.size());
  Eigen::MatrixXd values(degree, degree);
  for (Eigen::Index k = 0; k < degree; ++k) {
    const double input = static_cast<double>(k + 1) / static_cast<double>(degree);
    for (Eigen::Index j = 0; j < degree; ++j) values(k, j) = std::pow(input, static_cast<double>(j + 1));
    out.names[static_cast<std::size_t>(powers[static_cast<std::size_t>(k)])] =
        in.numbers[static_cast<std::size_t>(powers.front())].name +
        (degree == 1 ? "" : " at " + shown(input, 2) + " of the largest");
  }
  const double largest = std::max(least, (values * found(powers)).cwiseAbs().maxCoeff());
  out.basis(powers, powers) = largest * values.inverse();
}

Asked asked(const CalibrationInput& in, const Eigen::VectorXd& found, const std::vector<bool>& free) {
  const auto count = static_cast<Eigen::Index>(in.problem.unknowns.size());
  Asked out{Eigen::MatrixXd::Identity(count, count), {}};
  for (Eigen::Index i = 0; i < count; ++i) {
    out.names.push_back(in.numbers[static_cast<std::size_t>(i)].name);
    if (is_factor(in.problem.unknowns[static_cast<std::size_t>(i)].kind)) out.basis(i, i) = found[i];
  }
  for (int a = 0; a < static_cast<int>(in.problem.rod.actuators.size()); ++a) {
    for (const CalibrationUnknown law : {CalibrationUnknown::moment, CalibrationUnknown::force}) {
      const std::vector<Eigen::Index> powers = powers_of(in, law, a);
      // A power that a bound holds is known, and its law is then asked for by the others.
      const bool all =
          std::all_of(powers.begin(), powers.end(), [&](Eigen::Index p) { return free[static_cast<std::size_t>(p)]; });
      if (!powers.empty() && all) ask_for_values(in, found, powers, out);
    }
  }
  return out;
}

/// A direction in words: what shares in it.
std::string combination(const Asked& of, const Eigen::VectorXd& direction) {
  std::string out;
  const double largest = direction.cwiseAbs().maxCoeff();
  double sign = 0.0;
  int count = 0;
  std::string last;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) < 0.1 * largest) continue;
    if (count++ == 0) sign = direction[i] < 0.0 ? -1.0 : 1.0;
    const double share = sign * direction[i];
    last = "the " + of.names[static_cast<std::size_t>(i)];
    out += (out.empty() ? "" : share < 0.0 ? " less " : " with ") + shown(std::abs(share), 4) + " of " + last;
  }
  if (count == 1) return last;
  return "a change of " + out +
         " (parts of factors and of the largest moments and forces, radians, lengths of the rod)";
}

struct Range {
  double low = infinity, high = -infinity;
};

std::vector<Range> ranges_of(const CalibrationInput& in, const std::vector<int>& shapes) {
  std::vector<Range> out(in.known.front().size());
  for (const int s : shapes) {
    for (std::size_t k = 0; k < out.size(); ++k) {
      const double value = in.known[static_cast<std::size_t>(s)][k].value;
      out[k] = {std::min(out[k].low, value), std::max(out[k].high, value)};
    }
  }
  return out;
}

/// The loads that were fitted, as seen from the base; the scene's, or the one that was found.
CalibratedLoads loads_of(const CalibrationInput& in, const Scene& scene, const std::vector<CalibratedNumber>& numbers) {
  double angle = scene.rod.base_angle;
  for (const CalibratedNumber& n : numbers) {
    const bool of_all = n.spec.kind == CalibrationUnknown::base_angle && n.spec.per == CalibrationScope::all;
    if (of_all && n.identifiable) angle = n.value;
  }
  std::size_t next = scene.rod.actuators.size();
  const auto take = [&](std::size_t names) {
    LoadRange out{{infinity, infinity}, {-infinity, -infinity}};
    for (const int s : in.fitted) {
      const auto& known = in.known[static_cast<std::size_t>(s)];
      const Vec2 seen = seen_from_base({known[next].value, known[next + 1].value}, angle);
      out = {{std::min(out.first.x, seen.x), std::min(out.first.y, seen.y)},
             {std::max(out.second.x, seen.x), std::max(out.second.y, seen.y)}};
    }
    next += names;
    return out;
  };
  CalibratedLoads out;
  out.gravity = take(2);
  for (const RodLoadSpec& load : scene.rod.loads) {
    const Vec2 spread = seen_from_base(load.force, angle);
    out.along.push_back(load.from < load.to ? LoadRange{spread, spread} : take(3));
  }
  out.tip_force = take(3);
  return out;
}

/// What of a recording's loads lies beyond those of others; empty: nothing.
std::string beyond(const CalibrationInput& in, int shape, const std::vector<Range>& ranges) {
  std::string out;
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    const CalibrationInput::Known& known = in.known[static_cast<std::size_t>(shape)][k];
    const Range& range = ranges[k];
    const double rounding = range_tolerance * std::max({std::abs(range.low), std::abs(range.high), 1e-300});
    if (known.value >= range.low - rounding && known.value <= range.high + rounding) continue;
    out += (out.empty() ? "" : ", ") + known.name + " " + shown(known.value, 4) + " " + known.unit + " (fitted " +
           shown(range.low, 4) + " to " + shown(range.high, 4) + ")";
  }
  return out;
}

struct MarkerErrors {
  double rms = 0.0, tip = 0.0;
};

/// Distances of markers from where they were seen, m.
MarkerErrors errors_of(const CalibrationInput& in, const FittedPoint& point, int shape) {
  const auto i = static_cast<std::size_t>(shape);
  MarkerErrors out;
  double squares = 0.0;
  int count = 0;
  Eigen::Index row = 0;
  for (const SeenMarker& m : in.problem.shapes[i].markers) {
    if (m.has_position) {
      out.tip = in.scale.length * point.residuals[i].segment<2>(row).norm();
      squares += out.tip * out.tip;
      ++count;
      row += 2;
    }
    row += m.has_angle ? 1 : 0;
  }
  if (count > 0) out.rms = std::sqrt(squares / count);
  return out;
}

CalibratedShape shape_of(const CalibrationInput& in, const FittedPoint& point, int shape) {
  const auto i = static_cast<std::size_t>(shape);
  CalibratedShape out;
  Eigen::Index row = 0;
  for (const SeenMarker& m : in.problem.shapes[i].markers) {
    if (m.has_position) {
      const Vec2 off{point.residuals[i][row], point.residuals[i][row + 1]};
      out.measured.push_back(in.scale.length * m.position);
      out.fitted.push_back(in.scale.length * (m.position + off));
      row += 2;
    }
    row += m.has_angle ? 1 : 0;
  }
  const MarkerErrors errors = errors_of(in, point, shape);
  out.rms = errors.rms;
  out.tip_error = errors.tip;
  return out;
}

/// Standard deviation of a coordinate between recordings with the same loads and markers, about their mean.
double repeatability(const CalibrationInput& in) {
  std::map<std::vector<double>, std::vector<int>> alike;
  for (const int s : in.fitted) {
    std::vector<double> key;
    for (const CalibrationInput::Known& k : in.known[static_cast<std::size_t>(s)]) key.push_back(k.value);
    for (const SeenMarker& m : in.problem.shapes[static_cast<std::size_t>(s)].markers) key.push_back(m.arc_length);
    alike[key].push_back(s);
  }
  double squares = 0.0;
  std::size_t degrees = 0;
  for (const auto& [key, shapes] : alike) {
    const std::size_t markers = in.problem.shapes[static_cast<std::size_t>(shapes.front())].markers.size();
    for (std::size_t m = 0; m < markers; ++m) {
      const auto seen = [&](int s) { return in.problem.shapes[static_cast<std::size_t>(s)].markers[m].position; };
      Vec2 mean{};
      for (const int s : shapes) mean += (1.0 / static_cast<double>(shapes.size())) * seen(s);
      for (const int s : shapes) squares += dot(seen(s) - mean, seen(s) - mean);
      degrees += 2 * (shapes.size() - 1);
    }
  }
  return degrees == 0 ? infinity : in.scale.length * std::sqrt(squares / static_cast<double>(degrees));
}

TipErrors tip_errors(std::vector<double> errors) {
  TipErrors out;
  out.count = static_cast<int>(errors.size());
  if (errors.empty()) return out;
  std::sort(errors.begin(), errors.end());
  for (const double e : errors) out.mean += e / static_cast<double>(errors.size());
  out.median = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  out.largest = errors.back();
  return out;
}

}  // namespace

void report_numbers(const CalibrationInput& in, const CalibrationFit& fit, const CalibrationFit::Result& result,
                    Calibration& out) {
  const std::size_t count = in.problem.unknowns.size();
  std::vector<bool> free(count, true);
  Eigen::VectorXd unit(static_cast<Eigen::Index>(count));
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  fit.equations(result.point, result.noise, normal, gradient);
  for (std::size_t i = 0; i < count; ++i) {
    const auto u = static_cast<Eigen::Index>(i);
    const Sought& sought = in.problem.unknowns[i];
    CalibratedNumber& number = out.numbers[i];
    unit[u] = in.units[i];
    number.value = result.point.values[u] * in.units[i];
    number.at_bound = result.point.values[u] <= sought.lower || result.point.values[u] >= sought.upper;
    free[i] = !number.at_bound;
    if (number.at_bound)
      out.warnings.push_back("the " + number.name + " ends at its bound, where its error says nothing");
  }
  const Asked as = asked(in, result.point.values, free);
  const Eigen::MatrixXd seen = as.basis.transpose() * normal * as.basis;
  const Identifiability known = identify(seen, result.noise * result.noise, free, largest_error);
  for (const Eigen::VectorXd& direction : known.undetermined) out.undetermined.push_back(combination(as, direction));
  const Eigen::MatrixXd in_si = unit.asDiagonal() * as.basis;
  out.covariance = in_si * known.covariance * in_si.transpose();
  for (std::size_t i = 0; i < count; ++i) {
    CalibratedNumber& number = out.numbers[i];
    const auto u = static_cast<Eigen::Index>(i);
    number.identifiable = true;
    for (std::size_t k = 0; k < count; ++k) {
      const bool shares = as.basis(u, static_cast<Eigen::Index>(k)) != 0.0;
      number.identifiable = number.identifiable && (!shares || known.determined[k]);
    }
    if (!number.identifiable) {
      out.covariance.row(u).setZero();
      out.covariance.col(u).setZero();
    }
    number.error = std::sqrt(out.covariance(u, u));
    if (!number.identifiable) number.reason = "the points do not determine " + out.undetermined.front();
  }
  const int measured = CalibrationFit::count(in.problem, in.fitted);
  double squares = 0.0;
  for (const int s : in.fitted) squares += result.point.residuals[static_cast<std::size_t>(s)].squaredNorm();
  out.residual_rms = in.scale.length * std::sqrt(squares / measured);
  out.noise = in.scale.length * result.noise;
  out.noise_estimated = in.problem.noise == 0.0;
  out.degrees_of_freedom = measured - static_cast<int>(count);
  out.repeatability = repeatability(in);
}

void report_shapes(const CalibrationInput& in, const Scene& scene, const CalibrationSpec& spec, CalibrationFit& fit,
                   const FittedPoint& point, Calibration& out) {
  const std::vector<Range> ranges = ranges_of(in, in.fitted);
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    const CalibrationInput::Known& known = in.known.front()[k];
    out.ranges.push_back(known.name + " " + shown(ranges[k].low, 4) + " to " + shown(ranges[k].high, 4) + " " +
                         known.unit);
  }
  const std::vector<ActuatorKind>& kinds = spec.recordings.front().input_kinds;
  for (std::size_t a = 0; a < kinds.size(); ++a) out.inputs.push_back({kinds[a], ranges[a].low, ranges[a].high});
  out.loads = loads_of(in, scene, out.numbers);
  std::vector<double> drawn(51);
  for (std::size_t i = 0; i < drawn.size(); ++i)
    drawn[i] = static_cast<double>(i) / static_cast<double>(drawn.size() - 1);
  out.shapes.resize(spec.recordings.size());
  for (std::size_t i = 0; i < spec.recordings.size(); ++i) {
    const auto s = static_cast<int>(i);
    const bool check = spec.recordings[i].check_only;
    const FittedPoint predicted = check ? fit.at(point.values, {s}, nullptr) : FittedPoint{};
    const FittedPoint& at = check ? predicted : point;
    CalibratedShape shape;
    if (!check || predicted.found) {
      shape = shape_of(in, at, s);
      const std::vector<CalibrationFit::Drawn> points = fit.draw(at, s, drawn);
      for (std::size_t p = 0; p < points.size(); ++p) {
        const Vec2 position = in.scale.length * points[p].position;
        shape.backbone.push_back({in.scale.length * drawn[p], position.x, position.y, points[p].angle,
                                  points[p].curvature / in.scale.length});
      }
    } else {
      shape.rms = shape.tip_error = infinity;
      out.warnings.push_back("recording \"" + spec.recordings[i].name + "\" has no equilibrium as calibrated");
    }
    shape.name = spec.recordings[i].name;
    shape.check_only = check;
    if (check) shape.beyond = beyond(in, s, ranges);
    out.shapes[i] = std::move(shape);
  }
}

void report_predictions(const CalibrationInput& in, const FittedPoint& predicted, const std::vector<int>& left_out,
                        const std::vector<int>& others, Calibration& out) {
  const std::vector<Range> ranges = ranges_of(in, others);
  for (const int s : left_out) {
    CalibratedShape& shape = out.shapes[static_cast<std::size_t>(s)];
    shape.beyond = beyond(in, s, ranges);
    if (!predicted.found) continue;
    const MarkerErrors errors = errors_of(in, predicted, s);
    shape.left_out_tip_error = errors.tip;
    shape.left_out_rms = errors.rms;
  }
}

void summarize(const CalibrationSpec& spec, Calibration& out) {
  std::vector<double> fitted, left_out, left_out_beyond, checked, checked_beyond;
  for (const CalibratedShape& shape : out.shapes) {
    const bool inside = shape.beyond.empty();
    if (shape.check_only) {
      if (std::isfinite(shape.tip_error)) (inside ? checked : checked_beyond).push_back(shape.tip_error);
      continue;
    }
    fitted.push_back(shape.tip_error);
    if (std::isfinite(shape.left_out_tip_error)) {
      (inside ? left_out : left_out_beyond).push_back(shape.left_out_tip_error);
    }
  }
  const auto beyond_count = static_cast<int>(checked_beyond.size());
  out.fitted = tip_errors(std::move(fitted));
  out.left_out = tip_errors(std::move(left_out));
  out.left_out_beyond = tip_errors(std::move(left_out_beyond));
  out.checked = tip_errors(std::move(checked));
  out.checked_beyond = tip_errors(std::move(checked_beyond));
  if (beyond_count > 0) {
    out.warnings.push_back(std::to_string(beyond_count) +
                           " of the recordings that are only checked lie beyond the loads that were fitted");
  }
  if (spec.robust && out.noise_estimated) {
    out.warnings.push_back("the errors hold for noise that is normal but for single points, as the robust loss has it");
  }
}

}  // namespace tendril
