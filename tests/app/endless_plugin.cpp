#include <chrono>
#include <thread>

#include "tendril/plugin.hpp"

namespace {

class Endless : public tendril::Solver {
 public:
  std::string name() const override { return "endless"; }
  tendril::SolverCapabilities capabilities() const override { return {}; }

 protected:
  Outcome do_solve(Callbacks&, const Start&, const tendril::SolveControl&) override {
    while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
  }
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  registrar.add(tendril::SolverComponent{
      "endless", "never returns", {}, [](const auto&) { return std::make_unique<Endless>(); }});
}
