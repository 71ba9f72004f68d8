#include "components.hpp"

#include <pybind11/stl.h>

#include "checks.hpp"
#include "dual.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

/// Runs the test kit over a component; what is wrong, in lines.
class Checker : public Registrar {
 public:
  void add(CoordinateComponent component) override { kit::check_coordinates(*make(component), findings_); }
  void add(ObjectiveComponent component) override {
    kit::check_objective(*make(component), 2, {{0.7, 0.4}, 0.6, true, true}, findings_);
  }
  void add(ObstacleComponent component) override { kit::check_obstacle(*make(component), findings_); }
  void add(SolverComponent) override {}

  RawOptions options;
  std::string text() const { return findings_.text(); }

 private:
  template <class Interface>
  std::unique_ptr<Interface> make(const Component<Interface>& component) const {
    return component.make(resolve_options(component.options, options, Scale{}, {}, "'" + component.name + "'"));
  }
  kit::Findings findings_;
};

std::string check(const PythonComponent& component, const py::dict& options) {
  Checker checker;
  checker.options = raw_options(options);
  const py::gil_scoped_release released;
  component.provide(checker);
  return checker.text();
}

}  // namespace

std::function<void(Registrar&)> together(const std::vector<PythonComponent>& components) {
  return [components](Registrar& registrar) {
    for (const PythonComponent& component : components) component.provide(registrar);
  };
}

void add_components(py::module_& module) {
  add_dual(module);
  const py::class_<PythonComponent> type(module, "Component");
  add_terms(module);
  add_bases(module);
  add_obstacles(module);
  module.def("check", &check);
}

}  // namespace tendril::python
