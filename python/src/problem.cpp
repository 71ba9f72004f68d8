#include "problem.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <mutex>

#include "interrupt.hpp"
#include "source.hpp"
#include "tendril/error.hpp"
#include "tendril/scale.hpp"
#include "tendril/whole_number.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

/// A problem with the plan that it follows. Several threads may use it: one waits for the other.
class FollowedProblem {
 public:
  explicit FollowedProblem(const files::SceneSource& source) : file_(source), problem_(file_.problem()) {}

  const files::SceneFile& file() const { return file_; }

  std::string plan(const std::optional<std::string>& start) {
    return interruptible([&](const std::atomic<bool>& stop) {
      const std::lock_guard lock(mutex_);
      const std::optional<Plan> earlier = start ? std::optional(file_.read_plan({*start, "start"})) : std::nullopt;
      plan_now(stop, earlier ? &*earlier : nullptr);
      return file_.json(plan_);
    });
  }

  void set_target(const TargetSpec& target) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    problem_.set_target(target);
  }

  void follow(const TargetSpec& target) {
    std::unique_lock lock(mutex_, std::defer_lock);
    {
      // Python hears of Ctrl-C behind a step, which takes microseconds, with friction milliseconds.
      const py::gil_scoped_release released;
      lock.lock();
      if (planned_ && problem_.step(target, plan_)) return;
      problem_.set_target(target);
    }
    interruptible([&](const std::atomic<bool>& stop) {
      plan_now(stop, planned_ ? &plan_ : nullptr);
      return true;
    });
  }

  /// `read` of the plan as it stands.
  template <class Read>
  auto read(Read&& read) {
    std::unique_lock lock(mutex_, std::defer_lock);
    {
      const py::gil_scoped_release released;
      lock.lock();
    }
    return read(plan_);
  }

 private:
  void plan_now(const std::atomic<bool>& stop, const Plan* start) {
    PlanControl control;
    control.stop = &stop;
    control.start = start;
    plan_ = problem_.plan(control);
    planned_ = true;
  }

  files::SceneFile file_;
  Problem& problem_;
  Plan plan_;
  bool planned_ = false;
  std::mutex mutex_;  ///< taken without Python's lock, so that none waits for both
};

constexpr std::int64_t most_turns = 1000000;

/// SI number, text with a unit, or what the package makes one of these of.
double quantity(const py::handle& value, const Scene& scene, const Dimension& wanted, const char* name) {
  double number = 0.0;
  if (PyFloat_Check(value.ptr())) {
    number = PyFloat_AS_DOUBLE(value.ptr());
  } else {
    const py::object plain = py::module_::import("tendril._values").attr("plain")(value, name);
    if (!py::isinstance<py::str>(plain)) {
      number = plain.cast<double>();
    } else {
      const auto text = plain.cast<std::string>();
      try {
        number = scene.read_quantity(text, wanted);
      } catch (const Error& error) {
        throw py::value_error(std::string(name) + ": found \"" + text + "\", " + error.what() +
                              ", expected a number in " + std::string(wanted.unit) + " or text with a unit");
      }
    }
  }
  if (!std::isfinite(number)) throw py::value_error(std::string(name) + ": found a number that is not finite");
  return number;
}

TargetSpec target_of(const py::object& position, const py::object& angle, const py::object& turns, const Scene& scene) {
  TargetSpec target;
  if (!position.is_none()) {
    if (!py::isinstance<py::sequence>(position) && !py::isinstance<py::array>(position))
      throw py::type_error("position: expected two lengths (x, y)");
    const py::sequence pair(position);
    if (py::isinstance<py::str>(position) || pair.size() != 2)
      throw py::value_error("position: expected two lengths (x, y)");
    target.position = Vec2{quantity(pair[0], scene, dimension::length, "position[0]"),
                           quantity(pair[1], scene, dimension::length, "position[1]")};
  }
  if (!angle.is_none()) target.angle = quantity(angle, scene, dimension::angle, "angle");
  if (!turns.is_none()) {
    const double found = PyFloat_AsDouble(turns.ptr());
    if (PyErr_Occurred() != nullptr) PyErr_Clear();  // no number, which -1 then stands for
    const auto count =
        PyNumber_Check(turns.ptr()) != 0 && PyBool_Check(turns.ptr()) == 0 ? whole_number(found) : std::nullopt;
    if (!count || std::abs(*count) > most_turns)
      throw py::type_error("turns: found " + py::repr(turns).cast<std::string>() +
                           ", expected a whole number of turns");
    target.turns = static_cast<int>(*count);
  }
  if (!target.position && !target.angle) throw py::value_error("target: expected a position, an angle, or both");
  return target;
}

py::array_t<double> copied(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::array_t<double> copied(const std::vector<BackbonePoint>& points) {
  static_assert(sizeof(BackbonePoint) == 5 * sizeof(double));
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(points.size()), 5};
  return py::array_t<double>(shape, points.empty() ? nullptr : &points.front().s);
}

py::list contacts_of(const Plan& plan) {
  py::list contacts;
  for (const PlannedContact& c : plan.contacts) {
    py::dict one;
    one["obstacle"] = c.obstacle_name;
    one["arc_length"] = c.arc_length;
    one["point"] = py::make_tuple(c.point.x, c.point.y);
    one["normal"] = py::make_tuple(c.normal.x, c.normal.y);
    one["force"] = c.force;
    one["gap"] = c.gap;
    contacts.append(one);
  }
  return contacts;
}

template <class Read>
auto property(Read&& read) {
  return [read](FollowedProblem& problem) { return problem.read(read); };
}

}  // namespace

void add_problem(py::module_& module) {
  py::class_<FollowedProblem>(module, "Problem")
      .def(py::init([](const SceneTuple& scene) { return std::make_unique<FollowedProblem>(source_of(scene)); }))
      .def("plan", &FollowedProblem::plan)
      .def("set_target",
           [](FollowedProblem& problem, const py::object& position, const py::object& angle, const py::object& turns) {
             problem.set_target(target_of(position, angle, turns, problem.file().scene()));
           })
      .def(
          "follow",
          [](FollowedProblem& problem, const py::object& position, const py::object& angle, const py::object& turns) {
            problem.follow(target_of(position, angle, turns, problem.file().scene()));
          },
          py::arg("position") = py::none(), py::arg("angle") = py::none(), py::arg("turns") = py::none())
      .def("json",
           [](FollowedProblem& problem) {
             return problem.read([&](const Plan& plan) { return problem.file().json(plan); });
           })
      .def_property_readonly("status", property([](const Plan& plan) { return std::string(to_string(plan.status)); }))
      .def_property_readonly("solved", property([](const Plan& plan) { return plan.status == PlanStatus::solved; }))
      .def_property_readonly("message", property([](const Plan& plan) { return plan.message; }))
      .def_property_readonly("objective", property([](const Plan& plan) { return plan.objective; }))
      .def_property_readonly("target_error", property([](const Plan& plan) { return plan.target_error; }))
      .def_property_readonly(
          "tip", property([](const Plan& plan) { return py::make_tuple(plan.tip_x, plan.tip_y, plan.tip_angle); }))
      .def_property_readonly("moments", property([](const Plan& plan) { return copied(plan.moments); }))
      .def_property_readonly("coordinates", property([](const Plan& plan) { return copied(plan.coordinates); }))
      .def_property_readonly("backbone", property([](const Plan& plan) { return copied(plan.backbone); }))
      .def_property_readonly("contacts", property(&contacts_of));
}

}  // namespace tendril::python
