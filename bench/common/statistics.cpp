#include "common/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tendril::bench {

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

template <class X>
Line fit_logarithm(const std::vector<double>& x, const std::vector<double>& y, X transformed) {
  std::vector<double> a, b;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = transformed(x[i]);
    if (!std::isfinite(t) || !(y[i] > 0.0) || !std::isfinite(y[i])) continue;
    a.push_back(t);
    b.push_back(std::log10(y[i]));
  }
  return fit_line(a, b);
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return undefined;
  std::sort(values.begin(), values.end());
  const double place = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const double part = place - static_cast<double>(below);
  if (part == 0.0 || below + 1 == values.size()) return values[below];
  return values[below] + part * (values[below + 1] - values[below]);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double margin_of(double objective, double scale) {
  return same_objective * std::max(std::abs(objective), same_objective * scale);
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

Quartiles quartiles(const std::vector<double>& values) {
  return {quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75)};
}

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  Line line{undefined, undefined, undefined, static_cast<int>(x.size())};
  if (x.size() < 2) return line;
  const auto n = static_cast<double>(x.size());
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  if (xx == 0.0) return line;
  line.slope = xy / xx;
  line.intercept = mean_y - line.slope * mean_x;
  line.determination = yy > 0.0 ? xy * xy / (xx * yy) : 1.0;
  return line;
}

Line fit_power(const std::vector<double>& x, const std::vector<double>& y) {
  return fit_logarithm(x, y, [](double v) { return v > 0.0 ? std::log10(v) : undefined; });
}

Line fit_exponential(const std::vector<double>& x, const std::vector<double>& y) {
  return fit_logarithm(x, y, [](double v) { return v; });
}

double shifted_geometric_mean(const std::vector<double>& values, double shift) {
  if (values.empty()) return undefined;
  double sum = 0.0;
  for (const double v : values) sum += std::log(v + shift);
  return std::exp(sum / static_cast<double>(values.size())) - shift;
}

std::vector<std::vector<double>> performance_ratios(const std::vector<std::vector<double>>& cost) {
  std::vector<std::vector<double>> ratios = cost;
  const std::size_t programs = cost.empty() ? 0 : cost.front().size();
  for (std::size_t p = 0; p < programs; ++p) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& row : cost) best = std::min(best, row[p]);
    for (auto& row : ratios) {
      row[p] = std::isfinite(row[p]) ? row[p] / best : std::numeric_limits<double>::infinity();
    }
  }
  for (auto& row : ratios) std::sort(row.begin(), row.end());
  return ratios;
}

double share_within(const std::vector<double>& ratios, double factor) {
  if (ratios.empty()) return undefined;
  const auto within = std::count_if(ratios.begin(), ratios.end(), [&](double r) { return r <= factor; });
  return static_cast<double>(within) / static_cast<double>(ratios.size());
}

std::vector<int> ranks(const std::vector<double>& cost, const std::vector<double>& second, double tie) {
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cost[a] < cost[b]; });
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && cost[order[end]] <= tie * cost[order[begin]]) ++end;
    std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin), order.begin() + static_cast<std::ptrdiff_t>(end),
              [&](std::size_t a, std::size_t b) { return second[a] != second[b] ? second[a] < second[b] : a < b; });
    begin = end;
  }
  std::vector<int> rank(cost.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<int>(i) + 1;
  return rank;
}

}  // namespace tendril::bench
