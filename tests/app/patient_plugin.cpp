#include <signal.h>

#include <chrono>
#include <thread>

#include "tendril/plugin.hpp"

namespace {

/// Presses Ctrl-C itself, so that no test depends on how fast the command starts, and then waits until it is told to
/// stop.
class Patient : public tendril::Solver {
 public:
  explicit Patient(std::int64_t interrupts) : interrupts_(interrupts) {}
  std::string name() const override { return "patient"; }
  tendril::SolverCapabilities capabilities() const override { return {}; }

 protected:
  Outcome do_solve(Callbacks& callbacks, const Start& start, const tendril::SolveControl&) override {
    for (; interrupts_ > 0; --interrupts_) ::raise(SIGINT);
    while (!callbacks.must_stop()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Outcome outcome;
    outcome.status = tendril::SolveStatus::interrupted;
    outcome.x.assign(start.x.begin(), start.x.end());
    return outcome;
  }

 private:
  std::int64_t interrupts_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  tendril::OptionSpec interrupts;
  interrupts.name = "interrupts";
  interrupts.type = tendril::OptionType::integer;
  interrupts.default_value = std::int64_t{1};
  registrar.add(tendril::SolverComponent{
      "patient", "waits until it is told to stop", {interrupts}, [](const tendril::Options& options) {
        return std::make_unique<Patient>(options.integer("interrupts"));
      }});
}
