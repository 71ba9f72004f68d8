#include "tendril/plugin.hpp"

namespace {

using namespace tendril;

/// The force on a grasp's object along the axis of symmetry, away from the palm (paper, Eq. 6): -f n_x summed over the
/// contacts, either squared or, as the paper has it, as it is. The linear form has no lower bound of its own.
class GraspBalance : public ObjectiveBase<GraspBalance> {
 public:
  explicit GraspBalance(bool square) : square_(square) {}

  Reads reads() const override { return {.contact_normal = true, .contact_force = true, .mirrored = square_}; }
  double lower_bound() const override { return square_ ? 0.0 : -infinity; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    T force{};
    for (const ContactQuantities<T>& contact : x.contacts) force -= contact.force * contact.normal_x;
    if (square_) {
      out.residual(force);
    } else {
      out.smooth(force);
    }
  }

 private:
  bool square_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "form",
                              .type = OptionType::text,
                              .default_value = std::string("square"),
                              .description = "the force squared, or as it is",
                              .choices = {"square", "linear"}}};
  registrar.add(ObjectiveComponent{
      "grasp_balance", "no force on the object along a grasp's axis of symmetry", options,
      [](const Options& given) { return std::make_unique<GraspBalance>(given.text("form") == "square"); }});
}
