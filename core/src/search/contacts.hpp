#pragma once

#include <optional>
#include <string>
#include <vector>

#include "search/task.hpp"

/// Which contact belongs to which obstacle. Few assignments are all tried. Many are searched: no contact, every single
/// contact, then each of the best plans with k contacts gets one more where its rod comes nearest to an obstacle.
namespace tendril {

/// Whether both are the same contacts in the same order along the rod.
bool same_contacts(const std::vector<ContactSetup>& a, const std::vector<ContactSetup>& b);

/// Places for a contact: in each stretch with each obstacle, then at the tip with each obstacle.
std::vector<ContactSetup> contact_slots(int stretches, int obstacles);

/// Every ordered choice of 1 to `count` contacts, small ones first: interior ones by ascending stretch, within a
/// stretch in any order, with a convex obstacle one at most; a tip contact last. Where on an obstacle a contact is, is
/// no choice: it slides there. Empty if there are more than `at_most`.
std::optional<std::vector<std::vector<ContactSetup>>> every_assignment(const Task& problem,
                                                                       const std::vector<ContactSetup>& slots,
                                                                       int count, std::size_t at_most);

/// How many choices every_assignment() would give for all slots.
double assignment_count(const Task& problem, int count);

/// An assignment with one contact more, and where a search for it starts.
struct Extension {
  std::vector<ContactSetup> contacts;
  StartShape start;
  double distance = 0.0;  ///< of the rod of the start to the new contact's obstacle
};

/// Everything that can be added to `contacts`, the nearest obstacles of the rod `shape` first. The order along the rod
/// is that of the rod.
std::vector<Extension> extensions(const Task& problem, const std::vector<ContactSetup>& contacts,
                                  const StartShape& shape);

/// The stretch that holds an arc length.
int stretch_at(const Rod& rod, double arc_length);

/// What the search leaves out, for the report.
LeftOut search_note(const Task& problem);

}  // namespace tendril
