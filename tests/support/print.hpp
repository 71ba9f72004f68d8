#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <ostream>
#include <string>
#include <string_view>

#include "tendril/estimate.hpp"
#include "tendril/execute.hpp"
#include "tendril/options.hpp"
#include "tendril/plan.hpp"
#include "tendril/registrar.hpp"
#include "tendril/scene.hpp"
#include "tendril/solver.hpp"
#include "tendril/trajectory.hpp"
#if __has_include("tendril/plugins/error.hpp")
#include "tendril/plugins/error.hpp"
#endif
// Core's own headers, for tests that see them.
#if __has_include("nlp/multipliers.hpp")
#include "nlp/multipliers.hpp"
#include "program/pose_program.hpp"
#endif

/// How failing tests show values. GoogleTest prints an enumeration as its bytes; with this header it says
/// names.
namespace tendril {

///@{
/// The name that results write.
inline void PrintTo(SolveStatus value, std::ostream* out) { *out << to_string(value); }
inline void PrintTo(PlanStatus value, std::ostream* out) { *out << to_string(value); }
inline void PrintTo(EstimateStatus value, std::ostream* out) { *out << to_string(value); }
inline void PrintTo(StepMethod value, std::ostream* out) { *out << to_string(value); }
inline void PrintTo(SnapKind value, std::ostream* out) { *out << to_string(value); }
inline void PrintTo(ComponentKind value, std::ostream* out) { *out << to_string(value); }
///@}

/// The name that stands at the value's place in the order of its declaration.
template <class Enum>
std::string_view name_of(Enum value, std::initializer_list<std::string_view> names) {
  const auto place = static_cast<std::size_t>(value);
  return place < names.size() ? names.begin()[place] : "a value without a name";
}

///@{
/// The name in the source.
inline void PrintTo(ProblemKind value, std::ostream* out) {
  *out << name_of(value, {"pose", "trajectory", "grasp", "execute", "estimate"});
}
inline void PrintTo(ContactModeName value, std::ostream* out) {
  *out << name_of(value, {"ignore", "avoid", "allow", "require"});
}
inline void PrintTo(Treatment value, std::ostream* out) {
  *out << name_of(value, {"penalty", "slack", "scholtes", "fischer_burmeister"});
}
inline void PrintTo(Fingers value, std::ostream* out) { *out << name_of(value, {"as_needed", "mirrored", "both"}); }
inline void PrintTo(OptionType value, std::ostream* out) {
  *out << name_of(value, {"boolean", "integer", "real", "text", "list", "points", "matrix"});
}
#if __has_include("nlp/multipliers.hpp")
inline void PrintTo(MultiplierSign value, std::ostream* out) {
  *out << name_of(value, {"free", "non_negative", "non_positive"});
}
inline void PrintTo(Branch value, std::ostream* out) { *out << name_of(value, {"open", "touching", "separated"}); }
#endif
///@}

#if __has_include("tendril/plugins/error.hpp")
namespace plugins {

/// The name in the source.
inline void PrintTo(Failure value, std::ostream* out) {
  *out << name_of(value, {"not_found", "untrusted", "not_a_plugin", "missing_dependency", "other_interface",
                          "wrong_component", "threw", "failed"});
}

}  // namespace plugins
#endif

}  // namespace tendril
