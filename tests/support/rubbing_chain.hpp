#pragma once

#include <Eigen/Core>
#include <vector>

#include "support/rod_bvp.hpp"

/// A rod as rigid links with torsion springs whose joints rub on obstacles with Coulomb friction, followed by small
/// steps of its loads: an independent second method for sticking and slipping. It knows joints that stay where they are
/// or slide, and nothing of rolling, of tangents or of a path's rates. L = EI = 1.
namespace tendril::support {

struct RoughObstacle {
  BvpContact shape{};
  double friction = 0.0;
};

class RubbingChain {
 public:
  /// `links`: their lengths, together 1; short ones where joints touch, since forces act at joints.
  RubbingChain(std::vector<double> links, double curvature, double base_angle, std::vector<RoughObstacle> obstacles);

  /// On to the next loads: a moment along the whole rod, and its weight, along -y. Steps have to be small: joints are
  /// taken to move straight. Throws BvpError where nothing is found near.
  void step(double moment, double weight);

  Point tip() const;
  struct Contact {
    double force = 0.0;       ///< normal, of all joints that touch
    double tangential = 0.0;  ///< along the rod
    double arc_length = 0.0;  ///< mean, weighted with the forces
    bool slips = false;       ///< all of them
  };
  Contact contact(std::size_t obstacle) const;

 private:
  /// What a joint that touches does.
  struct Touch {
    Eigen::Index joint = 0;
    std::size_t obstacle = 0;
    Point from{};   ///< where the joint was when the step began, or where it came down
    int slips = 0;  ///< along the turned normal, 1 or -1: that is where friction pushes; 0: it sticks
    double force = 0.0, shear = 0.0;
  };
  /// What a touching joint has slid along the turned normal in this step.
  double slid(const Touch& t, const std::vector<Point>& now) const;
  std::vector<Point> joints() const;
  void solve(double moment, double weight);
  /// The first of joints side by side that touch: a link between them is rigid, so that these stick or slip as one.
  bool leads(std::size_t touch) const;
  bool change_friction(std::size_t leader);
  /// Changes what contradicts Coulomb's law most. False: nothing does.
  bool change_touches();

  double middle(Eigen::Index i) const;
  double link(Eigen::Index i) const { return links_[static_cast<std::size_t>(i)]; }

  Eigen::Index n_;
  std::vector<double> links_, ends_;  ///< lengths, and where each link begins
  double base_angle_;
  std::vector<RoughObstacle> obstacles_;
  Eigen::VectorXd angle_;
  std::vector<Point> before_;   ///< joints when the step began
  std::vector<Touch> touches_;  ///< along each obstacle in turn
};

}  // namespace tendril::support
