#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "program/pose_program_data.hpp"
#include "program/valleys.hpp"
#include "rod/curve.hpp"
#include "rod/outline.hpp"

namespace tendril {
namespace {

/// The moments that hold a shape against nothing but its own stiffness: least squares over the stretches of the rod.
std::vector<double> holding_moments(const Rod& rod, const std::function<double(double)>& curvature) {
  if (rod.actuators.empty()) return {};
  const std::vector<double> knots = rod.fixed_knots();
  const auto stretches = static_cast<Eigen::Index>(knots.size()) - 1;
  const auto count = static_cast<Eigen::Index>(rod.actuators.size());
  Eigen::MatrixXd spans = Eigen::MatrixXd::Zero(stretches, count);
  Eigen::VectorXd wanted(stretches);
  for (Eigen::Index r = 0; r < stretches; ++r) {
    const auto i = static_cast<std::size_t>(r);
    const double middle = 0.5 * (knots[i] + knots[i + 1]);
    const Rod::Segment& segment = rod.segment_at(middle);
    wanted[r] = segment.stiffness_at(middle).value * (curvature(middle) - segment.rest_curvature_at(middle).value);
    for (Eigen::Index a = 0; a < count; ++a) {
      spans(r, a) = rod.actuators[static_cast<std::size_t>(a)].at(middle);
    }
  }
  const Eigen::VectorXd u = spans.completeOrthogonalDecomposition().solve(wanted);
  std::vector<double> moments;
  for (Eigen::Index a = 0; a < count; ++a) {
    const Rod::Actuator& actuator = rod.actuators[static_cast<std::size_t>(a)];
    moments.push_back(std::clamp(u[a], actuator.minimum, actuator.maximum));
  }
  return moments;
}

/// The palm distance at which the first contact's part of a shape comes nearest to touching its obstacle, and the rest
/// overlaps it least. `line`: of the shape, with the base at Rod::base.
double start_distance(const PoseProgram& program, const StartShape& shape, const std::vector<OutlinePoint>& line) {
  const PoseProgramSpec& spec = program.spec();
  const double low = spec.palm->minimum;
  const double high = spec.palm->maximum;
  if (std::isfinite(shape.palm_distance)) return std::clamp(shape.palm_distance, low, high);
  if (spec.contacts.empty()) return 0.5 * (low + high);
  const Obstacle& obstacle = *spec.obstacles[static_cast<std::size_t>(spec.contacts[0].obstacle)];
  const bool at_tip = spec.contacts[0].at_tip;
  const double from = at_tip ? 1.0 : program.lower()[program.layout().first_arc_length];
  const double to = at_tip ? 1.0 : program.upper()[program.layout().first_arc_length];
  constexpr int candidates = 60;
  double best = infinity;
  double distance = low;
  for (int c = 0; c <= candidates; ++c) {
    const double trial = low + (high - low) * c / candidates;
    double own = infinity;
    double any = infinity;
    for (const OutlinePoint& p : line) {
      const double gap = obstacle.at(p.position - trial * spec.palm->axis).distance - p.radius;
      any = std::min(any, gap);
      if (p.s >= from && p.s <= to) own = std::min(own, gap);
    }
    const double defect = std::abs(own) + std::max(0.0, -any);
    if (!(defect < best)) continue;
    best = defect;
    distance = trial;
  }
  return distance;
}

/// Where a contact inside the rod starts: where the shape comes nearest to its obstacle. Of several with one obstacle
/// in one stretch each has a valley of its own, as far as there are so many.
double first_place(const PoseProgramSpec& spec, std::size_t contact, const std::vector<OutlinePoint>& line, double low,
                   double high) {
  const ContactSetup& own = spec.contacts[contact];
  std::size_t before = 0;
  std::size_t all = 0;
  for (std::size_t k = 0; k < spec.contacts.size(); ++k) {
    const ContactSetup& c = spec.contacts[k];
    if (c.at_tip || c.obstacle != own.obstacle || c.region != own.region) continue;
    before += k < contact ? 1 : 0;
    ++all;
  }
  std::vector<Valley> places = valleys(line, *spec.obstacles[static_cast<std::size_t>(own.obstacle)], low, high);
  if (places.size() < all) return low + (high - low) * static_cast<double>(before + 1) / static_cast<double>(all + 1);
  places.resize(all);
  std::sort(places.begin(), places.end(), [](const Valley& a, const Valley& b) { return a.arc_length < b.arc_length; });
  return places[before].arc_length;
}

/// Curvature and stretch of a chain at given coordinates, constant over each of many short parts of the rod, with the
/// value in its middle. A series of the curvature costs less than the basis.
class SampledShape {
 public:
  SampledShape(const Chain& chain, ConstVectorRef q, std::span<const double> knots)
      : tables_(chain.curve_tables()),
        stretch_(chain.table().stretch),
        functions_(chain.functions()),
        q_(q),
        series_(tables_->per_interval(), tables_->intervals() * chain.piece_count()) {
    const int intervals = tables_->intervals();
    for (int j = 0; j < chain.piece_count(); ++j) {
      pieces_.push_back({chain.start(j, knots), chain.length(j, knots)});
      const Eigen::VectorXd at_nodes =
          chain.table().slope * q_.segment(j * functions_, functions_) / pieces_.back().length;
      series_.middleCols(j * intervals, intervals).noalias() =
          tables_->transform() * at_nodes.reshaped(tables_->per_interval(), intervals);
    }
  }
  double curvature(double s) const {
    const Place at = place(s);
    int i = 0;
    while (i + 1 < tables_->intervals() && at.sigma > tables_->end(i + 1)) ++i;
    const double width = tables_->end(i + 1) - tables_->end(i);
    return tables_->sum(series_.col(at.piece * tables_->intervals() + i).data(), tables_->per_interval(),
                        2.0 * (at.sigma - tables_->end(i)) / width - 1.0);
  }
  double stretch(double s) const {
    const Place at = place(s);
    Eigen::VectorXd value(stretch_.order), slope(stretch_.order);
    stretch_.evaluate(at.sigma, value.data(), slope.data());
    return value.dot(q_.segment((at.piece + 1) * functions_ - stretch_.order, stretch_.order));
  }

 private:
  static constexpr int samples = 501;
  struct Piece {
    double start, length;
  };
  struct Place {
    int piece;
    double sigma;
  };
  Place place(double s) const {
    const int sample = std::clamp(static_cast<int>(s * samples), 0, samples - 1);
    for (int j = 0;; ++j) {
      const Piece& p = pieces_[static_cast<std::size_t>(j)];
      const double inside = ((static_cast<double>(sample) + 0.5) / samples - p.start) / p.length;
      if (inside > 1.0 && j + 1 < static_cast<int>(pieces_.size())) continue;
      return {j, std::clamp(inside, 0.0, 1.0)};
    }
  }

  std::shared_ptr<const CurveTables> tables_;
  StretchBasis stretch_;
  int functions_;
  Eigen::VectorXd q_;
  Eigen::MatrixXd series_;  ///< of the curvature, a column per piece and interval
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<Valley> valleys(const std::vector<OutlinePoint>& line, const Obstacle& obstacle, double from, double to) {
  std::vector<Valley> found;
  double before = infinity;
  bool falls = true;
  for (const OutlinePoint& p : line) {
    if (p.s < from || p.s > to) continue;
    const double distance = obstacle.at(p.position).distance - p.radius;
    // The last point of a fall is a valley as soon as the distance rises again, or the stretch ends.
    if (distance < before) {
      if (falls && !found.empty()) found.pop_back();
      found.push_back({distance, p.s});
    }
    falls = distance < before || (falls && distance == before);
    before = distance;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Valley& a, const Valley& b) { return a.distance < b.distance; });
  return found;
}

StartShape constant_curvature(double tip_angle) {
  StartShape shape;
  shape.curvature = [tip_angle](double) { return tip_angle; };
  return shape;
}

Eigen::VectorXd PoseProgram::start_from(const StartShape& shape) const {
  const Data& d = *data_;
  const Layout& at = d.layout;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(variable_count());

  const std::vector<double> moments =
      shape.moments.empty() ? holding_moments(*d.spec.rod, shape.curvature) : shape.moments;
  for (std::size_t a = 0; a < d.moment_variable.size(); ++a) {
    if (d.moment_variable[a] >= 0) x[d.moment_variable[a]] = moments[a];
  }

  for (int l = 0; l < at.moves; ++l) {
    const auto i = static_cast<std::size_t>(l);
    const int variable = at.first_move + l;
    x[variable] = std::clamp(shape.moves.empty() ? d.spec.rod->moves[i].start : shape.moves[i], lower()[variable],
                             upper()[variable]);
  }

  // Contacts start where the shape comes nearest to their obstacles, unless it says where they are.
  const auto placed = [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    return i < shape.arc_lengths.size() && std::isfinite(shape.arc_lengths[i]);
  };
  bool drawn = at.palm >= 0 && !std::isfinite(shape.palm_distance);
  for (int k = 0; k < at.arc_lengths; ++k) drawn = drawn || !placed(k);
  std::vector<OutlinePoint> line;
  if (drawn) outline(*d.spec.rod, shape.curvature, 400, line);
  if (d.spec.palm) {
    const double distance = at.palm < 0 ? d.spec.palm->minimum : start_distance(*this, shape, line);
    if (at.palm >= 0) x[at.palm] = distance;
    for (OutlinePoint& p : line) p.position += -distance * d.spec.palm->axis;
  }
  for (int k = 0; k < at.arc_lengths; ++k) {
    const int variable = at.first_arc_length + k;
    const double low = std::max(lower()[variable], d.spec.rod->draws() ? x[at.first_arc_length - 1] : 0.0);
    const double high = upper()[variable];
    const auto index = static_cast<std::size_t>(k);
    if (placed(k)) {
      x[variable] = std::clamp(shape.arc_lengths[index], low, high);
      continue;
    }
    // A start in the middle of what is allowed leaves room to slide; the ends leave pieces without length.
    const double margin = 0.05 * (high - low);
    x[variable] = std::clamp(first_place(d.spec, index, line, low, high), low + margin, high - margin);
  }
  for (int k = 0; k + 1 < at.arc_lengths; ++k) {
    const auto index = static_cast<std::size_t>(k);
    if (d.spec.contacts[index].region != d.spec.contacts[index + 1].region) continue;
    const double least = x[at.first_arc_length + k] + 0.02;
    x[at.first_arc_length + k + 1] =
        std::min(upper()[at.first_arc_length + k + 1], std::max(least, x[at.first_arc_length + k + 1]));
  }
  for (int k = 0; k < at.forces; ++k) {
    const auto index = static_cast<std::size_t>(k);
    const double force = index < shape.forces.size() && std::isfinite(shape.forces[index]) ? shape.forces[index] : 0.0;
    x[at.first_force + k] = std::clamp(force, lower()[at.first_force + k], upper()[at.first_force + k]);
  }

  for (int k = 0; k < at.leans && k < static_cast<int>(shape.leans.size()); ++k) {
    const int variable = at.first_lean + k;
    x[variable] = std::clamp(shape.leans[static_cast<std::size_t>(k)], lower()[variable], upper()[variable]);
  }

  x.head(at.coordinates) = d.chain.coordinates_of(shape.curvature, knots(x), shape.stretch);
  return x;
}

StartShape PoseProgram::shape_of(ConstVectorRef x) const {
  const Data& d = *data_;
  const Layout& at = d.layout;
  StartShape shape;
  const auto series = std::make_shared<const SampledShape>(d.chain, x.head(at.coordinates), knots(x));
  shape.curvature = [series](double s) { return series->curvature(s); };
  if (d.chain.stretches() > 0) shape.stretch = [series](double s) { return series->stretch(s); };
  for (const int variable : d.moment_variable) shape.moments.push_back(variable < 0 ? 0.0 : x[variable]);
  for (int l = 0; l < at.moves; ++l) shape.moves.push_back(x[at.first_move + l]);
  for (int k = 0; k < at.forces; ++k) {
    const int variable = arc_length_variable(k);
    shape.arc_lengths.push_back(variable < 0 ? std::numeric_limits<double>::quiet_NaN() : x[variable]);
    shape.forces.push_back(x[at.first_force + k]);
    if (at.leans > 0) shape.leans.push_back(x[at.first_lean + k]);
  }
  if (d.spec.palm) shape.palm_distance = palm_distance(x);
  return shape;
}

}  // namespace tendril
