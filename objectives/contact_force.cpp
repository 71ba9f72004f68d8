#include "tendril/plugin.hpp"

namespace {

using namespace tendril;

/// A reward for contact force, -f summed over the contacts (paper, Eq. 5 and 6).
class ContactForce : public ObjectiveBase<ContactForce> {
 public:
  Reads reads() const override { return {.contact_force = true}; }
  double lower_bound() const override { return -infinity; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    for (const ContactQuantities<T>& contact : x.contacts) out.smooth(-contact.force);
  }
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  registrar.add(
      ObjectiveComponent{"contact_force", "large contact forces: -f, summed over the contacts", {}, [](const Options&) {
                           return std::make_unique<ContactForce>();
                         }});
}
