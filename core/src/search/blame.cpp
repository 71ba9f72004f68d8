#include "search/blame.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace tendril {
namespace {

/// Why the basis describes some shapes in many ways; empty: it does not.
std::string basis_fault(const CoordinateModel& model) {
  const int functions = model.function_count();
  std::vector<double> sigma(static_cast<std::size_t>(4 * functions + 20));
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    sigma[i] = (static_cast<double>(i) + 0.5) / static_cast<double>(sigma.size());
  }
  const auto rows = static_cast<Eigen::Index>(sigma.size());
  Eigen::MatrixXd value(rows, functions);
  Eigen::MatrixXd first(rows, functions);
  Eigen::MatrixXd second(rows, functions);
  model.evaluate(sigma, value, first, second);
  for (int i = 0; i < functions; ++i) {
    const double size = first.col(i).norm();
    if (!(size > 0.0)) return "its function " + std::to_string(i + 1) + " bends the rod nowhere";
    first.col(i) /= size;
  }
  // Cheap, and never the smaller one of the two: most bases end here.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(first);
  if (std::abs(qr.matrixQR()(functions - 1, functions - 1)) > 1e-6 * qr.maxPivot()) return "";
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(first, Eigen::ComputeThinV);
  // Below this, coordinates that differ visibly give shapes that differ by rounding.
  constexpr double least = 1e-11;
  if (svd.singularValues()[functions - 1] > least * svd.singularValues()[0]) return "";
  // The combination that vanishes names those that take part in it.
  const Eigen::VectorXd combination = svd.matrixV().col(functions - 1).cwiseAbs();
  std::string names;
  for (int i = 0; i < functions; ++i) {
    if (combination[i] > 1e-6 * combination.maxCoeff()) names += (names.empty() ? "" : ", ") + std::to_string(i + 1);
  }
  return "its functions " + names + " depend linearly on each other, so that one shape has many coordinates";
}

}  // namespace

void require_independent_functions(const Task& task) {
  const std::string fault = basis_fault(*task.model);
  if (fault.empty()) return;
  throw SceneError("coordinates.plugin", "coordinates plugin '" + task.scene.coordinates.plugin + "': " + fault);
}

void blame_terms(const Task& task, Plan& plan) {
  std::string blame;
  bool named = false;  // by the message that is there
  for (const PoseProgramTerm& term : task.terms) {
    if (term.fault->empty()) continue;
    const std::string name = "objective '" + term.name + "'";
    named = named || plan.message.find(name) != std::string::npos;
    blame += (blame.empty() ? "" : "; ") + name + ": " + *term.fault;
    if (plan.status == PlanStatus::solved)
      plan.left_out.push_back({"shapes where " + name + " is no number", *term.fault});
  }
  if (blame.empty() || plan.status == PlanStatus::solved || plan.status == PlanStatus::interrupted) return;
  plan.status = PlanStatus::failed;
  plan.message = blame + (plan.message.empty() || named ? "" : " (" + plan.message + ")");
}

}  // namespace tendril
