// Where a contact sticks, the surface of the rod's body does not slide along the obstacle's (model.md section 11).
// While the rod turns there it rolls, so that the contact moves along both.

#include <cmath>

#include "obstacle/surface.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

bool at_tip(const PoseState& state, int contact) {
  return state.spec.contacts[static_cast<std::size_t>(contact)].at_tip;
}

/// How far the contact moves along the obstacle, per length by which the rod does. The round end of a rod turns about
/// its tip.
double along(const PoseState& state, int contact) {
  const PoseProgram::ContactState& c = state.contacts[static_cast<std::size_t>(contact)];
  const double height = c.surface.distance + (at_tip(state, contact) ? 0.0 : c.radius.value);
  return 1.0 - height * c.surface.curvature;
}

/// What the body's surface slides per arc length of the rod by which the contact moves along it.
double roll(const PoseState& state, int contact) {
  const auto k = static_cast<std::size_t>(contact);
  const PoseProgram::ContactState& c = state.contacts[k];
  const double forward = dot(turned(c.surface.normal), c.tangent);
  if (c.radius.value == 0.0 && state.chain.stretches() == 0) return -forward;
  // A couple at the contact makes the curvature jump, a tangential force the stretch.
  const Places::Side before = state.places.side(state.contact_places[k], 0);
  if (at_tip(state, contact)) return c.radius.value * before.curvature - forward * before.stretch;
  const Places::Side behind = state.places.side(state.contact_places[k], 1);
  const double bend = 0.5 * (before.curvature + behind.curvature) + c.radius.bend / forward;
  return c.radius.value * bend - forward * (0.5 * (before.stretch + behind.stretch));
}

/// The point of the obstacle's surface.
Vec2 touched(const PoseProgram::ContactState& c) {
  return c.point - (c.surface.distance + c.radius.value) * c.surface.normal;
}

/// How far the surfaces have slid since the anchor.
double slid(const PoseState& state, int contact) {
  const auto k = static_cast<std::size_t>(contact);
  const PoseProgram::ContactState& c = state.contacts[k];
  const Anchor& anchor = state.loads.anchors[k];
  const auto o = static_cast<std::size_t>(state.spec.contacts[k].obstacle);
  const double rounding = state.spec.obstacles[o]->rounding() - state.loads.shrink[o];
  // Along the surface: round corners turn the normal, straight sides move the point of the core.
  const Vec2 normal = c.surface.normal;
  const double turn = std::atan2(cross(anchor.normal, normal), dot(anchor.normal, normal));
  const Vec2 core = (touched(c) - rounding * normal) - (anchor.point - rounding * anchor.normal);
  const double straight = std::copysign(norm(core), dot(core, turned(normal) + turned(anchor.normal)));
  const double round_end = at_tip(state, contact) ? c.radius.value * (turn - (c.angle - anchor.angle)) : 0.0;
  return anchor.slid + rounding * turn + straight + round_end + anchor.roll * (c.arc_length - anchor.arc_length);
}

/// Its derivatives by all variables, with `roll` held.
void sliding_row(const PoseState& state, int contact, double roll, VectorRef out) {
  const auto k = static_cast<std::size_t>(contact);
  const PoseProgram::ContactState& c = state.contacts[k];
  out = state.contact_row(contact, along(state, contact) * turned(c.surface.normal));
  if (at_tip(state, contact)) {
    out -= c.radius.value * state.base.row(state.base.index.contacts[k].point.angle);
  } else {
    out[state.layout.first_arc_length + contact] += roll;
  }
}

class StickRows : public RowBlock {
 public:
  explicit StickRows(PoseState& state)
      : RowBlock("sticking", state.layout.first_stick, state.layout.shears), d_(state), row_(state.variables) {
    for (int k = 0; k < state.layout.forces; ++k) {
      if (state.spec.contacts[static_cast<std::size_t>(k)].sticks) contacts_.push_back(k);
    }
  }

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int i = 0; i < count(); ++i) {
      const int k = contacts_[static_cast<std::size_t>(i)];
      values[i] = slid(d_, k);
      if (!derivatives) continue;
      sliding_row(d_, k, d_.loads.anchors[static_cast<std::size_t>(k)].roll, row_);
      rows.row(i) = row_;
    }
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    for (int i = 0; i < count(); ++i) {
      const auto k = static_cast<std::size_t>(contacts_[static_cast<std::size_t>(i)]);
      const PoseProgram::ContactState& c = d_.contacts[k];
      const BaseIndex::Point& p = d_.base.index.contacts[k].point;
      const Vec2 n = c.surface.normal;
      const Vec2 tau = turned(n);
      const double by_place = multipliers[i] * along(d_, contacts_[static_cast<std::size_t>(i)]);
      d_.base.gradient[p.x] += by_place * tau.x;
      d_.base.gradient[p.y] += by_place * tau.y;
      if (d_.spec.contacts[k].at_tip) d_.base.gradient[p.angle] -= multipliers[i] * c.radius.value;
      // Farther out the same turn is a longer way.
      const double mixed = -c.surface.curvature * by_place;
      d_.base.add(p, {2.0 * mixed * n.x * tau.x, mixed * (n.x * tau.y + n.y * tau.x), 2.0 * mixed * n.y * tau.y});
    }
  }

 private:
  PoseState& d_;
  std::vector<int> contacts_;
  Eigen::VectorXd row_;
};

}  // namespace

std::unique_ptr<RowBlock> stick_rows(PoseState& state) { return std::make_unique<StickRows>(state); }

void sliding_row(const PoseState& state, int contact, VectorRef out) {
  sliding_row(state, contact, roll(state, contact), out);
}

Anchor anchor(const PoseState& state, int contact) {
  const auto k = static_cast<std::size_t>(contact);
  const PoseProgram::ContactState& c = state.contacts[k];
  Anchor now{touched(c), c.surface.normal, c.arc_length, c.angle, roll(state, contact)};
  if (state.spec.contacts[k].sticks) {
    const Anchor& last = state.loads.anchors[k];
    now.slid = slid(state, contact) + 0.5 * (now.roll - last.roll) * (now.arc_length - last.arc_length);
  }
  return now;
}

}  // namespace tendril
