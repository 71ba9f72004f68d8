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
  const auto place = [starts = std::move(starts), lengths](double s) {
    std::size_t j = 0;
    while (j + 1 < starts.size() && s >= starts[j + 1]) ++j;
    return std::pair(j, std::clamp((s - starts[j]) / lengths[j], 0.0, 1.0));
  };
  const auto bends = static_cast<Eigen::Index>(chain.bends());
  auto curvature = [basis = std::move(basis), place, lengths = std::move(lengths), q, bends](double s) {
    const auto [j, at] = place(s);
    const double sigma[1] = {at};
    Eigen::MatrixXd value(1, bends);
    Eigen::MatrixXd first(1, bends);
    Eigen::MatrixXd second(1, bends);
    basis->evaluate(sigma, value, first, second);
    return first.row(0).dot(q.col(static_cast<Eigen::Index>(j)).head(bends)) / lengths[j];
  };
  if (chain.stretches() == 0) return curvature;
  return {curvature, [place, q, bends, stretch = chain.table().stretch](double s) {
            const auto [j, at] = place(s);
            Eigen::VectorXd value(stretch.order);
            Eigen::VectorXd slope(stretch.order);
            stretch.evaluate(at, value.data(), slope.data());
            return value.dot(q.col(static_cast<Eigen::Index>(j)).tail(q.rows() - bends));
          }};
}

Curvature moved(const Curvature& curvature, double factor, const Curvature& along) {
  const auto sum = [factor](const Curvature::Along& a, const Curvature::Along& b) -> Curvature::Along {
    if (!a || !b) return a;
    return [a, b, factor](double s) { return a(s) + factor * b(s); };
  };
  return {sum(curvature, along), sum(curvature.stretch, along.stretch)};
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
