#pragma once

#include <string>

#include "tendril/app/result.hpp"
#include "tendril/estimate_sequence.hpp"

namespace tendril::app {

/// One JSON document, schema 1, SI units: every frame, and what a single shape would have of the last one.
std::string sequence_json(const Scene& scene, const SequenceSpec& spec, const SequenceEstimate& estimate,
                          const RunInfo& run);

/// Tables for people: of contacts, and of frames.
std::string sequence_report(const Scene& scene, const SequenceEstimate& estimate);

}  // namespace tendril::app
