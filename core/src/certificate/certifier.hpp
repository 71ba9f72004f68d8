#pragma once

#include <memory>

#include "certificate/clearance.hpp"
#include "program/pose_program.hpp"
#include "tendril/certificate.hpp"

namespace tendril {

/// Fills `failures` from the numbers: one line for each requirement that is not met.
TENDRIL_API void list_failures(Certificate& certificate);

/// Whether nothing but stability, in the plane or out of it, is missing.
TENDRIL_API bool only_unstable(const Certificate& certificate);

/// The worse of two judgements in every number, and the failures of both.
TENDRIL_API Certificate worse_of(const Certificate& a, const Certificate& b);

/// Judges points of one pose program without asking a solver (model.md section 7): on a rule with twice the nodes,
/// where the program's own is not proven to be exact, with the true shape between check points, and with the stability
/// of the equilibrium itself.
class TENDRIL_API Certifier {
 public:
  /// `spec` is that of the program to be judged; its pointers must outlive this. Everything is read on twice the nodes.
  explicit Certifier(const PoseProgramSpec& spec);
  /// For the points of this program alone, which must outlive this: where its rule is exact it is read itself, and
  /// where it was evaluated last nothing is evaluated again.
  explicit Certifier(PoseProgram& judged);
  ~Certifier();
  Certifier(Certifier&&) noexcept;             ///< Leaves the other one unusable.
  Certifier& operator=(Certifier&&) noexcept;  ///< Leaves the other one unusable.

  /// Judges x of `program`, whose branches say which contacts touch.
  Certificate certify(PoseProgram& program, ConstVectorRef x);
  /// The same into `out`, whose memory is used again. `multipliers` and `bound_multipliers` (of the program's rows and
  /// variables, or null) are tried first: where they have the right signs and leave no slope, no others are looked for.
  /// Then a valid certificate allocates nothing after the first of one number of pressing contacts.
  void certify(PoseProgram& program, ConstVectorRef x, Certificate& out, const Eigen::VectorXd* multipliers,
               const Eigen::VectorXd* bound_multipliers);
  /// The part of the judgement that concerns the rod alone: everything but balance, stationarity and the list of
  /// failures, which a larger program around this one has its own of. `x` must be finite.
  void measure(PoseProgram& program, ConstVectorRef x, Certificate& out);
  /// The same without the local moment balance, for which no point is refused.
  void judge(PoseProgram& program, ConstVectorRef x, Certificate& out);
  /// The target of the program to be judged is another from now on.
  void set_target(const Target& target);

  /// Local minima of the distance to any obstacle below `level` at x.
  struct Approach {
    int obstacle = 0;    ///< index in the spec's obstacles
    ClosestApproach at;  ///< the place on the rod
  };
  /// All such places at x, for `level` in units of L.
  std::vector<Approach> approaches(ConstVectorRef x, double level);
  /// The program that x is read from, on a rule that is fine enough, moved there: what is read between nodes is read
  /// from this one.
  const PoseProgram& finer(ConstVectorRef x);
  /// The curve of the rod there: where finer() or a judgement was asked for last.
  const Curve& curve() const;
  /// Whether there is any; allocates nothing unless there is.
  bool approached(ConstVectorRef x, double level);

  /// As PoseProgram::set_loads().
  void set_loads(const Loads& loads);
  /// Largest defect of the local moment balance at x (model.md section 7).
  double moment_balance(ConstVectorRef x);
  /// The margin alone: smallest eigenvalue of the second variation against the bending energy (model.md section 7).
  double stability(ConstVectorRef x);
  /// The matrix whose definiteness is asked for, at x: H before projection. coordinates() squared.
  Eigen::MatrixXd second_variation(ConstVectorRef x);
  /// d_ss of contact k at x; infinity for a contact at the tip.
  double contact_convexity(ConstVectorRef x, int contact);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Force of all contacts on the finger along its palm's axis beyond what they carry, EI/L^2, at the point evaluated
/// last.
double axial_force(const PoseProgram& program);

}  // namespace tendril
