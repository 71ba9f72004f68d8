#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

struct Box {
  Vec2 low{infinity, infinity}, high{-infinity, -infinity};
  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  void add(const Box& box) {
    add(box.low);
    add(box.high);
  }
  bool meets(const Box& other, double reach) const {
    return low.x <= other.high.x + reach && other.low.x <= high.x + reach && low.y <= other.high.y + reach &&
           other.low.y <= high.y + reach;
  }
  bool holds(Vec2 p) const { return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y; }
  /// Square of the distance to a point.
  double square_to(Vec2 p) const {
    const double x = std::max({0.0, low.x - p.x, p.x - high.x});
    const double y = std::max({0.0, low.y - p.y, p.y - high.y});
    return x * x + y * y;
  }
};

/// Finds what is near a point among many things without a look at the others.
class BoxTree {
 public:
  /// One box per thing.
  explicit BoxTree(const std::vector<Box>& boxes) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(boxes.size() + 1);
    if (!boxes.empty()) build(boxes, 0, boxes.size());
  }

  /// Calls visit(thing, best) for every thing that may be nearer to `point` than the root of `best`, the square of the
  /// least distance so far, which visit() lowers. Allocates nothing.
  template <class Visit>
  void nearest(Vec2 point, double best, Visit&& visit) const {
    std::array<std::size_t, most_levels> open;
    std::size_t count = 0;
    if (!nodes_.empty()) open[count++] = 0;
    while (count > 0) {
      const Node& node = nodes_[open[--count]];
      if (node.box.square_to(point) > best) continue;
      if (node.right == 0) {
        for (std::size_t i = node.begin; i < node.end; ++i) visit(order_[i], best);
        continue;
      }
      const auto left = static_cast<std::size_t>(&node - nodes_.data()) + 1;
      const bool left_first = nodes_[left].box.square_to(point) < nodes_[node.right].box.square_to(point);
      open[count++] = left_first ? node.right : left;
      open[count++] = left_first ? left : node.right;
    }
  }

 private:
  static constexpr std::size_t most_levels = 64;  ///< halves of what fits into memory are fewer
  static constexpr std::size_t leaf = 4;
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;
    std::size_t right = 0;  ///< 0: a leaf; the left one is the next
  };

  void build(const std::vector<Box>& boxes, std::size_t begin, std::size_t end) {
    const std::size_t at = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Box whole;
    Box middles;
    const auto middle = [&](int i) {
      const Box& box = boxes[static_cast<std::size_t>(i)];
      return 0.5 * (box.low + box.high);
    };
    for (std::size_t i = begin; i < end; ++i) {
      whole.add(boxes[static_cast<std::size_t>(order_[i])]);
      middles.add(middle(order_[i]));
    }
    nodes_[at].box = whole;
    if (end - begin <= leaf) return;
    const bool wide = middles.high.x - middles.low.x > middles.high.y - middles.low.y;
    const std::size_t half = begin + (end - begin) / 2;
    const auto first = order_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(half),
                     first + static_cast<std::ptrdiff_t>(end),
                     [&](int a, int b) { return wide ? middle(a).x < middle(b).x : middle(a).y < middle(b).y; });
    build(boxes, begin, half);
    nodes_[at].right = nodes_.size();
    build(boxes, half, end);
  }

  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace tendril
