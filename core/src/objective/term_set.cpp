#include "objective/term_set.hpp"

#include <cmath>

#include "obstacle/surface.hpp"
#include "tendril/error.hpp"

namespace tendril {
TermEvaluator::TermEvaluator(WeightedTerm term, const Target& target, int contacts, int moments, const TermUnits& units)
    : weighted_(std::move(term)), reads_(weighted_.term->reads()), units_(units) {
  for (const double s : reads_.samples) {
    if (!(s >= 0.0 && s <= 1.0)) {
      throw Error("objective '" + weighted_.name +
                  "' asks for a backbone sample outside the rod (s/L = " + std::to_string(s) + ")");
    }
  }
  finger_.resize(1);
  dual_finger_.resize(1);
  samples_.resize(reads_.samples.size());
  dual_samples_.resize(samples_.size());
  if (reads_.any_contact()) {
    contacts_.resize(static_cast<std::size_t>(contacts));
    dual_contacts_.resize(contacts_.size());
  }
  if (reads_.moments) {
    moments_.resize(static_cast<std::size_t>(moments));
    dual_moments_.resize(moments_.size());
  }
  finger_[0].samples = samples_;
  finger_[0].contacts = contacts_;
  finger_[0].moments = moments_;
  dual_finger_[0].samples = dual_samples_;
  dual_finger_[0].contacts = dual_contacts_;
  dual_finger_[0].moments = dual_moments_;
  quantities_.fingers = finger_;
  dual_quantities_.fingers = dual_finger_;
  set_target(target);

  // The number of residuals and the parts that the term uses show in one dry run. Its quantities are all different from
  // zero, so that a part that is used is not zero by accident.
  double probe = 0.1;
  const auto next = [&probe] { return probe += 0.0173; };
  for (auto* p : {&finger_[0].tip}) *p = {next(), next(), next(), next()};
  for (auto& p : samples_) p = {next(), next(), next(), next()};
  for (auto& c : contacts_) c = {next(), next(), next(), 0.6, 0.8, next(), next(), next(), next()};
  for (double& m : moments_) m = next();
  finger_[0].bending_energy = next();
  quantities_.palm_distance = next();
  Contribution<double> dry{std::span<double>{}};
  weighted_.term->evaluate(quantities_, dry);
  residuals_ = static_cast<int>(dry.residual_count());
  has_linear_ = dry.linear_part() != 0.0;
  has_smooth_ = dry.smooth_part() != 0.0;
  finger_[0].tip = {};
  finger_[0].bending_energy = 0.0;
  quantities_.palm_distance = 0.0;
  for (auto& p : samples_) p = {};
  for (auto& c : contacts_) c = {};
  for (double& m : moments_) m = 0.0;
  residual_values_.resize(static_cast<std::size_t>(residuals_));
  dual_residuals_.resize(static_cast<std::size_t>(residuals_));
}

void TermEvaluator::set_target(const Target& target) {
  quantities_.target = target;
  dual_quantities_.target = target;
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
  inputs_.push_back(input);
}

void TermEvaluator::bind(const BaseIndex& index, std::size_t first_sample) {
  index_ = &index;
  inputs_.clear();
  const double length = units_.length;
  const double moment = units_.force * units_.length;
  FingerQuantities<double>& f = finger_[0];
  FingerQuantities<HyperDual>& d = dual_finger_[0];
  if (reads_.tip_position) {
    add_input(f.tip.x, d.tip.x, index.tip.x, length);
    add_input(f.tip.y, d.tip.y, index.tip.y, length);
  }
  if (reads_.tip_angle) add_input(f.tip.angle, d.tip.angle, index.tip.angle, 1.0);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const BaseIndex::Point& p = index.samples[first_sample + i];
    add_input(samples_[i].x, dual_samples_[i].x, p.x, length);
    add_input(samples_[i].y, dual_samples_[i].y, p.y, length);
    add_input(samples_[i].angle, dual_samples_[i].angle, p.angle, 1.0);
    add_input(samples_[i].curvature, dual_samples_[i].curvature, p.curvature, 1.0 / length);
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const BaseIndex::Contact& c = index.contacts[k];
    if (reads_.contact_point) {
      add_input(contacts_[k].x, dual_contacts_[k].x, c.point.x, length);
      add_input(contacts_[k].y, dual_contacts_[k].y, c.point.y, length);
    }
    if (reads_.contact_gap) add_surface_input(contacts_[k].gap, dual_contacts_[k].gap, Kind::gap, static_cast<int>(k));
    if (reads_.contact_normal) {
      add_surface_input(contacts_[k].normal_x, dual_contacts_[k].normal_x, Kind::normal_x, static_cast<int>(k));
      add_surface_input(contacts_[k].normal_y, dual_contacts_[k].normal_y, Kind::normal_y, static_cast<int>(k));
    }
    if (reads_.contact_force) add_input(contacts_[k].force, dual_contacts_[k].force, c.force, units_.force);
    if (reads_.contact_arc_length)
      add_input(contacts_[k].arc_length, dual_contacts_[k].arc_length, c.arc_length, length);
  }
  for (std::size_t a = 0; a < moments_.size(); ++a) add_input(moments_[a], dual_moments_[a], index.moments[a], moment);
  if (reads_.bending_energy) add_input(f.bending_energy, d.bending_energy, index.energy, moment);
  if (reads_.palm_distance) add_input(quantities_.palm_distance, dual_quantities_.palm_distance, index.palm, length);
  input_gradient_.resize(inputs_.size());
  input_hessian_.resize(inputs_.size() * inputs_.size());
}

void TermEvaluator::evaluate(const BaseValues& at, double& cost, double& rest, double* residuals) {
  for (Input& input : inputs_) {
    if (input.kind == Kind::plain) {
      *input.value = input.unit * at.base[input.base[0]];
      continue;
    }
    const SurfacePoint& s = at.surfaces[static_cast<std::size_t>(input.contact)];
    *input.value = input.kind == Kind::gap        ? input.unit * s.distance
                   : input.kind == Kind::normal_x ? s.normal.x
                                                  : s.normal.y;
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    // A tip contact has no arc length among its variables, yet sits at 1.
    if (reads_.contact_arc_length && index_->contacts[k].arc_length < 0) {
      contacts_[k].arc_length = units_.length;
      dual_contacts_[k].arc_length = units_.length;
    }
    if (!reads_.contact_point) continue;
    const Vec2 reference = units_.length * at.references[k];
    contacts_[k].reference_x = reference.x;
    contacts_[k].reference_y = reference.y;
    dual_contacts_[k].reference_x = reference.x;
    dual_contacts_[k].reference_y = reference.y;
  }
  if (reads_.palm_distance && index_->palm < 0) {
    quantities_.palm_distance = units_.length * at.palm;
    dual_quantities_.palm_distance = units_.length * at.palm;
  }
  Contribution<double> out{residual_values_};
  weighted_.term->evaluate(quantities_, out);
  if (static_cast<int>(out.residual_count()) != residuals_) {
    throw Error("objective '" + weighted_.name + "' changed its number of residuals from " +
                std::to_string(residuals_) + " to " + std::to_string(out.residual_count()));
  }
  const double root = std::sqrt(weighted_.weight);
  double squares = 0.0;
  for (int i = 0; i < residuals_; ++i) {
    const double r = root * residual_values_[static_cast<std::size_t>(i)];
    residuals[i] = r;
    squares += r * r;
  }
  const double extra = weighted_.weight * (out.linear_part() + out.smooth_part());
  value_ = squares + extra;
  cost += value_;
  rest += extra;
}

Contribution<HyperDual> TermEvaluator::run_dual() {
  Contribution<HyperDual> out{dual_residuals_};
  weighted_.term->evaluate(dual_quantities_, out);
  return out;
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
  const auto scatter = [&](const Input& input, auto direction, const Contribution<HyperDual>& out) {
    const double extra = weight * (direction(out.linear_part()) + direction(out.smooth_part()));
    double total = extra;
    for (int r = 0; r < residuals_; ++r) {
      const HyperDual& value = dual_residuals_[static_cast<std::size_t>(r)];
      total += 2.0 * weight * value.v * direction(value);
    }
    for (int side = 0; side < 2; ++side) {
      if (input.base[side] < 0) continue;
      gradient[input.base[side]] += input.factor[side] * total;
      rest_gradient[input.base[side]] += input.factor[side] * extra;
      for (int r = 0; r < residuals_; ++r) {
        jacobian(first + r, input.base[side]) +=
            input.factor[side] * root * direction(dual_residuals_[static_cast<std::size_t>(r)]);
      }
    }
  };
  // One run carries two directions.
  for (std::size_t i = 0; i < inputs_.size(); i += 2) {
    const bool pair = i + 1 < inputs_.size();
    inputs_[i].dual->a = 1.0;
    if (pair) inputs_[i + 1].dual->b = 1.0;
    const Contribution<HyperDual> out = run_dual();
    inputs_[i].dual->a = 0.0;
    scatter(
        inputs_[i], [](const HyperDual& x) { return x.a; }, out);
    if (!pair) continue;
    inputs_[i + 1].dual->b = 0.0;
    scatter(
        inputs_[i + 1], [](const HyperDual& x) { return x.b; }, out);
  }
}

void TermEvaluator::add_hessian(const BaseValues& at, double sigma, Eigen::MatrixXd& hessian) {
  refresh_factors(at);
  const double weight = sigma * weighted_.weight;
  const std::size_t n = inputs_.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k) {
      inputs_[i].dual->a = 1.0;
      inputs_[k].dual->b = 1.0;
      const Contribution<HyperDual> out = run_dual();
      inputs_[i].dual->a = 0.0;
      inputs_[k].dual->b = 0.0;
      double second = out.linear_part().ab + out.smooth_part().ab;
      double slope = out.linear_part().a + out.smooth_part().a;
      for (const HyperDual& r : dual_residuals_) {
        second += 2.0 * (r.a * r.b + r.v * r.ab);
        slope += 2.0 * r.v * r.a;
      }
      if (i == k) input_gradient_[i] = weight * slope;
      input_hessian_[i * n + k] = input_hessian_[k * n + i] = weight * second;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const double value = input_hessian_[i * n + k];
      if (value == 0.0) continue;
      for (int a = 0; a < 2; ++a) {
        if (inputs_[i].base[a] < 0) continue;
        for (int b = 0; b < 2; ++b) {
          if (inputs_[k].base[b] < 0) continue;
          hessian(inputs_[i].base[a], inputs_[k].base[b]) += inputs_[i].factor[a] * inputs_[k].factor[b] * value;
        }
      }
    }
    // Gap and normal are themselves curved functions of the contact point.
    const Input& input = inputs_[i];
    if (input.kind == Kind::plain) continue;
    const SurfacePoint& s = at.surfaces[static_cast<std::size_t>(input.contact)];
    const Symmetric2 second = input.kind == Kind::gap
                                  ? distance_hessian(s)
                                  : normal_hessian(s, input.kind == Kind::normal_x ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0});
    const double slope = input.unit * input_gradient_[i];
    hessian(input.base[0], input.base[0]) += slope * second.xx;
    hessian(input.base[0], input.base[1]) += slope * second.xy;
    hessian(input.base[1], input.base[0]) += slope * second.xy;
    hessian(input.base[1], input.base[1]) += slope * second.yy;
  }
}

TermSet::TermSet(const std::vector<WeightedTerm>& terms, const Target& target, int contacts, int moments,
                 const TermUnits& units) {
  for (const WeightedTerm& term : terms) {
    terms_.emplace_back(term, target, contacts, moments, units);
    residual_count_ += terms_.back().residual_count();
  }
}

bool TermSet::reads_tip() const {
  for (const TermEvaluator& t : terms_) {
    if (t.reads().tip_position || t.reads().tip_angle) return true;
  }
  return false;
}

bool TermSet::reads_energy() const {
  for (const TermEvaluator& t : terms_) {
    if (t.reads().bending_energy) return true;
  }
  return false;
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

bool TermSet::has_rest() const {
  for (const TermEvaluator& t : terms_) {
    if (t.has_linear() || t.has_smooth()) return true;
  }
  return false;
}

bool TermSet::rest_is_linear() const {
  for (const TermEvaluator& t : terms_) {
    if (t.has_smooth()) return false;
  }
  return true;
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
