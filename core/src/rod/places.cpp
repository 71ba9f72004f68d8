#include "rod/places.hpp"

#include <algorithm>

#include "rod/kernels.hpp"

namespace tendril {

Places::Places(const Rod& rod, const Chain& chain, int contacts)
    : chain_(&chain),
      backbone_(chain, rod.base, rod.base_angle),
      sections_(chain),
      shifts_(rod.moves.begin(), rod.moves.end() - (rod.draws() ? 1 : 0)),
      moves_(static_cast<int>(rod.moves.size())),
      arc_lengths_(moves_ + contacts),
      origin_(rod.base),
      angle_(rod.base_angle),
      stations_(static_cast<std::size_t>(chain.piece_count())),
      virtual_(chain),
      sums_(chain, false),
      gram_sums_(chain, true),
      rate_sums_(static_cast<std::size_t>(arc_lengths_), PieceSums(chain, false)) {
  const int pieces = chain.piece_count();
  const int arc_lengths = arc_lengths_;
  const auto shifts = static_cast<int>(shifts_.size());
  for (int l = 0; l < shifts; ++l) {
    if (shifts_[static_cast<std::size_t>(l)].kind == Rod::Move::Kind::turn) turn_ = l;
  }
  if (turn_ >= 0) {
    const int coordinates = chain.coordinate_count();
    lambda_.setZero(coordinates);
    row_buffer_.setZero(coordinates + arc_lengths_);
    second_buffer_.setZero(coordinates, coordinates + arc_lengths_);
  }
  left_ = 1.0 - chain.table().sigma.array();
  length_rate_.setZero(pieces, arc_lengths);
  start_rate_.setZero(pieces, arc_lengths);
  length_rate_.middleCols(shifts, chain.knot_count()) = chain.length_rate();
  start_rate_.middleCols(shifts, chain.knot_count()) = chain.start_rate();
  mass_rate_.setZero(pieces, arc_lengths);
  for (int j = pieces - 2; j >= 0; --j) {
    // The weight of a whole segment does not change, and this is not asked for inside of one that weighs unevenly.
    mass_rate_.row(j) = mass_rate_.row(j + 1);
    if (chain.piece(j + 1).weighs_evenly) mass_rate_.row(j) += chain.piece(j + 1).weight * length_rate_.row(j + 1);
  }
  line_rate_.setZero(2 * pieces, arc_lengths);
  dead_ = rod.has_dead_loads();
  for (int j = pieces - 2; j >= 0; --j) {
    const Vec2 line = chain.piece(j + 1).line;
    line_rate_.row(2 * j) = line_rate_.row(2 * j + 2) + line.x * length_rate_.row(j + 1);
    line_rate_.row(2 * j + 1) = line_rate_.row(2 * j + 3) + line.y * length_rate_.row(j + 1);
  }
  rates_.setZero(2 * arc_lengths, pieces + 1);
  virtual_rates_ = rates_;
  stiff_.setZero(chain.coordinate_count());
  bool bends_evenly = true;
  for (int j = 0; j < pieces; ++j) bends_evenly = bends_evenly && chain.piece(j).bends_evenly;
  if (!bends_evenly) bent_.setZero(chain.nodes(), pieces);
  psi_.setZero(chain.nodes(), pieces);
  psi_knot_.setZero(pieces + 1);
  for (Eigen::VectorXd* v : {&node_buffer_, &push_along_, &push_across_, &heavy_, &along_nodes_, &virtual_bent_}) {
    v->setZero(chain.nodes());
  }
  third_.setZero(chain.functions());
  by_s_.setZero(arc_lengths);
  still_.setZero(arc_lengths, arc_lengths);
  if (chain.stretches() == 0) return;
  eta_.setZero(chain.nodes(), pieces);
  strain_.setZero(chain.nodes(), pieces);
  for (Eigen::VectorXd* v : {&unit_buffer_, &unit_push_along_, &unit_push_across_}) v->setZero(chain.nodes());
}

int Places::add_knot(int piece) {
  knots_.push_back(count());
  places_.push_back({.piece = piece});
  return count() - 1;
}

int Places::add_sliding(int piece, int contact) {
  inside_.push_back(count());
  places_.push_back({.kind = Kind::inside,
                     .piece = piece,
                     .own = static_cast<int>(moving_.size()),
                     .arc_length = contact < 0 ? -1 : moves_ + contact});
  moving_.emplace_back(*chain_);
  return count() - 1;
}

int Places::add_fixed(double arc_length) {
  const int place = add_sliding(0, -1);
  places_.back().fixed = arc_length;
  return place;
}

std::vector<int> Places::add_stations(std::span<const Station> stations) {
  std::vector<int> made;
  made.reserve(stations.size());
  for (const auto [piece, sigma] : stations) {
    Stations& s = stations_[static_cast<std::size_t>(piece)];
    const auto found = std::find(s.sigma.begin(), s.sigma.end(), sigma);
    const auto own = static_cast<int>(found - s.sigma.begin());
    if (found == s.sigma.end()) {
      s.place.push_back(count());
      s.sigma.push_back(sigma);
      places_.push_back({.kind = Kind::station, .piece = piece, .own = own});
    }
    made.push_back(s.place[static_cast<std::size_t>(own)]);
  }
  for (Stations& s : stations_) {
    const auto count = static_cast<Eigen::Index>(s.sigma.size());
    s.by_node.resize(count, chain_->nodes());
    s.sum.setZero(2 * chain_->functions(), count);
    for (Eigen::VectorXd* v : {&s.chord_x, &s.chord_y, &s.push_x, &s.push_y}) v->setZero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      chain_->rule().partial_weights(s.sigma[static_cast<std::size_t>(i)],
                                     {node_buffer_.data(), static_cast<std::size_t>(chain_->nodes())});
      s.by_node.row(i) = node_buffer_.transpose();
    }
  }
  return made;
}

void Places::move(ConstVectorRef q, std::span<const double> arc_lengths) {
  Vec2 base = origin_;
  double angle = angle_;
  for (std::size_t l = 0; l < shifts_.size(); ++l) {
    base += arc_lengths[l] * shifts_[l].along;
    if (shifts_[l].kind == Rod::Move::Kind::turn) angle = arc_lengths[l];
  }
  backbone_.place(base, angle);
  backbone_.move(q, arc_lengths.subspan(shifts_.size(), static_cast<std::size_t>(chain_->knot_count())));
  for (Place& p : places_) {
    if (p.kind == Kind::station) continue;
    if (p.kind == Kind::knot) {
      p.point = backbone_.knot_point(p.piece + 1);
      continue;
    }
    double s = p.fixed;
    if (p.arc_length >= 0) {
      s = arc_lengths[static_cast<std::size_t>(p.arc_length)];
    } else {
      p.piece = 0;
      while (p.piece + 1 < chain_->piece_count() && s > backbone_.start(p.piece + 1)) ++p.piece;
    }
    MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
    m.move(backbone_, p.piece, s);
    p.point = m.position();
  }
  sections_.move(backbone_);
  const int n = chain_->functions();
  stiff_.setZero();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    if (chain_->piece(j).bends_evenly) {
      kernels::add_weighted_columns(n, n, n, chain_->table().stiffness.data(), q.data() + j * n, 1,
                                    stiff_.data() + j * n);
    } else {
      bent_.col(j).noalias() = chain_->table().slope * q.segment(j * n, n);
    }
    if (const int m = chain_->stretches(); m > 0) {
      strain_.col(j).noalias() = chain_->table().stretch_by_function * q.segment(j * n + chain_->bends(), m);
    }
    Stations& s = stations_[static_cast<std::size_t>(j)];
    const auto count = static_cast<int>(s.sigma.size());
    if (count == 0) continue;
    s.chord_x.setZero();
    s.chord_y.setZero();
    backbone_.add_tangents(j, count, s.by_node.data(), s.chord_x.data(), s.chord_y.data());
    const Vec2 start = backbone_.knot_point(j);
    for (int i = 0; i < count; ++i) {
      places_[static_cast<std::size_t>(s.place[static_cast<std::size_t>(i)])].point =
          start + backbone_.length(j) * Vec2{s.chord_x[i], s.chord_y[i]};
    }
  }
}

Vec2 Places::tangent(int place) const {
  const Place& p = at(place);
  return p.kind == Kind::knot ? backbone_.knot_tangent(p.piece + 1) : moving_[own(place)].tangent();
}

double Places::angle(int place) const {
  const Place& p = at(place);
  return p.kind == Kind::knot ? backbone_.knot_angle(p.piece + 1) : moving_[own(place)].angle();
}

Rod::Jet Places::radius(int place) const {
  if (!chain_->is_thick()) return {};
  const Place& p = at(place);
  const double sigma = p.kind == Kind::knot     ? 1.0
                       : p.kind == Kind::inside ? moving_[own(place)].sigma()
                                                : stations_[static_cast<std::size_t>(p.piece)].sigma[own(place)];
  return chain_->segment(p.piece).radius_at(backbone_.start(p.piece) + sigma * backbone_.length(p.piece));
}

double Places::running(int place, int l) const {
  const Place& p = at(place);
  if (p.kind == Kind::inside) return p.arc_length == l ? 1.0 : 0.0;
  return run(p.piece, p.kind == Kind::knot ? 1.0 : stations_[static_cast<std::size_t>(p.piece)].sigma[own(place)], l);
}

void Places::differentiate() {
  backbone_.sum_normals();
  find_rates(backbone_.integrals(), rates_);
  for (int j = 0; j < chain_->piece_count(); ++j) {
    Stations& s = stations_[static_cast<std::size_t>(j)];
    s.sum.setZero();
    const auto stride = static_cast<int>(s.by_node.rows());
    for (int i = 0; i < stride; ++i) backbone_.add_turned(j, s.by_node.data() + i, stride, s.sum.col(i).data());
  }
}

double Places::own_rate(const Place& p, int l) const {
  // d(h sigma)/ds_l minus sigma dh/ds_l.
  const double sigma = moving_[static_cast<std::size_t>(p.own)].sigma();
  return (p.arc_length == l ? 1.0 : 0.0) - start_rate_(p.piece, l) - sigma * length_rate_(p.piece, l);
}

void Places::find_rates(const Integrals& field, Eigen::MatrixXd& rates) const {
  for (int j = 0; j < chain_->piece_count(); ++j) {
    for (int l = 0; l < arc_lengths_; ++l) {
      rates.block<2, 1>(2 * l, j + 1) = rates.block<2, 1>(2 * l, j) + length_rate_(j, l) * field.chord.col(j);
    }
  }
}

void Places::row_of(const Integrals& field, const Eigen::MatrixXd& rates, const Place& p, Vec2 value, Vec2 n,
                    RowPart out) const {
  const int last = p.kind == Kind::knot ? p.piece + 1 : p.piece;
  field.row_before(last, value, n, chain_->table().end, out.q);
  for (int l = 0; l < arc_lengths_; ++l) out.s[l] = n.x * rates(2 * l, last) + n.y * rates(2 * l + 1, last);
  if (turn_ >= 0) out.s[turn_] += dot(n, turned(value - field.knot_of(0)));
}

void Places::row(int place, Vec2 n, RowPart out) const {
  row_from_base(place, n, out);
  for (std::size_t l = 0; l < shifts_.size(); ++l) out.s[l] += dot(n, shifts_[l].along);
}

void Places::row_from_base(int place, Vec2 n, RowPart out) const {
  const Place& p = at(place);
  const int j = p.piece;
  row_of(backbone_.integrals(), rates_, p, p.point, n, out);
  if (p.kind == Kind::knot) return;
  const int functions = chain_->functions();
  double* own = out.q + j * functions;
  if (p.kind == Kind::station) {
    const Stations& s = stations_[static_cast<std::size_t>(j)];
    const double* sum = s.sum.col(p.own).data();
    const Vec2 hn = backbone_.length(j) * n;
    for (int i = 0; i < functions; ++i) own[i] = hn.x * sum[i] + hn.y * sum[functions + i];
    const double chord = dot(n, {s.chord_x[p.own], s.chord_y[p.own]});
    for (int l = 0; l < arc_lengths_; ++l) out.s[l] += length_rate_(j, l) * chord;
    return;
  }
  const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
  m.own_row(n, false, own);
  for (int l = 0; l < arc_lengths_; ++l) {
    out.s[l] += length_rate_(j, l) * dot(n, m.chord()) + own_rate(p, l) * dot(n, m.velocity());
  }
}

void Places::angle_row(int place, RowPart out) const {
  const Place& p = at(place);
  const int n = chain_->functions();
  const int last = p.kind == Kind::knot ? p.piece + 1 : p.piece;
  for (int i = 0; i < last; ++i) std::copy_n(chain_->table().end.data(), n, out.q + i * n);
  std::fill_n(out.s, arc_lengths_, 0.0);
  if (turn_ >= 0) out.s[turn_] = 1.0;
  if (p.kind == Kind::knot) return;
  const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
  std::copy_n(m.beta(), n, out.q + p.piece * n);
  for (int l = 0; l < arc_lengths_; ++l) out.s[l] += m.slope() * own_rate(p, l) / backbone_.length(p.piece);
}

Places::Side Places::side(int place, int which) const {
  const Place& p = at(place);
  const int n = chain_->functions();
  const int pieces = chain_->piece_count();
  const auto beside = [&](int j, const Eigen::VectorXd& slope, auto where) {
    const Eigen::Map<const Eigen::VectorXd> q(backbone_.coordinates(j), n);
    Side at{j, where, slope.dot(q) / backbone_.length(j)};
    const BasisTable& table = chain_->table();
    for (int k = 0; k < table.stretch.order; ++k) {
      at.stretch += q[table.bends + k] * (where == Side::end ? table.stretch.factor : table.stretch_start[k]);
    }
    return at;
  };
  const auto at_end = [&](int j) { return beside(j, chain_->table().slope_end, Side::end); };
  const auto at_start = [&](int j) { return beside(j, chain_->table().slope_start, Side::start); };
  const int j = p.piece;
  if (p.kind == Kind::knot) return which == 0 || j + 1 == pieces ? at_end(j) : at_start(j + 1);
  const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
  if (which == 0 && m.sigma() <= 0.0 && j > 0) return at_end(j - 1);
  if (which == 1 && m.sigma() >= 1.0 && j + 1 < pieces) return at_start(j + 1);
  return {j, Side::inside, m.curvature(), m.stretch()};
}

void Places::add_bend_row(int place, const Side& side, double factor, RowPart out) const {
  add_curvature_row(place, side, factor / side.stretch, out);
  if (chain_->stretches() > 0) add_stretch_row(place, side, -factor * side.bend() / side.stretch, out);
}

void Places::add_curvature_row(int place, const Side& side, double factor, RowPart out) const {
  const int n = chain_->functions();
  const double by_length = factor / backbone_.length(side.piece);
  const bool inside = side.where == Side::inside;
  const MovingPoint* m = inside ? &moving_[own(place)] : nullptr;
  const BasisTable& table = chain_->table();
  const double* slope = inside                    ? m->beta1()
                        : side.where == Side::end ? table.slope_end.data()
                                                  : table.slope_start.data();
  for (int i = 0; i < n; ++i) out.q[side.piece * n + i] += by_length * slope[i];
  for (int l = 0; l < arc_lengths_; ++l) {
    out.s[l] -= by_length * side.curvature * length_rate_(side.piece, l);
    if (inside) out.s[l] += by_length * m->bend() * own_rate(at(place), l) / backbone_.length(side.piece);
  }
}

void Places::displace(const double* lambda) {
  if (turn_ >= 0) lambda_ = Eigen::Map<const Eigen::VectorXd>(lambda, chain_->coordinate_count());
  psi_knot_[0] = 0.0;
  backbone_.along(lambda, psi_, psi_knot_);
  const int n = chain_->functions();
  for (int j = 0; j < chain_->piece_count() && chain_->stretches() > 0; ++j) {
    const Eigen::Map<const Eigen::VectorXd> along(lambda + j * n + chain_->bends(), chain_->stretches());
    eta_.col(j).noalias() = chain_->table().stretch_by_function * along;
  }
  backbone_.turn(psi_, eta_, virtual_);
  find_rates(virtual_, virtual_rates_);
  for (Place& p : places_) {
    if (p.kind == Kind::station) continue;
    p.displacement = virtual_.knot_of(p.kind == Kind::knot ? p.piece + 1 : p.piece);
    if (p.kind == Kind::knot) continue;
    MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
    m.displace(lambda + p.piece * n, psi_knot_[p.piece]);
    p.displacement += backbone_.length(p.piece) * m.virtual_chord();
  }
}

void Places::displacement_row(int place, Vec2 n, RowPart out) const {
  const Place& p = at(place);
  row_of(virtual_, virtual_rates_, p, p.displacement, n, out);
  if (p.kind == Kind::knot) return;
  const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
  m.own_row(n, true, out.q + p.piece * chain_->functions());
  for (int l = 0; l < arc_lengths_; ++l) {
    out.s[l] += length_rate_(p.piece, l) * dot(n, m.virtual_chord()) + own_rate(p, l) * m.psi() * dot(n, m.normal());
  }
  for (int l = 0; l < arc_lengths_ && chain_->stretches() > 0; ++l) {
    // `normal` above is that of P'.
    out.s[l] += own_rate(p, l) * m.eta() * dot(n, m.tangent());
  }
}

}  // namespace tendril
