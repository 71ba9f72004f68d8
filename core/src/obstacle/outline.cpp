#include "obstacle/outline.hpp"

#include <algorithm>

#include "tendril/numbers.hpp"

namespace tendril {

void spread_outline(const std::vector<Vec2>& corners, std::span<Vec2> points) {
  const std::size_t n = corners.size();
  if (n == 0 || points.size() < n) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = n == 0 ? Vec2{infinity, infinity} : corners[i * n / points.size()];
    }
    return;
  }
  std::vector<double> length;
  double around = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    length.push_back(norm(corners[(i + 1) % n] - corners[i]));
    around += length.back();
  }
  const std::size_t spare = points.size() - n;
  std::size_t at = 0;
  std::size_t spent = 0;
  double done = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    done += length[i];
    const std::size_t until =
        i + 1 == n || !(around > 0.0)
            ? spare
            : std::min(spare, static_cast<std::size_t>(static_cast<double>(spare) * done / around));
    const std::size_t own = until - spent;
    spent = until;
    for (std::size_t k = 0; k <= own; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(own + 1);
      points[at++] = corners[i] + t * (corners[(i + 1) % n] - corners[i]);
    }
  }
}

}  // namespace tendril
