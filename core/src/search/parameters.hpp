#pragma once

#include <string>
#include <vector>

#include "tendril/export.hpp"

/// Every number that steers the search, and every strategy that can be left out: type, name, value, meaning. They
/// decide how a plan is found, never whether it is accepted. What each is worth stands in docs/search.md.
#define TENDRIL_SEARCH_PARAMETERS(X)                                                                                 \
  X(int, most_starts, 5, "starts per way of being in contact before a program may be called infeasible")             \
  X(int, further_starts, 2, "starts per way where all of these led to no plan")                                      \
  X(int, spread_starts, 5, "starts per way, to see whether a contact spreads")                                       \
  X(double, much_work, 2e6, "work without a plan: the search hurries")                                               \
  X(int, looks_at_a_rest, 4000, "steps that the rod may take to a rest; few need more than 400")                     \
  X(bool, sides, true, "starts on every side of every obstacle")                                                     \
  X(int, most_sides, 6, "starts on further sides for one way of being in contact")                                   \
  X(int, outline_steps, 40, "points of a shape that is only looked at")                                              \
  X(int, arcs_of_one, 33, "shapes of one arc")                                                                       \
  X(double, widest_of_one, 3.2, "largest angle of one arc, rad")                                                     \
  X(int, arcs_of_two, 13, "shapes of each of two arcs")                                                              \
  X(double, widest_of_two, 2.4, "largest angle of each of two arcs, rad")                                            \
  X(double, beside, 0.7, "sine of the angle between rod and obstacle from which on it passes beside it")             \
  X(double, cost_of_bend, 0.002, "of the square of the curvature, against the square of the distance to the target") \
  X(double, cost_of_depth, 2.0, "of the depth in an obstacle, against the same")                                     \
  X(double, cost_of_distance, 0.5, "of the distance to an obstacle that is to be touched, against the same")         \
  X(double, dearer, 1e-6, "a point that costs so much more than the plan is not completed (scaled objective)")       \
  X(bool, hold_cheaper, true, "points that cost less than the plan and are unstable compete as held plans")

namespace tendril {

struct SearchParameters {
#define TENDRIL_DECLARE(type, name, value, meaning) type name = value;
  TENDRIL_SEARCH_PARAMETERS(TENDRIL_DECLARE)
#undef TENDRIL_DECLARE
};

/// Those in force. Only the bench changes them, before it plans anything.
TENDRIL_API const SearchParameters& search_parameters();

/// One of them, in words.
struct SearchParameter {
  std::string name, value, meaning;
};
/// All of them as they are.
TENDRIL_API std::vector<SearchParameter> list_search_parameters();
/// Sets one. Throws Error for a name or a value that it does not know.
TENDRIL_API void set_search_parameter(const std::string& name, const std::string& value);

}  // namespace tendril
