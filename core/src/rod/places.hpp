#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "rod/backbone.hpp"
#include "rod/moving_point.hpp"
#include "rod/rod.hpp"
#include "rod/sections.hpp"

namespace tendril {

class Curve;

/// A row of derivatives that is written in two parts: by the coordinates and by the arc lengths.
struct RowPart {
  double* q = nullptr;
  double* s = nullptr;
};

/// What second derivatives are added to: by coordinates twice, by coordinates and arc lengths, by arc lengths twice.
/// Without entries in `ss` these are left out.
struct SecondPart {
  MatrixRef qq, qs, ss;
};

/// What acts on a place: the derivative of some sum by its position, its angle and the rod's curvature and stretch
/// there.
struct Push {
  Vec2 force{};
  double moment = 0.0;
  ///@{
  /// on places inside of pieces only
  double bending = 0.0;
  double strain = 0.0;
  ///@}
};

/// Forces on a rod: on its places, on its tip, and on all of its mass.
struct Forces {
  std::vector<Push> on;  ///< one per place; nothing acts on those behind its end
  Vec2 tip{};            ///< on the end of the rod
  Vec2 gravity{};        ///< per weight
  double payload = 0.0;  ///< weight at the end of the rod
  Vec2 dead{};           ///< the rod's own dead loads, stretched and turned by this complex number
  Vec2 dead_load(Vec2 load) const { return dead.x * load + dead.y * turned(load); }
};

/// Places on a rod, through which everybody else sees its shape: where they are, and how they move with the
/// coordinates q and with arc lengths s. These are, in this order: what the rod is moved by (Rod::moves), which are arc
/// lengths only where it is drawn into its port; then the other moving knots of the chain or, where contacts have none,
/// the places themselves. Sums over nodes, angles, sines and cosines stay in here. Nothing allocates after the last
/// place was added.
class TENDRIL_API Places {
 public:
  /// On rods with this chain, which is borrowed. `contacts`: arc lengths beside those that the rod is moved by.
  Places(const Rod& rod, const Chain& chain, int contacts);

  int add_knot(int piece);  ///< The end of a piece.
  int add_tip() { return add_knot(chain_->piece_count() - 1); }
  int add_sliding(int piece, int contact);  ///< Inside a piece, at a contact's arc length that is no knot.
  int add_fixed(double arc_length);         ///< At a fixed arc length, whatever piece holds it.
  /// A fixed sigma in (0,1] of a piece.
  struct Station {
    int piece;
    double sigma;
  };
  /// All stations at once: the place of each. Those that are asked for twice are the same place.
  std::vector<int> add_stations(std::span<const Station> stations);

  const Backbone& backbone() const { return backbone_; }
  const Sections& sections() const { return sections_; }
  /// Where the next move() begins, but for what it says itself.
  void place(Vec2 base) { origin_ = base; }
  /// Moves to coordinates and arc lengths.
  void move(ConstVectorRef q, std::span<const double> arc_lengths);

  int count() const { return static_cast<int>(places_.size()); }
  int arc_lengths() const { return arc_lengths_; }
  /// The place moves with so many coordinates, the first ones.
  int reach(int place) const { return (at(place).piece + 1) * chain_->functions(); }
  Vec2 point(int place) const { return at(place).point; }
  /// Not of stations; nor is the angle.
  Vec2 tangent(int place) const;
  double angle(int place) const;

  /// Radius of the body at a place, with its derivatives by the arc length there.
  Rod::Jet radius(int place) const;
  /// How fast the arc length of a place runs with arc length l.
  double running(int place, int l) const;

  /// The rod's curvature right before a place (0) or behind it (1), which may jump at ends of pieces.
  struct Side {
    int piece = 0;
    enum { start, inside, end } where = end;
    double curvature = 0.0;
    double stretch = 1.0;  ///< 1 + eps there
    /// Of the line that the rod is.
    double bend() const { return curvature / stretch; }
  };
  Side side(int place, int which) const;

  /// Prepares the derivatives at the point moved to last.
  void differentiate();
  /// n . dP of a place: by the coordinates up to its piece, and by all arc lengths.
  void row(int place, Vec2 n, RowPart out) const;
  void angle_row(int place, RowPart out) const;  ///< Likewise, of its angle.
  /// Adds the derivatives of the curvature beside a place, times a factor.
  void add_curvature_row(int place, const Side& side, double factor, RowPart out) const;
  void add_bend_row(int place, const Side& side, double factor, RowPart out) const;  ///< Likewise of Side::bend().
  /// Likewise of the stretch there.
  void add_stretch_row(int place, const Side& side, double factor, RowPart out) const;

  /// Virtual displacements of all places along coordinates: dP/dq times `lambda`, after differentiate().
  void displace(const double* lambda);
  Vec2 displacement(int place) const { return at(place).displacement; }
  double rotation(int knot) const { return psi_knot_[at(knot).piece + 1]; }  ///< Likewise, of the end of a piece.
  /// n . d(displacement), as row().
  void displacement_row(int place, Vec2 n, RowPart out) const;

  /// What fixed forces do on the way from the base to where they act.
  double work(const Forces& forces);
  /// Largest defect of the local balance of moments under forces and the moments of actuators. `curve`: of the
  /// backbone.
  double moment_defect(const Forces& forces, std::span<const double> moments, const Curve& curve);
  /// The same of the balance of forces along a rod that stretches, as a strain.
  double stretch_defect(const Forces& forces, std::span<const double> moments);
  /// out += derivative by the coordinates of the forces' work at fixed forces.
  void pull_back(const Forces& forces, double* out);
  /// The work of an actuator by a unit of its moment: int p kappa ds, p its profile, and thrust times int eps ds.
  double turn_along(int actuator) const;
  /// out += its derivatives.
  void add_turn_row(int actuator, RowPart out);
  /// Adds its second derivatives times a factor, by coordinates and arc lengths and by arc lengths twice.
  void add_turn_second(int actuator, double factor, const SecondPart& out);
  /// out += moment * derivative of the former by the coordinates, for p = 1 of the angle over its span, and pull *
  /// derivative of the latter.
  void pull_back_moment(int actuator, double moment, double pull, double* out) const;
  /// The latter along coordinates.
  double stretch_along(int actuator, const double* coordinates) const;
  /// Derivatives of the former by the arc lengths, which move the pieces along the profile: adds to `by_q_and_s`.
  void add_moment_rates(int actuator, double moment, double pull, MatrixRef by_q_and_s);
  /// Adds second derivatives of  lambda . (what pull_back_moment() adds):  by the moment, of which the pull changes by
  /// `pull_slope`, and the arc lengths, by the arc lengths twice.
  void add_moment_second(int actuator, double moment, double pull_slope, const double* lambda,
                         VectorRef by_moment_and_s, MatrixRef by_s_twice);
  /// Adds second derivatives of the forces' work at fixed forces and, if there are `virtual_forces`, of these forces'
  /// work on the virtual displacements. With `ss` the former act on places alone.
  void second_pull_back(const Forces& forces, const Forces* virtual_forces, SecondPart out);

  /// The elastic energy: of bending, V_c (model.md section 3), and of the stretch, V_e (section 14).
  double energy() const;
  /// out += factor * dV; without a place for it not by the arc lengths.
  void add_energy_row(double factor, RowPart out) const;
  /// Adds second derivatives of  factor V - lambda . dV/dq;  without lambda of the first part.
  void add_energy_second(double factor, const double* lambda, SecondPart out) const;

 private:
  enum class Kind { knot, inside, station };
  struct Place {
    Kind kind = Kind::knot;
    int piece = 0;
    int own = -1;         ///< number among the places inside of pieces, or among the stations of its piece
    int arc_length = -1;  ///< which one it slides with
    double fixed = 0.0;   ///< its arc length, if it is inside and does not slide
    Vec2 point{}, displacement{};
  };
  struct Stations {
    std::vector<int> place;
    std::vector<double> sigma;
    Eigen::MatrixXd by_node;           ///< stations x nodes: int_0^sigma as weights on the nodes
    Eigen::MatrixXd sum;               ///< 2 functions x stations: int_0^sigma (dP' by the coordinates) dsigma
    Eigen::VectorXd chord_x, chord_y;  ///< int_0^sigma P' dsigma
    Eigen::VectorXd push_x, push_y;    ///< buffers
  };
  /// A force on the nodes of a piece: end + (1 - sigma) slope, and where its weight varies heavy times share, a number
  /// per node.
  struct Ramp {
    Vec2 end{}, slope{}, heavy{};
    const double* share = nullptr;
    /// What has its component across the rod along it.
    Ramp across() const { return {-turned(end), -turned(slope), -turned(heavy), share}; }
    friend Ramp operator*(double factor, const Ramp& r) {
      return {factor * r.end, factor * r.slope, factor * r.heavy, r.share};
    }
  };
  class Sweep;

  const Place& at(int place) const { return places_[static_cast<std::size_t>(place)]; }
  std::size_t own(int place) const { return static_cast<std::size_t>(at(place).own); }
  /// How fast a place inside a piece runs along it with arc length l.
  double own_rate(const Place& p, int l) const;
  void row_of(const Integrals& field, const Eigen::MatrixXd& rates, const Place& p, Vec2 value, Vec2 n,
              RowPart out) const;
  /// Derivatives of a field's knots by the arc lengths: x and y, one after the other, by knots.
  void find_rates(const Integrals& field, Eigen::MatrixXd& rates) const;
  void weigh(int j, const Ramp& along, const Ramp* turning, double* z) const;
  void add_unit_weight(int j, const Ramp& along, const double* factors, double* z) const;
  void add_stretch_gram(int j, const Sweep& sweep, const Sweep* turning, bool pushed);
  void add_stretch_rate(int j, int l, const Sweep& sweep, const Sweep* turning, bool pushed);
  /// How fast sigma of piece j runs along the rod with arc length l.
  double run(int j, double sigma, int l) const { return start_rate_(j, l) + sigma * length_rate_(j, l); }
  Vec2 line_rate(int j, int l) const { return {line_rate_(2 * j, l), line_rate_(2 * j + 1, l)}; }
  /// Nothing in piece j moves with arc length l, nor does what pulls behind it change.
  bool still(int j, int l) const {
    return length_rate_(j, l) == 0.0 && mass_rate_(j, l) == 0.0 && line_rate(j, l) == Vec2{} &&
           (chain_->piece(j).weighs_evenly || start_rate_(j, l) == 0.0);
  }
  static const Push& on(int place, const Forces& forces) {
    static constexpr Push nothing{};
    const auto k = static_cast<std::size_t>(place);
    return k < forces.on.size() ? forces.on[k] : nothing;
  }
  /// Forces may act on stations of a piece, which are numbered in order.
  bool may_push(int j, const Forces& forces) const {
    const std::vector<int>& stations = stations_[static_cast<std::size_t>(j)].place;
    return !stations.empty() && static_cast<std::size_t>(stations.front()) < forces.on.size();
  }
  bool gather_pushes(int j, const Forces& forces);
  /// As row(), of a base that is not shifted.
  void row_from_base(int place, Vec2 n, RowPart out) const;
  void add_second(const Forces& forces, const Forces* virtual_forces, SecondPart& out);
  void add_turn(const Forces& forces, const Forces* virtual_forces, SecondPart& out);
  double moment_defect(int j, const Ramp& load, const Forces& forces, std::span<const double> moments,
                       const Curve& curve, double& beyond);
  void add_inside(const Forces& forces, const Forces* virtual_forces, int j, SecondPart& out);
  void add_inside_stretch(const Place& p, const Push& push, Vec2 v, bool turns, SecondPart& out);
  double stretch_energy() const;
  void add_stretch_energy_row(double factor, RowPart out) const;
  void add_stretch_energy_second(double factor, const double* lambda, SecondPart out) const;
  double varying_energy(int j) const;
  void add_varying_row(int j, double factor, RowPart out) const;
  void add_varying_second(int j, double factor, const double* lambda, SecondPart out) const;

  const Chain* chain_;
  Backbone backbone_;
  Sections sections_;
  std::vector<Rod::Move> shifts_;  ///< the first arc lengths, which move the base and no knot
  int turn_ = -1;                  ///< that of them which turns it
  int moves_ = 0;                  ///< arc lengths that belong to no contact
  int arc_lengths_ = 0;
  Vec2 origin_{};       ///< of the base, before it is shifted
  double angle_ = 0.0;  ///< of a base that does not turn
  std::vector<Place> places_;
  std::vector<MovingPoint> moving_;
  std::vector<int> knots_;          ///< places at ends of pieces
  std::vector<int> inside_;         ///< places that the moving points stand for
  std::vector<Stations> stations_;  ///< per piece
  Eigen::VectorXd left_;            ///< 1 - sigma at the nodes
  /// d length_j / d s_l and d (mass beyond j) / d s_l; zero where places slide.
  Eigen::MatrixXd length_rate_, start_rate_, mass_rate_;
  Eigen::MatrixXd line_rate_;  ///< likewise of the dead force on what is beyond j, x and y one after the other
  bool dead_ = false;          ///< the rod has dead loads
  Eigen::VectorXd by_s_;       ///< what nobody asks for
  Eigen::MatrixXd still_;      ///< likewise
  Eigen::MatrixXd psi_, eta_;  ///< nodes x pieces: virtual rotation, and growth along the tangent
  Eigen::VectorXd psi_knot_;
  Integrals virtual_;
  Eigen::MatrixXd rates_, virtual_rates_;  ///< 2 arc lengths x (pieces + 1)
  Eigen::VectorXd stiff_;                  ///< int beta' beta'^T times the coordinates, by pieces that bend evenly
  Eigen::MatrixXd bent_;                   ///< dphi/dsigma at the nodes of the others
  Eigen::MatrixXd strain_;                 ///< eps at the nodes of a rod that stretches
  mutable Eigen::VectorXd along_nodes_, virtual_bent_;
  PieceSums sums_, gram_sums_;
  std::vector<PieceSums> rate_sums_;  ///< one per arc length
  Eigen::VectorXd node_buffer_, push_along_, push_across_, third_;
  Eigen::VectorXd unit_buffer_, unit_push_along_, unit_push_across_;  ///< of a rod that stretches, with unit tangents
  mutable Eigen::VectorXd heavy_;                                     ///< at nodes
  Forces back_;                                                       ///< of a base that turns, as what follows
  Eigen::VectorXd lambda_, row_buffer_;
  Eigen::MatrixXd second_buffer_;
};

}  // namespace tendril
