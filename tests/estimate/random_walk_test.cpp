// Filter, smoother and likeliest rates of random walks, against the joint normal distribution of all frames.

#include "estimate/random_walk.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "estimate/truth.hpp"

namespace tendril {
namespace {

/// Frames with one or two contacts: the second one comes and goes, and at last the first one is another one.
std::vector<FrameEvidence> some_frames(std::uint64_t seed) {
  const std::vector<std::vector<int>> before{{-1}, {0}, {0, -1}, {0, 1}, {0, 1}, {1}, {0}, {-1}, {0}};
  test::NormalNumbers normal(seed);
  std::vector<FrameEvidence> out;
  for (std::size_t k = 0; k < before.size(); ++k) {
    const auto n = 2 * static_cast<Eigen::Index>(before[k].size());
    Eigen::MatrixXd rates(n + 4, n);
    for (double& v : rates.reshaped()) v = normal();
    Eigen::VectorXd values(n + 4);
    for (double& v : values) v = 0.5 * normal();
    out.push_back(
        {0.5 + 0.1 * static_cast<double>(k), before[k], rates.transpose() * rates, rates.transpose() * values});
  }
  return out;
}

/// All frames as one normal distribution: information, its vector, and where each frame begins.
struct Joint {
  Eigen::MatrixXd information;
  Eigen::VectorXd weighted;
  std::vector<Eigen::Index> first;
  double log_steps = 0.0;  ///< of the densities of the steps, without what does not depend on the rates

  Joint(std::span<const FrameEvidence> frames, const WalkRates& rates) {
    Eigen::Index n = 0;
    for (const FrameEvidence& f : frames) {
      first.push_back(n);
      n += f.weighted.size();
    }
    information.setZero(n, n);
    weighted.setZero(n);
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const FrameEvidence& f = frames[k];
      information.block(first[k], first[k], f.weighted.size(), f.weighted.size()) += f.information;
      weighted.segment(first[k], f.weighted.size()) += f.weighted;
      for (std::size_t c = 0; c < f.before.size(); ++c) {
        for (Eigen::Index part = 0; f.before[c] >= 0 && part < 2; ++part) {
          const double rate = part == 0 ? rates.force : rates.place;
          const double w = 1.0 / (f.step * rate * rate);
          const Eigen::Index a = first[k - 1] + 2 * f.before[c] + part;
          const Eigen::Index b = first[k] + 2 * static_cast<Eigen::Index>(c) + part;
          information(a, a) += w;
          information(b, b) += w;
          information(a, b) -= w;
          information(b, a) -= w;
          log_steps += 0.5 * std::log(w);
        }
      }
    }
  }

  /// Logarithm of the likelihood of all points, but for what does not depend on the rates.
  double log_likelihood() const {
    const Eigen::LLT<Eigen::MatrixXd> factor(information);
    const Eigen::MatrixXd l = factor.matrixL();
    return log_steps + 0.5 * weighted.dot(factor.solve(weighted)) - l.diagonal().array().log().sum();
  }
};

TEST(RandomWalk, SmoothedStatesAreThoseOfTheJointDistribution) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<FrameEvidence> frames = some_frames(seed);
    const WalkRates rates{0.7, 0.3};
    const std::vector<ContactState> so_far = filtered(frames, rates);
    const std::vector<ContactState> all = smoothed(frames, so_far, rates);
    for (std::size_t last = 0; last < frames.size(); ++last) {
      // What frames up to one say of it is the joint distribution of these alone.
      for (const std::size_t end : {last + 1, frames.size()}) {
        const Joint joint(std::span<const FrameEvidence>(frames).first(end), rates);
        const Eigen::MatrixXd covariance = joint.information.inverse();
        const Eigen::VectorXd mean = covariance * joint.weighted;
        const Eigen::Index n = frames[last].weighted.size();
        const Eigen::Index at = joint.first[last];
        const ContactState& state = end == frames.size() ? all[last] : so_far[last];
        EXPECT_LE((state.mean - mean.segment(at, n)).norm(), 1e-10 * (1.0 + mean.norm()));
        EXPECT_LE((state.covariance - covariance.block(at, at, n, n)).norm(), 1e-10 * covariance.norm());
      }
    }
  }
}

TEST(RandomWalk, RatesThatAreFoundAreTheLikeliest) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<FrameEvidence> frames;
    // A long walk, so that the largest likelihood lies inside.
    test::NormalNumbers normal(seed);
    Eigen::Vector2d x(1.0, 0.5);
    for (int k = 0; k < 60; ++k) {
      const double step = k % 3 == 0 ? 2.0 : 1.0;
      x += std::sqrt(step) * Eigen::Vector2d(0.4 * normal(), 0.2 * normal());
      Eigen::Matrix2d information;
      information << 9.0, 4.0, 4.0, 16.0;
      const Eigen::Matrix2d root = Eigen::LLT<Eigen::Matrix2d>(information).matrixL();
      const Eigen::Vector2d noise(normal(), normal());
      frames.push_back({step, {k == 0 ? -1 : 0}, information, information * x + root * noise});
    }
    const std::optional<WalkRates> rates = likeliest_rates(frames, {}, {});
    ASSERT_TRUE(rates);
    const double best = Joint(frames, *rates).log_likelihood();
    // Up to what does not depend on the rates.
    const WalkRates others{0.3, 0.6};
    EXPECT_NEAR(log_likelihood(frames, *rates) - log_likelihood(frames, others),
                best - Joint(frames, others).log_likelihood(), 1e-9 * std::abs(best));
    // 97.5 %: half the quantile of chi-square, found to a thousandth of the rate.
    const WalkRates largest = fastest_likely(frames, *rates, false, false);
    EXPECT_GT(largest.place, rates->place);
    EXPECT_NEAR(best - Joint(frames, {largest.force, rates->place}).log_likelihood(), 1.92, 0.02);
    EXPECT_NEAR(best - Joint(frames, {rates->force, largest.place}).log_likelihood(), 1.92, 0.02);
    for (const double factor : {0.9, 1.1}) {
      EXPECT_LT(Joint(frames, {factor * rates->force, rates->place}).log_likelihood(), best);
      EXPECT_LT(Joint(frames, {rates->force, factor * rates->place}).log_likelihood(), best);
    }
    const std::optional<WalkRates> held = likeliest_rates(frames, 0.25, {});
    EXPECT_EQ(held->force, 0.25);
    EXPECT_EQ(fastest_likely(frames, *held, true, false).force, 0.25);
    EXPECT_LT(Joint(frames, {0.25, 1.1 * held->place}).log_likelihood(), Joint(frames, *held).log_likelihood());
  }
}

TEST(RandomWalk, NoContactInTwoFramesTellsNoRate) {
  std::vector<FrameEvidence> frames = some_frames(1);
  frames.resize(1);
  EXPECT_FALSE(likeliest_rates(frames, {}, {}));
}

}  // namespace
}  // namespace tendril
