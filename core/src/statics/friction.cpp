// Contacts that stick and slip along a path of loads (model.md section 11).

#include <algorithm>
#include <cmath>

#include "statics/tracker.hpp"
#include "tendril/numbers.hpp"

namespace tendril {
namespace {

constexpr double outside = 1e-12;  ///< tangential force beyond the cone that a step's end may show (EI/L^2)
constexpr double at_edge = 1e-9;   ///< share of the normal force by which a contact at the edge of its cone is inside
constexpr double moving = 1e-9;    ///< a rate along the path that is more than rounding
/// What a contact may be outside of its cone where the path begins: more, and its coefficient is another one now.
constexpr double other_cone = 1e-6;
/// Right behind where sliding ceases, along a step: what it slides back by until then is of the second order.
constexpr double slip_bracket = 1e-8;
constexpr int most_changes = 256;

/// Which way a contact slips counts, however little friction it has.
double side_of(double lean) { return lean < 0.0 ? -1.0 : 1.0; }

}  // namespace

bool Tracker::add_friction(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found) {
  if (!path_.is_rough()) return true;
  Statics& s = *now_.statics;
  for (int k = 0; k < s.contact_count(); ++k) {
    if (s.shear_index(k) >= 0 && !add_slip(step, tangent, k, found)) return false;
    if (s.contact(k).lean != 0.0 && !add_stick(step, tangent, k, found)) return false;
  }
  return true;
}

bool Tracker::add_slip(const Step& step, const Eigen::VectorXd& tangent, int k, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  const double coefficient = path_.coefficient(s.contact(k).obstacle);
  const double shear = step.z[s.shear_index(k)];
  Eigen::VectorXd row = Eigen::VectorXd::Zero(s.size() + 1);
  row[s.shear_index(k)] = shear < 0.0 ? -1.0 : 1.0;
  row[s.force_index(k)] = -coefficient;
  const double after = row.dot(step.z);
  if (!(after > outside)) return true;
  const double before = std::min(0.0, row.dot(now_.z));
  const bool inward = before > -outside && !(row.dot(tangent) > 0.0);
  Event e;
  e.kind = EventKind::slip;
  e.contact = k;
  e.lean = shear < 0.0 ? -coefficient : coefficient;
  e.z = now_.z + before / (before - after) * (step.z - now_.z);
  if (!s.solve(e.z, row, 0.0, 1e-9).converged) return false;
  e.tau = step.row.dot(e.z - now_.z);
  // From the edge, where the step begins, it goes in first, and out again only behind that.
  if (!(e.tau >= (inward ? moving : -1e-7) && e.tau <= step.tau + 1e-7)) return false;
  found.push_back(std::move(e));
  return true;
}

bool Tracker::add_stick(const Step& step, const Eigen::VectorXd& tangent, int k, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  const double lean = s.contact(k).lean;
  const auto with_friction = [&](const Eigen::VectorXd& z, const Eigen::VectorXd& along) {
    return s.sliding(z, along, k) * side_of(lean);
  };
  if (!(with_friction(step.z, step.tangent) > moving)) return true;
  Event e;
  e.kind = EventKind::stick;
  e.contact = k;
  e.z = step.z;
  double low = 0.0;
  double high = step.tau;
  while (high - low > slip_bracket) {
    const double middle = 0.5 * (low + high);
    const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
    if (!z) return false;
    const bool past = with_friction(*z, s.tangent(*z)) > 0.0;
    (past ? high : low) = middle;
    if (past) e.z = *z;
  }
  e.tau = high;
  found.push_back(std::move(e));
  return true;
}

std::optional<double> Tracker::other_lean(int k, const Eigen::VectorXd& tangent) {
  Statics& s = *now_.statics;
  const ContactSetup& setup = s.contact(k);
  const double coefficient = path_.coefficient(setup.obstacle);
  if (setup.lean != 0.0)
    return s.sliding(now_.z, tangent, k) * side_of(setup.lean) > moving ? std::optional(0.0) : std::nullopt;
  // What has just been touched, or comes from a result without friction, sticks first.
  if (!setup.sticks) return coefficient > 0.0 ? std::optional(0.0) : std::nullopt;
  const double shear = now_.z[s.shear_index(k)];
  const double most = coefficient * now_.z[s.force_index(k)];
  if (most - std::abs(shear) > at_edge * most + outside) return std::nullopt;
  const double rate = tangent[s.shear_index(k)];
  const double side = std::abs(shear) > outside ? shear : rate;
  const double lean = side < 0.0 ? -coefficient : coefficient;
  const bool leaves = (side < 0.0 ? -rate : rate) - coefficient * tangent[s.force_index(k)] > moving;
  return leaves || std::abs(shear) - most > other_cone * (1.0 + most) ? std::optional(lean) : std::nullopt;
}

bool Tracker::set_friction(int k, double lean) {
  State state = now_.statics->state(now_.z);
  PointContact& c = state.contacts[static_cast<std::size_t>(k)];
  if (lean == 0.0) {
    c.anchor = now_.statics->anchor(now_.z, k);
    c.shear = c.setup.lean * c.force;
  }
  c.setup.sticks = lean == 0.0;
  c.setup.lean = lean;
  std::unique_ptr<Statics> statics = make(state);
  Eigen::VectorXd z = statics->point(state);
  if (!statics->solve_at_load(z, state.load, 1e-9).converged) {
    trouble_ = "a contact that begins or ceases to slip could not be followed";
    return false;
  }
  now_ = {std::move(statics), std::move(z)};
  return true;
}

/// One contact after the other is changed that cannot go on as it does, the first along the rod first, which ends where
/// the rates of the contacts decide each other's states (Murty's least-index method).
bool Tracker::choose_friction() {
  if (!path_.is_rough() || done_) return true;
  for (int change = 0; change < most_changes; ++change) {
    now_.statics->anchor(now_.z);
    const Eigen::VectorXd tangent = now_.statics->tangent(now_.z);
    std::optional<double> lean;
    int changed = 0;
    for (int k = 0; k < now_.statics->contact_count() && !lean; ++k) {
      lean = other_lean(k, tangent);
      changed = k;
    }
    if (!lean) return true;
    if (!set_friction(changed, *lean)) return false;
  }
  trouble_ = "the rod gives way at load fraction " + shown(now_.z[now_.statics->size()], 9) +
             ": whichever contacts stick or slip, it does not stay at rest";
  return false;
}

}  // namespace tendril
