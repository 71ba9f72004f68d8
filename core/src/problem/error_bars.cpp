#include <algorithm>
#include <cmath>

#include "tendril/numbers.hpp"
#include "tendril/sensitivity.hpp"

namespace tendril {
namespace {

/// A margin of stability that inputs move by a third of itself, one standard deviation, may be lost.
constexpr double safe_deviations = 3.0;

/// A number's column times what moves it.
struct Moved {
  std::vector<double> rates;  ///< of the quantities, and of the margin of stability last
  std::vector<Vec2> shape;
  std::string trouble;
};

Moved moved_by(const Sensitivity& sensitivity, const Spread& spread) {
  Moved out;
  out.rates.resize(sensitivity.quantities.size() + 1);
  out.shape.resize(sensitivity.arc_lengths.size());
  for (const Spread::Part& part : spread.parts) {
    const Sensitivity::Column* column = sensitivity.find(part.key);
    if (column == nullptr || !column->trouble.empty()) {
      out.trouble = "by '" + spread.key + "' nothing is differentiated: " +
                    (column == nullptr ? "it moves nothing that is known" : column->trouble);
      return out;
    }
    const double by = part.rate * spread.deviation;
    for (std::size_t i = 0; i < column->rates.size(); ++i) out.rates[i] += by * column->rates[i];
    for (std::size_t i = 0; i < out.shape.size(); ++i) out.shape[i] += by * column->shape[i];
    out.rates.back() += by * column->margin;
  }
  return out;
}

/// What moves together with each input, itself and what is correlated with it by its correlation.
std::vector<Moved> together(const std::vector<Moved>& moved, const std::vector<Spread>& spreads) {
  std::vector<Moved> out = moved;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    for (std::size_t j = 0; j < moved.size(); ++j) {
      const auto found = spreads[k].correlations.find(spreads[j].key);
      if (j == k || found == spreads[k].correlations.end()) continue;
      const double part = found->second;
      for (std::size_t i = 0; i < out[k].rates.size(); ++i) out[k].rates[i] += part * moved[j].rates[i];
      for (std::size_t i = 0; i < out[k].shape.size(); ++i) out[k].shape[i] += part * moved[j].shape[i];
    }
  }
  return out;
}

double share_of(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

}  // namespace

Uncertainty uncertainty_of(const Sensitivity& sensitivity, const std::vector<Spread>& spreads) {
  Uncertainty out;
  out.kind = sensitivity.kind;
  out.trouble = sensitivity.trouble;
  if (!out.trouble.empty()) return out;
  std::vector<Moved> moved;
  for (const Spread& spread : spreads) {
    moved.push_back(moved_by(sensitivity, spread));
    out.trouble = moved.back().trouble;
    if (!out.trouble.empty()) return out;
  }
  std::vector<ResultQuantity> quantities = sensitivity.quantities;
  quantities.push_back({"stability", "", sensitivity.margin});
  std::vector<double> variance(quantities.size());
  const std::vector<Moved> with = together(moved, spreads);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    for (std::size_t i = 0; i < variance.size(); ++i) variance[i] += moved[k].rates[i] * with[k].rates[i];
  }
  // Inputs that cancel one another leave rounding.
  for (double& v : variance) v = std::max(0.0, v);
  for (std::size_t i = 0; i < variance.size(); ++i) {
    const ResultQuantity& q = quantities[i];
    out.deviations.push_back({q.name, q.unit, std::sqrt(variance[i])});
    if (!(safe_deviations * out.deviations.back().value >= q.value)) continue;
    const bool margin = i + 1 == variance.size();
    if (!margin && !q.name.ends_with(".force")) continue;
    out.warning += (out.warning.empty() ? "" : "; ") + (margin ? "the margin of stability" : q.name) + " is " +
                   shown(q.value, 3) + (margin ? "" : " N") + " +- " + shown(out.deviations.back().value, 3) +
                   (margin ? ": the robot may snap to another state" : ": the contact may come off") +
                   ", and these numbers hold only as long as it does not";
  }
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const auto part = [&](std::size_t i) { return moved[k].rates[i] * with[k].rates[i]; };
    Uncertainty::Share share;
    share.key = spreads[k].key;
    for (std::size_t i = 0; i < variance.size(); ++i) share.each.push_back(share_of(part(i), variance[i]));
    // The tip's place comes first.
    share.tip = share_of(part(0) + part(1), variance[0] + variance[1]);
    out.shares.push_back(std::move(share));
  }
  for (std::size_t i = 0; i < sensitivity.arc_lengths.size(); ++i) {
    Uncertainty::Point point;
    point.arc_length = sensitivity.arc_lengths[i];
    for (std::size_t k = 0; k < moved.size(); ++k) {
      point.xx += moved[k].shape[i].x * with[k].shape[i].x;
      point.xy += moved[k].shape[i].x * with[k].shape[i].y;
      point.yy += moved[k].shape[i].y * with[k].shape[i].y;
    }
    out.shape.push_back(point);
  }
  return out;
}

}  // namespace tendril
