#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::bench {

/// What is known of the answer of an extreme case, dimensionless.
struct KnownAnswer {
  std::optional<Vec2> tip;  ///< L
  std::optional<double> arc_length, force;
  double digits = 1e-9;  ///< error that the source leaves
};

/// The word for what came out of a case: the status of a plan or an execution, "extended" where the rod was found to
/// lie along an obstacle, "refused" where the scene is not taken.
using Verdict = std::string;

/// A stiff or extreme scene with a known answer or a known verdict.
struct ExtremeCase {
  std::string group, name;
  std::string text;             ///< the scene, without coordinates and solver
  bool executed = false;        ///< carried out, not planned: no coordinate model and no solver take part
  std::vector<double> moments;  ///< N m, of an execution
  Verdict verdict = "solved";
  std::string source;  ///< of what is known
  KnownAnswer known{};
  std::string same_as{};           ///< plans of one family are the same dimensionless plan
  bool against_execution = false;  ///< compared with what the fine basis does under the same moments
  bool overlaps = false;           ///< the rod crosses or covers itself, which has to be reported
  /// One point contact cannot be: not solved, or extended, or held by several points each of which is convex.
  bool spread = false;
  bool quick = false;            ///< part of the short form
  double stiffness_least = 1.0;  ///< of all segments, against the first one's: scales what a defect can do
  /// Moments that an execution starts from, itself carried out first; empty: the scene's own start.
  std::vector<double> before{};
};

/// Every case, group by group.
std::vector<ExtremeCase> extreme_cases();

}  // namespace tendril::bench
