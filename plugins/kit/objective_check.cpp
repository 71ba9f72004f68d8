#include <cmath>
#include <random>

#include "checks.hpp"
#include "difference.hpp"
#include "quantities.hpp"
#include "tendril/bounded_off_target.hpp"
#ifdef TENDRIL_COUNTS_ALLOCATIONS
#include "allocation/counting_malloc.hpp"
#endif

namespace tendril::kit {

namespace {

/// What one call of a term gave.
template <class T>
struct Parts {
  std::size_t residual_count = 0;
  std::vector<T> residuals;
  T smooth{};

  T cost() const {
    T sum = smooth;
    for (const T& r : residuals) sum += r * r;
    return sum;
  }
};

constexpr std::size_t most_residuals = 1024;

/// A term with so many contacts and moments, as a function of a flat vector.
class Flat {
 public:
  Flat(const ObjectiveTerm& term, int contacts, int moments, const Target& target)
      : term_(term),
        inputs_(inputs(term.reads(), contacts, moments)),
        plain_(term.reads(), contacts, moments, target),
        dual_(term.reads(), contacts, moments, target) {}

  const std::vector<Input>& names() const { return inputs_; }

  /// What Reads does not ask for is zero, as in a plan.
  std::vector<double> random_point(std::mt19937& engine) const {
    std::vector<double> x;
    for (const Input& input : inputs_) {
      const double value = std::uniform_real_distribution<double>(input.low, input.high)(engine);
      x.push_back(input.asked ? value : 0.0);
    }
    return x;
  }

  Parts<double> at(const std::vector<double>& x) { return evaluate(plain_.set(x), Parts<double>{}); }

  /// From the tip to the target's position; 0 without one.
  double off_target(const std::vector<double>& x) {
    const Quantities<double>& q = plain_.set(x);
    return q.target.has_position ? norm(Vec2{q.tip.x, q.tip.y} - q.target.position) : 0.0;
  }

#ifdef TENDRIL_COUNTS_ALLOCATIONS
  /// Allocations of one evaluation in each form.
  long allocations_at(const std::vector<double>& x) {
    const std::vector<HyperDual> dual(x.begin(), x.end());
    std::vector<double> residuals(most_residuals);
    std::vector<HyperDual> dual_residuals(most_residuals);
    const Quantities<double>& plain = plain_.set(x);
    const Quantities<HyperDual>& twice = dual_.set(dual);
    Contribution<double> out(residuals);
    Contribution<HyperDual> dual_out(dual_residuals);
    const long before = test::allocations();
    term_.evaluate(plain, out);
    term_.evaluate(twice, dual_out);
    return test::allocations() - before;
  }
#endif

  Parts<HyperDual> along(const std::vector<double>& x, std::size_t a, std::size_t b) {
    std::vector<HyperDual> dual(x.begin(), x.end());
    dual[a].a = 1.0;
    dual[b].b = 1.0;
    return evaluate(dual_.set(dual), Parts<HyperDual>{});
  }

 private:
  template <class T>
  Parts<T> evaluate(const Quantities<T>& quantities, Parts<T> parts) const {
    parts.residuals.resize(most_residuals);
    Contribution<T> out(parts.residuals);
    term_.evaluate(quantities, out);
    parts.residual_count = out.residual_count();
    parts.residuals.resize(std::min(parts.residual_count, most_residuals));
    parts.smooth = out.smooth_part();
    return parts;
  }

  const ObjectiveTerm& term_;
  std::vector<Input> inputs_;
  FlatQuantities<double> plain_;
  FlatQuantities<HyperDual> dual_;
};

std::vector<double> moved(std::vector<double> x, std::size_t i, double by) {
  x[i] += by;
  return x;
}

void check_values(const ObjectiveTerm& term, Flat& flat, std::mt19937& random, Findings& findings) {
  const std::size_t residuals = flat.at(flat.random_point(random)).residual_count;
  findings.expect(
      residuals <= most_residuals, "residuals",
      "found " + std::to_string(residuals) + "; this check takes at most " + std::to_string(most_residuals));
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> x = flat.random_point(random);
    const Parts<double> parts = flat.at(x);
    const double cost = parts.cost();
    findings.expect(std::isfinite(cost), "finite",
                    "the term is " + shown(cost) + " at a sensible point; expected a number");
    findings.expect(parts.residual_count == residuals, "number of residuals",
                    "found " + std::to_string(parts.residual_count) + " at one point and " + std::to_string(residuals) +
                        " at another; expected a number that does not depend on the values (add a residual of 0)");
    findings.expect(cost >= term.lower_bound() - 1e-12 * std::abs(cost), "lower_bound",
                    "the term is " + shown(cost) + ", below lower_bound() = " + shown(term.lower_bound()) +
                        "; expected never: override lower_bound(), with -tendril::infinity if there is none. Ways of "
                        "being in contact that cannot win by this bound are left out");
    const double distance = flat.off_target(x);
    if (const auto* bounded = dynamic_cast<const BoundedOffTarget*>(&term)) {
      const double off_target = bounded->lower_bound_off_target(distance);
      const bool rises = bounded->lower_bound_off_target(0.5 * distance) <= off_target;
      findings.expect(rises && cost >= off_target - 1e-12 * std::abs(cost), "lower_bound_off_target",
                      "the term is " + shown(cost) + " where the tip is " + shown(distance) +
                          " from the target, lower_bound_off_target() there " + shown(off_target) +
                          "; expected never above the term, and not less farther from the target");
    }
    if (x.empty()) continue;
    const Parts<HyperDual> dual = flat.along(x, 0, 0);
    findings.expect(dual.residual_count == parts.residual_count, "number of residuals",
                    "evaluated for double " + std::to_string(parts.residual_count) + ", for HyperDual " +
                        std::to_string(dual.residual_count) + "; expected the same");
    // The same formula in the same order: rounding only.
    findings.expect(std::abs(dual.cost().v - cost) <= 1e-12 * (1.0 + std::abs(cost)), "two forms",
                    "evaluated for double " + shown(cost) + ", for HyperDual " + shown(dual.cost().v) +
                        "; expected the same value");
  }
}

void check_derivatives(Flat& flat, std::mt19937& random, Findings& findings) {
  constexpr double h = 1e-3;
  for (int trial = 0; trial < 4; ++trial) {
    const std::vector<double> x = flat.random_point(random);
    const double size = 1.0 + std::abs(flat.at(x).cost());
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!flat.names()[i].asked) continue;
      const auto say = [&](const std::string& of, double stated, const Difference& found) {
        return "of the " + of + " by " + flat.names()[i].name + ": stated " + shown(stated) +
               ", but differences give " + shown(found.value);
      };
      const Parts<HyperDual> here = flat.along(x, i, i);
      const Difference slope = difference([&](double t) { return flat.at(moved(x, i, t)).cost(); }, 0.0, h);
      findings.expect(agrees(here.cost().a, slope, size), "first derivative", say("term", here.cost().a, slope));
      for (std::size_t r = 0; r < here.residuals.size(); ++r) {
        const Difference of_residual =
            difference([&](double t) { return flat.at(moved(x, i, t)).residuals[r]; }, 0.0, h);
        findings.expect(agrees(here.residuals[r].a, of_residual, 1.0 + std::abs(here.residuals[r].v)),
                        "first derivative", say("residual " + std::to_string(r + 1), here.residuals[r].a, of_residual));
      }
      for (std::size_t k = i; k < x.size(); ++k) {
        if (!flat.names()[k].asked) continue;
        const Parts<HyperDual> both = flat.along(x, i, k);
        const Difference bend = difference([&](double t) { return flat.along(moved(x, k, t), i, k).cost().a; }, 0.0, h);
        findings.expect(agrees(both.cost().ab, bend, size), "second derivative",
                        say("slope by " + flat.names()[k].name, both.cost().ab, bend));
      }
    }
  }
}

/// Value and slope along a line through the values that a term reads.
struct OnLine {
  double value = 0.0, slope = 0.0, bend = 0.0;
};

/// Follows a jump of the value or of the slope along random lines into ever shorter pieces: what is smooth changes less
/// and less, a kink or a jump stays.
class SmoothnessCheck {
 public:
  SmoothnessCheck(Flat& flat, std::mt19937& random, Findings& findings)
      : flat_(flat), random_(random), findings_(findings) {}

  void run() {
    for (std::size_t i = 0; i < flat_.names().size(); ++i) {
      if (!flat_.names()[i].asked) continue;
      for (int trial = 0; trial < 4; ++trial) follow(i);
    }
  }

 private:
  OnLine at(std::size_t i, double value) {
    x_[i] = value;
    const HyperDual cost = flat_.along(x_, i, i).cost();
    return {cost.v, cost.a, cost.ab};
  }

  /// Change between two points, in units of a slope, that slope and bend do not explain.
  static double unexplained(const OnLine& a, const OnLine& b, double width) {
    return std::abs(b.slope - a.slope - 0.5 * width * (a.bend + b.bend)) +
           std::abs(b.value - a.value - 0.5 * width * (a.slope + b.slope)) / width;
  }

  void follow(std::size_t i) {
    const Input& input = flat_.names()[i];
    x_ = flat_.random_point(random_);
    constexpr int pieces = 64;
    const double step = (input.high - input.low) / pieces;
    double low = input.low;
    double largest = -1.0;
    OnLine before = at(i, low);
    double size = std::abs(before.value) + std::abs(before.slope);
    for (int p = 1; p <= pieces; ++p) {
      const double here = input.low + step * p;
      const OnLine now = at(i, here);
      size = std::max(size, std::abs(now.value) + std::abs(now.slope));
      if (const double change = unexplained(before, now, step); change > largest) {
        largest = change;
        low = here - step;
      }
      before = now;
    }
    if (!std::isfinite(size)) return;
    narrow(i, low, low + step, 1.0 + size);
  }

  void narrow(std::size_t i, double low, double high, double size) {
    OnLine left = at(i, low);
    OnLine right = at(i, high);
    for (int halving = 0; halving < 24; ++halving) {
      const double middle = 0.5 * (low + high);
      const OnLine half = at(i, middle);
      const double width = 0.5 * (high - low);
      const bool in_left = unexplained(left, half, width) >= unexplained(half, right, width);
      (in_left ? high : low) = middle;
      (in_left ? right : left) = half;
    }
    // The piece is 1e-9 wide now: a smooth term changes by about as much.
    constexpr double least = 1e-4;
    const std::string place = flat_.names()[i].name + " = " + shown(low);
    findings_.expect(std::abs(right.value - left.value) <= least * size, "jump",
                     "the term jumps from " + shown(left.value) + " to " + shown(right.value) + " at " + place +
                         "; expected a continuous one");
    findings_.expect(
        std::abs(right.slope - left.slope) <= least * size, "kink",
        "its slope jumps from " + shown(left.slope) + " to " + shown(right.slope) + " at " + place +
            "; expected a smooth term, which solvers rely on (sqrt(v^2 + 1e-6) instead of |v|, for instance)");
  }

  Flat& flat_;
  std::mt19937& random_;
  Findings& findings_;
  std::vector<double> x_;
};

#ifdef TENDRIL_COUNTS_ALLOCATIONS
void check_allocation(Flat& flat, std::mt19937& random, Findings& findings) {
  const std::vector<double> x = flat.random_point(random);
  flat.allocations_at(x);  // what a term makes once and keeps is no fault
  const long count = flat.allocations_at(x);
  findings.expect(
      count == 0, "allocation",
      "one evaluation allocates " + std::to_string(count) +
          " times; expected never, since it is evaluated thousands of times: make storage in the constructor");
}
#endif

void check_reads(const Reads& reads, Flat& flat, std::mt19937& random, Findings& findings) {
  for (const double s : reads.samples) {
    findings.expect(s >= 0.0 && s <= 1.0, "samples",
                    "Reads::samples has " + shown(s) + "; expected arc lengths s/L from 0 to 1");
  }
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<double> x = flat.random_point(random);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Input& input = flat.names()[i];
      if (input.asked) continue;
      const std::string advice =
          input.reads.empty() ? "; expected it to be left alone, since nothing hands it over (name the arc length 1 in "
                                "Reads::samples instead)"
                              : "; expected 'reads()' to say ." + input.reads + " = true, without which it is always 0";
      findings.expect(flat.at(moved(x, i, 0.5)).cost() == flat.at(x).cost(), "reads",
                      "the term changes with " + input.name + advice);
    }
  }
}

}  // namespace

void check_objective(const ObjectiveTerm& term, int moments, const Target& target, Findings& findings) {
  const Reads reads = term.reads();
  for (const int contacts : {0, 1, 2}) {
    Flat flat(term, contacts, moments, target);
    std::mt19937 random(6);
    check_values(term, flat, random, findings);
    if (flat.at(flat.random_point(random)).residual_count > most_residuals) return;
    check_reads(reads, flat, random, findings);
    check_derivatives(flat, random, findings);
    SmoothnessCheck(flat, random, findings).run();
#ifdef TENDRIL_COUNTS_ALLOCATIONS
    check_allocation(flat, random, findings);
#endif
  }
}

}  // namespace tendril::kit
