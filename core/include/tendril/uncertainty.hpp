#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tendril/export.hpp"

namespace tendril {

/// What becomes of a plan where a number of its scene is another one (docs/model.md section 15).
enum class SensitivityKind {
  replanned,  ///< planned anew, with the same contacts and limits active
  held        ///< carried out: the moments stay, which is what the robot does
};
TENDRIL_API std::string_view to_string(SensitivityKind kind);  ///< The word that results use.

/// A number of a result, SI.
struct ResultQuantity {
  std::string name;    ///< "tip.x", "tip.y", "tip.angle", "contacts[0].force", "contacts[0].arc_length", "moments[0]"
  std::string unit;    ///< of the value; empty: a pure number
  double value = 0.0;  ///< in it
};

/// Standard deviations of a result that is linear in its inputs.
struct Uncertainty {
  SensitivityKind kind = SensitivityKind::held;  ///< whose derivatives were taken
  std::string trouble{};                         ///< why there is none; empty: there is
  /// Why the numbers below should not be relied on: a state that may be lost within them. Empty: nothing is known.
  std::string warning{};
  std::vector<ResultQuantity> deviations{};  ///< of what a sensitivity tells, then of the margin
  /// What comes of one input, with its part in what it shares with others that go along with it.
  struct Share {
    std::string key;             ///< of the input
    double tip = 0.0;            ///< share of the variance of the tip's place, 0..1
    std::vector<double> each{};  ///< share of the variance of each of `deviations`
  };
  std::vector<Share> shares{};  ///< one per input, in the order given
  /// How well a point of the backbone is known.
  struct Point {
    double arc_length = 0.0;  ///< m
    double xx = 0.0;          ///< m^2, variance of its x
    double xy = 0.0;          ///< m^2, covariance of x and y
    double yy = 0.0;          ///< m^2, variance of its y
  };
  std::vector<Point> shape{};  ///< along the backbone, the tip last
};

}  // namespace tendril
