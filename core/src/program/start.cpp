#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

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

  // Contacts start where the shape comes nearest to their obstacles.
  std::vector<OutlinePoint> line;
  if (at.arc_lengths > 0 || d.spec.palm) outline(*d.spec.rod, shape.curvature, 400, line);
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
    if (index < shape.arc_lengths.size() && std::isfinite(shape.arc_lengths[index])) {
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
  const std::span<const double> knots = this->knots(x);
  static constexpr int samples = 500;
  std::vector<double> curvature(samples + 1);
  std::vector<double> stretch(d.chain.stretches() > 0 ? curvature.size() : 0);
  Eigen::VectorXd grown(d.chain.stretches());
  Eigen::VectorXd grown_slope(d.chain.stretches());
  const CurveTables& tables = *d.chain.curve_tables();
  const int n = tables.per_interval();
  Eigen::MatrixXd series(n, tables.intervals());
  std::size_t done = 0;
  for (int j = 0; j < d.chain.piece_count(); ++j) {
    const double from = d.chain.start(j, knots);
    const double length = d.chain.length(j, knots);
    // A series of the curvature costs less than the basis at every sample.
    const Eigen::VectorXd at_nodes =
        d.chain.table().slope * x.segment(j * d.chain.functions(), d.chain.functions()) / length;
    series.noalias() = tables.transform() * at_nodes.reshaped(n, tables.intervals());
    for (int interval = 0; done < curvature.size(); ++done) {
      const double inside = ((static_cast<double>(done) + 0.5) / (samples + 1.0) - from) / length;
      if (inside > 1.0 && j + 1 < d.chain.piece_count()) break;
      const double sigma = std::clamp(inside, 0.0, 1.0);
      while (interval + 1 < tables.intervals() && sigma > tables.end(interval + 1)) ++interval;
      const double width = tables.end(interval + 1) - tables.end(interval);
      curvature[done] = tables.sum(series.col(interval).data(), n, 2.0 * (sigma - tables.end(interval)) / width - 1.0);
      if (stretch.empty()) continue;
      d.chain.table().stretch.evaluate(sigma, grown.data(), grown_slope.data());
      stretch[done] = grown.dot(x.segment(j * d.chain.functions() + d.chain.bends(), d.chain.stretches()));
    }
  }
  StartShape shape;
  const auto sampled = [](std::vector<double> along) {
    return [along = std::move(along)](double s) {
      return along[static_cast<std::size_t>(std::clamp(static_cast<int>(s * (samples + 1)), 0, samples))];
    };
  };
  if (!stretch.empty()) shape.stretch = sampled(std::move(stretch));
  shape.curvature = sampled(std::move(curvature));
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
