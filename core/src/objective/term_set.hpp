#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "objective/term_units.hpp"
#include "rod/rod.hpp"
#include "tendril/nonlinear_program.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

/// A term and its weight (already divided by the objective's scale).
struct WeightedTerm {
  const ObjectiveTerm* term = nullptr;
  double weight = 1.0;
  std::string name;
  std::shared_ptr<std::string> fault{};  ///< where it was first no number, in words; null: nobody asks
};

/// Where the base quantities stand: the backbone quantities and variables through which every term sees x. -1: not
/// there.
struct BaseIndex {
  struct Point {
    int x = -1, y = -1, angle = -1, curvature = -1, strain = -1;
  };
  struct Contact {
    Point point;
    int force = -1, arc_length = -1, lean = -1;
  };
  Point tip;
  std::vector<Point> samples;  ///< of all terms, one after the other
  std::vector<Contact> contacts;
  std::vector<int> moments;  ///< one per actuator; -1: fixed at zero
  /// An actuator that is one.
  struct Tendon {
    int actuator = 0;
    int turn = -1;        ///< the work of a unit of its moment; -1: nobody reads it
    double offset = 0.0;  ///< Rod::Actuator::offset
  };
  std::vector<Tendon> tendons;
  std::vector<Point> deviations;  ///< of the tip: x and y
  int energy = -1;
  int port = -1;       ///< arc length at the port; -1: the rod is not drawn in or out
  int palm = -1;       ///< palm distance; -1: no variable
  bool thick = false;  ///< the gap depends on where along the rod the contact is
  int count = 0;
};

/// Of how many things terms see something.
struct TermCounts {
  int contacts = 0, moments = 0, tendons = 0, deviations = 0;
};

/// What a program knows at a point and terms read.
struct BaseValues {
  Eigen::VectorXd base;                ///< BaseIndex::count
  std::vector<SurfacePoint> surfaces;  ///< one per contact
  std::vector<Vec2> references;        ///< one per contact
  std::vector<Rod::Jet> radii;         ///< of the body, one per contact
  double palm = 0.0;                   ///< palm distance where it is no variable
};

/// One term with the storage that it reads from. It sees zeros wherever its Reads did not ask: a derivative can then
/// never be missing in silence.
class TermEvaluator {
 public:
  TermEvaluator(WeightedTerm term, const Target& target, const TermCounts& counts, const TermUnits& units);
  TermEvaluator(const TermEvaluator&) = delete;
  TermEvaluator(TermEvaluator&&) = default;
  TermEvaluator& operator=(const TermEvaluator&) = delete;
  TermEvaluator& operator=(TermEvaluator&&) = default;
  ~TermEvaluator() = default;

  const std::string& name() const { return weighted_.name; }
  const Reads& reads() const { return reads_; }
  int residual_count() const { return static_cast<int>(plain_.residuals.size()); }
  /// Weighted value at the last point.
  double value() const { return value_; }

  /// `first_sample`: where this term's samples start in BaseIndex::samples.
  void bind(const BaseIndex& index, std::size_t first_sample);
  void set_target(const Target& target);

  /// Reads the point and computes value, rest and residuals (residual_count() entries, times the root of the weight).
  void evaluate(const BaseValues& at, double& cost, double& rest, double* residuals);
  /// Adds gradients; row i of the Jacobian belongs to residual `first + i`.
  void differentiate(const BaseValues& at, Eigen::VectorXd& gradient, Eigen::VectorXd& rest_gradient,
                     Eigen::MatrixXd& jacobian, int first);
  void add_hessian(const BaseValues& at, double sigma, Eigen::MatrixXd& hessian);

 private:
  /// What the term sees and says, with the storage behind it.
  template <class T>
  struct View {
    View(const Reads& reads, const TermCounts& counts);
    Contribution<T> run(const ObjectiveTerm& term);

    std::vector<BackboneQuantities<T>> samples;
    std::vector<ContactQuantities<T>> contacts;
    std::vector<T> moments, tensions, shortenings;
    std::vector<TipDeviation<T>> deviations;
    Quantities<T> seen;
    std::vector<T> residuals;
  };
  enum class Kind { plain, gap, normal_x, normal_y };
  struct Input {
    double* value = nullptr;
    HyperDual* dual = nullptr;
    Kind kind = Kind::plain;
    int contact = -1;
    int base[3] = {-1, -1, -1};
    double unit = 1.0;    ///< of the quantity, in units of the scene
    double offset = 0.0;  ///< what the term sees where the quantity is 0
    double factor[3] = {1.0, 0.0, 0.0};
  };
  void add_input(double& value, HyperDual& dual, int base, double unit);
  void add_surface_input(double& value, HyperDual& dual, Kind kind, int contact);
  /// Derivatives of the inputs with respect to base quantities at the current surfaces.
  void refresh_factors(const BaseValues& at);
  void bind_contact(int contact);
  void read_inputs(const BaseValues& at);
  /// Keeps the place for a report if `value` is no number, though the term sees numbers, and none was before. It
  /// allocates then, and only then.
  void record_fault(double value, const char* what);
  /// Derivatives of the term by its inputs, times `weight`, into input_gradient_ and input_hessian_.
  void differentiate_twice(double weight);

  WeightedTerm weighted_;
  Reads reads_;
  TermUnits units_;
  const BaseIndex* index_ = nullptr;
  std::vector<Input> inputs_;
  double value_ = 0.0;

  View<double> plain_;
  View<HyperDual> dual_;
  std::vector<double> input_gradient_, input_hessian_;
};

/// The whole objective as a function of base quantities.
class TermSet {
 public:
  TermSet(const std::vector<WeightedTerm>& terms, const Target& target, const TermCounts& counts,
          const TermUnits& units);

  /// Whether any term reads this.
  bool reads(bool Reads::*what) const;
  std::vector<double> sample_arc_lengths() const;
  void bind(const BaseIndex& index);
  void set_target(const Target& target);

  int residual_count() const { return residual_count_; }
  std::size_t size() const { return terms_.size(); }
  const TermEvaluator& operator[](std::size_t i) const { return terms_[i]; }

  void evaluate(const BaseValues& at, double& cost, double& rest, Eigen::VectorXd& residuals);
  void differentiate(const BaseValues& at, Eigen::VectorXd& gradient, Eigen::VectorXd& rest_gradient,
                     Eigen::MatrixXd& jacobian);
  void add_hessian(const BaseValues& at, double sigma, Eigen::MatrixXd& hessian);

 private:
  std::vector<TermEvaluator> terms_;
  BaseIndex index_;
  int residual_count_ = 0;
};

}  // namespace tendril
