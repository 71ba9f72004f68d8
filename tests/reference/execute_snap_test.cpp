#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "execute_support.hpp"
#include "obstacle/rounded_hull.hpp"
#include "support/link_chain.hpp"
#include "support/print.hpp"

namespace tendril::support {
namespace {

constexpr double right_angle = std::numbers::pi / 2.0;

/// The same rod for the independent discretization.
RodBvp upright_links(double weight) {
  RodBvp rod;
  rod.sections[0].density = weight;
  rod.gravity = {0.0, -1.0};
  rod.base_angle = right_angle;
  return rod;
}

// A tip that is pushed along a thin bar slides to where its end begins to be round, and no further.
TEST(Snap, ATipSlipsOverTheEndOfABar) {
  ForwardScene s;
  ObstacleSpec bar;
  bar.name = "bar";
  bar.shape = "capsule";
  s.scene.obstacles.push_back(bar);
  constexpr double radius = 0.004;
  s.obstacles.push_back(
      std::make_unique<RoundedHull>(std::vector<Vec2>{{0.7, 0.5 + radius}, {2.0, 0.5 + radius}}, radius));
  const Execution before = s.run({1.3});
  ASSERT_EQ(before.result.status, PlanStatus::solved) << before.result.message;
  ASSERT_EQ(before.result.contacts.size(), 1U);
  EXPECT_TRUE(before.result.contacts[0].at_tip);
  EXPECT_GT(before.result.tip_x, 0.7);
  const Execution e = s.run({3.0});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.snaps.size(), 1U);
  EXPECT_EQ(e.snaps[0].kind, SnapKind::fold);
  EXPECT_NEAR(e.snaps[0].before.back().x, 0.7, 1e-6);
  EXPECT_TRUE(e.snaps[0].contacts_after.empty());
  EXPECT_NEAR(e.result.tip_x, std::sin(3.0) / 3.0, 1e-10);
  // Under friction nothing says where it falls to, but that it does, and later.
  s.scene.contact.friction = 0.2;
  const Execution rubs = s.run({3.0});
  EXPECT_EQ(rubs.result.message.rfind("the rod gives way at load fraction", 0), 0U) << rubs.result.message;
  EXPECT_GT(rubs.load, e.snaps[0].load + 1e-3);
  EXPECT_NEAR(rubs.result.tip_x, 0.7, 1e-6);
}

struct KnownFold {
  double weight, moment, tip_angle;
};

class SnapThrough : public testing::TestWithParam<KnownFold> {};

// model.md section 8: fold of the tip moment, and the tip's angle from the vertical just before.
TEST_P(SnapThrough, FoldOfTheMomentIsFoundAndTheStateAfterItIsStable) {
  const KnownFold& known = GetParam();
  ForwardScene s = upright(known.weight);
  s.scene.start_tip_angle = 1.0;
  const Execution first = s.run({2.0});
  ASSERT_EQ(first.result.status, PlanStatus::solved) << first.result.message;
  const Execution e = s.run({-1.0}, &first.result);
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.snaps.size(), 1U);
  const Snap& snap = e.snaps[0];
  EXPECT_EQ(snap.kind, SnapKind::fold);
  EXPECT_NEAR(snap.moments[0], known.moment, 1e-7);
  EXPECT_NEAR(snap.load, (2.0 - known.moment) / 3.0, 1e-7);
  EXPECT_NEAR(snap.before.back().angle - right_angle, known.tip_angle, 1e-4);
  EXPECT_GT(snap.stability_after, 0.1);
  EXPECT_LT(snap.after.back().angle, right_angle);
  // The link chain, started on the other side, agrees on where the rod ends.
  LinkChainOptions options;
  options.links = 200;
  options.curvature = -1.5;
  const LinkChainSolution links = settle(upright_links(known.weight), {-1.0}, {}, options);
  EXPECT_NEAR(e.result.tip_x, links.tip_x, 2e-5);
  EXPECT_NEAR(e.result.tip_y, links.tip_y, 2e-5);
}

INSTANTIATE_TEST_SUITE_P(ModelSection8, SnapThrough,
                         testing::Values(KnownFold{10.0, -0.24017224, 0.7272}, KnownFold{12.0, -0.59941729, 0.8253}));

TEST(ExecuteSnap, AHigherStartHasNoFoldAboveTheCriticalMoment) {
  ForwardScene s = upright(10.0);
  s.scene.start_tip_angle = 1.0;
  const Execution first = s.run({2.0});
  const Execution e = s.run({-0.24}, &first.result);
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  EXPECT_TRUE(e.snaps.empty());
  EXPECT_GT(e.result.tip_angle, right_angle + 0.7);
}

TEST(ExecuteSnap, ASymmetricRodBucklesAtTheEulerLoad) {
  ForwardScene s;
  s.scene.tip_load.force = {-5.0, 0.0};
  const Execution e = s.run({0.0});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.snaps.size(), 1U);
  EXPECT_EQ(e.snaps[0].kind, SnapKind::bifurcation);
  EXPECT_NEAR(5.0 * e.snaps[0].load, 2.4674011003, 1e-6);
  EXPECT_GT(e.result.tip_angle, 0.5);  // the side of the larger tip angle
  EXPECT_GT(e.result.certificate.stability, 0.1);
}

TEST(ExecuteSnap, ASymmetricRodBucklesUnderItsOwnWeight) {
  const Execution e = upright(10.0).run({0.0});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.snaps.size(), 1U);
  EXPECT_NEAR(10.0 * e.snaps[0].load, 7.8373474389, 1e-6);
}

}  // namespace
}  // namespace tendril::support
