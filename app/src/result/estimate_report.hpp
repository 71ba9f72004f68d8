#pragma once

#include <string>

#include "tendril/app/result.hpp"
#include "tendril/estimate.hpp"

namespace tendril::app {

/// One JSON document, schema 1, SI units. Force, arc length, point and normal of a contact that is not identifiable are
/// null; its errors stay, since they say why.
std::string estimate_json(const Scene& scene, const Estimate& estimate, const RunInfo& run);

/// A table for people.
std::string estimate_report(const Scene& scene, const Estimate& estimate);

}  // namespace tendril::app
