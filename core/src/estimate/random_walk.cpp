#include "estimate/random_walk.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

/// Rates are likeliest where they change by no more than this part.
constexpr double rate_accuracy = 1e-3;
constexpr int most_rounds = 300;

Eigen::Index first_of(int contact) { return 2 * static_cast<Eigen::Index>(contact); }

/// The contacts of a frame that the one before has.
std::vector<int> staying(const FrameEvidence& frame) {
  std::vector<int> out;
  for (const int b : frame.before) {
    if (b >= 0) out.push_back(b);
  }
  return out;
}

/// Rows that pick contacts out of a state of `count`.
Eigen::MatrixXd pick(std::span<const int> contacts, Eigen::Index size) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(contacts.size()), size);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    out.block<2, 2>(first_of(static_cast<int>(i)), first_of(contacts[i])).setIdentity();
  }
  return out;
}

/// Rows that pick those contacts of a frame that the one before has.
Eigen::MatrixXd pick_staying(const FrameEvidence& frame) {
  std::vector<int> own;
  for (std::size_t k = 0; k < frame.before.size(); ++k) {
    if (frame.before[k] >= 0) own.push_back(static_cast<int>(k));
  }
  return pick(own, frame.weighted.size());
}

/// What its points alone say is likeliest.
Eigen::VectorXd alone(const FrameEvidence& frame) { return frame.information.ldlt().solve(frame.weighted); }

/// A step back from a frame to the one before it.
struct StepBack {
  Eigen::MatrixXd from;  ///< picks what stays out of the frame before
  Eigen::MatrixXd gain;
  ContactState known;  ///< what stays, as all frames tell it
};

/// What all frames say of the one before `next`: `here` says what it and those before it do, `later` what all say of
/// `next`.
StepBack smooth(const FrameEvidence& next, ContactState& here, const ContactState& later, const WalkRates& rates) {
  const std::vector<int> stay = staying(next);
  const ContactState ahead = predicted(here, stay, next.step, rates);
  const Eigen::MatrixXd own = pick_staying(next);
  StepBack out{pick(stay, here.mean.size()), {}, {own * later.mean, own * later.covariance * own.transpose()}};
  out.gain = ahead.covariance.ldlt().solve(out.from * here.covariance).transpose();
  here.mean += out.gain * (out.known.mean - ahead.mean);
  here.covariance += out.gain * (out.known.covariance - ahead.covariance) * out.gain.transpose();
  return out;
}

}  // namespace

ContactState predicted(const ContactState& last, std::span<const int> stay, double step, const WalkRates& rates) {
  const Eigen::MatrixXd picked = pick(stay, last.mean.size());
  ContactState out{picked * last.mean, picked * last.covariance * picked.transpose()};
  for (Eigen::Index i = 0; i < out.mean.size(); ++i) {
    const double rate = i % 2 == 0 ? rates.force : rates.place;
    out.covariance(i, i) += step * rate * rate;
  }
  return out;
}

namespace {

/// Kalman's filter; `likelihood`: as log_likelihood() has it.
std::vector<ContactState> filter(std::span<const FrameEvidence> frames, const WalkRates& rates, double& likelihood) {
  std::vector<ContactState> out;
  out.reserve(frames.size());
  likelihood = 0.0;
  for (const FrameEvidence& frame : frames) {
    Eigen::MatrixXd information = frame.information;
    Eigen::VectorXd weighted = frame.weighted;
    const Eigen::Index n = weighted.size();
    if (n == 0) {
      out.push_back({Eigen::VectorXd(0), Eigen::MatrixXd(0, 0)});
      continue;
    }
    if (const std::vector<int> stay = staying(frame); !stay.empty()) {
      const ContactState ahead = predicted(out.back(), stay, frame.step, rates);
      const Eigen::MatrixXd own = pick_staying(frame);
      const Eigen::LDLT<Eigen::MatrixXd> factor(ahead.covariance);
      const Eigen::VectorXd known = factor.solve(ahead.mean);
      information += own.transpose() * factor.solve(own);
      weighted += own.transpose() * known;
      likelihood -= 0.5 * (factor.vectorD().array().abs().log().sum() + ahead.mean.dot(known));
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(information);
    out.push_back({factor.solve(weighted), factor.solve(Eigen::MatrixXd::Identity(n, n))});
    likelihood -= 0.5 * (factor.vectorD().array().abs().log().sum() - weighted.dot(out.back().mean));
  }
  return out;
}

}  // namespace

std::vector<ContactState> filtered(std::span<const FrameEvidence> frames, const WalkRates& rates) {
  double likelihood = 0.0;
  return filter(frames, rates, likelihood);
}

double log_likelihood(std::span<const FrameEvidence> frames, const WalkRates& rates) {
  double likelihood = 0.0;
  filter(frames, rates, likelihood);
  return likelihood;
}

WalkRates fastest_likely(std::span<const FrameEvidence> frames, const WalkRates& likeliest, bool force_given,
                         bool place_given) {
  // Half of the quantile of chi-square with one degree of freedom, 95 %.
  const double least = log_likelihood(frames, likeliest) - 1.92;
  const auto largest = [&](double WalkRates::*rate) {
    WalkRates inside = likeliest;
    WalkRates outside = likeliest;
    const auto allowed = [&](const WalkRates& rates) { return log_likelihood(frames, rates) >= least; };
    for (int doubling = 0; doubling < 20 && allowed(outside); ++doubling) {
      inside = outside;
      outside.*rate *= 2.0;
    }
    for (int halving = 0; halving < 10; ++halving) {
      WalkRates middle = inside;
      middle.*rate = std::sqrt(inside.*rate * outside.*rate);
      (allowed(middle) ? inside : outside) = middle;
    }
    return inside.*rate;
  };
  return {force_given ? likeliest.force : largest(&WalkRates::force),
          place_given ? likeliest.place : largest(&WalkRates::place)};
}

std::vector<ContactState> smoothed(std::span<const FrameEvidence> frames, std::vector<ContactState> filtered,
                                   const WalkRates& rates) {
  for (std::size_t k = frames.size(); k-- > 1;) {
    if (!staying(frames[k]).empty()) smooth(frames[k], filtered[k - 1], filtered[k], rates);
  }
  return filtered;
}

std::optional<WalkRates> likeliest_rates(std::span<const FrameEvidence> frames, const std::optional<double>& force,
                                         const std::optional<double>& place) {
  // From the changes as they stand there, noise included: from above.
  double square[2] = {0.0, 0.0};
  int changes = 0;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const std::vector<int> stay = staying(frames[k]);
    if (stay.empty()) continue;
    const Eigen::VectorXd before = alone(frames[k - 1]);
    const Eigen::VectorXd change = pick_staying(frames[k]) * alone(frames[k]) - pick(stay, before.size()) * before;
    for (Eigen::Index i = 0; i < change.size(); ++i) square[i % 2] += change[i] * change[i] / frames[k].step;
    changes += static_cast<int>(stay.size());
  }
  if (changes == 0) return std::nullopt;
  const auto rate = [&](int i) { return std::sqrt(square[i] / changes); };
  WalkRates rates{force.value_or(rate(0)), place.value_or(rate(1))};
  for (int round = 0; round < most_rounds && !(force && place); ++round) {
    std::vector<ContactState> states = filtered(frames, rates);
    square[0] = square[1] = 0.0;
    for (std::size_t k = frames.size(); k-- > 1;) {
      if (staying(frames[k]).empty()) continue;
      ContactState& here = states[k - 1];
      const StepBack back = smooth(frames[k], here, states[k], rates);
      const Eigen::MatrixXd with_here = back.known.covariance * back.gain.transpose() * back.from.transpose();
      const Eigen::VectorXd change = back.known.mean - back.from * here.mean;
      const Eigen::MatrixXd spread = back.known.covariance + back.from * here.covariance * back.from.transpose() -
                                     with_here - with_here.transpose();
      for (Eigen::Index i = 0; i < change.size(); ++i) {
        square[i % 2] += (change[i] * change[i] + spread(i, i)) / frames[k].step;
      }
    }
    const WalkRates before = rates;
    rates = {force.value_or(rate(0)), place.value_or(rate(1))};
    if (std::abs(rates.force - before.force) <= rate_accuracy * before.force &&
        std::abs(rates.place - before.place) <= rate_accuracy * before.place) {
      break;
    }
  }
  return rates;
}

}  // namespace tendril
