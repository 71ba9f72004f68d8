#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/workload.hpp"
#include "extremes/cases.hpp"

namespace tendril::bench {

/// The numbers of the cases: those of the table, or held-out ones, each up to a tenth larger or smaller.
class CaseNumbers {
 public:
  explicit CaseNumbers(std::uint64_t held_out) : held_out_(held_out), uniform_(held_out) {}
  double operator()(double value) { return held_out_ == 0 ? value : value * uniform_(0.9, 1.1); }
  /// What is known only for the numbers of the table.
  KnownAnswer table(const KnownAnswer& known) const { return held_out_ == 0 ? known : KnownAnswer{}; }

 private:
  std::uint64_t held_out_;
  Uniform uniform_;
};

/// Cases as they are put together, group by group.
class CaseList {
 public:
  explicit CaseList(std::uint64_t held_out) : number(held_out) {}
  CaseNumbers number;
  ExtremeCase& plan(const char* group, std::string name, std::string text, std::string source) {
    all_.push_back({group, std::move(name), std::move(text), {}, "solved", std::move(source)});
    return all_.back();
  }
  ExtremeCase& execution(const char* group, std::string name, std::string text, std::vector<double> moments,
                         std::string source) {
    all_.push_back({group, std::move(name), std::move(text), std::move(moments), "solved", std::move(source)});
    all_.back().executed = true;
    return all_.back();
  }
  std::vector<ExtremeCase> take() { return std::move(all_); }

 private:
  std::vector<ExtremeCase> all_;
};

/// The tip of a circular arc of unit length that leaves the origin along x and turns by `angle`.
Vec2 arc_tip(double angle);

/// The braced arm of the exact table.
extern const KnownAnswer braced;

/// The groups of cases. Held-out numbers are drawn in the order in which the groups are added.
void add_scales(CaseList& list);
void add_softness(CaseList& list);
void add_large_angles(CaseList& list);
void add_obstacles(CaseList& list);
void add_contacts(CaseList& list);
void add_shapes(CaseList& list);
void add_trajectories(CaseList& list);
void add_programs(CaseList& list);
void add_outlines(CaseList& list);

}  // namespace tendril::bench
