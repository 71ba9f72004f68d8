// The second computation of a plan agrees with its certificate, whatever the contact is beside.

#include "check/plan_check.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "check/body.hpp"
#include "common/scene_text.hpp"
#include "common/scenes.hpp"
#include "obstacle/shape_options.hpp"
#include "support/print.hpp"
#include "support/random_outline.hpp"
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

// 200 bodies of any outline, over and under the rod: gap, normal and force of what touches, and the margin, by the
// geometry of the check.
TEST(CheckedPlans, WithAnyOutlineHasNoDefect) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  std::mt19937 random(17);
  int touching = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double side = trial % 2 == 0 ? 1.0 : -1.0;
    const Vec2 center{0.3 + 0.004 * (trial % 100), -0.3 * side};
    std::string vertices;
    for (const Vec2 p : support::random_outline(random, center, 0.27)) {
      vertices += fmt::format("{}[{:.17g}, {:.17g}]", vertices.empty() ? "" : ", ", p.x, p.y);
    }
    const std::string part = "[[obstacle]]\nshape = \"polygon\"\nvertices = [" + vertices + "]\nrounding = 0.01\n";
    const Scene scene = scene_from_text(gravity_of(1.0) + unit_rod(2.0) + actuator(-3.0, 3.0) + contact("allow") +
                                            target(0.9, -0.25 * side) + weighted(1.0, 1e-4) + part + models[3].text,
                                        "part", registry);
    Problem problem(scene, plugins::make_components(registry, scene));
    const Plan plan = problem.plan();
    ASSERT_EQ(plan.status, PlanStatus::solved) << trial << ": " << plan.message;
    const PlanCheck check = check_plan(scene, plan);
    for (const std::string& defect : check.defects) ADD_FAILURE() << trial << ": " << defect;
    if (plan.contacts.empty() || !(plan.contacts[0].force > 1e-6)) continue;
    EXPECT_NEAR(check.margin, plan.certificate.stability, same_margin) << trial;
    ++touching;
  }
  EXPECT_GT(touching, 50);
}

// A body of one thickness beside any outline is a line beside the outline that is grown by its radius, whose plans are
// checked above.
TEST(CheckedPlans, OfAThickRodAreThoseBesideAGrownOutline) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  std::mt19937 random(18);
  int touching = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const double side = trial % 2 == 0 ? 1.0 : -1.0;
    const Vec2 center{0.3 + 0.01 * trial, -0.3 * side};
    std::string vertices;
    for (const Vec2 p : support::random_outline(random, center, 0.25)) {
      vertices += fmt::format("{}[{:.17g}, {:.17g}]", vertices.empty() ? "" : ", ", p.x, p.y);
    }
    const auto planned = [&](const std::string& rounding, const std::string& thickness) {
      const std::string part =
          "[[obstacle]]\nshape = \"polygon\"\nvertices = [" + vertices + "]\nrounding = " + rounding + "\n";
      const Scene scene =
          scene_from_text(gravity_of(1.0) + unit_rod(2.0) + thickness + actuator(-3.0, 3.0) + contact("allow") +
                              target(0.9, -0.25 * side) + weighted(1.0, 1e-4) + part + models[3].text,
                          "part", registry);
      return Problem(scene, plugins::make_components(registry, scene)).plan();
    };
    const Plan thick = planned("0.01", "thickness = 0.03\n");
    const Plan grown = planned("0.025", "");
    ASSERT_EQ(thick.status, PlanStatus::solved) << trial << ": " << thick.message;
    ASSERT_EQ(grown.status, PlanStatus::solved) << trial << ": " << grown.message;
    EXPECT_NEAR(thick.objective, grown.objective, 1e-8 * (1.0 + grown.objective)) << trial;
    ASSERT_EQ(thick.contacts.size(), grown.contacts.size()) << trial;
    for (std::size_t i = 0; i < grown.contacts.size(); ++i) {
      EXPECT_NEAR(thick.contacts[i].force, grown.contacts[i].force, 1e-6 * (1.0 + grown.contacts[i].force)) << trial;
      touching += grown.contacts[i].force > 1e-6 ? 1 : 0;
    }
  }
  EXPECT_GT(touching, 5);
}

/// What bounds a channel, by other formulas than those of the shape: corners that are mitred or rounded, ends, widths.
TEST(BodyOfAChannel, IsThatOfTheShape) {
  const Component<Obstacle> component = channel_component();
  std::mt19937 random(19);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 100; ++trial) {
    ObstacleSpec spec{"o", "channel", {}};
    RawValue::List points, widths;
    Vec2 at{};
    double heading = 0.0;
    for (int i = 0; i < 2 + trial % 5; ++i) {
      points.push_back({RawValue::List{{at.x}, {at.y}}});
      widths.push_back({0.1 + 0.2 * unit(random)});
      at += (0.3 + 0.3 * unit(random)) * Vec2{std::cos(heading), std::sin(heading)};
      heading += trial % 2 == 0 ? 3.0 * unit(random) - 1.5 : unit(random) - 0.5;
    }
    spec.options = {{"points", {points}}, {"rounding", {0.02}}, {"wall", {0.1 + 0.1 * unit(random)}}};
    static constexpr std::array<const char*, 4> ends{"none", "start", "end", "both"};
    spec.options["closed"] = {std::string(ends[static_cast<std::size_t>(trial % 4)])};
    if (trial % 3 == 0) {
      spec.options["widths"] = {widths};
    } else {
      spec.options["width"] = {0.2};
    }
    const Body body = body_of(spec, {}, 1.0);
    const std::unique_ptr<Obstacle> shape =
        component.make(resolve_options(component.options, spec.options, Scale{1.0, 1.0}, {}, "a channel"));
    for (int i = 0; i < 200; ++i) {
      const Vec2 p{2.5 * unit(random) - 0.5, 3.0 * unit(random) - 1.5};
      Vec2 normal{};
      const SurfacePoint s = shape->at(p);
      EXPECT_NEAR(body.distance(p, normal) - body.radius, s.distance, 1e-9) << trial;
    }
  }
}

/// One thing that is wrong with a plan, or that its scene does not allow, two to five times as far off as may be.
struct Wrong {
  const char* defect;  ///< what is said of it
  std::function<void(Scene&, Plan&)> put;
};

/// (L) The certificate's limits are 1e-9 and the check's 2e-9 (plan_check.cpp).
constexpr double off = 5e-9;

void put_wall(Scene& scene, double y) {
  scene.obstacles.front().options["point"] = {RawValue::List{{0.0, {}}, {y, {}}}, {}};
}

std::vector<Wrong> wrongs() {
  return {
      {"no equilibrium", [](Scene&, Plan& p) { p.moments[0] += off; }},
      {"a moment", [](Scene&, Plan& p) { p.moments[0] += off; }},
      {"no equilibrium", [](Scene&, Plan& p) { p.coordinates[1] += 10.0 * off; }},
      {"no equilibrium", [](Scene&, Plan& p) { p.contacts[0].force += 10.0 * off; }},
      {"a contact is no closest point", [](Scene&, Plan& p) { p.coordinates[0] += 20.0 * off; }},
      {"has a gap of", [](Scene& s, Plan&) { put_wall(s, top - off); }},
      {"deep in", [](Scene& s, Plan&) { put_wall(s, top + off); }},
      {"a moment", [](Scene& s, Plan&) { s.rod.actuators[0].maximum = s.rod.actuators[0].minimum = 1.5 - off; }},
      {"a moment", [](Scene& s, Plan&) { s.rod.actuators[0].maximum = s.rod.actuators[0].minimum = 1.5 + off; }},
      {"a force", [](Scene& s, Plan& p) { s.contact.max_force = p.contacts[0].force - off; }},
      {"a force", [](Scene& s, Plan& p) { s.contact.min_force = p.contacts[0].force + off; }},
      {"a force", [](Scene& s, Plan&) { s.contact.mode = ContactModeName::avoid; }},
      {"too many contacts", [](Scene& s, Plan&) { s.contact.count = 0; }},
      {"no contact", [](Scene&, Plan& p) { p.contacts.clear(); }},
      {"an arc length", [](Scene&, Plan& p) { p.contacts[0].arc_length = 1.0 + off; }},
      {"the tip is off", [](Scene&, Plan& p) { p.tip_x += off; }},
      {"the tip is off", [](Scene&, Plan& p) { p.tip_y -= off; }},
      {"the tip is off", [](Scene&, Plan& p) { p.tip_angle += off; }},
      {"the backbone is off", [](Scene&, Plan& p) { p.backbone[40].x += off; }},
      {"the backbone is off", [](Scene&, Plan& p) { p.backbone[70].y -= off; }},
      {"the target is missed", [](Scene&, Plan& p) { *p.target_error += off; }},
      {"the target is missed", [](Scene& s, Plan&) { s.target.position->x += 1e-6; }},
  };
}

TEST(WrongPlan, IsToldFalseByName) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  const Scene scene = scene_with(obstacles[0], models[3], registry);
  Problem problem(scene, plugins::make_components(registry, scene));
  const Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_TRUE(check_plan(scene, plan).defects.empty());
  std::size_t number = 0;
  for (const Wrong& wrong : wrongs()) {
    Scene other = scene;
    Plan bad = plan;
    wrong.put(other, bad);
    std::string defects;
    for (const std::string& defect : check_plan(other, bad).defects) defects += defect + '\n';
    EXPECT_NE(defects.find(wrong.defect), std::string::npos)
        << "number " << number << ", expected \"" << wrong.defect << "\", found:\n"
        << defects;
    ++number;
  }
}

// A straight rod that stands on its base is an equilibrium under any weight, and buckles at 7.83734744 EI/L^3.
TEST(WrongPlan, ThatIsUnstableIsToldFalse) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  for (const double weight : {7.8, 7.9}) {
    const Scene scene = scene_from_text(gravity_of(1.0) + unit_rod(weight) + "[rod.base]\nangle = \"90 deg\"\n" +
                                            target(0.0, 1.0) + weighted(1.0, 1e-6) + models[3].text,
                                        "column", registry);
    Plan plan;
    plan.coordinates_name = "legendre";
    plan.order = 6;
    plan.coordinates.assign(6, 0.0);
    plan.tip_y = 1.0;
    plan.tip_angle = std::acos(0.0);
    plan.backbone = {{0.0, 0.0, 0.0, plan.tip_angle, 0.0}, {1.0, 0.0, 1.0, plan.tip_angle, 0.0}};
    const PlanCheck check = check_plan(scene, plan);
    // Margin: 1 - weight / critical weight, which six functions have to 1e-6.
    EXPECT_NEAR(check.margin, 1.0 - weight / 7.83734744, 1e-5);
    ASSERT_EQ(check.defects.size(), weight > 7.84 ? 1U : 0U);
    for (const std::string& defect : check.defects) EXPECT_TRUE(defect.starts_with("unstable: margin")) << defect;
  }
}

}  // namespace
}  // namespace tendril::bench
