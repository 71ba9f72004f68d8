#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "grasp/frames.hpp"

namespace tendril {
namespace {

constexpr int steps = 200;       ///< of the finger between its base and the contact
constexpr int most_newton = 30;  ///< where the fit ends is a start, whatever is left

/// Places of the contact within its stretch, and angles of a tip that touches: one per start.
constexpr std::array<double, grasp_starts> places{0.5, 0.12, 0.88, 0.3, 0.7};
constexpr std::array<double, grasp_starts> tip_angles{-0.2, -0.6, -1.0, -1.5, -2.0};

/// A finger without weight whose contact at arc length `contact` is pressed straight away from the axis, integrated
/// from the contact, where place and angle are known, back to the base.
struct Finger {
  const Rod& rod;
  double contact, force, radius, angle;

  struct Base {
    double x = 0.0, y = 0.0, angle = 0.0;                ///< x from the contact
    Eigen::Matrix<double, 2, Eigen::Dynamic> by_moment;  ///< of (angle, y)
    std::vector<double> curvature;                       ///< at the middles of the steps, from the base on
  };

  double curvature(double s, double x, const Eigen::VectorXd& moments) const {
    const Rod::Segment& segment = rod.segment_at(s);
    double moment = -force * x;
    for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
      moment += rod.actuators[a].at(s) * moments[static_cast<Eigen::Index>(a)];
    }
    return segment.rest_curvature_at(s).value + moment / segment.stiffness_at(s).value;
  }

  Base base(const Eigen::VectorXd& moments) const {
    const Eigen::Index count = moments.size();
    Base at;
    at.y = radius;
    at.angle = angle;
    at.curvature.resize(steps);
    Eigen::RowVectorXd dx = Eigen::RowVectorXd::Zero(count);
    Eigen::RowVectorXd dy = dx;
    Eigen::RowVectorXd dangle = dx;
    const double h = contact / steps;
    for (int i = steps - 1; i >= 0; --i) {
      const double s = (i + 0.5) * h;
      const double stiffness = rod.segment_at(s).stiffness_at(s).value;
      Eigen::RowVectorXd own = Eigen::RowVectorXd::Zero(count);
      for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
        own[static_cast<Eigen::Index>(a)] = rod.actuators[a].at(s) / stiffness;
      }
      const double half = at.angle - 0.5 * h * curvature(s, at.x, moments);
      const Eigen::RowVectorXd dhalf = dangle - 0.5 * h * (own - force / stiffness * dx);
      const double middle_x = at.x - 0.5 * h * std::cos(at.angle);
      const Eigen::RowVectorXd dmiddle = dx + 0.5 * h * std::sin(at.angle) * dangle;
      at.curvature[static_cast<std::size_t>(i)] = curvature(s, middle_x, moments);
      at.angle -= h * at.curvature[static_cast<std::size_t>(i)];
      dangle -= h * (own - force / stiffness * dmiddle);
      at.x -= h * std::cos(half);
      at.y -= h * std::sin(half);
      dx += h * std::sin(half) * dhalf;
      dy -= h * std::cos(half) * dhalf;
    }
    at.by_moment.resize(2, count);
    at.by_moment.row(0) = dangle;
    at.by_moment.row(1) = dy;
    return at;
  }

  /// What is chosen: the moments, and what the base is moved by.
  struct Choice {
    Eigen::VectorXd moments, moves;
  };

  Eigen::Vector2d miss(const Base& at, const Eigen::VectorXd& moves) const {
    Eigen::Vector2d out{at.angle - rod.base_angle, at.y - rod.base.y};
    for (Eigen::Index l = 0; l < moves.size(); ++l) {
      const Rod::Move& move = rod.moves[static_cast<std::size_t>(l)];
      if (move.kind == Rod::Move::Kind::turn) out[0] -= moves[l] - rod.base_angle;
      out[1] -= moves[l] * move.along.y;
    }
    return out;
  }

  /// The smallest moments that bring the base to where it is clamped, as nearly as their limits let them, with the
  /// base moved as little as that takes.
  Choice fit() const {
    const auto count = static_cast<Eigen::Index>(rod.actuators.size());
    const auto moves = static_cast<Eigen::Index>(rod.moves.size());
    const std::vector<double> starts = rod.starts();
    Choice chosen{Eigen::VectorXd::Zero(count), Eigen::Map<const Eigen::VectorXd>(starts.data(), moves)};
    if (count + moves == 0) return chosen;
    Eigen::MatrixXd rate(2, count + moves);
    for (Eigen::Index l = 0; l < moves; ++l) {
      const Rod::Move& move = rod.moves[static_cast<std::size_t>(l)];
      rate.col(count + l) << (move.kind == Rod::Move::Kind::turn ? -1.0 : 0.0), -move.along.y;
    }
    Base at = base(chosen.moments);
    for (int round = 0; round < most_newton; ++round) {
      rate.leftCols(count) = at.by_moment;
      const Eigen::VectorXd step = rate.completeOrthogonalDecomposition().solve(-miss(at, chosen.moves));
      double share = std::min(1.0, 3.0 / std::max(1e-12, step.norm()));
      bool better = false;
      for (int halving = 0; halving < 8 && !better; ++halving, share *= 0.5) {
        Choice trial{chosen.moments + share * step.head(count), chosen.moves + share * step.tail(moves)};
        for (Eigen::Index a = 0; a < count; ++a) {
          const Rod::Actuator& limits = rod.actuators[static_cast<std::size_t>(a)];
          trial.moments[a] = std::clamp(trial.moments[a], limits.minimum, limits.maximum);
        }
        for (Eigen::Index l = 0; l < moves; ++l) {
          const Rod::Move& limits = rod.moves[static_cast<std::size_t>(l)];
          trial.moves[l] = std::clamp(trial.moves[l], limits.minimum, limits.maximum);
        }
        Base moved = base(trial.moments);
        better = miss(moved, trial.moves).norm() < miss(at, chosen.moves).norm();
        if (!better) continue;
        chosen = std::move(trial);
        at = std::move(moved);
      }
      if (!better || miss(at, chosen.moves).norm() < 1e-10) break;
    }
    return chosen;
  }
};

}  // namespace

StartShape grasp_start(const Task& data, const Mode& mode, int index) {
  const auto which = static_cast<std::size_t>(std::clamp(index, 0, static_cast<int>(places.size()) - 1));
  const ContactSetup& contact = mode.contacts.front();
  const std::vector<double> knots = data.rod.fixed_knots();
  const auto stretch = static_cast<std::size_t>(contact.region);
  Finger finger{data.rod, 1.0, std::isfinite(data.max_force) ? data.max_force : 1.0,
                data.obstacles[0]->smallest_radius(), 0.0};
  if (contact.at_tip) {
    finger.angle = tip_angles[which];
  } else {
    finger.contact = knots[stretch] + places[which] * (knots[stretch + 1] - knots[stretch]);
  }
  finger.radius += data.rod.radius_at(finger.contact).value;
  const auto [moments, moves] = finger.fit();
  Finger::Base at = finger.base(moments);
  StartShape shape;
  shape.curvature = [rod = data.rod, moments = moments, place = finger.contact,
                     within = std::move(at.curvature)](double s) {
    if (s < place)
      return within[static_cast<std::size_t>(std::clamp(static_cast<int>(s / place * steps), 0, steps - 1))];
    return Finger{rod, place, 0.0, 0.0, 0.0}.curvature(s, 0.0, moments);
  };
  shape.moments.assign(moments.data(), moments.data() + moments.size());
  shape.moves.assign(moves.data(), moves.data() + moves.size());
  shape.arc_lengths = {contact.at_tip ? std::nan("") : finger.contact};
  shape.forces = {finger.force};
  shape.palm_distance = std::clamp(-at.x, data.palm->minimum, data.palm->maximum);
  return shape;
}

}  // namespace tendril
