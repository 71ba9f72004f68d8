#include "support/rod_flow.hpp"

#include <algorithm>

namespace tendril::support {
namespace {

constexpr int kOrder = 28;

double real(double v) { return v; }
double real(const Complex& v) { return v.real(); }

}  // namespace

template <class T>
State<T> flow(const Field<T>& f, State<T> z, double length) {
  using std::cos;
  using std::sin;
  using Series = std::array<T, kOrder + 1>;
  double remaining = length;
  while (remaining > 0.0) {
    Series angle{}, c{}, s{}, moment{};
    angle[0] = z[kAngle];
    c[0] = cos(angle[0]);
    s[0] = sin(angle[0]);
    moment[0] = z[kMoment];
    for (std::size_t k = 0; k < kOrder; ++k) {
      const double next = static_cast<double>(k + 1);
      angle[k + 1] = (moment[k] / f.stiffness + (k == 0 ? f.free_curvature : T(0.0))) / next;
      T c_sum(0.0), s_sum(0.0);
      for (std::size_t j = 0; j <= k; ++j) {
        const T turn = static_cast<double>(k + 1 - j) * angle[k + 1 - j];
        c_sum -= s[j] * turn;
        s_sum += c[j] * turn;
      }
      c[k + 1] = c_sum / next;
      s[k + 1] = s_sum / next;
      T torque = s[k] * z[kForceX] - c[k] * z[kForceY];
      if (k > 0) torque += c[k - 1] * f.weight.y - s[k - 1] * f.weight.x;
      moment[k + 1] = torque / next;
    }
    // The last two terms must not matter; both, since one of them may vanish by symmetry.
    double step = remaining;
    for (const Series* series : {&angle, &c, &s, &moment}) {
      const double size = std::max(1.0, std::abs(real(series->front())));
      for (std::size_t k : {std::size_t{kOrder} - 1, std::size_t{kOrder}}) {
        const double a = std::abs(real((*series)[k]));
        if (a > 0.0) step = std::min(step, std::pow(1e-18 * size / a, 1.0 / static_cast<double>(k)));
      }
    }
    if (!(step > 1e-9 * length)) throw BvpError("the rod turns too fast for the integrator");
    State<T> end = z;
    T x(0.0), y(0.0);
    T da(0.0), dm(0.0);
    for (std::size_t k = kOrder; k >= 1; --k) {
      da = (da + angle[k]) * step;
      dm = (dm + moment[k]) * step;
      x = (x + c[k - 1] / static_cast<double>(k)) * step;
      y = (y + s[k - 1] / static_cast<double>(k)) * step;
    }
    end[kAngle] += da;
    end[kMoment] += dm;
    end[kX] += x;
    end[kY] += y;
    end[kForceX] -= f.weight.x * step;
    end[kForceY] -= f.weight.y * step;
    z = end;
    remaining -= step;
  }
  return z;
}

template State<double> flow(const Field<double>& f, State<double> z, double length);
template State<Complex> flow(const Field<Complex>& f, State<Complex> z, double length);

}  // namespace tendril::support
