#pragma once

#include "result/json_reader.hpp"

namespace tendril::app {

/// The numbers beside a frame of a drawing, as lists of {"name", "value", "unit"}: of a plan, of a state beside a snap,
/// of a case of a study.
Json plan_numbers(const Reader& plan);
Json snap_numbers(const Reader& snap, const Reader& state);
Json case_numbers(const Reader& one);

}  // namespace tendril::app
