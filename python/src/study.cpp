#include "study.hpp"

#include <pybind11/stl.h>

#include "interrupt.hpp"
#include "source.hpp"
#include "tendril/files/study_file.hpp"

namespace py = pybind11;

namespace tendril::python {

void add_study(py::module_& module) {
  using files::Study;
  using files::StudyCases;
  py::class_<StudyCases>(module, "StudyCases")
      .def(py::init([](const SceneTuple& scene) { return std::make_unique<StudyCases>(source_of(scene)); }))
      .def("answer", [](StudyCases& cases, int index) {
        return interruptible([&](const auto& stop) { return cases.answer(index, &stop); });
      });
  py::class_<Study>(module, "Study")
      .def(py::init([](const SceneTuple& scene, const std::optional<std::string>& output,
                       const std::optional<std::string>& figure, const std::optional<std::string>& movie,
                       const std::string& shard, bool merge) {
        const files::StudyPlaces places{output, figure, movie, shard, merge};
        return interruptible([&](const auto&) { return std::make_unique<Study>(source_of(scene), places); });
      }))
      .def_property_readonly("warnings", &Study::warnings)
      .def_property_readonly("waiting", &Study::waiting)
      .def_property_readonly("finished", &Study::finished)
      .def_property_readonly("one_shard", &Study::one_shard)
      .def("take", &Study::take)
      .def("lost", &Study::lost)
      .def("finish", [](Study& study) {
        const Study::Finished finished = interruptible([&](const auto& stop) { return study.finish(&stop); });
        return py::make_tuple(finished.json, finished.notes);
      });
}

}  // namespace tendril::python
