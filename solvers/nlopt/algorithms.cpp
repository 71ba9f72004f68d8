#include "algorithms.hpp"

#include <algorithm>

namespace tendril::nlopt_plugin {

namespace {

Algorithm local(std::string_view name, nlopt_algorithm id, bool gradient) {
  Algorithm a{name, id};
  a.gradient = gradient;
  return a;
}

Algorithm global(std::string_view name, nlopt_algorithm id, bool random) {
  Algorithm a{name, id};
  a.finite_bounds = true;
  a.random = random;
  return a;
}

Algorithm with_rows(Algorithm a, bool equalities) {
  a.equalities = equalities;
  a.inequalities = true;
  return a;
}

Algorithm with_inner(Algorithm a) {
  a.has_inner = true;
  return a;
}

Algorithm from(Algorithm a, int least_variables) {
  a.least_variables = least_variables;
  return a;
}

const std::vector<Algorithm>& algorithms() {
  static const std::vector<Algorithm> all = [] {
    Algorithm slsqp = with_rows(local("LD_SLSQP", NLOPT_LD_SLSQP, true), true);
    slsqp.halves_step = true;
    Algorithm newuoa = from(local("LN_NEWUOA", NLOPT_LN_NEWUOA, false), 2);
    newuoa.bounds = false;
    Algorithm gd_mlsl = with_inner(global("GD_MLSL", NLOPT_GD_MLSL, true));
    Algorithm gd_mlsl_lds = with_inner(global("GD_MLSL_LDS", NLOPT_GD_MLSL_LDS, true));
    gd_mlsl.gradient = gd_mlsl_lds.gradient = true;
    return std::vector<Algorithm>{
        slsqp,
        with_rows(local("LD_MMA", NLOPT_LD_MMA, true), false),
        with_rows(local("LD_CCSAQ", NLOPT_LD_CCSAQ, true), false),
        with_inner(with_rows(local("LD_AUGLAG", NLOPT_LD_AUGLAG, true), true)),
        with_inner(with_rows(local("LD_AUGLAG_EQ", NLOPT_LD_AUGLAG_EQ, true), true)),
        local("LD_LBFGS", NLOPT_LD_LBFGS, true),
        local("LD_VAR1", NLOPT_LD_VAR1, true),
        local("LD_VAR2", NLOPT_LD_VAR2, true),
        local("LD_TNEWTON", NLOPT_LD_TNEWTON, true),
        local("LD_TNEWTON_RESTART", NLOPT_LD_TNEWTON_RESTART, true),
        local("LD_TNEWTON_PRECOND", NLOPT_LD_TNEWTON_PRECOND, true),
        local("LD_TNEWTON_PRECOND_RESTART", NLOPT_LD_TNEWTON_PRECOND_RESTART, true),
        with_rows(local("LN_COBYLA", NLOPT_LN_COBYLA, false), true),
        with_inner(with_rows(local("LN_AUGLAG", NLOPT_LN_AUGLAG, false), true)),
        with_inner(with_rows(local("LN_AUGLAG_EQ", NLOPT_LN_AUGLAG_EQ, false), true)),
        from(local("LN_BOBYQA", NLOPT_LN_BOBYQA, false), 2),
        newuoa,
        from(local("LN_NEWUOA_BOUND", NLOPT_LN_NEWUOA_BOUND, false), 2),
        from(local("LN_PRAXIS", NLOPT_LN_PRAXIS, false), 2),
        local("LN_NELDERMEAD", NLOPT_LN_NELDERMEAD, false),
        local("LN_SBPLX", NLOPT_LN_SBPLX, false),
        with_rows(global("GN_ISRES", NLOPT_GN_ISRES, true), true),
        global("GN_ESCH", NLOPT_GN_ESCH, true),
        global("GN_CRS2_LM", NLOPT_GN_CRS2_LM, true),
        global("GN_DIRECT", NLOPT_GN_DIRECT, false),
        global("GN_DIRECT_L", NLOPT_GN_DIRECT_L, false),
        global("GN_DIRECT_L_RAND", NLOPT_GN_DIRECT_L_RAND, true),
        with_rows(global("GN_ORIG_DIRECT", NLOPT_GN_ORIG_DIRECT, false), false),
        with_rows(global("GN_ORIG_DIRECT_L", NLOPT_GN_ORIG_DIRECT_L, false), false),
        with_inner(global("GN_MLSL", NLOPT_GN_MLSL, true)),
        with_inner(global("GN_MLSL_LDS", NLOPT_GN_MLSL_LDS, true)),
        gd_mlsl,
        gd_mlsl_lds,
    };
  }();
  return all;
}

}  // namespace

const Algorithm* find_algorithm(std::string_view name) {
  const auto& all = algorithms();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Algorithm& a) { return a.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::vector<std::string> algorithm_names() {
  std::vector<std::string> names;
  for (const Algorithm& a : algorithms()) names.emplace_back(a.name);
  return names;
}

}  // namespace tendril::nlopt_plugin
