#pragma once

#include <vector>

#include "nlopt_solver.hpp"

namespace tendril::nlopt_plugin {

/// One side of a row as NLopt sees it: sign * (c - bound), <= 0 or = 0.
struct Side {
  int row;
  double sign;
  double bound;
};

/// What the C callbacks reach through their data pointer.
struct NloptSolver::Run {
  Callbacks& callbacks;
  nlopt_opt opt = nullptr;
  std::vector<Side> equalities{};
  std::vector<Side> inequalities{};
  int iteration_limit = 0;
  int evaluations = 0;
  int gradients = 0;
  int not_finite = 0;
  Eigen::VectorXd last{};  ///< the last point with finite values
  bool uses_gradient = true;
  bool halves_step = false;
  bool limit_met = false;
  int searched = 0;    ///< values since the last gradient
  bool stuck = false;  ///< the last search went on for ever

  /// Sorts the program's rows into equalities and inequalities.
  void take_rows();
  /// How the run ended, in the words of every backend.
  SolveStatus status_of(nlopt_result result) const;
  /// Of the library, as far as its calls show them.
  int iterations() const;
  /// Keeps the exception being handled and asks NLopt to end.
  void stop();

  /// NLopt's callbacks; `data` is the run.
  static double objective(unsigned n, const double* x, double* gradient, void* data);
  static void equality_rows(unsigned, double* result, unsigned n, const double* x, double* gradient, void* data);
  static void inequality_rows(unsigned, double* result, unsigned n, const double* x, double* gradient, void* data);

 private:
  void write_sides(const std::vector<Side>& sides, unsigned n, const double* x, double* result, double* gradient);
};

}  // namespace tendril::nlopt_plugin
