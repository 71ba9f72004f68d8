#include "certificate/check_points.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

namespace tendril {

namespace {

/// The deepest valleys, in their order: those of a rod that winds through an obstacle many times are too many for rows,
/// and where the deepest ones are gone it is another shape.
void keep_deepest(std::vector<Certifier::Approach>& valleys) {
  if (valleys.size() <= most_new_checks) return;
  std::vector<double> depths;
  for (const Certifier::Approach& v : valleys) depths.push_back(v.at.distance);
  const auto last = depths.begin() + most_new_checks - 1;
  std::nth_element(depths.begin(), last, depths.end());
  std::size_t kept = 0;
  for (const Certifier::Approach& v : valleys) {
    if (kept < most_new_checks && v.at.distance <= *last) valleys[kept++] = v;
  }
  valleys.resize(kept);
}

}  // namespace

bool exchange_checks(const PoseProgram& program, ConstVectorRef x, Certifier& certifier,
                     std::vector<CheckPoint>& checks, double level, bool keep) {
  const Chain& chain = program.chain();
  const PoseProgram::Layout& at = program.layout();
  const std::span<const double> knots = program.knots(x);
  bool changed = false;
  std::vector<bool> moved(checks.size(), false);
  std::vector<Certifier::Approach> valleys = certifier.approaches(x, level);
  keep_deepest(valleys);
  for (const Certifier::Approach& valley : valleys) {
    const double s = valley.at.arc_length;
    bool own_contact = false;
    for (int k = 0; k < at.forces; ++k) {
      const ContactSetup& c = program.spec().contacts[static_cast<std::size_t>(k)];
      if (c.obstacle != valley.obstacle || program.branch(k) != Branch::touching) continue;
      const double contact = c.at_tip ? 1.0 : x[at.first_arc_length + k];
      own_contact = own_contact || std::abs(contact - s) < contact_neighbourhood;
    }
    if (own_contact) continue;
    CheckPoint wanted{valley.at.piece, valley.at.sigma, valley.obstacle};
    if (wanted.sigma < 1e-6) {
      // The start of a piece is the end of the one before; the base itself cannot move.
      if (wanted.piece == 0) continue;
      wanted = {wanted.piece - 1, 1.0, wanted.obstacle};
    }
    // The nearest check point of the same valley moves: between it and the valley's floor the distance does not rise
    // above what it is at the check point. A neighbourhood of a tenth of the rod stands for that.
    int nearest = -1;
    double best = 0.1;
    for (std::size_t i = 0; i < checks.size(); ++i) {
      if (keep || checks[i].obstacle != valley.obstacle || (i < moved.size() && moved[i])) continue;
      const double own = chain.start(checks[i].piece, knots) + checks[i].sigma * chain.length(checks[i].piece, knots);
      if (std::abs(own - s) >= best) continue;
      best = std::abs(own - s);
      nearest = static_cast<int>(i);
    }
    if (nearest >= 0) {
      checks[static_cast<std::size_t>(nearest)] = wanted;
      moved[static_cast<std::size_t>(nearest)] = true;
    } else {
      checks.push_back(wanted);
      moved.push_back(true);
    }
    changed = true;
  }
  return changed;
}

void keep_unique(std::vector<CheckPoint>& checks) {
  const auto key = [](const CheckPoint& c) { return std::tuple(c.obstacle, c.piece, c.sigma); };
  std::sort(checks.begin(), checks.end(), [&](const CheckPoint& a, const CheckPoint& b) { return key(a) < key(b); });
  checks.erase(std::unique(checks.begin(), checks.end(),
                           [&](const CheckPoint& a, const CheckPoint& b) { return key(a) == key(b); }),
               checks.end());
}

}  // namespace tendril
