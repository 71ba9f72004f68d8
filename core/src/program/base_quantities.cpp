#include "program/base_quantities.hpp"

#include <algorithm>
#include <utility>

#include "program/tip_deviations.hpp"

namespace tendril {
namespace {

std::vector<WeightedTerm> weighted_terms(const PoseProgramSpec& spec) {
  std::vector<WeightedTerm> terms;
  for (const PoseProgramTerm& t : spec.terms) terms.push_back({t.term, t.weight, t.name, t.fault});
  return terms;
}

TermCounts term_counts(const PoseProgramSpec& spec) {
  const std::vector<Rod::Actuator>& actuators = spec.rod->actuators;
  const auto tendons =
      std::count_if(actuators.begin(), actuators.end(), [](const Rod::Actuator& a) { return a.offset != 0.0; });
  return {static_cast<int>(spec.contacts.size()), static_cast<int>(actuators.size()), static_cast<int>(tendons),
          spec.uncertainties ? spec.uncertainties->deviations() : 0};
}

}  // namespace

BaseQuantities::BaseQuantities(const PoseProgramSpec& spec, const PoseProgram::Layout& layout,
                               const std::vector<int>& moment_variables, std::vector<int> contact_places,
                               Places& places)
    : terms(weighted_terms(spec), spec.target, term_counts(spec), spec.term_units),
      places_(places),
      first_move_(layout.first_move),
      contact_places_(std::move(contact_places)) {
  int next = 0;
  const auto point = [&next] {
    BaseIndex::Point p;
    p.x = next++;
    p.y = next++;
    p.angle = next++;
    return p;
  };
  for (int k = 0; k < layout.forces; ++k) index.contacts.push_back({point(), -1, -1, -1});
  if (terms.reads(&Reads::tip_position) || terms.reads(&Reads::tip_angle) || spec.tolerance.any()) {
    index.tip = point();
    tip_place_ = places.add_tip();
  }
  for (const double arc_length : terms.sample_arc_lengths()) {
    sample_places_.push_back(places.add_fixed(arc_length));
    BaseIndex::Point p = point();
    p.curvature = next++;
    if (spec.rod->stretches()) p.strain = next++;
    index.samples.push_back(p);
  }
  if (terms.reads(&Reads::bending_energy)) index.energy = next++;
  if (terms.reads(&Reads::tip_deviations) && spec.uncertainties) {
    deviations_ = std::make_unique<TipDeviations>(spec);
    for (int i = 0; i < spec.uncertainties->deviations(); ++i) {
      index.deviations.push_back({next, next + 1});
      next += 2;
    }
  }
  for (const Rod::Actuator& a : spec.rod->actuators) {
    if (a.offset == 0.0) continue;
    const bool read = a.limits_length() || terms.reads(&Reads::shortenings);
    index.tendons.push_back({static_cast<int>(&a - spec.rod->actuators.data()), read ? next++ : -1, a.offset});
  }
  dense_ = next;
  const auto alone = [&](int variable) {
    variables_.push_back(variable);
    return next++;
  };
  for (const int variable : moment_variables) index.moments.push_back(variable < 0 ? -1 : alone(variable));
  for (int k = 0; k < layout.forces; ++k) {
    index.contacts[static_cast<std::size_t>(k)].force = alone(layout.first_force + k);
  }
  for (int k = 0; k < layout.arc_lengths; ++k) {
    index.contacts[static_cast<std::size_t>(k)].arc_length = alone(layout.first_arc_length + k);
  }
  for (int k = 0; k < layout.leans; ++k) {
    index.contacts[static_cast<std::size_t>(k)].lean = alone(layout.first_lean + k);
  }
  if (spec.rod->draws() && terms.reads(&Reads::insertion)) index.port = alone(layout.first_arc_length - 1);
  if (layout.palm >= 0) {
    index.palm = alone(layout.palm);
  } else if (spec.palm) {
    values.palm = spec.palm->minimum;
  }
  int shear = layout.first_shear;
  for (const ContactSetup& c : spec.contacts) shears_.push_back(c.sticks ? alone(shear++) : -1);
  index.count = next;
  index.thick = spec.rod->is_thick();
  terms.bind(index);

  values.base.setZero(index.count);
  values.surfaces.resize(spec.contacts.size());
  values.radii.resize(spec.contacts.size());
  for (const ContactSetup& c : spec.contacts) {
    values.references.push_back(spec.obstacles[static_cast<std::size_t>(c.obstacle)]->reference_point());
  }
  rows_.setZero(dense_ + 2 * layout.forces, layout.variables());
  pulled_.setZero(layout.variables());
  term_gradient_.setZero(index.count);
  term_rest_.setZero(index.count);
  term_jacobian_.setZero(terms.residual_count(), index.count);
  gradient.setZero(index.count);
  hessian.setZero(index.count + 2 * layout.forces, index.count + 2 * layout.forces);
  if (layout.palm < 0) return;
  // Every point of the rod moves with its base.
  const auto mark = [&](const BaseIndex::Point& p) {
    rows_(p.x, layout.palm) = -spec.palm->axis.x;
    rows_(p.y, layout.palm) = -spec.palm->axis.y;
  };
  for (const BaseIndex::Contact& contact : index.contacts) mark(contact.point);
  for (const BaseIndex::Point& sample : index.samples) mark(sample);
  if (index.tip.x >= 0) mark(index.tip);
}

BaseQuantities::~BaseQuantities() = default;

void BaseQuantities::move(ConstVectorRef x, const std::vector<PoseProgram::ContactState>& contacts) {
  const auto fill = [this](const BaseIndex::Point& p, int place) {
    values.base[p.x] = places_.point(place).x;
    values.base[p.y] = places_.point(place).y;
    values.base[p.angle] = places_.angle(place);
    if (p.curvature >= 0) values.base[p.curvature] = places_.side(place, 0).curvature;
    if (p.strain >= 0) values.base[p.strain] = places_.side(place, 0).stretch - 1.0;
  };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    fill(index.contacts[k].point, contact_places_[k]);
    values.surfaces[k] = contacts[k].surface;
    values.radii[k] = contacts[k].radius;
  }
  if (tip_place_ >= 0) fill(index.tip, tip_place_);
  for (std::size_t i = 0; i < sample_places_.size(); ++i) fill(index.samples[i], sample_places_[i]);
  if (index.energy >= 0) values.base[index.energy] = places_.energy();
  for (const BaseIndex::Tendon& t : index.tendons) {
    if (t.turn >= 0) values.base[t.turn] = places_.turn_along(t.actuator);
  }
  if (deviations_) values.base.segment(index.deviations.front().x, deviations_->count()) = deviations_->values_at(x);
  for (int b = dense_; b < index.count; ++b) values.base[b] = x[variable(b)];
}

void BaseQuantities::differentiate() {
  const auto fill = [this](const BaseIndex::Point& p, int place) {
    places_.row(place, {1.0, 0.0}, part(p.x));
    places_.row(place, {0.0, 1.0}, part(p.y));
    places_.angle_row(place, part(p.angle));
  };
  for (std::size_t k = 0; k < contact_places_.size(); ++k) fill(index.contacts[k].point, contact_places_[k]);
  if (tip_place_ >= 0) fill(index.tip, tip_place_);
  for (std::size_t i = 0; i < sample_places_.size(); ++i) {
    // The piece that holds a fixed arc length may change when knots move.
    const BaseIndex::Point& p = index.samples[i];
    for (const int r : {p.x, p.y, p.angle, p.curvature}) rows_.row(r).head(first_move_).setZero();
    for (int l = 0; l < places_.arc_lengths(); ++l) rows_(p.curvature, first_move_ + l) = 0.0;
    fill(p, sample_places_[i]);
    const Places::Side side = places_.side(sample_places_[i], 0);
    places_.add_curvature_row(sample_places_[i], side, 1.0, part(p.curvature));
    if (p.strain < 0) continue;
    rows_.row(p.strain).setZero();
    places_.add_stretch_row(sample_places_[i], side, 1.0, part(p.strain));
  }
  for (const BaseIndex::Tendon& t : index.tendons) {
    if (t.turn < 0) continue;
    rows_.row(t.turn).setZero();
    places_.add_turn_row(t.actuator, part(t.turn));
  }
  if (deviations_) rows_.middleRows(index.deviations.front().x, deviations_->count()) = deviations_->rows();
  if (index.energy < 0) return;
  rows_.row(index.energy).setZero();
  places_.add_energy_row(1.0, part(index.energy));
}

void BaseQuantities::differentiate_terms(Eigen::VectorXd& by_x, Eigen::VectorXd& rest, Eigen::MatrixXd& jacobian) {
  terms.differentiate(values, term_gradient_, term_rest_, term_jacobian_);
  by_x.setZero();
  rest.setZero();
  jacobian.setZero();
  const Eigen::Index count = by_x.size();
  for (int b = 0; b < index.count; ++b) {
    const double* row = is_variable(b) ? nullptr : rows_.row(b).data();
    const auto add = [&](double value, double* out, Eigen::Index stride) {
      if (row == nullptr) {
        out[variable(b) * stride] += value;
      } else if (value != 0.0) {
        for (Eigen::Index i = 0; i < count; ++i) out[i * stride] += value * row[i];
      }
    };
    add(term_gradient_[b], by_x.data(), 1);
    add(term_rest_[b], rest.data(), 1);
    for (Eigen::Index r = 0; r < jacobian.rows(); ++r) add(term_jacobian_(r, b), jacobian.data() + r, jacobian.rows());
  }
}

void BaseQuantities::start_second(double sigma) {
  hessian.setZero();
  terms.add_hessian(values, sigma, hessian);
  gradient = sigma * term_gradient_;
}

void BaseQuantities::displace() {
  for (std::size_t k = 0; k < contact_places_.size(); ++k) {
    const int x = displacement(static_cast<int>(k));
    places_.displacement_row(contact_places_[k], {1.0, 0.0}, part(x));
    places_.displacement_row(contact_places_[k], {0.0, 1.0}, part(x + 1));
  }
}

void BaseQuantities::add_pushes(Forces& forces) const {
  const auto add = [&](const BaseIndex::Point& p, int place) {
    Push& push = forces.on[static_cast<std::size_t>(place)];
    push.force += {gradient[p.x], gradient[p.y]};
    push.moment += gradient[p.angle];
    if (p.curvature >= 0) push.bending += gradient[p.curvature];
    if (p.strain >= 0) push.strain += gradient[p.strain];
  };
  for (std::size_t k = 0; k < contact_places_.size(); ++k) add(index.contacts[k].point, contact_places_[k]);
  if (tip_place_ >= 0) add(index.tip, tip_place_);
  for (std::size_t i = 0; i < sample_places_.size(); ++i) add(index.samples[i], sample_places_[i]);
}

void BaseQuantities::add_deviations_second(Eigen::MatrixXd& out) const {
  if (deviations_) deviations_->add_second(gradient.segment(index.deviations.front().x, deviations_->count()), out);
}

void BaseQuantities::set_branch(int contact, Branch branch) {
  if (deviations_) deviations_->set_branch(contact, branch);
}

void BaseQuantities::pull_back(Eigen::MatrixXd& out) {
  const auto total = static_cast<int>(hessian.rows());
  const Eigen::Index count = pulled_.size();
  double* pulled = pulled_.data();
  for (int a = 0; a < total; ++a) {
    std::fill_n(pulled, count, 0.0);
    bool any = false;
    for (int b = 0; b < total; ++b) {
      const double value = hessian(a, b);
      if (value == 0.0) continue;
      any = true;
      if (is_variable(b)) {
        pulled[variable(b)] += value;
      } else {
        const double* row_b = row(b).data();
        for (Eigen::Index i = 0; i < count; ++i) pulled[i] += value * row_b[i];
      }
    }
    if (!any) continue;
    const auto add = [&](Eigen::Index column, double factor) {
      double* to = out.col(column).data();
      for (Eigen::Index i = 0; i < count; ++i) to[i] += factor * pulled[i];
    };
    if (is_variable(a)) {
      add(variable(a), 1.0);
      continue;
    }
    const double* row_a = row(a).data();
    for (Eigen::Index column = 0; column < count; ++column) {
      if (row_a[column] != 0.0) add(column, row_a[column]);
    }
  }
}

}  // namespace tendril
