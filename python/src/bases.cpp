#include <pybind11/numpy.h>

#include <cmath>

#include "components.hpp"
#include "kept.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

/// Functions of Python's, or plain values, for what a basis says of itself.
struct Basis {
  py::object evaluate, functions, breaks, subdivision, names;
  py::dict options;

  py::object told(const py::object& value) const {
    return PyCallable_Check(value.ptr()) != 0 ? py::object(value(**options)) : value;
  }
};

class PythonCoordinates final : public CoordinateModel {
 public:
  explicit PythonCoordinates(Kept<Basis> basis) : basis_(std::move(basis)) {
    in_python([&] {
      functions_ = whole(basis_->told(basis_->functions));
      breaks_ = list(basis_->breaks, "breaks");
      subdivision_ = list(basis_->subdivision, "subdivision");
      for (const py::handle& name : basis_->told(basis_->names)) names_.push_back(py::str(name));
    });
  }

  int function_count() const override { return functions_; }
  std::vector<double> breaks() const override { return breaks_; }
  std::vector<double> subdivision() const override { return subdivision_; }
  std::string coordinate_name(int i) const override {
    const auto at = static_cast<std::size_t>(i);
    return at < names_.size() ? names_[at] : CoordinateModel::coordinate_name(i);
  }

  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    in_python([&] {
      const py::array_t<double> points(static_cast<py::ssize_t>(sigma.size()), sigma.data());
      const py::object given = basis_->evaluate(points, **basis_->options);
      const bool triple = py::isinstance<py::tuple>(given) || py::isinstance<py::list>(given);
      if (!triple || py::len(given) != 3) refuse("the basis", given, "three arrays: values, first, second derivatives");
      const auto parts = py::reinterpret_borrow<py::sequence>(given);
      take(parts[0], "the values", value);
      take(parts[1], "the first derivatives", first);
      take(parts[2], "the second derivatives", second);
    });
  }

 private:
  std::vector<double> list(const py::object& value, const char* what) const {
    std::vector<double> entries;
    const py::object told = basis_->told(value);
    if (!py::isinstance<py::iterable>(told)) refuse(what, told, "a list of numbers");
    for (const py::handle& entry : told) entries.push_back(number(entry, what));
    return entries;
  }

  static int whole(const py::object& value) {
    constexpr double most = 1e6;  // far more than any rod is made of
    const double found = number(value, "functions");
    if (!(std::abs(found) <= most) || found != std::round(found)) refuse("functions", value, "a whole number");
    return static_cast<int>(found);
  }

  static void take(const py::object& from, const char* what, Eigen::Ref<Eigen::MatrixXd> to) {
    const auto array = numbers(from, static_cast<std::size_t>(to.rows()), static_cast<std::size_t>(to.cols()), what);
    const auto entry = array.unchecked<2>();
    for (Eigen::Index i = 0; i < to.rows(); ++i) {
      for (Eigen::Index k = 0; k < to.cols(); ++k) to(i, k) = entry(i, k);
    }
  }

  Kept<Basis> basis_;
  int functions_ = 0;
  std::vector<double> breaks_, subdivision_;
  std::vector<std::string> names_;
};

PythonComponent coordinates(const std::string& name, const std::string& description, const py::object& function,
                            const py::object& functions, const py::object& breaks, const py::object& subdivision,
                            const py::object& names, const std::vector<OptionTuple>& options) {
  const Kept<Basis> kept({function, functions, breaks, subdivision, names, {}});
  return component_of<CoordinateModel>(name, description, options, [kept](const py::dict& given) {
    Basis basis = *kept;
    basis.options = given;
    return std::make_unique<PythonCoordinates>(Kept<Basis>(std::move(basis)));
  });
}

}  // namespace

void add_bases(py::module_& module) { module.def("coordinates", &coordinates); }

}  // namespace tendril::python
