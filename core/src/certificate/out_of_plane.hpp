#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <vector>

#include "program/pose_program.hpp"
#include "rod/curve.hpp"
#include "rod/quadrature.hpp"

namespace tendril {

/// Whether a planar equilibrium also is one of a rod that may leave its plane (model.md section 12): obstacles are
/// prisms across the plane, loads are dead, actuators turn with the rod.
///
/// A rotation w in the plane, w = 0 at the clamp, bends the rod out of it (w'.N) and twists it (w'.t). With w in the
/// fixed frame the second variation of the energy needs no curvature:
///
///     2 Q = int GJ (w'.t)^2 + EI_o (w'.N)^2 - m w x w' - (1 + eps) (w.N) (w x F) ds,
///
/// F and m the force and the moment of everything beyond, eps the stretch. It is taken on Legendre functions of its
/// own.
class TENDRIL_API OutOfPlane {
 public:
  /// Of rods whose torsion is known. `most_functions`: of each of both components of w, on one panel.
  explicit OutOfPlane(int most_functions = 16);

  /// Smallest eigenvalue of Q against its first two terms. `curve`: of the program's backbone at the point evaluated
  /// last.
  double margin(const PoseProgram& program, const Curve& curve);

 private:
  /// A stretch of a piece on which all integrands are smooth.
  struct Panel {
    int piece = 0;
    double from = 0.0, to = 1.0;  ///< sigma of the piece
    double start = 0.0, length = 1.0;
  };
  /// A force at one place along the rod, and its couple about the backbone.
  struct PointForce {
    double s = 0.0;
    Vec2 force{};
    double moment = 0.0;
  };
  /// Of everything beyond.
  struct Transmitted {
    Vec2 force{};
    double moment = 0.0;
  };

  void cut(const PoseProgram& program, const Curve& curve);
  void find_forces(const PoseProgram& program);
  void choose_functions(int count);
  void weigh(const PoseProgram& program, const Curve& curve, std::size_t p, Transmitted& beyond);
  void form(std::size_t p);
  void add_to_whole(std::size_t p);

  int most_functions_;
  int functions_ = 0;
  Eigen::MatrixXd value_, slope_;  ///< nodes x (1 + functions): w at the panel's start, then the basis
  Eigen::MatrixXd up_to_;          ///< nodes x nodes: integrals from the panel's start to each node
  Quadrature rule_{1};
  std::vector<Panel> panels_;
  std::vector<PointForce> forces_;
  std::vector<double> ends_;
  Eigen::VectorXd shear_, passed_;                   ///< at nodes: t x F, and its integral
  Eigen::VectorXd by_xx_, by_xy_, by_yy_, by_turn_;  ///< weights at nodes
  Eigen::VectorXd stiff_xx_, stiff_xy_, stiff_yy_;   ///< likewise, of the first two terms
  Eigen::MatrixXd local_, stiffness_, geometric_, coupled_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> factors_;  ///< per panel
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_;
};

}  // namespace tendril
