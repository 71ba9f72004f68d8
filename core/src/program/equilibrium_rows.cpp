// The rod stands still: all generalized forces on its coordinates vanish (model.md section 3). With lambda the
// multipliers, lambda . h_e is the virtual work along lambda: forces times virtual displacements, plus moments times
// virtual rotations, minus the change of the bending energy.

#include "obstacle/surface.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

class EquilibriumRows : public RowBlock {
 public:
  explicit EquilibriumRows(PoseState& state) : RowBlock("equilibrium", 0, state.layout.coordinates), d_(state) {}

  void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) override {
    values.setZero();
    d_.places.pull_back(d_.forces, values.data());
    d_.places.add_energy_row(-1.0, {values.data(), nullptr});
    for (std::size_t a = 0; a < d_.moment_variable.size(); ++a) {
      const int variable = d_.moment_variable[a];
      if (variable < 0) continue;
      moments_[a] = x[variable];
      pulls_[a] = d_.chain.pull(static_cast<int>(a), x[variable]);
      d_.places.pull_back_moment(static_cast<int>(a), x[variable], pulls_[a].value, values.data());
    }
    if (derivatives) differentiate(rows);
  }

  void add_second(ConstVectorRef lambda, Eigen::MatrixXd& hessian) override {
    if (profiles_move_) add_moments_second(lambda, hessian);
    for (std::size_t a = 0; a < d_.moment_variable.size(); ++a) {
      const int variable = d_.moment_variable[a];
      if (variable < 0 || !d_.chain.pulls_by_law(static_cast<int>(a))) continue;
      hessian(variable, variable) += pulls_[a].bend * d_.places.stretch_along(static_cast<int>(a), lambda.data());
    }
    d_.places.displace(lambda.data());
    d_.base.displace();
    for (int k = 0; k < d_.layout.forces; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const PoseProgram::ContactState& c = d_.contacts[i];
      const BaseIndex::Contact& at = d_.base.index.contacts[i];
      d_.add_force_work(k, d_.places.displacement(d_.contact_places[i]));
      const int dx = d_.base.displacement(k);
      const Symmetric2 of_distance = distance_hessian(c.surface);
      const auto turns = [&](int point, Vec2 normal) {
        Vec2 push = c.force * (normal + c.lean * turned(normal));
        if (c.shear != 0.0) push += c.shear * turned(normal);
        d_.base.add_symmetric(point, dx, push.x);
        d_.base.add_symmetric(point, dx + 1, push.y);
      };
      turns(at.point.x, {of_distance.xx, of_distance.xy});
      turns(at.point.y, {of_distance.xy, of_distance.yy});
      d_.base.add_symmetric(dx, at.force, c.push.x);
      d_.base.add_symmetric(dx + 1, at.force, c.push.y);
      if (c.lean != 0.0) add_couple_second(k, c.force, c.lean, d_.layout.first_force + k, hessian);
      if (at.lean >= 0) add_lean_second(k, hessian);
      const int shear = d_.shear_variables[i];
      if (shear < 0) continue;
      const Vec2 tau = turned(c.surface.normal);
      d_.add_shear_work(k, d_.places.displacement(d_.contact_places[i]));
      d_.base.add_symmetric(dx, d_.base.shear(k), tau.x);
      d_.base.add_symmetric(dx + 1, d_.base.shear(k), tau.y);
      add_couple_second(k, c.shear, 1.0, shear, hessian);
    }
  }

 private:
  /// The couple of a tangential force works along the rotation of its place, which at a knot that moves with the
  /// contact depends on the coordinates alone. `lean`: tangential force per unit of the variable.
  void add_couple_second(int k, double force, double lean, int variable, Eigen::MatrixXd& hessian) {
    const auto i = static_cast<std::size_t>(k);
    const PoseProgram::ContactState& c = d_.contacts[i];
    const double rotation = d_.places.rotation(d_.contact_places[i]);
    d_.add_along(k, -force * lean * c.radius.bend * rotation, hessian);
    d_.add_slope_along(k, -lean * c.radius.slope * rotation, hessian.col(variable));
    d_.add_slope_along(k, -lean * c.radius.slope * rotation, hessian.row(variable));
  }

  /// Of a tangential force that is a variable: by it and by displacement and rotation of its place.
  void add_lean_second(int k, Eigen::MatrixXd& hessian) {
    const auto i = static_cast<std::size_t>(k);
    const PoseProgram::ContactState& c = d_.contacts[i];
    const BaseIndex::Contact& at = d_.base.index.contacts[i];
    const int dx = d_.base.displacement(k);
    const Vec2 push = c.force * turned(c.surface.normal);
    d_.base.add_symmetric(dx, at.lean, push.x);
    d_.base.add_symmetric(dx + 1, at.lean, push.y);
    const double rotation = d_.places.rotation(d_.contact_places[i]);
    d_.base.add_symmetric(at.force, at.lean, -c.radius.value * rotation);
    const int lean = d_.layout.first_lean + k;
    d_.add_slope_along(k, -c.force * c.radius.slope * rotation, hessian.col(lean));
    d_.add_slope_along(k, -c.force * c.radius.slope * rotation, hessian.row(lean));
  }

  void add_moments_second(ConstVectorRef lambda, Eigen::MatrixXd& hessian) {
    const int first = d_.layout.first_move;
    const int count = d_.layout.slides();
    for (std::size_t a = 0; a < d_.moment_variable.size(); ++a) {
      const int variable = d_.moment_variable[a];
      if (variable < 0) continue;
      mixed_.setZero();
      d_.places.add_moment_second(static_cast<int>(a), moments_[a], pulls_[a].slope, lambda.data(), mixed_,
                                  hessian.block(first, first, count, count));
      hessian.col(variable).segment(first, count) += mixed_;
      hessian.row(variable).segment(first, count) += mixed_.transpose();
    }
  }

  void differentiate(MatrixRef rows) {
    const PoseProgram::Layout& at = d_.layout;
    rows.setZero();
    const SecondPart by{rows.leftCols(at.coordinates), rows.middleCols(at.first_move, at.slides()),
                        rows.topLeftCorner(0, 0)};
    d_.places.second_pull_back(d_.forces, nullptr, by);
    d_.places.add_energy_second(-1.0, nullptr, by);
    for (std::size_t a = 0; a < d_.moment_variable.size(); ++a) {
      const int variable = d_.moment_variable[a];
      if (variable < 0) continue;
      d_.places.pull_back_moment(static_cast<int>(a), 1.0, pulls_[a].slope, rows.col(variable).data());
      if (profiles_move_) d_.places.add_moment_rates(static_cast<int>(a), moments_[a], pulls_[a].value, by.qs);
    }
    // Contact forces act along normals that turn with the contact point.
    for (int k = 0; k < at.forces; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const PoseProgram::ContactState& c = d_.contacts[i];
      differentiate_force(k, at.first_force + k, c.force, c.push, c.lean, rows);
      if (at.leans > 0) {
        turning_ = d_.base.row(d_.base.index.contacts[i].point.angle);
        along_ = d_.contact_row(k, turned(c.surface.normal));
        rows.col(at.first_lean + k) = c.force * (along_ - c.radius.value * turning_).head(at.coordinates);
      }
      if (d_.shear_variables[i] < 0) continue;
      differentiate_force(k, d_.shear_variables[i], c.shear, turned(c.surface.normal), 1.0, rows);
    }
  }

  /// One of a contact's forces: `push` per unit of the variable, `lean` of it tangential.
  void differentiate_force(int k, int variable, double force, Vec2 push, double lean, MatrixRef rows) {
    const PoseProgram::Layout& at = d_.layout;
    const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
    rows.col(variable) = d_.contact_row(k, push).head(at.coordinates);
    if (lean != 0.0) differentiate_couple(k, variable, force, lean, rows);
    // The surface bends the normal.
    const double factor = force * c.surface.curvature;
    if (factor == 0.0) return;
    along_ = d_.contact_row(k, turned(push));
    turning_ = along_;
    if (lean != 0.0) turning_ = d_.contact_row(k, turned(c.surface.normal));
    for (int column = 0; column < d_.variables; ++column) {
      const double scaled = factor * turning_[column];
      if (scaled != 0.0) rows.col(column) += scaled * along_.head(at.coordinates);
    }
  }

  void differentiate_couple(int k, int variable, double force, double lean, MatrixRef rows) {
    const PoseProgram::Layout& at = d_.layout;
    const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
    turning_ = d_.base.row(d_.base.index.contacts[static_cast<std::size_t>(k)].point.angle);
    rows.col(variable) -= lean * c.radius.value * turning_.head(at.coordinates);
    along_.setZero();
    d_.add_slope_along(k, -force * lean * c.radius.slope, along_);
    for (int l = at.first_move; l < at.first_force; ++l) {
      rows.col(l) += along_[l] * turning_.head(at.coordinates);
    }
  }

  PoseState& d_;
  /// Knots that move carry pieces along profiles that vary, and change what pulls along them.
  const bool profiles_move_ = d_.chain.has_moving_work() && d_.chain.knot_count() > 0;
  std::vector<double> moments_ = std::vector<double>(d_.moment_variable.size(), 0.0);
  std::vector<Rod::Jet> pulls_ = std::vector<Rod::Jet>(d_.moment_variable.size());
  Eigen::VectorXd mixed_ = Eigen::VectorXd::Zero(d_.layout.slides());
  Eigen::VectorXd along_ = Eigen::VectorXd::Zero(d_.variables), turning_ = along_;
};

}  // namespace

std::unique_ptr<RowBlock> equilibrium_rows(PoseState& state) { return std::make_unique<EquilibriumRows>(state); }

}  // namespace tendril
