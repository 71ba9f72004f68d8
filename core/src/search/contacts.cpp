#include "search/contacts.hpp"

#include <algorithm>
#include <limits>

#include "rod/outline.hpp"
#include "search/parameters.hpp"

namespace tendril {
namespace {

bool same(const ContactSetup& a, const ContactSetup& b) {
  return a.obstacle == b.obstacle && a.at_tip == b.at_tip && a.region == b.region;
}

/// False: more than `at_most`.
bool enumerate(const std::vector<ContactSetup>& slots, std::size_t from, int count, std::size_t at_most,
               std::vector<ContactSetup>& chosen, std::vector<std::vector<ContactSetup>>& out) {
  if (!chosen.empty()) {
    if (out.size() == at_most) return false;
    out.push_back(chosen);
  }
  if (static_cast<int>(chosen.size()) == count) return true;
  for (std::size_t i = from; i < slots.size(); ++i) {
    // Within a stretch the order along the rod is part of the choice, so later slots of the same stretch may come
    // first.
    if (!chosen.empty() && chosen.back().at_tip) return true;
    std::size_t next = i + 1;
    if (!slots[i].at_tip) {
      next = i;
      while (next > 0 && !slots[next - 1].at_tip && slots[next - 1].region == slots[i].region) --next;
    }
    if (std::any_of(chosen.begin(), chosen.end(), [&](const ContactSetup& c) { return same(c, slots[i]); })) continue;
    chosen.push_back(slots[i]);
    const bool few = enumerate(slots, next, count, at_most, chosen, out);
    chosen.pop_back();
    if (!few) return false;
  }
  return true;
}

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

std::optional<std::vector<std::vector<ContactSetup>>> every_assignment(const std::vector<ContactSetup>& slots,
                                                                       int count, std::size_t at_most) {
  std::vector<std::vector<ContactSetup>> all;
  std::vector<ContactSetup> chosen;
  if (!enumerate(slots, 0, count, at_most, chosen, all)) return std::nullopt;
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return all;
}

double assignment_count(int stretches, int obstacles, int count) {
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
  std::vector<double> in_a_stretch{1.0};  // m different obstacles in any order
  for (int m = 1; m <= std::min(count, obstacles); ++m)
    in_a_stretch.push_back(in_a_stretch.back() * (obstacles - m + 1));
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
  struct Nearest {
    double distance = infinity;
    double arc_length = 0.0;
  };
  std::vector<std::vector<Nearest>> nearest(problem.obstacles.size(), std::vector<Nearest>(stretches));
  std::vector<double> of_tip;
  std::vector<OutlinePoint> line;
  outline(rod, shape.curvature, 400, line);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double s = line[i].s;
    const auto stretch = static_cast<std::size_t>(stretch_at(rod, s));
    for (std::size_t o = 0; o < problem.obstacles.size(); ++o) {
      const double distance = problem.obstacles[o]->at(line[i].position).distance - line[i].radius;
      if (distance < nearest[o][stretch].distance) nearest[o][stretch] = {distance, s};
      if (i + 1 == line.size()) of_tip.push_back(distance);
    }
  }

  const bool has_tip = std::any_of(contacts.begin(), contacts.end(), [](const ContactSetup& c) { return c.at_tip; });
  std::vector<Extension> all;
  for (const ContactSetup& slot : contact_slots(static_cast<int>(stretches), problem.contact_obstacles)) {
    if (slot.at_tip && has_tip) continue;
    if (std::any_of(contacts.begin(), contacts.end(), [&](const ContactSetup& c) { return same(c, slot); })) continue;
    const auto o = static_cast<std::size_t>(slot.obstacle);
    const Nearest place = slot.at_tip ? Nearest{of_tip[o], 1.0} : nearest[o][static_cast<std::size_t>(slot.region)];
    std::size_t position = 0;
    while (position < contacts.size()) {
      const ContactSetup& c = contacts[position];
      const bool before =
          slot.at_tip || (!c.at_tip && (c.region < slot.region ||
                                        (c.region == slot.region && shape.arc_lengths[position] < place.arc_length)));
      if (!before) break;
      ++position;
    }
    Extension extension;
    extension.contacts = contacts;
    extension.start = shape;
    extension.distance = place.distance;
    const auto offset = static_cast<std::ptrdiff_t>(position);
    extension.contacts.insert(extension.contacts.begin() + offset, slot);
    extension.start.arc_lengths.insert(extension.start.arc_lengths.begin() + offset,
                                       slot.at_tip ? std::numeric_limits<double>::quiet_NaN() : place.arc_length);
    extension.start.forces.insert(extension.start.forces.begin() + offset, 0.0);
    all.push_back(std::move(extension));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Extension& a, const Extension& b) { return a.distance < b.distance; });
  return all;
}

LeftOut search_note(const Task& problem) {
  const int stretches = static_cast<int>(problem.rod.fixed_knots().size()) - 1;
  const double count = assignment_count(stretches, problem.contact_obstacles, problem.scene.contact.count);
  return {"other contact assignments",
          shown(count, 15) + " ways of assigning up to " + std::to_string(problem.scene.contact.count) +
              " contacts are too many: a heuristic search tries every single contact, then gives the " +
              std::to_string(search_parameters().beam_width) +
              " best plans of each size one more contact at each of the " +
              std::to_string(search_parameters().most_extensions) +
              " obstacles that their rod comes nearest to, in the order in which the rod meets them"};
}

}  // namespace tendril
