#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "components.hpp"
#include "dual.hpp"
#include "kept.hpp"

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
                           Flag{"tensions", &Reads::tensions},
                           Flag{"shortenings", &Reads::shortenings},
                           Flag{"contact_point", &Reads::contact_point},
                           Flag{"contact_gap", &Reads::contact_gap},
                           Flag{"contact_normal", &Reads::contact_normal},
                           Flag{"contact_force", &Reads::contact_force},
                           Flag{"contact_arc_length", &Reads::contact_arc_length},
                           Flag{"insertion", &Reads::insertion},
                           Flag{"palm_distance", &Reads::palm_distance},
                           Flag{"tip_deviations", &Reads::tip_deviations},
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
    visit(curvature, at.strain, "samples");
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
  for (const T& tension : x.tensions) visit(reads.tensions, tension, "tensions");
  for (const T& shortening : x.shortenings) visit(reads.shortenings, shortening, "shortenings");
  for (const TipDeviation<T>& one : x.tip_deviations) {
    visit(reads.tip_deviations, one.x, "tip_deviations");
    visit(reads.tip_deviations, one.y, "tip_deviations");
  }
  visit(reads.bending_energy, x.bending_energy, "bending_energy");
  visit(reads.insertion, x.insertion, "insertion");
  visit(reads.palm_distance, x.palm_distance, "palm_distance");
}

/// The package's types for what a term sees.
struct Types {
  Types() : module(py::module_::import("tendril._components")) {}
  py::object module;
  py::object quantities = module.attr("Quantities"), point = module.attr("BackbonePoint"),
             contact = module.attr("ContactPoint"), deviation = module.attr("TipDeviation"),
             target = module.attr("TargetPose");
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
    const py::object seen = put_together(numbers, x);
    return value_of(function_->call(seen, **function_->options));
  }

  /// The numbers of each_number() as the package's Quantities.
  template <class T>
  py::object put_together(const std::vector<py::object>& numbers, const Quantities<T>& x) const {
    const Types& types = function_->types;
    auto n = numbers.begin();
    const auto point = [&] {
      n += 5;
      return types.point(n[-5], n[-4], n[-3], n[-2], n[-1]);
    };
    const auto tuple = [](std::size_t count, auto make) {
      py::tuple all(count);
      for (std::size_t i = 0; i < count; ++i) all[i] = make();
      return all;
    };
    const py::object tip = point();
    const py::tuple sampled = tuple(x.samples.size(), point);
    const py::tuple touching = tuple(x.contacts.size(), [&] {
      n += 9;
      return types.contact(n[-9], n[-8], n[-7], n[-6], n[-5], n[-4], n[-3], n[-2], n[-1]);
    });
    const auto next = [&] { return *n++; };
    const py::tuple moments = tuple(x.moments.size(), next);
    const py::tuple tensions = tuple(x.tensions.size(), next);
    const py::tuple shortenings = tuple(x.shortenings.size(), next);
    const py::tuple deviations = tuple(x.tip_deviations.size(), [&] {
      n += 2;
      return types.deviation(n[-2], n[-1]);
    });
    const Target& t = x.target;
    const py::object position =
        t.has_position ? py::object(py::make_tuple(t.position.x, t.position.y)) : py::object(py::none());
    const py::object angle = t.has_angle ? py::object(py::float_(t.angle)) : py::object(py::none());
    return types.quantities(tip, sampled, touching, moments, tensions, shortenings, deviations, n[0], n[1], n[2],
                            types.target(position, angle));
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

PythonComponent objective(const std::string& name, const std::string& description, const py::object& function,
                          const std::vector<std::string>& reads, const std::vector<double>& samples, double lower_bound,
                          const std::vector<OptionTuple>& options) {
  const Kept<py::object> kept(function);
  return component_of<ObjectiveTerm>(
      name, description, options, [kept, reads = reads_of(reads, samples), lower_bound](const py::dict& given) {
        return std::make_unique<PythonTerm>(Kept<Function>({*kept, given}), reads, lower_bound);
      });
}

}  // namespace

void add_terms(py::module_& module) { module.def("objective", &objective); }

}  // namespace tendril::python
