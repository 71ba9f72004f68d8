#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "support/rod_bvp.hpp"
#include "tendril/estimate.hpp"

namespace tendril::test {

/// A rod held by circles, solved as a boundary-value problem: what an estimate is judged by. It shares nothing with the
/// estimator, neither the discretization nor the way forces enter.
struct Truth {
  support::RodBvp rod;
  std::vector<double> moments;
  std::vector<support::BvpContact> circles;
  support::BvpGuess guess;

  support::BvpSolution solve() const;
  double length() const { return rod.length(); }
};

/// Forces (positive along the backbone's normal) and places, force and arc length of each contact in turn, SI.
Eigen::VectorXd parameters(const Truth& truth, const support::BvpSolution& solution);

/// Exact points at `count` equally spaced arc lengths, the last one at the tip: x and y in turn.
Eigen::VectorXd exact_points(const Truth& truth, const support::BvpSolution& solution, int count);

/// The scene of an estimate with these measured points; noise in m, 0: not given.
Scene scene_of(const Truth& truth, const Eigen::VectorXd& points, double noise, int contacts);

/// Cramer-Rao bound of the parameters for independent normal noise: the circles are moved, the boundary-value problem
/// is solved anew, and central differences give how the points and the parameters move.
Eigen::MatrixXd cramer_rao(const Truth& truth, int points, double noise);

/// Standard normal numbers, the same on every platform: Box and Muller's transform of std::mt19937_64.
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : bits_(seed) {}
  double operator()();

 private:
  double uniform();
  std::mt19937_64 bits_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

Eigen::VectorXd noisy(const Eigen::VectorXd& points, double noise, std::uint64_t seed);

/// The points that scenes/estimate.csv holds: the braced arm's exact shape at 20 arc lengths with noise of 0.05 mm,
/// seed 1, rounded to micrometres.
std::string measurement_file();

/// The arm of the reference data, resting on its peg: 2.5 N mm.
Truth braced_arm();
/// A heavier load case without gravity: the rod is bent by 1.2 rad and held back by a circle above it (negative force).
Truth held_from_above();
/// Two segments and two actuators, base turned and moved, inch-sized; one circle on the distal segment.
Truth stepped_finger();
/// An arm held between two circles on opposite sides, far apart.
Truth two_pegs();
/// The same with both contacts close together.
Truth close_pegs();

/// What many estimates with different noise say, in standard deviations of the Cramer-Rao bound.
struct Campaign {
  int runs = 0;
  int solved = 0;
  int wrong_count = 0;
  Eigen::VectorXd mean;                ///< of (estimate - truth) / bound
  Eigen::VectorXd deviation;           ///< standard deviation of the same
  Eigen::VectorXd within_1, within_2;  ///< share with the truth inside 1 and 1.96 reported errors
  std::string text() const;
};
Campaign run_campaign(const Truth& truth, int points, double noise, bool noise_given, int contacts, int runs,
                      std::uint64_t first_seed);

}  // namespace tendril::test
