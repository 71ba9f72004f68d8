#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <tuple>
#include <vector>

#include "tendril/options.hpp"

namespace tendril::python {

/// (name, default, unit, description, least, most)
using OptionTuple = std::tuple<std::string, pybind11::object, std::string, std::string, double, double>;

/// What a component of Python's declares. Throws what Python shows as ValueError for a unit that is none.
OptionSchema schema_of(const std::vector<OptionTuple>& options);
/// What a scene set, as arguments by name.
pybind11::dict options_of(const Options& options);
/// Arguments by name as a scene would set them.
RawOptions raw_options(const pybind11::dict& options);

}  // namespace tendril::python
