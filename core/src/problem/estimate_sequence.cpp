#include "tendril/estimate_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include "estimate/contact_tracker.hpp"
#include "estimate/significance.hpp"
#include "problem/calibrated_range.hpp"
#include "problem/estimate_parts.hpp"

namespace tendril {
namespace {

/// Where frames tell the noise (units of L): below this is what is left of the model, which is no noise.
constexpr double least_noise = 1e-9;
/// The model may be off by this part of the noise.
constexpr double model_share = 1e-3;
/// So many frames, spread over the sequence, tell how far it is.
constexpr std::size_t checked_frames = 8;
constexpr int most_steps_of_a_fit = 200;

/// A sequence on its way.
struct Sequence {
  const EstimateInput& in;
  const Deadline& deadline;
  const SequenceProgress& progress;
  std::vector<SequenceFrame> frames;
  double noise = 0.0;
  std::optional<double> force_rate{}, place_rate{};

  WalkRates rates{};
  std::unique_ptr<LoadedRod> rod{};
  double model_error = 0.0;
  std::vector<TrackedFrame> tracked{};
  int starts = 0, solves = 0;

  double variance() const { return noise * noise; }
  bool complete() const { return tracked.size() == frames.size(); }
};

Sequence begun(const EstimateInput& in, const SequenceSpec& spec, const Deadline& deadline,
               const SequenceProgress& progress) {
  Sequence out{in, deadline, progress, in.frames};
  for (SequenceFrame& frame : out.frames) frame.shape.least_noise = least_noise;
  out.noise = in.frames.front().shape.noise;
  const auto rate = [](const std::optional<double>& si, double unit) {
    return si ? std::optional(*si / unit) : std::nullopt;
  };
  out.force_rate = rate(spec.force_rate, in.scale.force());
  out.place_rate = rate(spec.place_rate, in.scale.length);
  return out;
}

/// One after the other, as far as there is time. `near`: what they told by themselves; or empty.
void follow(Sequence& q, const std::optional<WalkRates>& rates, double accuracy,
            const std::vector<TrackedFrame>& near = {}) {
  // Over all frames, noise shall pass for a change no more often than it does in a single shape. Each has three tests.
  const double most_chance = significance / (3.0 * static_cast<double>(q.frames.size()));
  ContactTracker tracker(*q.rod, {q.in.most_contacts, most_chance, rates, accuracy}, q.deadline);
  q.tracked.clear();
  for (std::size_t i = 0; i < q.frames.size(); ++i) {
    TrackedFrame next = tracker.follow(q.frames[i], near.empty() ? nullptr : &near[i]);
    if (q.deadline.over()) break;
    q.tracked.push_back(std::move(next));
    if (q.progress) q.progress(q.tracked.size(), q.frames.size());
  }
  q.starts += tracker.starts();
}

/// How far functions of a higher order move points of frames at the forces that were found.
double change_with(Sequence& q, int order, double turn) {
  LoadedRod finer(q.in.rod, q.frames.front().moments, order, turn);
  double out = 0.0;
  const std::size_t step = (q.tracked.size() + checked_frames - 1) / checked_frames;
  for (std::size_t i = 0; i < q.tracked.size(); i += step) {
    const ShapeFit& fit = q.tracked[i].fit;
    if (!q.tracked[i].found) continue;
    finer.set_moments(q.frames[i].moments);
    const LoadedRod::Shape shape = finer.solve(fit.shape.forces, q.rod->curvature(fit.shape));
    if (!shape.converged) return infinity;
    const Eigen::VectorXd points = finer.response(shape, q.frames[i].shape.arc_lengths).points;
    out = std::max(out, (points - fit.response.points).lpNorm<Eigen::Infinity>());
  }
  q.solves += finer.solve_count();
  return out;
}

std::vector<FrameEvidence> evidence_of(const Sequence& q) {
  std::vector<FrameEvidence> out;
  for (std::size_t i = 0; i < q.tracked.size(); ++i) {
    const double step = i == 0 ? 0.0 : q.frames[i].time - q.frames[i - 1].time;
    out.push_back(evidence_of(q.tracked[i], q.frames[i].shape.points.size(), step, q.variance()));
  }
  return out;
}

/// What the scene does not say is told by frames that stand alone: how much is noise, how fast contacts change.
std::optional<WalkRates> learned(Sequence& q) {
  if (q.noise == 0.0) {
    double squares = 0.0;
    int degrees = 0;
    for (const TrackedFrame& frame : q.tracked) {
      squares += frame.squares;
      degrees += frame.degrees;
    }
    q.noise = std::max(least_noise, degrees > 0 ? std::sqrt(squares / degrees) : 0.0);
    for (SequenceFrame& frame : q.frames) frame.shape.noise = q.noise;
  }
  const std::vector<FrameEvidence> evidence = evidence_of(q);
  const std::optional<WalkRates> likeliest = likeliest_rates(evidence, q.force_rate, q.place_rate);
  if (!likeliest) return std::nullopt;
  return fastest_likely(evidence, *likeliest, q.force_rate.has_value(), q.place_rate.has_value());
}

void solve(Sequence& q) {
  double turn = 0.0;
  for (const SequenceFrame& frame : q.frames) turn = std::max(turn, measured_turn(q.in.rod, frame.shape));
  turn = std::min(30.0, turn + 1.0);
  std::optional<WalkRates> rates;
  if (q.noise > 0.0 && q.force_rate && q.place_rate) rates = WalkRates{*q.force_rate, *q.place_rate};
  int order = first_order;
  for (const int finer : finer_orders) {
    q.rod = std::make_unique<LoadedRod>(q.in.rod, q.frames.front().moments, order, turn);
    // Frames that only are to tell the rates are not needed to the last digit.
    follow(q, rates, rates ? final_accuracy : search_accuracy);
    if (!q.complete()) break;
    q.model_error = change_with(q, finer, turn);
    if (q.model_error <= std::max(order_tolerance, model_share * q.noise)) break;
    if (finer == *std::rbegin(finer_orders)) break;
    q.solves += q.rod->solve_count();
    order = finer;
  }
  if (q.complete() && !rates) {
    rates = learned(q);
    const std::vector<TrackedFrame> alone = std::move(q.tracked);
    follow(q, rates, final_accuracy, alone);
  }
  q.solves += q.rod->solve_count();
  // Frames that only were to tell the rates are no answer.
  if (!q.complete() && !rates) q.tracked.clear();
  q.rates = rates.value_or(WalkRates{});
}

/// Force and place of contact `k` of a state.
NormalForce force_of(const ContactState& state, std::size_t k) {
  const auto i = 2 * static_cast<Eigen::Index>(k);
  return {state.mean[i], std::clamp(state.mean[i + 1], 0.0, 1.0)};
}

void report_contacts(const Sequence& q, const TrackedFrame& tracked, const ContactState& so_far,
                     const ContactState& all, EstimatedFrame& out) {
  const std::size_t count = tracked.contacts.size();
  std::vector<double> places;
  for (const ContactState* state : {&so_far, &all}) {
    for (std::size_t k = 0; k < count; ++k) places.push_back(force_of(*state, k).arc_length);
  }
  const std::vector<LoadedRod::Point> points = q.rod->points(tracked.fit.shape, places);
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = 2 * static_cast<Eigen::Index>(k);
    const auto told = [&](const ContactState& state, const LoadedRod::Point& at) {
      const NormalForce f = force_of(state, k);
      const Eigen::Vector2d unit((f.force < 0.0 ? -1.0 : 1.0) * q.in.scale.force(), q.in.scale.length);
      const Eigen::Matrix2d block = state.covariance.block<2, 2>(i, i);
      return contact_of(q.in.scale, f, at, unit.asDiagonal() * block * unit.asDiagonal());
    };
    out.contacts.push_back({tracked.contacts[k], told(all, points[count + k]), told(so_far, points[k])});
  }
}

/// What the contacts of a frame may be, whatever the state of their friction, as its points alone have them: that state
/// may be another one in each frame, and is no noise that others would even out.
void report_friction(const Sequence& q, std::size_t i, EstimatedFrame& out) {
  const TrackedFrame& tracked = q.tracked[i];
  if (q.in.friction == 0.0 || tracked.fit.contacts() == 0) return;
  const MeasuredShape& measured = q.frames[i].shape;
  q.rod->set_moments(q.frames[i].moments);
  const ShapeFit alone =
      fit_shape(*q.rod, measured, tracked.fit.shape, final_accuracy, most_steps_of_a_fit, q.deadline);
  if (!alone.converged) return;
  const ConeFits cone = fit_cone(*q.rod, measured, alone, q.in.friction, final_accuracy, q.deadline);
  for (int k = 0; k < alone.contacts(); ++k) {
    out.contacts[static_cast<std::size_t>(k)].all.friction = friction_of(q.in, measured, cone, k);
  }
}

EstimatedFrame frame_of(const Sequence& q, std::size_t i, std::string& trouble) {
  const TrackedFrame& tracked = q.tracked[i];
  EstimatedFrame out;
  out.time = q.frames[i].time;
  if (i > 0) {
    const std::vector<int>& past = q.tracked[i - 1].contacts;
    std::copy_if(past.begin(), past.end(), std::back_inserter(out.broken), [&](int c) {
      return std::find(tracked.contacts.begin(), tracked.contacts.end(), c) == tracked.contacts.end();
    });
  }
  for (std::size_t k = 0; k < tracked.before.size(); ++k) {
    if (tracked.before[k] < 0) out.made.push_back(tracked.contacts[k]);
  }
  if (!tracked.found) {
    trouble = "no equilibrium near its points was found, whatever the contacts";
    return out;
  }
  const Eigen::VectorXd residual = tracked.fit.residual.head(q.frames[i].shape.points.size());
  // Noise that the frames told is none that they could be measured by.
  trouble = misfit(q.in.frames[i].shape, q.in.scale.length, residual, tracked.fit.contacts());
  out.status = trouble.empty() ? EstimateStatus::solved : EstimateStatus::poor_fit;
  out.residual_rms = std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size())) * q.in.scale.length;
  out.chi_square = tracked.squares / q.variance();
  out.degrees_of_freedom = tracked.degrees;
  out.fit_probability = chi_square_probability(out.chi_square, out.degrees_of_freedom);
  out.surprise = tracked.conflict / q.variance();
  out.surprise_degrees = tracked.conflict_degrees;
  out.surprise_probability = chi_square_probability(out.surprise, out.surprise_degrees);
  return out;
}

std::string name_of(const EstimatedFrame& frame, bool timed) {
  return timed ? "that at " + shown(frame.time) + " s" : "number " + shown(frame.time);
}

void report_frames(const Sequence& q, SequenceEstimate& out) {
  const std::vector<FrameEvidence> evidence = evidence_of(q);
  const std::vector<ContactState> so_far = filtered(evidence, q.rates);
  const std::vector<ContactState> all = smoothed(evidence, so_far, q.rates);
  int troubled = 0;
  double squares = 0.0;
  Eigen::Index coordinates = 0;
  out.status = EstimateStatus::solved;
  for (std::size_t i = 0; i < q.tracked.size(); ++i) {
    std::string trouble;
    EstimatedFrame frame = frame_of(q, i, trouble);
    if (q.tracked[i].found) {
      report_contacts(q, q.tracked[i], so_far[i], all[i], frame);
      report_friction(q, i, frame);
    }
    if (!trouble.empty() && ++troubled == 1) {
      out.status = frame.status;
      out.message = name_of(frame, out.timed) + ": " + trouble +
                    hint_of(q.in, q.in.frames[i].shape, q.frames[i].moments, q.deadline);
    }
    const Eigen::Index count = q.frames[i].shape.points.size();
    if (q.tracked[i].found) {
      squares += q.tracked[i].fit.residual.head(count).squaredNorm();
      coordinates += count;
    }
    out.chi_square += frame.chi_square + frame.surprise;
    out.degrees_of_freedom += frame.degrees_of_freedom + frame.surprise_degrees;
    out.frames.push_back(std::move(frame));
  }
  if (troubled > 0) {
    out.message = shown(troubled) + " of " + shown(static_cast<double>(q.frames.size())) +
                  (troubled == 1 ? " frames is" : " frames are") + " not explained, first " + out.message;
  }
  if (coordinates > 0) out.residual_rms = std::sqrt(squares / static_cast<double>(coordinates)) * q.in.scale.length;
  if (out.noise_estimated) return;
  out.fit_probability = chi_square_probability(out.chi_square, out.degrees_of_freedom);
  const std::string doubt = doubt_of_noise(out.chi_square, out.degrees_of_freedom);
  if (!doubt.empty()) out.message += (out.message.empty() ? "" : "; ") + doubt;
}

/// A contact of which no frame tells force and place.
void report_identifiable(SequenceEstimate& out) {
  std::vector<bool> told;
  for (const EstimatedFrame& frame : out.frames) {
    for (const FollowedContact& c : frame.contacts) {
      told.resize(std::max(told.size(), static_cast<std::size_t>(c.number)));
      if (c.all.identifiable) told[static_cast<std::size_t>(c.number - 1)] = true;
    }
  }
  const auto unknown = std::find(told.begin(), told.end(), false);
  if (out.status != EstimateStatus::solved || unknown == told.end()) return;
  out.status = EstimateStatus::not_identifiable;
  out.message = "the points show contact " + std::to_string(unknown - told.begin() + 1) +
                ", but determine its force and place in no frame";
}

}  // namespace

SequenceEstimate estimate_sequence(const Scene& scene, const SequenceSpec& spec, const PlanControl& control,
                                   const SequenceProgress& progress) {
  const double begin = now();
  const EstimateInput in(scene, spec);
  const Deadline deadline(control.stop, scene.solver.time_limit);
  Sequence q = begun(in, spec, deadline, progress);
  solve(q);
  SequenceEstimate out;
  out.left_out = left_out_of(scene, in);
  out.timed = spec.timed;
  out.starts = q.starts;
  out.solves = q.solves;
  out.order = q.rod->order();
  out.model_error = q.model_error * in.scale.length;
  out.noise_estimated = scene.measurement.noise == 0.0;
  out.noise = q.noise * in.scale.length;
  out.force_rate = q.rates.force * in.scale.force();
  out.place_rate = q.rates.place * in.scale.length;
  out.rates_estimated = !q.force_rate || !q.place_rate;
  out.assumed = assumption(in.friction);
  // What was followed until the time was over stands, if there is a noise to measure it by.
  if (!q.tracked.empty() && q.noise > 0.0) {
    report_frames(q, out);
    report_identifiable(out);
    for (std::size_t i = 0; i < out.frames.size(); ++i) {
      EstimatedFrame& frame = out.frames[i];
      frame.moments = spec.frames[i].moments.empty() ? known_moments(scene) : spec.frames[i].moments;
      // The first frame of a kind stands for all of them.
      if (!out.notes.empty()) continue;
      tell_beyond_calibration(scene, frame.moments, std::vector<double>(frame.moments.size(), unknown_turn),
                              scene.rod.base_angle, name_of(frame, out.timed) + ": ", out.notes);
    }
    if (q.tracked.back().found) out.backbone = backbone_of(in.scale, *q.rod, q.tracked.back().fit.shape);
  }
  end(deadline, scene.solver.time_limit, begin, out);
  return out;
}

}  // namespace tendril
