#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "checks.hpp"
#include "difference.hpp"

namespace tendril::kit {

namespace {

struct Basis {
  Eigen::MatrixXd value, first, second;
};

Basis evaluate(const CoordinateModel& model, const std::vector<double>& sigma) {
  const auto rows = static_cast<Eigen::Index>(sigma.size());
  // Entries that the model leaves out show as NaN.
  const Eigen::MatrixXd unset =
      Eigen::MatrixXd::Constant(rows, model.function_count(), std::numeric_limits<double>::quiet_NaN());
  Basis basis{unset, unset, unset};
  model.evaluate(sigma, basis.value, basis.first, basis.second);
  return basis;
}

std::string function_at(int i, double sigma) {
  return "function " + std::to_string(i + 1) + " at sigma = " + shown(sigma);
}

std::vector<double> spread(int count) {
  std::vector<double> sigma(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) sigma[static_cast<std::size_t>(i)] = (i + 0.5) / count;
  return sigma;
}

void check_pieces(const CoordinateModel& model, Findings& findings) {
  double sum = 0.0;
  for (const double fraction : model.subdivision()) {
    findings.expect(fraction > 0.0, "subdivision", "found the fraction " + shown(fraction) + "; expected more than 0");
    sum += fraction;
  }
  // Fractions are quotients: one rounding each.
  findings.expect(std::abs(sum - 1.0) <= 1e-12, "subdivision",
                  "the fractions sum to " + shown(sum) + "; expected 1 (a model without pieces returns {1.0})");
  double last = 0.0;
  for (const double at : model.breaks()) {
    findings.expect(at > last && at < 1.0, "breaks",
                    "found " + shown(at) + " after " + shown(last) + "; expected ascending points inside (0, 1)");
    last = at;
  }
}

void check_values(const CoordinateModel& model, Findings& findings) {
  const std::vector<double> sigma{0.0, 0.2, 0.55, 1.0};
  const Basis together = evaluate(model, sigma);
  const std::vector<double> backwards(sigma.rbegin(), sigma.rend());
  const Basis reversed = evaluate(model, backwards);
  const auto last = static_cast<Eigen::Index>(sigma.size()) - 1;
  for (int i = 0; i < model.function_count(); ++i) {
    findings.expect(std::abs(together.value(0, i)) <= 1e-14, "begins at zero",
                    "function " + std::to_string(i + 1) + " is " + shown(together.value(0, i)) +
                        " at sigma = 0; expected 0, since the angle at the beginning of a piece belongs to the piece "
                        "before it: subtract the function's value at 0");
    for (Eigen::Index g = 0; g <= last; ++g) {
      const double at = sigma[static_cast<std::size_t>(g)];
      findings.expect(std::isfinite(together.value(g, i)) && std::isfinite(together.first(g, i)) &&
                          std::isfinite(together.second(g, i)),
                      "finite",
                      function_at(i, at) + ": found (" + shown(together.value(g, i)) + ", " +
                          shown(together.first(g, i)) + ", " + shown(together.second(g, i)) +
                          ") for value, first and second derivative; expected numbers. NaN also means that evaluate() "
                          "left an entry unwritten");
      findings.expect(together.value(g, i) == reversed.value(last - g, i), "order of points",
                      function_at(i, at) +
                          " differs between a call with ascending and one with descending sigma; expected each row to "
                          "depend on its own sigma alone");
    }
  }
}

void check_derivatives(const CoordinateModel& model, Findings& findings) {
  constexpr double h = 1e-3;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> inside(3 * h, 1.0 - 3 * h);
  const std::vector<double> breaks = model.breaks();
  const Basis all = evaluate(model, spread(50));
  for (int trial = 0; trial < 40; ++trial) {
    const double at = inside(random);
    bool near_break = false;
    for (const double knot : breaks) near_break = near_break || std::abs(at - knot) < 3 * h;
    if (near_break) continue;
    const Basis here = evaluate(model, {at});
    for (int i = 0; i < model.function_count(); ++i) {
      const Difference first = difference([&](double s) { return evaluate(model, {s}).value(0, i); }, at, h);
      const Difference second = difference([&](double s) { return evaluate(model, {s}).first(0, i); }, at, h);
      const auto say = [&](double stated, const Difference& found, const char* of) {
        return function_at(i, at) + ": stated " + shown(stated) + ", but differences of its " + of + " give " +
               shown(found.value);
      };
      findings.expect(agrees(here.first(0, i), first, all.first.col(i).lpNorm<Eigen::Infinity>()), "first derivative",
                      say(here.first(0, i), first, "value"));
      findings.expect(agrees(here.second(0, i), second, all.second.col(i).lpNorm<Eigen::Infinity>()),
                      "second derivative",
                      say(here.second(0, i), second, "first derivative") +
                          " (at a knot of reduced smoothness, add the knot to breaks())");
    }
  }
  for (const double knot : breaks) {
    constexpr double near = 1e-9;
    const Basis sides = evaluate(model, {knot - near, knot + near});
    for (int i = 0; i < model.function_count(); ++i) {
      const double jump = sides.value(1, i) - sides.value(0, i);
      const double slope = all.first.col(i).lpNorm<Eigen::Infinity>();
      findings.expect(std::abs(jump) <= 1e-12 + 4.0 * near * slope, "continuous angle",
                      function_at(i, knot) + " jumps by " + shown(jump) + "; expected an angle without jumps");
    }
  }
}

/// Two coordinates that do the same leave the solver a choice without meaning.
void check_independence(const CoordinateModel& model, Findings& findings) {
  const Eigen::MatrixXd slopes = evaluate(model, spread(4 * model.function_count() + 20)).first;
  if (!slopes.allFinite()) return;
  Eigen::MatrixXd scaled = slopes;
  for (int i = 0; i < model.function_count(); ++i) {
    const double size = slopes.col(i).norm();
    findings.expect(size > 0.0, "independent functions",
                    "function " + std::to_string(i + 1) + " is zero everywhere; expected one that bends the rod");
    if (size > 0.0) scaled.col(i) /= size;
  }
  const Eigen::VectorXd singular = scaled.jacobiSvd().singularValues();
  // Below this, moments that differ by rounding give shapes that differ visibly.
  constexpr double least = 1e-11;
  findings.expect(singular[singular.size() - 1] > least * singular[0], "independent functions",
                  "some combination of the functions vanishes (smallest singular value of their slopes " +
                      shown(singular[singular.size() - 1] / singular[0]) +
                      " of the largest); expected functions that are linearly independent and not nearly equal");
}

struct KnownShape {
  const char* name;
  std::function<double(double)> angle;
};

/// Largest error of the angle when `shape` is fitted on `pieces` equal pieces, by least squares.
double fit_error(const CoordinateModel& model, const KnownShape& shape, int pieces) {
  const int functions = model.function_count();
  const std::vector<double> sigma = spread(3 * functions + 8);
  const Basis basis = evaluate(model, sigma);
  const Basis end = evaluate(model, {1.0});
  const auto points = static_cast<Eigen::Index>(sigma.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(pieces * points, pieces * functions);
  Eigen::VectorXd angle(pieces * points);
  for (Eigen::Index piece = 0; piece < pieces; ++piece) {
    for (Eigen::Index g = 0; g < points; ++g) {
      const Eigen::Index row = piece * points + g;
      angle[row] = shape.angle((static_cast<double>(piece) + sigma[static_cast<std::size_t>(g)]) / pieces);
      for (Eigen::Index before = 0; before < piece; ++before) {
        matrix.block(row, before * functions, 1, functions) = end.value;
      }
      matrix.block(row, piece * functions, 1, functions) = basis.value.row(g);
    }
  }
  const Eigen::VectorXd q = matrix.colPivHouseholderQr().solve(angle);
  return (matrix * q - angle).lpNorm<Eigen::Infinity>();
}

void check_completeness(const CoordinateModel& model, Findings& findings) {
  constexpr double pi = std::numbers::pi;
  const KnownShape shapes[] = {{"a rod of constant curvature", [](double s) { return 0.7 * s; }},
                               {"a clothoid (curvature that grows linearly)", [](double s) { return s * s; }},
                               {"an S (curvature cos(pi s))", [](double s) { return std::sin(pi * s) / pi; }}};
  for (const KnownShape& shape : shapes) {
    constexpr int few = 2;
    constexpr int many = 8;
    const double coarse = fit_error(model, shape, few);
    const double fine = fit_error(model, shape, many);
    // A basis that holds a straight line only converges with the first power of the length: fourfold here.
    findings.expect(fine <= 1e-9 || fine <= coarse / 3.0, "completeness",
                    std::string("the angle of ") + shape.name + " is off by " + shown(coarse) + " rad on " +
                        std::to_string(few) + " pieces and by " + shown(fine) + " rad on " + std::to_string(many) +
                        "; expected an error that shrinks with the pieces: some combination of the functions must come "
                        "near to the straight line sigma, which turns the rod steadily");
  }
}

}  // namespace

void check_coordinates(const CoordinateModel& model, Findings& findings) {
  findings.expect(model.function_count() >= 1, "function_count",
                  "found " + std::to_string(model.function_count()) + "; expected at least 1");
  if (model.function_count() < 1) return;
  check_pieces(model, findings);
  check_values(model, findings);
  check_derivatives(model, findings);
  check_independence(model, findings);
  check_completeness(model, findings);
}

}  // namespace tendril::kit
