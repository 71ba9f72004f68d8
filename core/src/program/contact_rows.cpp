// A contact is where the rod comes nearest to its obstacle: its gap d - r, and t . n - r', which vanishes there
// (model.md sections 4 and 10).

#include "obstacle/surface.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

class GapRows : public RowBlock {
 public:
  explicit GapRows(PoseState& state)
      : RowBlock("contact_gap", state.layout.first_gap, state.layout.forces), d_(state) {}

  void bounds(VectorRef lower, VectorRef upper) const override {
    lower.setZero();
    for (int k = 0; k < count(); ++k) {
      upper[k] = d_.branches[static_cast<std::size_t>(k)] == Branch::touching ? 0.0 : infinity;
    }
  }

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int k = 0; k < count(); ++k) {
      const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
      values[k] = c.surface.distance;
      if (!derivatives) continue;
      rows.row(k) = d_.contact_row(k, c.surface.normal);
      d_.add_slope_along(k, -c.radius.slope, rows.row(k));
    }
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    for (int k = 0; k < count(); ++k) {
      d_.add_along(k, -multipliers[k] * d_.contacts[static_cast<std::size_t>(k)].radius.bend, hessian);
      const SurfacePoint& surface = d_.contacts[static_cast<std::size_t>(k)].surface;
      const BaseIndex::Point& p = d_.base.index.contacts[static_cast<std::size_t>(k)].point;
      d_.base.gradient[p.x] += multipliers[k] * surface.normal.x;
      d_.base.gradient[p.y] += multipliers[k] * surface.normal.y;
      const Symmetric2 h = distance_hessian(surface);
      d_.base.add(p, {multipliers[k] * h.xx, multipliers[k] * h.xy, multipliers[k] * h.yy});
    }
  }

 private:
  PoseState& d_;
};

class ClosestPointRows : public RowBlock {
 public:
  explicit ClosestPointRows(PoseState& state)
      : RowBlock("closest_point", state.layout.first_closest, state.layout.forces), d_(state) {}

  void bounds(VectorRef lower, VectorRef upper) const override {
    // t.n - r' = 0 inside, <= 0 at the tip. Where the tip does not touch, no point needs to be closest.
    for (int k = 0; k < count(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const bool at_tip = d_.spec.contacts[i].at_tip;
      lower[k] = at_tip ? -infinity : 0.0;
      upper[k] = at_tip && d_.branches[i] == Branch::separated ? infinity : 0.0;
    }
  }

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int k = 0; k < count(); ++k) {
      const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
      values[k] = dot(c.tangent, c.surface.normal) - c.radius.slope;
      if (!derivatives) continue;
      const Vec2 tau = turned(c.surface.normal);
      const Vec2 bend = c.surface.curvature * dot(tau, c.tangent) * tau;
      const BaseIndex::Point& p = d_.base.index.contacts[static_cast<std::size_t>(k)].point;
      rows.row(k) = dot(turned(c.tangent), c.surface.normal) * d_.base.row(p.angle) + d_.contact_row(k, bend);
      d_.add_slope_along(k, -c.radius.bend, rows.row(k));
    }
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    BaseQuantities& base = d_.base;
    for (int k = 0; k < count(); ++k) {
      const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
      const BaseIndex::Point& p = base.index.contacts[static_cast<std::size_t>(k)].point;
      const Vec2 tau = turned(c.surface.normal);
      const Vec2 normal = turned(c.tangent);
      const double curvature = multipliers[k] * c.surface.curvature;
      d_.add_along(k, -multipliers[k] * c.radius.jerk, hessian);
      base.gradient[p.x] += curvature * dot(tau, c.tangent) * tau.x;
      base.gradient[p.y] += curvature * dot(tau, c.tangent) * tau.y;
      base.gradient[p.angle] += multipliers[k] * dot(normal, c.surface.normal);
      base.add(p, normal_hessian(c.surface, multipliers[k] * c.tangent));
      base.add_symmetric(p.x, p.angle, curvature * dot(tau, normal) * tau.x);
      base.add_symmetric(p.y, p.angle, curvature * dot(tau, normal) * tau.y);
      base.hessian(p.angle, p.angle) -= multipliers[k] * dot(c.tangent, c.surface.normal);
    }
  }

 private:
  PoseState& d_;
};

}  // namespace

std::unique_ptr<RowBlock> gap_rows(PoseState& state) { return std::make_unique<GapRows>(state); }
std::unique_ptr<RowBlock> closest_point_rows(PoseState& state) { return std::make_unique<ClosestPointRows>(state); }

}  // namespace tendril
