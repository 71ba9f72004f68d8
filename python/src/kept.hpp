#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <utility>

namespace tendril::python {

/// Objects of Python kept by the library, which lets go of them wherever it likes: with Python's lock or without.
template <class T>
class Kept {
 public:
  explicit Kept(T objects) : objects_(new T(std::move(objects)), &let_go) {}
  const T* operator->() const { return objects_.get(); }
  const T& operator*() const { return *objects_; }

 private:
  static void let_go(T* objects) {
    const pybind11::gil_scoped_acquire held;
    delete objects;
  }
  std::shared_ptr<T> objects_;
};

/// Runs `call` with Python's lock. What Python raises becomes an Error that says where.
[[noreturn]] void raise_as_error(pybind11::error_already_set& raised);
template <class Call>
auto in_python(Call&& call) {
  const pybind11::gil_scoped_acquire held;
  try {
    return call();
  } catch (pybind11::error_already_set& raised) {
    raise_as_error(raised);
  }
}

/// "found None, expected ..." of something that Python gave back.
[[noreturn]] void refuse(const std::string& what, const pybind11::handle& found, const std::string& expected);
/// A number of Python's; `what` names it.
double number(const pybind11::handle& value, const std::string& what);
/// Two of them.
std::pair<double, double> two_numbers(const pybind11::handle& value, const std::string& what);
/// An array of `rows` x `columns` numbers, in rows.
pybind11::array_t<double, pybind11::array::c_style> numbers(const pybind11::handle& value, std::size_t rows,
                                                            std::size_t columns, const std::string& what);

}  // namespace tendril::python
