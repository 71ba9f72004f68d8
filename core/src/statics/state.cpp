#include "statics/state.hpp"

#include <algorithm>
#include <utility>

namespace tendril {

Curvature curvature_of(std::shared_ptr<const CoordinateModel> basis, const Backbone& backbone,
                       ConstVectorRef coordinates) {
  const Chain& chain = backbone.chain();
  std::vector<double> starts, lengths;
  for (int j = 0; j < chain.piece_count(); ++j) {
    starts.push_back(backbone.start(j));
    lengths.push_back(backbone.length(j));
  }
  const Eigen::MatrixXd q =
      Eigen::Map<const Eigen::MatrixXd>(coordinates.data(), chain.functions(), chain.piece_count());
  return [basis = std::move(basis), starts = std::move(starts), lengths = std::move(lengths), q](double s) {
    std::size_t j = 0;
    while (j + 1 < starts.size() && s >= starts[j + 1]) ++j;
    const double sigma[1] = {std::clamp((s - starts[j]) / lengths[j], 0.0, 1.0)};
    Eigen::MatrixXd value(1, q.rows());
    Eigen::MatrixXd first(1, q.rows());
    Eigen::MatrixXd second(1, q.rows());
    basis->evaluate(sigma, value, first, second);
    return first.row(0).dot(q.col(static_cast<Eigen::Index>(j))) / lengths[j];
  };
}

void sort_contacts(std::vector<PointContact>& contacts) {
  std::stable_sort(contacts.begin(), contacts.end(), [](const PointContact& a, const PointContact& b) {
    if (a.setup.at_tip != b.setup.at_tip) return b.setup.at_tip;
    return !a.setup.at_tip && a.s < b.s;
  });
}

void place_inside(PointContact& contact, double s, const std::vector<double>& knots, double clearance) {
  std::size_t r = 0;
  while (r + 2 < knots.size() && s >= knots[r + 1]) ++r;
  contact.setup.at_tip = false;
  contact.setup.region = static_cast<int>(r);
  contact.s = std::clamp(s, knots[r] + clearance, knots[r + 1] - clearance);
}

bool hand_over(PointContact& contact, bool upward, const std::vector<double>& knots, double clearance) {
  const auto region = static_cast<std::size_t>(contact.setup.region);
  if (!upward && region == 0) return false;
  const double knot = upward ? knots[region + 1] : knots[region];
  contact.setup.at_tip = upward && region + 2 == knots.size();
  contact.setup.region = contact.setup.at_tip ? 0 : contact.setup.region + (upward ? 1 : -1);
  contact.s = contact.setup.at_tip ? 1.0 : knot + (upward ? clearance : -clearance);
  return true;
}

}  // namespace tendril
