#include "options.hpp"

#include <pybind11/stl.h>

#include <array>

#include "kept.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

Dimension dimension_of(const std::string& unit, const std::string& option) {
  constexpr std::array known{dimension::none,  dimension::angle,  dimension::length,    dimension::curvature,
                             dimension::force, dimension::moment, dimension::stiffness, dimension::pressure};
  std::vector<std::string> names;
  for (const Dimension& d : known) {
    if (d.unit == unit) return d;
    names.emplace_back(d.unit);
  }
  throw py::value_error("options['" + option + "'].unit: found '" + unit +
                        "', expected one of the SI units m, rad, 1/m, N, N m, N m^2, Pa");
}

RawValue raw(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return {value.cast<bool>()};
  if (py::isinstance<py::int_>(value)) return {value.cast<std::int64_t>()};
  if (py::isinstance<py::str>(value)) return {value.cast<std::string>()};
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    RawValue::List list;
    for (const py::handle& entry : value) list.push_back(raw(entry));
    return {list};
  }
  return {number(value, "an option")};
}

}  // namespace

OptionSchema schema_of(const std::vector<OptionTuple>& options) {
  OptionSchema schema;
  for (const auto& [name, value, unit, description, least, most] : options) {
    OptionSpec spec;
    spec.name = name;
    spec.description = description;
    spec.minimum = least;
    spec.maximum = most;
    spec.dimension = dimension_of(unit, name);
    if (py::isinstance<py::bool_>(value)) {
      spec.type = OptionType::boolean;
      spec.default_value = value.cast<bool>();
    } else if (py::isinstance<py::int_>(value) && unit.empty()) {
      spec.type = OptionType::integer;
      spec.default_value = value.cast<std::int64_t>();
    } else if (py::isinstance<py::str>(value)) {
      spec.type = OptionType::text;
      spec.default_value = value.cast<std::string>();
    } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
      spec.type = OptionType::list;
      NumberTable table{1, static_cast<int>(py::len(value)), value.cast<std::vector<double>>()};
      spec.default_value = std::move(table);
    } else if (value.is_none()) {
      spec.required = true;
    } else {
      spec.default_value = number(value, "the default of '" + name + "'");
    }
    schema.push_back(std::move(spec));
  }
  return schema;
}

py::dict options_of(const Options& options) {
  py::dict given;
  for (const auto& [name, value] : options.values()) {
    py::object entry = py::none();
    if (const auto* flag = std::get_if<bool>(&value)) entry = py::bool_(*flag);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) entry = py::int_(*whole);
    if (const auto* real = std::get_if<double>(&value)) entry = py::float_(*real);
    if (const auto* text = std::get_if<std::string>(&value)) entry = py::str(*text);
    if (const auto* table = std::get_if<NumberTable>(&value)) entry = py::cast(table->values);
    given[py::str(name)] = entry;
  }
  return given;
}

RawOptions raw_options(const py::dict& options) {
  RawOptions given;
  for (const auto& [name, value] : options) given.emplace(py::str(name), raw(value));
  return given;
}

}  // namespace tendril::python
