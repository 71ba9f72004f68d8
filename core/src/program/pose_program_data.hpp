#pragma once

#include <memory>
#include <vector>

#include "objective/term_set.hpp"
#include "program/margin_row.hpp"
#include "program/pose_program.hpp"
#include "rod/moving_point.hpp"

namespace tendril {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Check points of one piece that share a sigma are one station.
struct CheckStations {
  Eigen::MatrixXd by_node;           ///< stations x nodes: int_0^sigma as weights on the nodes
  std::vector<double> sigma;         ///< one per station
  std::vector<int> rows;             ///< check row of each use
  std::vector<int> station;          ///< station of each use
  Eigen::MatrixXd turned;            ///< 2 functions x stations: int_0^sigma N beta dsigma, from the last derivatives
  Eigen::VectorXd chord_x, chord_y;  ///< int_0^sigma t dsigma
  Eigen::VectorXd adjoint_x, adjoint_y;  ///< per station, for the Hessian
};

/// Everything that a pose program knows beside its bounds.
struct PoseProgram::Data {
  explicit Data(PoseProgramSpec s);

  PoseProgramSpec spec;
  Loads loads;
  Layout layout;
  Chain chain;
  Backbone backbone;
  TermSet terms;
  std::unique_ptr<MarginRow> margin;   ///< null: there is no such row
  std::vector<LearnedHessian> convex;  ///< one per row that keeps a contact from spreading
  std::vector<int> moment_variable;    ///< per actuator
  std::vector<Branch> branches;
  bool gravity = false;
  Vec2 shift{};  ///< of the base
  int pieces = 0, n = 0, nodes = 0, q_count = 0, x_count = 0, s_count = 0;

  /// d length_j / d s_l and d (mass beyond j) / d s_l for the arc length variables (zero for an unsplit rod).
  Eigen::MatrixXd length_rate, start_rate, mass_rate;

  // Contacts and samples.
  std::vector<int> contact_piece;         ///< piece that ends at the contact (split, tip) or holds it (unsplit)
  std::vector<int> contact_moving;        ///< index into `moving`, or -1
  std::vector<MovingPoint> moving;        ///< unsplit contacts first, then samples
  std::vector<int> moving_variable;       ///< arc length variable index (0..s_count), or -1: fixed arc length
  std::vector<double> moving_arc_length;  ///< for fixed ones
  std::vector<ContactState> contacts;
  std::vector<CheckStations> stations;      ///< per piece
  std::vector<SurfacePoint> check_surface;  ///< per check row
  std::vector<Vec2> check_point;

  BaseIndex index;
  BaseValues values;
  int dense_count = 0;             ///< base quantities with a dense row: the first ones
  std::vector<int> unit_variable;  ///< variable of each base quantity behind them
  int delta_row = 0;               ///< first of the rows of virtual displacements (Hessian only), 2 per contact
  RowMatrix rows;                  ///< (dense_count + 2 contacts) x x_count
  Eigen::VectorXd term_gradient, term_rest_gradient;
  Eigen::MatrixXd term_jacobian;

  // Sweeps over pieces and nodes.
  Eigen::VectorXd mass_beyond;
  Eigen::MatrixXd force;          ///< 2 x pieces: force transmitted at the end of a piece, without gravity
  Eigen::MatrixXd force_normal;   ///< nodes x pieces: F . N
  Eigen::MatrixXd force_tangent;  ///< nodes x pieces: F . t
  Eigen::VectorXd node_buffer, check_buffer, vector_buffer;
  PieceSums sums, gram_sums;
  std::vector<PieceSums> rate_sums;  ///< one per arc length variable

  // Second derivatives.
  Eigen::MatrixXd psi;  ///< nodes x pieces: virtual rotation along the multipliers
  Eigen::VectorXd psi_knot;
  Eigen::MatrixXd virtual_chord;  ///< 2 x pieces: int N psi
  Eigen::MatrixXd virtual_turn;   ///< 2 x (pieces + 1): int t psi ds up to each knot
  Eigen::MatrixXd virtual_sum;    ///< 2 functions x pieces: h int N psi beta
  Eigen::MatrixXd base_hessian;
  Eigen::VectorXd base_gradient;
  Eigen::MatrixXd adjoint, virtual_adjoint;  ///< 2 x pieces: sums of c and c' of all points beyond
  Eigen::VectorXd row_buffer;
  Eigen::MatrixXd check_rows;   ///< (coordinates + arc lengths + palm) x checks: tangential rows for the Hessian
  Eigen::MatrixXd scaled_rows;  ///< checks x (coordinates + arc lengths + palm)
  Eigen::VectorXd third;

  double length(int j) const { return backbone.length(j); }
  double start_distance(const StartShape& shape, const std::vector<Vec2>& points, ConstVectorRef lower,
                        ConstVectorRef upper) const;
  void evaluate_shape(ConstVectorRef x);
  void evaluate_forces(ConstVectorRef x);
  void evaluate_rows(ConstVectorRef x, Eigen::VectorXd& c);
  void fill_base(ConstVectorRef x);
  void base_rows();
  void mark_palm_column();
  bool carried(int obstacle) const { return obstacle >= static_cast<int>(spec.obstacles.size()) - spec.carried; }
  void equilibrium_jacobian(ConstVectorRef x, Eigen::MatrixXd& jacobian);
  void contact_jacobian(Eigen::MatrixXd& jacobian);
  void check_jacobian(Eigen::MatrixXd& jacobian);
  void balance_jacobian(Eigen::MatrixXd& jacobian) const;
  /// direction . dP of a check point against its obstacle, after check_jacobian(): the coordinates up to its piece, and
  /// from `others` on the arc lengths and the palm distance.
  void check_row(int j, const CheckStations& at, std::size_t use, Vec2 direction, double* row, double* others) const;
  void point_row_of_moving(const MovingPoint& m, int variable, double* x, double* y, double* angle, double* curvature);
  /// The rod's curvature beside contact k, on the side where it makes d_ss larger: the piece, and where in it.
  struct Side {
    int piece = 0;
    enum { start, inside, end } place = end;
    double curvature = 0.0;
  };
  Side convex_side(int contact) const;
  /// The curvature right before (0) or behind (1) contact k.
  Side side_of(int contact, int which) const;
  /// d_ss with the curvature of a side, and its derivatives by all variables.
  double convexity(int contact, const Side& side) const;
  void convexity_gradient(int contact, const Side& side, VectorRef gradient) const;
  void convexity_rows(ConstVectorRef x, bool derivatives, Workspace& out);
  double own_rate(const MovingPoint& m, int variable, int l) const;
  bool gather_check_adjoints(CheckStations& at, ConstVectorRef multipliers, Vec2& sum) const;
  void add_inner_second(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Eigen::MatrixXd& h);
};

}  // namespace tendril
