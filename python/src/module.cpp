#include <dlfcn.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <filesystem>
#include <utility>

#include "components.hpp"
#include "interrupt.hpp"
#include "problem.hpp"
#include "source.hpp"
#include "study.hpp"
#include "tendril/error.hpp"
#include "tendril/files/estimate_file.hpp"
#include "tendril/version.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

using files::SceneFile;

std::string plan(SceneFile& scene, const std::optional<std::string>& start, bool verified, const py::object& progress) {
  return reporting(progress, [&](const auto& stop, const auto& report) {
    return scene.json(scene.plan({&stop, result_of(start, "start"), report}, verified));
  });
}

std::string plan_trajectory(SceneFile& scene, bool verified, const py::object& progress) {
  return reporting(progress, [&](const auto& stop, const auto& report) {
    return scene.json(scene.plan_trajectory({&stop, std::nullopt, report}, verified));
  });
}

std::string estimate(const SceneTuple& scene) {
  return interruptible([&](const auto& stop) { return files::estimate_json(source_of(scene), {&stop}); });
}

std::string sensitivity(SceneFile& scene, const std::vector<std::string>& keys, bool held, const std::string& moments,
                        const std::optional<std::string>& plan) {
  return interruptible([&](const auto& stop) {
    const files::Inputs given{files::InputKind::moments, moments, "moments"};
    return scene.sensitivity_json({keys, given, held, result_of(plan, "plan")}, {&stop});
  });
}

/// Its JSON, and why there is no figure.
std::pair<std::string, std::vector<std::string>> calibrate(SceneFile& scene, const std::optional<std::string>& output,
                                                           const std::optional<std::string>& figure) {
  return interruptible([&](const auto& stop) {
    const files::CalibrationPlaces places{output, figure};
    const Calibration calibration = scene.calibrate({&stop}, places);
    return std::pair(scene.json(calibration), scene.write(calibration, places));
  });
}

std::vector<std::string> view(const std::string& result, const std::string& file,
                              const std::vector<PythonComponent>& components) {
  return interruptible([&](const auto& stop) { return files::view({result}, file, {}, together(components), &stop); });
}

void live(const SceneTuple& scene, int port, bool open_browser, const py::function& ready) {
  interruptible([&](const auto& stop) {
    const auto told = [&](const std::string& address) {
      const py::gil_scoped_acquire held;
      try {
        ready(address);
      } catch (py::error_already_set& raised) {
        raised.discard_as_unraisable("live");  // the server could not go on from there
      }
    };
    files::live(source_of(scene), {port, open_browser, &stop, told});
    return true;
  });
}

/// Whether it is a trajectory, and its JSON. `earlier`: a result whose moments are held, instead of `inputs`. `along`:
/// the inputs are way points, even if there is but one.
std::pair<bool, std::string> execute(SceneFile& scene, const std::string& kind, const std::string& inputs,
                                     const std::optional<std::string>& earlier, const std::optional<std::string>& start,
                                     bool along, const std::string& insertion, const std::string& base) {
  const auto of = kind == "moments"     ? files::InputKind::moments
                  : kind == "pressures" ? files::InputKind::pressures
                  : kind == "inputs"    ? files::InputKind::each
                                        : files::InputKind::none;
  return interruptible([&](const auto& stop) {
    const files::Inputs told{of, inputs, kind, insertion, base};
    const files::Run run{&stop, result_of(start, "start")};
    const auto path = [&](const Trajectory& trajectory) { return std::pair(true, scene.json(trajectory)); };
    const auto single = [&](const Execution& execution) { return std::pair(false, scene.json(execution)); };
    if (!earlier) return along ? path(scene.execute_along(told, run)) : single(scene.execute(told, run));
    const auto executed = scene.execute(files::ResultText{*earlier, "plan"}, run, told);
    const auto* trajectory = std::get_if<Trajectory>(&executed);
    return trajectory != nullptr ? path(*trajectory) : single(std::get<Execution>(executed));
  });
}

/// The command that belongs to the library in use: build, wheel and installation all lay it beside lib/.
std::string command_path() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&tendril::validate), &info) == 0) return "";
  const std::filesystem::path library = std::filesystem::weakly_canonical(info.dli_fname);
  return library.parent_path().parent_path() / "bin" / "tendril";
}

void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const Error& error) {
    const py::object type = py::module_::import("tendril._errors").attr("Error");
    PyErr_SetObject(type.ptr(), type(error.what()).ptr());
  }
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  py::register_exception_translator(&translate);
  module.attr("version") = TENDRIL_VERSION;
  module.def("command_path", &command_path);
  module.def("scene_text",
             [](const std::string& file, const std::string& text, const std::vector<SettingTuple>& settings) {
               return files::scene_text(source_of({file, text, settings, {}, {}}));
             });
  add_components(module);
  module.def("drawing", [](const std::string& result, const std::vector<PythonComponent>& components) {
    return files::drawing_json({result}, {}, together(components));
  });
  module.def("view", &view);
  module.def("live", &live);
  module.def("estimate", &estimate);
  py::class_<SceneFile>(module, "SceneFile")
      .def(py::init([](const SceneTuple& scene) { return SceneFile(source_of(scene)); }))
      .def_property_readonly("problem",
                             [](const SceneFile& scene) { return std::string(to_string(scene.scene().problem)); })
      .def_property_readonly("warnings", [](const SceneFile& scene) { return scene.scene().warnings; })
      .def("describe", [](SceneFile& scene) { return scene.json(scene.describe()); })
      .def("plan", &plan)
      .def("plan_trajectory", &plan_trajectory)
      .def("calibrate", &calibrate)
      .def("sensitivity", &sensitivity)
      .def("execute", &execute);
  add_problem(module);
  add_study(module);
}

}  // namespace tendril::python
