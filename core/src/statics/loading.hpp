#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "statics/descent.hpp"
#include "statics/load_path.hpp"
#include "statics/tracker.hpp"

namespace tendril {

/// A rod that is loaded from a start to given moments: where it comes to rest, by the stable equilibria in between.
/// Obstacles that the start overlaps grow from nothing together with the loads. With `holds_lengths` it is the
/// shortenings of tendons told their length that are given, as in LoadPath::Ends; from a rest these begin taut without
/// tension.
class Loading {
 public:
  /// What is held: moments (EI/L) or shortenings, one per actuator, and where the rod was moved to (Rod::moves).
  struct Held {
    std::vector<double> moments, moves;
    bool operator==(const Held&) const = default;
  };
  /// From a constant curvature, which moments hold without any other load; all loads then grow.
  Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, double curvature, const Held& held,
          std::function<bool()> must_stop, bool holds_lengths = false);
  /// From an earlier state that holds `first` under all other loads; only what is held then changes.
  Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, State earlier, const Held& first,
          const Held& last, std::function<bool()> must_stop, bool holds_lengths = false);
  /// From a shape that no loads are known to hold: it is let go under all loads.
  Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, Curvature shape, const Held& held,
          std::function<bool()> must_stop, bool holds_lengths = false);
  Loading(const Loading&) = delete;
  Loading& operator=(const Loading&) = delete;

  /// Contact forces, normal to the surface at the start, get a tangential part on the way: in the end so much for each
  /// unit of the normal part, one number per obstacle. `first`: what they have of it at the start; empty: nothing.
  void rub(const std::vector<double>& friction, const std::vector<double>& first = {});
  /// Contacts stick and slip instead, at one coefficient of friction per obstacle; not with obstacles that grow.
  void roughen(const std::vector<double>& coefficients);

  /// The obstacle whose core the start runs through, so that it lies on neither side: nothing can be said then.
  std::optional<std::size_t> without_side() const { return without_side_; }
  /// Obstacles that the start lies inside of by more than rounding: they grow, or a wall comes up, with the loads.
  struct Overlap {
    std::size_t obstacle = 0;
    double depth = 0.0;  ///< L
  };
  const std::vector<Overlap>& overlaps() const { return overlaps_; }
  /// Follows the path; whether the final loads were reached.
  bool run();

  /// Where no point contact held the rod on the way: carried on to the final loads with a run of contacts that stands
  /// for the stretch along which it lies.
  struct Lying {
    Descent down;
    double first = 1.0, last = 0.0;  ///< of the stretch, s/L
  };
  /// Nothing: it does not come to rest so, or stands on points again, and how it came to that is not known.
  std::optional<Lying> lie();

  Tracker& tracker() { return tracker_; }
  const LoadPath& path() const { return path_; }

 private:
  struct Set {
    LoadPath path;
    State start;
    Tracker::Start from = Tracker::Start::near;
    bool moves = true;  ///< something changes along the path
  };
  Loading(Set set, const std::vector<const Obstacle*>& obstacles, std::function<bool()> must_stop);
  static Set set_from_rest(Rod rod, const std::vector<const Obstacle*>& obstacles, double curvature, const Held& held,
                           bool holds_lengths);
  void draw_tendons();
  void grow_overlapped(const std::vector<const Obstacle*>& obstacles);

  LoadPath path_;
  State start_;
  Tracker::Start from_;
  bool moves_;
  std::vector<Overlap> overlaps_;
  std::optional<std::size_t> without_side_;
  std::function<bool()> must_stop_;
  Tracker tracker_;
};

}  // namespace tendril
