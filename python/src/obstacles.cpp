#include <pybind11/numpy.h>

#include "components.hpp"
#include "kept.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

class PythonObstacle final : public Obstacle {
 public:
  explicit PythonObstacle(py::object shape) : shape_(std::move(shape)) {
    in_python([&] {
      rounding_ = number(get("rounding"), "rounding");
      smallest_radius_ = number(get("smallest_radius"), "smallest_radius");
      if (!py::isinstance<py::bool_>(get("convex"))) refuse("convex", get("convex"), "True or False");
      convex_ = get("convex").cast<bool>();
      reference_ = vector(get("reference_point"), "reference_point");
      const auto box = py::reinterpret_borrow<py::sequence>(get("bounding_box"));
      if (py::len(box) != 2) refuse("bounding_box", box, "two corners ((x, y), (x, y))");
      low_ = vector(box[0], "bounding_box");
      high_ = vector(box[1], "bounding_box");
    });
  }

  SurfacePoint at(Vec2 point) const override {
    return in_python([&] {
      const py::object given = get("at")(point.x, point.y);
      const bool four = py::isinstance<py::tuple>(given) || py::isinstance<py::list>(given);
      if (!four || py::len(given) != 4) {
        refuse("at()", given, "(distance, (normal x, normal y), curvature, its rate along the surface)");
      }
      const auto parts = py::reinterpret_borrow<py::sequence>(given);
      return SurfacePoint{number(parts[0], "the distance"), vector(parts[1], "the normal"),
                          number(parts[2], "the curvature"), number(parts[3], "the curvature's rate")};
    });
  }
  Vec2 reference_point() const override { return reference_; }
  double smallest_radius() const override { return smallest_radius_; }
  double core_distance(Vec2 point) const override {
    return in_python([&] { return number(get("core_distance")(point.x, point.y), "core_distance()"); });
  }
  double rounding() const override { return rounding_; }
  bool convex() const override { return convex_; }
  void bounding_box(Vec2& low, Vec2& high) const override {
    low = low_;
    high = high_;
  }
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override {
    in_python([&] {
      const py::object given =
          get("outline")(points.size(), py::make_tuple(low.x, low.y), py::make_tuple(high.x, high.y));
      const auto array = numbers(given, points.size(), 2, "outline()");
      const auto entry = array.unchecked<2>();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto row = static_cast<py::ssize_t>(i);
        points[i] = {entry(row, 0), entry(row, 1)};
      }
    });
  }

 private:
  py::object get(const char* name) const { return shape_->attr(name); }
  static Vec2 vector(const py::handle& value, const char* what) {
    const auto [x, y] = two_numbers(value, what);
    return {x, y};
  }

  Kept<py::object> shape_;
  Vec2 reference_{}, low_{}, high_{};
  double rounding_ = 0.0, smallest_radius_ = 0.0;
  bool convex_ = true;
};

PythonComponent obstacle(const std::string& name, const std::string& description, const py::object& shape,
                         const std::vector<OptionTuple>& options) {
  const Kept<py::object> kept(shape);
  return component_of<Obstacle>(name, description, options, [kept](const py::dict& given) {
    return std::make_unique<PythonObstacle>((*kept)(**given));
  });
}

}  // namespace

void add_obstacles(py::module_& module) { module.def("obstacle", &obstacle); }

}  // namespace tendril::python
