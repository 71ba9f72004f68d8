#pragma once

#include <string>
#include <vector>

namespace tendril::results {

/// Collects what does not fit, each with the place in the result where it stands.
class Findings {
 public:
  /// `value` is what the result says, `expected` what follows from its other numbers.
  void near(const std::string& what, double value, double expected, double tolerance);
  void that(bool holds, const std::string& what);

  /// Everything found until the end of its life stands at `place`.
  class Place {
   public:
    Place(Findings& findings, const std::string& place) : findings_(findings) { findings_.places_.push_back(place); }
    ~Place() { findings_.places_.pop_back(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    Findings& findings_;
  };

  const std::vector<std::string>& list() const { return list_; }

 private:
  std::string where() const;

  std::vector<std::string> places_;
  std::vector<std::string> list_;
};

}  // namespace tendril::results
