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
  std::vector<double> rates;
  std::vector<Vec2> shape;
  double margin = 0.0;
  std::string trouble;
};

Moved moved_by(const Sensitivity& sensitivity, const Spread& spread) {
  Moved out;
  out.rates.resize(sensitivity.quantities.size());
  out.shape.resize(sensitivity.arc_lengths.size());
  for (const Spread::Part& part : spread.parts) {
    const Sensitivity::Column* column = sensitivity.find(part.key);
    if (column == nullptr || !column->trouble.empty()) {
      out.trouble = "by '" + spread.key + "' nothing is differentiated: " +
                    (column == nullptr ? "it moves nothing that is known" : column->trouble);
      return out;
    }
    const double by = part.rate * spread.deviation;
    for (std::size_t i = 0; i < out.rates.size(); ++i) out.rates[i] += by * column->rates[i];
    for (std::size_t i = 0; i < out.shape.size(); ++i) out.shape[i] += by * column->shape[i];
    out.margin += by * column->margin;
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
  std::vector<double> variance(sensitivity.quantities.size());
  double margin = 0.0;
  for (const Moved& m : moved) {
    for (std::size_t i = 0; i < variance.size(); ++i) variance[i] += m.rates[i] * m.rates[i];
    margin += m.margin * m.margin;
  }
  for (std::size_t i = 0; i < variance.size(); ++i) {
    const ResultQuantity& q = sensitivity.quantities[i];
    out.deviations.push_back({q.name, q.unit, std::sqrt(variance[i])});
  }
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const std::vector<double>& rates = moved[k].rates;
    Uncertainty::Share share;
    share.key = spreads[k].key;
    for (std::size_t i = 0; i < rates.size(); ++i) {
      share.each.push_back(share_of(rates[i] * rates[i], variance[i]));
    }
    // The tip's place comes first.
    share.tip = share_of(rates[0] * rates[0] + rates[1] * rates[1], variance[0] + variance[1]);
    out.shares.push_back(std::move(share));
  }
  for (std::size_t i = 0; i < sensitivity.arc_lengths.size(); ++i) {
    Uncertainty::Point point;
    point.arc_length = sensitivity.arc_lengths[i];
    for (const Moved& m : moved) {
      point.xx += m.shape[i].x * m.shape[i].x;
      point.xy += m.shape[i].x * m.shape[i].y;
      point.yy += m.shape[i].y * m.shape[i].y;
    }
    out.shape.push_back(point);
  }
  if (safe_deviations * std::sqrt(margin) >= sensitivity.margin) {
    out.warning = "the margin of stability is " + shown(sensitivity.margin, 3) + " +- " + shown(std::sqrt(margin), 3) +
                  ": the robot may snap to another state, and these numbers hold only as long as it does not";
  }
  return out;
}

}  // namespace tendril
