#include "tendril/calibrate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/deadline.hpp"
#include "calibrate/fit.hpp"
#include "calibrate/identifiability.hpp"
#include "estimate/plausibility.hpp"
#include "problem/calibrate_input.hpp"
#include "problem/calibrate_report.hpp"

namespace tendril {
namespace {

/// Orders of the Legendre functions per piece: the first one searches, each other one is tried until the markers stay
/// where they are (units of L).
constexpr int first_fit_order = 8;
constexpr int orders[] = {12, 18, 26};
constexpr double order_settled = 1e-7;
/// A fit has converged when the next step is this small, in standard deviations of the measured numbers: while starts
/// are still compared, and at the end.
constexpr double coarse_accuracy = 1e-2;
constexpr double calibrated_accuracy = 1e-5;
constexpr int most_search_steps = 40;
constexpr int most_steps = 100;
/// Starts that end within this part of the best sum of squares have found the same.
constexpr double same_sum = 1e-3;
/// Where so many starts have agreed the rest is left out.
constexpr int enough_agreed = 2;

/// The i-th number of Halton's sequence: spread evenly over (0, 1), the same on every machine.
double halton(int i, int base) {
  double out = 0.0;
  for (double share = 1.0 / base; i > 0; i /= base, share /= base) out += share * (i % base);
  return out;
}

Eigen::VectorXd start_values(const SoughtNumbers& problem, int start) {
  constexpr int primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29};
  constexpr double most_factor = 4.0;
  Eigen::VectorXd values(static_cast<Eigen::Index>(problem.unknowns.size()));
  for (std::size_t i = 0; i < problem.unknowns.size(); ++i) {
    const Sought& u = problem.unknowns[i];
    const double share = 2.0 * halton(start, primes[i % std::size(primes)]) - 1.0;
    const double value = start == 0          ? u.start
                         : is_factor(u.kind) ? u.start * std::pow(most_factor, share)
                                             : u.start + share * u.spread;
    values[static_cast<Eigen::Index>(i)] = std::clamp(value, u.lower, u.upper);
  }
  return values;
}

struct Found {
  CalibrationFit::Result result;
  int starts = 0, agreed = 0;
};

/// The best of several starts. That of the scene comes first; the others are there to tell whether it found another
/// valley.
Found search(const CalibrationInput& in, CalibrationFit& fit, int starts, const Deadline& deadline) {
  Found best;
  for (int i = 0; i < std::max(1, starts) && !deadline.over() && best.agreed < enough_agreed; ++i) {
    FittedPoint point = fit.at(start_values(in.problem, i), in.fitted, nullptr);
    ++best.starts;
    CalibrationFit::Result result = fit.fit(std::move(point), in.fitted, coarse_accuracy, most_search_steps);
    if (!result.point.found) continue;
    const double sum = result.point.sum;
    const double least = best.result.point.sum;
    const bool same = std::isfinite(least) && std::abs(sum - least) <= same_sum * least;
    if (same) ++best.agreed;
    if (sum < least) {
      if (!same) best.agreed = 1;
      best.result = std::move(result);
    }
  }
  return best;
}

/// Repeats the fit with more functions per piece until its markers stay.
struct Refined {
  std::unique_ptr<CalibrationFit> fit;
  CalibrationFit::Result result;
  int order = first_fit_order;
  double change = infinity;
};

Refined refine(const CalibrationInput& in, CalibrationFit::Result found, const Deadline& deadline, int& solves) {
  Refined out;
  out.result = std::move(found);
  for (const int order : orders) {
    auto fit = std::make_unique<CalibrationFit>(in.problem, order, in.turn, deadline);
    FittedPoint start = fit->at(out.result.point.values, in.fitted, nullptr);
    if (start.found) start.weights = out.result.point.weights;
    CalibrationFit::Result next = fit->fit(std::move(start), in.fitted, calibrated_accuracy, most_steps);
    solves += fit->solves();
    if (!next.point.found) return out;
    out.change = 0.0;
    for (const int s : in.fitted) {
      const auto i = static_cast<std::size_t>(s);
      out.change =
          std::max(out.change, (next.point.residuals[i] - out.result.point.residuals[i]).lpNorm<Eigen::Infinity>());
    }
    out.result = std::move(next);
    out.fit = std::move(fit);
    out.order = order;
    if (out.change <= order_settled || deadline.over()) break;
  }
  return out;
}

/// Which shapes are left out together.
std::vector<std::vector<int>> folds_of(const CalibrationInput& in, const CalibrationSpec& spec) {
  std::map<std::string, std::vector<int>> by_group;
  std::vector<std::vector<int>> folds;
  if (spec.fold_by_group) {
    for (const int s : in.fitted) by_group[spec.recordings[static_cast<std::size_t>(s)].group].push_back(s);
    for (auto& [group, shapes] : by_group) folds.push_back(std::move(shapes));
  } else {
    folds.resize(std::min<std::size_t>(static_cast<std::size_t>(std::max(0, spec.folds)), in.fitted.size()));
    for (std::size_t i = 0; i < in.fitted.size() && !folds.empty(); ++i) {
      folds[i % folds.size()].push_back(in.fitted[i]);
    }
  }
  if (folds.size() < 2) folds.clear();
  return folds;
}

/// Every shape predicted by what the others tell. Bases of a recording or group of its own are then as the scene has
/// them.
void cross_validate(const CalibrationInput& in, const CalibrationSpec& spec, Refined& refined, const Deadline& deadline,
                    Calibration& out) {
  const std::vector<std::vector<int>> folds = folds_of(in, spec);
  out.folds = static_cast<int>(folds.size());
  for (const std::vector<int>& left_out : folds) {
    std::vector<int> others;
    std::set_difference(in.fitted.begin(), in.fitted.end(), left_out.begin(), left_out.end(),
                        std::back_inserter(others));
    const int count = CalibrationFit::count(in.problem, others);
    if (count <= static_cast<int>(in.problem.unknowns.size()) || deadline.over()) continue;
    Eigen::VectorXd start = refined.result.point.values;
    for (const int s : left_out) {
      for (const int i : refined.fit->unknowns_of(s)) {
        const Sought& u = in.problem.unknowns[static_cast<std::size_t>(i)];
        const bool elsewhere = std::any_of(others.begin(), others.end(), [&](int o) {
          return in.problem.shapes[static_cast<std::size_t>(o)].group == u.group;
        });
        if (u.group >= 0 && !elsewhere) start[i] = u.start;
      }
    }
    FittedPoint point = refined.fit->at(start, others, &refined.result.point);
    const CalibrationFit::Result result =
        refined.fit->fit(std::move(point), others, coarse_accuracy, most_search_steps);
    if (!result.point.found) continue;
    const FittedPoint predicted = refined.fit->at(result.point.values, left_out, nullptr);
    report_predictions(in, predicted, left_out, others, out);
  }
}

/// A fit of shapes that are seen with other axes, if it explains so much more that the axes must be wrong.
std::string hint_of_axes(const CalibrationInput& in, const FittedPoint& found, const Deadline& deadline) {
  constexpr double misfit = 0.03;  // rms in L from which axes are doubted
  constexpr double far_better = 0.25;
  const auto rms = [&](const FittedPoint& p) {
    return std::sqrt(p.sum / std::max(1, CalibrationFit::count(in.problem, in.fitted)));
  };
  const double here = rms(found);
  if (!(here > misfit)) return "";
  for (const OtherAxes& axes : other_axes) {
    SoughtNumbers turned_axes = in.problem;
    for (SeenShape& shape : turned_axes.shapes) {
      for (SeenMarker& m : shape.markers) {
        m.position = in.problem.rod.base + axes.seen(m.position - in.problem.rod.base);
      }
    }
    CalibrationFit fit(turned_axes, first_fit_order, in.turn, deadline);
    FittedPoint start = fit.at(start_values(in.problem, 0), in.fitted, nullptr);
    const CalibrationFit::Result result = fit.fit(std::move(start), in.fitted, coarse_accuracy, most_search_steps);
    if (result.point.found && rms(result.point) < far_better * here) {
      return std::string("as if ") + axes.name + " the points are explained far better: are their axes right?";
    }
  }
  return "";
}

}  // namespace

std::string_view to_string(CalibrationStatus status) {
  switch (status) {
    case CalibrationStatus::solved:
      return "solved";
    case CalibrationStatus::not_identifiable:
      return "not_identifiable";
    case CalibrationStatus::not_converged:
      return "not_converged";
    case CalibrationStatus::time_limit:
      return "time_limit";
    case CalibrationStatus::interrupted:
      return "interrupted";
  }
  return "?";
}

Calibration calibrate(const Scene& scene, const CalibrationSpec& spec, const PlanControl& control) {
  const double begin = now();
  const CalibrationInput in(scene, spec);
  Calibration out;
  out.length = in.scale.length;
  out.warnings = in.warnings;
  out.numbers = in.numbers;
  const Deadline deadline(control.stop, scene.solver.time_limit);
  std::string hint;
  const auto finish = [&] {
    if (deadline.interrupted()) {
      out.status = CalibrationStatus::interrupted;
      out.message = "interrupted";
    } else if (deadline.over()) {
      out.status = CalibrationStatus::time_limit;
      out.message = "the time limit of " + shown(scene.solver.time_limit, 3) + " s was reached";
    }
    out.message += (out.message.empty() || hint.empty() ? "" : "; ") + hint;
    out.seconds = now() - begin;
    return out;
  };

  CalibrationFit coarse(in.problem, first_fit_order, in.turn, deadline);
  Found found = search(in, coarse, spec.starts, deadline);
  out.starts = found.starts;
  out.starts_agreed = found.agreed;
  out.solves = coarse.solves();
  if (!found.result.point.found) {
    out.message = "from no start had every recording a stable equilibrium: are the loads and their units right?";
    return finish();
  }
  // Shapes with wrong axes have no number that fits: what follows may take all the time.
  hint = hint_of_axes(in, found.result.point, deadline);
  Refined refined = refine(in, std::move(found.result), deadline, out.solves);
  if (!refined.fit) {
    out.message = "the fit did not converge with more functions per piece";
    return finish();
  }
  out.order = refined.order;
  out.model_error = refined.change * in.scale.length;
  report_numbers(in, *refined.fit, refined.result, out);
  report_shapes(in, scene, spec, *refined.fit, refined.result.point, out);
  cross_validate(in, spec, refined, deadline, out);
  summarize(spec, out);
  if (!refined.result.converged) {
    out.message =
        "the fit did not come to rest: are bounds or priors too tight, or unknowns beyond what the points show?";
  } else if (out.undetermined.empty()) {
    out.status = CalibrationStatus::solved;
  } else {
    out.status = CalibrationStatus::not_identifiable;
    out.message = "the points do not determine " + out.undetermined.front();
  }
  return finish();
}

}  // namespace tendril
