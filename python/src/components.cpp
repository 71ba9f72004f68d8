#include "components.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "checks.hpp"
#include "dual.hpp"
#include "kept.hpp"
#include "tendril/error.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

/// The flags of Reads by their names, in the order in which a term's numbers are laid out.
struct Flag {
  const char* name;
  bool Reads::*flag;
};
constexpr std::array flags{Flag{"tip_position", &Reads::tip_position},
                           Flag{"tip_angle", &Reads::tip_angle},
                           Flag{"bending_energy", &Reads::bending_energy},
                           Flag{"moments", &Reads::moments},
                           Flag{"contact_point", &Reads::contact_point},
                           Flag{"contact_gap", &Reads::contact_gap},
                           Flag{"contact_normal", &Reads::contact_normal},
                           Flag{"contact_force", &Reads::contact_force},
                           Flag{"contact_arc_length", &Reads::contact_arc_length},
                           Flag{"palm_distance", &Reads::palm_distance},
                           Flag{"target", &Reads::target},
                           Flag{"mirrored", &Reads::mirrored}};

Reads reads_of(const std::vector<std::string>& names, const std::vector<double>& samples) {
  Reads reads;
  std::vector<std::string> known;
  known.reserve(flags.size());
  for (const Flag& flag : flags) known.emplace_back(flag.name);
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      throw py::value_error("reads: there is no quantity '" + name + "'" + did_you_mean(name, known));
    }
    reads.*flags[static_cast<std::size_t>(found - known.begin())].flag = true;
  }
  reads.samples = samples;
  return reads;
}

/// Hands each number that a term may read to `visit`, always in the same order: with whether it is read, and under
/// which name.
template <class T, class Visit>
void each_number(const Reads& reads, const Quantities<T>& x, Visit&& visit) {
  const auto point = [&](const BackboneQuantities<T>& at, bool position, bool angle, bool curvature, bool tip) {
    visit(position, at.x, tip ? "tip_position" : "samples");
    visit(position, at.y, tip ? "tip_position" : "samples");
    visit(angle, at.angle, tip ? "tip_angle" : "samples");
    visit(curvature, at.curvature, "samples");
  };
  point(x.tip, reads.tip_position, reads.tip_angle, false, true);
  for (const BackboneQuantities<T>& sample : x.samples) point(sample, true, true, true, false);
  for (const ContactQuantities<T>& c : x.contacts) {
    visit(reads.contact_point, c.x, "contact_point");
    visit(reads.contact_point, c.y, "contact_point");
    visit(reads.contact_gap, c.gap, "contact_gap");
    visit(reads.contact_normal, c.normal_x, "contact_normal");
    visit(reads.contact_normal, c.normal_y, "contact_normal");
    visit(reads.contact_force, c.force, "contact_force");
    visit(reads.contact_arc_length, c.arc_length, "contact_arc_length");
    visit(reads.contact_point, c.reference_x, "contact_point");
    visit(reads.contact_point, c.reference_y, "contact_point");
  }
  for (const T& moment : x.moments) visit(reads.moments, moment, "moments");
  visit(reads.bending_energy, x.bending_energy, "bending_energy");
  visit(reads.palm_distance, x.palm_distance, "palm_distance");
}

/// The package's types for what a term sees.
struct Types {
  Types() : module(py::module_::import("tendril._components")) {}
  py::object module;
  py::object quantities = module.attr("Quantities"), point = module.attr("BackbonePoint"),
             contact = module.attr("ContactPoint"), target = module.attr("TargetPose");
  py::dict not_read = module.attr("NOT_READ");
};

/// A function of Python's, and what a scene set of its options.
struct Function {
  py::object call;
  py::dict options;
  Types types{};
};

class PythonTerm final : public ObjectiveTerm {
 public:
  PythonTerm(Kept<Function> function, Reads reads, double lower_bound)
      : function_(std::move(function)), reads_(std::move(reads)), lower_bound_(lower_bound) {}

  Reads reads() const override { return reads_; }
  double lower_bound() const override { return lower_bound_; }

  void evaluate(const Quantities<double>& x, Contribution<double>& out) const override {
    in_python([&] {
      const Value value = call(x, [](double v) { return Dual(v); });
      double cost = value.smooth.value();
      for (const Dual& residual : value.residuals) {
        out.residual(residual.value());
        cost += residual.value() * residual.value();
      }
      out.smooth(value.smooth.value());
      if (cost < lower_bound_ - 1e-9 * (1.0 + std::abs(cost))) {
        throw Error("it is " + shown(cost) + ", below its lower_bound of " + shown(lower_bound_) +
                    "; expected never (lower_bound=-math.inf where there is none)");
      }
    });
  }

  /// Core asks for many pairs of directions at one point, Python is asked once.
  void evaluate(const Quantities<HyperDual>& x, Contribution<HyperDual>& out) const override {
    directions_.clear();
    each_number(reads_, x, [&](bool read, const HyperDual& v, const char*) {
      if (read) directions_.push_back(v);
    });
    if (!same_point()) in_python([&] { evaluate_at(x); });
    for (const Dual& residual : value_.residuals) out.residual(along(residual));
    out.smooth(along(value_.smooth));
  }

 private:
  struct Value {
    std::vector<Dual> residuals;
    Dual smooth;
  };

  bool same_point() const {
    return known_ && std::equal(point_.begin(), point_.end(), directions_.begin(), directions_.end(),
                                [](double v, const HyperDual& d) { return v == d.v; });
  }

  void evaluate_at(const Quantities<HyperDual>& x) const {
    known_ = false;
    point_.clear();
    for (const HyperDual& d : directions_) point_.push_back(d.v);
    const auto count = static_cast<int>(point_.size());
    int next = 0;
    value_ = call(x, [&](const HyperDual& v) { return Dual(v.v, count, next++); });
    known_ = true;
  }

  HyperDual along(const Dual& y) const {
    HyperDual sum(y.value());
    const auto count = static_cast<int>(directions_.size());
    for (int i = 0; i < count; ++i) {
      const HyperDual& d = directions_[static_cast<std::size_t>(i)];
      sum.a += y.slope(i) * d.a;
      sum.b += y.slope(i) * d.b;
      sum.ab += y.slope(i) * d.ab;
      if (d.a == 0.0) continue;
      for (int k = 0; k < count; ++k) {
        const double b = directions_[static_cast<std::size_t>(k)].b;
        if (b != 0.0) sum.ab += y.bend(i, k) * d.a * b;
      }
    }
    return sum;
  }

  template <class T, class Number>
  Value call(const Quantities<T>& x, Number&& number) const {
    std::vector<py::object> numbers;
    each_number(reads_, x, [&](bool read, const T& v, const char* name) {
      numbers.push_back(read ? py::cast(number(v)) : py::object(function_->types.not_read[name]));
    });
    const py::object seen = put_together(numbers, x.samples.size(), x.contacts.size(), x.moments.size(), x.target);
    return value_of(function_->call(seen, **function_->options));
  }

  /// The numbers of each_number() as the package's Quantities.
  py::object put_together(const std::vector<py::object>& numbers, std::size_t samples, std::size_t contacts,
                          std::size_t moments, const Target& t) const {
    const Types& types = function_->types;
    auto n = numbers.begin();
    const auto point = [&] {
      n += 4;
      return types.point(n[-4], n[-3], n[-2], n[-1]);
    };
    const auto tuple = [](std::size_t count, auto make) {
      py::tuple all(count);
      for (std::size_t i = 0; i < count; ++i) all[i] = make();
      return all;
    };
    const py::object tip = point();
    const py::tuple sampled = tuple(samples, point);
    const py::tuple touching = tuple(contacts, [&] {
      n += 9;
      return types.contact(n[-9], n[-8], n[-7], n[-6], n[-5], n[-4], n[-3], n[-2], n[-1]);
    });
    const py::tuple moving = tuple(moments, [&] { return *n++; });
    const py::object position =
        t.has_position ? py::object(py::make_tuple(t.position.x, t.position.y)) : py::object(py::none());
    const py::object angle = t.has_angle ? py::object(py::float_(t.angle)) : py::object(py::none());
    return types.quantities(tip, sampled, touching, moving, n[0], n[1], types.target(position, angle));
  }

  /// A number is added to the cost as it is, of a list the squares.
  static Value value_of(const py::object& given) {
    const auto dual = [](const py::handle& value) {
      return py::isinstance<Dual>(value) ? value.cast<Dual>() : Dual(number(value, "its value"));
    };
    const bool is_array = py::isinstance<py::array>(given);
    Value value;
    if (is_array && py::reinterpret_borrow<py::array>(given).ndim() == 0) {
      value.smooth = dual(given.attr("item")());
    } else if (is_array || py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given)) {
      for (const py::handle& residual : given) value.residuals.push_back(dual(residual));
    } else if (py::isinstance<Dual>(given) || PyNumber_Check(given.ptr()) != 0) {
      value.smooth = dual(given);
    } else {
      refuse("its value", given, "a number, which is added to the cost, or a list of numbers, whose squares are");
    }
    return value;
  }

  Kept<Function> function_;
  Reads reads_;
  double lower_bound_;
  mutable std::vector<HyperDual> directions_;
  mutable std::vector<double> point_;
  mutable Value value_;
  mutable bool known_ = false;
};

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
      functions_ = static_cast<int>(std::lround(number(basis_->told(basis_->functions), "functions")));
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
    for (const py::handle& entry : basis_->told(value)) entries.push_back(number(entry, what));
    return entries;
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

class PythonObstacle final : public Obstacle {
 public:
  explicit PythonObstacle(py::object shape) : shape_(std::move(shape)) {
    in_python([&] {
      rounding_ = number(get("rounding"), "rounding");
      smallest_radius_ = number(get("smallest_radius"), "smallest_radius");
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

Dimension dimension_of(const std::string& unit) {
  constexpr std::array known{dimension::none,  dimension::angle,  dimension::length,    dimension::curvature,
                             dimension::force, dimension::moment, dimension::stiffness, dimension::pressure};
  std::vector<std::string> names;
  for (const Dimension& d : known) {
    if (d.unit == unit) return d;
    names.emplace_back(d.unit);
  }
  throw py::value_error("unit: found '" + unit + "', expected one of the SI units m, rad, 1/m, N, N m, N m^2, Pa");
}

/// (name, default, unit, description, least, most)
using OptionTuple = std::tuple<std::string, py::object, std::string, std::string, double, double>;

OptionSchema schema_of(const std::vector<OptionTuple>& options) {
  OptionSchema schema;
  for (const auto& [name, value, unit, description, least, most] : options) {
    OptionSpec spec;
    spec.name = name;
    spec.description = description;
    spec.minimum = least;
    spec.maximum = most;
    spec.dimension = dimension_of(unit);
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

PythonComponent objective(const std::string& name, const std::string& description, const py::object& function,
                          const std::vector<std::string>& reads, const std::vector<double>& samples, double lower_bound,
                          const std::vector<OptionTuple>& options) {
  const Kept<py::object> kept(function);
  ObjectiveComponent component{
      name, description, schema_of(options),
      [kept, reads = reads_of(reads, samples), lower_bound](const Options& given) {
        return in_python([&]() -> std::unique_ptr<ObjectiveTerm> {
          return std::make_unique<PythonTerm>(Kept<Function>({*kept, options_of(given)}), reads, lower_bound);
        });
      }};
  return {[component](Registrar& registrar) { registrar.add(component); }};
}

PythonComponent coordinates(const std::string& name, const std::string& description, const py::object& function,
                            const py::object& functions, const py::object& breaks, const py::object& subdivision,
                            const py::object& names, const std::vector<OptionTuple>& options) {
  const Kept<Basis> kept({function, functions, breaks, subdivision, names, {}});
  CoordinateComponent component{name, description, schema_of(options), [kept](const Options& given) {
                                  return in_python([&]() -> std::unique_ptr<CoordinateModel> {
                                    Basis basis = *kept;
                                    basis.options = options_of(given);
                                    return std::make_unique<PythonCoordinates>(Kept<Basis>(std::move(basis)));
                                  });
                                }};
  return {[component](Registrar& registrar) { registrar.add(component); }};
}

PythonComponent obstacle(const std::string& name, const std::string& description, const py::object& shape,
                         const std::vector<OptionTuple>& options) {
  const Kept<py::object> kept(shape);
  ObstacleComponent component{name, description, schema_of(options), [kept](const Options& given) {
                                return in_python([&]() -> std::unique_ptr<Obstacle> {
                                  return std::make_unique<PythonObstacle>((*kept)(**options_of(given)));
                                });
                              }};
  return {[component](Registrar& registrar) { registrar.add(component); }};
}

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

std::string check(const PythonComponent& component, const py::dict& options) {
  Checker checker;
  for (const auto& [name, value] : options) checker.options.emplace(py::str(name), raw(value));
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
  module.def("objective", &objective);
  module.def("coordinates", &coordinates);
  module.def("obstacle", &obstacle);
  module.def("check", &check);
}

}  // namespace tendril::python
