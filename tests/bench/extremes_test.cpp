#include "extremes/extremes.hpp"

#include <gtest/gtest.h>

#include <set>

namespace tendril::bench {
namespace {

/// The short form, once.
const std::vector<ExtremeRow>& quick_rows() {
  static const std::vector<ExtremeRow> rows = [] {
    plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
    Extent extent;
    extent.quick = true;
    std::vector<LeftOut> left_out;
    return extreme_rows(registry, extent, left_out);
  }();
  return rows;
}

TEST(Extremes, EveryRowIsMetOrExplainedByAMeasuredLimit) {
  EXPECT_GT(quick_rows().size(), 100U);
  for (const ExtremeRow& row : quick_rows()) {
    EXPECT_NE(row.outcome, Outcome::not_met)
        << row.group << ", " << row.name << ", " << row.model << ", " << row.backend << ": expected " << row.expected
        << ", got " << row.got << "; " << row.why;
  }
}

TEST(Extremes, EveryGroupTakesPart) {
  std::set<std::string> groups;
  for (const ExtremeRow& row : quick_rows()) groups.insert(row.group);
  for (const char* group : {"scale", "softness", "large angle", "orders", "obstacles", "contact", "shapes",
                            "instability", "programs", "outlines"}) {
    EXPECT_TRUE(groups.count(group)) << group;
  }
}

TEST(Extremes, EveryModelAndEveryBackendTakesPart) {
  plugins::Registry registry(plugins::Catalog(plugins::search_places({})));
  std::set<std::string> models;
  std::set<std::string> backends;
  for (const ExtremeRow& row : quick_rows()) {
    models.insert(row.model);
    backends.insert(row.backend);
  }
  for (const std::string& name : registry.names(ComponentKind::coordinates)) EXPECT_TRUE(models.count(name)) << name;
  for (const std::string& name : registry.names(ComponentKind::solver)) EXPECT_TRUE(backends.count(name)) << name;
}

}  // namespace
}  // namespace tendril::bench
