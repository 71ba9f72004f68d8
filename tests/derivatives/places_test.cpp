// What a rod tells about places on it, against differences of where they are: rows, and the pull-backs of forces once
// and twice.

#include "rod/places.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "differences.hpp"
#include "rod/curve.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril {
namespace {

/// Two segments and a load of every kind, with places of every kind. Split: arc lengths are knots; else one place
/// slides.
struct Posed {
  struct Kind {
    bool split, varies = false, stretches = false, moves = false;
  };
  explicit Posed(Kind kind) : split(kind.split), moves(kind.moves) {
    const bool varies = kind.varies;
    rod.segments = {{0.0, 0.4, 1.0, 1.7, 0.3}, {0.4, 1.0, 0.6, 0.9, -0.2}};
    if (varies) {
      rod.segments[0].more_stiffness = {-0.3};
      rod.segments[0].more_weight = {0.4};
      rod.segments[1].more_stiffness = {-0.4, 0.2, 0.1, -0.05};
      rod.segments[1].more_weight = {-0.7, 0.3};
      rod.segments[1].more_rest_curvature = {0.5, -0.2};
      rod.loads = {{0.4, 0.4, {0.2, -0.3}, 0.25}, {0.4, 1.0, {-0.4, 0.3}, 0.0}, {0.0, 1.0, {0.1, 0.2}, 0.0}};
    }
    if (kind.stretches) {
      rod.stretch_order = 4;
      rod.segments[0].axial = 0.6;
      rod.segments[1].axial = 0.9;
      if (varies) {
        rod.segments[0].more_axial = {0.2, -0.3};
        rod.segments[1].more_axial = {-0.3, 0.1, 0.2};
      }
    }
    rod.base = {0.1, -0.2};
    rod.base_angle = 0.3;
    if (moves) {
      using Move = Rod::Move;
      rod.moves = {{Move::Kind::shift, {0.8, -0.6}}, {Move::Kind::turn}, {Move::Kind::draw}};
    }
    const std::vector<int> stretches = split ? std::vector<int>{0, 1} : std::vector<int>{};
    chain = std::make_unique<Chain>(rod, model, stretches, 40);
    places = std::make_unique<Places>(rod, *chain, split ? 2 : 1);
    if (split) {
      for (const int k : {0, 1}) places->add_knot(chain->piece_before_knot(k));
    } else {
      places->add_sliding(1, 0);
    }
    places->add_fixed(0.31);
    places->add_fixed(0.93);
    places->add_tip();
    places->add_stations(std::vector<Places::Station>{{1, 0.37}, {0, 1.0}});
    forces = virtual_forces = Forces{};
    forces.on.resize(static_cast<std::size_t>(places->count()));
    virtual_forces.on.resize(forces.on.size());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> d(-1.0, 1.0);
    for (Forces* f : {&forces, &virtual_forces}) {
      f->tip = {d(random), d(random)};
      f->gravity = {d(random), d(random)};
      f->payload = 0.4;
      f->dead = f == &forces ? Vec2{0.7, 0.2} : Vec2{1.3, -0.4};
      for (Push& push : f->on) push.force = {d(random), d(random)};
    }
    for (int k = 0; k < places->count(); ++k) {
      const bool station = k >= places->count() - 2;
      auto& push = forces.on[static_cast<std::size_t>(k)];
      if (!station) push.moment = d(random);
      if (!station && inside(k)) push.bending = 0.3 * d(random);
      if (station) virtual_forces.on[static_cast<std::size_t>(k)].force = {};
    }
    at.resize(chain->coordinate_count() + places->arc_lengths());
    lambda.resize(chain->coordinate_count());
    for (Eigen::Index i = 0; i < lambda.size(); ++i) {
      at[i] = 0.5 * d(random) / (1.0 + static_cast<double>(i % chain->functions()));
      lambda[i] = d(random) / (1.0 + static_cast<double>(i % chain->functions()));
    }
    const Eigen::Index contacts = at.size() - (split ? 2 : 1);
    at[contacts] = split ? 0.23 : 0.71;
    if (split) at[contacts + 1] = 0.77;
    if (moves) at.segment(lambda.size(), 3) << 0.3, -0.4, 0.12;
    move(at);
  }

  bool inside(int place) const { return split ? place == 2 || place == 3 : place < 3; }

  void move(const Eigen::VectorXd& z) {
    const Eigen::Index q = lambda.size();
    places->move(z.head(q), {z.data() + q, static_cast<std::size_t>(places->arc_lengths())});
    places->differentiate();
    places->displace(lambda.data());
  }

  /// Work of the forces, whatever they are fixed to, at z.
  double work(const Forces& f, const Eigen::VectorXd& z) {
    move(z);
    const Backbone& shape = places->backbone();
    Curve curve(chain->curve_tables());
    curve.follow(shape);
    double sum = dot(f.tip, shape.tip()) + f.payload * dot(f.gravity, shape.tip());
    for (int k = 0; k < places->count(); ++k) {
      const Push& push = f.on[static_cast<std::size_t>(k)];
      sum += dot(push.force, places->point(k));
      if (push.moment != 0.0) sum += push.moment * places->angle(k);
      if (push.bending != 0.0) sum += push.bending * places->side(k, 0).curvature;
    }
    for (int j = 0; j < chain->piece_count(); ++j) {
      for (int g = 0; g < chain->nodes(); ++g) {
        const double s = shape.start(j) + chain->table().sigma[g] * shape.length(j);
        Vec2 load = rod.segment_at(s).weight_at(s).value * f.gravity;
        for (const Rod::Load& l : rod.loads) {
          if (s > l.from && s < l.to) load += f.dead_load(l.force);
        }
        sum += shape.length(j) * chain->table().weight[g] * dot(load, curve.position(j, chain->table().sigma[g]));
      }
    }
    for (const Rod::Load& l : rod.loads) {
      if (l.at_point()) sum += dot(f.dead_load(l.force) + l.weight * f.gravity, shape.at(l.from).position);
    }
    return sum;
  }

  /// Derivatives of the forces' work by the coordinates, and by the arc lengths: rows of places, masses by differences.
  Eigen::VectorXd pulled(const Forces& f, const Eigen::VectorXd& z) {
    move(z);
    Eigen::VectorXd out = Eigen::VectorXd::Zero(lambda.size());
    places->pull_back(f, out.data());
    return out;
  }

  Eigen::MatrixXd second(const Forces& f, const Forces* turning) {
    move(at);
    const Eigen::Index q = lambda.size();
    const int s = places->arc_lengths();
    Eigen::MatrixXd qq = Eigen::MatrixXd::Zero(q, q);
    Eigen::MatrixXd qs = Eigen::MatrixXd::Zero(q, s);
    Eigen::MatrixXd ss = Eigen::MatrixXd::Zero(s, s);
    places->second_pull_back(f, turning, {qq, qs, ss});
    Eigen::MatrixXd all(q + s, q + s);
    all << qq, qs, qs.transpose(), ss;
    return all;
  }

  bool split, moves;
  LegendreBasis model{5, 1};
  Rod rod;
  std::unique_ptr<Chain> chain;
  std::unique_ptr<Places> places;
  Forces forces, virtual_forces;
  Eigen::VectorXd at, lambda;
};

class PlacesOn : public testing::TestWithParam<Posed::Kind> {
 protected:
  Posed p{GetParam()};
  const std::function<std::string(int)> number = [](int i) { return std::to_string(i); };
};

TEST_P(PlacesOn, WorkIsThatOfForcesOnTheWayToWhereTheyAct) {
  Eigen::VectorXd elsewhere = p.at;
  elsewhere.head(p.lambda.size()) *= 0.7;
  const double expected = p.work(p.virtual_forces, elsewhere) - p.work(p.virtual_forces, p.at);
  p.move(elsewhere);
  const double after = p.places->work(p.virtual_forces);
  p.move(p.at);
  // Sums of a dozen numbers of size 1.
  EXPECT_NEAR(after - p.places->work(p.virtual_forces), expected, 1e-13);
}

TEST_P(PlacesOn, RowsAreDerivativesOfPoints) {
  for (int k = 0; k < p.places->count(); ++k) {
    SCOPED_TRACE("place " + std::to_string(k));
    const Eigen::MatrixXd expected = differences(p.at, [&](const Eigen::VectorXd& z) {
      p.move(z);
      const Vec2 point = p.places->point(k);
      const Vec2 shift = p.places->displacement(k);
      return Eigen::VectorXd(Eigen::Vector4d(point.x, point.y, shift.x, shift.y));
    });
    p.move(p.at);
    Eigen::MatrixXd found = Eigen::MatrixXd::Zero(4, p.at.size());
    const bool station = k >= p.places->count() - 2;
    for (int i = 0; i < 4; ++i) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(p.at.size());
      const Vec2 along = i % 2 == 0 ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0};
      const RowPart part{row.data(), row.data() + p.lambda.size()};
      if (i < 2) p.places->row(k, along, part);
      if (i >= 2 && !station) p.places->displacement_row(k, along, part);
      found.row(i) = row.transpose();
    }
    expect_near("the row", found, expected, number, number, 1e-8);
  }
}

TEST_P(PlacesOn, PullBackIsTheDerivativeOfTheWork) {
  const Eigen::MatrixXd expected =
      differences(p.at, [&](const Eigen::VectorXd& z) { return Eigen::VectorXd::Constant(1, p.work(p.forces, z)); });
  const Eigen::VectorXd found = p.pulled(p.forces, p.at);
  expect_near("the pull-back", found.transpose(), expected.leftCols(p.lambda.size()), number, number, 1e-8);
}

TEST_P(PlacesOn, SecondPullBackIsTheSecondDerivativeOfTheWork) {
  const Eigen::Index q = p.lambda.size();
  const Eigen::MatrixXd expected = differences(p.at, [&](const Eigen::VectorXd& z) { return p.pulled(p.forces, z); });
  const Eigen::MatrixXd found = p.second(p.forces, nullptr);
  expect_near("the second pull-back", found.topRows(q), expected, number, number, 1e-8);
  // By arc lengths twice only the work itself can tell, of a base that turns that of forces on places.
  if (p.moves) p.forces = {p.forces.on};
  const Eigen::Index arcs = p.at.size() - q;
  const auto work_at = [&](const Eigen::VectorXd& s) {
    Eigen::VectorXd z = p.at;
    z.tail(arcs) = s;
    return Eigen::VectorXd::Constant(1, p.work(p.forces, z));
  };
  constexpr double wide = 1e-3;
  const Eigen::MatrixXd bends = differences(
      p.at.tail(arcs),
      [&](const Eigen::VectorXd& s) { return Eigen::VectorXd(differences(s, work_at, wide).transpose()); }, wide);
  expect_near("the second pull-back", p.second(p.forces, nullptr).bottomRightCorner(arcs, arcs), bends, number, number,
              1e-8);
}

TEST_P(PlacesOn, SecondPullBackAlongIsTheSecondDerivativeOfTheVirtualWork) {
  const Eigen::Index q = p.lambda.size();
  const Forces none{std::vector<Push>(p.forces.on.size())};
  const auto slope = [&](const Eigen::VectorXd& z) {
    // lambda . d(work), whose own second derivatives are meant, by all variables.
    Eigen::VectorXd out(z.size());
    p.move(z);
    Eigen::MatrixXd qq = Eigen::MatrixXd::Zero(q, q);
    Eigen::MatrixXd qs = Eigen::MatrixXd::Zero(q, p.places->arc_lengths());
    Eigen::MatrixXd ss(0, 0);
    p.places->second_pull_back(p.virtual_forces, nullptr, {qq, qs, ss});
    out.head(q) = qq * p.lambda;
    out.tail(p.places->arc_lengths()) = qs.transpose() * p.lambda;
    return out;
  };
  expect_near("the second pull-back", p.second(none, &p.virtual_forces), differences(p.at, slope), number, number,
              1e-8);
}

TEST_P(PlacesOn, EnergyHasItsDerivatives) {
  const Eigen::Index q = p.lambda.size();
  const auto row_at = [&](const Eigen::VectorXd& z) {
    p.move(z);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(z.size());
    p.places->add_energy_row(1.0, {row.data(), row.data() + q});
    return row;
  };
  const Eigen::MatrixXd slope = differences(p.at, [&](const Eigen::VectorXd& z) {
    p.move(z);
    return Eigen::VectorXd::Constant(1, p.places->energy());
  });
  expect_near("the energy's row", row_at(p.at).transpose(), slope, number, number, 1e-8);
  const int s = p.places->arc_lengths();
  const auto second = [&](double factor, const double* lambda) {
    Eigen::MatrixXd qq = Eigen::MatrixXd::Zero(q, q);
    Eigen::MatrixXd qs = Eigen::MatrixXd::Zero(q, s);
    Eigen::MatrixXd ss = Eigen::MatrixXd::Zero(s, s);
    p.places->add_energy_second(factor, lambda, {qq, qs, ss});
    Eigen::MatrixXd all(q + s, q + s);
    all << qq, qs, qs.transpose(), ss;
    return all;
  };
  const Eigen::MatrixXd bend = differences(p.at, row_at);
  p.move(p.at);
  expect_near("the energy's second derivative", second(1.0, nullptr), bend, number, number, 1e-8);
  const auto along = [&](const Eigen::VectorXd& z) {
    p.move(z);
    return Eigen::VectorXd(-(second(1.0, nullptr).leftCols(q) * p.lambda));
  };
  const Eigen::MatrixXd third = differences(p.at, along);
  p.move(p.at);
  expect_near("its derivative along lambda", second(0.0, p.lambda.data()), third, number, number, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Rods, PlacesOn,
                         testing::Values(Posed::Kind{false}, Posed::Kind{true}, Posed::Kind{false, true},
                                         Posed::Kind{true, true}, Posed::Kind{false, false, true},
                                         Posed::Kind{true, false, true}, Posed::Kind{false, true, true},
                                         Posed::Kind{true, true, true}, Posed::Kind{false, false, false, true},
                                         Posed::Kind{true, true, false, true}, Posed::Kind{true, true, true, true}),
                         [](const auto& kind) {
                           return std::string(kind.param.split ? "split" : "unsplit") +
                                  (kind.param.varies ? "_varied" : "") + (kind.param.stretches ? "_stretched" : "") +
                                  (kind.param.moves ? "_moved" : "");
                         });

}  // namespace
}  // namespace tendril
