// Derivatives by the implicit function theorem against plans and executions of scenes with other numbers.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planned.hpp"
#include "scene/error_bars.hpp"

namespace tendril::app::test {
namespace {

struct Case {
  std::string name;
  Settings settings;
  std::vector<std::string> keys;
  bool executed = true;  ///< whether held moments are looked at as well
};

std::ostream& operator<<(std::ostream& os, const Case& c) { return os << c.name; }

const std::vector<std::string> every_key{"gravity[0]",
                                         "gravity[1]",
                                         "rod.length",
                                         "rod.bending_stiffness",
                                         "rod.linear_density",
                                         "rod.rest_curvature",
                                         "rod.base.position[0]",
                                         "rod.base.position[1]",
                                         "rod.base.angle",
                                         "tip_load.mass",
                                         "tip_load.force[0]",
                                         "tip_load.force[1]",
                                         "obstacle[0].center[0]",
                                         "obstacle[0].center[1]",
                                         "obstacle[0].radius",
                                         "target.position[0]",
                                         "target.position[1]",
                                         "objective[0].weight",
                                         "objective[1].weight",
                                         "rod.actuator[0].limit"};
const std::vector<std::string> some_keys{"rod.length", "rod.bending_stiffness", "obstacle[0].radius",
                                         "obstacle[0].center[0]", "rod.base.angle"};

std::vector<Case> cases() {
  return {{"FreeMoment", {}, every_key},
          {"MomentAtItsLimit", {{"rod.actuator[0].limit", "2.5 N mm"}}, every_key},
          {"ForceAtItsLimit",
           {{"contact.max_force", "0.06 N"}},
           {"contact.max_force", "rod.length", "rod.bending_stiffness", "obstacle[0].radius"},
           false},
          {"Pcc", {{"coordinates.plugin", "pcc"}}, some_keys, false},
          {"Whole", {{"coordinates.split_at_contact", "false"}}, some_keys, false},
          {"Thick",
           {{"rod.thickness", "4 mm"}},
           {"rod.thickness", "rod.length", "rod.base.angle", "obstacle[0].radius", "obstacle[0].center[1]"}},
          {"NearTheObstacle",
           {{"objective[1].plugin", "contact_proximity"},
            {"objective[1].weight", "30"},
            {"rod.actuator[0].limit", "4 N mm"}},
           some_keys,
           false},
          {"WithoutContact",
           {{"contact.mode", "ignore"}},
           {"rod.length", "rod.bending_stiffness", "rod.linear_density", "rod.base.angle", "target.position[0]"},
           false},
          {"HeldOff",
           {{"contact.mode", "avoid"}},
           {"rod.length", "obstacle[0].radius", "obstacle[0].center[0]", "rod.base.angle", "rod.linear_density"},
           false}};
}

Settings changed(Settings settings, const std::string& key, const std::string& text) {
  settings.push_back({key, text});
  return settings;
}

/// By five points: steps of 1e-3 leave 1e-12 of truncation, and rounding of plans 1e-9. In units of the text.
template <class Run>
std::vector<double> by_differences(const std::string& text, const Run& run) {
  const double value = std::stod(text);
  const double step = 1e-3 * std::abs(value);
  const auto at = [&](int steps) { return run(with_number(text, value + steps * step)); };
  const std::vector<double> a = at(-2), b = at(-1), c = at(1), d = at(2);
  std::vector<double> out;
  for (std::size_t i = 0; i < a.size(); ++i) {
    out.push_back((a[i] - 8.0 * b[i] + 8.0 * c.at(i) - d.at(i)) / (12.0 * step));
  }
  return out;
}

/// All quantities by a key, per unit of its text.
std::vector<double> by_key(const Session& session, const Sensitivity& all, const std::string& key, double unit) {
  std::vector<double> out(all.quantities.size());
  for (const Spread::Part& part : spread_of(session.document(), session.scene(), key).parts) {
    const Sensitivity::Column* column = all.find(part.key);
    if (column == nullptr || !column->trouble.empty()) {
      ADD_FAILURE() << key << ": " << (column == nullptr ? "no column" : column->trouble);
      return out;
    }
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += unit * part.rate * column->rates[i];
  }
  return out;
}

double margin_by_key(const Session& session, const Sensitivity& all, const std::string& key, double unit) {
  double out = 0.0;
  for (const Spread::Part& part : spread_of(session.document(), session.scene(), key).parts) {
    out += unit * part.rate * all.find(part.key)->margin;
  }
  return out;
}

void expect_same(const Sensitivity& all, const std::vector<double>& exact, const std::vector<double>& differences,
                 double value, const std::string& key) {
  ASSERT_EQ(exact.size(), differences.size()) << key;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    // Relative, and to what is not told from rounding: 1e-2 of the quantity per share of the number.
    const double size = std::abs(differences[i]) + 1e-2 * std::abs(all.quantities[i].value / value);
    EXPECT_NEAR(exact[i], differences[i], 1e-6 * size) << all.quantities[i].name << " by " << key;
  }
}

class Derivatives : public testing::TestWithParam<Case> {};

TEST_P(Derivatives, OfPlansAreThoseOfOtherPlans) {
  const Case& c = GetParam();
  Session session(arguments_of(arm, c.settings));
  const Plan plan = session.plan(std::nullopt);
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  const Sensitivity all = session.sensitivity(plan, SensitivityKind::replanned);
  ASSERT_EQ(all.trouble, "");
  for (const std::string& key : c.keys) {
    const std::string text = written_value(session.document(), key);
    const std::vector<double> differences = by_differences(text, [&](const std::string& other) {
      Session again(arguments_of(arm, changed(c.settings, key, other)));
      const Plan next = again.plan_from(&plan, false);
      EXPECT_EQ(next.status, PlanStatus::solved) << key << ": " << next.message;
      return quantities(next, true);
    });
    expect_same(all, by_key(session, all, key, unit_of(text)), differences, std::stod(text), key);
  }
}

TEST_P(Derivatives, UnderHeldMomentsAreThoseOfExecutions) {
  const Case& c = GetParam();
  if (!c.executed) return;
  Session session(arguments_of(arm, c.settings));
  const Plan plan = session.plan(std::nullopt);
  const Plan executed = session.execute(plan.moments, plan).result;
  ASSERT_EQ(executed.status, PlanStatus::solved) << executed.message;
  const Sensitivity all = sensitivity_of(session.scene(), session.make_obstacles(), executed);
  ASSERT_EQ(all.trouble, "");
  const Sensitivity planned = session.sensitivity(plan, SensitivityKind::held);
  for (const std::string& key : c.keys) {
    if (key.starts_with("target") || key.starts_with("objective") || key.ends_with("limit")) continue;
    const std::string text = written_value(session.document(), key);
    std::vector<double> differences = by_differences(text, [&](const std::string& other) {
      Session again(arguments_of(arm, changed(c.settings, key, other)));
      const Plan there = again.execute(plan.moments, executed).result;
      std::vector<double> values = quantities(there, false);
      values.push_back(there.certificate.stability);
      return values;
    });
    const double margin = margin_by_key(session, all, key, unit_of(text));
    EXPECT_NEAR(margin, differences.back(), 1e-6 * (std::abs(margin) + std::abs(all.margin / std::stod(text)))) << key;
    differences.pop_back();
    const std::vector<double> exact = by_key(session, all, key, unit_of(text));
    expect_same(all, exact, differences, std::stod(text), key);
    // The plan's own basis is coarser.
    const std::vector<double> coarse = by_key(session, planned, key, unit_of(text));
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double size = std::abs(exact[i]) + 1e-2 * std::abs(all.quantities[i].value / std::stod(text));
      EXPECT_NEAR(coarse[i], exact[i], 2e-3 * size) << all.quantities[i].name << " by " << key;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sensitivity, Derivatives, testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

TEST(HeldMoments, AreNumbersToo) {
  Session session(arguments_of(arm, {}));
  const Plan plan = session.plan(std::nullopt);
  const Plan executed = session.execute(plan.moments, plan).result;
  const Sensitivity all = sensitivity_of(session.scene(), session.make_obstacles(), executed, {"moments[0]"});
  ASSERT_EQ(all.columns.size(), 1U);
  const double step = 1e-3 * plan.moments[0];
  const auto at = [&](int steps) {
    const std::vector<double> moments{plan.moments[0] + steps * step};
    return quantities(session.execute(moments, executed).result, false);
  };
  const std::vector<double> a = at(-2), b = at(-1), c = at(1), d = at(2);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * step);
    EXPECT_NEAR(all.columns[0].rates[i], difference, 1e-6 * std::abs(difference)) << all.quantities[i].name;
  }
}

TEST(KeysOfTheScene, ThatARodIsMadeOfAreDifferentiatedThroughIt) {
  std::string text = arm;
  const std::string by_numbers = "bending_stiffness = \"4.9e-4 N m^2\"\nlinear_density = \"84 g/m\"\n";
  text.replace(text.find(by_numbers), by_numbers.size(),
               "youngs_modulus = \"1 MPa\"\ndensity = \"1070 kg/m^3\"\ndiameter = \"10 mm\"\n");
  Session session(arguments_of(text, {}));
  const Plan plan = session.plan(std::nullopt);
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  const Sensitivity all = session.sensitivity(plan, SensitivityKind::replanned);
  for (const std::string key : {"rod.youngs_modulus", "rod.density", "rod.diameter"}) {
    const std::string value = written_value(session.document(), key);
    const std::vector<double> differences = by_differences(value, [&](const std::string& other) {
      Session again(arguments_of(text, {{key, other}}));
      return quantities(again.plan_from(&plan, false), true);
    });
    expect_same(all, by_key(session, all, key, unit_of(value)), differences, std::stod(value), key);
  }
}

TEST(MovedBase, IsDifferentiatedWhereItIsHeld) {
  const Settings turned{{"rod.base.angle_range", "[\"1 deg\", \"8 deg\"]"}};
  Session session(arguments_of(arm, turned));
  const Plan plan = session.plan(std::nullopt);
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_TRUE(plan.place.base);
  EXPECT_GT(std::abs(plan.place.base->angle - 0.0523598775598299), 1e-3);
  const Plan executed = session.execute(plan.moments, plan, std::nullopt, plan.place).result;
  ASSERT_EQ(executed.status, PlanStatus::solved) << executed.message;
  const Sensitivity all = sensitivity_of(session.scene(), session.make_obstacles(), executed);
  ASSERT_EQ(all.trouble, "");
  const Sensitivity planned = session.sensitivity(plan, SensitivityKind::held);
  ASSERT_EQ(planned.trouble, "");
  for (const std::string key : {"rod.bending_stiffness", "rod.linear_density", "tip_load.mass", "obstacle[0].radius"}) {
    const std::string value = written_value(session.document(), key);
    const std::vector<double> differences = by_differences(value, [&](const std::string& other) {
      Session again(arguments_of(arm, changed(turned, key, other)));
      return quantities(again.execute(plan.moments, executed, std::nullopt, plan.place).result, false);
    });
    const std::vector<double> exact = by_key(session, all, key, unit_of(value));
    expect_same(all, exact, differences, std::stod(value), key);
    // The plan's own basis is coarser.
    const std::vector<double> coarse = by_key(session, planned, key, unit_of(value));
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double size = std::abs(exact[i]) + 1e-2 * std::abs(all.quantities[i].value / std::stod(value));
      EXPECT_NEAR(coarse[i], exact[i], 2e-3 * size) << all.quantities[i].name << " by " << key;
    }
  }
  EXPECT_EQ(session.sensitivity(plan, SensitivityKind::replanned).trouble,
            "plans that choose where the base stands are differentiated with all held only");
  Session pushed(arguments_of(arm, {{"rod.insertion.min", "60 mm"}, {"rod.insertion.max", "100 mm"}}));
  EXPECT_EQ(pushed.sensitivity(pushed.plan(std::nullopt), SensitivityKind::held).trouble,
            "rods that are drawn into a port are not differentiated");
}

TEST(NoDerivative, IsToldInWords) {
  // A limit that is met, and only just: the plan without it needs no more.
  Session session(arguments_of(arm, {}));
  const Plan plan = session.plan(std::nullopt);
  const Sensitivity all = session.sensitivity(plan, SensitivityKind::replanned);
  char limit[64];
  std::snprintf(limit, sizeof limit, "%.17g", plan.moments[0]);
  Session met(arguments_of(arm, {{"rod.actuator[0].limit", limit}}));
  const Plan leaning = met.plan(std::nullopt);
  EXPECT_NE(met.sensitivity(leaning, SensitivityKind::replanned).trouble.find("holds nothing"), std::string::npos);
  Session longer(arguments_of(arm, {{"rod.axial_stiffness", "50 N"}, {"coordinates.stretch_order", "2"}}));
  EXPECT_EQ(longer.sensitivity(longer.plan(std::nullopt), SensitivityKind::held).trouble,
            "rods that stretch are not differentiated");
  // Pieces of the rod end where an actuator does.
  Session part(arguments_of(arm, {{"rod.actuator[0].to", "60 mm"}}));
  const Sensitivity partly = part.sensitivity(part.plan(std::nullopt), SensitivityKind::replanned);
  ASSERT_EQ(partly.trouble, "");
  EXPECT_NE(partly.find("rod.actuator[0].to")->trouble, "");
  EXPECT_NE(partly.find("rod.length")->trouble, "");
  EXPECT_EQ(partly.find("obstacle[0].radius")->trouble, "");
  EXPECT_THROW(session.problem().sensitivity(plan, SensitivityKind::held, {"rod.lenght"}), Error);
}

}  // namespace
}  // namespace tendril::app::test
