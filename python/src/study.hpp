#pragma once

#include <pybind11/pybind11.h>

namespace tendril::python {

/// Adds the classes StudyCases and Study: which cases wait, what each comes to, what is made of all.
void add_study(pybind11::module_& module);

}  // namespace tendril::python
