#include "scene/outline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <utility>

namespace tendril::app {

namespace {

double side(Vec2 a, Vec2 b, Vec2 p) { return cross(b - a, p - a); }

/// Whether the boxes around two stretches meet.
bool are_near(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  return std::max(a.x, b.x) >= std::min(c.x, d.x) && std::max(c.x, d.x) >= std::min(a.x, b.x) &&
         std::max(a.y, b.y) >= std::min(c.y, d.y) && std::max(c.y, d.y) >= std::min(a.y, b.y);
}

/// Whether two stretches have a point in common.
bool meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  return are_near(a, b, c, d) && side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0;
}

/// Whether a triangle that runs either way holds a point.
bool holds(Vec2 a, Vec2 b, Vec2 c, Vec2 p) {
  const double u = side(a, b, p);
  const double v = side(b, c, p);
  const double w = side(c, a, p);
  return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
}

/// Corners are taken away one by one, that first which costs least, each in exchange for a triangle that is added to
/// the body: a corner that turns inward is cut across, and a side between two that turn outward is left out where its
/// neighbours meet. How far each side has gone from the body that was given is summed up.
class Simplifier {
 public:
  Simplifier(const std::vector<Outline>& lines, double tolerance) : tolerance_(tolerance) {
    for (const Outline& line : lines) {
      const std::size_t first = corners_.size();
      firsts_.push_back(first);
      for (std::size_t i = 0; i < line.size(); ++i) {
        corners_.push_back({line[i], first + (i + line.size() - 1) % line.size(), first + (i + 1) % line.size()});
      }
      left_.push_back(line.size());
      line_of_.resize(corners_.size(), firsts_.size() - 1);
    }
  }

  std::vector<Outline> run() {
    for (std::size_t i = 0; i < corners_.size(); ++i) offer(i);
    while (!offers_.empty()) {
      const Offer best = offers_.top();
      offers_.pop();
      if (corners_[best.corner].stamp != best.stamp || left_[line_of_[best.corner]] <= 3) continue;
      const std::optional<Change> change = change_at(best.corner);
      if (change && is_free(best.corner, *change)) take(best.corner, *change);
    }
    std::vector<Outline> lines;
    for (std::size_t l = 0; l < firsts_.size(); ++l) {
      std::size_t i = firsts_[l];
      while (corners_[i].gone) ++i;
      Outline line;
      for (std::size_t k = 0; k < left_[l]; ++k, i = corners_[i].next) line.push_back(corners_[i].at);
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  struct Corner {
    Vec2 at{};
    std::size_t before = 0, next = 0;
    double away = 0.0;  ///< how far the side from here to the next has gone from the given body, at most
    int stamp = 0;      ///< rises whenever what an offer for it stands on changes
    bool gone = false;
  };
  struct Offer {
    double away = 0.0;
    std::size_t corner = 0;
    int stamp = 0;
    bool operator<(const Offer& other) const { return away > other.away; }
  };
  /// What comes instead of a corner, or of it and the next.
  struct Change {
    bool both = false;
    Vec2 tip{};  ///< where the neighbours of the side meet, if both go
    double away = 0.0;
  };

  bool outward(std::size_t i) const {
    const Corner& c = corners_[i];
    return side(corners_[c.before].at, c.at, corners_[c.next].at) > 0.0;
  }

  std::optional<Change> change_at(std::size_t i) const {
    const Corner& c = corners_[i];
    const Corner& before = corners_[c.before];
    const Corner& next = corners_[c.next];
    Change change;
    if (!outward(i)) {
      const double length = norm(next.at - before.at);
      if (!(length > 0.0)) return std::nullopt;
      change.away = std::max(before.away, c.away) + std::abs(side(before.at, next.at, c.at)) / length;
    } else {
      if (!outward(c.next)) return std::nullopt;
      const Vec2 forth = c.at - before.at;
      const Vec2 back = next.at - corners_[next.next].at;
      const double turn = cross(forth, -back);
      // The two sides have to turn by less than half a turn together.
      if (!(turn > 1e-12 * norm(forth) * norm(back))) return std::nullopt;
      change.both = true;
      change.tip = c.at + (cross(next.at - c.at, -back) / turn) * forth;
      const Vec2 along = next.at - c.at;
      const double t = std::clamp(dot(change.tip - c.at, along) / dot(along, along), 0.0, 1.0);
      change.away = std::max({before.away, next.away, c.away + norm(change.tip - c.at - t * along)});
    }
    if (!(change.away <= tolerance_)) return std::nullopt;
    return change;
  }

  /// Whether nothing of any outline lies in the triangle that is added.
  bool is_free(std::size_t i, const Change& change) const {
    const Corner& c = corners_[i];
    const Vec2 a = change.both ? c.at : corners_[c.before].at;
    const Vec2 b = change.both ? change.tip : c.at;
    const Vec2 d = corners_[c.next].at;
    const Vec2 low{std::min({a.x, b.x, d.x}), std::min({a.y, b.y, d.y})};
    const Vec2 high{std::max({a.x, b.x, d.x}), std::max({a.y, b.y, d.y})};
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      const Corner& other = corners_[k];
      if (other.gone) continue;
      const Vec2 next = corners_[other.next].at;
      if (std::max(other.at.x, next.x) < low.x || std::min(other.at.x, next.x) > high.x ||
          std::max(other.at.y, next.y) < low.y || std::min(other.at.y, next.y) > high.y) {
        continue;
      }
      const bool own = k == i || k == c.next || (!change.both && k == c.before);
      if (!own && holds(a, b, d, other.at)) return false;
      // Sides that begin or end at a corner of the triangle may touch it there.
      const bool touches = own || other.next == i || other.next == c.before || other.next == c.next;
      if (touches) continue;
      if (change.both ? meet(a, b, other.at, next) || meet(b, d, other.at, next) : meet(a, d, other.at, next))
        return false;
    }
    return true;
  }

  void take(std::size_t i, const Change& change) {
    Corner& c = corners_[i];
    Corner& before = corners_[c.before];
    Corner& next = corners_[c.next];
    if (change.both) {
      // The corner moves to the tip, and the next one goes.
      c.at = change.tip;
      c.away = std::max(next.away, change.away);
      before.away = std::max(before.away, change.away);
      c.next = next.next;
      corners_[next.next].before = i;
      next.gone = true;
    } else {
      before.next = c.next;
      before.away = change.away;
      next.before = c.before;
      c.gone = true;
    }
    --left_[line_of_[i]];
    std::size_t near = change.both ? i : c.before;
    for (int k = 0; k < 3; ++k) near = corners_[near].before;
    for (int k = 0; k < 6; ++k, near = corners_[near].next) {
      ++corners_[near].stamp;
      offer(near);
    }
    ++(change.both ? next : c).stamp;
  }

  void offer(std::size_t i) {
    if (const std::optional<Change> change = change_at(i)) offers_.push({change->away, i, corners_[i].stamp});
  }

  double tolerance_;
  std::vector<Corner> corners_;
  std::vector<std::size_t> firsts_, left_, line_of_;
  std::priority_queue<Offer> offers_;
};

}  // namespace

double twice_area(const Outline& line) {
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) area += cross(line[i] - line[0], line[i + 1] - line[0]);
  return area;
}

bool cross_each_other(const Outline& a, const Outline& b) {
  const auto corners = [](const Outline& line) {
    std::pair box{line.front(), line.front()};
    for (const Vec2 p : line) {
      box.first = {std::min(box.first.x, p.x), std::min(box.first.y, p.y)};
      box.second = {std::max(box.second.x, p.x), std::max(box.second.y, p.y)};
    }
    return box;
  };
  const auto [a_low, a_high] = corners(a);
  const auto [b_low, b_high] = corners(b);
  if (!are_near(a_low, a_high, b_low, b_high)) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 from = a[i];
    const Vec2 to = a[(i + 1) % a.size()];
    if (!are_near(from, to, b_low, b_high)) continue;
    for (std::size_t k = 0; k < b.size(); ++k) {
      const Vec2 c = b[k];
      const Vec2 d = b[(k + 1) % b.size()];
      if (side(from, to, c) * side(from, to, d) < 0.0 && side(c, d, from) * side(c, d, to) < 0.0) return true;
    }
  }
  return false;
}

std::vector<Outline> simplified(const std::vector<Outline>& lines, double tolerance) {
  if (!(tolerance > 0.0)) return lines;
  return Simplifier(lines, tolerance).run();
}

}  // namespace tendril::app
