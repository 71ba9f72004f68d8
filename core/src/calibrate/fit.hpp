#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "base/deadline.hpp"
#include "estimate/loaded_rod.hpp"
#include "nlp/levenberg.hpp"
#include "tendril/calibration_unknown.hpp"

namespace tendril {

/// What was seen at an arc length, dimensionless.
struct SeenMarker {
  double arc_length = 1.0;
  double along_normal = 0.0, along_tangent = 0.0;  ///< of a stalk that it stands on
  bool has_position = true, has_angle = false;
  Vec2 position{};
  double angle = 0.0;
};

/// A recording, dimensionless.
struct SeenShape {
  std::vector<SeenMarker> markers;
  /// What the actuators were told, in units of the largest of all that each of them was told: powers then stay
  /// comparable.
  Eigen::VectorXd inputs;
  Eigen::VectorXd moments;  ///< as far as they are known
  LoadedRod::Loads loads;   ///< moments apart, with the base at its nominal angle
  int group = 0;            ///< recordings with a base pose in common
};

/// A number to be found, in a unit of its own of about the size in which a change matters.
struct Sought {
  CalibrationUnknown kind = CalibrationUnknown::stiffness;
  int index = 0;   ///< segment or actuator; -1: all segments
  int power = 1;   ///< of the input
  int group = -1;  ///< whose base it is; -1: of all
  double start = 0.0, lower = -infinity, upper = infinity;
  double prior = 0.0, prior_error = infinity;
  double spread = 0.0;  ///< how far around the start other starts lie
};

/// A calibration, dimensionless.
struct SoughtNumbers {
  Rod rod;
  std::vector<SeenShape> shapes;
  std::vector<Sought> unknowns;
  double angle_weight = 1.0;  ///< what a radian counts, in L
  double noise = 0.0;         ///< of a coordinate; 0: not known
  bool robust = false;        ///< Huber's loss instead of squares
};

/// Shapes and their rates at some values of the unknowns.
struct FittedPoint {
  Eigen::VectorXd values;
  std::vector<Eigen::VectorXd> coordinates;  ///< of each shape; empty: not asked for
  std::vector<Eigen::MatrixXd> rates;        ///< of the coordinates, by the unknowns that concern the shape
  std::vector<Eigen::VectorXd> residuals;    ///< of each shape: x and y, angle of its markers in turn
  std::vector<Eigen::MatrixXd> jacobians;    ///< of them
  std::vector<Eigen::VectorXd> weights;      ///< of the residuals, at most 1
  double sum = infinity;                     ///< of weighted squares, priors included
  bool found = false;                        ///< every shape asked for has an equilibrium
};

/// Least squares over the unknowns, the equilibria of all shapes solved inside (model.md section 13).
class TENDRIL_API CalibrationFit {
 public:
  /// `problem` is borrowed.
  CalibrationFit(const SoughtNumbers& problem, int order, double turn, const Deadline& deadline);

  /// Shapes at given values. `near`: a point whose shapes are close, or null: loads grow from nothing.
  FittedPoint at(const Eigen::VectorXd& values, const std::vector<int>& shapes, const FittedPoint* near);
  /// The best point near `start` for some of the shapes, to a part `accuracy` of the standard deviations.
  struct Result {
    FittedPoint point;
    bool converged = false;
    double noise = 0.0;  ///< standard deviation of a coordinate, as given or as the residuals tell
  };
  Result fit(FittedPoint start, const std::vector<int>& shapes, double accuracy, int most_steps);

  /// J^T W J and J^T W r, priors included.
  void equations(const FittedPoint& point, double noise, Eigen::MatrixXd& normal, Eigen::VectorXd& gradient) const;
  /// Unknowns that concern a shape, in ascending order.
  const std::vector<int>& unknowns_of(int shape) const { return columns_[static_cast<std::size_t>(shape)]; }
  /// Measured coordinates of shapes.
  static int count(const SoughtNumbers& problem, const std::vector<int>& shapes);

  /// Points of a shape along the rod.
  struct Drawn {
    Vec2 position{};
    double angle = 0.0, curvature = 0.0;
  };
  std::vector<Drawn> draw(const FittedPoint& point, int shape, const std::vector<double>& arc_lengths);
  int solves() const { return solves_; }

 private:
  struct Pose {
    Vec2 position{};
    double angle = 0.0;
  };
  LoadedRod::Properties properties(const Eigen::VectorXd& values) const;
  LoadedRod::Loads loads(const Eigen::VectorXd& values, const SeenShape& shape, const Pose& pose) const;
  Pose pose(const Eigen::VectorXd& values, int shape) const;
  Eigen::VectorXd force_by(const Sought& unknown, const SeenShape& shape) const;
  Places& places_at(const std::vector<SeenMarker>& markers);
  void see(FittedPoint& point, int shape, const Pose& pose);
  double priors(const Eigen::VectorXd& values, double noise) const;
  double weighted_sum(const FittedPoint& point, double noise) const;
  double spread(const FittedPoint& point, const std::vector<int>& shapes) const;
  void weigh(FittedPoint& point, double noise) const;
  FitEnd improve(FittedPoint& point, const std::vector<int>& shapes, double noise, double accuracy, int most_steps);
  void hold_at_bounds(const FittedPoint& point, NormalEquations& at) const;

  const SoughtNumbers& problem_;
  LoadedRod rod_;
  const Deadline& deadline_;
  std::vector<std::vector<int>> columns_;
  std::map<std::vector<double>, std::unique_ptr<Places>> places_;
  int solves_ = 0;
};

}  // namespace tendril
