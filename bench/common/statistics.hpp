#pragma once

#include <vector>

namespace tendril::bench {

/// Times within this factor are one class: the spread of a busy machine.
inline constexpr double same_class = 1.5;

/// Objectives that differ by less are the same: relative, and of this share of their scale, the largest weight of a
/// scene, where they are smaller.
inline constexpr double same_objective = 1e-6;
double margin_of(double objective, double scale = 1.0);

/// The p-quantile, 0 <= p <= 1, interpolated linearly between order statistics. NaN of no values. Infinite values are
/// larger than all others.
double quantile(std::vector<double> values, double p);
double median(std::vector<double> values);
double mean(const std::vector<double>& values);  ///< NaN of no values

struct Quartiles {
  double low = 0.0, median = 0.0, high = 0.0;
};
Quartiles quartiles(const std::vector<double>& values);

/// A least-squares line y = intercept + slope x.
struct Line {
  double slope = 0.0, intercept = 0.0;
  double determination = 0.0;  ///< R^2: 1 where the points lie on a line
  int points = 0;              ///< fewer than 2 with different x: slope and intercept are NaN
};
Line fit_line(const std::vector<double>& x, const std::vector<double>& y);

/// y = c x^slope, by a line through the logarithms. Points that are not positive and finite are left out.
Line fit_power(const std::vector<double>& x, const std::vector<double>& y);
/// y = c 10^(slope x), likewise.
Line fit_exponential(const std::vector<double>& x, const std::vector<double>& y);

/// exp(mean(log(value + shift))) - shift: small values, which are mostly overhead, do not decide (Mittelmann).
double shifted_geometric_mean(const std::vector<double>& values, double shift);

/// Performance profile (Dolan and More 2002): `cost[contestant][program]`, infinity where it failed. Row c of the
/// result holds the ratios of contestant c to the cheapest on each program, ascending; infinity where it failed. A
/// program that nobody solved gives infinity to all.
std::vector<std::vector<double>> performance_ratios(const std::vector<std::vector<double>>& cost);
/// The share of programs whose ratio is at most `factor`.
double share_within(const std::vector<double>& ratios, double factor);

/// Ranks by `cost`, 1 for the least. Costs within `tie` (>= 1) of the first of their class share that class, in which
/// `second` decides: times of the same order are not a difference worth a rank. Equal in both: order of the input.
std::vector<int> ranks(const std::vector<double>& cost, const std::vector<double>& second, double tie);

}  // namespace tendril::bench
