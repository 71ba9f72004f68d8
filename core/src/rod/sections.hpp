#pragma once

#include <Eigen/Core>
#include <vector>

#include "rod/backbone.hpp"
#include "tendril/export.hpp"

namespace tendril {

/// The sections of a moved rod: properties at the nodes of those pieces along which they vary, and what the elastic
/// energy makes of coordinates. Of other pieces nothing is evaluated. Nothing allocates after the first use.
class TENDRIL_API Sections {
 public:
  explicit Sections(const Chain& chain);

  /// Follows a backbone of the chain to where its pieces begin and end.
  void move(const Backbone& backbone);

  /// Of a piece that does not bend evenly, at its nodes; derivatives are by the arc length.
  struct Bending {
    Eigen::VectorXd stiffness, stiffness_slope, stiffness_bend;
    Eigen::VectorXd rest, rest_slope, rest_bend;
  };
  const Bending* bending(int j) const { return chain_->piece(j).bends_evenly ? nullptr : &own(j).bending; }
  /// Of a piece that does not weigh evenly: weight per length at its nodes, and what lies between them and its end.
  struct Weight {
    Eigen::VectorXd value, slope, beyond;
    double whole = 0.0;
  };
  const Weight* weight(int j) const { return chain_->piece(j).weighs_evenly ? nullptr : &own(j).weight; }

  /// Axial stiffness at the nodes of a rod that stretches.
  struct Axial {
    Eigen::VectorXd value, slope, bend;
  };
  const Axial& axial(int j) const { return own(j).axial; }

  /// int EI beta' beta'^T dsigma of a piece that does not bend evenly.
  const Eigen::MatrixXd& stiffness(int j) const;
  /// Coordinates y of a piece in which its elastic energy is |y|^2 / 2 but for rest curvature: q = factor inverse y.
  struct Unit {
    const Eigen::MatrixXd& inverse;
    double factor;
  };
  Unit unit(int j) const;
  /// factor times the derivative of v . K v by arc length l, K the second derivative of the energy of piece j by its
  /// coordinates.
  double stretching(int j, double factor, const double* v, int l) const;

 private:
  Unit unit_with_stretch(int j) const;
  double by_stretch(int j, const double* v, int l) const;

  struct Own {
    Bending bending;
    Weight weight;
    Axial axial;
    bool known = false, factored = false;  ///< the matrices, where the piece is now
    Eigen::MatrixXd stiffness, inverse;
  };
  const Own& own(int j) const { return own_[static_cast<std::size_t>(j)]; }

  const Chain* chain_;
  Eigen::VectorXd start_, length_;
  mutable std::vector<Own> own_;
  mutable Eigen::MatrixXd even_inverse_, weighted_;
  mutable Eigen::VectorXd turn_;
};

}  // namespace tendril
