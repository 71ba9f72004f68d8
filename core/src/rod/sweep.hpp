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
  }
  /// Takes up what acts inside of piece j.
  void leave(int j) {
    for (const int k : places_.inside_) {
      if (places_.at(k).piece == j) beyond_ += on(k).force;
    }
    if (places_.may_push(j, forces_)) {
      for (const int k : places_.stations_[static_cast<std::size_t>(j)].place) beyond_ += on(k).force;
    }
    mass_ += places_.chain_->piece(j).weight * places_.backbone_.length(j);
  }
  const Push& on(int place) const { return places_.on(place, forces_); }
  /// Force times length on the nodes of piece j, without what acts inside of it.
  Ramp load(int j) const {
    const double h = places_.backbone_.length(j);
    const double weight = places_.chain_->piece(j).weight;
    return {h * (beyond_ + mass_ * forces_.gravity), (h * h * weight) * forces_.gravity};
  }
  /// Its derivative by arc length l.
  Ramp load_rate(int j, int l) const {
    const double h = places_.backbone_.length(j);
    const double rate = places_.length_rate_(j, l);
    const double mass = rate * mass_ + h * places_.mass_rate_(j, l);
    return {rate * beyond_ + mass * forces_.gravity,
            (2.0 * h * rate * places_.chain_->piece(j).weight) * forces_.gravity};
  }
  /// Its derivative by two arc lengths: masses of pieces are quadratic in their lengths.
  Ramp load_bend(int j, int l, int k) const {
    const double h_l = places_.length_rate_(j, l);
    const double h_k = places_.length_rate_(j, k);
    return {(h_l * places_.mass_rate_(j, k) + h_k * places_.mass_rate_(j, l)) * forces_.gravity,
            (2.0 * h_l * h_k * places_.chain_->piece(j).weight) * forces_.gravity};
  }

 private:
  const Places& places_;
  const Forces& forces_;
  Vec2 beyond_;
  double mass_;
};

}  // namespace tendril
