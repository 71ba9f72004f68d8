#include <fcntl.h>

#include <cstdlib>

#include "tendril/plugin.hpp"

namespace {

/// Costs nothing and takes the whole process with it where the target lies at more than 0.96 of the length. If
/// TENDRIL_TEST_ONCE names a file: only once, when that file is not there yet.
struct Fragile : tendril::ObjectiveBase<Fragile> {
  tendril::Reads reads() const override {
    tendril::Reads reads;
    reads.target = true;
    return reads;
  }
  template <class T>
  void operator()(const tendril::Quantities<T>& x, tendril::Contribution<T>& out) const {
    if (x.target.position.x > 0.96) {
      const char* once = std::getenv("TENDRIL_TEST_ONCE");
      if (once == nullptr || ::open(once, O_CREAT | O_EXCL | O_WRONLY, 0600) >= 0) std::abort();
    }
    out.smooth(T(0.0));
  }
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  registrar.add(
      tendril::ObjectiveComponent{"fragile", "ends the process for far targets", {}, [](const tendril::Options&) {
                                    return std::make_unique<Fragile>();
                                  }});
}
