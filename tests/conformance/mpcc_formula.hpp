#pragma once

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

#include "known_problems.hpp"

namespace tendril::conformance {

/// A formula with pairs: rows 0 .. plain-1 are ordinary, then G and H of each pair in turn.
template <int n, int plain, int p>
struct Sizes {
  static constexpr int variables = n;
  static constexpr int plain_rows = plain;
  static constexpr int pairs = p;
  void bounds(Bounds) const {}
};

/// The treated program: ordinary rows, all G >= 0, all H >= 0 and, for Scholtes, all G H <= parameter.
template <class Formula>
struct Treated {
  static constexpr int plain = Formula::plain_rows;
  static constexpr int pairs = Formula::pairs;
  MpccTreatment treatment = MpccTreatment::penalty;
  double parameter = 0.0;
  int variables = Formula::variables;
  int rows = plain + 2 * pairs + (treatment == MpccTreatment::scholtes ? pairs : 0);
  int residuals = 0;

  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    Formula{}(x, out);
    for (std::size_t k = 0; k < static_cast<std::size_t>(pairs); ++k) {
      const std::size_t g = static_cast<std::size_t>(plain) + 2 * k;
      const T product = out.rows[g] * out.rows[g + 1];
      if (treatment == MpccTreatment::scholtes) {
        out.rows[static_cast<std::size_t>(plain + 2 * pairs) + k] = product;
      } else {
        out.rest += parameter * product;
      }
    }
  }

  void bounds(Bounds b) const {
    b.row_upper.segment(plain, 2 * pairs).setConstant(infinity);
    if (treatment == MpccTreatment::scholtes) {
      b.row_lower.tail(pairs).setConstant(-infinity);
      b.row_upper.tail(pairs).setConstant(parameter);
    }
    Formula{}.bounds(b);
  }
};

template <class Formula>
Values<double> evaluate(ConstVectorRef x) {
  Values<double> values;
  values.rows.resize(static_cast<std::size_t>(Formula::plain_rows + 2 * Formula::pairs));
  Formula{}(x.data(), values);
  return values;
}

template <class Formula>
KnownMpcc mpcc(std::string name, std::string features, std::initializer_list<double> start, double optimum) {
  KnownMpcc p;
  p.name = std::move(name);
  p.features = std::move(features);
  p.make = [](MpccTreatment treatment, double parameter) {
    return std::make_unique<FormulaProgram<Treated<Formula>>>(Treated<Formula>{treatment, parameter});
  };
  p.complementarity = [](ConstVectorRef x) {
    const Values<double> values = evaluate<Formula>(x);
    double worst = 0.0;
    for (std::size_t k = static_cast<std::size_t>(Formula::plain_rows); k < values.rows.size(); k += 2) {
      worst = std::max(worst, std::min(values.rows[k], values.rows[k + 1]));
    }
    return worst;
  };
  p.cost = [](ConstVectorRef x) { return evaluate<Formula>(x).rest; };
  p.start.resize(static_cast<Eigen::Index>(start.size()));
  std::copy(start.begin(), start.end(), p.start.begin());
  p.optimum = optimum;
  return p;
}

}  // namespace tendril::conformance
