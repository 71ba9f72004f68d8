#include "certificate/certifier.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "certificate/out_of_plane.hpp"
#include "nlp/multipliers.hpp"
#include "obstacle/shrunk.hpp"
#include "program/stability.hpp"
#include "rod/rule_error.hpp"
#include "tendril/error.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// What a rule may leave in a row of a program that is judged on this rule alone: a hundredth of what doubling it may
/// show.
constexpr double rule_is_exact = 1e-2 * tolerance::quadrature;

std::string defect(const char* what, double value, double limit) {
  return what + (' ' + shown_with_exponent(value)) + " is above " + shown_with_exponent(limit, 1);
}

/// It buckles sideways.
bool leaves_plane(const Certificate& c) {
  return c.out_of_plane && !c.guided_in_plane && !(*c.out_of_plane >= -tolerance::out_of_plane);
}

/// Somewhere the rod lies along an obstacle instead of touching it at a point.
bool spreads(const Certificate& c) { return !(c.contact_convexity > tolerance::convexity); }

}  // namespace

double axial_force(const PoseProgram& program) {
  double sum = -program.spec().palm->load;
  for (const PoseProgram::ContactState& c : program.contacts()) sum += c.force * dot(c.push, program.spec().palm->axis);
  return sum;
}

struct Certifier::Data {
  explicit Data(const PoseProgramSpec& s) : Data(s, std::make_unique<PoseProgram>(doubled(s)), nullptr) {}
  explicit Data(PoseProgram& judged) : Data(judged.spec(), nullptr, &judged) {}
  Data(const PoseProgramSpec& s, std::unique_ptr<PoseProgram> twice, PoseProgram* judged)
      : spec(doubled(s)),
        own(judged),
        fine(std::move(twice)),
        program(judged != nullptr ? judged : fine.get()),
        stability(*program) {
    for (const Obstacle* o : spec.obstacles) shrunk.emplace_back(*o);
    if (spec.rod->has_torsion()) out_of_plane = std::make_unique<OutOfPlane>();
    if (judged != nullptr && !out_of_plane && !spec.rod->has_dead_loads()) rule_error.emplace(judged->chain());
  }

  static PoseProgramSpec doubled(PoseProgramSpec s) {
    s.nodes *= 2;
    return s;
  }

  /// The program on twice the nodes, made where it is needed.
  PoseProgram& doubled_program() {
    if (!fine) {
      fine = std::make_unique<PoseProgram>(spec);
      fine->set_loads(own->loads());
    }
    return *fine;
  }

  /// What the rule of the judged program leaves in any of its rows at the point that it was evaluated at last.
  double own_error() const {
    const RuleError::Bound bound = rule_error->of(own->backbone());
    const Loads& loads = own->loads();
    double weight = spec.rod->payload;
    for (const Rod::Segment& segment : spec.rod->segments) weight += segment.whole_weight();
    double force = norm(loads.tip_force) + norm(loads.gravity) * weight;
    for (const PoseProgram::ContactState& c : own->contacts()) {
      force += std::abs(c.force) * norm(c.push) + std::abs(c.shear);
    }
    // A force turns each piece by its own integral and, through its arm, by those of all pieces before it.
    return 2.0 * (1.0 + force) * bound.integral + bound.tangent;
  }

  /// The program that x is read from and its curve there. The curve is followed again only where the program was
  /// evaluated anew.
  void move(ConstVectorRef x) {
    exact = false;
    if (rule_error && rule_error->known()) {
      own->jacobian(x);
      error = own_error();
      exact = error <= rule_is_exact;
    }
    PoseProgram& at = exact ? *own : doubled_program();
    at.jacobian(x);
    if (&at == program && at.counts().first_derivatives == followed) return;
    if (&at != program || !curve) curve = std::make_unique<Curve>(at.chain().curve_tables());
    program = &at;
    followed = at.counts().first_derivatives;
    curve->follow(program->backbone());
    if (spec.carried == 0) return;
    if (!from_palm) from_palm = std::make_unique<Curve>(at.chain().curve_tables());
    *from_palm = *curve;
    from_palm->translate(-program->base_shift());
    from_palm->strip();
  }

  /// Obstacles that the rod has to keep out of.
  std::size_t bodies() const { return spec.obstacles.size() - static_cast<std::size_t>(spec.measures); }

  /// An obstacle in the size that it has under the present loads.
  const Obstacle& obstacle(std::size_t o) const {
    if (program->loads().shrink[o] == 0.0) return *spec.obstacles[o];
    return shrunk[o];
  }

  /// The rod in the frame of an obstacle; of what stands on the palm the body may lie on it, too.
  const Curve& curve_beside(std::size_t obstacle) const {
    return obstacle + static_cast<std::size_t>(spec.carried) >= spec.obstacles.size() ? *from_palm : *curve;
  }

  double margin(ConstVectorRef x) { return stability.margin(*program, x); }
  /// A quadratic form that holds for half of all disturbances is positive there only if it is for all of them: a
  /// contact at the end of the rod has to hold it as one that slides and as one at the tip.
  double margin_to_both_sides(ConstVectorRef x) {
    const double sliding = margin(x);
    bool leans = false;
    for (int k = 0; k < program->layout().forces; ++k) leans = leans || Stability::leans_on_end(*program, k);
    if (!leans) return sliding;
    stability.hold_ends(true);
    const double held = margin(x);
    stability.hold_ends(false);
    return std::min(sliding, held);
  }
  void judge_stationarity(PoseProgram& judged, ConstVectorRef x, Certificate& c, const Eigen::VectorXd* multipliers,
                          const Eigen::VectorXd* bound_multipliers);

  PoseProgramSpec spec;                 ///< on twice the nodes
  PoseProgram* own;                     ///< whose points are judged; null: any program's
  std::unique_ptr<PoseProgram> fine;    ///< null: not needed yet
  PoseProgram* program;                 ///< the one of these that the last point is read from
  std::optional<RuleError> rule_error;  ///< of `own`; nothing where it is not asked for
  double error = 0.0;                   ///< of its rows at the last point
  bool exact = false;                   ///< that is nothing but rounding
  std::vector<ShrunkObstacle> shrunk;   ///< one per obstacle
  std::unique_ptr<Curve> curve, from_palm;
  std::int64_t followed = 0;  ///< evaluations of the program when the curve was made

  Stability stability;
  std::unique_ptr<OutOfPlane> out_of_plane;  ///< null: torsion is not known
  // Memory that is used again.
  Eigen::VectorXd rows;
  std::vector<int> biactive;
  std::vector<Branch> branches;
  std::vector<ClosestApproach> near;
  KktJudgement known;
};

Certifier::Certifier(const PoseProgramSpec& spec) : data_(std::make_unique<Data>(spec)) {}
Certifier::Certifier(PoseProgram& judged) : data_(std::make_unique<Data>(judged)) {}
Certifier::~Certifier() = default;
Certifier::Certifier(Certifier&&) noexcept = default;
Certifier& Certifier::operator=(Certifier&&) noexcept = default;

void Certifier::Data::judge_stationarity(PoseProgram& judged, ConstVectorRef x, Certificate& c,
                                         const Eigen::VectorXd* multipliers, const Eigen::VectorXd* bound_multipliers) {
  const PoseProgram::Layout& at = program->layout();
  // The tightened program: the branch of each contact is what the point says it is.
  biactive.clear();
  branches.clear();
  bool as_judged = true;
  for (int k = 0; k < at.forces; ++k) {
    const PoseProgram::ContactState& state = program->contacts()[static_cast<std::size_t>(k)];
    const bool touches =
        judged.branch(k) == Branch::touching || std::abs(state.surface.distance) <= tolerance::complementarity;
    const bool pushes = state.force > tolerance::complementarity;
    if (touches && !pushes) biactive.push_back(k);
    branches.push_back(touches ? Branch::touching : Branch::separated);
    as_judged = as_judged && judged.branch(k) == branches.back();
  }
  // The judged program itself stays as it is.
  PoseProgram& tight = exact && as_judged && biactive.empty() ? *program : doubled_program();
  const auto set_branch = [&](int contact, Branch branch) {
    if (tight.branch(contact) != branch) tight.set_branch(contact, branch);
  };
  for (int k = 0; k < at.forces; ++k) set_branch(k, branches[static_cast<std::size_t>(k)]);
  constexpr double active = 1e-8;
  if (multipliers != nullptr && bound_multipliers != nullptr && biactive.empty()) {
    judge_kkt(tight, x, active, *multipliers, *bound_multipliers, known);
    c.stationarity = known.stationarity;
    c.stationarity_kind = "S";
    if (known.stationarity <= tolerance::stationarity) return;
  }
  const KktJudgement best = judge_kkt(tight, x, active);
  c.stationarity = best.stationarity;
  c.stationarity_kind = best.stationarity <= tolerance::stationarity ? "S" : "none";
  if (biactive.empty() || c.stationarity_kind == "none") return;
  // Gap and force both zero: the gap's multiplier must be that of g >= 0 for strong stationarity.
  for (const int k : biactive) set_branch(k, Branch::open);
  const KktJudgement strong = judge_kkt(tight, x, active);
  if (strong.stationarity <= tolerance::stationarity) {
    c.stationarity = strong.stationarity;
    return;
  }
  c.stationarity_kind = "M";
  for (const int k : biactive) {
    const double gap = -best.multipliers[at.first_gap + k];
    const double force = -best.bound_multipliers[at.first_force + k];
    const double small = tolerance::stationarity;
    if (std::abs(gap) <= small || std::abs(force) <= small || (gap > 0.0 && force > 0.0)) continue;
    c.stationarity_kind = gap * force > 0.0 ? "C" : "none";
    if (gap * force <= 0.0) return;
  }
}

Certificate Certifier::certify(PoseProgram& judged, ConstVectorRef x) {
  Certificate c;
  certify(judged, x, c, nullptr, nullptr);
  return c;
}

void Certifier::set_target(const Target& target) {
  data_->spec.target = target;
  if (data_->fine) data_->fine->set_target(target);
}

void Certifier::certify(PoseProgram& judged, ConstVectorRef x, Certificate& c, const Eigen::VectorXd* multipliers,
                        const Eigen::VectorXd* bound_multipliers) {
  if (!x.allFinite()) {
    c = Certificate{};
    c.failures.assign(1, "the plan is not finite");
    return;
  }
  measure(judged, x, c);
  const PoseProgram::Layout& at = data_->program->layout();
  c.balance = at.balances > 0 ? std::abs(axial_force(*data_->program)) : 0.0;
  data_->judge_stationarity(judged, x, c, multipliers, bound_multipliers);
  list_failures(c);
}

void Certifier::measure(PoseProgram& judged, ConstVectorRef x, Certificate& c) {
  judge(judged, x, c);
  c.moment_balance = data_->program->moment_defect(x, *data_->curve);
}

void Certifier::judge(PoseProgram& judged, ConstVectorRef x, Certificate& c) {
  Data& d = *data_;
  c.contact_convexity = infinity;
  const PoseProgram::Layout& at = d.program->layout();
  d.move(x);
  const Eigen::VectorXd& rows = d.rows = d.program->constraints(x);
  if (rows.size() != judged.row_count()) throw Error("the program to be judged has other check points than its judge");
  c.quadrature = d.error;
  if (!d.exact) {
    // Where nothing touches and nothing pulls no row depends on where the rod is, but what is asked of its tip does.
    c.quadrature = std::max((rows - judged.constraints(x)).cwiseAbs().maxCoeff(),
                            norm(d.program->backbone().tip() - judged.backbone().tip()));
  }
  c.equilibrium = rows.head(at.coordinates).cwiseAbs().maxCoeff() + (d.exact ? d.error : 0.0);

  c.bounds = 0.0;
  for (int i = 0; i < judged.variable_count(); ++i) {
    // Limits are those of the scene: a branch that holds a force at zero is no limit.
    const bool force = i >= at.first_force && i < at.first_force + at.forces;
    const double low = force ? d.spec.min_force : judged.lower()[i];
    const double high = force ? d.spec.max_force : judged.upper()[i];
    c.bounds = std::max({c.bounds, low - x[i], x[i] - high});
  }

  const auto keep_rows = [&](int first, int count) {
    for (int i = first; i < first + count; ++i) {
      c.bounds = std::max({c.bounds, d.program->row_lower()[i] - rows[i], rows[i] - d.program->row_upper()[i]});
    }
  };
  keep_rows(at.first_target, at.targets);
  keep_rows(at.first_shortening, at.shortenings);

  c.penetration = 0.0;
  for (std::size_t o = 0; o < d.bodies(); ++o) {
    c.penetration = std::max(c.penetration, certified_depth(d.curve_beside(o), d.obstacle(o)));
  }

  c.complementarity = 0.0;
  c.closest_point = 0.0;
  for (int k = 0; k < at.forces; ++k) {
    const PoseProgram::ContactState& state = d.program->contacts()[static_cast<std::size_t>(k)];
    c.complementarity = std::max(c.complementarity, std::abs(std::min(state.surface.distance, state.force)));
    if (!(state.force > tolerance::force)) continue;
    const double slope = dot(state.tangent, state.surface.normal) - state.radius.slope;
    const bool at_tip = d.spec.contacts[static_cast<std::size_t>(k)].at_tip;
    c.closest_point = std::max(c.closest_point, at_tip ? std::max(0.0, slope) : std::abs(slope));
    const double convexity = d.program->contact_convexity(k);
    if (std::isnan(convexity) || convexity < c.contact_convexity) c.contact_convexity = convexity;
  }
  c.stability = spreads(c) ? -infinity : d.margin_to_both_sides(x);
  c.held_lengths = spreads(c) ? 0 : d.stability.held_lengths();
  if (d.out_of_plane) c.out_of_plane = d.out_of_plane->margin(*d.program, *d.curve);
  c.guided_in_plane = d.spec.rod->guided;
  c.least_stretch = 1.0;
  for (int j = 0; j < d.program->chain().piece_count() && d.spec.rod->stretches(); ++j) {
    for (int g = 0; g < d.program->chain().nodes(); ++g) {
      c.least_stretch = std::min(c.least_stretch, d.program->backbone().stretch(j, g));
    }
  }
}

Certificate worse_of(const Certificate& a, const Certificate& b) {
  Certificate c = a;
  // What is no number is worse than any.
  const auto larger = [](double& kept, double value) {
    if (std::isnan(value) || value > kept) kept = value;
  };
  const auto smaller = [](double& kept, double value) {
    if (std::isnan(value) || value < kept) kept = value;
  };
  larger(c.equilibrium, b.equilibrium);
  larger(c.bounds, b.bounds);
  larger(c.penetration, b.penetration);
  larger(c.complementarity, b.complementarity);
  larger(c.closest_point, b.closest_point);
  larger(c.balance, b.balance);
  larger(c.stationarity, b.stationarity);
  larger(c.moment_balance, b.moment_balance);
  larger(c.quadrature, b.quadrature);
  smaller(c.stability, b.stability);
  c.held_lengths += b.held_lengths;
  smaller(c.contact_convexity, b.contact_convexity);
  smaller(c.least_stretch, b.least_stretch);
  if (b.out_of_plane) {
    c.out_of_plane = c.out_of_plane.value_or(infinity);
    smaller(*c.out_of_plane, *b.out_of_plane);
  }
  const auto weakness = [](const std::string& kind) { return kind == "S" ? 0 : kind == "M" ? 1 : kind == "C" ? 2 : 3; };
  if (weakness(b.stationarity_kind) > weakness(c.stationarity_kind)) c.stationarity_kind = b.stationarity_kind;
  c.failures.insert(c.failures.end(), b.failures.begin(), b.failures.end());
  return c;
}

void list_failures(Certificate& c) {
  c.failures.clear();
  if (!(c.equilibrium <= tolerance::equilibrium))
    c.failures.push_back(defect("equilibrium residual", c.equilibrium, tolerance::equilibrium));
  if (!(c.balance <= tolerance::balance))
    c.failures.push_back(defect("net force on the object", c.balance, tolerance::balance));
  if (!(c.bounds <= tolerance::bounds))
    c.failures.push_back(defect("violation of a limit", c.bounds, tolerance::bounds));
  if (!(c.penetration <= tolerance::penetration))
    c.failures.push_back(defect("penetration", c.penetration, tolerance::penetration));
  if (!(c.complementarity <= tolerance::complementarity))
    c.failures.push_back(defect("complementarity", c.complementarity, tolerance::complementarity));
  if (!(c.closest_point <= tolerance::closest_point))
    c.failures.push_back(defect("closest point", c.closest_point, tolerance::closest_point));
  if (!(c.stationarity <= tolerance::stationarity))
    c.failures.push_back(defect("stationarity", c.stationarity, tolerance::stationarity));
  if (c.stationarity <= tolerance::stationarity && c.stationarity_kind != "S") {
    c.failures.push_back("the point is " +
                         (c.stationarity_kind == "none" ? std::string("not even C") : c.stationarity_kind) +
                         "-stationary, not S-stationary");
  }
  if (!(c.least_stretch > 0.0)) {
    c.failures.push_back("the rod is compressed to nothing: 1 + its stretch falls to " +
                         shown_with_exponent(c.least_stretch, 4));
  }
  if (spreads(c)) {
    c.failures.emplace_back("contact spreads: the rod lies along the obstacle, a point contact does not hold it");
  } else if (!(c.stability > tolerance::stability)) {
    c.failures.push_back("unstable: the stability margin is " + shown_with_exponent(c.stability, 4));
  }
  if (leaves_plane(c)) {
    c.failures.push_back("unstable out of its plane: the margin there is " + shown_with_exponent(*c.out_of_plane, 4));
  }
}

bool only_unstable(const Certificate& c) {
  return c.failures.size() == 1 && !spreads(c) && (!(c.stability > tolerance::stability) || leaves_plane(c));
}

std::vector<Certifier::Approach> Certifier::approaches(ConstVectorRef x, double level) {
  Data& d = *data_;
  d.move(x);
  std::vector<Approach> all;
  for (std::size_t o = 0; o < d.bodies(); ++o) {
    for (const ClosestApproach& at : closest_approaches(d.curve_beside(o), d.obstacle(o), level)) {
      all.push_back({static_cast<int>(o), at});
    }
  }
  return all;
}

const PoseProgram& Certifier::finer(ConstVectorRef x) {
  data_->move(x);
  return *data_->program;
}

const Curve& Certifier::curve() const { return *data_->curve; }

bool Certifier::approached(ConstVectorRef x, double level) {
  Data& d = *data_;
  d.move(x);
  d.near.clear();
  for (std::size_t o = 0; o < d.bodies() && d.near.empty(); ++o) {
    closest_approaches(d.curve_beside(o), d.obstacle(o), level, d.near);
  }
  return !d.near.empty();
}

void Certifier::set_loads(const Loads& loads) {
  data_->doubled_program().set_loads(loads);
  for (std::size_t o = 0; o < loads.shrink.size(); ++o) data_->shrunk[o].shrink(loads.shrink[o]);
}

double Certifier::moment_balance(ConstVectorRef x) {
  data_->move(x);
  return data_->program->moment_defect(x, *data_->curve);
}

double Certifier::stability(ConstVectorRef x) {
  data_->move(x);
  return data_->margin(x);
}

Eigen::MatrixXd Certifier::second_variation(ConstVectorRef x) {
  data_->move(x);
  Eigen::MatrixXd h;
  data_->stability.second_variation(*data_->program, x, h);
  return h;
}

double Certifier::contact_convexity(ConstVectorRef x, int contact) {
  data_->move(x);
  return data_->program->contact_convexity(contact);
}

}  // namespace tendril
