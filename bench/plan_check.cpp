#include "plan_check.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>

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
/// (L) Between nodes a sample stands on the interpolating polynomial of the plan's own rule.
constexpr double sample_limit = 1e-6;
/// Differences of the equilibrium leave about 1e-7 of its scale in the margin.
constexpr double margin_limit = 1e-4;
/// (EI/L^2) A contact with less force does not hold the rod.
constexpr double pressing = 1e-9;

constexpr int rule_size = 16;

/// Gauss-Legendre on [0,1] with the matrix of integrals from 0 to each node.
struct Rule {
  std::array<double, rule_size> node{}, weight{};
  Eigen::Matrix<double, rule_size, rule_size> to_node;

  Rule() {
    for (int i = 0; i < rule_size; ++i) {
      double x = std::cos(M_PI * (i + 0.75) / (rule_size + 0.5));
      double slope = 0.0;
      for (int step = 0; step < 50; ++step) {
        const double p = std::legendre(rule_size, x);
        slope = rule_size * (x * p - std::legendre(rule_size - 1, x)) / (x * x - 1.0);
        const double change = p / slope;
        x -= change;
        if (std::abs(change) < 1e-16) break;
      }
      const auto at = static_cast<std::size_t>(rule_size - 1 - i);
      node[at] = 0.5 * (1.0 + x);
      weight[at] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    for (int i = 0; i < rule_size; ++i) {
      for (int k = 0; k < rule_size; ++k) {
        double sum = 0.0;
        for (int j = 0; j < rule_size; ++j) {
          const double t = node[static_cast<std::size_t>(i)] * node[static_cast<std::size_t>(j)];
          double cardinal = 1.0;
          for (int m = 0; m < rule_size; ++m) {
            if (m == k) continue;
            const double xm = node[static_cast<std::size_t>(m)];
            cardinal *= (t - xm) / (node[static_cast<std::size_t>(k)] - xm);
          }
          sum += weight[static_cast<std::size_t>(j)] * cardinal;
        }
        to_node(i, k) = node[static_cast<std::size_t>(i)] * sum;
      }
    }
  }
};

const Rule& rule() {
  static const Rule the_rule;
  return the_rule;
}

/// A convex core (a point, a line, a polygon or a half plane) grown by a radius.
struct Body {
  std::vector<Vec2> core;  ///< counterclockwise
  double radius = 0.0;
  bool half_plane = false;  ///< core[0] is on its surface, core[1] is its normal
  double size = 1.0;        ///< largest coordinate, for what rounding of the data does

  /// Distance to the core (negative inside a polygon) and its gradient.
  double distance(Vec2 p, Vec2& normal) const {
    if (half_plane) {
      normal = core[1];
      return dot(core[1], p - core[0]);
    }
    double nearest = infinity;
    bool inside = core.size() > 2;
    double shallow = -infinity;
    Vec2 inner{};
    for (std::size_t i = 0; i < core.size(); ++i) {
      const Vec2 a = core[i];
      const Vec2 along = core[(i + 1) % core.size()] - a;
      const double square = dot(along, along);
      const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
      const Vec2 away = p - a - t * along;
      if (norm(away) < nearest) {
        nearest = norm(away);
        normal = nearest > 0.0 ? (1.0 / nearest) * away : Vec2{1.0, 0.0};
      }
      if (core.size() > 2) {
        const Vec2 out = (-1.0 / std::sqrt(square)) * turned(along);
        const double level = dot(out, p - a);
        inside = inside && level < 0.0;
        if (level > shallow) {
          shallow = level;
          inner = out;
        }
      }
    }
    if (!inside) return nearest;
    normal = inner;
    return shallow;
  }
};

double number_of(const RawValue& value, const QuantityReader& read, const Dimension& of) {
  if (const auto* real = std::get_if<double>(&value.value)) return *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
  if (const auto* text = std::get_if<std::string>(&value.value)) return read(*text, of);
  throw Error("an option of an obstacle is no number");
}

Vec2 point_of(const RawValue& value, const QuantityReader& read, double length) {
  const auto& list = std::get<RawValue::List>(value.value);
  return {number_of(list.at(0), read, dimension::length) / length,
          number_of(list.at(1), read, dimension::length) / length};
}

Body body_of(const ObstacleSpec& spec, const QuantityReader& read, double length) {
  const auto at = [&](const char* name) { return point_of(spec.options.at(name), read, length); };
  const auto real = [&](const char* name) {
    return number_of(spec.options.at(name), read, dimension::length) / length;
  };
  Body body;
  if (spec.shape == "circle") {
    body.core = {at("center")};
    body.radius = real("radius");
  } else if (spec.shape == "wall") {
    const Vec2 normal = at("normal");
    body.core = {at("point"), (1.0 / norm(normal)) * normal};
    body.half_plane = true;
  } else if (spec.shape == "capsule") {
    body.core = {at("from"), at("to")};
    body.radius = real("radius");
  } else if (spec.shape == "polygon") {
    for (const RawValue& corner : std::get<RawValue::List>(spec.options.at("vertices").value)) {
      body.core.push_back(point_of(corner, read, length));
    }
    double area = 0.0;
    for (std::size_t i = 0; i < body.core.size(); ++i)
      area += cross(body.core[i], body.core[(i + 1) % body.core.size()]);
    if (area < 0.0) std::reverse(body.core.begin(), body.core.end());
    body.radius = real("rounding");
  } else {
    throw Error("no geometry is known here for the shape '" + spec.shape + "'");
  }
  body.size = 1.0 + body.radius;
  for (const Vec2& p : body.core) body.size = std::max(body.size, norm(p));
  return body;
}

/// A contact that the plan says it has.
struct Touch {
  std::size_t body = 0;
  bool at_tip = false;
  double s = 0.0, force = 0.0;
};

struct Span {
  double from = 0.0, to = 1.0, moment = 0.0;
};

struct Stretch {
  double from, to, stiffness, weight, rest;
};

/// Places along the rod are data too (model.md section 1). Unrounded ones would differ by 1e-12, and the curvature of a
/// short piece by that over its length.
double rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.11e", value);
  return std::strtod(text.data(), nullptr);
}

/// The rod of a scene, by definitions of its own.
struct Loaded {
  std::vector<Stretch> segments;
  std::vector<Span> actuators;
  Vec2 base{}, gravity{}, tip_force{};
  double base_angle = 0.0;
  double loads = 1.0;  ///< sum of all, for what rounding of the data does

  Loaded(const Scene& scene, const Plan& plan) {
    const double length = scene.rod.length();
    const double stiffness = scene.rod.segments.front().bending_stiffness;
    const double unit_force = stiffness / (length * length);
    double at = 0.0;
    const double g = scene.gravity ? norm(*scene.gravity) : 0.0;
    if (g > 0.0) gravity = (1.0 / g) * *scene.gravity;
    for (const SegmentSpec& s : scene.rod.segments) {
      const double to = rounded(at + s.length / length);
      const double weight = s.linear_density * g * length / unit_force;
      segments.push_back({at, to, s.bending_stiffness / stiffness, weight, s.rest_curvature * length});
      loads += weight * (to - at) + std::abs(segments.back().rest) * segments.back().stiffness;
      at = to;
    }
    for (std::size_t a = 0; a < scene.rod.actuators.size(); ++a) {
      const ActuatorSpec& spec = scene.rod.actuators[a];
      actuators.push_back(
          {rounded(spec.from / length), rounded(spec.to / length), plan.moments.at(a) / (unit_force * length)});
      loads += std::abs(actuators.back().moment);
    }
    base = (1.0 / length) * scene.rod.base_position;
    base_angle = scene.rod.base_angle;
    tip_force = (1.0 / unit_force) * scene.tip_load.force + (scene.tip_load.mass * g / unit_force) * gravity;
    loads += norm(tip_force);
  }

  std::vector<double> knots() const {
    std::vector<double> ends{0.0, 1.0};
    for (const Stretch& s : segments) ends.push_back(s.to);
    for (const Span& a : actuators) ends.insert(ends.end(), {a.from, a.to});
    std::sort(ends.begin(), ends.end());
    // What the rounding of sums leaves apart is one knot.
    ends.erase(std::unique(ends.begin(), ends.end(), [](double a, double b) { return b - a < 1e-9; }), ends.end());
    ends.front() = 0.0;
    ends.back() = 1.0;
    return ends;
  }
};

/// Values (or slopes) of the local basis at sigma: the integrated Legendre polynomials of model.md section 2.
void basis(int order, double sigma, bool slope, Eigen::Ref<Eigen::VectorXd> out) {
  const double x = std::clamp(2.0 * sigma - 1.0, -1.0, 1.0);
  for (int i = 1; i <= order; ++i) {
    const auto n = static_cast<unsigned>(i);
    if (slope) {
      out[i - 1] = std::legendre(n - 1, x);
    } else {
      out[i - 1] = i == 1 ? sigma : (std::legendre(n, x) - std::legendre(n - 2, x)) / (2.0 * (2.0 * i - 1.0));
    }
  }
}

struct Piece {
  double from = 0.0, length = 1.0;
  std::size_t segment = 0;
};

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
      rod_.loads += std::abs(touch.force);
      touches_.push_back(touch);
      if (!c.at_tip && plan.split_at_contact) moving.push_back(touch.s);
    }
    order_ = plan.order;
    q_ = Eigen::Map<const Eigen::VectorXd>(plan.coordinates.data(), static_cast<Eigen::Index>(plan.coordinates.size()));
    make_pieces(moving);
  }

  PlanCheck judge();

 private:
  void make_pieces(const std::vector<double>& moving) {
    std::vector<double> knots = rod_.knots();
    knots.insert(knots.end(), moving.begin(), moving.end());
    std::sort(knots.begin(), knots.end());
    const auto total = static_cast<std::size_t>(q_.size() / order_);
    const std::size_t stretches = knots.size() - 1;
    if (total == 0 || total % stretches != 0) throw Error("the plan's coordinates do not fit its pieces");
    const std::size_t parts = total / stretches;
    for (std::size_t r = 0; r < stretches; ++r) {
      const double h = (knots[r + 1] - knots[r]) / static_cast<double>(parts);
      for (std::size_t p = 0; p < parts; ++p) {
        Piece piece{knots[r] + h * static_cast<double>(p), h, 0};
        const double middle = piece.from + 0.5 * h;
        while (piece.segment + 1 < rod_.segments.size() && rod_.segments[piece.segment].to < middle) ++piece.segment;
        pieces_.push_back(piece);
      }
    }
  }

  /// The rod cut into panels at pieces and at further places, with all that a quadrature needs at their nodes.
  struct Grid {
    std::vector<double> s, weight, angle, curvature;  ///< weight: of arc length
    std::vector<std::size_t> piece;
    std::vector<Vec2> at;
    Eigen::MatrixXd slopes;  ///< d curvature / d q of the node's piece, a column per node
    Vec2 tip{};
    double tip_angle = 0.0;
    std::vector<double> load;       ///< integral of rho beyond s
    std::vector<Vec2> load_moment;  ///< and of rho P
  };
  Grid grid(const Eigen::VectorXd& q, const std::vector<double>& cuts) const;

  struct Point {
    Vec2 at{};
    double angle = 0.0;
  };
  Point point(const Eigen::VectorXd& q, double s) const;
  double gap(std::size_t body, Vec2 at, Vec2& normal) const {
    return bodies_[body].distance(at, normal) - bodies_[body].radius;
  }
  /// Tangent . normal, the slope of the distance along the rod.
  double slope(const Eigen::VectorXd& q, std::size_t body, double s) const;
  /// Residual of the equilibrium with contacts at arc lengths `s`, which hold the rod along the obstacle's normal
  /// there; `pull`: what a unit force of each does.
  Eigen::VectorXd residual(const Eigen::VectorXd& q, const std::vector<double>& s, Eigen::MatrixXd& pull) const;
  void contacts(PlanCheck& check, double tolerance);
  double penetration(const Grid& g);
  double margin() const;
  void limits(PlanCheck& check) const;

  const Scene& scene_;
  const Plan& plan_;
  Loaded rod_;
  double length_ = 1.0, unit_force_ = 1.0;
  std::vector<Body> bodies_;
  std::vector<Touch> touches_;
  int order_ = 1;
  Eigen::VectorXd q_;
  std::vector<Piece> pieces_;
  std::size_t deepest_ = 0;
};

Judge::Grid Judge::grid(const Eigen::VectorXd& q, const std::vector<double>& cuts) const {
  Grid g;
  double angle = rod_.base_angle;
  Vec2 at = rod_.base;
  std::vector<Eigen::VectorXd> slopes;
  Eigen::VectorXd value(order_);
  Eigen::VectorXd slope(order_);
  for (std::size_t j = 0; j < pieces_.size(); ++j) {
    const Piece& piece = pieces_[j];
    const Eigen::VectorXd own = q.segment(static_cast<Eigen::Index>(j) * order_, order_);
    const int panels = 4 + order_ / 5 + static_cast<int>(std::min(200.0, own.cwiseAbs().sum()));
    std::vector<double> ends;
    for (int i = 0; i <= panels; ++i) ends.push_back(static_cast<double>(i) / panels);
    for (const double cut : cuts) {
      const double sigma = (cut - piece.from) / piece.length;
      if (sigma > 1e-12 && sigma < 1.0 - 1e-12) ends.push_back(sigma);
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      const double width = ends[e + 1] - ends[e];
      if (!(width > 0.0)) continue;
      const double h = width * piece.length;
      std::array<Vec2, rule_size> tangent;
      for (std::size_t i = 0; i < rule_size; ++i) {
        const double sigma = ends[e] + width * rule().node[i];
        basis(order_, sigma, false, value);
        basis(order_, sigma, true, slope);
        g.s.push_back(piece.from + sigma * piece.length);
        g.weight.push_back(h * rule().weight[i]);
        g.angle.push_back(angle + own.dot(value));
        g.curvature.push_back(own.dot(slope) / piece.length);
        g.piece.push_back(j);
        slopes.emplace_back(slope / piece.length);
        tangent[i] = {std::cos(g.angle.back()), std::sin(g.angle.back())};
      }
      Vec2 whole{};
      for (std::size_t i = 0; i < rule_size; ++i) {
        Vec2 partial{};
        for (std::size_t k = 0; k < rule_size; ++k) {
          partial += rule().to_node(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * tangent[k];
        }
        g.at.push_back(at + h * partial);
        whole += rule().weight[i] * tangent[i];
      }
      at += h * whole;
    }
    basis(order_, 1.0, false, value);
    angle += own.dot(value);
  }
  g.tip = at;
  g.tip_angle = angle;
  g.slopes.resize(order_, static_cast<Eigen::Index>(slopes.size()));
  for (std::size_t i = 0; i < slopes.size(); ++i) g.slopes.col(static_cast<Eigen::Index>(i)) = slopes[i];

  // From the tip to the base: the weight beyond each node and its first moment.
  g.load.resize(g.s.size());
  g.load_moment.resize(g.s.size());
  double beyond = 0.0;
  Vec2 moment_beyond{};
  for (std::size_t panel = g.s.size() / rule_size; panel-- > 0;) {
    const std::size_t first = panel * rule_size;
    const double rho = rod_.segments[pieces_[g.piece[first]].segment].weight;
    double h = 0.0;
    for (std::size_t i = 0; i < rule_size; ++i) h += g.weight[first + i];
    for (std::size_t i = 0; i < rule_size; ++i) {
      double weight = 0.0;
      Vec2 moment{};
      for (std::size_t k = 0; k < rule_size; ++k) {
        const double w =
            h * rho * (rule().weight[k] - rule().to_node(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
        weight += w;
        moment += w * g.at[first + k];
      }
      g.load[first + i] = beyond + weight;
      g.load_moment[first + i] = moment_beyond + moment;
    }
    for (std::size_t k = 0; k < rule_size; ++k) {
      beyond += h * rho * rule().weight[k];
      moment_beyond += (h * rho * rule().weight[k]) * g.at[first + k];
    }
  }
  return g;
}

Judge::Point Judge::point(const Eigen::VectorXd& q, double s) const {
  Point p{rod_.base, rod_.base_angle};
  Eigen::VectorXd value(order_);
  for (std::size_t j = 0; j < pieces_.size(); ++j) {
    const Piece& piece = pieces_[j];
    const bool last = s <= piece.from + piece.length || j + 1 == pieces_.size();
    const double end = last ? (s - piece.from) / piece.length : 1.0;
    const Eigen::VectorXd own = q.segment(static_cast<Eigen::Index>(j) * order_, order_);
    const int panels = 2 + order_ / 5 + static_cast<int>(std::min(200.0, own.cwiseAbs().sum()));
    for (int e = 0; e < panels; ++e) {
      const double width = end / panels;
      for (std::size_t i = 0; i < rule_size; ++i) {
        basis(order_, width * (e + rule().node[i]), false, value);
        const double angle = p.angle + own.dot(value);
        p.at += (piece.length * width * rule().weight[i]) * Vec2{std::cos(angle), std::sin(angle)};
      }
    }
    basis(order_, end, false, value);
    p.angle += own.dot(value);
    if (last) break;
  }
  return p;
}

double Judge::slope(const Eigen::VectorXd& q, std::size_t body, double s) const {
  const Point p = point(q, s);
  Vec2 normal{};
  gap(body, p.at, normal);
  return std::cos(p.angle) * normal.x + std::sin(p.angle) * normal.y;
}

Eigen::VectorXd Judge::residual(const Eigen::VectorXd& q, const std::vector<double>& s, Eigen::MatrixXd& pull) const {
  const Grid g = grid(q, s);
  std::vector<Vec2> place(touches_.size());
  std::vector<Vec2> normal(touches_.size());
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    place[k] = touches_[k].at_tip ? g.tip : point(q, s[k]).at;
    gap(touches_[k].body, place[k], normal[k]);
  }
  Eigen::VectorXd r = Eigen::VectorXd::Zero(q.size());
  pull.setZero(q.size(), static_cast<Eigen::Index>(touches_.size()));
  for (std::size_t i = 0; i < g.s.size(); ++i) {
    const Stretch& segment = rod_.segments[pieces_[g.piece[i]].segment];
    double moment =
        cross(g.tip - g.at[i], rod_.tip_force) + cross(g.load_moment[i] - g.load[i] * g.at[i], rod_.gravity);
    for (const Span& a : rod_.actuators) {
      if (g.s[i] > a.from && g.s[i] < a.to) moment += a.moment;
    }
    const auto first = static_cast<Eigen::Index>(g.piece[i]) * order_;
    const auto slopes = g.slopes.col(static_cast<Eigen::Index>(i));
    for (std::size_t k = 0; k < touches_.size(); ++k) {
      if (g.s[i] > s[k]) continue;
      const double lever = cross(place[k] - g.at[i], normal[k]);
      moment += touches_[k].force * lever;
      pull.col(static_cast<Eigen::Index>(k)).segment(first, order_) += (g.weight[i] * lever) * slopes;
    }
    r.segment(first, order_) += (g.weight[i] * (segment.stiffness * (g.curvature[i] - segment.rest) - moment)) * slopes;
  }
  return r;
}

double Judge::penetration(const Grid& g) {
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
      const auto at = [&](double where) { return gap(b, point(q_, where).at, normal); };
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
    const Point p = point(q_, touch.s);
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

double Judge::margin() const {
  const Eigen::Index n = q_.size();
  std::vector<double> s;
  for (const Touch& touch : touches_) s.push_back(touch.s);
  Eigen::MatrixXd pull;
  residual(q_, s, pull);
  std::vector<Eigen::Index> holding;
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    if (touches_[k].force > pressing) holding.push_back(static_cast<Eigen::Index>(k));
  }
  Eigen::MatrixXd free = Eigen::MatrixXd::Identity(n, n);
  if (!holding.empty()) {
    Eigen::MatrixXd rows(n, static_cast<Eigen::Index>(holding.size()));
    for (std::size_t k = 0; k < holding.size(); ++k) rows.col(static_cast<Eigen::Index>(k)) = pull.col(holding[k]);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(rows);
    const Eigen::MatrixXd orthogonal = factors.householderQ();
    free = orthogonal.rightCols(n - factors.rank());
  }
  if (free.cols() == 0) return infinity;
  Eigen::MatrixXd second(n, n);
  Eigen::MatrixXd unused;
  constexpr double step = 1e-5;
  Eigen::MatrixXd slides(n, static_cast<Eigen::Index>(touches_.size()));
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::VectorXd more = q_;
    Eigen::VectorXd less = q_;
    more[i] += step;
    less[i] -= step;
    second.col(i) = (residual(more, s, unused) - residual(less, s, unused)) / (2.0 * step);
    for (std::size_t k = 0; k < touches_.size(); ++k) {
      slides(i, static_cast<Eigen::Index>(k)) =
          (slope(more, touches_[k].body, s[k]) - slope(less, touches_[k].body, s[k])) / (2.0 * step);
    }
  }
  // A contact inside the rod slides along as the rod moves. Where the curvature jumps, the side with less sliding
  // counts.
  for (const Eigen::Index k : holding) {
    const Touch& touch = touches_[static_cast<std::size_t>(k)];
    if (touch.at_tip) continue;
    constexpr double side = 1e-6;
    const double here = slope(q_, touch.body, touch.s);
    const double convexity =
        std::max(slope(q_, touch.body, touch.s + side) - here, here - slope(q_, touch.body, touch.s - side)) / side;
    if (!(convexity > 0.0)) return -infinity;
    second += (touch.force / convexity) * slides.col(k) * slides.col(k).transpose();
  }
  Eigen::VectorXd stiffness(n);
  for (std::size_t j = 0; j < pieces_.size(); ++j) {
    for (int i = 0; i < order_; ++i) {
      stiffness[static_cast<Eigen::Index>(j) * order_ + i] =
          rod_.segments[pieces_[j].segment].stiffness / (pieces_[j].length * (2.0 * i + 1.0));
    }
  }
  const Eigen::MatrixXd h = free.transpose() * (0.5 * (second + second.transpose())) * free;
  const Eigen::MatrixXd k = free.transpose() * stiffness.asDiagonal() * free;
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
  }
  if (static_cast<int>(touches_.size()) > contact.count) check.defects.emplace_back("too many contacts");
  if (contact.mode == ContactModeName::require && touches_.empty()) check.defects.emplace_back("no contact");
}

PlanCheck Judge::judge() {
  PlanCheck check;
  std::vector<double> cuts;
  for (const Touch& touch : touches_) cuts.push_back(touch.s);
  Eigen::MatrixXd pull;
  check.equilibrium = residual(q_, cuts, pull).cwiseAbs().maxCoeff();
  if (!(check.equilibrium <= equilibrium_limit + data * rod_.loads)) {
    check.defects.push_back(fmt::format("no equilibrium: {:.2e}", check.equilibrium));
  }
  const Grid g = grid(q_, {});
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
    const Point p = point(q_, std::clamp(sample[0] / length_, 0.0, 1.0));
    const double off = norm(p.at - Vec2{sample[1] / length_, sample[2] / length_});
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
