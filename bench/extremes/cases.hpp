#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::bench {

/// What is known of the answer of an extreme case beforehand, dimensionless.
struct KnownAnswer {
  std::optional<Vec2> tip;                  ///< L
  std::optional<double> arc_length, force;  ///< of the contact that presses hardest
  double digits = 1e-9;                     ///< error that the source leaves; relative for forces above 1
};

/// Of a rod that lies along an obstacle: where that begins (L), and all force on it (EI/L^2).
struct StretchAnswer {
  double begin = 0.0, force = 0.0;
};

/// The word for what came out of a case: the status of a plan or an execution, "extended" where the rod was found to
/// lie along an obstacle, "refused" where the scene is not taken.
using Verdict = std::string;

/// A stiff or extreme scene with a known answer or a known verdict. Whatever is solved is compared with the exact state
/// (exact_state.hpp) besides.
struct ExtremeCase {
  std::string group, name;
  std::string text;             ///< the scene, without coordinates and solver
  std::vector<double> moments;  ///< N m, of an execution
  Verdict verdict = "solved";
  std::string source;     ///< of what is known
  bool executed = false;  ///< carried out, not planned: no coordinate model and no solver take part
  KnownAnswer known{};
  std::optional<StretchAnswer> stretch{};  ///< of an execution whose verdict is "extended"
  std::string same_as{};                   ///< plans of one family are the same dimensionless plan
  bool against_execution = false;          ///< compared with what the fine basis does under the same moments
  bool overlaps = false;                   ///< the rod crosses or covers itself, which has to be reported
  bool split = true;                       ///< at contacts
  bool quick = false;                      ///< part of the short form
  /// Contacts that press at the end, and at the beginning of what has one: `before`, or the first of `targets`.
  std::optional<int> contacts{}, contacts_before{};
  /// Moments that an execution starts from, itself carried out first; empty: the scene's own start.
  std::vector<double> before{};
  /// Of a trajectory, L; empty: the scene's own target alone.
  std::vector<Vec2> targets{};
};

/// Every case, group by group. `held_out`: 0 for the numbers of the table; else the seed of other ones, each up to a
/// tenth away.
std::vector<ExtremeCase> extreme_cases(std::uint64_t held_out = 0);

}  // namespace tendril::bench
