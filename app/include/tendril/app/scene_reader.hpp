#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "tendril/app/document.hpp"
#include "tendril/app/study.hpp"
#include "tendril/app/units.hpp"
#include "tendril/calibrate.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

enum class KeyType {
  text,
  boolean,
  integer,
  quantity,
  point,
  texts,
  quantities,
  ends,
  points,
  targets,
  law,      ///< a number, or coefficients of a polynomial
  offsets,  ///< a length, one at either end, or a table along the rod
  table,
  tables,
  options
};

/// Everything there is to know of one key of a scene: read by the reader, by "did you mean", and by the reference page.
struct KeySpec {
  std::string name;
  KeyType type = KeyType::text;
  Dimension dimension{};
  std::string default_text{};  ///< as the reference shows it; empty: none
  std::string description{};
  double minimum = -std::numeric_limits<double>::infinity();  ///< SI
  bool minimum_excluded = false;
  std::vector<std::string> choices{};
  bool required = false;
  std::vector<KeySpec> keys{};  ///< of a table
  bool takes_options = false;   ///< a table whose other keys are options of a component
};

/// All keys of a scene, as one tree.
std::vector<KeySpec> scene_keys();

/// Reads a scene out of a document: types, units, unknown keys. Throws InputError with the place. `units` lives on
/// inside Scene::read_quantity. Whether the numbers make sense together is core's validate().
Scene read_scene(const Document& document, std::shared_ptr<const Units> units);

/// The sweeps that a scene declares in [study]. Throws InputError where read_scene() does, and if there are none.
StudySpec read_study(const Document& document, const Units& units);

/// What a scene declares in [calibrate], its files read. Columns that are not read are told in the left_out of `scene`,
/// which is that of the document. Throws InputError where read_scene() does, and if there is none.
CalibrationSpec read_calibration(const Document& document, const Units& units, Scene& scene);

}  // namespace tendril::app
