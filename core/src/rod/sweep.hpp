#pragma once

#include "rod/places.hpp"

namespace tendril {

/// What acts beyond a piece, from the tip to the base.
class Places::Sweep {
 public:
  Sweep(const Places& places, const Forces& forces)
      : places_(places), forces_(forces), beyond_(forces.tip), mass_(forces.payload) {}

  /// Takes up what acts on the end of piece j.
  void enter(int j) {
    for (const int k : places_.knots_) {
      if (places_.at(k).piece == j) beyond_ += on(k).force;
    }
    beyond_ += forces_.dead_load(piece(j).point);
    mass_ += piece(j).point_weight;
  }
  /// Takes up what acts inside of piece j.
  void leave(int j) {
    for (const int k : places_.inside_) {
      if (places_.at(k).piece == j) beyond_ += on(k).force;
    }
    if (places_.may_push(j, forces_)) {
      for (const int k : places_.stations_[static_cast<std::size_t>(j)].place) beyond_ += on(k).force;
    }
    beyond_ += places_.backbone_.length(j) * forces_.dead_load(piece(j).line);
    const Sections::Weight* varying = places_.sections_.weight(j);
    mass_ += varying != nullptr ? varying->whole : weight(j) * places_.backbone_.length(j);
  }
  const Push& on(int place) const { return places_.on(place, forces_); }
  /// Force times length on the nodes of piece j, without what acts inside of it.
  Ramp load(int j) const {
    const double h = places_.backbone_.length(j);
    Ramp out{h * (beyond_ + mass_ * forces_.gravity),
             (h * h * weight(j)) * forces_.gravity + (h * h) * forces_.dead_load(piece(j).line)};
    if (const Sections::Weight* varying = places_.sections_.weight(j)) {
      vary(out, [&](int g) { return h * varying->beyond[g]; });
    }
    return out;
  }
  /// Its derivative by arc length l. The weight beyond a node changes only as the node runs.
  Ramp load_rate(int j, int l) const {
    const double h = places_.backbone_.length(j);
    const double rate = places_.length_rate_(j, l);
    const Sections::Weight* varying = places_.sections_.weight(j);
    const double mass = rate * mass_ + (varying != nullptr ? 0.0 : h * places_.mass_rate_(j, l));
    Ramp out{rate * beyond_ + mass * forces_.gravity + h * forces_.dead_load(places_.line_rate(j, l)),
             (2.0 * h * rate * weight(j)) * forces_.gravity + (2.0 * h * rate) * forces_.dead_load(piece(j).line)};
    if (varying != nullptr) {
      vary(out, [&](int g) { return rate * varying->beyond[g] - h * varying->value[g] * run(j, g, l); });
    }
    return out;
  }
  /// Its derivative by two arc lengths: masses of pieces are quadratic in their lengths.
  Ramp load_bend(int j, int l, int k) const {
    const double h_l = places_.length_rate_(j, l);
    const double h_k = places_.length_rate_(j, k);
    Ramp out{forces_.dead_load(h_l * places_.line_rate(j, k) + h_k * places_.line_rate(j, l)),
             (2.0 * h_l * h_k) * forces_.dead_load(piece(j).line)};
    if (const Sections::Weight* varying = places_.sections_.weight(j)) {
      vary(out, [&](int g) {
        const double s_l = run(j, g, l);
        const double s_k = run(j, g, k);
        return -(h_l * s_k + h_k * s_l) * varying->value[g] -
               places_.backbone_.length(j) * varying->slope[g] * s_l * s_k;
      });
      return out;
    }
    out.end += (h_l * places_.mass_rate_(j, k) + h_k * places_.mass_rate_(j, l)) * forces_.gravity;
    out.slope += (2.0 * h_l * h_k * weight(j)) * forces_.gravity;
    return out;
  }

 private:
  const Chain::Piece& piece(int j) const { return places_.chain_->piece(j); }
  /// Of a piece that weighs evenly; others have it at their nodes.
  double weight(int j) const { return piece(j).weighs_evenly ? piece(j).weight : 0.0; }
  double run(int j, int g, int l) const { return places_.run(j, places_.chain_->table().sigma[g], l); }
  template <class Share>
  void vary(Ramp& ramp, const Share& share) const {
    if (forces_.gravity == Vec2{}) return;
    ramp.heavy = forces_.gravity;
    ramp.share = places_.heavy_.data();
    for (int g = 0; g < places_.chain_->nodes(); ++g) places_.heavy_[g] = share(g);
  }

  const Places& places_;
  const Forces& forces_;
  Vec2 beyond_;
  double mass_;
};

}  // namespace tendril
