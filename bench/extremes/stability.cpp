#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "certificate/certifier.hpp"
#include "common/workload.hpp"
#include "extremes/extremes.hpp"
#include "extremes/models.hpp"
#include "rod/quadrature.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

/// From so many smooth functions on one piece on, the critical loads are exact to `critical_digits`.
constexpr int resolving_functions = 8;
constexpr double critical_digits = 1e-6;

/// A rod with one coordinate model and, with `driven`, a moment along all of it.
class Column {
 public:
  Column(const CoordinateModel& model, bool driven) : model_(model) {
    if (driven) rod_.actuators.push_back({});
  }
  void load(double thrust, double weight, double base_angle) {
    rod_.tip_force = {-thrust, 0.0};
    rod_.gravity = weight > 0.0 ? Vec2{0.0, -1.0} : Vec2{};
    rod_.segments[0].weight = weight;
    rod_.base_angle = base_angle;
    PoseProgramSpec spec;
    spec.rod = &rod_;
    spec.model = &model_;
    spec.nodes = suggested_nodes(model_.function_count(), 4.0);
    program_ = std::make_unique<PoseProgram>(spec);
    certifier_ = std::make_unique<Certifier>(spec);
  }
  PoseProgram& program() { return *program_; }
  Certifier& certifier() { return *certifier_; }
  Eigen::VectorXd straight() const { return Eigen::VectorXd::Zero(program_->variable_count()); }

  /// The equilibrium with this angle of the tip against the base, near x; its moment is one of the unknowns.
  bool bend(Eigen::VectorXd& x, double angle) {
    const int n = program_->layout().coordinates;
    const int functions = program_->chain().functions();
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 1, n + 1);
    Eigen::VectorXd right(n + 1);
    for (int j = 0; j < program_->chain().piece_count(); ++j) {
      system.row(n).segment(j * functions, functions) = program_->chain().table().end.transpose();
    }
    for (int step = 0; step < 30; ++step) {
      right.head(n) = -Eigen::VectorXd(program_->constraints(x)).head(n);
      right[n] = angle - system.row(n).dot(x);
      const Eigen::MatrixXd jacobian = program_->jacobian(x);
      system.topRows(n) = jacobian.topRows(n);
      const Eigen::VectorXd dx = system.partialPivLu().solve(right);
      if (!dx.allFinite()) return false;
      x += dx;
      if (dx.cwiseAbs().maxCoeff() < 1e-12) return true;
    }
    return false;
  }

 private:
  const CoordinateModel& model_;
  Rod rod_;
  std::unique_ptr<PoseProgram> program_;
  std::unique_ptr<Certifier> certifier_;
};

std::vector<ExtremeModel> tried_models(plugins::Registry& registry, bool quick) {
  std::vector<LeftOut> ignored;
  std::vector<ExtremeModel> models = extreme_models(registry, false, ignored);
  for (ExtremeModel& m :
       counted_models(registry, quick ? std::vector<int>{8} : std::vector<int>{1, 2, 4, 8, 16, 32, 64})) {
    models.push_back(std::move(m));
  }
  return models;
}

bool resolves(const CoordinateModel& model) {
  return model.function_count() >= resolving_functions && model.breaks().empty();
}

ExtremeRow row_of(const char* name, const ExtremeModel& model, bool resolving, const char* source) {
  ExtremeRow row;
  row.group = "instability";
  row.name = name;
  row.model = model.name;
  row.backend = "-";
  row.source = source;
  row.error = none;
  row.allowed = resolving ? critical_digits : none;
  row.expected = resolving ? "margin 0 at the exact load to 1e-6, unstable beyond"
                           : "not below the exact load, its error reported, unstable beyond";
  return row;
}

/// Where the margin of the straight state vanishes, and what the certificate says there.
ExtremeRow straight_row(const char* name, const ExtremeModel& model, const CoordinateModel& basis, double exact,
                        const char* source, const std::function<void(Column&, double)>& put) {
  ExtremeRow row = row_of(name, model, resolves(basis), source);
  const double begin = now();
  Column column(basis, false);
  const auto margin = [&](double load) {
    put(column, load);
    return column.certifier().stability(column.straight());
  };
  const double at_exact = margin(exact);
  double low = 0.5 * exact;
  double high = 4.0 * exact;
  while (high - low > 1e-12 * exact) {
    const double middle = 0.5 * (low + high);
    (margin(middle) > 0.0 ? low : high) = middle;
  }
  row.error = low / exact - 1.0;
  put(column, low * (1.0 + 1e-4));
  const Certificate beyond = column.certifier().certify(column.program(), column.straight());
  bool unstable = false;
  for (const std::string& failure : beyond.failures) unstable = unstable || failure.rfind("unstable", 0) == 0;
  row.seconds = now() - begin;
  row.got = fmt::format("margin {:.1e} at the exact load, 0 at {:.9g} (relative error {:.1e}), {} beyond", at_exact,
                        low, row.error, unstable ? "unstable" : "not unstable");
  row.residuals = fmt::format("equilibrium {:.0e}, margin beyond {:.1e}", beyond.equilibrium, beyond.stability);
  // A basis that is a part of all shapes cannot buckle earlier than they do.
  const bool good = resolves(basis) ? std::abs(at_exact) <= critical_digits && std::abs(row.error) <= critical_digits
                                    : row.error >= -critical_digits;
  row.outcome = good && unstable ? Outcome::met : Outcome::not_met;
  if (!good) row.why = "the margin does not vanish at the exact load";
  if (!unstable) row.why = "the certificate does not call it unstable";
  return row;
}

/// A rod clamped upright leans over under its tip moment; lowered, the moment passes a fold where the rod falls.
ExtremeRow fold_row(const ExtremeModel& model, const CoordinateModel& basis, double weight, double exact,
                    double angle) {
  ExtremeRow row = row_of("", model, resolves(basis), "two bases of higher order agree");
  row.name = fmt::format("snap-through, weight {}", weight);
  const double begin = now();
  Column column(basis, true);
  column.load(0.0, weight, 0.5 * pi);
  Eigen::VectorXd x = column.straight();
  const int moment = column.program().moment_variable(0);
  double high = 0.0;
  double low = 0.0;
  bool followed = true;
  // From a lean on which the rod stands by the moment, back towards the upright.
  for (double lean = 0.0; lean <= 1.6 && followed; lean += 0.05) followed = column.bend(x, lean);
  double stable = 1.6;
  for (double lean = 1.6; lean > 0.05 && followed; lean -= 0.05) {
    followed = column.bend(x, lean);
    if (!(column.certifier().stability(x) > 0.0)) {
      low = lean;
      high = stable;
      break;
    }
    stable = lean;
  }
  if (!followed || high == 0.0) {
    // A stiffer rod carries the weight by itself: a basis with a higher critical weight has nowhere to fall from.
    const double upright = column.certifier().stability(column.straight());
    row.seconds = now() - begin;
    row.got = followed ? fmt::format("no fold, margin {:.1e} of the upright rod without a moment", upright)
                       : "the equilibrium could not be followed";
    row.expected = "no fold where the upright rod is stable by itself";
    row.outcome = followed && !resolves(basis) && upright > -1e-9 ? Outcome::met : Outcome::not_met;
    if (row.outcome != Outcome::met) row.why = "no fold was found";
    return row;
  }
  while (high - low > 1e-12 && followed) {
    const double middle = 0.5 * (low + high);
    followed = column.bend(x, middle);
    (column.certifier().stability(x) > 0.0 ? high : low) = middle;
  }
  followed = followed && column.bend(x, high);
  const double margin = column.certifier().stability(x);
  const double found = x[moment];
  row.error = found - exact;
  Eigen::VectorXd over = x;
  followed = followed && column.bend(over, high - 1e-2);
  const double beyond = column.certifier().stability(over);
  row.seconds = now() - begin;
  row.got = fmt::format(
      "margin {:.1e} at moment {:.9g} (off by {:.1e}), tip {:.4f} rad from the vertical, margin {:.1e} beyond", margin,
      found, row.error, high, beyond);
  row.residuals = fmt::format("equilibrium {:.0e}", Eigen::VectorXd(column.program().constraints(x))
                                                        .head(column.program().layout().coordinates)
                                                        .cwiseAbs()
                                                        .maxCoeff());
  const bool good = !resolves(basis) || (std::abs(row.error) <= critical_digits && std::abs(high - angle) <= 1e-4);
  row.expected = resolves(basis) ? "fold at the exact moment to 1e-6, unstable beyond"
                                 : "a fold, its error reported, unstable beyond";
  row.outcome = followed && good && beyond < 0.0 && std::abs(margin) < 1e-6 ? Outcome::met : Outcome::not_met;
  if (row.outcome != Outcome::met) row.why = "not at the exact moment";
  return row;
}

}  // namespace

std::vector<ExtremeRow> instability_rows(plugins::Registry& registry, const Extent& extent) {
  std::vector<ExtremeRow> rows;
  for (const ExtremeModel& model : tried_models(registry, extent.quick)) {
    if (extent.stopped()) break;
    const std::unique_ptr<CoordinateModel> basis = make_model(registry, model, 1.0, 1.0);
    rows.push_back(straight_row("buckling under tip thrust", model, *basis, 0.25 * pi * pi, "Euler",
                                [](Column& column, double load) { column.load(load, 0.0, 0.0); }));
    rows.push_back(straight_row("critical weight of a rod held upright", model, *basis, 7.8373474389,
                                "root of a Bessel function",
                                [](Column& column, double load) { column.load(0.0, load, 0.5 * pi); }));
    rows.push_back(fold_row(model, *basis, 10.0, -0.24017224, 0.7272));
    rows.push_back(fold_row(model, *basis, 12.0, -0.59941729, 0.8253));
  }
  return rows;
}

std::vector<ExtremeRow> conditioning_rows(plugins::Registry& registry, const Extent& extent) {
  std::vector<ExtremeRow> rows;
  for (const ExtremeModel& model : tried_models(registry, extent.quick)) {
    if (extent.stopped()) break;
    const std::unique_ptr<CoordinateModel> basis = make_model(registry, model, 1.0, 1.0);
    ExtremeRow row;
    row.group = "orders";
    row.name = "conditioning under self-weight 1";
    row.model = model.name;
    row.backend = "-";
    row.expected = "unit roundoff times condition below the tolerance of equilibrium";
    row.source = "singular values of the second variation";
    const double begin = now();
    Column column(*basis, false);
    column.load(0.0, 1.0, 0.0);
    const Eigen::MatrixXd h = column.certifier().second_variation(column.straight());
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(h, Eigen::EigenvaluesOnly).eigenvalues();
    const double condition = values[values.size() - 1] / values[0];
    row.error = std::numeric_limits<double>::epsilon() * condition;
    row.allowed = tolerance::equilibrium;
    row.seconds = now() - begin;
    row.got = fmt::format("condition {:.3g} with {} coordinates, so {:.1e} relative error of a solve", condition,
                          values.size(), row.error);
    row.outcome = row.error > 0.0 && row.error <= row.allowed ? Outcome::met : Outcome::not_met;
    if (row.outcome != Outcome::met) row.why = "too ill-conditioned";
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tendril::bench
