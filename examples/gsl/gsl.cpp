#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <algorithm>
#include <memory>

#include "tendril/augmented_lagrangian.hpp"
#include "tendril/plugin.hpp"

// The trust-region method for sums of squares of the GNU Scientific Library. The base turns rows and bounds into
// squares.
class GslSolver : public tendril::AugmentedLagrangianSolver {
 public:
  // GSL would end the process on an error; here its status codes are read instead.
  GslSolver() { gsl_set_error_handler_off(); }
  std::string name() const override { return "gsl"; }

 private:
  // GSL takes no "there is no number here": a value that no step is taken to stands for it. Its square is finite.
  static int residuals(const gsl_vector* x, void* problem, gsl_vector* f) {
    if (!static_cast<Subproblem*>(problem)->evaluate(x->data, f->data, nullptr)) gsl_vector_set_all(f, 1e140);
    return GSL_SUCCESS;
  }
  static int jacobian(const gsl_vector* x, void* problem, gsl_matrix* J) {
    std::vector<double> unused(J->size1);
    return static_cast<Subproblem*>(problem)->evaluate(x->data, unused.data(), J->data) ? GSL_SUCCESS : GSL_EBADFUNC;
  }

  Reduction reduce(Subproblem& problem, double* start) override {
    const auto n = static_cast<std::size_t>(problem.variable_count());
    const auto m = static_cast<std::size_t>(problem.residual_count());
    std::vector<double> probe(m);
    if (!problem.evaluate(start, probe.data(), nullptr)) return {};
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.solver = gsl_multifit_nlinear_solver_qr;
    const std::unique_ptr<gsl_multifit_nlinear_workspace, void (*)(gsl_multifit_nlinear_workspace*)> work(
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, m, n), gsl_multifit_nlinear_free);
    gsl_multifit_nlinear_fdf functions{};
    functions.f = residuals;
    functions.df = jacobian;
    functions.n = m;
    functions.p = n;
    functions.params = &problem;
    const gsl_vector_const_view from = gsl_vector_const_view_array(start, n);
    if (!work || gsl_multifit_nlinear_init(&from.vector, &functions, work.get()) != GSL_SUCCESS) return {};

    int iteration = 0;
    int status = GSL_SUCCESS;
    const auto slope = [&] { return std::max(gsl_vector_max(work->g), -gsl_vector_min(work->g)); };
    while (status == GSL_SUCCESS && slope() > problem.gradient_tolerance() && iteration < problem.iteration_limit() &&
           problem.seconds_left() > 0.0) {
      status = gsl_multifit_nlinear_iterate(work.get());
      ++iteration;
    }
    std::copy_n(gsl_multifit_nlinear_position(work.get())->data, n, start);
    // No progress: no shorter step reduces the sum either, which is a minimum within rounding.
    const bool finished = slope() <= problem.gradient_tolerance() || status == GSL_ENOPROG;
    return {status == GSL_SUCCESS || status == GSL_ENOPROG, finished, iteration, gsl_strerror(status)};
  }

  std::map<std::string, std::string> effective_options() const override {
    return {{"trs", "levenberg-marquardt"}, {"solver", "qr"}};
  }
};

TENDRIL_PLUGIN(registrar) {
  registrar.add(tendril::SolverComponent{
      "gsl", "GNU Scientific Library: least squares inside an augmented Lagrangian", {}, [](const tendril::Options&) {
        return std::make_unique<GslSolver>();
      }});
}
