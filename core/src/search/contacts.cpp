#include "search/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "program/valleys.hpp"
#include "rod/outline.hpp"
#include "search/parameters.hpp"

namespace tendril {
namespace {

/// Contacts of one obstacle in one stretch start at least so far from each other (L).
constexpr double apart = 0.05;

bool same(const ContactSetup& a, const ContactSetup& b) {
  return a.obstacle == b.obstacle && a.at_tip == b.at_tip && a.region == b.region;
}

/// One stretch touches a convex obstacle once, another one wherever it has a place for that.
bool may_repeat(const Task& problem, const ContactSetup& slot) {
  return !slot.at_tip && !problem.obstacles[static_cast<std::size_t>(slot.obstacle)]->convex();
}

class Enumeration {
 public:
  Enumeration(const Task& problem, const std::vector<ContactSetup>& slots, int count, std::size_t at_most)
      : problem_(problem), slots_(slots), count_(count), at_most_(at_most) {}

  /// False: there are more than asked for.
  bool from(std::size_t first) {
    if (!chosen_.empty()) {
      if (all.size() == at_most_) return false;
      all.push_back(chosen_);
    }
    if (static_cast<int>(chosen_.size()) == count_) return true;
    for (std::size_t i = first; i < slots_.size(); ++i) {
      // Within a stretch the order along the rod is part of the choice, so later slots of the same stretch may come
      // first.
      if (!chosen_.empty() && chosen_.back().at_tip) return true;
      const ContactSetup& slot = slots_[i];
      std::size_t next = i + 1;
      if (!slot.at_tip) {
        next = i;
        while (next > 0 && !slots_[next - 1].at_tip && slots_[next - 1].region == slot.region) --next;
      }
      const auto equal = [&](const ContactSetup& c) { return same(c, slot); };
      if (!may_repeat(problem_, slot) && std::any_of(chosen_.begin(), chosen_.end(), equal)) continue;
      chosen_.push_back(slot);
      const bool few = from(next);
      chosen_.pop_back();
      if (!few) return false;
    }
    return true;
  }

  std::vector<std::vector<ContactSetup>> all;

 private:
  const Task& problem_;
  const std::vector<ContactSetup>& slots_;
  int count_;
  std::size_t at_most_;
  std::vector<ContactSetup> chosen_;
};

}  // namespace

bool same_contacts(const std::vector<ContactSetup>& a, const std::vector<ContactSetup>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

std::vector<ContactSetup> contact_slots(int stretches, int obstacles) {
  std::vector<ContactSetup> slots;
  for (int r = 0; r < stretches; ++r) {
    for (int o = 0; o < obstacles; ++o) slots.push_back({o, false, r});
  }
  for (int o = 0; o < obstacles; ++o) slots.push_back({o, true, 0});
  return slots;
}

std::optional<std::vector<std::vector<ContactSetup>>> every_assignment(const Task& problem,
                                                                       const std::vector<ContactSetup>& slots,
                                                                       int count, std::size_t at_most) {
  Enumeration found(problem, slots, count, at_most);
  if (!found.from(0)) return std::nullopt;
  std::stable_sort(found.all.begin(), found.all.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return std::move(found.all);
}

double assignment_count(const Task& problem, int count) {
  const auto stretches = static_cast<int>(problem.rod.fixed_knots().size()) - 1;
  const int obstacles = problem.contact_obstacles;
  int convex = 0;
  for (int o = 0; o < obstacles; ++o) convex += may_repeat(problem, {o, false, 0}) ? 0 : 1;
  // Coefficient k of a product of polynomials is the number of choices with k contacts.
  const auto size = static_cast<std::size_t>(count) + 1;
  std::vector<double> ways(size, 0.0);
  ways[0] = 1.0;
  const auto multiply = [&](const std::vector<double>& by) {
    std::vector<double> product(size, 0.0);
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t k = 0; i + k < size && k < by.size(); ++k) product[i + k] += ways[i] * by[k];
    }
    ways = product;
  };
  // m contacts in any order, k of them with different convex obstacles: choose where these are, which, and the rest.
  std::vector<double> in_a_stretch;
  for (int m = 0; m <= count; ++m) {
    double sum = 0.0;
    double places_and_convex = 1.0;  // binomial(m, k) convex! / (convex - k)!
    for (int k = 0; k <= std::min(m, convex); ++k) {
      sum += places_and_convex * std::pow(obstacles - convex, m - k);
      places_and_convex *= static_cast<double>((m - k) * (convex - k)) / (k + 1);
    }
    in_a_stretch.push_back(sum);
  }
  for (int r = 0; r < stretches; ++r) multiply(in_a_stretch);
  multiply({1.0, static_cast<double>(obstacles)});
  double sum = 0.0;
  for (std::size_t k = 1; k < size; ++k) sum += ways[k];
  return sum;
}

int stretch_at(const Rod& rod, double arc_length) {
  const std::vector<double> knots = rod.fixed_knots();
  const auto after = std::upper_bound(knots.begin() + 1, knots.end() - 1, arc_length);
  return static_cast<int>(after - knots.begin()) - 1;
}

std::vector<Extension> extensions(const Task& problem, const std::vector<ContactSetup>& contacts,
                                  const StartShape& shape) {
  const Rod& rod = problem.rod;
  const auto stretches = rod.fixed_knots().size() - 1;
  std::vector<OutlinePoint> line;
  outline(rod, shape.curvature, 400, line);
  const std::vector<double> knots = rod.fixed_knots();
  /// Nothing: every place is taken by a contact.
  const auto place_of = [&](const ContactSetup& slot) -> std::optional<Valley> {
    const Obstacle& obstacle = *problem.obstacles[static_cast<std::size_t>(slot.obstacle)];
    const OutlinePoint& tip = line.back();
    if (slot.at_tip) return Valley{obstacle.at(tip.position).distance - tip.radius, 1.0};
    const auto region = static_cast<std::size_t>(slot.region);
    for (const Valley& valley : valleys(line, obstacle, std::max(line[1].s, knots[region]), knots[region + 1])) {
      bool taken = false;
      for (std::size_t k = 0; k < contacts.size(); ++k) {
        taken = taken || (same(contacts[k], slot) && std::abs(shape.arc_lengths[k] - valley.arc_length) < apart);
      }
      if (!taken) return valley;
    }
    return std::nullopt;
  };

  const bool has_tip = std::any_of(contacts.begin(), contacts.end(), [](const ContactSetup& c) { return c.at_tip; });
  std::vector<Extension> all;
  for (const ContactSetup& slot : contact_slots(static_cast<int>(stretches), problem.contact_obstacles)) {
    if (slot.at_tip && has_tip) continue;
    const auto equal = [&](const ContactSetup& c) { return same(c, slot); };
    if (!may_repeat(problem, slot) && std::any_of(contacts.begin(), contacts.end(), equal)) continue;
    const std::optional<Valley> place = place_of(slot);
    if (!place) continue;
    std::size_t position = 0;
    while (position < contacts.size()) {
      const ContactSetup& c = contacts[position];
      const bool before =
          slot.at_tip || (!c.at_tip && (c.region < slot.region ||
                                        (c.region == slot.region && shape.arc_lengths[position] < place->arc_length)));
      if (!before) break;
      ++position;
    }
    Extension extension;
    extension.contacts = contacts;
    extension.start = shape;
    extension.distance = place->distance;
    const auto offset = static_cast<std::ptrdiff_t>(position);
    extension.contacts.insert(extension.contacts.begin() + offset, slot);
    extension.start.arc_lengths.insert(extension.start.arc_lengths.begin() + offset,
                                       slot.at_tip ? std::numeric_limits<double>::quiet_NaN() : place->arc_length);
    extension.start.forces.insert(extension.start.forces.begin() + offset, 0.0);
    all.push_back(std::move(extension));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Extension& a, const Extension& b) { return a.distance < b.distance; });
  return all;
}

LeftOut search_note(const Task& problem) {
  const double count = assignment_count(problem, problem.scene.contact.count);
  return {"other contact assignments",
          shown(count, 15) + " ways of assigning up to " + std::to_string(problem.scene.contact.count) +
              " contacts are too many: a heuristic search tries every single contact, then gives the " +
              std::to_string(search_parameters().beam_width) +
              " best plans of each size one more contact at each of the " +
              std::to_string(search_parameters().most_extensions) +
              " obstacles that their rod comes nearest to, in the order in which the rod meets them"};
}

}  // namespace tendril
