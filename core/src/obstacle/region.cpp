#include "obstacle/region.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "obstacle/box_tree.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Shares of the whole size: points that count as one, and how far beside a side is looked for what lies there.
constexpr double same_point = 1e-10, beside = 1e-8;

Box box_of(const ClosedLine& line) {
  Box box;
  for (const Vec2 p : line) box.add(p);
  return box;
}

/// On which side of the line through a and b a point lies: > 0, on the left.
double side(Vec2 a, Vec2 b, Vec2 p) { return cross(b - a, p - a); }

/// Whether p lies on the stretch from a to b, up to `reach`.
bool lies_on(Vec2 a, Vec2 b, Vec2 p, double reach) {
  const double length = norm(b - a);
  const double along = dot(p - a, b - a) / length;
  return along >= -reach && along <= length + reach && std::abs(side(a, b, p)) <= reach * length;
}

bool meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  return cross_inside(a, b, c, d) || lies_on(a, b, c, 0.0) || lies_on(a, b, d, 0.0) || lies_on(c, d, a, 0.0) ||
         lies_on(c, d, b, 0.0);
}

/// Points by number: those nearer to each other than the reach share one.
class Points {
 public:
  explicit Points(double reach) : reach_(reach) {}
  int number_of(Vec2 p) {
    const auto column = static_cast<long long>(std::floor(p.x / reach_));
    const auto row = static_cast<long long>(std::floor(p.y / reach_));
    for (long long i = column - 1; i <= column + 1; ++i) {
      for (long long j = row - 1; j <= row + 1; ++j) {
        const auto known = cells_.find({i, j});
        if (known != cells_.end() && norm(at_[static_cast<std::size_t>(known->second)] - p) <= reach_) {
          return known->second;
        }
      }
    }
    const auto number = static_cast<int>(at_.size());
    at_.push_back(p);
    cells_.emplace(std::pair{column, row}, number);
    return number;
  }
  Vec2 operator[](int number) const { return at_[static_cast<std::size_t>(number)]; }

 private:
  double reach_;
  std::vector<Vec2> at_;
  std::map<std::pair<long long, long long>, int> cells_;
};

/// All lines as sides between numbered points, cut where they meet others, and what of them bounds the whole.
class Arrangement {
 public:
  Arrangement(const std::vector<ClosedLine>& bodies, const std::vector<ClosedLine>& holes, Overlap overlap, double size)
      : overlap_(overlap), size_(size), points_(same_point * size) {
    for (const ClosedLine& line : bodies) add(line, true);
    for (const ClosedLine& line : holes) add(line, false);
    cut();
  }

  std::vector<ClosedLine> boundary() {
    keep_bounding();
    std::vector<ClosedLine> lines;
    for (auto& [from, ends] : next_) {
      while (!ends.empty()) {
        ClosedLine line = walk(from);
        drop_straight(line);
        if (line.size() > 2) lines.push_back(std::move(line));
      }
    }
    return lines;
  }

 private:
  struct Body {
    ClosedLine line;
    Box box;
    bool solid = true;
  };
  struct Side {
    int from = 0, to = 0;
    Box box;
    std::vector<int> cuts{};
  };

  void add(const ClosedLine& line, bool solid) {
    bodies_.push_back({line, box_of(line), solid});
    for (std::size_t i = 0; i < line.size(); ++i) {
      Side s{points_.number_of(line[i]), points_.number_of(line[(i + 1) % line.size()]), {}};
      s.box.add(points_[s.from]);
      s.box.add(points_[s.to]);
      if (s.from != s.to) sides_.push_back(std::move(s));
    }
  }

  void cut() {
    const double reach = same_point * size_;
    for (std::size_t i = 0; i < sides_.size(); ++i) {
      Side& a = sides_[i];
      for (std::size_t k = i + 1; k < sides_.size(); ++k) {
        Side& b = sides_[k];
        if (!a.box.meets(b.box, reach)) continue;
        bool touch = false;
        const auto cut_at = [&](Side& whole, int end) {
          if (!lies_on(points_[whole.from], points_[whole.to], points_[end], reach)) return;
          whole.cuts.push_back(end);
          touch = true;
        };
        cut_at(a, b.from);
        cut_at(a, b.to);
        cut_at(b, a.from);
        cut_at(b, a.to);
        const Vec2 p = points_[a.from];
        const Vec2 along = points_[a.to] - p;
        const Vec2 q = points_[b.from];
        const Vec2 other = points_[b.to] - q;
        if (touch || !cross_inside(p, p + along, q, q + other)) continue;
        const int at = points_.number_of(p + (cross(q - p, other) / cross(along, other)) * along);
        a.cuts.push_back(at);
        b.cuts.push_back(at);
      }
    }
  }

  bool solid(Vec2 p) const {
    int in = 0;
    for (const Body& body : bodies_) {
      if (!body.box.holds(p) || !lies_inside(body.line, p)) continue;
      if (!body.solid && overlap_ == Overlap::cut) return false;
      in += body.solid ? 1 : -1;
    }
    return in > 0;
  }

  /// Stretches with the body on one side of them only, turned to have it on their left.
  void keep_bounding() {
    std::set<std::pair<int, int>> kept;
    for (Side& s : sides_) {
      const Vec2 start = points_[s.from];
      const Vec2 along = points_[s.to] - start;
      s.cuts.push_back(s.from);
      s.cuts.push_back(s.to);
      std::sort(s.cuts.begin(), s.cuts.end(),
                [&](int a, int b) { return dot(points_[a] - start, along) < dot(points_[b] - start, along); });
      for (std::size_t i = 1; i < s.cuts.size(); ++i) {
        const int from = s.cuts[i - 1];
        const int to = s.cuts[i];
        if (from == to) continue;
        const Vec2 middle = 0.5 * (points_[from] + points_[to]);
        const Vec2 left = (beside * size_ / norm(along)) * turned(along);
        const bool on_left = solid(middle + left);
        const bool on_right = solid(middle - left);
        if (on_left == on_right) continue;
        const std::pair<int, int> stretch = on_left ? std::pair{from, to} : std::pair{to, from};
        if (kept.insert(stretch).second) next_[stretch.first].push_back(stretch.second);
      }
    }
  }

  ClosedLine walk(int first) {
    ClosedLine line{points_[first]};
    const int second = next_[first].front();
    int before = first;
    int at = second;
    for (;;) {
      std::vector<int>& ends = next_[at];
      if (ends.empty()) {
        throw Error("the outlines of an obstacle come so near to each other that they cannot be told apart");
      }
      // Where bodies meet in a point, the boundary goes on along its own: the first side clockwise from where it came.
      const Vec2 back = points_[before] - points_[at];
      const auto clockwise = [&](int end) {
        const Vec2 out = points_[end] - points_[at];
        const double angle = std::atan2(-cross(back, out), dot(back, out));
        return angle > 0.0 ? angle : angle + 2.0 * std::numbers::pi;
      };
      const auto chosen =
          std::min_element(ends.begin(), ends.end(), [&](int a, int b) { return clockwise(a) < clockwise(b); });
      const int next = *chosen;
      ends.erase(chosen);
      if (at == first && next == second) return line;
      line.push_back(points_[at]);
      before = at;
      at = next;
    }
  }

  void drop_straight(ClosedLine& line) const {
    ClosedLine corners;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec2 before = corners.empty() ? line.back() : corners.back();
      const Vec2 after = line[(i + 1) % line.size()];
      if (!lies_on(before, after, line[i], same_point * size_)) corners.push_back(line[i]);
    }
    line = std::move(corners);
  }

  Overlap overlap_;
  double size_;
  Points points_;
  std::vector<Body> bodies_;
  std::vector<Side> sides_;
  std::map<int, std::vector<int>> next_;
};

}  // namespace

double twice_area(const ClosedLine& line) {
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) area += cross(line[i] - line[0], line[i + 1] - line[0]);
  return area;
}

std::optional<LineFault> fault_of(const ClosedLine& line, std::size_t first) {
  const std::size_t n = line.size();
  if (n < 3) return LineFault{std::to_string(n) + " vertices", "at least 3"};
  const auto vertex = [&](std::size_t i) { return "vertex " + std::to_string(first + i % n); };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 before = line[i] - line[(i + n - 1) % n];
    const Vec2 after = line[(i + 1) % n] - line[i];
    if (!(norm(after) > 0.0)) {
      return LineFault{vertex(i) + " twice in a row", "vertices that differ; the first one is not repeated at the end"};
    }
    if (std::abs(cross(before, after)) <= 1e-12 * norm(before) * norm(after) && dot(before, after) < 0.0) {
      return LineFault{vertex(i) + ", at which the outline turns back on itself", "sides that do not overlap"};
    }
  }
  std::vector<Box> boxes(n);
  for (std::size_t i = 0; i < n; ++i) {
    boxes[i].add(line[i]);
    boxes[i].add(line[(i + 1) % n]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 2; k < n; ++k) {
      if ((k + 1) % n == i || !boxes[i].meets(boxes[k], 0.0)) continue;
      if (!meet(line[i], line[i + 1], line[k], line[(k + 1) % n])) continue;
      return LineFault{
          "sides that cross or meet: from " + vertex(i) + " to the next, and from " + vertex(k) + " to the next",
          "an outline that does not cross itself"};
    }
  }
  const Box box = box_of(line);
  if (std::abs(twice_area(line)) <= 1e-12 * dot(box.high - box.low, box.high - box.low)) {
    return LineFault{"an outline from " + vertex(0) + " on without area", "a body"};
  }
  return std::nullopt;
}

std::vector<ClosedLine> boundary_of(const std::vector<ClosedLine>& bodies, const std::vector<ClosedLine>& holes,
                                    Overlap overlap) {
  Box all;
  for (const ClosedLine& line : bodies) {
    for (const Vec2 p : line) all.add(p);
  }
  if (bodies.empty()) return {};
  return Arrangement(bodies, holes, overlap, norm(all.high - all.low)).boundary();
}

}  // namespace tendril
