// Contacts do not spread: d_ss (model.md section 7) of those that touch inside the rod stays up on both sides of them.

#include "nlp/learned_hessian.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

class ConvexityRows : public RowBlock {
 public:
  explicit ConvexityRows(PoseState& state)
      : RowBlock("point_contact", state.layout.first_convexity, state.layout.convexities),
        d_(state),
        gradient_(Eigen::VectorXd::Zero(state.variables)),
        learned_(static_cast<std::size_t>(state.layout.convexities), LearnedHessian(state.variables)) {}

  void bounds(VectorRef lower, VectorRef upper) const override {
    for (int i = 0; i < count(); ++i) {
      const bool touches = d_.branches[static_cast<std::size_t>(i / 2)] == Branch::touching;
      lower[i] = touches ? *d_.spec.least_convexity : -infinity;
    }
    upper.setConstant(infinity);
  }

  void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int i = 0; i < count(); ++i) {
      const int k = i / 2;
      const Places::Side side = d_.places.side(d_.contact_places[static_cast<std::size_t>(k)], i % 2);
      values[i] = convexity(d_, k, side);
      if (!derivatives) continue;
      convexity_gradient(d_, k, side, gradient_);
      rows.row(i) = gradient_.transpose();
      learned_[static_cast<std::size_t>(i)].learn(x, gradient_);
    }
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    for (int i = 0; i < count(); ++i) {
      if (multipliers[i] != 0.0) hessian += multipliers[i] * learned_[static_cast<std::size_t>(i)].matrix();
    }
  }

 private:
  PoseState& d_;
  Eigen::VectorXd gradient_;
  std::vector<LearnedHessian> learned_;  ///< one per row
};

}  // namespace

std::unique_ptr<RowBlock> convexity_rows(PoseState& state) { return std::make_unique<ConvexityRows>(state); }

Places::Side convex_side(const PoseState& state, int contact) {
  const auto k = static_cast<std::size_t>(contact);
  // The curvature jumps only by what the basis cannot follow; the larger value decides (model.md section 7).
  const double turn = dot(turned(state.contacts[k].tangent), state.contacts[k].surface.normal);
  const Places::Side before = state.places.side(state.contact_places[k], 0);
  const Places::Side behind = state.places.side(state.contact_places[k], 1);
  return behind.bend() * turn > before.bend() * turn ? behind : before;
}

double convexity(const PoseState& state, int contact, const Places::Side& side) {
  const PoseProgram::ContactState& c = state.contacts[static_cast<std::size_t>(contact)];
  const double along = dot(turned(c.surface.normal), c.tangent);
  return side.bend() * dot(turned(c.tangent), c.surface.normal) + c.surface.curvature * along * along - c.radius.bend;
}

namespace {

/// By the point's motion across and along the obstacle, and by its angle: dn = k tau (tau . dP), dk = -k^2 (n . dP) +
/// k_tau (tau . dP).
struct ConvexityBy {
  Vec2 point{};
  double angle = 0.0;
};

ConvexityBy convexity_by(const PoseProgram::ContactState& c, const Places::Side& side) {
  const Vec2 tau = turned(c.surface.normal);
  const Vec2 normal = turned(c.tangent);
  const double curvature = c.surface.curvature;
  const double along = dot(tau, c.tangent);
  const double slope = dot(c.tangent, c.surface.normal);
  const double by_across = -curvature * curvature * along * along;
  const double by_along = side.bend() * curvature * dot(normal, tau) + c.surface.curvature_rate * along * along -
                          2.0 * curvature * curvature * along * slope;
  return {by_across * c.surface.normal + by_along * tau,
          -side.bend() * slope + 2.0 * curvature * along * dot(tau, normal)};
}

}  // namespace

void convexity_gradient(const PoseState& state, int contact, const Places::Side& side, VectorRef gradient) {
  const auto k = static_cast<std::size_t>(contact);
  const PoseProgram::ContactState& c = state.contacts[k];
  const ConvexityBy by = convexity_by(c, side);
  gradient = state.contact_row(contact, by.point).transpose();
  gradient += by.angle * state.base.row(state.base.index.contacts[k].point.angle).transpose();
  const double turn = dot(turned(c.tangent), c.surface.normal);
  state.places.add_bend_row(state.contact_places[k], side, turn, state.part(gradient.data()));
  state.add_slope_along(contact, -c.radius.jerk, gradient);
}

double convexity_rate(const PoseState& state, int contact, Vec2 velocity, double turn, double stretch) {
  const PoseProgram::ContactState& c = state.contacts[static_cast<std::size_t>(contact)];
  const ConvexityBy by = convexity_by(c, convex_side(state, contact));
  const double along = dot(turned(c.surface.normal), c.tangent);
  return dot(by.point, velocity) + by.angle * turn + stretch * c.surface.curvature * along * along;
}

}  // namespace tendril
