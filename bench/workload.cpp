#include "workload.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tendril/error.hpp"

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
      const Vec2 away = Vec2{p[1], p[2]} - reference;
      if (norm(away) >= nearest) continue;
      nearest = norm(away);
      side = cross({std::cos(p[3]), std::sin(p[3])}, away);
    }
    text += side >= 0.0 ? '+' : '-';
  }
  return text;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace tendril::bench
