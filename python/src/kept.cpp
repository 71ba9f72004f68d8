#include "kept.hpp"

#include "tendril/error.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

/// ", at file:line" of the innermost line that was running.
std::string place_of(const py::error_already_set& raised) {
  if (!raised.trace()) return "";
  py::object step = raised.trace();
  while (!step.attr("tb_next").is_none()) step = step.attr("tb_next");
  return ", at " + py::str(step.attr("tb_frame").attr("f_code").attr("co_filename")).cast<std::string>() + ":" +
         py::str(step.attr("tb_lineno")).cast<std::string>();
}

}  // namespace

void raise_as_error(py::error_already_set& raised) {
  if (raised.matches(PyExc_KeyboardInterrupt)) {
    PyErr_SetInterrupt();  // whoever waits for the library raises it again, once it has come to its end
    throw Error("interrupted");
  }
  throw Error(py::str(raised.type().attr("__name__")).cast<std::string>() + ": " +
              py::str(raised.value()).cast<std::string>() + place_of(raised));
}

void refuse(const std::string& what, const py::handle& found, const std::string& expected) {
  throw Error(what + ": found " + py::repr(found).cast<std::string>() + ", expected " + expected);
}

double number(const py::handle& value, const std::string& what) {
  const bool other = value.is_none() || py::isinstance<py::str>(value) || py::isinstance<py::bool_>(value);
  if (other) refuse(what, value, "a number");  // a comparison has no slope
  const double found = PyFloat_AsDouble(value.ptr());
  if (found == -1.0 && PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    refuse(what, value, "a number");
  }
  return found;
}

std::pair<double, double> two_numbers(const py::handle& value, const std::string& what) {
  if (!py::isinstance<py::sequence>(value) && !py::isinstance<py::array>(value)) refuse(what, value, "two numbers");
  const auto pair = py::reinterpret_borrow<py::sequence>(value);
  if (py::isinstance<py::str>(value) || pair.size() != 2) refuse(what, value, "two numbers");
  return {number(pair[0], what), number(pair[1], what)};
}

py::array_t<double, py::array::c_style> numbers(const py::handle& value, std::size_t rows, std::size_t columns,
                                                const std::string& what) {
  const std::string expected =
      "an array of numbers of shape (" + std::to_string(rows) + ", " + std::to_string(columns) + ")";
  auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array) {
    PyErr_Clear();
    refuse(what, value, expected);
  }
  const bool fits = array.ndim() == 2 && static_cast<std::size_t>(array.shape(0)) == rows &&
                    static_cast<std::size_t>(array.shape(1)) == columns;
  if (!fits) refuse(what + " of shape", py::object(array.attr("shape")), expected);
  return array;
}

}  // namespace tendril::python
