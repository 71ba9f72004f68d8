#include <numeric>

#include "tendril/plugin.hpp"

namespace {

using namespace tendril;

/// Piecewise constant curvature (the paper's Table I, left column): the angle grows linearly on each piece.
class ConstantCurvature : public CoordinateModel {
 public:
  explicit ConstantCurvature(std::vector<double> fractions) : fractions_(std::move(fractions)) {}

  int function_count() const override { return 1; }
  void evaluate(std::span<const double> sigma, Eigen::Ref<Eigen::MatrixXd> value, Eigen::Ref<Eigen::MatrixXd> first,
                Eigen::Ref<Eigen::MatrixXd> second) const override {
    value.col(0) = Eigen::Map<const Eigen::VectorXd>(sigma.data(), static_cast<Eigen::Index>(sigma.size()));
    first.setOnes();
    second.setZero();
  }
  std::vector<double> subdivision() const override { return fractions_; }
  std::string coordinate_name(int) const override { return "curvature times length of the piece [rad]"; }

 private:
  std::vector<double> fractions_;
};

std::unique_ptr<CoordinateModel> make(const Options& given) {
  if (given.has("lengths") && given.has("pieces")) throw Error("found 'pieces' and 'lengths'; expected one of them");
  const auto pieces = static_cast<std::size_t>(given.has("pieces") ? given.integer("pieces") : 3);
  auto lengths = given.has("lengths") ? given.table("lengths").values : std::vector<double>(pieces, 1.0);
  if (lengths.size() > 64) {
    throw Error("option 'lengths': found " + std::to_string(lengths.size()) + " pieces; expected at most 64");
  }
  const double sum = std::accumulate(lengths.begin(), lengths.end(), 0.0);
  for (double& length : lengths) length /= sum;
  return std::make_unique<ConstantCurvature>(std::move(lengths));
}

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "pieces",
                              .type = OptionType::integer,
                              .description = "equal pieces between two knots; 3 unless lengths are given",
                              .minimum = 1,
                              .maximum = 64},
                             {.name = "lengths",
                              .type = OptionType::list,
                              .description = "lengths of the pieces in any unit: only their ratios count",
                              .minimum = 0,
                              .minimum_excluded = true}};
  registrar.add(CoordinateComponent{"pcc", "piecewise constant curvature (Table I)", options, make});
}
