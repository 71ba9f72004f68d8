#pragma once

#include <string>
#include <vector>

#include "calibrate/fit.hpp"
#include "tendril/calibrate.hpp"
#include "tendril/scale.hpp"

namespace tendril {

/// What an actuator is told, in words; its SI unit; that of a law per power of it (empty: a pure number).
std::string input_name(ActuatorKind kind);
std::string input_unit(ActuatorKind kind);
std::string law_unit(CalibrationUnknown law, ActuatorKind kind, int power);

/// A scene and its recordings made dimensionless.
struct CalibrationInput {
  /// Throws SceneError where the data make no sense, or cannot determine what is asked for.
  CalibrationInput(const Scene& scene, const CalibrationSpec& spec);

  Scale scale;
  SoughtNumbers problem;
  std::vector<CalibratedNumber> numbers;  ///< of each unknown: what is known of it beforehand
  std::vector<double> units;              ///< of each unknown, SI
  double turn = 0.0;                      ///< how far a shape may turn, for the number of nodes
  std::vector<int> fitted, checked;       ///< shapes
  std::vector<std::string> warnings;

  /// What was known of a recording, by name: inputs and loads.
  struct Known {
    std::string name, unit;
    double value = 0.0;  ///< SI
  };
  std::vector<std::vector<Known>> known;  ///< of each shape, the same names for all

 private:
  void add_shapes(const Scene& scene, const CalibrationSpec& spec);
  void add_loads(const Scene& scene, const Recording& recording, SeenShape& shape);
  void add_inputs(const Scene& scene, const CalibrationSpec& spec);
  void add_markers(const Recording& recording, SeenShape& shape);
  void require_plausible(const Recording& recording, const SeenShape& shape) const;
  void add_unknowns(const Scene& scene, const CalibrationSpec& spec);
  void add_unknown(const Scene& scene, const CalibrationSpec& spec, const CalibrationUnknownSpec& unknown, int group,
                   const std::string& whose);
  struct Subject {
    std::string name, unit;
    int index = -1;
    double size = 1.0;   ///< SI, of what is 1 without dimensions
    double known = 1.0;  ///< SI, as the scene has it
    double spread = 0.0;
  };
  Subject subject_of(const Scene& scene, const CalibrationSpec& spec, const CalibrationUnknownSpec& unknown) const;
  void require_stretch(const CalibrationUnknownSpec& unknown) const;
  void require_sensible(const CalibrationUnknownSpec& spec, const Sought& one, const CalibratedNumber& number) const;
  void require_one_known_load() const;
  void require_enough(const CalibrationSpec& spec) const;
  bool is_sought(CalibrationUnknown kind) const;
  bool is_sought(CalibrationUnknown kind, int index) const;

  std::string at_;                   ///< where in the scene the unknown stands that is being added
  double gravity_ = 0.0;             ///< m/s^2, that the rod's weights are made with
  double aside_ = 0.0;               ///< L, the largest that a point has out of the plane
  std::vector<double> input_sizes_;  ///< SI, the largest that each actuator was told
};

}  // namespace tendril
