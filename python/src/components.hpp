#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kept.hpp"
#include "options.hpp"
#include "tendril/registrar.hpp"

namespace tendril::python {

/// A component that is written in Python: hands itself to a registrar.
struct PythonComponent {
  std::function<void(Registrar&)> provide;
};

/// The component of an interface that `make` makes of options by name, with Python's lock.
template <class Interface, class Make>
PythonComponent component_of(const std::string& name, const std::string& description,
                             const std::vector<OptionTuple>& options, Make make) {
  Component<Interface> component{
      name, description, schema_of(options), [make](const Options& given) {
        return in_python([&]() -> std::unique_ptr<Interface> { return make(options_of(given)); });
      }};
  return {[component](Registrar& registrar) { registrar.add(component); }};
}

/// All of them, as a scene's source takes them.
std::function<void(Registrar&)> together(const std::vector<PythonComponent>& components);

/// Each adds what makes a component of Python's functions and classes.
void add_terms(pybind11::module_& module);
void add_bases(pybind11::module_& module);
void add_obstacles(pybind11::module_& module);
/// All of these, and the checks of the test kit.
void add_components(pybind11::module_& module);

}  // namespace tendril::python
