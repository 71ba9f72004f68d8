#pragma once

#include <span>
#include <vector>

#include "program/base_quantities.hpp"
#include "program/pose_program.hpp"
#include "rod/places.hpp"

namespace tendril {

/// What all rows of a pose program share: what it was assembled from, and its rod and contacts at the point moved to
/// last.
struct PoseState {
  explicit PoseState(PoseProgramSpec s);
  PoseState(const PoseState&) = delete;
  PoseState& operator=(const PoseState&) = delete;

  PoseProgramSpec spec;
  Chain chain;
  PoseProgram::Layout layout;
  std::vector<int> moment_variable;  ///< per actuator
  std::vector<Branch> branches;      ///< per contact
  Places places;
  std::vector<int> contact_places;
  std::vector<int> shear_variables;  ///< per contact; -1: it does not stick
  BaseQuantities base;
  std::vector<PoseProgram::ContactState> contacts;
  Vec2 shift{};  ///< of the base
  Loads loads;
  Forces forces;  ///< on the rod: its loads and those of contacts
  Forces pushes;  ///< what second derivatives of rows and terms leave on places
  int variables = 0;

  void move(ConstVectorRef x);
  /// After move(): what first derivatives of rows need.
  void differentiate();

  /// The arc lengths of Places.
  std::span<const double> slides(ConstVectorRef x) const {
    return {x.data() + layout.first_move, static_cast<std::size_t>(layout.slides())};
  }
  /// Where a row by all variables has what Places has of it.
  RowPart part(double* row) const { return {row, row + layout.first_move}; }
  /// A contact inside the rod, or as -1 a port that moves, and the next one in the same stretch: they must keep their
  /// order.
  bool ordered(int contact) const;
  /// Obstacles that stand on the palm.
  bool carried(int obstacle) const { return obstacle >= static_cast<int>(spec.obstacles.size()) - spec.carried; }
  /// Obstacles that bound no body.
  bool measures(int obstacle) const { return obstacle >= static_cast<int>(spec.obstacles.size()) - spec.measures; }
  /// Of an obstacle in its present size, next to a point.
  SurfacePoint surface(int obstacle, Vec2 point) const;
  /// direction . dP of contact k by all variables.
  auto contact_row(int k, Vec2 direction) const {
    const BaseIndex::Point& p = base.index.contacts[static_cast<std::size_t>(k)].point;
    return direction.x * base.row(p.x) + direction.y * base.row(p.y);
  }
  /// Moment about the backbone of a unit force at contact k: it acts on the surface of the body, not on the backbone.
  double couple(int k) const {
    const PoseProgram::ContactState& c = contacts[static_cast<std::size_t>(k)];
    return -c.lean * c.radius.value;
  }
  /// Adds second derivatives of a function of contact k's arc length alone.
  void add_along(int contact, double second, Eigen::MatrixXd& hessian) const {
    for (int l = 0; l < layout.slides(); ++l) {
      const double run = places.running(contact_places[static_cast<std::size_t>(contact)], l);
      for (int m = 0; m < layout.slides() && run != 0.0; ++m) {
        hessian(layout.first_move + l, layout.first_move + m) +=
            second * run * places.running(contact_places[static_cast<std::size_t>(contact)], m);
      }
    }
  }
  /// The same of its derivative.
  template <class Row>
  void add_slope_along(int contact, double slope, Row&& row) const {
    for (int l = 0; l < layout.slides() && slope != 0.0; ++l) {
      row[layout.first_move + l] += slope * places.running(contact_places[static_cast<std::size_t>(contact)], l);
    }
  }
  /// Adds second derivatives of the work of contact k's force, its couple aside, along a constant displacement.
  void add_force_work(int contact, Vec2 displacement);
  void add_shear_work(int contact, Vec2 displacement);  ///< Likewise, of the tangential force where it sticks.
  /// The same of a constant force; returns the work's gradient by the contact's point, per force.
  Vec2 add_push_work(int contact, Vec2 displacement, double force);
  Vec2 add_normal_work(int contact, Vec2 displacement, double force);  ///< The same of one along the normal.
};

}  // namespace tendril
