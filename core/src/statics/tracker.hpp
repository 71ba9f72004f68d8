#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "statics/descent.hpp"
#include "statics/load_path.hpp"
#include "statics/statics.hpp"
#include "tendril/plan.hpp"

namespace tendril {

/// Where a contact is handed over to the next stretch or the tip (L).
inline constexpr double knot_distance = 1e-6;
/// What a tendon that is held by its length may be longer by, over the size of its largest offset, before it is taut.
inline constexpr double drawn = -1e-10;
/// Cosine between the tangents at both ends of a step, and with that at an event in between.
inline constexpr double straightness = 0.9;

/// A state together with the system that it solves.
struct Settled {
  std::unique_ptr<Statics> statics;
  Eigen::VectorXd z;
};

/// One jump, dimensionless.
struct TrackedSnap {
  SnapKind kind = SnapKind::fold;
  double load = 0.0;
  Settled before, after;
  double margin = 0.0;
};

/// Follows the stable equilibrium along a load path by arc-length continuation. Events (a contact made, released,
/// sliding over a knot or the tip, beginning or ceasing to slip, a tendon drawn taut or gone slack, a fold, a
/// bifurcation) are located exactly, each as one more equation with the load as its unknown, and the first along the
/// path is taken. A tendon that is held by its length is drawn taut as a contact is made, and goes slack as one is
/// released.
class Tracker {
 public:
  Tracker(const LoadPath& path, std::function<bool()> must_stop) : path_(path), must_stop_(std::move(must_stop)) {}

  /// What a start is to the equilibrium from which the path is followed: that itself, near it, or above it.
  enum class Start { exact, near, relax };
  /// Sets out from a guess at load 0. False: `trouble()` says why.
  bool begin(const State& guess, Start start);
  /// Follows the path to load 1.
  bool follow();
  /// Refines the basis where it stands until the local moment balance stops improving or is tiny.
  void refine_fully();

  const std::string& trouble() const { return trouble_; }
  /// The trouble is that the rod came to lie along an obstacle, where no point contact holds it.
  bool spread() const { return spread_; }
  Settled& current() { return now_; }
  std::vector<TrackedSnap>& snaps() { return snaps_; }
  int steps() const { return steps_; }
  int contact_changes() const { return contact_changes_; }
  int tendon_changes() const { return tendon_changes_; }
  int order() const { return order_; }

 private:
  enum class EventKind { end, release, touch, handover, tip_leaves, slip, stick, fold, bifurcation };
  struct Event {
    EventKind kind = EventKind::end;
    double tau = infinity;  ///< along the step
    int contact = -1;       ///< or another hold
    bool upward = false;
    double lean = 0.0;  ///< with which the contact slips from then on
    Eigen::VectorXd z{};
    Eigen::VectorXd direction{};
    std::unique_ptr<Statics> statics{};  ///< if another system than the current one
  };
  struct Step {
    Eigen::VectorXd z, tangent, row;
    double tau = 0.0;
    bool turned = false;  ///< the load falls again
    struct Handover {
      int contact = -1;
      bool upward = false;
    };
    std::optional<Handover> handover{};  ///< a contact reaches the end of its stretch
  };

  /// With the contacts and tendons of a state.
  std::unique_ptr<Statics> make(const State& state);
  /// Without hold k: a contact, or behind these a tendon.
  static void remove_contact(State& state, int k);
  void count_change(bool contact) { ++(contact ? contact_changes_ : tendon_changes_); }
  /// Newton at fixed load with contacts added and released until nothing is violated.
  std::optional<Settled> settle(State guess, double load);
  enum class Repair { needless, made, impossible };
  /// Changes the contacts of `guess` where the equilibrium found with them violates something.
  Repair repair(State& guess, Settled& s);
  Repair repair_penetration(State& guess, Settled& s);
  Repair repair_slack(State& guess, Settled& s);
  /// The actuator that is longest of the tendons that are longer than they are held; -1: none is.
  int longest_tendon(Statics& statics, const Eigen::VectorXd& z) const;
  bool rebuild();  ///< on the basis as it is set now
  bool resolve(double enough);
  bool coarse() const;
  void choose_nodes();

  bool advance();
  /// A contact handed over a knot may have carried the load past the end, which then lies at the knot itself.
  bool go_back_to_end();
  std::optional<Step> try_step(const Eigen::VectorXd& tangent, double length);
  /// Ends a step where a contact is handed over to the next stretch. False: it could not be located.
  bool end_at_knot(Step& step, const Eigen::VectorXd& tangent, double length, const Statics::NewtonResult& r);
  std::optional<Eigen::VectorXd> corrected(const Step& step, const Eigen::VectorXd& tangent, double tau);
  /// Every event inside a step; nothing if one was seen but could not be located.
  std::optional<std::vector<Event>> events(const Step& step, const Eigen::VectorXd& tangent);
  bool add_releases(const Step& step, std::vector<Event>& found);
  bool add_touches(const Step& step, std::vector<Event>& found);
  bool add_taut(const Step& step, std::vector<Event>& found);
  /// Where hold k of `state`, which is not yet one, begins to hold.
  bool add_hold(const Step& step, const State& state, int k, std::vector<Event>& found);
  bool add_tip(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found);
  /// Where contacts begin and cease to slip.
  bool add_friction(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found);
  bool add_slip(const Step& step, const Eigen::VectorXd& tangent, int k, std::vector<Event>& found);
  bool add_stick(const Step& step, const Eigen::VectorXd& tangent, int k, std::vector<Event>& found);
  bool add_instability(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found);
  /// Between the step's beginning and `until` along it the rod passes through an obstacle.
  bool passes_through(const Step& step, const Eigen::VectorXd& tangent, double until);
  bool take(Event& event);
  bool take_first(Event& event);
  /// Lets contacts stick or slip, each as it has to when the load grows from here. False: `trouble_` says why.
  bool choose_friction();
  /// The lean with which contact k has to slip from here on, 0 if it has to stick; nothing: it goes on as it does.
  std::optional<double> other_lean(int k, const Eigen::VectorXd& tangent);
  /// Lets contact k slip with a lean, or stick where it is.
  bool set_friction(int k, double lean);
  bool take_fold(Event& event);
  bool take_bifurcation(const Event& event);
  bool release(Event& event);
  bool pass_knot(Event& event);
  bool leave_tip(Event& event);
  /// The state below `from` moved along a critical direction to either side; nothing, and why, if none is found.
  std::optional<Settled> below(SnapKind kind, const Curvature& from, const Curvature& along, double load,
                               std::string& reason);
  bool snap(SnapKind kind, const Eigen::VectorXd& critical, const Eigen::VectorXd* direction, double load);
  /// Downhill at a load that may lie `extra` further, then exactly at the load itself.
  std::optional<Settled> fall(const Curvature& curvature, double load, double extra, double& energy);
  /// A contact with force has no more than this d_ss: `trouble_` says where.
  bool spreads(double least);
  bool turns_by_spreading();
  /// No step is short enough, and stability is lost right behind: at a seam of an obstacle, where its curvature jumps.
  bool ends_at_seam(const Eigen::VectorXd& tangent);
  /// Two obstacles leave the rod no room: `trouble_` says where.
  bool pinched();
  /// Tendons are held shorter than any shape of the rod lets them be together: `trouble_` says which.
  bool overdrawn();

  const LoadPath& path_;
  std::function<bool()> must_stop_;
  Settled now_;
  std::vector<TrackedSnap> snaps_;
  std::string trouble_;
  bool spread_ = false;
  double length_ = 0.05;  ///< of the next step
  int order_ = 12, pieces_ = 1, nodes_ = 30;
  int steps_ = 0, contact_changes_ = 0, tendon_changes_ = 0;
  bool done_ = false;
};

}  // namespace tendril
