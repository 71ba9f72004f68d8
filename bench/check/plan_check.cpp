#include "check/plan_check.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "check/body.hpp"
#include "check/rod.hpp"
#include "check/touch.hpp"
#include "tendril/error.hpp"

namespace tendril::bench {
namespace {

/// A defect is one that exceeds what the certificate promises (model.md section 7) by a factor of two: this check
/// rounds differently. `data` is what the 12 digits to which a program's data are rounded can do: times the loads (to
/// moments and forces) or the coordinates of an obstacle (to distances).
constexpr double equilibrium_limit = 2e-9;
constexpr double penetration_limit = 2e-9;
constexpr double contact_limit = 2e-9;
constexpr double closest_point_limit = 2e-8;
constexpr double bounds_limit = 2e-9;
constexpr double data = 1e-11;
/// (L, rad) The tip, which every rule integrates whole.
constexpr double shape_limit = 1e-9;
/// (L) Between nodes a sample stands on the interpolating polynomial of a rule that the certificate found fine enough.
constexpr double sample_limit = 1e-9;
/// What the certificate asks for. Differences of the equilibrium leave some 1e-9 in the margins of the campaign's
/// plans.
constexpr double margin_limit = 1e-6;
/// (EI/L^2) A contact with less force does not hold the rod.
constexpr double pressing = 1e-9;

class Judge {
 public:
  Judge(const Scene& scene, const Plan& plan) : scene_(scene), plan_(plan), rod_(scene, plan) {
    length_ = scene.rod.length();
    unit_force_ = scene.rod.segments.front().bending_stiffness / (length_ * length_);
    if (scene.contact.mode != ContactModeName::ignore) {
      for (const ObstacleSpec& spec : scene.obstacles) bodies_.push_back(body_of(spec, scene.read_quantity, length_));
    }
    std::vector<double> moving;
    for (const PlannedContact& c : plan.contacts) {
      Touch touch;
      touch.body = static_cast<std::size_t>(c.obstacle);
      touch.at_tip = c.at_tip;
      touch.s = c.at_tip ? 1.0 : c.arc_length / length_;
      touch.force = c.force / unit_force_;
      if (c.tangential != 0.0) {
        touch.lean = c.tangential / c.force * dot(c.tangent, turned(c.normal));
        touch.sticks = c.sticks;
      }
      rod_.loads += std::abs(touch.force);
      touches_.push_back(touch);
      if (!c.at_tip && plan.split_at_contact) moving.push_back(touch.s);
    }
    order_ = plan.order;
    q_ = Eigen::Map<const Eigen::VectorXd>(plan.coordinates.data(), static_cast<Eigen::Index>(plan.coordinates.size()));
    shape_.emplace(rod_, moving, q_.size(), order_);
    for (Touch& touch : touches_) look_beside(bodies_[touch.body], *shape_, q_, touch);
  }

  PlanCheck judge();

 private:
  double gap(std::size_t body, Vec2 at, Vec2& normal) const {
    return bodies_[body].distance(at, normal) - bodies_[body].radius;
  }
  /// Tangent . normal, the slope of the distance along the rod.
  double slope(const Eigen::VectorXd& q, const Touch& touch, double s) const;
  /// Contacts at their arc lengths, which hold the rod along their obstacles' normals there.
  std::vector<Hold> holds(const Eigen::VectorXd& q) const;
  /// The same where those with tiny round obstacles have slid along to the closest point.
  std::vector<Hold> followed_holds(const Eigen::VectorXd& q) const;
  /// Residual of the equilibrium; `pull`: what a unit force of each contact does.
  Eigen::VectorXd residual(const Eigen::VectorXd& q, const std::vector<Hold>& by, Eigen::MatrixXd& pull) const;
  void contacts(PlanCheck& check, double tolerance);
  double penetration(const RodShape::Grid& g);
  /// What the rounding of data does to the equilibrium: it turns the normals of small obstacles.
  double turning_allowance() const;
  double margin();
  /// What contacts that press keep as it is, and what they push along, a column each.
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> holding(const std::vector<std::size_t>& pressing_ones);
  /// How the residual changes as contact k alone is moved along the rod.
  Eigen::VectorXd moved_along(std::size_t k);
  void limits(PlanCheck& check) const;

  const Scene& scene_;
  const Plan& plan_;
  Loaded rod_;
  double length_ = 1.0, unit_force_ = 1.0;
  std::vector<Body> bodies_;
  std::vector<Touch> touches_;
  int order_ = 1;
  Eigen::VectorXd q_;
  std::optional<RodShape> shape_;
  std::size_t deepest_ = 0;
};

double Judge::slope(const Eigen::VectorXd& q, const Touch& touch, double s) const {
  const RodShape::Point p = shape_->point(q, s);
  return dot({std::cos(p.angle), std::sin(p.angle)}, normal_of(bodies_[touch.body], touch, p.at));
}

std::vector<Hold> Judge::holds(const Eigen::VectorXd& q) const {
  std::vector<Hold> all;
  for (const Touch& touch : touches_) {
    const Vec2 at = shape_->point(q, touch.s).at;
    all.push_back({at, normal_of(bodies_[touch.body], touch, at)});
  }
  return all;
}

std::vector<Hold> Judge::followed_holds(const Eigen::VectorXd& q) const {
  std::vector<Hold> all = holds(q);
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    if (touches_[k].followed) all[k] = followed_hold(touches_[k], shape_->point(q, touches_[k].s));
  }
  return all;
}

Eigen::VectorXd Judge::residual(const Eigen::VectorXd& q, const std::vector<Hold>& by, Eigen::MatrixXd& pull) const {
  std::vector<double> cuts;
  for (const Touch& touch : touches_) cuts.push_back(touch.s);
  const RodShape::Grid g = shape_->grid(q, cuts);
  Eigen::VectorXd r = Eigen::VectorXd::Zero(q.size());
  pull.setZero(q.size(), static_cast<Eigen::Index>(touches_.size()));
  for (std::size_t i = 0; i < g.s.size(); ++i) {
    const Stretch& segment = rod_.segments[shape_->pieces()[g.piece[i]].segment];
    double moment =
        cross(g.tip - g.at[i], rod_.tip_force) + cross(g.load_moment[i] - g.load[i] * g.at[i], rod_.gravity);
    for (const Span& a : rod_.actuators) {
      if (g.s[i] > a.from && g.s[i] < a.to) moment += a.moment;
    }
    const auto first = static_cast<Eigen::Index>(g.piece[i]) * order_;
    const auto slopes = g.slopes.col(static_cast<Eigen::Index>(i));
    for (std::size_t k = 0; k < touches_.size(); ++k) {
      if (g.s[i] > touches_[k].s) continue;
      const double lever = cross(by[k].at - g.at[i], by[k].normal + touches_[k].lean * turned(by[k].normal));
      moment += touches_[k].force * lever;
      pull.col(static_cast<Eigen::Index>(k)).segment(first, order_) += (g.weight[i] * lever) * slopes;
    }
    r.segment(first, order_) += (g.weight[i] * (segment.stiffness * (g.curvature[i] - segment.rest) - moment)) * slopes;
  }
  return r;
}

double Judge::penetration(const RodShape::Grid& g) {
  double deepest = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Vec2 normal{};
    std::vector<double> s{0.0};
    std::vector<double> distance{gap(b, rod_.base, normal)};
    for (std::size_t i = 0; i < g.s.size(); ++i) {
      s.push_back(g.s[i]);
      distance.push_back(gap(b, g.at[i], normal));
    }
    s.push_back(1.0);
    distance.push_back(gap(b, g.tip, normal));
    const double allowed = penetration_limit + data * bodies_[b].size;
    double own = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      const bool valley =
          (i == 0 || distance[i] <= distance[i - 1]) && (i + 1 == s.size() || distance[i] <= distance[i + 1]);
      // Between two nodes the distance changes by less than they are apart.
      const double step = std::max(i > 0 ? s[i] - s[i - 1] : 0.0, i + 1 < s.size() ? s[i + 1] - s[i] : 0.0);
      if (!valley || distance[i] > step) continue;
      double low = s[i == 0 ? 0 : i - 1];
      double high = s[std::min(i + 1, s.size() - 1)];
      const auto at = [&](double where) { return gap(b, shape_->point(q_, where).at, normal); };
      constexpr double golden = 0.6180339887498949;
      for (int round = 0; round < 60 && high - low > 1e-12; ++round) {
        const double left = high - golden * (high - low);
        const double right = low + golden * (high - low);
        (at(left) < at(right) ? high : low) = at(left) < at(right) ? right : left;
      }
      own = std::max({own, -distance[i], -at(0.5 * (low + high))});
    }
    if (own > allowed && own - allowed > deepest) {
      deepest = own;
      deepest_ = b;
    } else {
      deepest = std::max(deepest, std::min(own, penetration_limit));
    }
  }
  return deepest;
}

void Judge::contacts(PlanCheck& check, double tolerance) {
  check.contact = 0.0;
  check.closest_point = 0.0;
  for (const Touch& touch : touches_) {
    const RodShape::Point p = shape_->point(q_, touch.s);
    Vec2 normal{};
    const double distance = gap(touch.body, p.at, normal);
    const double slope = std::cos(p.angle) * normal.x + std::sin(p.angle) * normal.y;
    const double slack = tolerance + data * bodies_[touch.body].size;
    const double open = touch.force > pressing ? std::abs(distance) : std::min(distance, touch.force);
    check.contact = std::max(check.contact, open);
    if (open > slack) {
      check.defects.push_back(fmt::format("a contact with force {:.3g} has a gap of {:.2e}", touch.force, distance));
    }
    if (touch.force <= pressing) continue;
    const double off = touch.at_tip ? std::max(0.0, slope) : std::abs(slope);
    check.closest_point = std::max(check.closest_point, off);
    // The normal of a small circle turns by the gap over its radius.
    const double turn = slack / std::max(bodies_[touch.body].radius, slack);
    const double allowed = closest_point_limit + (bodies_[touch.body].half_plane ? 0.0 : turn);
    if (off > allowed) check.defects.push_back(fmt::format("a contact is no closest point: {:.2e}", off));
  }
}

double Judge::turning_allowance() const {
  double sum = 0.0;
  for (const Touch& touch : touches_) {
    const Body& body = bodies_[touch.body];
    if (!body.half_plane) sum += std::abs(touch.force) * data * body.size / std::max(body.radius, data);
  }
  return sum;
}

Eigen::VectorXd Judge::moved_along(std::size_t k) {
  constexpr double step = 1e-5;
  const double s = touches_[k].s;
  Eigen::MatrixXd unused;
  const auto at = [&](double where) {
    touches_[k].s = where;
    return residual(q_, holds(q_), unused);
  };
  const bool at_end = s + step > 1.0;
  Eigen::VectorXd change =
      at_end ? (3.0 * at(s) - 4.0 * at(s - step) + at(s - 2.0 * step)).eval() : (at(s + step) - at(s - step)).eval();
  touches_[k].s = s;
  return change / (2.0 * step);
}

std::pair<Eigen::MatrixXd, Eigen::MatrixXd> Judge::holding(const std::vector<std::size_t>& pressing_ones) {
  Eigen::MatrixXd pull;
  Eigen::MatrixXd along_normals;
  residual(q_, holds(q_), pull);
  std::vector<double> leans;
  for (Touch& touch : touches_) leans.push_back(std::exchange(touch.lean, 0.0));
  residual(q_, holds(q_), along_normals);
  for (std::size_t k = 0; k < touches_.size(); ++k) touches_[k].lean = leans[k];
  Eigen::MatrixXd closed(q_.size(), 0);
  Eigen::MatrixXd pushed(q_.size(), 0);
  const auto add = [](Eigen::MatrixXd& to, const Eigen::VectorXd& column) {
    to.conservativeResize(column.size(), to.cols() + 1);
    to.rightCols(1) = column;
  };
  for (const std::size_t k : pressing_ones) {
    const auto column = static_cast<Eigen::Index>(k);
    add(closed, along_normals.col(column));
    add(pushed, pull.col(column));
    if (!touches_[k].sticks) continue;
    const Eigen::VectorXd along_surface = (pull.col(column) - along_normals.col(column)) / leans[k];
    add(closed, along_surface);
    add(pushed, along_surface);
  }
  return {closed, pushed};
}

/// Contacts keep closed, and those that stick where they are; what they push along balances the rest. Where all push
/// along their normals that is the least eigenvalue of the second variation.
double Judge::margin() {
  const Eigen::Index n = q_.size();
  std::vector<std::size_t> pressing_ones;
  bool leans = false;
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    if (!(touches_[k].force > pressing)) continue;
    if (!(touches_[k].convexity > 0.0)) return -infinity;
    pressing_ones.push_back(k);
    leans = leans || touches_[k].lean != 0.0;
  }
  const auto across = [n](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
    if (columns.cols() == 0) return Eigen::MatrixXd::Identity(n, n);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(columns);
    const Eigen::MatrixXd orthogonal = factors.householderQ();
    return orthogonal.rightCols(n - factors.rank());
  };
  const auto [closed, pushed] = holding(pressing_ones);
  const Eigen::MatrixXd free = across(closed);
  const Eigen::MatrixXd test = across(pushed);
  if (free.cols() == 0) return infinity;
  if (free.cols() != test.cols()) return -infinity;
  Eigen::MatrixXd second(n, n);
  Eigen::MatrixXd unused;
  constexpr double step = 1e-5;
  Eigen::MatrixXd slides(n, static_cast<Eigen::Index>(touches_.size()));
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::VectorXd more = q_;
    Eigen::VectorXd less = q_;
    more[i] += step;
    less[i] -= step;
    second.col(i) =
        (residual(more, followed_holds(more), unused) - residual(less, followed_holds(less), unused)) / (2.0 * step);
    for (std::size_t k = 0; k < touches_.size(); ++k) {
      slides(i, static_cast<Eigen::Index>(k)) =
          (slope(more, touches_[k], touches_[k].s) - slope(less, touches_[k], touches_[k].s)) / (2.0 * step);
    }
  }
  // A contact inside the rod slides along as the rod moves. Where the curvature jumps, the side with less sliding
  // counts.
  for (const std::size_t k : pressing_ones) {
    const Touch& touch = touches_[k];
    if (touch.at_tip || touch.followed) continue;
    constexpr double side = 1e-6;
    const double here = slope(q_, touch, touch.s);
    const double convexity =
        std::max(slope(q_, touch, touch.s + side) - here, here - slope(q_, touch, touch.s - side)) / side;
    if (!(convexity > 0.0)) return -infinity;
    const Eigen::VectorXd slide = slides.col(static_cast<Eigen::Index>(k));
    const Eigen::VectorXd push = touch.lean == 0.0 ? Eigen::VectorXd(touch.force * slide) : -moved_along(k);
    second += (1.0 / convexity) * push * slide.transpose();
  }
  Eigen::VectorXd stiffness(n);
  for (std::size_t j = 0; j < shape_->pieces().size(); ++j) {
    for (int i = 0; i < order_; ++i) {
      stiffness[static_cast<Eigen::Index>(j) * order_ + i] =
          rod_.segments[shape_->pieces()[j].segment].stiffness / (shape_->pieces()[j].length * (2.0 * i + 1.0));
    }
  }
  const Eigen::MatrixXd k = test.transpose() * stiffness.asDiagonal() * free;
  if (leans) {
    const Eigen::MatrixXd pencil = k.partialPivLu().solve(test.transpose() * second * free);
    return Eigen::EigenSolver<Eigen::MatrixXd>(pencil, false).eigenvalues().real().minCoeff();
  }
  const Eigen::MatrixXd h = free.transpose() * (0.5 * (second + second.transpose())) * free;
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(h, k, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

void Judge::limits(PlanCheck& check) const {
  check.limits = 0.0;
  const auto beyond = [&](const char* what, double value, double low, double high) {
    const double excess = std::max({0.0, low - value, value - high});
    check.limits = std::max(check.limits, excess);
    const double size = std::max(std::isfinite(low) ? std::abs(low) : 0.0, std::isfinite(high) ? std::abs(high) : 0.0);
    if (!(excess <= bounds_limit + data * size)) {
      check.defects.push_back(fmt::format("{} {:.6g} is outside of {:.6g} to {:.6g}", what, value, low, high));
    }
  };
  const double unit_moment = unit_force_ * length_;
  for (std::size_t a = 0; a < rod_.actuators.size(); ++a) {
    const ActuatorSpec& spec = scene_.rod.actuators[a];
    beyond("a moment", rod_.actuators[a].moment, spec.minimum / unit_moment, spec.maximum / unit_moment);
  }
  const ContactSpec& contact = scene_.contact;
  const bool planned = contact.mode == ContactModeName::allow || contact.mode == ContactModeName::require;
  const double least = contact.mode == ContactModeName::require ? contact.min_force / unit_force_ : 0.0;
  for (const Touch& touch : touches_) {
    beyond("a force", touch.force, least, planned ? contact.max_force / unit_force_ : 0.0);
    beyond("an arc length", touch.s, 0.0, 1.0);
    const double cone = friction_of(scene_, touch.body);
    beyond("a tangential ratio", touch.lean, -cone, cone);
  }
  if (static_cast<int>(touches_.size()) > contact.count) check.defects.emplace_back("too many contacts");
  if (contact.mode == ContactModeName::require && touches_.empty()) check.defects.emplace_back("no contact");
}

PlanCheck Judge::judge() {
  PlanCheck check;
  Eigen::MatrixXd pull;
  check.equilibrium = residual(q_, holds(q_), pull).cwiseAbs().maxCoeff();
  if (!(check.equilibrium <= equilibrium_limit + data * rod_.loads + turning_allowance())) {
    check.defects.push_back(fmt::format("no equilibrium: {:.2e}", check.equilibrium));
  }
  const RodShape::Grid g = shape_->grid(q_, {});
  check.penetration = penetration(g);
  if (!bodies_.empty() && !(check.penetration <= penetration_limit + data * bodies_[deepest_].size)) {
    check.defects.push_back(fmt::format("{:.2e} deep in '{}'", check.penetration, scene_.obstacles[deepest_].name));
  }
  contacts(check, contact_limit);
  limits(check);
  check.shape = norm(g.tip - Vec2{plan_.tip_x / length_, plan_.tip_y / length_});
  check.shape = std::max(check.shape, std::abs(g.tip_angle - plan_.tip_angle));
  if (!(check.shape <= shape_limit)) check.defects.push_back(fmt::format("the tip is off by {:.2e}", check.shape));
  for (const BackbonePoint& sample : plan_.backbone) {
    const RodShape::Point p = shape_->point(q_, std::clamp(sample.s / length_, 0.0, 1.0));
    const double off = norm(p.at - Vec2{sample.x / length_, sample.y / length_});
    if (!(off <= sample_limit)) {
      check.defects.push_back(fmt::format("the backbone is off by {:.2e}", off));
      break;
    }
  }
  if (plan_.target_error) {
    const double error = norm(g.tip - (1.0 / length_) * *scene_.target.position);
    if (!(std::abs(error - *plan_.target_error / length_) <= shape_limit + data * error)) {
      check.defects.push_back(fmt::format("the target is missed by {:.6g}", error));
    }
  }
  check.margin = margin();
  if (!(check.margin > -margin_limit)) check.defects.push_back(fmt::format("unstable: margin {:.2e}", check.margin));
  return check;
}

}  // namespace

PlanCheck check_plan(const Scene& scene, const Plan& plan) {
  if (plan.coordinates_name != "pcc" && plan.coordinates_name != "psc" && plan.coordinates_name != "legendre") {
    throw Error("the basis of coordinates '" + plan.coordinates_name + "' is not known here");
  }
  return Judge(scene, plan).judge();
}

}  // namespace tendril::bench
