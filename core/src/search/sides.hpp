#pragma once

#include <vector>

#include "search/task.hpp"

namespace tendril {

/// On which side of each obstacle a rod passes: 1, the obstacle lies to its left; -1, to its right; 2 and -2, the rod
/// ends before it with its tip on that side; 0, it has no sides (a wall), or is out of reach. A rod that runs through
/// an obstacle passes on the side with less of it.
using Sides = std::vector<int>;

/// Whether an obstacle has notches that a rod may go into: parts of its outline under a stretch of its convex hull that
/// is longer than a hundredth of the rod, or the base stands within the hull. Over narrower ones a contact slides.
TENDRIL_API bool has_pockets(const Obstacle& obstacle, Vec2 base);
/// Whether a rod can pass an obstacle on more than one side: it ends somewhere, and is within reach.
bool has_sides(const Task& task, std::size_t obstacle);
Sides sides_of(const Task& task, const StartShape& shape);

/// A simple shape to start from.
struct SideStart {
  StartShape shape;
  Sides sides;
  /// Of obstacles that are not convex: the patch that the shape comes nearest to, since one side of a window is not the
  /// other; of all others 0.
  std::vector<int> patches;
  std::vector<double> distances;  ///< of the shape to each obstacle, units of L; negative: it runs through
  Vec2 tip{};                     ///< of the shape, units of L
  double bend = 0.0;              ///< mean of its curvature squared
  double merit = 0.0;             ///< how far it is from the target and from being free; less is better
  double bent_at = 1.0;           ///< where a contact bends it in two, s/L; 1: it is not
  int number = -1;                ///< among the shapes of a task, whose own start is 0; -1: it is none of them
};

SideStart start_by_sides(const Task& task, StartShape shape);

/// Shapes of one or two arcs, the best one for each choice of sides (and patches) that such shapes can have, best
/// first. Which side a rod passes on is a discrete choice: no local method changes it. Empty: no obstacle within reach
/// has sides. `bent`: instead those that no moments but a contact may bend in two, a quarter or half along the rod;
/// none where moments do. What is seen of the shapes is kept in the task for the next target.
std::vector<SideStart> starts_by_sides(Task& task, bool bent = false);
/// Whether these are two or more.
bool several_sides(const Task& task);

}  // namespace tendril
