#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "rod/quadrature.hpp"
#include "rod/rod.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril {

/// How a rod stretches along a piece: eps = factor sum_k e_k P_k(2 sigma - 1), k below `order`.
struct StretchBasis {
  int order = 0;        ///< 0: not at all
  double factor = 1.0;  ///< such that the energy of a coordinate is of the size that it has in bending
  /// The functions at sigma, and their derivatives.
  void evaluate(double sigma, double* value, double* slope) const;
  /// Second derivative of  sum_k e_k functions.
  double bend(double sigma, const double* e) const;
  bool operator==(const StretchBasis&) const = default;
};

/// Values of a local basis at the nodes of a rule on [0,1], in the two layouts that the evaluation needs. Behind the
/// functions of the angle stand those of the stretch, which turn nothing: what belongs to the angle is 0 there.
struct BasisTable {
  int functions = 0;            ///< of the angle and of the stretch
  int bends = 0;                ///< of the angle: the first ones
  int nodes = 0;                ///< points of the rule
  Eigen::VectorXd sigma;        ///< nodes: the points of the rule
  Eigen::VectorXd weight;       ///< nodes: its weights
  Eigen::MatrixXd by_function;  ///< nodes x functions, a column per function
  Eigen::MatrixXd by_node;      ///< functions x nodes, a column per node
  Eigen::MatrixXd products;     ///< bends (bends + 1) / 2 x nodes: beta_i beta_k, i <= k; empty for large bases
  Eigen::VectorXd end;          ///< beta(1)
  Eigen::MatrixXd slope;        ///< nodes x functions: beta'
  Eigen::VectorXd slope_start;  ///< beta'(0)
  Eigen::VectorXd slope_end;    ///< beta'(1)
  Eigen::MatrixXd stiffness;    ///< int beta_i' beta_k' dsigma
  Eigen::VectorXd slope_bound;  ///< max over [0,1] of |beta_i'|, sampled densely and inflated
  /// Per smooth interval: functions x Legendre coefficients of beta''.
  std::vector<Eigen::MatrixXd> bend_series;
  StretchBasis stretch;
  Eigen::MatrixXd stretch_by_function;  ///< nodes x stretch.order
  Eigen::MatrixXd stretch_by_node;      ///< stretch.order x nodes
  Eigen::MatrixXd mixed;                ///< bends stretch.order x nodes: beta_i times each of them, i by i
  Eigen::VectorXd stretch_start;        ///< at sigma = 0; at 1 all are stretch.factor
};

class CurveTables;

/// A rule on [0,1] and a basis at its nodes: what a chain needs beside the rod.
struct ChainTables {
  /// The rule has `nodes` points on each smooth interval of `model`.
  ChainTables(const CoordinateModel& model, int nodes, const StretchBasis& stretch = {});
  Quadrature rule;                           ///< cut at the model's breaks
  std::shared_ptr<const CurveTables> curve;  ///< for the same rule
  BasisTable basis;                          ///< at the nodes of `rule`, made with the former
};

/// Makes the tables of each model and number of nodes once: the many small programs of a plan share them. Models must
/// outlive it. Not for concurrent use.
class TENDRIL_API TableStore {
 public:
  /// The tables for `nodes` points per smooth interval of `model`, made if they are asked for the first time.
  std::shared_ptr<const ChainTables> of(const CoordinateModel& model, int nodes, const StretchBasis& stretch = {});

 private:
  struct Entry {
    const CoordinateModel* model;
    int nodes;
    StretchBasis stretch;
    std::shared_ptr<const ChainTables> tables;
  };
  std::vector<Entry> entries_;
};

/// The rod cut into pieces (model.md section 2): which pieces there are, how long they are as affine functions of the
/// moving knots, and the tables that never change. Knots are fixed (Rod::fixed_knots()) or move with a contact; that at
/// the base moves, as the first of them, where the rod is drawn into its port.
///
/// Coordinates: q = (q_1, ..., q_J), `functions()` numbers per piece: those of its angle, then those of its stretch.
class TENDRIL_API Chain {
 public:
  /// A piece and its properties where they are constant, dimensionless.
  struct Piece {
    int stretch = 0;              ///< between which fixed knots
    double stiffness = 1.0;       ///< EI / EI0
    double weight = 0.0;          ///< rho |g| L^3 / EI0
    double rest_curvature = 0.0;  ///< kappa0 L
    int segment = 0;              ///< of the rod
    bool bends_evenly = true;     ///< stiffness and rest curvature are constant
    bool weighs_evenly = true;    ///< the weight is
    Vec2 line{};                  ///< dead force per length on it
    Vec2 point{};                 ///< dead force at its end
    double point_weight = 0.0;    ///< what hangs at its end
  };

  /// `knot_stretches`: for each contact's knot, in ascending order along the rod, the stretch between fixed knots in
  /// which it moves. `nodes`: Gauss nodes per smooth interval of a piece. Without `store` the chain makes its own
  /// tables.
  Chain(const Rod& rod, const CoordinateModel& model, std::span<const int> knot_stretches, int nodes,
        TableStore* store = nullptr);

  /// Number of pieces J.
  int piece_count() const { return static_cast<int>(pieces_.size()); }
  /// Coordinates per piece.
  int functions() const { return table().functions; }
  /// Of these, how many are of the angle, and of the stretch.
  int bends() const { return table().bends; }
  int stretches() const { return table().stretch.order; }
  int nodes() const { return table().nodes; }  ///< per piece
  /// Length of q.
  int coordinate_count() const { return piece_count() * functions(); }
  /// Number of knots that move.
  int knot_count() const { return static_cast<int>(start_rate_.cols()); }
  /// Properties of piece j.
  const Piece& piece(int j) const { return pieces_[static_cast<std::size_t>(j)]; }
  /// The segment of the rod that piece j is cut from.
  const Rod::Segment& segment(int j) const { return segments_[static_cast<std::size_t>(piece(j).segment)]; }
  /// The rod has a body.
  bool is_thick() const { return thick_; }
  /// The piece that ends at the knot of contact k.
  int piece_before_knot(int k) const { return knot_piece_[static_cast<std::size_t>(k)]; }
  /// Knots that do not move, ascending, 0 and 1 included; units of L.
  const std::vector<double>& fixed_knots() const { return fixed_knots_; }

  /// Piece j starts at  start0[j] + start_rate.row(j) . knots  and has length  length0[j] + length_rate.row(j) . knots.
  const Eigen::VectorXd& start0() const { return start0_; }
  /// piece_count() entries.
  const Eigen::VectorXd& length0() const { return length0_; }
  /// piece_count() x knot_count().
  const Eigen::MatrixXd& start_rate() const { return start_rate_; }
  /// piece_count() x knot_count().
  const Eigen::MatrixXd& length_rate() const { return length_rate_; }
  /// Arc length at which piece j begins, for moving knots at `knots` (knot_count() entries); units of L.
  double start(int j, std::span<const double> knots) const;
  /// Length of piece j for moving knots at `knots`; units of L.
  double length(int j, std::span<const double> knots) const;

  /// The profile of actuator a where it is the same all over piece j; 0 as well where it does not bend the piece.
  double level(int a, int j) const { return levels_(a, j); }
  /// The profile of actuator a where it varies over piece j, else null.
  const ProfilePart* varying(int a, int j) const {
    const int part = varying_(a, j);
    return part < 0 ? nullptr : &parts_[static_cast<std::size_t>(part)];
  }
  /// Axial force by a unit of pull() of actuator a on piece j.
  double thrust(int a, int j) const { return thrusts_(a, j); }
  /// What goes with the axial force of actuator a under a moment, most often the moment itself, and its derivatives.
  Rod::Jet pull(int a, double moment) const {
    const auto& law = pulls_[static_cast<std::size_t>(a)];
    return law ? law(moment) : Rod::Jet{moment, 1.0};
  }
  /// Whether it is anything else.
  bool pulls_by_law(int a) const { return static_cast<bool>(pulls_[static_cast<std::size_t>(a)]); }
  /// Number of actuators of the rod.
  int actuator_count() const { return static_cast<int>(levels_.rows()); }
  /// Whether the work of any actuator changes as pieces move along it.
  bool has_moving_work() const { return !parts_.empty() || !thrusts_.isZero(0.0); }

  /// The basis at the nodes of the rule.
  const BasisTable& table() const { return tables_->basis; }
  /// The rule on [0,1] that every piece is integrated with.
  const Quadrature& rule() const { return tables_->rule; }
  /// Tables for a Curve of this chain.
  const std::shared_ptr<const CurveTables>& curve_tables() const { return tables_->curve; }
  /// The coordinate model, borrowed.
  const CoordinateModel& model() const { return *model_; }

  /// Coordinates of a piece that come nearest (in curvature, L2) to curvature(sigma) * length given at the nodes.
  Eigen::VectorXd project(std::span<const double> scaled_curvature) const;

  /// The same for all pieces, from a curvature along the rod (times L, of s/L) and moving knots at `knots`. `stretch`:
  /// likewise; empty: none.
  Eigen::VectorXd coordinates_of(const std::function<double(double)>& curvature, std::span<const double> knots,
                                 const std::function<double(double)>& stretch = {}) const;

  /// The piece that holds arc length s (the earlier one at a knot).
  int piece_at(double s, std::span<const double> knots) const;

 private:
  void find_profiles(const Rod& rod);
  void find_loads(const Rod& rod);

  const CoordinateModel* model_;
  std::shared_ptr<const ChainTables> tables_;
  std::vector<double> fixed_knots_;
  std::vector<Rod::Segment> segments_;
  bool thick_ = false;
  std::vector<Piece> pieces_;
  std::vector<int> knot_piece_;
  Eigen::VectorXd start0_, length0_;
  Eigen::MatrixXd start_rate_, length_rate_;
  Eigen::MatrixXd levels_, thrusts_;  // actuators x pieces
  std::vector<std::function<Rod::Jet(double)>> pulls_{};
  Eigen::MatrixXi varying_;  // actuators x pieces: index into parts_, or -1
  std::vector<ProfilePart> parts_{};
};

/// Number of Gauss nodes per smooth interval that resolves `functions` coordinates and a change of angle of `angle` per
/// piece (model.md section 2).
TENDRIL_API int suggested_nodes(int functions, double angle);

}  // namespace tendril
