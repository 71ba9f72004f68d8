// The library's rods with closed contacts against the tables and the boundary-value problem.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "core_support.hpp"
#include "obstacle/circle.hpp"

namespace tendril::support {
namespace {

struct Errors {
  double tip = 0.0;
  double force = 0.0;  // relative
  double arc_length = 0.0;
};

Errors errors(Equilibrium& rod, const BvpSolution& exact) {
  Errors e;
  e.tip = norm(rod.tip() - Vec2{exact.tip_x, exact.tip_y});
  for (std::size_t k = 0; k < exact.forces.size(); ++k) {
    const auto contact = static_cast<int>(k);
    e.force = std::max(e.force, std::abs(rod.force(contact) / exact.forces[k] - 1.0));
    if (rod.program->arc_length_variable(contact) < 0) continue;
    e.arc_length = std::max(e.arc_length, std::abs(rod.arc_length(contact) - exact.arc_lengths[k]));
  }
  return e;
}

/// One contact problem of the tables with its exact solution.
struct Pressed {
  std::string name;
  RodBvp rod;
  double moment = 0.0;
  BvpContact contact;
  std::unique_ptr<Obstacle> obstacle;
  BvpSolution exact;
  Errors error(const Model& model, bool split) const {
    const auto rod_at = equilibrium_near(rod, {moment}, {contact}, {obstacle.get()}, exact, model, split);
    return errors(*rod_at, exact);
  }
};

std::vector<Pressed> pressed_cases() {
  std::vector<Pressed> cases;
  const ReferenceTable circles("circle_contact");
  for (std::size_t i = 0; i < circles.rows(); ++i) {
    Pressed p;
    p.name = "circle_contact row " + std::to_string(i);
    p.moment = circles.value(i, "moment");
    p.contact = table_circle(circles, i);
    p.exact = press(p.contact, p.moment);
    p.obstacle = core_obstacle(p.contact);
    cases.push_back(std::move(p));
  }
  const ReferenceTable arms("braced_arm");
  const DimensionlessArm arm;
  for (std::size_t i = 0; i < arms.rows(); ++i) {
    Pressed p;
    p.name = "braced_arm row " + std::to_string(i);
    p.rod = arm.rod;
    p.moment = arms.value(i, "moment") / DimensionlessArm::moment_unit;
    p.contact = arm.circle;
    p.exact = arm.brace(p.moment);
    p.obstacle = core_obstacle(p.contact);
    cases.push_back(std::move(p));
  }
  return cases;
}

// The table's equilibria, reached from an arc that does not touch, without help of the boundary-value problem.
TEST(CoreContactReference, CircleContactTable) {
  const ReferenceTable table("circle_contact");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    SCOPED_TRACE(i);
    const BvpContact contact = table_circle(table, i);
    const auto obstacle = core_obstacle(contact);
    const double moment = table.value(i, "moment");
    StartShape start = constant_curvature(0.7);
    start.moments = {0.7};
    start.arc_lengths = {contact.center.x};
    Eigen::VectorXd x;
    std::unique_ptr<Equilibrium> rod;
    constexpr int steps = 12;
    for (int step = 0; step <= steps; ++step) {
      const double now = 0.7 + (moment - 0.7) * step / steps;
      rod = std::make_unique<Equilibrium>(core_rod(RodBvp{}), legendre(6), std::vector<double>{now},
                                          std::vector<const Obstacle*>{obstacle.get()},
                                          std::vector<ContactSetup>{{0, false, 0}});
      ASSERT_LE(step == 0 ? rod->solve(start) : rod->solve_from(x), 1e-11);
      x = rod->x;
    }
    const Errors e = errors(*rod, press(contact, moment));
    std::cout << "split, 6 functions per piece, row " << i << ": tip / L " << e.tip << "  force " << e.force
              << "  arc length / L " << e.arc_length << '\n';
    // Six functions on each side of the contact: the hardest row, at moment 3, is off by 1.0008e-8 (measured), the
    // others by less than 2e-11.
    EXPECT_LT(e.tip, i == 1 ? 1.01e-8 : 1e-10);
    EXPECT_LT(e.force, 1e-7);
    EXPECT_LT(e.arc_length, 1e-8);
    // The model's error beside what is printed.
    EXPECT_NEAR(rod->tip().x, table.value(i, "tip_x"), printed(table, i, "tip_x") + e.tip);
    EXPECT_NEAR(rod->tip().y, table.value(i, "tip_y"), printed(table, i, "tip_y") + e.tip);
    EXPECT_NEAR(rod->arc_length(0), table.value(i, "arc_length"), printed(table, i, "arc_length") + e.arc_length);
    EXPECT_NEAR(rod->force(0), table.value(i, "force"), printed(table, i, "force") + e.force * table.value(i, "force"));
  }
}

TEST(CoreContactReference, BracedArmTable) {
  const ReferenceTable table("braced_arm");
  const DimensionlessArm arm;
  const auto obstacle = core_obstacle(arm.circle);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    SCOPED_TRACE(i);
    const double moment = table.value(i, "moment") / DimensionlessArm::moment_unit;
    for (const int order : {6, 10}) {
      Equilibrium rod(core_rod(arm.rod), legendre(order), {moment}, {obstacle.get()}, {{0, false, 0}});
      StartShape start = constant_curvature(0.4);
      start.moments = {moment};
      start.arc_lengths = {0.6};
      start.forces = {1.4};
      ASSERT_LE(rod.solve(start), 1e-11);
      const Errors e = errors(rod, arm.brace(moment));
      std::cout << "split, " << order << " functions per piece, row " << i << ": tip / L " << e.tip << "  force "
                << e.force << "  arc length / L " << e.arc_length << '\n';
      EXPECT_LT(e.tip, 1e-8);
      EXPECT_LT(e.force, 1e-7);
      EXPECT_LT(e.arc_length, 1e-8);
      constexpr double length = DimensionlessArm::length;
      // At six functions the model's error stays below the ten digits printed (measured: 1e-13 L), at ten it is
      // rounding.
      EXPECT_NEAR(length * rod.arc_length(0), table.value(i, "arc_length"), printed(table, i, "arc_length"));
      EXPECT_NEAR(length * rod.tip().x, table.value(i, "tip_x"), printed(table, i, "tip_x"));
      EXPECT_NEAR(length * rod.tip().y, table.value(i, "tip_y"), printed(table, i, "tip_y"));
      EXPECT_NEAR(rod.tip_angle(), table.value(i, "tip_angle"), printed(table, i, "tip_angle"));
      EXPECT_NEAR(DimensionlessArm::force_unit * rod.force(0), table.value(i, "force"), printed(table, i, "force"));
    }
  }
}

TEST(CoreContactReference, CoarseModelsShowTheirTrueError) {
  for (const Pressed& p : pressed_cases()) {
    const Errors twelve = p.error(legendre(12), false);
    std::cout << p.name << ": tip error / L, relative force error\n";
    const auto print = [](const char* name, const Errors& e) {
      std::cout << "  " << name << "  " << e.tip << "  " << e.force << '\n';
    };
    print("legendre12 unsplit", twelve);
    print("psc unsplit", p.error(psc(), false));
    print("psc split", p.error(psc(), true));
    print("pcc3 unsplit", p.error(pcc(3), false));
    print("pcc3 split", p.error(pcc(3), true));
    EXPECT_LT(twelve.tip, 1e-4) << p.name;
    // Bounds at about twice the worst row measured.
    EXPECT_LT(p.error(psc(), true).tip, 1e-4) << p.name;
    EXPECT_LT(p.error(psc(), false).tip, 1e-2) << p.name;
    EXPECT_LT(p.error(pcc(3), true).tip, 1.2e-2) << p.name;
    EXPECT_LT(p.error(pcc(3), false).tip, 4e-2) << p.name;
  }
}

TEST(CoreContactReference, SplitBasisConvergesExponentially) {
  for (const Pressed& p : pressed_cases()) {
    const double e3 = p.error(legendre(3), true).tip;
    const double e6 = p.error(legendre(6), true).tip;
    const double e10 = p.error(legendre(10), true).tip;
    std::cout << p.name << ": tip error / L at 3, 6, 10 functions per piece: " << e3 << ' ' << e6 << ' ' << e10 << '\n';
    // The boundary-value problem is good to about 1e-13, so 1e-12 ends every comparison.
    EXPECT_LT(e6, std::max(1e-3 * e3, 1e-12)) << p.name;
    EXPECT_LT(e10, std::max(1e-3 * e6, 1e-12)) << p.name;
  }
}

TEST(CoreContactReference, UnsplitBasesConvergeAlgebraically) {
  for (const Pressed& p : pressed_cases()) {
    // Where the kink falls inside a piece or between roots makes single errors jump: the mean over a few neighbours is
    // judged.
    const auto mean = [&](auto&& model, int first, int last) {
      double sum = 0.0;
      for (int n = first; n <= last; ++n) sum += std::log(p.error(model(n), false).tip);
      return std::exp(sum / (last - first + 1));
    };
    const double smooth = order_of(12.0, mean([](int n) { return legendre(n); }, 10, 14), 40.0,
                                   mean([](int n) { return legendre(n); }, 36, 44));
    const double constant =
        order_of(10.0, mean([](int n) { return pcc(n); }, 7, 13), 40.0, mean([](int n) { return pcc(n); }, 34, 46));
    std::cout << p.name << ": orders legendre " << smooth << "  pcc " << constant << '\n';
    // The mean leaves a few hundredths of the jumps (measured: 3.01 to 3.06 and 1.945 to 2.01).
    EXPECT_NEAR(smooth, 3.0, 0.15) << p.name;
    EXPECT_NEAR(constant, 2.0, 0.15) << p.name;
  }
}

// The free arc of moment 0.7 passes below both circles, so a closed contact would have to pull.
TEST(CoreContactReference, UntouchedCirclesWouldHaveToPull) {
  const ReferenceTable table("circle_contact");
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
    const BvpContact contact = table_circle(table, i);
    const auto obstacle = core_obstacle(contact);
    StartShape start = constant_curvature(0.7);
    start.moments = {0.7};
    Equilibrium free(core_rod(RodBvp{}), legendre(6), {0.7});
    ASSERT_LE(free.solve(start), 1e-12);
    double gap = infinity;
    for (int k = 0; k <= 1000; ++k)
      gap = std::min(gap, obstacle->at(free.program->backbone().at(k / 1000.0).position).distance);
    // The closer circle is missed by 4.2e-4 L.
    EXPECT_GT(gap, 1e-4);
    Equilibrium closed(core_rod(RodBvp{}), legendre(6), {0.7}, {obstacle.get()}, {{0, false, 0}});
    start.arc_lengths = {0.6};
    ASSERT_LE(closed.solve(start), 1e-11);
    EXPECT_LT(closed.force(0), 0.0);
    BvpGuess guess;
    guess.curvature = 0.7;
    guess.arc_lengths = {0.6};
    guess.forces = {0.0};
    const BvpSolution exact = solve(RodBvp{}, {0.7}, {contact}, guess);
    EXPECT_NEAR(closed.force(0), exact.forces[0], 1e-7);
  }
}

TEST(CoreContactReference, TipContactPushesAlongTheNormal) {
  const BvpContact contact{{0.2, 0.77}, 0.3, true};
  const auto obstacle = core_obstacle(contact);
  BvpGuess guess;
  guess.curvature = 1.8;
  guess.arc_lengths = {1.0};
  guess.forces = {0.1};
  const BvpSolution exact = solve(RodBvp{}, {2.0}, {contact}, guess);
  for (const bool split : {true, false}) {
    Equilibrium rod(core_rod(RodBvp{}), legendre(14), {2.0}, {obstacle.get()}, {{0, true, 0}}, split);
    StartShape start = constant_curvature(1.8);
    start.moments = {2.0};
    ASSERT_LE(rod.solve(start), 1e-11);
    // 14 functions on a rod without kinks: rounding of both methods.
    EXPECT_NEAR(rod.tip().x, exact.tip_x, 1e-11);
    EXPECT_NEAR(rod.tip().y, exact.tip_y, 1e-11);
    EXPECT_NEAR(rod.tip_angle(), exact.tip_angle, 1e-11);
    EXPECT_NEAR(rod.force(0), exact.forces[0], 1e-10);
    const PoseProgram::ContactState& at = rod.program->contacts()[0];
    EXPECT_GT(rod.force(0), 0.0);
    // At the tip the force is not perpendicular to the rod, and the rest of the rod lies farther out.
    EXPECT_LT(dot(at.tangent, at.surface.normal), -1e-3);
  }
}

// A rod that sags over a peg onto a floor: both contacts move, and a piece lies between two moving knots.
TEST(CoreContactReference, TwoContactsAtOnce) {
  RodBvp bvp;
  bvp.sections[0].density = 20.0;
  bvp.gravity = {0.0, -1.0};
  const std::vector<BvpContact> contacts{{{0.4, -0.12}, 0.1}, {{0.0, -0.1}, 0.0, false, {0.0, 1.0}}};
  BvpGuess guess;
  guess.angle = [](double s) { return s < 0.75 ? -0.25 * std::sin(s * 4.19) : 2.0 * (s - 0.75); };
  guess.arc_lengths = {0.4, 0.75};
  guess.forces = {5.0, 5.0};
  const BvpSolution exact = solve(bvp, {1.0}, contacts, guess);
  const auto peg = core_obstacle(contacts[0]);
  const auto floor = core_obstacle(contacts[1]);
  const auto error = [&](int order) {
    const auto rod = equilibrium_near(bvp, {1.0}, contacts, {peg.get(), floor.get()}, exact, legendre(order), true);
    return errors(*rod, exact);
  };
  // Converged at 14 functions per piece; the force is the stiffest quantity.
  const Errors e = error(14);
  EXPECT_LT(e.tip, 1e-10);
  EXPECT_LT(e.force, 1e-9);
  EXPECT_LT(e.arc_length, 1e-9);
  EXPECT_LT(error(6).tip, 1e-5);
  EXPECT_LT(e.tip, 1e-2 * error(6).tip);
}

TEST(CoreContactReference, RandomRodsWithAContactAgreeWithTheBoundaryValueProblem) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  int compared = 0;
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE(trial);
    RodBvp bvp;
    bvp.sections = {{0.45, 1.0, between(0.0, 2.0), between(-0.5, 0.5)},
                    {0.55, between(0.5, 2.0), between(0.0, 2.0), between(-0.5, 0.5)}};
    bvp.actuators = {{0.0, 1.0}, {0.0, 0.45}, {0.7, 1.0}};
    const std::vector<double> moments{between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0)};
    const double tilt = between(0.0, 6.283);
    bvp.gravity = {std::cos(tilt), std::sin(tilt)};
    bvp.payload = between(0.0, 0.5);
    bvp.tip_force = {between(-0.5, 0.5), between(-0.5, 0.5)};
    bvp.base = {between(-0.5, 0.5), between(-0.5, 0.5)};
    bvp.base_angle = between(-3.0, 3.0);
    BvpGuess guess;
    guess.curvature = 0.2;
    const BvpSolution free = follow(bvp, {0.0, 0.0, 0.0}, moments, {}, guess);
    // A circle that stands 0.02 L deep in the free rod, on either side of it.
    const double place = trial % 3 == 0 ? between(0.3, 0.4) : trial % 3 == 1 ? between(0.5, 0.65) : between(0.75, 0.9);
    const double side = trial % 2 == 0 ? 1.0 : -1.0;
    const double radius = between(0.05, 0.3);
    const BvpState at = free.at(place);
    const double away = side * (radius - 0.02);
    const BvpContact contact{{at.x - away * std::sin(at.angle), at.y + away * std::cos(at.angle)}, radius};
    BvpGuess closed = free.guess();
    closed.arc_lengths = {place};
    closed.forces = {0.0};
    const BvpSolution exact = solve(bvp, moments, {contact}, closed);
    const auto obstacle = core_obstacle(contact);
    const auto rod = equilibrium_near(bvp, moments, {contact}, {obstacle.get()}, exact, legendre(14), true);
    const Errors e = errors(*rod, exact);
    EXPECT_GT(rod->force(0), 0.0);
    // Relative to forces of order 1 to 20; 14 functions per stretch resolve everything to about 1e-12.
    EXPECT_LT(e.tip, 1e-9);
    EXPECT_LT(e.force, 1e-9);
    EXPECT_LT(e.arc_length, 1e-9);
    // The unsplit program knows the same physics; its error is that of a basis that runs through a kink.
    const auto unsplit = equilibrium_near(bvp, moments, {contact}, {obstacle.get()}, exact, legendre(14), false);
    EXPECT_LT(errors(*unsplit, exact).tip, 1e-4);
    ++compared;
  }
  EXPECT_EQ(compared, 12);
}

}  // namespace
}  // namespace tendril::support
