#pragma once

#include <limits>
#include <string>

namespace tendril::bench {

enum class Outcome {
  met,        ///< what is known came out
  explained,  ///< it did not, by a limit of the model that was measured
  not_met
};
std::string to_string(Outcome outcome);

/// Where there is no number.
inline constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// (L, and relative for forces above 1) A model whose error stays below this resolves its shape; what the fine basis
/// promises of executions. Ten times what a penetration of tolerance::penetration moves.
inline constexpr double resolved_error = 1e-8;

/// One case with one coordinate model and one backend.
struct ExtremeRow {
  std::string group, name;
  std::string model;    ///< "-": none takes part
  std::string backend;  ///< "-": none takes part
  std::string expected, source, got, residuals;
  double error = 0.0;    ///< of the model: against the exact state, of what is worst; NaN: there is none
  double allowed = 0.0;  ///< without any explanation
  double seconds = 0.0;
  Outcome outcome = Outcome::not_met;
  std::string why{};  ///< how the error falls where the model is coarse, or why the row is not met
};

}  // namespace tendril::bench
