#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <vector>

#include "tendril/registrar.hpp"

namespace tendril::python {

/// A component that is written in Python: hands itself to a registrar.
struct PythonComponent {
  std::function<void(Registrar&)> provide;
};

/// All of them, as a scene's source takes them.
std::function<void(Registrar&)> together(const std::vector<PythonComponent>& components);

/// Adds what makes components of Python's functions and classes, and the checks of the test kit.
void add_components(pybind11::module_& module);

}  // namespace tendril::python
