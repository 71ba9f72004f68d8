#pragma once

#include <algorithm>
#include <atomic>

#include "base/clock.hpp"

namespace tendril {

/// What ends a search: its user, or the clock. Time does nothing but end it, so that a search which is not cut finds
/// the same on every machine; how much goes into a part of it is an Allowance.
class Deadline {
 public:
  /// `stop` (null: nobody) must outlive this.
  Deadline(const std::atomic<bool>* stop, double seconds) : stop_(stop), end_(now() + seconds) {}

  bool interrupted() const { return stop_ != nullptr && stop_->load(); }
  /// Asked where the search would go on: then it was cut, if the time is over.
  bool over() const {
    if (interrupted()) return true;
    cut_ = cut_ || now() > end_;
    return cut_;
  }
  /// The clock ended the search before it was done.
  bool cut() const { return cut_; }
  double seconds_left() const { return end_ - now(); }
  const std::atomic<bool>* stop() const { return stop_; }

 private:
  const std::atomic<bool>* stop_;
  double end_;
  mutable bool cut_ = false;
};

/// So many looks, one per step of what is allowed them.
class Allowance {
 public:
  Allowance(const Deadline& deadline, int looks) : deadline_(deadline), all_(looks), left_(looks) {}
  /// Takes one; whether there was none, or the search is over.
  bool spent() { return --left_ < 0 || deadline_.over(); }
  int taken() const { return all_ - std::max(left_, 0); }

 private:
  const Deadline& deadline_;
  int all_;
  int left_;
};

}  // namespace tendril
