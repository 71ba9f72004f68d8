#include "objective/term_set.hpp"

#include <algorithm>
#include <cmath>

#include "obstacle/surface.hpp"
#include "tendril/error.hpp"

namespace tendril {

template <class T>
TermEvaluator::View<T>::View(const Reads& reads, const TermCounts& counts)
    : samples(reads.samples.size()),
      contacts(static_cast<std::size_t>(reads.any_contact() ? counts.contacts : 0)),
      moments(static_cast<std::size_t>(reads.moments ? counts.moments : 0)),
      tensions(static_cast<std::size_t>(reads.tensions ? counts.tendons : 0)),
      shortenings(static_cast<std::size_t>(reads.shortenings ? counts.tendons : 0)),
      deviations(static_cast<std::size_t>(reads.tip_deviations ? counts.deviations : 0)) {
  seen.samples = samples;
  seen.contacts = contacts;
  seen.moments = moments;
  seen.tensions = tensions;
  seen.shortenings = shortenings;
  seen.tip_deviations = deviations;
}

template <class T>
Contribution<T> TermEvaluator::View<T>::run(const ObjectiveTerm& term) {
  Contribution<T> out{residuals};
  term.evaluate(seen, out);
  return out;
}

TermEvaluator::TermEvaluator(WeightedTerm term, const Target& target, const TermCounts& counts, const TermUnits& units)
    : weighted_(std::move(term)),
      reads_(weighted_.term->reads()),
      units_(units),
      plain_(reads_, counts),
      dual_(reads_, counts) {
  for (const double s : reads_.samples) {
    if (!(s >= 0.0 && s <= 1.0)) {
      throw Error("objective '" + weighted_.name + "' asks for a backbone sample outside the rod (s/L = " + shown(s) +
                  ")");
    }
  }
  set_target(target);
  // How many residuals there are is the same at every point.
  plain_.residuals.resize(plain_.run(*weighted_.term).residual_count());
  dual_.residuals.resize(plain_.residuals.size());
}

void TermEvaluator::set_target(const Target& target) {
  plain_.seen.target = target;
  dual_.seen.target = target;
}

void TermEvaluator::add_input(double& value, HyperDual& dual, int base, double unit) {
  if (base < 0) return;
  Input input;
  input.value = &value;
  input.dual = &dual;
  input.base[0] = base;
  input.unit = input.factor[0] = unit;
  inputs_.push_back(input);
}

void TermEvaluator::add_surface_input(double& value, HyperDual& dual, Kind kind, int contact) {
  Input input;
  input.value = &value;
  input.dual = &dual;
  input.kind = kind;
  input.contact = contact;
  if (kind == Kind::gap) input.unit = units_.length;
  const BaseIndex::Point& p = index_->contacts[static_cast<std::size_t>(contact)].point;
  input.base[0] = p.x;
  input.base[1] = p.y;
  if (kind == Kind::gap && index_->thick)
    input.base[2] = index_->contacts[static_cast<std::size_t>(contact)].arc_length;
  inputs_.push_back(input);
}

void TermEvaluator::bind(const BaseIndex& index, std::size_t first_sample) {
  index_ = &index;
  inputs_.clear();
  const double length = units_.length;
  const double moment = units_.force * units_.length;
  Quantities<double>& p = plain_.seen;
  Quantities<HyperDual>& d = dual_.seen;
  if (reads_.tip_position) {
    add_input(p.tip.x, d.tip.x, index.tip.x, length);
    add_input(p.tip.y, d.tip.y, index.tip.y, length);
  }
  if (reads_.tip_angle) add_input(p.tip.angle, d.tip.angle, index.tip.angle, 1.0);
  for (std::size_t i = 0; i < plain_.samples.size(); ++i) {
    const BaseIndex::Point& at = index.samples[first_sample + i];
    BackboneQuantities<double>& plain = plain_.samples[i];
    BackboneQuantities<HyperDual>& dual = dual_.samples[i];
    add_input(plain.x, dual.x, at.x, length);
    add_input(plain.y, dual.y, at.y, length);
    add_input(plain.angle, dual.angle, at.angle, 1.0);
    add_input(plain.curvature, dual.curvature, at.curvature, 1.0 / length);
    add_input(plain.strain, dual.strain, at.strain, 1.0);
  }
  for (std::size_t k = 0; k < plain_.contacts.size(); ++k) bind_contact(static_cast<int>(k));
  for (std::size_t a = 0; a < plain_.moments.size(); ++a) {
    add_input(plain_.moments[a], dual_.moments[a], index.moments[a], moment);
  }
  for (std::size_t t = 0; t < plain_.tensions.size(); ++t) {
    const BaseIndex::Tendon& tendon = index.tendons[t];
    add_input(plain_.tensions[t], dual_.tensions[t], index.moments[static_cast<std::size_t>(tendon.actuator)],
              units_.force / tendon.offset);
  }
  for (std::size_t t = 0; t < plain_.shortenings.size(); ++t) {
    add_input(plain_.shortenings[t], dual_.shortenings[t], index.tendons[t].turn, length * index.tendons[t].offset);
  }
  for (std::size_t i = 0; i < plain_.deviations.size(); ++i) {
    add_input(plain_.deviations[i].x, dual_.deviations[i].x, index.deviations[i].x, length);
    add_input(plain_.deviations[i].y, dual_.deviations[i].y, index.deviations[i].y, length);
  }
  if (reads_.bending_energy) add_input(p.bending_energy, d.bending_energy, index.energy, moment);
  if (reads_.insertion) {
    p.insertion = length;
    d.insertion = HyperDual(length);
    add_input(p.insertion, d.insertion, index.port, -length);
    if (index.port >= 0) inputs_.back().offset = length;
  }
  if (reads_.palm_distance) add_input(p.palm_distance, d.palm_distance, index.palm, length);
  input_gradient_.resize(inputs_.size());
  input_hessian_.resize(inputs_.size() * inputs_.size());
}

void TermEvaluator::bind_contact(int k) {
  const BaseIndex::Contact& at = index_->contacts[static_cast<std::size_t>(k)];
  ContactQuantities<double>& plain = plain_.contacts[static_cast<std::size_t>(k)];
  ContactQuantities<HyperDual>& dual = dual_.contacts[static_cast<std::size_t>(k)];
  if (reads_.contact_point) {
    add_input(plain.x, dual.x, at.point.x, units_.length);
    add_input(plain.y, dual.y, at.point.y, units_.length);
  }
  if (reads_.contact_gap) add_surface_input(plain.gap, dual.gap, Kind::gap, k);
  if (reads_.contact_normal) {
    add_surface_input(plain.normal_x, dual.normal_x, Kind::normal_x, k);
    add_surface_input(plain.normal_y, dual.normal_y, Kind::normal_y, k);
  }
  if (reads_.contact_force) add_input(plain.force, dual.force, at.force, units_.force);
  if (reads_.contact_arc_length) add_input(plain.arc_length, dual.arc_length, at.arc_length, units_.length);
}

void TermEvaluator::read_inputs(const BaseValues& at) {
  for (Input& input : inputs_) {
    if (input.kind == Kind::plain) {
      *input.value = input.offset + input.unit * at.base[input.base[0]];
      continue;
    }
    const SurfacePoint& s = at.surfaces[static_cast<std::size_t>(input.contact)];
    *input.value = input.kind == Kind::gap        ? input.unit * s.distance
                   : input.kind == Kind::normal_x ? s.normal.x
                                                  : s.normal.y;
  }
  for (std::size_t k = 0; k < plain_.contacts.size(); ++k) {
    // A tip contact has no arc length among its variables, yet sits at 1.
    if (reads_.contact_arc_length && index_->contacts[k].arc_length < 0) {
      dual_.contacts[k].arc_length = plain_.contacts[k].arc_length = units_.length;
    }
    if (!reads_.contact_point) continue;
    const Vec2 reference = units_.length * at.references[k];
    dual_.contacts[k].reference_x = plain_.contacts[k].reference_x = reference.x;
    dual_.contacts[k].reference_y = plain_.contacts[k].reference_y = reference.y;
  }
  if (reads_.palm_distance && index_->palm < 0) {
    dual_.seen.palm_distance = plain_.seen.palm_distance = units_.length * at.palm;
  }
}

namespace {

/// What a term sees that a user can find again, dimensionless.
std::string place_of(const Reads& reads, const Quantities<double>& x) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "with " : ", ") + part; };
  if (reads.tip_position) add("the tip at (" + shown(x.tip.x) + ", " + shown(x.tip.y) + ") L");
  if (reads.tip_angle) add("the tip's angle " + shown(x.tip.angle) + " rad");
  for (std::size_t i = 0; i < x.samples.size() && i < 1; ++i) {
    add("the rod at (" + shown(x.samples[i].x) + ", " + shown(x.samples[i].y) +
        ") L at s/L = " + shown(reads.samples[i]) + ", angle " + shown(x.samples[i].angle) + " rad, curvature " +
        shown(x.samples[i].curvature) + "/L");
  }
  for (std::size_t a = 0; a < x.moments.size(); ++a) {
    add("moment " + std::to_string(a + 1) + " = " + shown(x.moments[a]) + " EI/L");
  }
  for (std::size_t a = 0; a < x.tensions.size(); ++a) {
    add("tension " + std::to_string(a + 1) + " = " + shown(x.tensions[a]) + " EI/L^2");
  }
  for (std::size_t a = 0; a < x.shortenings.size(); ++a) {
    add("shortening " + std::to_string(a + 1) + " = " + shown(x.shortenings[a]) + " L");
  }
  for (std::size_t k = 0; k < x.contacts.size(); ++k) {
    const ContactQuantities<double>& c = x.contacts[k];
    add("contact " + std::to_string(k + 1) + " at (" + shown(c.x) + ", " + shown(c.y) + ") L, force " + shown(c.force) +
        " EI/L^2, gap " + shown(c.gap) + " L");
  }
  if (reads.bending_energy) add("the bending energy " + shown(x.bending_energy) + " EI/L");
  if (reads.insertion) add("the insertion " + shown(x.insertion) + " L");
  return text.empty() ? "whatever it reads" : text;
}

}  // namespace

void TermEvaluator::record_fault(double value, const char* what) {
  if (std::isfinite(value) || !weighted_.fault || !weighted_.fault->empty()) return;
  // A term is not at fault where it is asked of no shape, as by a solver that took a step along another term's numbers.
  if (!std::all_of(inputs_.begin(), inputs_.end(), [](const Input& i) { return std::isfinite(*i.value); })) return;
  *weighted_.fault = std::string(what) + " is " + shown(value) + ' ' + place_of(reads_, plain_.seen);
}

void TermEvaluator::evaluate(const BaseValues& at, double& cost, double& rest, double* residuals) {
  read_inputs(at);
  const Contribution<double> out = plain_.run(*weighted_.term);
  if (out.residual_count() != plain_.residuals.size()) {
    throw Error("objective '" + weighted_.name + "' changed its number of residuals from " +
                std::to_string(plain_.residuals.size()) + " to " + std::to_string(out.residual_count()));
  }
  const double root = std::sqrt(weighted_.weight);
  double squares = 0.0;
  for (const double residual : plain_.residuals) {
    const double r = root * residual;
    *residuals++ = r;
    squares += r * r;
  }
  const double extra = weighted_.weight * out.smooth_part();
  value_ = squares + extra;
  record_fault(value_, "it");
  cost += value_;
  rest += extra;
}

void TermEvaluator::refresh_factors(const BaseValues& at) {
  for (Input& input : inputs_) {
    *input.dual = HyperDual(*input.value);
    if (input.kind == Kind::plain) continue;
    const SurfacePoint& s = at.surfaces[static_cast<std::size_t>(input.contact)];
    const Vec2 tau = turned(s.normal);
    if (input.kind == Kind::gap) {
      input.factor[0] = input.unit * s.normal.x;
      input.factor[1] = input.unit * s.normal.y;
      input.factor[2] = -input.unit * at.radii[static_cast<std::size_t>(input.contact)].slope;
    } else {
      const double row = s.curvature * (input.kind == Kind::normal_x ? tau.x : tau.y);
      input.factor[0] = row * tau.x;
      input.factor[1] = row * tau.y;
    }
  }
}

void TermEvaluator::differentiate(const BaseValues& at, Eigen::VectorXd& gradient, Eigen::VectorXd& rest_gradient,
                                  Eigen::MatrixXd& jacobian, int first) {
  refresh_factors(at);
  const double weight = weighted_.weight;
  const double root = std::sqrt(weight);
  const int residuals = residual_count();
  const auto scatter = [&](const Input& input, auto direction, const Contribution<HyperDual>& out) {
    const double extra = weight * direction(out.smooth_part());
    double total = extra;
    for (const HyperDual& value : dual_.residuals) total += 2.0 * weight * value.v * direction(value);
    record_fault(total, "its first derivative");
    for (int side = 0; side < 3; ++side) {
      if (input.base[side] < 0) continue;
      gradient[input.base[side]] += input.factor[side] * total;
      rest_gradient[input.base[side]] += input.factor[side] * extra;
      for (int r = 0; r < residuals; ++r) {
        jacobian(first + r, input.base[side]) +=
            input.factor[side] * root * direction(dual_.residuals[static_cast<std::size_t>(r)]);
      }
    }
  };
  // One run carries two directions.
  for (std::size_t i = 0; i < inputs_.size(); i += 2) {
    const bool pair = i + 1 < inputs_.size();
    inputs_[i].dual->a = 1.0;
    if (pair) inputs_[i + 1].dual->b = 1.0;
    const Contribution<HyperDual> out = dual_.run(*weighted_.term);
    inputs_[i].dual->a = 0.0;
    scatter(
        inputs_[i], [](const HyperDual& x) { return x.a; }, out);
    if (!pair) continue;
    inputs_[i + 1].dual->b = 0.0;
    scatter(
        inputs_[i + 1], [](const HyperDual& x) { return x.b; }, out);
  }
}

void TermEvaluator::differentiate_twice(double weight) {
  const std::size_t n = inputs_.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k) {
      inputs_[i].dual->a = 1.0;
      inputs_[k].dual->b = 1.0;
      const Contribution<HyperDual> out = dual_.run(*weighted_.term);
      inputs_[i].dual->a = 0.0;
      inputs_[k].dual->b = 0.0;
      double second = out.smooth_part().ab;
      double slope = out.smooth_part().a;
      for (const HyperDual& r : dual_.residuals) {
        second += 2.0 * (r.a * r.b + r.v * r.ab);
        slope += 2.0 * r.v * r.a;
      }
      record_fault(second, "its second derivative");
      if (i == k) input_gradient_[i] = weight * slope;
      input_hessian_[i * n + k] = input_hessian_[k * n + i] = weight * second;
    }
  }
}

void TermEvaluator::add_hessian(const BaseValues& at, double sigma, Eigen::MatrixXd& hessian) {
  refresh_factors(at);
  differentiate_twice(sigma * weighted_.weight);
  const std::size_t n = inputs_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Input& input = inputs_[i];
    for (std::size_t k = 0; k < n; ++k) {
      const double value = input_hessian_[i * n + k];
      if (value == 0.0) continue;
      for (int a = 0; a < 3; ++a) {
        if (input.base[a] < 0) continue;
        for (int b = 0; b < 3; ++b) {
          if (inputs_[k].base[b] < 0) continue;
          hessian(input.base[a], inputs_[k].base[b]) += input.factor[a] * inputs_[k].factor[b] * value;
        }
      }
    }
    if (input.kind == Kind::plain) continue;
    // Gap and normal are themselves curved functions of the contact point.
    const SurfacePoint& s = at.surfaces[static_cast<std::size_t>(input.contact)];
    const Symmetric2 second = input.kind == Kind::gap
                                  ? distance_hessian(s)
                                  : normal_hessian(s, input.kind == Kind::normal_x ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0});
    const double slope = input.unit * input_gradient_[i];
    hessian(input.base[0], input.base[0]) += slope * second.xx;
    hessian(input.base[0], input.base[1]) += slope * second.xy;
    hessian(input.base[1], input.base[0]) += slope * second.xy;
    hessian(input.base[1], input.base[1]) += slope * second.yy;
    if (input.base[2] < 0) continue;
    hessian(input.base[2], input.base[2]) -= slope * at.radii[static_cast<std::size_t>(input.contact)].bend;
  }
}

TermSet::TermSet(const std::vector<WeightedTerm>& terms, const Target& target, const TermCounts& counts,
                 const TermUnits& units) {
  for (const WeightedTerm& term : terms) {
    terms_.emplace_back(term, target, counts, units);
    residual_count_ += terms_.back().residual_count();
  }
}

bool TermSet::reads(bool Reads::*what) const {
  return std::any_of(terms_.begin(), terms_.end(), [what](const TermEvaluator& t) { return t.reads().*what; });
}

std::vector<double> TermSet::sample_arc_lengths() const {
  std::vector<double> all;
  for (const TermEvaluator& t : terms_) all.insert(all.end(), t.reads().samples.begin(), t.reads().samples.end());
  return all;
}

void TermSet::bind(const BaseIndex& index) {
  index_ = index;
  std::size_t first_sample = 0;
  for (TermEvaluator& t : terms_) {
    t.bind(index_, first_sample);
    first_sample += t.reads().samples.size();
  }
}

void TermSet::set_target(const Target& target) {
  for (TermEvaluator& t : terms_) t.set_target(target);
}

void TermSet::evaluate(const BaseValues& at, double& cost, double& rest, Eigen::VectorXd& residuals) {
  cost = 0.0;
  rest = 0.0;
  int first = 0;
  for (TermEvaluator& t : terms_) {
    t.evaluate(at, cost, rest, residuals.data() + first);
    first += t.residual_count();
  }
}

void TermSet::differentiate(const BaseValues& at, Eigen::VectorXd& gradient, Eigen::VectorXd& rest_gradient,
                            Eigen::MatrixXd& jacobian) {
  gradient.setZero();
  rest_gradient.setZero();
  jacobian.setZero();
  int first = 0;
  for (TermEvaluator& t : terms_) {
    t.differentiate(at, gradient, rest_gradient, jacobian, first);
    first += t.residual_count();
  }
}

void TermSet::add_hessian(const BaseValues& at, double sigma, Eigen::MatrixXd& hessian) {
  for (TermEvaluator& t : terms_) t.add_hessian(at, sigma, hessian);
}

}  // namespace tendril
