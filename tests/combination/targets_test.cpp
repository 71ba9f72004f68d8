// The pose of the paper: 25 targets at both limits of the motor, every solver from the scene's one start and from
// random ones.

#include <cmath>
#include <iostream>
#include <map>
#include <random>

#include "support.hpp"

namespace tendril::combination {
namespace {

struct Pose {
  const char* limit;
  Vec2 target;  ///< m
};

std::vector<Pose> poses() {
  std::vector<Pose> all;
  for (const char* limit : {"2.5 N mm", "10 N mm"}) {
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) all.push_back({limit, {0.091 + 0.002 * i, 0.006 + 0.005 * j}});
    }
  }
  return all;
}

std::ostream& operator<<(std::ostream& os, const Pose& pose) {
  return os << pose.limit << ", (" << 1e3 * pose.target.x << ", " << 1e3 * pose.target.y << ") mm";
}

Scene scene_of(const Pose& pose, const std::string& solver) {
  Scene made = scene("brace", {std::string("rod.actuator.0.limit=\"") + pose.limit + '"'});
  made.target.position = pose.target;
  made.solver.plugin = solver;
  return made;
}

/// True if the rod passes the peg of the scene on its left side, seen along the rod.
bool passes_above(const Plan& plan) {
  const Vec2 peg{0.06, 0.0};
  double nearest = infinity;
  bool above = false;
  for (const BackbonePoint& p : plan.backbone) {
    const Vec2 away = p.position() - peg;
    if (norm(away) >= nearest) continue;
    nearest = norm(away);
    above = cross({std::cos(p.angle), std::sin(p.angle)}, away) > 0.0;
  }
  return above;
}

/// Equal up to the rounding of two polished plans; a second minimum differs by far more.
double tolerance_of(double objective) { return 1e-6 * std::max(objective, 1e-6); }

TEST(Targets, EverySolverCertifiesEveryTargetAndTheyAgree) {
  int count = 0;
  for (const Pose& pose : poses()) {
    SCOPED_TRACE(testing::PrintToString(pose));
    std::map<bool, double> objective;  // by the side of the peg
    for (const std::string& solver : registry().names(ComponentKind::solver)) {
      SCOPED_TRACE(solver);
      const Plan found = plan(scene_of(pose, solver));
      ASSERT_TRUE(certified(found));
      ++count;
      const auto [known, first] = objective.emplace(passes_above(found), found.objective);
      if (!first) {
        EXPECT_NEAR(found.objective, known->second, tolerance_of(known->second));
      }
    }
    if (objective.size() > 1) std::cout << pose << ": the solvers end on different sides of the peg\n";
  }
  RecordProperty("plans", count);
}

// A sample of what `tendril-bench solvers` does with 20 starts for every target.
TEST(Targets, FromRandomStartsNineInTenReachTheBestOfTheirSide) {
  const std::vector<Pose> all = poses();
  std::mt19937 random(20);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  struct Run {
    bool above = false;
    double objective = infinity;
  };
  std::map<std::string, int> runs;
  std::map<std::string, int> reached;
  for (std::size_t i = 0; i < all.size(); i += 7) {
    std::map<std::string, std::vector<Run>> by_solver;
    std::map<bool, double> best{{false, infinity}, {true, infinity}};
    for (int start = 0; start < 4; ++start) {
      Plan shape;
      const double turn = uniform(-2.0, 2.0);
      const double slope = uniform(-1.5, 1.5);
      for (int k = 0; k <= 50; ++k) {
        const double s = 0.02 * k;
        shape.backbone.push_back({0.1 * s, 0.0, 0.0, 0.0, (turn + slope * (2.0 * s - 1.0)) / 0.1});
      }
      PlanControl control;
      control.start = &shape;
      for (const std::string& solver : registry().names(ComponentKind::solver)) {
        const Plan found = plan(scene_of(all[i], solver), control);
        ++runs[solver];
        // What fails says so, and is no plan.
        if (!certified(found)) {
          EXPECT_NE(found.message, "");
          continue;
        }
        by_solver[solver].push_back({passes_above(found), found.objective});
        best[passes_above(found)] = std::min(best[passes_above(found)], found.objective);
      }
    }
    for (const auto& [solver, own] : by_solver) {
      for (const Run& run : own)
        reached[solver] += run.objective <= best[run.above] + tolerance_of(best[run.above]) ? 1 : 0;
    }
  }
  for (const auto& [solver, count] : runs) EXPECT_GE(10 * reached[solver], 9 * count) << solver;
}

}  // namespace
}  // namespace tendril::combination
