#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "program/pose_program.hpp"
#include "support/reference_table.hpp"
#include "support/rod_bvp.hpp"

/// Forward equilibria of the library, and the same rods as boundary-value problems, for tests that compare the two.
namespace tendril::support {

/// One function per piece: the constant-curvature model, written here so that the tests need no plugin.
class ConstantCurvature : public CoordinateModel {
 public:
  explicit ConstantCurvature(int pieces) : pieces_(pieces) {}
  int function_count() const override { return 1; }
  void evaluate(std::span<const double> sigma, MatrixRef value, MatrixRef first, MatrixRef second) const override;
  std::vector<double> subdivision() const override;

 private:
  int pieces_;
};

/// A half plane. `normal` is a unit vector out of it.
class HalfPlane : public Obstacle {
 public:
  HalfPlane(Vec2 point, Vec2 normal) : point_(point), normal_(normal) {}
  SurfacePoint at(Vec2 point) const override { return {dot(point - point_, normal_), normal_, 0.0, 0.0}; }
  Vec2 reference_point() const override { return point_; }
  double smallest_radius() const override { return infinity; }
  double core_distance(Vec2 point) const override { return dot(point - point_, normal_); }
  double rounding() const override { return 0.0; }
  void bounding_box(Vec2& low, Vec2& high) const override;
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override;

 private:
  Vec2 point_, normal_;
};

using Model = std::shared_ptr<const CoordinateModel>;
Model legendre(int order, int pieces = 1);
Model psc();
Model pcc(int pieces);

/// The rod of a boundary-value problem whose length and first stiffness are 1. Actuators are free.
Rod core_rod(const RodBvp& rod);
/// A rod clamped upright with one actuator, its weight and a load on its tip pointing down.
Rod upright_rod(double weight, double load);
std::unique_ptr<Obstacle> core_obstacle(const BvpContact& contact);

/// A square system of the library: equilibrium, and per contact gap = 0 and closest point, over coordinates, arc
/// lengths and forces. Contacts are held closed whatever their sign.
class Equilibrium {
 public:
  /// `moments`: one per actuator; empty: the actuators stay free variables. `turn`: angle that one piece may turn by,
  /// for the number of nodes.
  Equilibrium(const Rod& rod, Model model, const std::vector<double>& moments,
              const std::vector<const Obstacle*>& obstacles = {}, const std::vector<ContactSetup>& contacts = {},
              bool split = true, double turn = 3.0);

  /// Solves from a start; `x` keeps the result. Returns the largest residual; below 1e-12 unless Newton's method fails.
  double solve(const StartShape& start);
  double solve_from(const Eigen::VectorXd& start);
  /// Newton's method on the coordinates alone, at the arc lengths, moments and forces of `start`.
  double solve_coordinates(const Eigen::VectorXd& start);
  /// Newton's method on coordinates and the moment of the only actuator at a given angle of the tip.
  double solve_at_tip_angle(const Eigen::VectorXd& start, double angle);

  Vec2 tip() { return moved().tip(); }
  double tip_angle() { return moved().tip_angle(); }
  double arc_length(int contact) const { return x[program->arc_length_variable(contact)]; }
  double force(int contact) const { return x[program->force_variable(contact)]; }

  PoseProgramSpec spec;
  std::unique_ptr<PoseProgram> program;
  Eigen::VectorXd x;

 private:
  const Backbone& moved();
  double newton(const Eigen::VectorXd& start, const std::vector<int>& rows, const std::vector<int>& columns);

  std::shared_ptr<Rod> rod_;
  Model model_;
};

/// The library's equilibrium with the contacts of a boundary-value problem, from that problem's solution as the start.
/// Without a split each interior contact is tried in the pieces around its place.
std::unique_ptr<Equilibrium> equilibrium_near(const RodBvp& rod, const std::vector<double>& moments,
                                              const std::vector<BvpContact>& contacts,
                                              const std::vector<const Obstacle*>& obstacles, const BvpSolution& near,
                                              const Model& model, bool split);

/// The braced arm of the reference data, dimensionless, and its units.
struct DimensionlessArm {
  static constexpr double length = 0.1;
  static constexpr double stiffness = 4.9e-4;
  static constexpr double moment_unit = stiffness / length;
  static constexpr double force_unit = stiffness / (length * length);
  RodBvp rod;
  BvpContact circle{{0.6, 0.0}, 0.08};
  DimensionlessArm();
  BvpSolution brace(double moment) const;
};

/// The contact of row `row` of circle_contact.csv, and its boundary-value solution at a moment.
BvpContact table_circle(const ReferenceTable& table, std::size_t row);
BvpSolution press(const BvpContact& circle, double moment);

/// One unit of the last digit printed: what two methods that agree to the digits shown may differ by.
double printed(const ReferenceTable& table, std::size_t row, const std::string& column);

/// Slope of log(error) over log(n) between two runs.
double order_of(double n1, double error1, double n2, double error2);

}  // namespace tendril::support
