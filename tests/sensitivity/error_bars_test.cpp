// Error bars of scenes against Monte Carlo: the same moments carried out in many scenes.

#include "scene/error_bars.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planned.hpp"
#include "support/repetitions.hpp"

namespace tendril::app::test {
namespace {

const Settings uncertain{{"rod.bending_stiffness", "4.9e-4 N m^2 +- 3 %"},
                         {"obstacle[0].radius", "8 mm +- 0.1 mm"},
                         {"rod.linear_density", "84 g/m +- 2 g/m"}};

TEST(ErrorBars, AreReadInUnitsAndShares) {
  Session session(arguments_of(arm, uncertain));
  const std::vector<Spread> spreads = error_bars(session.document(), session.scene());
  ASSERT_EQ(spreads.size(), 3U);
  EXPECT_EQ(spreads[0].key, "rod.bending_stiffness");
  EXPECT_DOUBLE_EQ(spreads[0].deviation, 0.03 * 4.9e-4);
  EXPECT_DOUBLE_EQ(spreads[1].deviation, 2e-3);
  EXPECT_DOUBLE_EQ(spreads[2].deviation, 1e-4);
  EXPECT_EQ(session.scene().rod.segments[0].bending_stiffness, 4.9e-4);
}

TEST(ErrorBars, OfTheWrongKindAreRefusedWithTheirPlace) {
  for (const std::string text : {"8 mm +- 0.1 kg", "8 mm +- -1 %", "8 mm +- 3 % of it", "8 mm +- much"}) {
    EXPECT_THROW(Session(arguments_of(arm, {{"obstacle[0].radius", text}})), InputError) << text;
  }
  EXPECT_THROW(Session(arguments_of(arm, {{"solver.time_limit", "10 s +- 1 s"}})), InputError);
}

TEST(ErrorBars, AgreeWithMonteCarloOfExecutions) {
  Session session(arguments_of(arm, uncertain));
  const Plan plan = session.plan(std::nullopt);
  const Plan reached = session.execute(plan.moments, plan).result;
  const std::vector<Uncertainty> bars = session.run_info().uncertainties;
  ASSERT_EQ(bars.size(), 1U);
  ASSERT_EQ(bars[0].trouble, "");
  EXPECT_EQ(bars[0].warning, "");
  const int draws = repetitions(400);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Scene scene = session.scene();
  const auto obstacles = session.make_obstacles();
  const auto values_of = [](const Plan& there) {
    std::vector<double> values = quantities(there, false);
    values.push_back(there.certificate.stability);
    return values;
  };
  const std::size_t count = bars[0].deviations.size();
  const std::vector<double> exact = values_of(reached);
  std::vector<double> sum(count), squares(count);
  Session other(arguments_of(arm, {}));
  for (int i = 0; i < draws; ++i) {
    Scene drawn = scene;
    drawn.rod.segments[0].bending_stiffness *= 1.0 + 0.03 * normal(random);
    drawn.rod.segments[0].linear_density += 2e-3 * normal(random);
    drawn.obstacles[0].options["radius"] = RawValue{8e-3 + 1e-4 * normal(random)};
    other.use(drawn);
    const std::vector<double> values = values_of(other.execute(plan.moments, reached).result);
    ASSERT_EQ(values.size(), count);
    for (std::size_t k = 0; k < count; ++k) {
      const double off = values[k] - exact[k];
      sum[k] += off;
      squares[k] += off * off;
    }
  }
  // The standard deviation of draws has a relative error of 1 / sqrt(2 (draws - 1)): four of them, and no less than 10
  // %.
  const double within = std::max(0.1, 4.0 / std::sqrt(2.0 * (draws - 1)));
  for (std::size_t k = 0; k < count; ++k) {
    const double drawn = std::sqrt((squares[k] - sum[k] * sum[k] / draws) / (draws - 1));
    EXPECT_NEAR(bars[0].deviations[k].value, drawn, within * drawn) << bars[0].deviations[k].name;
    RecordProperty(bars[0].deviations[k].name, std::to_string(bars[0].deviations[k].value / drawn));
  }
}

TEST(ErrorBars, HaveSharesThatSumToOne) {
  Session session(arguments_of(arm, uncertain));
  session.plan(std::nullopt);
  const Uncertainty bars = session.run_info().uncertainties.at(0);
  ASSERT_EQ(bars.shares.size(), 3U);
  double tip = 0.0;
  for (const Uncertainty::Share& share : bars.shares) tip += share.tip;
  EXPECT_NEAR(tip, 1.0, 1e-12);
  EXPECT_EQ(bars.kind, SensitivityKind::held);
  // The last point of the shape is the tip.
  EXPECT_NEAR(std::sqrt(bars.shape.back().xx), bars.deviations[0].value, 1e-15);
}

/// What a scene says of the correlation of its stiffness with another number.
std::string correlated(double value, const std::string& other = "obstacle[0].radius") {
  return "[[correlation]]\nbetween = [\"rod.bending_stiffness\", \"" + other + "\"]\nvalue = " + std::to_string(value) +
         '\n';
}

// Variances of sums: both alone, and twice the product of their deviations times the correlation.
TEST(ErrorBars, OfNumbersThatGoTogetherAddUp) {
  const auto bars = [](const std::string& more) {
    Session session(arguments_of(arm + more, {uncertain.begin(), uncertain.begin() + 2}));
    session.plan(std::nullopt);
    return session.run_info().uncertainties.at(0);
  };
  const Uncertainty apart = bars(""), sum = bars(correlated(0.6)), difference = bars(correlated(-0.6));
  for (std::size_t i = 0; i < apart.deviations.size(); ++i) {
    const double alone = std::pow(apart.deviations[i].value, 2);
    const double shared = alone * std::sqrt(apart.shares[0].each[i] * apart.shares[1].each[i]);
    const double more = std::pow(sum.deviations[i].value, 2) - alone;
    EXPECT_NEAR(std::abs(more), 1.2 * shared, 1e-9 * alone) << apart.deviations[i].name;
    EXPECT_NEAR(std::pow(difference.deviations[i].value, 2) - alone, -more, 1e-9 * alone);
    EXPECT_NEAR(sum.shares[0].each[i] + sum.shares[1].each[i], 1.0, 1e-12);
  }
}

TEST(ErrorBars, CorrelationsOfNothingAreRefused) {
  for (const std::string& text :
       {correlated(1.5), correlated(0.5, "rod.lenght"), correlated(0.5, "rod.bending_stiffness")}) {
    EXPECT_THROW(Session(arguments_of(arm + text, uncertain)), InputError) << text;
  }
}

// The moment that a held pressure gives follows its law.
TEST(ErrorBars, OfAPressuresLawMoveTheMoment) {
  Session session(arguments_of(arm, {{"rod.actuator[0].moment_per_pressure", "1e-7 N m/Pa +- 10 %"}}));
  const Plan plan = session.plan(std::nullopt);
  const Uncertainty bars = session.run_info().uncertainties.at(0);
  ASSERT_EQ(bars.trouble, "");
  const Sensitivity held = session.sensitivity(plan, SensitivityKind::held);
  const std::vector<double>& by_moment = held.find("moments[0]")->rates;
  for (std::size_t i = 0; i < by_moment.size(); ++i) {
    EXPECT_NEAR(bars.deviations[i].value, std::abs(0.1 * plan.moments[0] * by_moment[i]),
                1e-9 * bars.deviations[i].value);
  }
}

TEST(ErrorBars, OfAContactThatMayComeOffSaySo) {
  const auto warning_of = [](const std::string& error) {
    Session session(arguments_of(arm, {{"obstacle[0].radius", "8 mm +- " + error}}));
    session.plan(std::nullopt);
    return session.run_info().uncertainties.at(0).warning;
  };
  EXPECT_EQ(warning_of("0.1 mm"), "");
  const std::string far = warning_of("5 mm");
  EXPECT_NE(far.find("contacts[0].force is"), std::string::npos) << far;
  EXPECT_NE(far.find("the contact may come off, and these numbers"), std::string::npos) << far;
}

// A straight column under its own weight keeps its shape, whatever its stiffness, until it buckles: the margin alone
// tells.
TEST(ErrorBars, OfAColumnShortlyBeforeItBucklesAreToldNotToHold) {
  const std::string column = R"(
problem = "execute"
gravity = [0, "-9.81 m/s^2"]
[rod]
length = "100 mm"
bending_stiffness = "1e-4 N m^2 +- 5 %"
linear_density = "70 g/m"
base = {angle = "90 deg"}
)";
  const auto bars_of = [&](const Settings& settings) {
    Session session(arguments_of(column, settings));
    const Plan plan = session.execute(std::vector<double>{}, std::nullopt).result;
    EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
    return std::pair(plan.certificate.stability, session.run_info().uncertainties.at(0));
  };
  const auto [margin, bars] = bars_of({});
  // The margin is 1 less what goes with weight by stiffness.
  EXPECT_EQ(bars.deviations.back().name, "stability");
  EXPECT_NEAR(bars.deviations.back().value, 0.05 * (1.0 - margin), 1e-6);
  EXPECT_LT(margin, 3.0 * bars.deviations.back().value);
  EXPECT_NE(bars.warning.find("snap"), std::string::npos) << bars.trouble;
  EXPECT_EQ(bars_of({{"rod.linear_density", "20 g/m"}}).second.warning, "");
}

// A heavy upright rod shortly before it snaps through: the linear error bars are told to fail.
TEST(ErrorBars, NextToASnapAreToldNotToHold) {
  SceneArguments arguments{std::string(TENDRIL_SCENES) + "/snap_through.toml", {}, {}, {}};
  const Session first(arguments);
  arguments.overrides.push_back(
      {"set", "rod.bending_stiffness", written_value(first.document(), "rod.bending_stiffness") + " +- 2 %"});
  Session session(arguments);
  const std::vector<double> up{0.1}, down{-0.0299};
  const Plan before = session.execute(up, std::nullopt).result;
  const Plan near = session.execute(down, before).result;
  ASSERT_EQ(near.status, PlanStatus::solved) << near.message;
  const Uncertainty bars = session.run_info().uncertainties.at(0);
  EXPECT_NE(bars.warning.find("snap"), std::string::npos) << bars.trouble;
}

}  // namespace
}  // namespace tendril::app::test
