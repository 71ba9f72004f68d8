#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tendril/objective_term.hpp"

namespace tendril::kit {

/// One number that a term may read.
struct Input {
  std::string name;   ///< "contacts[1].force"
  std::string reads;  ///< the field of Reads that asks for it; empty: nothing does
  bool asked = false;
  double low = 0.0, high = 0.0;  ///< range of sensible values, dimensionless
};

/// All that a term reads, out of one flat vector: tip, samples, contacts, moments, tendons, deviations and energy.
template <class T>
class FlatQuantities {
 public:
  FlatQuantities(const Reads& reads, int contacts, int moments, const Target& target)
      : samples_(reads.samples.size()),
        contacts_(static_cast<std::size_t>(contacts)),
        moments_(static_cast<std::size_t>(moments)),
        tensions_(moments_),
        shortenings_(moments_),
        deviations_(moments_.size()) {
    quantities_.samples = samples_;
    quantities_.contacts = contacts_;
    quantities_.moments = moments_;
    quantities_.tensions = tensions_;
    quantities_.shortenings = shortenings_;
    quantities_.tip_deviations = deviations_;
    quantities_.target = target;
  }
  FlatQuantities(const FlatQuantities&) = delete;
  FlatQuantities& operator=(const FlatQuantities&) = delete;

  const Quantities<T>& set(const std::vector<T>& x) {
    std::size_t at = 0;
    const auto next = [&]() -> const T& { return x[at++]; };
    const auto read = [&](BackboneQuantities<T>& point) {
      for (T* number : {&point.x, &point.y, &point.angle, &point.curvature, &point.strain}) *number = next();
    };
    read(quantities_.tip);
    for (BackboneQuantities<T>& sample : samples_) read(sample);
    for (ContactQuantities<T>& c : contacts_) {
      for (T* number :
           {&c.x, &c.y, &c.gap, &c.normal_x, &c.normal_y, &c.force, &c.arc_length, &c.reference_x, &c.reference_y}) {
        *number = next();
      }
    }
    for (std::vector<T>* all : {&moments_, &tensions_, &shortenings_}) {
      for (T& one : *all) one = next();
    }
    for (TipDeviation<T>& one : deviations_) {
      one.x = next();
      one.y = next();
    }
    quantities_.bending_energy = next();
    quantities_.insertion = next();
    quantities_.palm_distance = next();
    return quantities_;
  }

 private:
  std::vector<BackboneQuantities<T>> samples_;
  std::vector<ContactQuantities<T>> contacts_;
  std::vector<T> moments_, tensions_, shortenings_;
  std::vector<TipDeviation<T>> deviations_;  ///< as many as moments
  Quantities<T> quantities_{};
};

/// The numbers of FlatQuantities in its order.
std::vector<Input> inputs(const Reads& reads, int contacts, int moments);

}  // namespace tendril::kit
