#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "objective/term_units.hpp"
#include "rod/backbone.hpp"
#include "rod/chain.hpp"
#include "rod/rod.hpp"
#include "rod/sections.hpp"
#include "tendril/nonlinear_program.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

class Curve;
struct Uncertainties;

/// One contact that a program plans with.
struct ContactSetup {
  int obstacle = 0;     ///< index in PoseProgramSpec::obstacles
  bool at_tip = false;  ///< at the rod's end; else inside
  /// Interior contacts: the stretch between fixed knots (split) or the piece (not split) in which the contact may
  /// slide.
  int region = 0;
  /// It sticks: its tangential force is a variable, and a row keeps the surfaces from sliding.
  bool sticks = false;
  /// It slips: the tangential part, along the turned normal, for each unit of the normal part.
  double lean = 0.0;
  bool operator==(const ContactSetup&) const = default;
};

/// From where a contact sticks.
struct Anchor {
  Vec2 point{};             ///< of the obstacle's surface
  Vec2 normal{};            ///< there
  double arc_length = 0.0;  ///< of the rod
  double angle = 0.0;       ///< of the rod there
  /// What the rod's surface slides along the turned normal per arc length by which the contact moves along the rod.
  double roll = 0.0;
  double slid = 0.0;  ///< to be made up for: what an earlier anchor took to be rolling was not
};

/// A point of the backbone that must stay outside an obstacle.
struct CheckPoint {
  int piece = 0;       ///< of the chain
  double sigma = 0.5;  ///< place on the piece, in [0,1]
  int obstacle = 0;    ///< index in PoseProgramSpec::obstacles
  bool operator==(const CheckPoint&) const = default;
};

/// What a program's rod carries besides moments and contact forces, and how far its obstacles are from their size: what
/// changes along a path of loads.
struct Loads {
  Vec2 gravity{};                ///< as Rod::gravity
  Vec2 tip_force{};              ///< as Rod::tip_force
  std::vector<double> shrink{};  ///< of each obstacle: its surface lies this much farther inward (units of L)
  double dead = 1.0;             ///< share of Rod::loads
  /// Of each obstacle: the tangential part of its contact forces, along the rod, for each unit of the normal part
  /// (w of model.md section 11). Empty: there is none.
  std::vector<double> friction{};
  /// Of each row of a shortening: what is held, which is subtracted there. Empty: nothing.
  std::vector<double> shortening{};
  std::vector<Anchor> anchors{};  ///< of each contact, for those that stick
};

/// What is known about a contact's complementarity g f = 0.
enum class Branch {
  open,      ///< g >= 0, f >= 0: someone else drives g f to zero
  touching,  ///< g = 0, f >= 0
  separated  ///< g >= 0, f = 0
};

/// A term of the objective and its weight.
struct PoseProgramTerm {
  const ObjectiveTerm* term = nullptr;  ///< borrowed
  double weight = 1.0;                  ///< dimensionless, > 0
  std::string name;                     ///< for reports
  /// where it was first no number, in words; null: nobody asks
  std::shared_ptr<std::string> fault{};
  bool operator==(const PoseProgramTerm&) const = default;
};

/// The palm that a finger stands on (model.md section 6, "grasp"). The program's frame is fixed to the object, whose
/// centre is the origin: the rod's base stands at `Rod::base` minus the palm distance times `axis`, so that every point
/// of the rod has the same constant derivative with respect to the distance.
struct PalmSetup {
  Vec2 axis{1.0, 0.0};   ///< unit vector away from the palm
  double minimum = 0.0;  ///< of the palm distance, units of L
  double maximum = 0.0;  ///< equal to the minimum: the distance is fixed, and no variable
  bool balance = true;   ///< whether sum_k f_k n_k . axis = 0 is a row
  bool loaded = false;   ///< the object is: that row is a force, also of one contact
  double load = 0.0;     ///< what these contacts carry of it along the axis, EI0/L^2
  /// Rows of the balance: along the axis, and in a program inside another one across it and about the object's centre.
  int parts = 1;
  bool operator==(const PalmSetup&) const = default;
};

/// How far the tip may be from the target, as rows. Infinity: there is no such row.
struct TargetTolerance {
  double position = infinity;  ///< units of L
  double angle = infinity;     ///< rad
  bool any() const { return position < infinity || angle < infinity; }
  bool operator==(const TargetTolerance&) const = default;
};

/// Everything that a pose program is assembled from. Pointers are borrowed and must outlive the program.
struct PoseProgramSpec {
  const Rod* rod = nullptr;                ///< dimensionless
  const CoordinateModel* model = nullptr;  ///< the local basis
  std::vector<const Obstacle*> obstacles;  ///< dimensionless; may be empty
  std::vector<PoseProgramTerm> terms;      ///< of the objective
  Target target;                           ///< for terms that read it
  TargetTolerance tolerance{};             ///< of the tip against the target
  bool split = true;                       ///< whether each interior contact has a knot of its own
  std::vector<ContactSetup> contacts;      ///< interior ones in order along the rod, then those at the tip
  std::vector<CheckPoint> checks;          ///< points kept outside of obstacles by a row each
  double checked_from = infinity;  ///< gap (L) above which rows of checks are lower bounds, and flat; obstacles stay
  int nodes = 0;                   ///< Gauss nodes per smooth interval of a piece
  double min_force = 0.0;          ///< of every contact, units of EI0/L^2
  double max_force = infinity;     ///< of every contact, units of EI0/L^2
  /// Of each obstacle, a coefficient: tangential parts of contact forces are variables, up to so much of the normal
  /// ones. Empty: contacts push along normals, or as Loads have it.
  std::vector<double> friction{};
  std::optional<PalmSetup> palm{};  ///< of a grasp
  int carried = 0;                  ///< the last so many obstacles stand on the palm: they move with the rod's base
  /// The last so many obstacles bound no body: they measure how far check points lie along a direction, for rows of a
  /// program that this one is a part of. No clearance is kept from them.
  int measures = 0;
  TermUnits term_units{};                                ///< in which terms see this rod
  std::shared_ptr<const Uncertainties> uncertainties{};  ///< for terms that read what these do to the tip
  std::shared_ptr<TableStore> tables{};  ///< shared by programs of one rod and model; null: each makes its own
  /// A row keeps the margin of stability (model.md section 7) at this or above; absent: there is no such row. Its
  /// second derivatives are learned from its gradients as the program is evaluated; everything else stays exact.
  std::optional<double> least_margin{};
  /// Rows keep d_ss (model.md section 7) of contacts that touch inside the rod at this or above, on both sides of the
  /// contact: beside it no check point can. Absent: there are no such rows. Second derivatives as above.
  std::optional<double> least_convexity{};
  /// Whether the same program comes out; of what is borrowed, whether it is the same object.
  bool operator==(const PoseProgramSpec&) const = default;
};

/// A shape to start from, whatever it was described with.
struct StartShape {
  std::function<double(double)> curvature;  ///< of the arc length s/L
  std::vector<double> moments{};            ///< one per actuator; empty: those that hold the shape without other loads
  std::vector<double> arc_lengths{};        ///< one per contact; empty or NaN: the nearest point
  std::vector<double> forces{};             ///< one per contact; empty: 0
  std::vector<double> leans{};              ///< ContactState::lean, one per contact; empty: 0
  std::function<double(double)> stretch{};  ///< of a rod that stretches, likewise; empty: none
  double palm_distance = std::numeric_limits<double>::quiet_NaN();  ///< NaN: where the shape nearly touches
  std::vector<double> moves{};  ///< of the rod, as Rod::moves; empty: where each of them starts
};

/// Constant curvature with this angle of the tip against the base.
TENDRIL_API StartShape constant_curvature(double tip_angle);

/// Contact points keep this distance (in L) from fixed knots and from each other: the equilibrium residual's floor
/// grows like 1e-17 / h (model.md section 2).
inline constexpr double knot_clearance = 1e-5;

/// The nonlinear program of one way of being in contact (model.md section 5). x = (q, moments, moves of the rod,
/// contact arc lengths, contact forces, their leans, palm distance, tangential forces where contacts stick), each block
/// only if needed. Exact first and second derivatives; no allocation after construction.
class TENDRIL_API PoseProgram : public NonlinearProgram {
 public:
  /// Assembles the program. Throws Error for a check point outside its piece.
  explicit PoseProgram(PoseProgramSpec spec);
  ~PoseProgram() override;

  /// Where each block of variables and rows begins, and how long it is.
  struct Layout {
    int coordinates = 0;       ///< length of q, which comes first
    int first_moment = 0;      ///< variable
    int moments = 0;           ///< actuators that are not fixed at zero
    int first_move = 0;        ///< variable
    int moves = 0;             ///< by which the rod is moved as a whole
    int first_arc_length = 0;  ///< variable, right behind these
    int arc_lengths = 0;       ///< interior contacts
    int first_force = 0;       ///< variable
    int forces = 0;            ///< all contacts
    int first_lean = 0;        ///< variable, right behind these
    int leans = 0;             ///< all contacts, where their tangential forces are variables
    int palm = -1;             ///< variable of the palm distance; -1: none, or fixed
    int first_shear = 0;       ///< variable
    int shears = 0;            ///< contacts that stick
    int first_gap = 0;         ///< row; one per contact, behind the equilibrium rows [0, coordinates)
    int first_closest = 0;     ///< row; one per contact
    int first_check = 0;       ///< row
    int checks = 0;            ///< check points
    int first_order = 0;       ///< row
    int orders = 0;            ///< pairs of contacts that must keep their order along the rod
    int first_balance = 0;     ///< row
    int balances = 0;          ///< PalmSetup::parts if the object of a grasp has to be in balance
    int first_target = 0;      ///< row
    int targets = 0;           ///< rows that keep the tip near the target: its position, its angle
    int first_margin = 0;      ///< row
    int margins = 0;           ///< 1 if the margin of stability is kept up
    int first_convexity = 0;   ///< row; two per contact inside the rod, before and behind it
    int convexities = 0;       ///< rows that keep contacts from spreading
    int first_shortening = 0;  ///< row
    int shortenings = 0;       ///< one for each tendon whose length is limited, or held
    int first_stick = 0;       ///< row; one per contact that sticks
    /// Of the arc lengths of Places: the moves, and those of contacts.
    int slides() const { return moves + arc_lengths; }
    int variables() const { return first_shear + shears; }
  };
  const Layout& layout() const;         ///< Where the blocks are.
  const PoseProgramSpec& spec() const;  ///< What it was assembled from.
  const Chain& chain() const;           ///< The rod's pieces.
  /// The moment variable of actuator a, or -1.
  int moment_variable(int actuator) const;
  /// The row of actuator a's shortening, or -1.
  int shortening_row(int actuator) const;
  /// Interior contact k's arc length variable, or -1 for a contact at the tip.
  int arc_length_variable(int contact) const;
  /// The chain's moving knots at x, which has to outlive them.
  std::span<const double> knots(ConstVectorRef x) const;
  /// Distance of the palm at x; 0 without a palm.
  double palm_distance(ConstVectorRef x) const;
  /// The force variable of contact k.
  int force_variable(int contact) const { return layout().first_force + contact; }
  /// The tangential force of contact k, or -1 where it does not stick.
  int shear_variable(int contact) const;

  /// Chooses the branch of contact k: changes bounds only. Calls invalidate().
  void set_branch(int contact, Branch branch);
  Branch branch(int contact) const;  ///< The branch that set_branch() chose; open at first.
  /// Another target for the rows and terms that read one. Calls invalidate().
  void set_target(const Target& target);
  /// Other loads and sizes of obstacles than those that it was assembled with; one that acts on nothing then has to
  /// stay zero. Calls invalidate().
  void set_loads(const Loads& loads);
  const Loads& loads() const;  ///< Of the next evaluation.

  /// A start of the given shape; contacts sit where the shape comes nearest to their obstacles unless the shape says
  /// where.
  Eigen::VectorXd start_from(const StartShape& shape) const;
  /// What x looks like, as a start of another program on the same rod: sampled curvature, moments, places and forces.
  StartShape shape_of(ConstVectorRef x) const;

  /// State at the point computed last.
  struct ContactState {
    double arc_length = 0.0;  ///< units of L
    Vec2 point{};             ///< units of L
    Vec2 tangent{};           ///< unit vector along the rod
    double angle = 0.0;       ///< of the rod, rad
    double force = 0.0;       ///< units of EI0/L^2
    Vec2 push{};              ///< per unit of it: the surface's normal, and the tangential part that goes with it
    double lean = 0.0;        ///< that part, along the turned normal
    double shear = 0.0;       ///< tangential force along the turned normal of a contact that sticks
    SurfacePoint surface{};   ///< the obstacle there, seen from the rod's body: its distance is the gap
    Rod::Jet radius{};        ///< of the body
  };
  /// All contacts, in the order of PoseProgramSpec::contacts.
  const std::vector<ContactState>& contacts() const;
  const Backbone& backbone() const;  ///< The rod's shape.
  const Sections& sections() const;  ///< The rod's sections there.
  /// Pi (model.md section 3) at x: bending energy less the work of loads and moments; contacts do not count.
  double potential(ConstVectorRef x);
  /// int p kappa ds along actuator a at the point evaluated last, p its profile.
  double turn_along(int actuator) const;
  /// Largest defect of the local balance of moments at x (model.md section 7). `curve`: of the rod's shape there.
  double moment_defect(ConstVectorRef x, const Curve& curve);
  /// How far the base stands from Rod::base.
  Vec2 base_shift() const;
  /// Weighted value of term i, and its name.
  double term_value(int i) const;

  std::string row_name(int row) const override;
  /// Name of the block and number inside it.
  std::string variable_name(int variable) const override;

  /// d_ss of contact k (model.md section 7) at the point computed last: the second derivative of its gap along the rod,
  /// on the side with more where the curvature jumps. Infinity at the tip.
  double contact_convexity(int contact) const;
  /// The same for a contact inside the rod, with its derivatives by all variables (variable_count() entries) at the
  /// point whose derivatives were computed last.
  double contact_convexity(int contact, VectorRef gradient) const;
  /// How the generalized force of contact k changes as the contact moves along the rod: coordinates() entries, at the
  /// point whose derivatives were computed last.
  void sliding_force(int contact, VectorRef out) const;
  /// What the body's surface slides at contact k along the obstacle's turned normal: its derivatives by all variables
  /// (variable_count() entries) at the point whose derivatives were computed last.
  void sliding_row(int contact, VectorRef out) const;
  /// Contact k held where it is at the point computed last.
  Anchor anchor(int contact) const;
  /// The forces of contact k at the point computed last have no potential: it slips, or a thick body rolls.
  bool dissipates(int contact) const;
  bool has_friction() const;  ///< Any does.

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override;
  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override;

 private:
  struct Data;
  void set_row_bounds();
  explicit PoseProgram(std::unique_ptr<Data> data);
  std::unique_ptr<Data> data_;
};

}  // namespace tendril
