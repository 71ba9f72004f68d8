// Contacts followed through sequences of shapes: against the boundary-value problem, and against the recursive
// Cramer-Rao bound.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "estimate/loaded_rod.hpp"
#include "estimate/truth.hpp"
#include "scene/make_rod.hpp"
#include "support/contains.hpp"
#include "tendril/estimate_sequence.hpp"

namespace tendril {
namespace {

using test::Truth;

MeasuredFrame frame_of(double time, const Eigen::VectorXd& points, double length, std::vector<double> moments) {
  MeasuredFrame frame{time, {}, std::move(moments)};
  const Eigen::Index count = points.size() / 2;
  for (Eigen::Index i = 0; i < count; ++i) {
    frame.points.push_back(
        {length * static_cast<double>(i + 1) / static_cast<double>(count), {points[2 * i], points[2 * i + 1]}});
  }
  return frame;
}

Scene scene_of(const Truth& truth, double noise, int contacts) {
  Scene scene = test::scene_of(truth, Eigen::VectorXd::Zero(2), noise, contacts);
  scene.solver.time_limit = 600.0;
  return scene;
}

/// Points of a rod under given forces (N, along the backbone's normal) and places (m).
class Simulator {
 public:
  explicit Simulator(const Truth& truth, int count = 20)
      : scene_(scene_of(truth, 0.0, 1)),
        scale_(scale_of(scene_)),
        rod_(make_rod(scene_, scale_), scaled(truth.moments), 16, 4.0) {
    for (int i = 0; i < count; ++i) places_.push_back((i + 1.0) / count);
  }

  /// `state`: force and place of each contact in turn.
  Eigen::VectorXd points(const Eigen::VectorXd& state) {
    std::vector<NormalForce> forces;
    for (Eigen::Index i = 0; i < state.size(); i += 2) forces.push_back({state[i], state[i + 1]});
    return points(std::move(forces));
  }

  /// N and m.
  Eigen::VectorXd points(std::vector<NormalForce> forces) {
    for (NormalForce& f : forces) f = {f.force / scale_.force(), f.arc_length / scale_.length, f.lean};
    const LoadedRod::Shape free = rod_.solve({}, [](double) { return 0.5; });
    const LoadedRod::Shape shape = rod_.solve(forces, last_.converged ? last_ : free);
    EXPECT_TRUE(shape.converged);
    last_ = shape;
    const std::vector<LoadedRod::Point> at = rod_.points(shape, places_);
    Eigen::VectorXd out(2 * static_cast<Eigen::Index>(at.size()));
    for (std::size_t i = 0; i < at.size(); ++i) {
      out.segment<2>(2 * static_cast<Eigen::Index>(i)) << at[i].position.x, at[i].position.y;
    }
    return scale_.length * out;
  }

  /// Fisher's information of the state in points with this noise, by central differences.
  Eigen::MatrixXd information(const Eigen::VectorXd& state, double noise) {
    Eigen::MatrixXd rates(2 * static_cast<Eigen::Index>(places_.size()), state.size());
    for (Eigen::Index i = 0; i < state.size(); ++i) {
      const double step = 1e-4 * (i % 2 == 0 ? scale_.force() : scale_.length);
      Eigen::VectorXd moved = state;
      moved[i] += step;
      const Eigen::VectorXd high = points(moved);
      moved[i] -= 2.0 * step;
      rates.col(i) = (high - points(moved)) / (2.0 * step);
    }
    return rates.transpose() * rates / (noise * noise);
  }

 private:
  std::vector<double> scaled(std::vector<double> moments) const {
    for (double& m : moments) m /= scale_.moment();
    return moments;
  }
  Scene scene_;
  Scale scale_;
  LoadedRod rod_;
  LoadedRod::Shape last_;
  std::vector<double> places_;
};

// The braced arm while its moment rises: the force doubles, the place slides. Times are uneven, rates and noise
// unknown.
TEST(Sequence, ExactShapesGiveBackForceAndPlace) {
  Truth arm = test::braced_arm();
  SequenceSpec spec;
  spec.timed = true;
  std::vector<Eigen::VectorXd> right;
  for (int k = 0; k < 8; ++k) {
    arm.moments = {2.2e-3 + 1e-4 * k};
    const support::BvpSolution solution = arm.solve();
    right.push_back(test::parameters(arm, solution));
    spec.frames.push_back(frame_of(0.1 * k + (k % 2 == 0 ? 0.02 : 0.0), test::exact_points(arm, solution, 20),
                                   arm.length(), arm.moments));
  }
  const SequenceEstimate result = estimate_sequence(scene_of(arm, 0.0, 1), spec);
  EXPECT_EQ(result.status, EstimateStatus::solved) << result.message;
  ASSERT_EQ(result.frames.size(), right.size());
  for (std::size_t k = 0; k < right.size(); ++k) {
    ASSERT_EQ(result.frames[k].contacts.size(), 1U);
    for (const EstimatedContact& c : {result.frames[k].contacts[0].all, result.frames[k].contacts[0].so_far}) {
      EXPECT_NEAR(c.force, right[k][0], 1e-6 * right[k][0]);
      EXPECT_NEAR(c.arc_length, right[k][1], 1e-6 * right[k][1]);
    }
    EXPECT_EQ(result.frames[k].contacts[0].number, 1);
  }
  EXPECT_LE(result.residual_rms, 1e-9 * arm.length());
}

/// Many random walks of the braced arm's contact, followed with the rates that they have.
struct Walks {
  static constexpr int runs = 60;
  static constexpr int frames = 16;
  static constexpr double noise = 5e-5, force_rate = 5e-4, place_rate = 1.5e-4;
  struct Errors {
    double square = 0.0, bound = 0.0, reported = 0.0;
    int within_1 = 0, within_2 = 0, count = 0;
    void add(double off, double error, double variance_bound) {
      square += off * off;
      bound += variance_bound;
      reported += error * error;
      within_1 += std::abs(off) <= error ? 1 : 0;
      within_2 += std::abs(off) <= 1.959963984540054 * error ? 1 : 0;
      ++count;
    }
    double ratio() const { return std::sqrt(square / bound); }
  };
  Errors so_far[2], last[2], middle[2], alone[2];  ///< of force and place
  int solves = 0, changed = 0;                     ///< sequences with another contact than the one

  Walks() {
    const Truth arm = test::braced_arm();
    const Scene scene = scene_of(arm, noise, 1);
    Simulator simulator(arm);
    for (int run = 0; run < runs; ++run) follow(scene, simulator, static_cast<std::uint64_t>(run + 1));
  }

  void follow(const Scene& scene, Simulator& simulator, std::uint64_t seed) {
    test::NormalNumbers normal(seed);
    SequenceSpec spec;
    spec.force_rate = force_rate;
    spec.place_rate = place_rate;
    std::vector<Eigen::VectorXd> right;
    std::vector<Eigen::MatrixXd> information;
    Eigen::VectorXd x = Eigen::Vector2d(0.06, 0.058);
    for (int k = 0; k < frames; ++k) {
      if (k > 0) x += Eigen::Vector2d(force_rate * normal(), place_rate * normal());
      right.push_back(x);
      Eigen::VectorXd points = simulator.points(x);
      for (double& v : points) v += noise * normal();
      spec.frames.push_back(frame_of(k, points, 0.1, {}));
      information.push_back(simulator.information(x, noise));
    }
    const SequenceEstimate result = estimate_sequence(scene, spec);
    ASSERT_EQ(result.frames.size(), right.size());
    solves += result.solves;
    judge(result, right, information);
  }

  /// The bound is the recursion of Fisher's information (Tichavsky, Muravchik and Nehorai 1998), the joint one for the
  /// smoother.
  void judge(const SequenceEstimate& result, const std::vector<Eigen::VectorXd>& right,
             const std::vector<Eigen::MatrixXd>& information) {
    const bool one = std::all_of(result.frames.begin(), result.frames.end(), [](const EstimatedFrame& frame) {
      return frame.contacts.size() == 1 && frame.contacts[0].number == 1;
    });
    if (!one) ++changed;
    if (!one) return;
    const Eigen::Matrix2d walk = Eigen::Vector2d(force_rate * force_rate, place_rate * place_rate).asDiagonal();
    Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(2 * frames, 2 * frames);
    Eigen::Matrix2d bound = Eigen::Matrix2d::Zero();
    for (int k = 0; k < frames; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Eigen::Matrix2d known = k == 0 ? Eigen::Matrix2d::Zero() : Eigen::Matrix2d((bound + walk).inverse());
      bound = (known + information[i]).inverse();
      joint.block<2, 2>(2 * k, 2 * k) += information[i];
      if (k > 0) {
        Eigen::MatrixXd step(2, 4);
        step << -Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity();
        joint.block<4, 4>(2 * k - 2, 2 * k - 2) += step.transpose() * walk.inverse() * step;
      }
      const EstimatedContact& c = result.frames[i].contacts[0].so_far;
      const Eigen::Vector2d off = Eigen::Vector2d(c.force, c.arc_length) - right[i];
      const double errors[] = {c.force_error, c.arc_length_error};
      for (int part = 0; part < 2; ++part) {
        so_far[part].add(off[part], errors[part], bound(part, part));
        if (k + 1 == frames) last[part].add(off[part], errors[part], bound(part, part));
        if (k == 0) alone[part].add(off[part], errors[part], bound(part, part));
      }
    }
    const Eigen::MatrixXd smoothed = joint.inverse();
    constexpr int half = frames / 2;
    const EstimatedContact& c = result.frames[half].contacts[0].all;
    middle[0].add(c.force - right[half][0], c.force_error, smoothed(2 * half, 2 * half));
    middle[1].add(c.arc_length - right[half][1], c.arc_length_error, smoothed(2 * half + 1, 2 * half + 1));
  }
};

const Walks& walks() {
  static const Walks all;
  return all;
}

// 960 frames, neighbours correlated: the ratio of root mean squares scatters by about 4 % about 1.
TEST(Sequence, ErrorsAreThoseOfTheRecursiveBound) {
  // One sequence in a hundred may take noise for a change.
  EXPECT_LE(walks().changed, 2);
  for (const Walks::Errors& e : walks().so_far) EXPECT_NEAR(e.ratio(), 1.0, 0.1);
  // What is reported is the bound at the estimate instead of at the truth.
  for (const auto& group : {walks().so_far, walks().middle}) {
    for (int part = 0; part < 2; ++part) EXPECT_NEAR(std::sqrt(group[part].reported / group[part].bound), 1.0, 0.02);
  }
}

// One frame of each of 60 independent sequences: within three standard deviations of the binomial distribution.
TEST(Sequence, TruthsLieWithinErrorsAsOftenAsTheySay) {
  const auto expect_share = [](int hits, int count, double share) {
    EXPECT_NEAR(hits, share * count, 3.0 * std::sqrt(share * (1.0 - share) * count));
  };
  for (const auto& group : {walks().last, walks().middle}) {
    for (int part = 0; part < 2; ++part) {
      expect_share(group[part].within_1, group[part].count, 0.6827);
      expect_share(group[part].within_2, group[part].count, 0.95);
    }
  }
}

// The first frame stands alone: no later one may be as uncertain, and the smoother knows more than the filter.
TEST(Sequence, FramesTogetherSayMoreThanEachAlone) {
  for (int part = 0; part < 2; ++part) {
    EXPECT_LT(std::sqrt(walks().last[part].reported), 0.8 * std::sqrt(walks().alone[part].reported));
    EXPECT_LT(walks().last[part].square, walks().alone[part].square);
    EXPECT_LT(walks().middle[part].reported, 0.9 * walks().last[part].reported);
  }
}

// Each frame begins where the one before ends: three to four equilibria. The first one is looked for.
TEST(Sequence, AFrameTakesFewEquilibria) { EXPECT_LE(walks().solves, Walks::runs * (60 + 5 * Walks::frames)); }

/// A force that rises, stays, and falls to nothing, while another one comes and goes beyond it.
TEST(Sequence, ContactsAreMadeAndBroken) {
  const Truth arm = test::braced_arm();
  constexpr double noise = 2e-5;
  constexpr int count = 40;
  Simulator simulator(arm);
  test::NormalNumbers normal(3);
  SequenceSpec spec;
  spec.timed = true;
  std::vector<Eigen::VectorXd> right;
  for (int k = 0; k < count; ++k) {
    std::vector<double> state;
    if (k >= 5 && k < 35) {
      const double force = k < 15 ? 0.005 * (k - 4) : k < 25 ? 0.055 : 0.055 - 0.005 * (k - 24);
      state = {force, 0.05 + 2e-4 * k};
    }
    if (k >= 18 && k < 30) state.insert(state.end(), {-0.02, 0.085});
    right.emplace_back(Eigen::Map<const Eigen::VectorXd>(state.data(), static_cast<Eigen::Index>(state.size())));
    Eigen::VectorXd points = simulator.points(right.back());
    for (double& v : points) v += noise * normal();
    spec.frames.push_back(frame_of(0.02 * k, points, 0.1, {}));
  }
  for (const bool known : {true, false}) {
    const SequenceEstimate result = estimate_sequence(scene_of(arm, known ? noise : 0.0, 2), spec);
    EXPECT_EQ(result.status, EstimateStatus::solved) << result.message;
    ASSERT_EQ(result.frames.size(), right.size());
    EXPECT_NEAR(result.noise, noise, 0.05 * noise);
    int differ = 0;
    int far = 0;
    int largest = 0;
    for (std::size_t k = 0; k < right.size(); ++k) {
      const EstimatedFrame& frame = result.frames[k];
      if (2 * frame.contacts.size() != static_cast<std::size_t>(right[k].size())) {
        ++differ;
        continue;
      }
      for (std::size_t c = 0; c < frame.contacts.size(); ++c) {
        const auto i = 2 * static_cast<Eigen::Index>(c);
        const EstimatedContact& told = frame.contacts[c].all;
        if (std::abs(told.force - std::abs(right[k][i])) > 3.0 * told.force_error) ++far;
        if (std::abs(told.arc_length - right[k][i + 1]) > 3.0 * told.arc_length_error) ++far;
        largest = std::max(largest, frame.contacts[c].number);
      }
    }
    // Where the force is a few standard deviations only, a frame or two may say either.
    EXPECT_LE(differ, 3);
    EXPECT_LE(far, 6);
    EXPECT_EQ(largest, 2);
    EXPECT_TRUE(result.frames[18].made == std::vector<int>{2});
    EXPECT_TRUE(result.frames[30].broken == std::vector<int>{2});
  }
}

TEST(Sequence, WhatCannotBeFollowedIsRefused) {
  const Truth arm = test::braced_arm();
  const Eigen::VectorXd points = test::exact_points(arm, arm.solve(), 20);
  const auto refusal = [&](const Scene& scene, const SequenceSpec& spec) {
    try {
      estimate_sequence(scene, spec);
    } catch (const SceneError& error) {
      return error.path() + ": " + error.what();
    }
    return std::string("nothing");
  };
  const Scene scene = scene_of(arm, 1e-5, 1);
  SequenceSpec spec;
  EXPECT_TRUE(contains_text(refusal(scene, spec), "no frame"));
  spec.frames = {frame_of(2.0, points, 0.1, {}), frame_of(1.0, points, 0.1, {})};
  EXPECT_TRUE(contains_text(refusal(scene, spec), "frame 1 follows frame 2"));
  spec.timed = true;
  spec.frames[1].time = 2.0;
  EXPECT_TRUE(contains_text(refusal(scene, spec), "time 2 s follows time 2 s"));
  spec.frames[1].time = 3.0;
  spec.frames[1].moments = {1.0, 2.0};
  EXPECT_TRUE(contains_text(refusal(scene, spec), "time 3 s: found 2 moments"));
  spec.frames[1].moments.clear();
  spec.frames[1].points.clear();
  EXPECT_TRUE(contains_text(refusal(scene, spec), "time 3 s: there are no measured points"));
  spec.frames.pop_back();
  spec.place_rate = 0.0;
  EXPECT_TRUE(contains_text(refusal(scene, spec), "measurement.place_rate"));
}

// What pushes off its normal looks like another force at another place; the range under friction holds the right ones.
TEST(Sequence, UnderFrictionTheRangeHoldsTheTruth) {
  const Truth arm = test::braced_arm();
  constexpr double coefficient = 0.3;
  Simulator simulator(arm);
  SequenceSpec spec;
  std::vector<NormalForce> right;
  for (int k = 0; k < 6; ++k) {
    // It slips one way, turns, and slips the other way.
    right.push_back({0.06 + 1e-3 * k, 0.058, coefficient * (0.9 - 0.36 * k)});
    spec.frames.push_back(frame_of(k, simulator.points({right.back()}), 0.1, {}));
  }
  Scene rough = scene_of(arm, 2e-5, 1);
  rough.contact.friction = coefficient;
  const SequenceEstimate result = estimate_sequence(rough, spec);
  EXPECT_TRUE(contains_text(result.assumed, "friction of up to 0.3")) << result.assumed;
  ASSERT_EQ(result.frames.size(), right.size());
  const auto holds = [](Interval range, double value, double rounding) {
    EXPECT_LE(range.low, value + rounding);
    EXPECT_GE(range.high, value - rounding);
    EXPECT_LT(range.low, range.high);
  };
  int misled = 0;
  for (std::size_t k = 0; k < right.size(); ++k) {
    ASSERT_EQ(result.frames[k].contacts.size(), 1U);
    const EstimatedContact& c = result.frames[k].contacts[0].all;
    ASSERT_TRUE(c.friction);
    EXPECT_TRUE(c.friction->whole);
    // A state between two that were fitted is off by the curvature of what is in between.
    holds(c.friction->ratio, right[k].lean, 0.0);
    holds(c.friction->force, right[k].force, 1e-3 * right[k].force);
    holds(c.friction->arc_length, right[k].arc_length, 1e-5);
    if (std::abs(c.force - right[k].force) > 3.0 * c.force_error) ++misled;
  }
  // Without the range the numbers would be believed.
  EXPECT_GE(misled, 3);
}

}  // namespace
}  // namespace tendril
