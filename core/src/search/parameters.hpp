#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tendril/export.hpp"

/// Every number that steers the search, and every strategy that can be left out: type, name, value, meaning. They
/// decide how a plan is found, never whether it is accepted. What each is worth stands in docs/search.md.
#define TENDRIL_SEARCH_PARAMETERS(X)                                                                                 \
  X(int, most_starts, 5, "starts per way of being in contact before a program may be called infeasible")             \
  X(int, further_starts, 2, "starts per way where all of these led to no plan")                                      \
  X(int, spread_starts, 5, "starts per way to see whether a contact spreads")                                        \
  X(double, much_work, 2e6, "work without a plan: the search hurries")                                               \
  X(int, looks_at_a_rest, 4000, "steps that the rod may take to a rest; few need more than 400")                     \
  X(bool, bound, true, "ways that cannot win by where their tip can be are tried last, or not at all")               \
  X(bool, sides, true, "starts on every side of every obstacle")                                                     \
  X(std::size_t, most_trials, 40, "starts on sides for all ways together, the most promising ones")                  \
  X(std::size_t, most_sides, 6, "starts on further sides for one way of being in contact")                           \
  X(double, side_work, 3e5, "work for all starts on sides before the ordinary search goes on")                       \
  X(int, thorough, 10, "times as many starts, and as much work for them, where the search is thorough")              \
  X(double, same_minimum, 1e-6, "difference of the objectives (relative) of two plans that count as one")            \
  X(double, there, 0.02, "distance to the target (rad, L) below which no other turn of the tip is tried")            \
  X(int, most_turns, 5, "angles of the tip, full turns apart, that a direction is tried for")                        \
  X(double, missed, 0.01, "distance to the target (L) from which on a plan says that it misses it")                  \
  X(int, outline_steps, 40, "points of a shape that is only looked at")                                              \
  X(int, arcs_of_one, 65, "shapes of one arc")                                                                       \
  X(double, widest_of_one, 6.4, "largest angle of one arc, rad")                                                     \
  X(int, arcs_of_two, 13, "shapes of each of two arcs")                                                              \
  X(double, widest_of_two, 2.4, "largest angle of each of two arcs, rad")                                            \
  X(bool, bent_at_contacts, true, "where the plan is off its target shapes that contacts bend in two are starts")    \
  X(double, beside, 0.7, "sine of the angle between rod and obstacle from which on it passes beside it")             \
  X(double, cost_of_bend, 0.002, "of the square of the curvature, against the square of the distance to the target") \
  X(double, cost_of_depth, 2.0, "of the depth in an obstacle, against the same")                                     \
  X(double, cost_of_distance, 0.5, "of the distance to an obstacle that is to be touched, against the same")         \
  X(int, most_retries, 3,                                                                                            \
    "repetitions of a start whose check points let the rod slip to the wrong side of an obstacle")                   \
  X(int, most_pieces_away, 3, "pieces of an unsplit rod, from where the start comes nearest to the obstacle")        \
  X(int, few_values, 60, "coordinates up to which the rod settles in those of the plan")                             \
  X(int, many_values, 150, "coordinates of programs that led to no plan, before the rod itself is asked")            \
  X(int, exchanges_along, 8, "rounds in which check points are added along equilibria")                              \
  X(int, useless_rests, 6, "rests in a row that say little, before plans are sought in other ways")                  \
  X(double, sampling_work, 2e6, "work for all rests before the ordinary search goes on")                             \
  X(double, deepest, 1e-2, "depth (L) in soft obstacles from which on a rod is not resting")                         \
  X(int, most_settlings, 3, "executions of unstable plans, for a stable shape to start from")                        \
  X(int, looks_at_unstable, 16000, "steps that the rod may take from an unstable plan")                              \
  X(double, unlimited_moment, 6.3, "moment (EI/L) that stands for no limit: it bends the rod to a circle")           \
  X(std::size_t, sampled_alone, 2, "the first so many are tried with one actuator before several are")               \
  X(std::size_t, most_samples, 64, "inputs at which rests are looked for")                                           \
  X(double, penalty_growth, 10.0, "factor of beta, until the branch is decided")                                     \
  X(double, penalty_cap, 1e4, "largest beta")                                                                        \
  X(double, relaxation_first, 1e-1, "eps of scholtes and fischer_burmeister in the first solve")                     \
  X(double, relaxation_last, 1e-8, "eps in the last solve")                                                          \
  X(double, relaxation_shrink, 1e-2, "factor of eps from solve to solve")                                            \
  X(double, tiny_radius, 1e-3, "radius (L) below which an obstacle is grown before a contact with it is searched")   \
  X(double, slowest_shrinking, 0.95, "share per step on the way back, before it is given up")                        \
  X(int, most_exchanges, 25, "rounds in which check points are moved or added before a certificate")                 \
  X(int, moving_exchanges, 8, "after so many rounds check points stay: moved ones may go to and fro")                \
  X(double, deciding_load, 1.0, "a load (EI/L^2) above this decides how the rod hangs")                              \
  X(int, patience, 8, "iterations of a solve of a grasp, over those of the slowest solve that converged")            \
  X(int, most_restorations, 400, "steps of a restoration")                                                           \
  X(int, patient_restorations, 4000, "steps of a restoration that is to prove something")                            \
  X(int, most_refinements, 5, "rounds in which the quadrature is refined before a certificate")                      \
  X(std::size_t, most_enumerated, 64, "up to so many assignments of contacts are all tried")                         \
  X(std::size_t, most_enumerated_at_last, 512, "up to so many where the search found no plan")                       \
  X(std::size_t, beam_width, 4,                                                                                      \
    "assignments of one size that are grown: the best certified ones, then those nearest to feasible")               \
  X(std::size_t, most_extensions, 6, "contacts that each of them is given in turn")                                  \
  X(double, nearly_feasible, 1e-3, "violation below which the point of a solver is worth sharpening")                \
  X(double, beats, 1e-12, "an objective must be lower by this to win")                                               \
  X(double, dearer, 1e-6, "a point that costs so much more than the plan is not completed (scaled objective)")       \
  X(bool, ask_rests, true, "where no first start led to a plan, rests under sampled moments are starts")             \
  X(bool, hang, true, "under large loads shapes that hang are starts")                                               \
  X(bool, scan, true, "a thorough search looks at all equilibria over the box of one or two moments")                \
  X(bool, relaxed_arcs, true, "where the plan is off its target arcs that are let go are starts")                    \
  X(double, off_target, 0.1, "distance to the target (rad, L) from which on they are")                               \
  X(double, off_notched, 0.02, "the same beside bodies that are not convex and have no pockets")                     \
  X(int, most_relaxed_arcs, 33, "arcs that are let go, over all turns")                                              \
  X(int, looks_at_arcs, 20000, "steps of all of them")                                                               \
  X(std::size_t, dearer_relaxed, 2,                                                                                  \
    "rests that cost more than the plan and are starts, each of another contact or side")                            \
  X(std::size_t, inputs_of_relaxed, 5, "moments under which they are")                                               \
  X(int, fine_scan, 64, "steps of one moment from limit to limit")                                                   \
  X(int, plane_scan, 12, "steps of each of two moments")                                                             \
  X(int, scanned_sides, 12, "shapes on different sides that are let go at the corners of the box")                   \
  X(bool, grow_small, true, "very small obstacles are grown, and shrink back")                                       \
  X(bool, fall_back, true, "where a treatment fails, scholtes is tried")                                             \
  X(bool, settle, true, "where no plan was found, what unstable plans do when executed is a start")                  \
  X(bool, hold, true, "where no plan was found, plans are held at the limit of stability")                           \
  X(bool, prove, true, "where no plan was found, the violation with stability rows is followed from every start")    \
  X(bool, tell_spread, true, "where no plan was found, it is looked whether a contact spreads")                      \
  X(bool, reduce_large, true, "programs of many coordinates are solved along equilibria alone")                      \
  X(bool, hurry, true, "after much work without a plan no solver is asked where nothing feasible is near")           \
  X(bool, defer, true, "starts of a grasp with nothing feasible near wait for the others")                           \
  X(bool, balance_first, true,                                                                                       \
    "where an objective is to balance a grasp, the plan with the balance as a row is the first start")               \
  X(bool, grow_contacts, true, "where assignments are too many, the best ones are given one contact more")           \
  X(bool, descend, true, "Newton's method goes from a feasible point to a minimum before the solver is asked")       \
  X(int, most_seams, 30, "pieces of a body that is not convex, from one to the next")                                \
  X(int, most_descents, 15, "steps of it")                                                                           \
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
  bool strategy = false;  ///< it can be left out
};
/// All of them as they are.
TENDRIL_API std::vector<SearchParameter> list_search_parameters();
/// Sets one. Throws Error for a name or a value that it does not know.
TENDRIL_API void set_search_parameter(const std::string& name, const std::string& value);

}  // namespace tendril
