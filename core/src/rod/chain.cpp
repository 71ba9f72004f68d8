#include "rod/chain.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "rod/curve.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Up to this size the products beta_i beta_k are tabulated: the Gram product is then one sweep over contiguous memory.
constexpr int largest_tabulated_basis = 12;

std::span<const double> span_of(const Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

/// The functions of the stretch, once those of the angle are there.
void add_stretch(BasisTable& t, const StretchBasis& stretch) {
  t.stretch = stretch;
  const int m = stretch.order;
  t.stretch_by_node.resize(m, t.nodes);
  t.mixed.resize(t.bends * m, t.nodes);
  t.stretch_start.resize(m);
  Eigen::VectorXd slope(m);
  stretch.evaluate(0.0, t.stretch_start.data(), slope.data());
  for (int g = 0; g < t.nodes; ++g) {
    stretch.evaluate(t.sigma[g], t.stretch_by_node.col(g).data(), slope.data());
    for (int i = 0; i < t.bends; ++i) t.mixed.col(g).segment(i * m, m) = t.by_node(i, g) * t.stretch_by_node.col(g);
  }
  t.stretch_by_function = t.stretch_by_node.transpose();
}

BasisTable make_table(const CoordinateModel& model, const Quadrature& rule, const Eigen::MatrixXd& transform,
                      const StretchBasis& stretch) {
  BasisTable t;
  t.bends = model.function_count();
  t.functions = t.bends + stretch.order;
  if (t.bends < 1) throw Error("a coordinate model needs at least one function");
  t.nodes = rule.size();
  t.sigma = rule.nodes();
  t.weight = rule.weights();
  t.slope.setZero(t.nodes, t.functions);
  Eigen::MatrixXd second = t.slope;
  t.by_function = t.slope;
  model.evaluate(span_of(t.sigma), t.by_function.leftCols(t.bends), t.slope.leftCols(t.bends),
                 second.leftCols(t.bends));
  t.by_node = t.by_function.transpose();
  t.stiffness = t.slope.transpose() * t.weight.asDiagonal() * t.slope;
  for (int from = 0; from < t.nodes; from += rule.nodes_per_interval()) {
    t.bend_series.emplace_back((transform * second.middleRows(from, rule.nodes_per_interval())).transpose());
  }

  const double ends[2] = {0.0, 1.0};
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(2, t.functions);
  Eigen::MatrixXd slope = value;
  Eigen::MatrixXd bend = value;
  model.evaluate(ends, value.leftCols(t.bends), slope.leftCols(t.bends), bend.leftCols(t.bends));
  if (!value.allFinite() || !slope.allFinite() || !t.by_function.allFinite() || !t.slope.allFinite()) {
    throw Error("the coordinate model returns values that are not finite");
  }
  if (value.row(0).cwiseAbs().maxCoeff() > 1e-12) {
    throw Error("the functions of a coordinate model must vanish at sigma = 0");
  }
  t.end = value.row(1);
  t.slope_start = slope.row(0);
  t.slope_end = slope.row(1);

  if (t.bends <= largest_tabulated_basis) {
    t.products.resize(t.bends * (t.bends + 1) / 2, t.nodes);
    for (int g = 0; g < t.nodes; ++g) {
      int row = 0;
      for (int i = 0; i < t.bends; ++i) {
        for (int k = i; k < t.bends; ++k) t.products(row++, g) = t.by_node(i, g) * t.by_node(k, g);
      }
    }
  }

  // The clearance bound needs max |beta_i'|. Between samples a function of this order moves by less than the inflation.
  const int samples = 64 * (t.bends + 1) + 1;
  const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(samples, 0.0, 1.0);
  Eigen::MatrixXd v(samples, t.bends);
  Eigen::MatrixXd d(samples, t.bends);
  Eigen::MatrixXd dd(samples, t.bends);
  model.evaluate(span_of(at), v, d, dd);
  const double half_step = 0.5 / (samples - 1);
  t.slope_bound =
      d.cwiseAbs().colwise().maxCoeff().transpose() + 2.0 * half_step * dd.cwiseAbs().colwise().maxCoeff().transpose();
  if (stretch.order > 0) add_stretch(t, stretch);
  return t;
}

/// Of a rod and the model of its angle.
StretchBasis stretch_of(const Rod& rod, const CoordinateModel& model) {
  StretchBasis stretch;
  if (!rod.stretches()) return stretch;
  stretch.order = rod.stretch_order == Rod::stretch_as_fine ? model.function_count() : rod.stretch_order;
  stretch.factor = 1.0 / std::sqrt(rod.segments.front().axial);
  return stretch;
}

}  // namespace

int suggested_nodes(int functions, double angle) {
  return static_cast<int>(std::ceil(1.5 * functions + 1.2 * std::abs(angle) + 8.0));
}

void StretchBasis::evaluate(double sigma, double* value, double* slope) const {
  const double x = 2.0 * sigma - 1.0;
  double before = 0.0, here = factor;
  double before_slope = 0.0, here_slope = 0.0;
  for (int k = 0; k < order; ++k) {
    value[k] = here;
    slope[k] = here_slope;
    const double after = ((2 * k + 1) * x * here - k * before) / (k + 1);
    const double after_slope = before_slope + (2 * k + 1) * 2.0 * here;
    before = here;
    here = after;
    before_slope = here_slope;
    here_slope = after_slope;
  }
}

double StretchBasis::bend(double sigma, const double* e) const {
  const double x = 2.0 * sigma - 1.0;
  double before = 0.0, here = factor;
  double before_slope = 0.0, here_slope = 0.0;
  double before_bend = 0.0, here_bend = 0.0;
  double sum = 0.0;
  for (int k = 0; k < order; ++k) {
    sum += e[k] * here_bend;
    const double after_bend = before_bend + (2 * k + 1) * 2.0 * here_slope;
    const double after_slope = before_slope + (2 * k + 1) * 2.0 * here;
    const double after = ((2 * k + 1) * x * here - k * before) / (k + 1);
    before_bend = std::exchange(here_bend, after_bend);
    before_slope = std::exchange(here_slope, after_slope);
    before = std::exchange(here, after);
  }
  return sum;
}

ChainTables::ChainTables(const CoordinateModel& model, int nodes, const StretchBasis& stretch)
    : rule(nodes, model.breaks()),
      curve(std::make_shared<CurveTables>(rule)),
      basis(make_table(model, rule, curve->transform(), stretch)) {}

std::shared_ptr<const ChainTables> TableStore::of(const CoordinateModel& model, int nodes,
                                                  const StretchBasis& stretch) {
  for (const Entry& entry : entries_) {
    if (entry.model == &model && entry.nodes == nodes && entry.stretch == stretch) return entry.tables;
  }
  entries_.push_back({&model, nodes, stretch, std::make_shared<ChainTables>(model, nodes, stretch)});
  return entries_.back().tables;
}

Chain::Chain(const Rod& rod, const CoordinateModel& model, std::span<const int> knot_stretches, int nodes,
             TableStore* store)
    : model_(&model),
      tables_(store != nullptr ? store->of(model, nodes, stretch_of(rod, model))
                               : std::make_shared<ChainTables>(model, nodes, stretch_of(rod, model))),
      fixed_knots_(rod.fixed_knots()),
      segments_(rod.segments),
      thick_(rod.is_thick()) {
  std::vector<double> parts = model.subdivision();
  const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
  if (parts.empty() || !(sum > 0.0)) throw Error("a coordinate model's subdivision must have positive parts");
  const int drawn = rod.draws() ? 1 : 0;
  const auto contacts = static_cast<int>(knot_stretches.size());
  const int knots = drawn + contacts;
  const auto stretches = static_cast<int>(fixed_knots_.size()) - 1;

  // Every knot, moving or not, as constant + unit row over the moving knots, in order along the rod.
  struct Knot {
    double constant;
    int moving;  // index of the moving knot, or -1
  };
  std::vector<double> starts;
  std::vector<double> lengths;
  std::vector<Eigen::RowVectorXd> start_rates;
  std::vector<Eigen::RowVectorXd> length_rates;
  for (int r = 0; r < stretches; ++r) {
    const double from = fixed_knots_[static_cast<std::size_t>(r)];
    const double to = fixed_knots_[static_cast<std::size_t>(r) + 1];
    std::vector<Knot> ends{r < drawn ? Knot{0.0, 0} : Knot{from, -1}};
    for (int k = 0; k < contacts; ++k) {
      const int stretch = knot_stretches[static_cast<std::size_t>(k)];
      if (stretch < 0 || stretch >= stretches) throw Error("a contact knot lies in no stretch of the rod");
      if (k > 0 && stretch < knot_stretches[static_cast<std::size_t>(k) - 1]) throw Error("contact knots must ascend");
      if (stretch == r) ends.push_back({0.0, drawn + k});
    }
    ends.push_back({to, -1});
    const Rod::Segment& segment = rod.segment_at(0.5 * (from + to));
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      double before = 0.0;
      for (const double part : parts) {
        const double fraction = part / sum;
        if (!(fraction > 0.0)) throw Error("a coordinate model's subdivision must have positive parts");
        // Start: end_e + before * (end_(e+1) - end_e); length: fraction * (end_(e+1) - end_e).
        Eigen::RowVectorXd start_rate = Eigen::RowVectorXd::Zero(knots);
        Eigen::RowVectorXd length_rate = Eigen::RowVectorXd::Zero(knots);
        if (ends[e].moving >= 0) {
          start_rate[ends[e].moving] += 1.0 - before;
          length_rate[ends[e].moving] -= fraction;
        }
        if (ends[e + 1].moving >= 0) {
          start_rate[ends[e + 1].moving] += before;
          length_rate[ends[e + 1].moving] += fraction;
        }
        const double span = ends[e + 1].constant - ends[e].constant;
        starts.push_back(ends[e].constant + before * span);
        lengths.push_back(fraction * span);
        start_rates.push_back(start_rate);
        length_rates.push_back(length_rate);
        pieces_.push_back({r, segment.stiffness, segment.weight, segment.rest_curvature,
                           static_cast<int>(&segment - rod.segments.data()), segment.bends_evenly(),
                           segment.weighs_evenly()});
        before += fraction;
      }
      if (ends[e + 1].moving >= 0) knot_piece_.push_back(piece_count() - 1);
    }
  }

  const int count = piece_count();
  start0_ = Eigen::Map<Eigen::VectorXd>(starts.data(), count);
  length0_ = Eigen::Map<Eigen::VectorXd>(lengths.data(), count);
  start_rate_.resize(count, knots);
  length_rate_.resize(count, knots);
  for (int j = 0; j < count; ++j) {
    start_rate_.row(j) = start_rates[static_cast<std::size_t>(j)];
    length_rate_.row(j) = length_rates[static_cast<std::size_t>(j)];
  }
  find_profiles(rod);
  find_loads(rod);
}

void Chain::find_loads(const Rod& rod) {
  for (int j = 0; j < piece_count(); ++j) {
    Piece& p = pieces_[static_cast<std::size_t>(j)];
    const auto r = static_cast<std::size_t>(p.stretch);
    const double middle = 0.5 * (fixed_knots_[r] + fixed_knots_[r + 1]);
    const bool last = j + 1 == piece_count() || piece(j + 1).stretch != p.stretch;
    for (const Rod::Load& load : rod.loads) {
      if (!load.at_point()) {
        if (middle > load.from && middle < load.to) p.line += load.force;
      } else if (last && std::abs(load.from - fixed_knots_[r + 1]) <= knot_merge_distance) {
        p.point += load.force;
        p.point_weight += load.weight;
      }
    }
  }
}

void Chain::find_profiles(const Rod& rod) {
  const auto actuators = static_cast<Eigen::Index>(rod.actuators.size());
  levels_.setZero(actuators, piece_count());
  thrusts_.setZero(actuators, piece_count());
  varying_.setConstant(actuators, piece_count(), -1);
  for (Eigen::Index a = 0; a < actuators; ++a) {
    const Rod::Actuator& actuator = rod.actuators[static_cast<std::size_t>(a)];
    pulls_.push_back(actuator.pull);
    for (int j = 0; j < piece_count(); ++j) {
      const auto r = static_cast<std::size_t>(pieces_[static_cast<std::size_t>(j)].stretch);
      const double middle = 0.5 * (fixed_knots_[r] + fixed_knots_[r + 1]);
      const bool acts = middle > actuator.from && middle < actuator.to;
      if (acts && rod.stretches()) thrusts_(a, j) = actuator.pull ? 1.0 : actuator.thrust;
      const ProfilePart* part = actuator.part_at(middle);
      if (part == nullptr || part->constant()) {
        levels_(a, j) = actuator.at(middle);
      } else if (acts) {
        varying_(a, j) = static_cast<int>(parts_.size());
        parts_.push_back(*part);
      }
    }
  }
}

double Chain::start(int j, std::span<const double> knots) const {
  double value = start0_[j];
  for (int k = 0; k < knot_count(); ++k) value += start_rate_(j, k) * knots[static_cast<std::size_t>(k)];
  return value;
}

double Chain::length(int j, std::span<const double> knots) const {
  double value = length0_[j];
  for (int k = 0; k < knot_count(); ++k) value += length_rate_(j, k) * knots[static_cast<std::size_t>(k)];
  return value;
}

Eigen::VectorXd Chain::project(std::span<const double> scaled_curvature) const {
  const int n = bends();
  const Eigen::Map<const Eigen::VectorXd> target(scaled_curvature.data(), nodes());
  const Eigen::VectorXd rhs = table().slope.leftCols(n).transpose() * table().weight.cwiseProduct(target);
  return table().stiffness.topLeftCorner(n, n).ldlt().solve(rhs);
}

Eigen::VectorXd Chain::coordinates_of(const std::function<double(double)>& curvature, std::span<const double> knots,
                                      const std::function<double(double)>& stretch) const {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(coordinate_count());
  std::vector<double> scaled(static_cast<std::size_t>(nodes()));
  for (int j = 0; j < piece_count(); ++j) {
    const double from = start(j, knots);
    const double h = length(j, knots);
    for (int g = 0; g < nodes(); ++g) {
      scaled[static_cast<std::size_t>(g)] = h * curvature(from + h * table().sigma[g]);
    }
    auto own = q.segment(static_cast<Eigen::Index>(j) * functions(), functions());
    own.head(bends()) = project(scaled);
    if (!stretch) continue;
    const StretchBasis& basis = table().stretch;
    for (int k = 0; k < basis.order; ++k) {
      double part = 0.0;
      for (int g = 0; g < nodes(); ++g) {
        part += table().weight[g] * table().stretch_by_node(k, g) * stretch(from + h * table().sigma[g]);
      }
      own[bends() + k] = (2 * k + 1) * part / (basis.factor * basis.factor);
    }
  }
  return q;
}

int Chain::piece_at(double s, std::span<const double> knots) const {
  for (int j = 0; j + 1 < piece_count(); ++j) {
    if (s <= start(j + 1, knots)) return j;
  }
  return piece_count() - 1;
}

}  // namespace tendril
