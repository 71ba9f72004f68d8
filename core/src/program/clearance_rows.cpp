// Points of the rod stay out of obstacles.

#include <algorithm>

#include "program/row_block.hpp"
#include "rod/kernels.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

class ClearanceRows : public RowBlock {
 public:
  explicit ClearanceRows(PoseState& state)
      : RowBlock("non_penetration", state.layout.first_check, state.layout.checks, 0.0, infinity), d_(state) {
    std::vector<Places::Station> stations;
    stations.reserve(d_.spec.checks.size());
    for (const CheckPoint& c : d_.spec.checks) {
      if (c.piece < 0 || c.piece >= d_.chain.piece_count() || !(c.sigma > 0.0 && c.sigma <= 1.0)) {
        throw Error("a check point lies outside its piece");
      }
      stations.push_back({c.piece, c.sigma});
    }
    const std::vector<int> places = d_.places.add_stations(stations);
    checks_.reserve(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const int obstacle = d_.spec.checks[i].obstacle;
      checks_.push_back({places[i], obstacle, d_.carried(obstacle), {}, {}});
    }
    row_.setZero(d_.layout.coordinates + d_.layout.slides() + (d_.layout.palm >= 0 ? 1 : 0));
    by_row_.setZero(row_.size(), count());
    scaled_.setZero(count(), row_.size());
  }

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    const PoseProgram::Layout& at = d_.layout;
    for (int i = 0; i < count(); ++i) {
      Check& c = checks_[static_cast<std::size_t>(i)];
      const Vec2 point = d_.places.point(c.place);
      // No point comes nearer to an obstacle than it moves.
      if (const double least = c.gap - norm(point - c.at); least > d_.spec.checked_from) {
        values[i] = least;
        if (derivatives) flatten(c, rows, i);
        continue;
      }
      c.surface = d_.surface(c.obstacle, c.carried ? point - d_.shift : point);
      // A body stands on its palm, but is kept apart from that of another finger.
      c.radius = c.carried && !d_.measures(c.obstacle) ? Rod::Jet{} : d_.places.radius(c.place);
      values[i] = c.surface.distance - c.radius.value;
      c.gap = values[i];
      c.at = point;
      if (!derivatives) continue;
      if (values[i] > d_.spec.checked_from) {
        flatten(c, rows, i);
        continue;
      }
      c.flat = false;
      fill(c, c.surface.normal, row_.data());
      const int reach = d_.places.reach(c.place);
      double* out = &rows(i, 0);
      for (int k = 0; k < reach; ++k, out += rows.outerStride()) *out = row_[k];
      for (int l = 0; l < at.slides(); ++l) {
        rows(i, at.first_move + l) = row_[at.coordinates + l];
        if (c.radius.slope != 0.0) rows(i, at.first_move + l) -= c.radius.slope * d_.places.running(c.place, l);
      }
      if (at.palm >= 0) rows(i, at.palm) = row_[row_.size() - 1];
    }
  }

  /// The curvature of obstacles adds one product over all rows.
  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    const PoseProgram::Layout& at = d_.layout;
    const auto width = static_cast<int>(row_.size());
    int used = 0;
    for (int i = 0; i < count(); ++i) {
      if (multipliers[i] == 0.0) continue;
      const Check& c = checks_[static_cast<std::size_t>(i)];
      d_.pushes.on[static_cast<std::size_t>(c.place)].force += multipliers[i] * c.surface.normal;
      for (int l = 0; l < at.slides() && c.radius.bend != 0.0; ++l) {
        for (int m = 0; m < at.slides(); ++m) {
          hessian(at.first_move + l, at.first_move + m) -=
              multipliers[i] * c.radius.bend * d_.places.running(c.place, l) * d_.places.running(c.place, m);
        }
      }
      const double factor = multipliers[i] * c.surface.curvature;
      if (factor == 0.0) continue;
      double* row = by_row_.col(used).data();
      const int reach = d_.places.reach(c.place);
      std::fill_n(row + reach, at.coordinates - reach, 0.0);
      fill(c, turned(c.surface.normal), row);
      scaled_.row(used) = factor * by_row_.col(used).transpose();
      ++used;
    }
    if (used == 0) return;
    double* column = row_.data();
    for (int i = 0; i < width; ++i) {
      std::fill_n(column, width, 0.0);
      kernels::add_weighted_columns(width, width, used, by_row_.data(), scaled_.col(i).data(), 1, column);
      double* out = hessian.col(variable(i)).data();
      for (int k = 0; k < at.coordinates; ++k) out[k] += column[k];
      for (int k = at.coordinates; k < width; ++k) out[variable(k)] += column[k];
    }
  }

 private:
  struct Check {
    int place, obstacle;
    bool carried;
    SurfacePoint surface;
    Rod::Jet radius{};       ///< of the body; the palm stands under it, and is kept off the backbone alone
    double gap = -infinity;  ///< where it was looked at last, there:
    Vec2 at{};
    bool flat = false;  ///< its row has no derivatives
  };

  static void flatten(Check& c, MatrixRef rows, int i) {
    if (!c.flat) rows.row(i).setZero();
    c.flat = true;
  }

  /// direction . dP of a check point against its obstacle, by coordinates up to its piece, arc lengths and the palm.
  void fill(const Check& c, Vec2 direction, double* row) const {
    d_.places.row(c.place, direction, {row, row + d_.layout.coordinates});
    if (d_.layout.palm >= 0) row[row_.size() - 1] = c.carried ? 0.0 : -dot(direction, d_.spec.palm->axis);
  }
  /// The variable that entry i of such a row belongs to.
  int variable(int i) const {
    const PoseProgram::Layout& at = d_.layout;
    const int l = i - at.coordinates;
    return l < 0 ? i : l < at.slides() ? at.first_move + l : at.palm;
  }

  PoseState& d_;
  std::vector<Check> checks_;
  Eigen::VectorXd row_;
  Eigen::MatrixXd by_row_, scaled_;  ///< rows along obstacles, side by side and times the obstacle's curvature
};

}  // namespace

std::unique_ptr<RowBlock> clearance_rows(PoseState& state) { return std::make_unique<ClearanceRows>(state); }

}  // namespace tendril
