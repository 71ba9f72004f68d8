#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "obstacle/circle.hpp"
#include "obstacle/wall.hpp"
#include "program/grasp_program.hpp"
#include "program/pose_program.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"

/// Programs with all that a program can have: for tests of what every program must do.
namespace tendril::support {

/// A term that reads all of what it is asked to, nonlinearly, in both forms.
class Everything : public ObjectiveBase<Everything> {
 public:
  struct Parts {
    bool contacts = true;
    bool palm = false;
    bool target = false;
    bool tendons = false;
    bool insertion = false;
    bool deviations = false;
    std::vector<double> samples{};  ///< arc lengths
  };
  explicit Everything(Parts parts) : parts_(std::move(parts)) {}
  Reads reads() const override;
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.residual(x.tip.x * x.tip.y - 0.3);
    out.residual(sin(x.tip.angle) + x.bending_energy * 0.2);
    out.smooth(0.7 * x.tip.y);
    if (parts_.palm) out.smooth(exp(x.palm_distance) * x.tip.y);
    if (parts_.insertion) out.residual(x.insertion * x.insertion * x.tip.y);
    if (parts_.target) out.residual(x.tip.x - x.target.position.x);
    for (const T& u : x.moments) out.smooth(exp(0.3 * u) * x.tip.x);
    for (const T& tension : x.tensions) out.residual(0.2 * tension * x.tip.y);
    for (const T& shortening : x.shortenings) out.smooth(exp(0.4 * shortening) * x.tip.angle);
    for (const TipDeviation<T>& one : x.tip_deviations) {
      out.residual(one.x - 0.1 * one.y);
      out.smooth(exp(0.3 * one.x) * (one.y + x.tip.x));
    }
    for (const BackboneQuantities<T>& b : x.samples) {
      out.residual(b.x * b.angle);
      out.smooth(b.y * b.curvature + 0.1 * b.curvature * b.curvature * b.curvature);
      out.smooth(b.x * b.strain + 0.3 * b.strain * b.strain * b.strain);
    }
    for (const ContactQuantities<T>& c : x.contacts) {
      out.residual((c.x - c.reference_x) * c.force + c.normal_x * c.normal_y);
      out.smooth(c.gap * c.gap * c.gap + c.arc_length * c.force * c.normal_y + c.y * c.arc_length * c.arc_length);
    }
  }

 private:
  Parts parts_;
};

/// One rod among two obstacles, of two segments, three actuators and with every load. Its contacts, beside one at the
/// tip if there is one, are in its second stretch: in one piece, where it is not split.
struct SamplePose {
  struct Setup {
    std::shared_ptr<CoordinateModel> model;
    bool split = true;
    bool tip_contact = false;
    int interior_contacts = 0;
    std::string shapes = "circles";  ///< of obstacles: "circles", "walls" or "hulls"
    bool palm = false;               ///< the base moves against one more obstacle
    std::string rod = "uniform";     ///< "uniform" by segments, "tapered", "loaded", "thick", or "varied": all of these
    bool profiles = false;           ///< moments of actuators vary along the rod
    bool stretches = false;          ///< the rod stretches, and actuators pull along it
    bool moves = false;              ///< the base is shifted and turned, and the rod drawn in
    bool uncertain = false;          ///< numbers of every kind have error bars
  };
  explicit SamplePose(const Setup& setup);
  SamplePose(const SamplePose&) = delete;
  SamplePose& operator=(const SamplePose&) = delete;

  std::shared_ptr<CoordinateModel> model;
  Rod rod;
  std::unique_ptr<Obstacle> upper, lower, carried;
  std::unique_ptr<Everything> everything;
  PoseProgramSpec spec;
};

/// Two fingers that hold a circle, with different sizes, stiffnesses, loads and units, and with rows that keep them
/// apart.
struct SampleGrasp {
  struct Setup {
    bool upper_at_tip = false, lower_at_tip = false, free_palm = true;
  };
  explicit SampleGrasp(const Setup& setup);
  SampleGrasp(const SampleGrasp&) = delete;
  SampleGrasp& operator=(const SampleGrasp&) = delete;

  LegendreBasis fine{5, 1}, coarse{3, 2};
  Everything everything{{.palm = true, .samples = {0.23}}};
  Wall palm{Vec2{}, Vec2{1.0, 0.0}};
  std::array<Rod, 2> rods;
  std::array<std::unique_ptr<Circle>, 2> objects;
  GraspProgramSpec spec;
};

}  // namespace tendril::support
