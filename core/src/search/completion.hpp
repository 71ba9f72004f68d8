#pragma once

#include <cmath>
#include <memory>

#include "base/clock.hpp"
#include "nlp/multipliers.hpp"
#include "search/parameters.hpp"
#include "search/verdict.hpp"
#include "tendril/tolerances.hpp"

/// From a point that a solver found to one that a certificate has judged, for every kind of program.
namespace tendril {

/// A point of a program, and who judges it.
template <class Program, class Certifier>
struct PointOf : Judged {
  std::shared_ptr<Program> program;
  std::shared_ptr<Certifier> certifier;
  Eigen::VectorXd x;
};

enum class Completion {
  judged,    ///< it has a certificate
  no_point,  ///< nothing feasible is near
  lost,      ///< it could not be followed to where what is near is feasible
};

/// Brings `x` to a certificate in `c`. `Steps` knows the program:
///   build()           makes c's program and certifier anew, with the check points and nodes that there are
///   sharpen(x, may)   Newton, and the solver if it may; false: x is no point to judge
///   recover(x)        reduces the violation alone, then sharpens
///   certify(x, p)     judges x in c; `p`: the polish that it is the point of, or null
///   exchange(x, i)    adds or moves check points in round i; false: none is missing
///   refine()          more nodes; false: there are enough of them
///   only_newton()     whether nothing else may move x
template <class Point, class Steps>
Completion bring_to_certificate(ProgramSearch& search, const Way& way, Point& c, Eigen::VectorXd x, Steps& steps) {
  steps.build();
  bool sharp = steps.sharpen(x, true);
  if (!sharp && steps.only_newton()) return Completion::lost;
  // What is only nearly feasible is feasible, or a place where the violation is stationary: then there is no point.
  if (!sharp && x.allFinite() && infeasibility(*c.program, x) > restored) {
    sharp = steps.recover(x);
    if (!sharp && infeasibility(*c.program, x) > restored) return Completion::no_point;
  }
  for (int round = 0; round < search_parameters().most_exchanges && !search.must_stop(); ++round) {
    if (!x.allFinite() || !steps.exchange(x, round)) break;
    steps.build();
    sharp = steps.sharpen(x, true) || steps.recover(x);
    if (!sharp) return Completion::lost;
  }
  for (int refinement = 0; refinement < search_parameters().most_refinements; ++refinement) {
    const double begin = now();
    steps.certify(x, search.polished());
    search.tally.seconds_certifying += now() - begin;
    const bool enough = !(c.certificate.quadrature > tolerance::quadrature);
    if (enough || !sharp || search.must_stop() || !steps.refine()) break;
    steps.build();
    sharp = steps.sharpen(x, false);
  }
  if (!x.allFinite()) return Completion::no_point;
  c.x = std::move(x);
  c.solver = way.last;
  c.objective = c.program->cost(c.x);
  c.has_point = std::isfinite(c.objective);
  return Completion::judged;
}

/// Whether a point is to be kept instead of the best one so far.
inline bool better(const Judged& point, const Judged& best) {
  if (point.certified() != best.certified() || !best.has_point) return point.certified() || !best.has_point;
  return point.objective < best.objective - search_parameters().beats;
}

/// Whether a solver's answer is worth going on with: a point of the program that is nearly feasible.
inline bool usable(const OptimalityReport& report, const Eigen::VectorXd& start) {
  return report.x.size() == start.size() && report.x.allFinite() &&
         report.infeasibility <= search_parameters().nearly_feasible;
}

}  // namespace tendril
