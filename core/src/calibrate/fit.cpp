#include "calibrate/fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nlp/levenberg.hpp"

namespace tendril {
namespace {

/// Steps that move the markers by less than this are rounding: a norm over all of them, in L.
constexpr double step_floor = 1e-12;
/// Without noise the residuals end at rounding, in L.
constexpr double least_noise = 1e-12;
/// A fit whose steps no longer help has converged if what remains is this part of the noise.
constexpr double rounding_share = 1e-3;
/// Huber's loss grows linearly from so many standard deviations on, where it loses 5 % against squares.
constexpr double huber = 1.345;
/// The median of a normal variable's size, times this, is its standard deviation.
constexpr double median_to_deviation = 1.4826;
/// Noise and weights are found in turn until the noise changes by no more than this part.
constexpr int most_rounds = 30;
constexpr double noise_tolerance = 1e-4;

Vec2 rotated(Vec2 v, double angle) { return std::cos(angle) * v + std::sin(angle) * turned(v); }

/// A factor on the stiffness in bending, or on that of the stretch.
bool bends(CalibrationUnknown u) { return u == CalibrationUnknown::stiffness || u == CalibrationUnknown::modulus; }
bool stretches(CalibrationUnknown u) {
  return u == CalibrationUnknown::axial_stiffness || u == CalibrationUnknown::modulus;
}

int count_of(const SeenMarker& m) { return (m.has_position ? 2 : 0) + (m.has_angle ? 1 : 0); }

Rod at_origin(Rod rod) {
  rod.base = {};
  return rod;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

CalibrationFit::CalibrationFit(const SoughtNumbers& problem, int order, double turn, const Deadline& deadline)
    : problem_(problem),
      rod_(at_origin(problem.rod), std::vector<double>(problem.rod.actuators.size()), order, turn),
      deadline_(deadline) {
  columns_.reserve(problem.shapes.size());
  for (const SeenShape& shape : problem.shapes) {
    std::vector<int>& columns = columns_.emplace_back();
    for (std::size_t i = 0; i < problem.unknowns.size(); ++i) {
      const int group = problem.unknowns[i].group;
      if (group < 0 || group == shape.group) columns.push_back(static_cast<int>(i));
    }
  }
}

int CalibrationFit::count(const SoughtNumbers& problem, const std::vector<int>& shapes) {
  int count = 0;
  for (const int s : shapes) {
    for (const SeenMarker& m : problem.shapes[static_cast<std::size_t>(s)].markers) count += count_of(m);
  }
  return count;
}

LoadedRod::Properties CalibrationFit::properties(const Eigen::VectorXd& values) const {
  const auto segments = static_cast<int>(problem_.rod.segments.size());
  LoadedRod::Properties out{Eigen::VectorXd::Ones(segments), Eigen::VectorXd::Ones(segments),
                            Eigen::VectorXd::Zero(segments)};
  for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
    const Sought& u = problem_.unknowns[i];
    const double value = values[static_cast<Eigen::Index>(i)];
    const int first = std::max(0, u.index);
    const int count = u.index < 0 ? segments : 1;
    if (bends(u.kind)) out.stiffness.segment(first, count) *= value;
    if (stretches(u.kind)) out.axial.segment(first, count) *= value;
    if (u.kind == CalibrationUnknown::density) {
      out.density *= value;
    } else if (u.kind == CalibrationUnknown::rest_curvature) {
      const Rod::Segment& segment = problem_.rod.segments[static_cast<std::size_t>(u.index)];
      out.rest_curvature[u.index] = value - segment.rest_curvature;
    }
  }
  return out;
}

CalibrationFit::Pose CalibrationFit::pose(const Eigen::VectorXd& values, int shape) const {
  Pose pose{problem_.rod.base, 0.0};
  for (const int i : unknowns_of(shape)) {
    const CalibrationUnknown kind = problem_.unknowns[static_cast<std::size_t>(i)].kind;
    if (kind == CalibrationUnknown::base_x) pose.position.x = values[i];
    if (kind == CalibrationUnknown::base_y) pose.position.y = values[i];
    if (kind == CalibrationUnknown::base_angle) pose.angle = values[i] - problem_.rod.base_angle;
  }
  return pose;
}

LoadedRod::Loads CalibrationFit::loads(const Eigen::VectorXd& values, const SeenShape& shape, const Pose& pose) const {
  LoadedRod::Loads out = shape.loads;
  out.moments = shape.moments;
  out.thrusts.setZero(shape.moments.size());
  for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
    const Sought& u = problem_.unknowns[i];
    if (!is_law(u.kind)) continue;
    (u.kind == CalibrationUnknown::moment ? out.moments : out.thrusts)[u.index] +=
        values[static_cast<Eigen::Index>(i)] * std::pow(shape.inputs[u.index], u.power);
  }
  if (pose.angle == 0.0) return out;
  out.gravity = rotated(out.gravity, -pose.angle);
  for (Push& push : out.at) push.force = rotated(push.force, -pose.angle);
  out.tip.force = rotated(out.tip.force, -pose.angle);
  return out;
}

Eigen::VectorXd CalibrationFit::force_by(const Sought& unknown, const SeenShape& shape) const {
  using Number = LoadedRod::Number;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(rod_.size());
  const int first = std::max(0, unknown.index);
  const int end = unknown.index < 0 ? static_cast<int>(problem_.rod.segments.size()) : first + 1;
  for (int s = first; s < end && bends(unknown.kind); ++s) out += rod_.force_by(Number::stiffness, s);
  for (int s = first; s < end && stretches(unknown.kind); ++s) out += rod_.force_by(Number::axial_stiffness, s);
  if (is_law(unknown.kind)) {
    const Number number = unknown.kind == CalibrationUnknown::moment ? Number::moment : Number::thrust;
    out = std::pow(shape.inputs[unknown.index], unknown.power) * rod_.force_by(number, unknown.index);
  }
  if (unknown.kind == CalibrationUnknown::density) out = rod_.force_by(Number::density, 0);
  if (unknown.kind == CalibrationUnknown::rest_curvature) out = rod_.force_by(Number::rest_curvature, unknown.index);
  if (unknown.kind == CalibrationUnknown::base_angle) out = rod_.force_by(Number::base_angle, 0);
  return out;
}

Places& CalibrationFit::places_at(const std::vector<SeenMarker>& markers) {
  std::vector<double> arc_lengths;
  arc_lengths.reserve(markers.size());
  for (const SeenMarker& m : markers) arc_lengths.push_back(m.arc_length);
  std::unique_ptr<Places>& places = places_[arc_lengths];
  if (!places) {
    places = std::make_unique<Places>(rod_.rod(), rod_.chain(), 0);
    for (const double s : arc_lengths) places->add_fixed(s);
  }
  return *places;
}

void CalibrationFit::see(FittedPoint& point, int shape, const Pose& pose) {
  const auto i = static_cast<std::size_t>(shape);
  const std::vector<SeenMarker>& markers = problem_.shapes[i].markers;
  const std::vector<int>& columns = unknowns_of(shape);
  const auto unknowns = static_cast<Eigen::Index>(columns.size());
  Places& places = places_at(markers);
  places.move(point.coordinates[i], {});
  places.differentiate();
  const int rows = count(problem_, {shape});
  Eigen::VectorXd& residual = point.residuals[i];
  Eigen::MatrixXd& jacobian = point.jacobians[i];
  residual.resize(rows);
  jacobian.resize(rows, unknowns);
  Eigen::RowVectorXd by_q[3];
  Eigen::MatrixXd moved(3, unknowns);
  Eigen::Index row = 0;
  for (int m = 0; m < static_cast<int>(markers.size()); ++m) {
    const SeenMarker& marker = markers[static_cast<std::size_t>(m)];
    for (Eigen::RowVectorXd& r : by_q) r.setZero(rod_.size());
    places.row(m, {1.0, 0.0}, {by_q[0].data(), nullptr});
    places.row(m, {0.0, 1.0}, {by_q[1].data(), nullptr});
    places.angle_row(m, {by_q[2].data(), nullptr});
    for (int r = 0; r < 3; ++r) moved.row(r).noalias() = by_q[r] * point.rates[i];
    const Vec2 t = places.tangent(m);
    const Vec2 stalk = marker.along_tangent * t + marker.along_normal * turned(t);
    const Vec2 seen = rotated(places.point(m) + stalk, pose.angle);
    for (Eigen::Index c = 0; c < unknowns; ++c) {
      const CalibrationUnknown kind =
          problem_.unknowns[static_cast<std::size_t>(columns[static_cast<std::size_t>(c)])].kind;
      Vec2 rate = rotated(Vec2{moved(0, c), moved(1, c)} + moved(2, c) * turned(stalk), pose.angle);
      if (kind == CalibrationUnknown::base_x) rate.x += 1.0;
      if (kind == CalibrationUnknown::base_y) rate.y += 1.0;
      if (kind == CalibrationUnknown::base_angle) {
        rate += turned(seen);
        moved(2, c) += 1.0;
      }
      moved(0, c) = rate.x;
      moved(1, c) = rate.y;
    }
    if (marker.has_position) {
      const Vec2 off = pose.position + seen - marker.position;
      residual.segment<2>(row) << off.x, off.y;
      jacobian.middleRows<2>(row) = moved.topRows<2>();
      row += 2;
    }
    if (marker.has_angle) {
      const double off = std::remainder(places.angle(m) + pose.angle - marker.angle, 2.0 * std::numbers::pi);
      residual[row] = problem_.angle_weight * off;
      jacobian.row(row++) = problem_.angle_weight * moved.row(2);
    }
  }
}

FittedPoint CalibrationFit::at(const Eigen::VectorXd& values, const std::vector<int>& shapes, const FittedPoint* near) {
  FittedPoint point;
  const std::size_t count = problem_.shapes.size();
  point.values = values;
  point.coordinates.resize(count);
  point.rates.resize(count);
  point.residuals.resize(count);
  point.jacobians.resize(count);
  if (near != nullptr) point.weights = near->weights;
  const LoadedRod::Properties properties_here = properties(values);
  for (const int s : shapes) {
    const auto i = static_cast<std::size_t>(s);
    const SeenShape& shape = problem_.shapes[i];
    const Pose pose_here = pose(values, s);
    rod_.set(properties_here, loads(values, shape, pose_here));
    const std::vector<int>& columns = unknowns_of(s);
    Eigen::VectorXd& q = point.coordinates[i];
    ++solves_;
    bool found = false;
    if (near != nullptr && near->coordinates[i].size() == rod_.size()) {
      q = near->coordinates[i];
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const double step = values[columns[c]] - near->values[columns[c]];
        q += step * near->rates[i].col(static_cast<Eigen::Index>(c));
      }
      found = rod_.settle(q);
    }
    if (!found) found = rod_.load_up(q);
    if (!found || !rod_.stand(q)) return point;
    point.rates[i].resize(rod_.size(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const Sought& unknown = problem_.unknowns[static_cast<std::size_t>(columns[c])];
      point.rates[i].col(static_cast<Eigen::Index>(c)) = rod_.follow(force_by(unknown, shape));
    }
    see(point, s, pose_here);
  }
  if (point.weights.empty()) {
    point.weights.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      point.weights[i].setOnes(CalibrationFit::count(problem_, {static_cast<int>(i)}));
    }
  }
  point.found = true;
  return point;
}

double CalibrationFit::priors(const Eigen::VectorXd& values, double noise) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
    const Sought& u = problem_.unknowns[i];
    const double off = noise * (values[static_cast<Eigen::Index>(i)] - u.prior) / u.prior_error;
    sum += off * off;
  }
  return sum;
}

double CalibrationFit::weighted_sum(const FittedPoint& point, double noise) const {
  double sum = priors(point.values, noise);
  for (std::size_t i = 0; i < point.residuals.size(); ++i) {
    if (point.residuals[i].size() > 0) sum += point.residuals[i].cwiseAbs2().dot(point.weights[i]);
  }
  return sum;
}

double CalibrationFit::spread(const FittedPoint& point, const std::vector<int>& shapes) const {
  if (problem_.noise > 0.0) return problem_.noise;
  std::vector<bool> concerned(problem_.unknowns.size(), false);
  std::vector<double> sizes;
  double sum = 0.0;
  for (const int s : shapes) {
    for (const int i : unknowns_of(s)) concerned[static_cast<std::size_t>(i)] = true;
    const Eigen::VectorXd& residual = point.residuals[static_cast<std::size_t>(s)];
    for (const double r : residual) sizes.push_back(std::abs(r));
    sum += residual.squaredNorm();
  }
  const auto count = static_cast<double>(sizes.size());
  const auto unknowns = static_cast<double>(std::count(concerned.begin(), concerned.end(), true));
  const double degrees = std::max(1.0, count - unknowns);
  const double noise = problem_.robust ? median_to_deviation * median(std::move(sizes)) * std::sqrt(count / degrees)
                                       : std::sqrt(sum / degrees);
  return std::max(noise, least_noise);
}

void CalibrationFit::weigh(FittedPoint& point, double noise) const {
  for (std::size_t i = 0; i < point.residuals.size(); ++i) {
    Eigen::Index row = 0;
    for (const SeenMarker& m : problem_.shapes[i].markers) {
      const int rows = count_of(m);
      if (row + rows > point.residuals[i].size()) break;
      const double size = point.residuals[i].segment(row, rows).norm() / (noise * std::sqrt(rows));
      point.weights[i].segment(row, rows).setConstant(std::min(1.0, huber / std::max(size, huber)));
      row += rows;
    }
  }
}

void CalibrationFit::equations(const FittedPoint& point, double noise, Eigen::MatrixXd& normal,
                               Eigen::VectorXd& gradient) const {
  const auto unknowns = static_cast<Eigen::Index>(problem_.unknowns.size());
  normal.setZero(unknowns, unknowns);
  gradient.setZero(unknowns);
  for (std::size_t i = 0; i < point.jacobians.size(); ++i) {
    if (point.jacobians[i].size() == 0) continue;
    const Eigen::MatrixXd weighted = point.weights[i].asDiagonal() * point.jacobians[i];
    const Eigen::MatrixXd own = point.jacobians[i].transpose() * weighted;
    const Eigen::VectorXd own_gradient = weighted.transpose() * point.residuals[i];
    const std::vector<int>& columns = unknowns_of(static_cast<int>(i));
    for (std::size_t a = 0; a < columns.size(); ++a) {
      gradient[columns[a]] += own_gradient[static_cast<Eigen::Index>(a)];
      for (std::size_t b = 0; b < columns.size(); ++b) {
        normal(columns[a], columns[b]) += own(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      }
    }
  }
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    const Sought& u = problem_.unknowns[static_cast<std::size_t>(i)];
    const double weight = noise / u.prior_error;
    normal(i, i) += weight * weight;
    gradient[i] += weight * weight * (point.values[i] - u.prior);
  }
}

/// Unknowns that lean against a bound stay there.
void CalibrationFit::hold_at_bounds(const FittedPoint& point, NormalEquations& at) const {
  for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
    const auto u = static_cast<Eigen::Index>(i);
    const bool low = point.values[u] <= problem_.unknowns[i].lower && at.gradient[u] > 0.0;
    const bool high = point.values[u] >= problem_.unknowns[i].upper && at.gradient[u] < 0.0;
    if (!low && !high) continue;
    at.normal.row(u).setZero();
    at.normal.col(u).setZero();
    at.normal(u, u) = 1.0;
    at.gradient[u] = 0.0;
  }
}

FitEnd CalibrationFit::improve(FittedPoint& point, const std::vector<int>& shapes, double noise, double accuracy,
                               int most_steps) {
  double remaining = infinity;
  double error = noise;
  point.sum = weighted_sum(point, noise);
  const auto here = [&](NormalEquations& at) {
    equations(point, noise, at.normal, at.gradient);
    hold_at_bounds(point, at);
    error = spread(point, shapes);
    // What the shapes do not determine is not asked for.
    Eigen::MatrixXd regular = at.normal;
    regular.diagonal().array() += 1e-12 * std::max(1e-12, at.normal.diagonal().maxCoeff());
    remaining = std::sqrt(std::max(0.0, at.gradient.dot(regular.ldlt().solve(at.gradient))));
    return remaining <= std::max(accuracy * error, step_floor);
  };
  const auto attempt = [&](const Eigen::VectorXd& shift) {
    if (!shift.allFinite()) return StepTried::too_long;
    Eigen::VectorXd values = point.values + shift;
    for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
      const auto u = static_cast<Eigen::Index>(i);
      values[u] = std::clamp(values[u], problem_.unknowns[i].lower, problem_.unknowns[i].upper);
      // A factor that a step would take to nothing or to many times its size is no small step.
      if (is_factor(problem_.unknowns[i].kind) &&
          !(values[u] > 0.2 * point.values[u] && values[u] < 5.0 * point.values[u])) {
        return StepTried::too_long;
      }
    }
    FittedPoint trial = at(values, shapes, &point);
    if (!trial.found) return StepTried::worse;
    trial.sum = weighted_sum(trial, noise);
    if (!(trial.sum < point.sum)) return StepTried::worse;
    point = std::move(trial);
    return StepTried::moved;
  };
  FitEnd end = levenberg(most_steps, here, attempt, [&] { return deadline_.over(); });
  if (end == FitEnd::stuck && remaining <= rounding_share * error) end = FitEnd::converged;
  return end;
}

CalibrationFit::Result CalibrationFit::fit(FittedPoint start, const std::vector<int>& shapes, double accuracy,
                                           int most_steps) {
  Result out{std::move(start)};
  if (!out.point.found) return out;
  const bool believed = std::any_of(problem_.unknowns.begin(), problem_.unknowns.end(),
                                    [](const Sought& u) { return std::isfinite(u.prior_error); });
  // Only what robust weights and priors are measured by has to be known beforehand.
  const bool in_turn = problem_.robust || (believed && problem_.noise == 0.0);
  out.noise = spread(out.point, shapes);
  for (int round = 0; round < (in_turn ? most_rounds : 1); ++round) {
    if (problem_.robust) weigh(out.point, out.noise);
    const FitEnd end = improve(out.point, shapes, out.noise, accuracy, most_steps);
    const double noise = spread(out.point, shapes);
    const bool same = std::abs(noise - out.noise) <= std::max(accuracy, noise_tolerance) * noise;
    out.noise = noise;
    out.converged = end == FitEnd::converged && (same || !in_turn);
    if (end == FitEnd::stuck || out.converged || deadline_.over()) break;
  }
  return out;
}

std::vector<CalibrationFit::Drawn> CalibrationFit::draw(const FittedPoint& point, int shape,
                                                        const std::vector<double>& arc_lengths) {
  std::vector<SeenMarker> markers;
  markers.reserve(arc_lengths.size());
  for (const double s : arc_lengths) markers.push_back({s});
  Places& places = places_at(markers);
  places.move(point.coordinates[static_cast<std::size_t>(shape)], {});
  const Pose at = pose(point.values, shape);
  std::vector<Drawn> out;
  out.reserve(arc_lengths.size());
  for (int m = 0; m < places.count(); ++m) {
    out.push_back(
        {at.position + rotated(places.point(m), at.angle), places.angle(m) + at.angle, places.side(m, 0).curvature});
  }
  return out;
}

}  // namespace tendril
