#pragma once

#include <algorithm>
#include <initializer_list>
#include <ostream>

#include "formula.hpp"
#include "tendril/solver.hpp"

namespace tendril::conformance {

inline Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.begin());
  return v;
}

/// A program with a published answer, against which any backend's solution is checked.
struct KnownProblem {
  std::string name;
  std::string features;  ///< what is special about it
  std::function<std::unique_ptr<NonlinearProgram>()> make;
  Eigen::VectorXd start;
  double optimum = 0.0;
  Eigen::VectorXd solution{};        ///< empty: not unique, or not published
  double cost_tolerance = 1e-6;      ///< relative to max(1, |optimum|): six digits are what the collection prints
  double solution_tolerance = 1e-4;  ///< looser than the cost by its square root, as everywhere near a minimum

  /// What is wrong with a report that claims to solve this; empty if nothing is.
  std::string check(const OptimalityReport& report) const;
};

/// W. Hock, K. Schittkowski, Test Examples for Nonlinear Programming Codes, Lecture Notes in Economics and Mathematical
/// Systems 187, Springer 1981.
const std::vector<KnownProblem>& hock_schittkowski();

enum class MpccTreatment { penalty, scholtes };
/// By name where a failing test shows its parameters.
inline void PrintTo(MpccTreatment treatment, std::ostream* out) {
  *out << (treatment == MpccTreatment::penalty ? "penalty" : "scholtes");
}

/// A program with complementarity pairs 0 <= G(x) _|_ H(x) >= 0, which a treatment with a parameter turns into an
/// ordinary one: penalty: cost + parameter sum G H; scholtes: rows G H <= parameter.
struct KnownMpcc {
  std::string name;
  std::string features;
  std::function<std::unique_ptr<NonlinearProgram>(MpccTreatment, double parameter)> make;
  /// Largest min(G, H) at x, and the cost without penalty.
  std::function<double(ConstVectorRef x)> complementarity;
  std::function<double(ConstVectorRef x)> cost;
  Eigen::VectorXd start;
  double optimum = 0.0;
};

/// S. Leyffer, MacMPEC: AMPL collection of MPECs (optima as printed there).
const std::vector<KnownMpcc>& macmpec();
/// Published programs with Coulomb friction, whose optima are closed forms.
const std::vector<KnownMpcc>& friction();

}  // namespace tendril::conformance
