// The second computation of a plan agrees with its certificate, whatever the contact is beside.

#include "plan_check.hpp"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "scene_text.hpp"
#include "scenes.hpp"
#include "support/print.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {
namespace {

using namespace scene_text;

/// The check takes the curvature on one side of a contact from angles 1e-6 L apart, and the second variation from
/// differences: some 1e-8 of both margins, which are close to 1.
constexpr double same_margin = 1e-7;

struct Case {
  const char* name;
  std::string text;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// (L) Below the clamp, where a rod of this weight lies on it with a point inside.
constexpr double top = -0.02;
/// (L) Far less than what the check's differences move the rod by.
constexpr double tiny = 2e-6;

const Case obstacles[] = {
    {"wall", wall(top, 1.0)},
    {"side_of_a_tiny_capsule", capsule({0.3, top - tiny}, {0.8, top - tiny}, tiny)},
    {"side_of_a_capsule", capsule({0.3, top - 0.1}, {0.8, top - 0.1}, 0.1)},
    {"tiny_circle", circle(0.5, top - tiny, tiny)},
    {"end_of_a_tiny_capsule", capsule({0.5, top - tiny}, {0.5, top - 0.1}, tiny)},
    {"circle", circle(0.5, top - 0.1, 0.1)},
};

/// From curvatures that jump at the contact to those that hardly do.
const Case models[] = {
    {"pcc_of_3", "[coordinates]\nplugin = \"pcc\"\npieces = 3\n"},
    {"pcc_of_8", "[coordinates]\nplugin = \"pcc\"\npieces = 8\n"},
    {"legendre_of_2", "[coordinates]\nplugin = \"legendre\"\norder = 2\n"},
    {"legendre_of_6", "[coordinates]\nplugin = \"legendre\"\norder = 6\n"},
};

/// A rod that sags onto the obstacle.
Scene scene_with(const Case& obstacle, const Case& model, const plugins::Registry& registry) {
  return scene_from_text(gravity_of(1.0) + unit_rod(5.0) + actuator(1.5, 1.5) + start(0.2) + contact("require") +
                             "min_force = 0.01\n" + target(1.0, 0.1) + weighted(1.0, 1e-6) + obstacle.text + model.text,
                         obstacle.name, registry);
}

class CheckedPlan : public testing::TestWithParam<std::tuple<Case, Case>> {};

TEST_P(CheckedPlan, HasTheMarginOfItsCertificateAndNoDefect) {
  const auto& [obstacle, model] = GetParam();
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  const Scene scene = scene_with(obstacle, model, registry);
  Problem problem(scene, plugins::make_components(registry, scene));
  const Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_EQ(plan.contacts.size(), 1U);
  ASSERT_FALSE(plan.contacts.front().at_tip);
  const PlanCheck check = check_plan(scene, plan);
  EXPECT_NEAR(check.margin, plan.certificate.stability, same_margin);
  for (const std::string& defect : check.defects) ADD_FAILURE() << defect;
}

INSTANTIATE_TEST_SUITE_P(Contacts, CheckedPlan,
                         testing::Combine(testing::ValuesIn(obstacles), testing::ValuesIn(models)),
                         [](const auto& each) {
                           return std::string(std::get<0>(each.param).name) + "_" + std::get<1>(each.param).name;
                         });

TEST(ChangedPlan, WithAnotherMomentOrContactIsFalse) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  const Scene scene = scene_with(obstacles[0], models[3], registry);
  Problem problem(scene, plugins::make_components(registry, scene));
  const Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_TRUE(check_plan(scene, plan).defects.empty());
  Plan stronger = plan;
  stronger.moments[0] += 1e-6;
  EXPECT_FALSE(check_plan(scene, stronger).defects.empty());
  Plan pressed = plan;
  pressed.contacts[0].force += 1e-6;
  EXPECT_FALSE(check_plan(scene, pressed).defects.empty());
}

}  // namespace
}  // namespace tendril::bench
