#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "tendril/plugin.hpp"

namespace {

/// Costs nothing. In the case of the number that TENDRIL_TEST_INTERRUPT says, counted from one over those of its
/// process, it presses Ctrl-C for the study that this process works for, and waits to be ended.
class Interrupting : public tendril::ObjectiveBase<Interrupting> {
 public:
  tendril::Reads reads() const override {
    tendril::Reads reads;
    reads.target = true;
    return reads;
  }
  template <class T>
  void operator()(const tendril::Quantities<T>& x, tendril::Contribution<T>& out) const {
    static int cases = 0;
    static tendril::Vec2 last{std::numeric_limits<double>::quiet_NaN(), 0.0};
    if (x.target.position != last) {
      last = x.target.position;
      const char* number = std::getenv("TENDRIL_TEST_INTERRUPT");
      if (number != nullptr && ++cases == std::atoi(number)) {
        ::kill(::getppid(), SIGINT);
        ::sleep(60);
      }
    }
    out.smooth(T(0.0));
  }
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  registrar.add(tendril::ObjectiveComponent{
      "interrupting", "interrupts a study in one of its cases", {}, [](const tendril::Options&) {
        return std::make_unique<Interrupting>();
      }});
}
