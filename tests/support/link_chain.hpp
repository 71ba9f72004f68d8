#pragma once

#include <functional>
#include <vector>

#include "support/rod_bvp.hpp"

/// A rod as rigid links with torsion springs: a coarse third method with an error of O(1/links^2) of its own, that
/// finds stable equilibria by minimizing the energy and needs no idea of where the contact is.
namespace tendril::support {

/// A given dead force on the rod.
struct PointForce {
  double arc_length = 0.0;
  Point force{};
};

struct LinkChainOptions {
  int links = 400;
  double curvature = 0.0;               ///< of the arc to start from, used if `angle` is empty
  std::function<double(double)> angle;  ///< absolute backbone angle to start from
  std::vector<PointForce> forces;       ///< besides the rod's own tip force
};

/// Force of one obstacle on the rod: the sum over the joints that it touches.
struct ChainContact {
  double force = 0.0;       ///< size of the summed force
  Point direction{};        ///< its direction; zero if not touched
  double arc_length = 0.0;  ///< mean over the joints, weighted with their forces; good to one link
  int joints = 0;           ///< touched
};

struct LinkChainSolution {
  double tip_x = 0.0;
  double tip_y = 0.0;
  double tip_angle = 0.0;
  std::vector<double> angles;          ///< per link: the backbone angle at the link's middle
  std::vector<Point> joints;           ///< links + 1 points, base first
  std::vector<ChainContact> contacts;  ///< one per obstacle
  double gradient = 0.0;               ///< largest unbalanced joint moment
  double penetration = 0.0;            ///< deepest joint
};

/// The stable equilibrium near the start, among obstacles that the joints (the tip included) may touch without
/// friction. `BvpContact::at_tip` is ignored. Throws BvpError if the minimization does not converge.
LinkChainSolution settle(const RodBvp& rod, const std::vector<double>& moments,
                         const std::vector<BvpContact>& obstacles = {}, const LinkChainOptions& options = {});

/// Stability margin of a contact-free equilibrium: smallest eigenvalue of the energy's Hessian against the Hessian of
/// the bending energy. 1 without loads, 0 at buckling and folds.
double stability_margin(const RodBvp& rod, const std::vector<double>& moments, const LinkChainSolution& at);

}  // namespace tendril::support
