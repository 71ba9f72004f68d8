#pragma once

#include <span>
#include <string>

#include "estimate/estimate_fit.hpp"
#include "rod/rod.hpp"

namespace tendril {

/// What about points does not go with the rod and its moments, in words that follow "; ", for a fit that explains
/// little. Empty: nothing catches the eye.
std::string misfit_hint(const Rod& rod, const MeasuredShape& measured, std::span<const double> moments,
                        bool equal_spacing, double length);

}  // namespace tendril
