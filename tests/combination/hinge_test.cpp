// A cost that is 0 wherever a limit is kept has to be seen by every solver, although most points do not show it.

#include "support.hpp"

namespace tendril::combination {
namespace {

/// The square of what the tip's angle has above a limit. Below it there is nothing: a term that is not even mentioned,
/// or one of 0.
class AngleBelow : public ObjectiveBase<AngleBelow> {
 public:
  AngleBelow(double limit, bool mentioned) : limit_(limit), mentioned_(mentioned) {}
  Reads reads() const override { return {.tip_angle = true}; }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    const T excess = x.tip.angle - limit_;
    if (excess > T(0.0)) {
      out.smooth(excess * excess);
    } else if (mentioned_) {
      out.smooth(T(0.0));
    }
  }

 private:
  double limit_;
  bool mentioned_;
};

/// The free arm with a limit to its tip's angle.
Plan plan_below(double limit, bool mentioned, const std::string& solver) {
  Scene made = scene("free", {"solver.plugin=\"" + solver + "\""});
  ObjectiveSpec hinge = made.objectives.back();
  hinge.weight = 1e3;
  made.objectives.push_back(hinge);
  Components components = plugins::make_components(registry(), made);
  components.terms.back() = std::make_unique<AngleBelow>(limit, mentioned);
  return Problem(made, std::move(components)).plan();
}

TEST(Hinge, IsSeenByEverySolverWhereverItAppears) {
  // The plan without a limit ends at 0.23: shapes that bend less than to 0.17 show nothing of the limit.
  const double limit = plan(scene("free")).tip_angle - 0.06;
  ASSERT_GT(limit, 0.16);
  for (const bool mentioned : {false, true}) {
    const Plan first = plan_below(limit, mentioned, solvers_to_combine().front());
    EXPECT_GT(first.tip_angle, limit);
    EXPECT_LT(first.tip_angle, limit + 0.03);
    for (const std::string& solver : solvers_to_combine()) {
      SCOPED_TRACE(solver);
      const Plan found = plan_below(limit, mentioned, solver);
      EXPECT_TRUE(certified(found));
      // The solver itself came there, not what the search does for one that did not.
      EXPECT_EQ(found.solver.status, SolveStatus::converged) << found.solver.message;
      EXPECT_NEAR(found.objective, first.objective, 1e-6 * (1.0 + first.objective));
      EXPECT_NEAR(found.tip_angle, first.tip_angle, 1e-5);
    }
  }
}

}  // namespace
}  // namespace tendril::combination
