#pragma once

#include <vector>

#include "calibrate/fit.hpp"
#include "problem/calibrate_input.hpp"
#include "tendril/calibrate.hpp"

namespace tendril {

/// The numbers found, their errors, and what is not determined.
void report_numbers(const CalibrationInput& in, const CalibrationFit& fit, const CalibrationFit::Result& result,
                    Calibration& out);
/// Shapes beside what was measured; those that are only checked are predicted.
void report_shapes(const CalibrationInput& in, const Scene& scene, const CalibrationSpec& spec, CalibrationFit& fit,
                   const FittedPoint& point, Calibration& out);
/// Errors of shapes that were left out of a fit to `others`.
void report_predictions(const CalibrationInput& in, const FittedPoint& predicted, const std::vector<int>& left_out,
                        const std::vector<int>& others, Calibration& out);
/// Errors of tips over all recordings.
void summarize(const CalibrationSpec& spec, Calibration& out);

}  // namespace tendril
