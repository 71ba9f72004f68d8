#include "extremes/extremes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tendril/tolerances.hpp"

namespace tendril::bench {

std::string to_string(Outcome outcome) {
  return outcome == Outcome::met ? "met" : outcome == Outcome::explained ? "explained" : "not met";
}

Section extremes_section(plugins::Registry& registry, const Extent& extent) {
  Section section;
  section.name = "extremes";
  section.title = "Stiff and extreme cases";
  const std::vector<ExtremeRow> rows = extreme_rows(registry, extent, section.left_out);
  Table table{
      "extremes",
      "Every case with every coordinate model and every backend. Error: of the model, against the exact state under "
      "the "
      "same moments with the same contacts: tip and places in L, forces relative to the larger of 1 and their size. "
      "Everything dimensionless",
      {"group", "case", "model", "backend", "expected", "source", "got", "error", "allowed", "residuals", "time (ms)",
       "outcome", "why"},
      {}};
  std::map<Outcome, int> counts;
  double slowest = 0.0;
  for (const ExtremeRow& row : rows) {
    ++counts[row.outcome];
    slowest = std::max(slowest, row.seconds);
    table.rows.push_back({row.group, row.name, row.model, row.backend, row.expected, row.source, row.got, row.error,
                          row.allowed, row.residuals, 1e3 * row.seconds, to_string(row.outcome), row.why});
  }
  section.prose.push_back(fmt::format(
      "{} rows: {} met, {} explained by a measured limit of the model, {} not met. The slowest took {:.2g} s.",
      rows.size(), counts[Outcome::met], counts[Outcome::explained], counts[Outcome::not_met], slowest));
  section.prose.push_back(fmt::format(
      "Everything solved is compared with the exact rod: a boundary-value problem in the strong form of the equations, "
      "under the moments that were found, with those contacts closed that press. A source that knows the answer "
      "beforehand is held against that state. A model is done with an error of {:.0e}. Where its error is larger, it "
      "is "
      "planned with more coordinates, too: the row is met if the error falls at least in proportion to them and is at "
      "most {:.0e}, the bound for coarse models that verification has; beyond that bound it is explained: the model "
      "has "
      "too few coordinates for the shape, and the row shows how many do.",
      resolved_error, tolerance::model_error));
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
