#pragma once

#include <string>

#include "result/result_object.hpp"
#include "tendril/scene.hpp"
#include "tendril/sensitivity.hpp"

namespace tendril::app {

/// "uncertainty" of a result: standard deviations of tip, forces and places of contacts, shares of the inputs.
Json uncertainty_json(const Uncertainty& uncertainty);
/// The lines of a report.
std::string uncertainty_text(const Scene& scene, const Uncertainty& uncertainty);

/// What `tendril sensitivity` tells of one key of the scene.
struct KeySensitivity {
  std::string key, value;       ///< as the scene writes them
  std::string trouble{};        ///< why there are no derivatives; empty: there are
  std::vector<double> rates{};  ///< of the quantities by the key, SI
};
/// One JSON document, ending in a line feed.
std::string sensitivity_json(const Scene& scene, const Sensitivity& sensitivity,
                             const std::vector<KeySensitivity>& keys);
std::string sensitivity_report(const Scene& scene, const Sensitivity& sensitivity,
                               const std::vector<KeySensitivity>& keys);

}  // namespace tendril::app
