#include <array>

#include "tendril/plugin.hpp"
#include "tendril/weight_matrix.hpp"

namespace {

using namespace tendril;

/// (P_o - P_c)^T Qc (P_o - P_c) over the contacts, P_o the obstacle's reference point (paper, Eq. 5 and 6).
class ContactProximity : public ObjectiveBase<ContactProximity> {
 public:
  explicit ContactProximity(const NumberTable& weights) : root_(weight_root(weights, 2, "weights")) {}

  Reads reads() const override { return {.contact_point = true}; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    for (const ContactQuantities<T>& contact : x.contacts) {
      const std::array<T, 2> apart{contact.reference_x - contact.x, contact.reference_y - contact.y};
      add_weighted<T>(root_, apart, out);
    }
  }

 private:
  NumberTable root_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "weights",
                              .type = OptionType::matrix,
                              .default_value = NumberTable{1, 1, {1.0}},
                              .description = "Qc: a number, weights for x and y, or a 2 x 2 matrix"}};
  registrar.add(ObjectiveComponent{
      "contact_proximity", "contacts near the obstacle's reference point", options,
      [](const Options& given) { return std::make_unique<ContactProximity>(given.table("weights")); }});
}
