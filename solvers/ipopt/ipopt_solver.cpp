#include <dlfcn.h>

#include <IpIpoptApplication.hpp>
#include <IpRegOptions.hpp>
#include <IpTNLP.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <set>

#include "ipopt_status.hpp"
#include "tendril/plugin.hpp"
#include "tendril/solver.hpp"
#include "tendril/whole_number.hpp"

namespace tendril::ipopt_plugin {

namespace {

/// MUMPS keeps its state in global variables: one solve at a time in the whole process.
std::timed_mutex mumps_lock;

/// Options that would let a scene read or write files.
constexpr std::array<std::string_view, 3> file_options{"output_file", "file_print_level", "option_file_name"};

/// What Ipopt says of its errors, which it tells to journals only.
class ErrorJournal final : public Ipopt::Journal {
 public:
  ErrorJournal() : Journal("errors", Ipopt::J_ERROR) {}

  void clear() { text_.clear(); }
  /// The last exception's own words on one line, without the place in Ipopt's sources; empty: there was none.
  std::string reason() const {
    constexpr std::string_view head = "Exception message:";
    const auto begin = text_.rfind(head);
    if (begin == std::string::npos) return "";
    std::string line;
    for (const char c : text_.substr(begin + head.size())) {
      const bool blank = c == ' ' || c == '\n' || c == '\t';
      if (!blank) line += c;
      if (blank && !line.empty() && line.back() != ' ') line += ' ';
    }
    while (line.ends_with(' ') || line.ends_with('.')) line.pop_back();
    return line;
  }

 protected:
  void PrintImpl(Ipopt::EJournalCategory, Ipopt::EJournalLevel, const char* text) override { text_ += text; }
  void PrintfImpl(Ipopt::EJournalCategory, Ipopt::EJournalLevel, const char* format, va_list arguments) override {
    std::array<char, 1000> part{};
    std::vsnprintf(part.data(), part.size(), format, arguments);
    text_ += part.data();
  }
  void FlushBufferImpl() override {}

 private:
  std::string text_;
};

/// Ipopt's application with the options of one solver object. Making one registers hundreds of options, so it is kept.
class Application {
 public:
  explicit Application(const Options& options) : application_(new Ipopt::IpoptApplication(false)) {
    application_->RethrowNonIpoptException(false);
    for (const auto& [name, value] : options.values()) {
      set_native(name, value);
      chosen_.insert(name);
    }
    // Nothing may reach standard output, where a command may be writing its one JSON document.
    int print_level = 0;
    application_->Options()->GetIntegerValue("print_level", print_level, "");
    if (chosen_.contains("print_level") && print_level > 0) {
      application_->Jnlst()->AddFileJournal("messages", "stderr", static_cast<Ipopt::EJournalLevel>(print_level));
    }
    application_->Jnlst()->AddJournal(Ipopt::GetRawPtr(errors_));
    set("print_level", 0);
    set("sb", "yes");
    set("bound_relax_factor", 0.0);
    set("fixed_variable_treatment", "make_parameter");
    // An empty name: without it Ipopt reads ipopt.opt from the current directory.
    if (application_->Initialize("") != Ipopt::Solve_Succeeded) throw Error("ipopt cannot be initialized");
  }

  /// Sets a default of ours; what the user named stays.
  void set(const std::string& name, double value) {
    if (!chosen_.contains(name)) require(application_->Options()->SetNumericValue(name, value), name, shown(value));
  }
  void set(const std::string& name, int value) {
    if (!chosen_.contains(name))
      require(application_->Options()->SetIntegerValue(name, value), name, std::to_string(value));
  }
  void set(const std::string& name, const char* value) {
    if (!chosen_.contains(name)) require(application_->Options()->SetStringValue(name, value), name, value);
  }

  Ipopt::ApplicationReturnStatus optimize(const Ipopt::SmartPtr<Ipopt::TNLP>& program) {
    errors_->clear();
    return application_->OptimizeTNLP(program);
  }

  /// Why the last run ended with an error, in Ipopt's words.
  std::string reason() const { return errors_->reason(); }

  const std::map<std::string, std::string>& effective() const { return effective_; }

 private:
  void require(bool accepted, const std::string& name, const std::string& value) {
    if (!accepted) throw OptionError(name, {}, "ipopt refuses option '" + name + "' = " + value);
    effective_[name] = value;
  }

  void set_native(const std::string& name, const OptionValue& value) {
    for (const std::string_view file : file_options) {
      if (name == file)
        throw OptionError(name, {},
                          "option '" + name + "' of ipopt is refused: a scene must not make it read or write files");
    }
    const Ipopt::SmartPtr<const Ipopt::RegisteredOption> known = application_->RegOptions()->GetOption(name);
    if (!Ipopt::IsValid(known))
      throw OptionError(name, {}, "ipopt has no option '" + name + "'" + did_you_mean(name, known_names()));
    struct Set {
      Application& self;
      const std::string& name;
      Ipopt::RegisteredOptionType type;
      void operator()(bool v) const { (*this)(std::string(v ? "yes" : "no")); }
      void operator()(std::int64_t v) const {
        if (type == Ipopt::OT_Number) return (*this)(static_cast<double>(v));
        self.require(type == Ipopt::OT_Integer && std::abs(v) < 2147483647 &&
                         self.application_->Options()->SetIntegerValue(name, static_cast<int>(v)),
                     name, std::to_string(v));
      }
      void operator()(double v) const {
        const std::optional<std::int64_t> whole = whole_number(v);
        if (type == Ipopt::OT_Integer && whole) return (*this)(*whole);
        self.require(type == Ipopt::OT_Number && self.application_->Options()->SetNumericValue(name, v), name,
                     shown(v));
      }
      void operator()(const std::string& v) const {
        self.require(type == Ipopt::OT_String && self.application_->Options()->SetStringValue(name, v), name,
                     "'" + v + "'");
      }
      void operator()(const NumberTable&) const { self.require(false, name, "a list"); }
      void operator()(std::monostate) const {}
    };
    std::visit(Set{*this, name, known->Type()}, value);
    if (name == "linear_solver") require_library(name);
  }

  /// Ipopt loads these when they are first used, and ends the process if the library is not there.
  void require_library(const std::string& name) const {
    std::string solver;
    application_->Options()->GetStringValue(name, solver, "");
    if (solver != "ma77" && solver != "ma86" && solver != "ma97") return;
    if (void* library = ::dlopen("libhsl.so", RTLD_LAZY | RTLD_LOCAL)) {
      ::dlclose(library);
      return;
    }
    const char* reason = ::dlerror();
    throw OptionError(name, {},
                      "ipopt's linear solver '" + solver + "' is not available: " + (reason != nullptr ? reason : ""));
  }

  std::vector<std::string> known_names() const {
    std::vector<std::string> names;
    for (const auto& entry : application_->RegOptions()->RegisteredOptionsList()) names.push_back(entry.first);
    return names;
  }

  Ipopt::SmartPtr<Ipopt::IpoptApplication> application_;
  Ipopt::SmartPtr<ErrorJournal> errors_ = new ErrorJournal;
  std::set<std::string, std::less<>> chosen_;
  std::map<std::string, std::string> effective_;
};

class IpoptSolver final : public Solver {
 public:
  explicit IpoptSolver(const Options& options) : application_(options) {}

  std::string name() const override { return "ipopt"; }

  SolverCapabilities capabilities() const override {
    SolverCapabilities can;
    can.uses_hessian = true;
    return can;
  }

 private:
  /// The program as Ipopt asks for it: dense, lower triangle of the Hessian row by row.
  class Adapter final : public Ipopt::TNLP {
   public:
    Adapter(Callbacks& callbacks, const Start& start, Outcome& outcome)
        : callbacks_(callbacks),
          program_(callbacks.program()),
          start_(start),
          outcome_(outcome),
          last_finite_(start.x) {}

    bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                      IndexStyleEnum& style) override {
      n = program_.variable_count();
      m = program_.row_count();
      jacobian_entries = n * m;
      hessian_entries = n * (n + 1) / 2;
      style = C_STYLE;
      return true;
    }

    bool get_bounds_info(Ipopt::Index n, double* x_lower, double* x_upper, Ipopt::Index m, double* row_lower,
                         double* row_upper) override {
      for (int i = 0; i < n; ++i) {
        x_lower[i] = finite(program_.lower()[i]);
        x_upper[i] = finite(program_.upper()[i]);
      }
      for (int i = 0; i < m; ++i) {
        row_lower[i] = finite(program_.row_lower()[i]);
        row_upper[i] = finite(program_.row_upper()[i]);
      }
      return true;
    }

    bool get_starting_point(Ipopt::Index n, bool with_x, double* x, bool with_z, double* z_lower, double* z_upper,
                            Ipopt::Index m, bool with_rows, double* multipliers) override {
      for (int i = 0; with_x && i < n; ++i) x[i] = start_.x[i];
      for (int i = 0; with_z && i < n; ++i) {
        const double z = start_.bound_multipliers.size() > 0 ? start_.bound_multipliers[i] : 0.0;
        z_lower[i] = std::max(0.0, -z);
        z_upper[i] = std::max(0.0, z);
      }
      for (int i = 0; with_rows && i < m; ++i)
        multipliers[i] = start_.multipliers.size() > 0 ? start_.multipliers[i] : 0.0;
      return true;
    }

    bool eval_f(Ipopt::Index, const double* x, bool, double& value) override {
      return guarded(x, [&](const VectorView& at) {
        value = callbacks_.cost(at);
        // Neither coming back to where it was is progress, nor a restoration phase, which looks at rows alone.
        if (at != last_finite_) {
          last_finite_ = at;
          not_finite_ = 0;
        }
      });
    }

    bool eval_grad_f(Ipopt::Index n, const double* x, bool, double* gradient) override {
      return guarded(x,
                     [&](const VectorView& at) { Eigen::Map<Eigen::VectorXd>(gradient, n) = callbacks_.gradient(at); });
    }

    bool eval_g(Ipopt::Index, const double* x, bool, Ipopt::Index m, double* rows) override {
      return guarded(x,
                     [&](const VectorView& at) { Eigen::Map<Eigen::VectorXd>(rows, m) = callbacks_.constraints(at); });
    }

    bool eval_jac_g(Ipopt::Index n, const double* x, bool, Ipopt::Index m, Ipopt::Index, Ipopt::Index* rows,
                    Ipopt::Index* columns, double* values) override {
      if (values != nullptr) {
        return guarded(
            x, [&](const VectorView& at) { Eigen::Map<Eigen::MatrixXd>(values, m, n) = callbacks_.jacobian(at); });
      }
      for (int j = 0, k = 0; j < n; ++j) {
        for (int i = 0; i < m; ++i, ++k) {
          rows[k] = i;
          columns[k] = j;
        }
      }
      return true;
    }

    bool eval_h(Ipopt::Index n, const double* x, bool, double factor, Ipopt::Index m, const double* multipliers, bool,
                Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns, double* values) override {
      if (values != nullptr) {
        return guarded(x, [&](const VectorView& at) {
          const MatrixView h = callbacks_.hessian(at, factor, point(multipliers, m));
          for (int j = 0, k = 0; j < n; ++j) {
            for (int i = j; i < n; ++i, ++k) values[k] = h(i, j);
          }
        });
      }
      for (int j = 0, k = 0; j < n; ++j) {
        for (int i = j; i < n; ++i, ++k) {
          rows[k] = i;
          columns[k] = j;
        }
      }
      return true;
    }

    bool intermediate_callback(Ipopt::AlgorithmMode, Ipopt::Index iteration, double, double, double, double, double,
                               double, double, double, Ipopt::Index, const Ipopt::IpoptData*,
                               Ipopt::IpoptCalculatedQuantities*) override {
      outcome_.iterations = iteration;
      return !callbacks_.must_stop();
    }

    void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const double* x, const double* z_lower,
                           const double* z_upper, Ipopt::Index m, const double*, const double* multipliers, double,
                           const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
      outcome_.x.assign(x, x + n);
      outcome_.multipliers.assign(multipliers, multipliers + m);
      outcome_.bound_multipliers.resize(static_cast<std::size_t>(n));
      for (std::size_t i = 0; i < outcome_.bound_multipliers.size(); ++i)
        outcome_.bound_multipliers[i] = z_upper[i] - z_lower[i];
    }

   private:
    static VectorView point(const double* x, Ipopt::Index n) { return {x, n}; }
    static double finite(double bound) { return std::clamp(bound, -2e19, 2e19); }

    /// False makes Ipopt shorten its step; after a recorded exception every answer is false until it gives up.
    template <class F>
    bool guarded(const double* x, F&& evaluate) {
      if (callbacks_.has_exception()) return false;
      const VectorView here = point(x, program_.variable_count());
      try {
        evaluate(here);
        return true;
      } catch (const NotFiniteError& e) {
        outcome_.message = e.what();
        if (++not_finite_ > shortenings) callbacks_.record_exception();
        return false;
      } catch (...) {
        callbacks_.record_exception();
        return false;
      }
    }

    /// After so many shortened steps in a row there is nothing finite to step to.
    static constexpr int shortenings = 30;

    Callbacks& callbacks_;
    const NonlinearProgram& program_;
    const Start& start_;
    Outcome& outcome_;
    Eigen::VectorXd last_finite_;
    int not_finite_ = 0;
  };

  std::string refusal(const NonlinearProgram& program) const override {
    int free_variables = 0;
    int equalities = 0;
    for (int i = 0; i < program.variable_count(); ++i)
      free_variables += program.lower()[i] < program.upper()[i] ? 1 : 0;
    for (int i = 0; i < program.row_count(); ++i) equalities += program.is_equality(i) ? 1 : 0;
    if (equalities > free_variables) {
      return "ipopt cannot take more equality constraints than free variables: " + std::to_string(equalities) +
             " rows, " + std::to_string(free_variables) + " variables";
    }
    return "";
  }

  void set_options(const Start& start, const SolveControl& control) {
    application_.set("tol", control.tolerance);
    application_.set("constr_viol_tol", control.tolerance);
    application_.set("max_iter", control.max_iterations);
    const bool warm = start.has_multipliers();
    application_.set("warm_start_init_point", warm ? "yes" : "no");
    // A warm start must stay where it is: Ipopt would push it well inside the bounds. Cold values are Ipopt's own.
    application_.set("mu_init", warm ? 1e-9 : 0.1);
    for (const char* push : {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
                             "warm_start_slack_bound_frac", "warm_start_mult_bound_push"}) {
      application_.set(push, warm ? 1e-10 : 1e-3);
    }
  }

  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) override {
    Outcome outcome;
    std::unique_lock<std::timed_mutex> lock(mumps_lock, std::defer_lock);
    if (std::isfinite(control.time_limit)) {
      if (!lock.try_lock_for(std::chrono::duration<double>(std::max(0.0, callbacks.seconds_left())))) {
        outcome.status = SolveStatus::time_limit;
        outcome.message = "another solve of this process held Ipopt's linear solver for all of the time";
        return outcome;
      }
    } else {
      lock.lock();
    }
    set_options(start, control);
    const Ipopt::SmartPtr<Ipopt::TNLP> adapter = new Adapter(callbacks, start, outcome);
    const Ipopt::ApplicationReturnStatus result = application_.optimize(adapter);
    outcome.status = status_of(result);
    outcome.native_status = words(result);
    if (outcome.status == SolveStatus::interrupted && callbacks.seconds_left() <= 0.0) {
      outcome.status = SolveStatus::time_limit;
      outcome.message = "the time limit of " + shown(control.time_limit) + " s is over";
    }
    if (outcome.status == SolveStatus::converged) outcome.message.clear();
    if (outcome.status == SolveStatus::failed && outcome.message.empty()) outcome.message = application_.reason();
    outcome.effective_options = application_.effective();
    complete_fixed(callbacks, outcome);
    return outcome;
  }

  /// Variables that Ipopt treats as parameters come back without a multiplier: it is what balances their column.
  static void complete_fixed(Callbacks& callbacks, Outcome& outcome) {
    const NonlinearProgram& program = callbacks.program();
    const VectorView x(outcome.x.data(), static_cast<Eigen::Index>(outcome.x.size()));
    const VectorView y(outcome.multipliers.data(), static_cast<Eigen::Index>(outcome.multipliers.size()));
    if (callbacks.has_exception() || x.size() == 0 || !x.allFinite() || outcome.status != SolveStatus::converged)
      return;
    for (int i = 0; i < program.variable_count(); ++i) {
      if (program.lower()[i] < program.upper()[i]) continue;
      outcome.bound_multipliers[static_cast<std::size_t>(i)] =
          -callbacks.gradient(x)[i] - callbacks.jacobian(x).col(i).dot(y);
    }
  }

  Application application_;
};

}  // namespace

}  // namespace tendril::ipopt_plugin

TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  OptionSpec any;
  any.name = any_option;
  any.type = OptionType::text;
  any.description = "every option of Ipopt by its own name, except those that read or write files";
  registrar.add(SolverComponent{"ipopt",
                                "Ipopt: interior point with the exact Hessian",
                                {any},
                                [](const Options& options) -> std::unique_ptr<Solver> {
                                  return std::make_unique<ipopt_plugin::IpoptSolver>(options);
                                }});
}
