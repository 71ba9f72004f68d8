#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raw_values.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/plugins/registry.hpp"

/// The coordinate models and objective terms of this build, opened as plugins as a scene does.
namespace tendril::plugins {
namespace {

using List = RawValue::List;

Registry built_plugins() { return Registry(Catalog(search_places({}))); }

template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

struct Basis {
  Eigen::MatrixXd value, first, second;
};

Basis evaluate(const CoordinateModel& model, const std::vector<double>& sigma) {
  const auto rows = static_cast<Eigen::Index>(sigma.size());
  const Eigen::MatrixXd empty(rows, model.function_count());
  Basis basis{empty, empty, empty};
  model.evaluate(sigma, basis.value, basis.first, basis.second);
  return basis;
}

class CoordinatePlugin : public testing::TestWithParam<const char*> {};

TEST_P(CoordinatePlugin, BeginsAtZeroAndHasTheDerivativesItStates) {
  Registry registry = built_plugins();
  const auto model = make(registry.coordinates(GetParam()), {});
  constexpr double h = 1e-5;
  for (const double s : {0.1, 0.5, 0.83}) {
    const Basis basis = evaluate(*model, {0.0, s - h, s, s + h});
    for (int i = 0; i < model->function_count(); ++i) {
      EXPECT_EQ(basis.value(0, i), 0.0);
      // h^2/6 = 2e-11 times third derivatives below 1e3 for six Legendre functions, and rounding of 1e-16 / h.
      EXPECT_NEAR(basis.first(2, i), (basis.value(3, i) - basis.value(1, i)) / (2 * h), 1e-8);
      EXPECT_NEAR(basis.second(2, i), (basis.first(3, i) - basis.first(1, i)) / (2 * h), 1e-7);
    }
  }
}

TEST_P(CoordinatePlugin, SubdividesIntoFractionsThatSumToOne) {
  Registry registry = built_plugins();
  double sum = 0.0;
  for (const double fraction : make(registry.coordinates(GetParam()), {})->subdivision()) {
    EXPECT_GT(fraction, 0.0);
    sum += fraction;
  }
  // Three roundings.
  EXPECT_NEAR(sum, 1.0, 1e-15);
}

INSTANTIATE_TEST_SUITE_P(All, CoordinatePlugin, testing::Values("pcc", "psc", "legendre"),
                         [](const auto& test) { return std::string(test.param); });

TEST(CoordinatePlugins, HaveTheSizesOfTableOne) {
  Registry registry = built_plugins();
  EXPECT_EQ(make(registry.coordinates("pcc"), {})->function_count(), 1);
  EXPECT_EQ(make(registry.coordinates("pcc"), {})->subdivision().size(), 3U);
  EXPECT_EQ(make(registry.coordinates("psc"), {})->function_count(), 3);
  EXPECT_EQ(make(registry.coordinates("psc"), {})->subdivision().size(), 1U);
  EXPECT_EQ(make(registry.coordinates("legendre"), {})->function_count(), 6);
}

TEST(CoordinatePlugins, TakeTheirOptions) {
  Registry registry = built_plugins();
  const auto legendre =
      make(registry.coordinates("legendre"), {{"order", {std::int64_t{9}}}, {"pieces", {std::int64_t{2}}}});
  EXPECT_EQ(legendre->function_count(), 9);
  EXPECT_EQ(legendre->subdivision(), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(make(registry.coordinates("pcc"), {{"pieces", {std::int64_t{64}}}})->subdivision().size(), 64U);
  EXPECT_EQ(make(registry.coordinates("pcc"), {{"lengths", numbers({1, 2, 1})}})->subdivision(),
            (std::vector<double>{0.25, 0.5, 0.25}));
}

TEST(CoordinatePlugins, RefuseContradictions) {
  Registry registry = built_plugins();
  const auto& pcc = registry.coordinates("pcc");
  EXPECT_TRUE(contains_text(refusal([&] {
                              make(pcc, {{"pieces", {std::int64_t{2}}}, {"lengths", numbers({1, 1})}});
                            }),
                            "expected one of them"));
  EXPECT_TRUE(contains_text(refusal([&] {
                              make(pcc, {{"lengths", numbers(std::vector<double>(65, 1.0))}});
                            }),
                            "at most 64"));
  EXPECT_TRUE(contains_text(refusal([&] { make(pcc, {{"lengths", numbers({1, 0})}}); }), "out of range"));
  EXPECT_TRUE(contains_text(refusal([&] { make(pcc, {{"pieces", {std::int64_t{65}}}}); }), "from 1 to 64"));
}

/// Everything that a term may read, from a plain vector: two contacts, two moments, two tendons and two deviations.
template <class T>
class World {
 public:
  static constexpr std::size_t numbers_per_contact = 9;
  static constexpr std::size_t size = 4 + 2 * numbers_per_contact + 6 + 4 + 3;

  World(const std::vector<T>& x, Target target) {
    std::size_t at = 4;
    quantities_.tip = {x[0], x[1], x[2], x[3]};
    for (ContactQuantities<T>& c : contacts_) {
      c = {x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5], x[at + 6], x[at + 7], x[at + 8]};
      at += numbers_per_contact;
    }
    moments_ = {x[at], x[at + 1]};
    tensions_ = {x[at + 2], x[at + 3]};
    shortenings_ = {x[at + 4], x[at + 5]};
    quantities_.contacts = contacts_;
    quantities_.moments = moments_;
    quantities_.tensions = tensions_;
    quantities_.shortenings = shortenings_;
    deviations_ = {TipDeviation<T>{x[at + 6], x[at + 7]}, {x[at + 8], x[at + 9]}};
    quantities_.tip_deviations = deviations_;
    quantities_.bending_energy = x[at + 10];
    quantities_.insertion = x[at + 11];
    quantities_.palm_distance = x[at + 12];
    quantities_.target = target;
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const Quantities<T>& quantities() const { return quantities_; }

 private:
  std::array<ContactQuantities<T>, 2> contacts_{};
  std::array<T, 2> moments_{}, tensions_{}, shortenings_{};
  std::array<TipDeviation<T>, 2> deviations_{};
  Quantities<T> quantities_{};
};

template <class T>
T cost(const ObjectiveTerm& term, const std::vector<T>& x, const Target& target) {
  const World<T> world(x, target);
  std::vector<T> residuals(64);
  Contribution<T> out(residuals);
  term.evaluate(world.quantities(), out);
  EXPECT_LE(out.residual_count(), residuals.size());
  T sum = out.smooth_part();
  for (std::size_t i = 0; i < out.residual_count(); ++i) sum += residuals[i] * residuals[i];
  return sum;
}

std::vector<double> some_point() {
  std::vector<double> x(World<double>::size);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(1.0 + 1.7 * static_cast<double>(i));
  return x;
}

const Target wanted{{0.97, 0.2}, 0.4, true, true};

struct TermCase {
  const char* name;
  RawOptions options;
};

/// The name of a test must not contain what changes from run to run.
void PrintTo(const TermCase& term, std::ostream* out) { *out << term.name; }

class ObjectivePlugin : public testing::TestWithParam<TermCase> {};

TEST_P(ObjectivePlugin, HyperDualDerivativesAgreeWithCentralDifferences) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective(GetParam().name), GetParam().options);
  const std::vector<double> x = some_point();
  constexpr double h = 1e-4;
  const auto shifted = [&](std::size_t i, double a, std::size_t k, double b) {
    std::vector<double> y = x;
    y[i] += a;
    y[k] += b;
    return cost(*term, y, wanted);
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t k = i; k < x.size(); ++k) {
      std::vector<HyperDual> y(x.begin(), x.end());
      y[i].a = 1.0;
      y[k].b = 1.0;
      const HyperDual exact = cost(*term, y, wanted);
      // All terms are at most quadratic, so differences have rounding errors only: sums of size 10 and eps, over h or
      // h^2.
      EXPECT_NEAR(exact.v, cost(*term, x, wanted), 1e-13);
      EXPECT_NEAR(exact.a, (shifted(i, h, i, 0) - shifted(i, -h, i, 0)) / (2 * h), 1e-10) << i;
      EXPECT_NEAR(exact.b, (shifted(k, h, k, 0) - shifted(k, -h, k, 0)) / (2 * h), 1e-10) << k;
      EXPECT_NEAR(
          exact.ab,
          (shifted(i, h, k, h) - shifted(i, h, k, -h) - shifted(i, -h, k, h) + shifted(i, -h, k, -h)) / (4 * h * h),
          1e-6)
          << i << ' ' << k;
    }
  }
}

TEST_P(ObjectivePlugin, DependsOnNothingThatItDoesNotRead) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective(GetParam().name), GetParam().options);
  const Reads reads = term->reads();
  // Tip, two contacts, moments, tendons, deviations, energy, palm.
  std::vector<bool> read{reads.tip_position, reads.tip_position, reads.tip_angle, false};
  for (std::size_t c = 0; c < 2; ++c) {
    // The reference point is given with the contact point.
    for (const bool r :
         {reads.contact_point, reads.contact_point, reads.contact_gap, reads.contact_normal, reads.contact_normal,
          reads.contact_force, reads.contact_arc_length, reads.contact_point, reads.contact_point}) {
      read.push_back(r);
    }
  }
  for (const bool r : {reads.moments, reads.moments, reads.tensions, reads.tensions, reads.shortenings,
                       reads.shortenings, reads.tip_deviations, reads.tip_deviations, reads.tip_deviations,
                       reads.tip_deviations, reads.bending_energy, reads.insertion, reads.palm_distance}) {
    read.push_back(r);
  }
  ASSERT_EQ(read.size(), World<double>::size);

  const std::vector<double> x = some_point();
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (read[i]) continue;
    std::vector<double> y = x;
    y[i] += 0.5;
    EXPECT_EQ(cost(*term, y, wanted), cost(*term, x, wanted)) << "number " << i;
  }
}

TEST_P(ObjectivePlugin, StaysAboveItsLowerBound) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective(GetParam().name), GetParam().options);
  EXPECT_GE(cost(*term, some_point(), wanted), term->lower_bound());
}

RawValue rows(const std::vector<std::vector<double>>& matrix) {
  List list;
  for (const auto& row : matrix) list.push_back(numbers(row));
  return {list};
}

INSTANTIATE_TEST_SUITE_P(
    All, ObjectivePlugin,
    testing::Values(TermCase{"tip_pose", {}}, TermCase{"tip_pose", {{"angle_weight", {0.0}}}},
                    TermCase{"tip_pose", {{"weights", rows({{2, 0.5, 0.1}, {0.5, 1, 0}, {0.1, 0, 3}})}}},
                    TermCase{"actuation_effort", {}}, TermCase{"actuation_effort", {{"weights", numbers({2, 3})}}},
                    TermCase{"contact_proximity", {{"weights", rows({{2, 1}, {1, 3}})}}}, TermCase{"contact_force", {}},
                    TermCase{"tip_variance", {}}, TermCase{"tendon_tension", {}},
                    TermCase{"tendon_tension", {{"wanted", {0.7}}}}, TermCase{"tendon_tension", {{"equal", {true}}}}),
    [](const auto& test) { return test.param.name + ("_" + std::to_string(test.index)); });

TEST(TipPose, CountsWhatTheTargetHas) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective("tip_pose"), {{"weights", numbers({2, 3})}, {"angle_weight", {5.0}}});
  const std::vector<double> x = some_point();
  const double dx = x[0] - wanted.position.x;
  const double dy = x[1] - wanted.position.y;
  const double da = x[2] - wanted.angle;
  // Roundings of numbers of size 10.
  EXPECT_NEAR(cost(*term, x, wanted), 2 * dx * dx + 3 * dy * dy + 5 * da * da, 1e-14);
  EXPECT_NEAR(cost(*term, x, Target{wanted.position, 0, true, false}), 2 * dx * dx + 3 * dy * dy, 1e-14);
  EXPECT_NEAR(cost(*term, x, Target{{}, wanted.angle, false, true}), 5 * da * da, 1e-14);
}

TEST(TipPose, ReadsTheAngleOnlyIfItHasAWeight) {
  Registry registry = built_plugins();
  const auto& tip_pose = registry.objective("tip_pose");
  EXPECT_TRUE(make(tip_pose, {})->reads().tip_angle);
  EXPECT_FALSE(make(tip_pose, {{"angle_weight", {0.0}}})->reads().tip_angle);
  EXPECT_FALSE(make(tip_pose, {{"weights", numbers({1, 1, 0})}})->reads().tip_angle);
  EXPECT_TRUE(make(tip_pose, {})->reads().target);
}

TEST(ActuationEffort, WeighsEachMoment) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective("actuation_effort"), {{"weights", numbers({2, 3})}});
  const std::vector<double> x = some_point();
  const std::size_t first = 4 + 2 * World<double>::numbers_per_contact;
  // Roundings of numbers of size 5.
  EXPECT_NEAR(cost(*term, x, wanted), 2 * x[first] * x[first] + 3 * x[first + 1] * x[first + 1], 1e-14);
}

TEST(ActuationEffort, WeightsForAnotherNumberOfActuatorsAreRefused) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective("actuation_effort"), {{"weights", numbers({1, 2, 3})}});
  EXPECT_TRUE(
      contains_text(refusal([&] { cost(*term, some_point(), wanted); }), "found weights for 3 actuators; expected 2"));
}

TEST(ContactForce, IsMinusTheSumOfForcesAndHasNoLowerBound) {
  Registry registry = built_plugins();
  const auto term = make(registry.objective("contact_force"), {});
  const std::vector<double> x = some_point();
  double sum = 0.0;
  for (std::size_t c = 0; c < 2; ++c) sum += x[4 + c * World<double>::numbers_per_contact + 5];
  EXPECT_NEAR(cost(*term, x, wanted), -sum, 1e-15);
  EXPECT_EQ(term->lower_bound(), -infinity);
}

TEST(ObjectivePlugins, RefuseWeightsThatAreNoWeights) {
  Registry registry = built_plugins();
  const auto negative = refusal([&] { make(registry.objective("tip_pose"), {{"weights", rows({{1, 2}, {2, 1}})}}); });
  EXPECT_TRUE(contains_text(negative, "objective plugin 'tip_pose'"));
  EXPECT_TRUE(contains_text(negative, "eigenvalue -1"));
  EXPECT_TRUE(contains_text(refusal([&] {
                              make(registry.objective("contact_proximity"), {{"weights", numbers({1, 2, 3})}});
                            }),
                            "found a matrix of 3 x 3; expected 2 x 2"));
}

TEST(Plugins, OnlyWhatIsAskedForIsOpened) {
  Registry registry = built_plugins();
  registry.coordinates("psc");
  registry.coordinates("psc");
  ASSERT_EQ(registry.opened().size(), 1U);
  EXPECT_EQ(registry.opened().front().name, "psc");
  EXPECT_EQ(registry.opened().front().kind, ComponentKind::coordinates);
}

}  // namespace
}  // namespace tendril::plugins
