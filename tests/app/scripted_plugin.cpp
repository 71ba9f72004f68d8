#include "tendril/plugin.hpp"

namespace {

/// Ends every solve where it started, with the status that its option names.
class Scripted : public tendril::Solver {
 public:
  explicit Scripted(std::string status) : status_(std::move(status)) {}
  std::string name() const override { return "scripted"; }
  tendril::SolverCapabilities capabilities() const override { return {}; }

 protected:
  Outcome do_solve(Callbacks&, const Start& start, const tendril::SolveControl&) override {
    Outcome outcome;
    outcome.status = status_ == "diverged" ? tendril::SolveStatus::diverged : tendril::SolveStatus::failed;
    outcome.message = "as its option says";
    outcome.x.assign(start.x.begin(), start.x.end());
    return outcome;
  }

 private:
  std::string status_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  tendril::OptionSpec status;
  status.name = "status";
  status.type = tendril::OptionType::text;
  status.default_value = std::string("failed");
  registrar.add(
      tendril::SolverComponent{"scripted", "ends as its option says", {status}, [](const tendril::Options& options) {
                                 return std::make_unique<Scripted>(options.text("status"));
                               }});
}
