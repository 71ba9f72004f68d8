#pragma once

#include <pybind11/pybind11.h>

namespace tendril::python {

/// Adds the class Problem and the state that it follows.
void add_problem(pybind11::module_& module);

}  // namespace tendril::python
