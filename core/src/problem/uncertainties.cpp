#include "problem/uncertainties.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "problem/scene_numbers.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

UncertainNumber number_of(const SceneChange& change) {
  UncertainNumber number;
  if (change.rod) number.rod = change.rod(1.0);
  number.step = change.step;
  number.motion = change.motion;
  number.moves = change.moves;
  number.length = change.length;
  number.stiffness = change.stiffness;
  return number;
}

/// A number of the law of an actuator, by its moment.
UncertainNumber number_of(const ActuatorSpec& actuator, const Spread::Law& law, double unit) {
  UncertainNumber number;
  number.actuator = static_cast<int>(law.actuator);
  number.held = [&actuator, power = law.power, unit](double moment) {
    const auto gain = actuator.gain_of(power, unit * moment);
    return Rod::Jet{gain->rate / unit, gain->slope};
  };
  return number;
}

/// A root of the correlations: with each independent deviation, a column, so much of a number's own goes along.
Eigen::MatrixXd root_of_correlations(const std::vector<Spread>& spreads) {
  const auto count = static_cast<Eigen::Index>(spreads.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Identity(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& known = spreads[static_cast<std::size_t>(i)].correlations;
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto found = known.find(spreads[static_cast<std::size_t>(k)].key);
      if (found != known.end() && k != i) all(i, k) = found->second;
    }
  }
  if (all.isIdentity(0.0)) return all;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(all);
  // Correlations as they are written may be those of nothing, by rounding.
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

std::string undifferentiated(const Rod& rod) {
  if (rod.stretches()) return "rods that stretch are not differentiated";
  if (rod.draws()) return "rods that are drawn into a port are not differentiated";
  if (std::any_of(rod.actuators.begin(), rod.actuators.end(), [](const Rod::Actuator& a) { return a.by_length; })) {
    return "tendons that are told their length are not differentiated";
  }
  return "";
}

std::shared_ptr<const Uncertainties> uncertainties_of(const Task& task, const std::string& path,
                                                      const std::string& needs) {
  const std::vector<Spread>& spreads = task.scene.spreads;
  const auto refuse = [&](const std::string& why) { throw SceneError(path, needs + why); };
  if (spreads.empty()) refuse("a number with an error bar (\"4.9e-4 N m^2 +- 5 %\"), but the scene has none");
  if (task.palm) refuse("error bars, but grasps are not differentiated");
  if (!task.friction.empty()) refuse("error bars, but contacts that stick or slip are not differentiated");
  if (const std::string why = undifferentiated(task.rod); !why.empty()) refuse("error bars, but " + why);
  if (!task.rod.moves.empty())
    refuse("error bars, but rods that choose where their base stands are not differentiated");
  std::vector<std::string> keys;
  for (const Spread& spread : spreads) {
    for (const Spread::Part& part : spread.parts) keys.push_back(part.key);
  }
  const std::vector<SceneEntry> entries = scene_entries(task.scene, task.scale, task.rod, keys);
  auto out = std::make_shared<Uncertainties>();
  std::vector<std::pair<std::size_t, double>> of_spread;  // of each number: whose it is, and its rate
  for (std::size_t k = 0; k < spreads.size(); ++k) {
    const auto unknown = [&](const std::string& why) {
      refuse("error bars, but by '" + spreads[k].key + "' nothing is differentiated: " + why);
    };
    for (const Spread::Part& part : spreads[k].parts) {
      const auto entry =
          std::find_if(entries.begin(), entries.end(), [&](const SceneEntry& e) { return e.number.key == part.key; });
      if (entry == entries.end()) unknown("it moves nothing that is known");
      const SceneChange change = entry->change();
      if (!change.trouble.empty()) unknown(change.trouble);
      out->numbers.push_back(number_of(change));
      of_spread.emplace_back(k, part.rate * spreads[k].deviation);
    }
    if (const auto& law = spreads[k].law) {
      const ActuatorSpec& actuator = task.scene.rod.actuators.at(law->actuator);
      if (!actuator.gain_of(law->power, 0.0)) unknown("it moves nothing that is known");
      out->numbers.push_back(number_of(actuator, *law, task.scale.moment()));
      of_spread.emplace_back(k, spreads[k].deviation);
    }
  }
  const Eigen::MatrixXd root = root_of_correlations(spreads);
  out->shares.resize(root.cols(), static_cast<Eigen::Index>(of_spread.size()));
  for (Eigen::Index j = 0; j < out->shares.cols(); ++j) {
    const auto& [k, rate] = of_spread[static_cast<std::size_t>(j)];
    out->shares.col(j) = rate * root.row(static_cast<Eigen::Index>(k)).transpose();
  }
  return out;
}

}  // namespace tendril
