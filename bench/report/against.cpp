#include "report/against.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "common/statistics.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::bench {

namespace {

using Json = nlohmann::ordered_json;

/// A table of a report, its columns by name.
class Rows {
 public:
  Rows(const Json& report, const std::string& section, const std::string& table) {
    for (const Json& one : report.at("sections")) {
      if (one.at("name") != section || !one.at("tables").contains(table)) continue;
      rows_ = one.at("tables").at(table).at("rows");
      std::size_t i = 0;
      for (const Json& column : one.at("tables").at(table).at("columns")) index_[column.get<std::string>()] = i++;
    }
  }
  std::size_t size() const { return rows_.size(); }
  const Json& at(std::size_t row, const std::string& column) const { return rows_.at(row).at(index_.at(column)); }
  std::string key(std::size_t row, const std::vector<std::string>& columns) const {
    std::string key;
    for (const std::string& column : columns) key += at(row, column).dump() + ' ';
    return key;
  }

 private:
  Json rows_ = Json::array();
  std::map<std::string, std::size_t> index_;
};

struct Match {
  std::string what;
  int common = 0, equal = 0, alone = 0;
  double pace = 1.0;                 ///< time of the same arithmetic, now / earlier; 1 if a report does not tell
  double time_ratio = std::nan("");  ///< geometric mean of now / earlier, at the same pace
  double typical = std::nan("");     ///< median over the rows of |ln(now / earlier)|
  /// What the reports state: quartiles over median, of nine in ten rows, and that of the pace in both.
  double spread = std::nan("");
  int apart = 0;  ///< rows whose times differ by more than `same_class`
  bool within() const { return std::abs(std::log(time_ratio)) <= spread && typical <= spread; }
};

/// A row's time, and how far its repetitions spread: distance of the quartiles over the median.
struct Timing {
  double seconds = std::nan(""), spread = std::nan("");
};
using TimingOf = Timing (*)(const Rows&, std::size_t row);

double number(const Json& cell) { return cell.is_number() ? cell.get<double>() : std::nan(""); }

Timing model_timing(const Rows& rows, std::size_t row) {
  const double median = number(rows.at(row, "seconds_median"));
  return {median, (number(rows.at(row, "seconds_high")) - number(rows.at(row, "seconds_low"))) / median};
}

/// What was timed once has no spread of its own.
Timing run_timing(const Rows& rows, std::size_t row) {
  const bool once = number(rows.at(row, "repetitions")) <= 1.0;
  return {number(rows.at(row, "seconds")), once ? std::nan("") : number(rows.at(row, "spread"))};
}

/// The machine's pace while a section was measured; NaN in a report that does not tell.
Timing pace_of(const Json& report, const std::string& section) {
  const Rows rows(report, section, section + "_pace");
  return rows.size() == 1 ? model_timing(rows, 0) : Timing{};
}

/// Rows with the same `keys` in both: whether `counts` are equal, and how their times compare.
Match match(const std::string& what, const Rows& now, const Rows& earlier, const std::vector<std::string>& keys,
            const std::vector<std::string>& counts, TimingOf timing, const Timing& pace, const Timing& earlier_pace) {
  std::map<std::string, std::size_t> other;
  for (std::size_t i = 0; i < earlier.size(); ++i) other[earlier.key(i, keys)] = i;
  Match m;
  m.what = what;
  const double ratio_of_paces = pace.seconds / earlier_pace.seconds;
  if (std::isfinite(ratio_of_paces)) m.pace = ratio_of_paces;
  std::vector<double> ratios, distances, spreads;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const auto found = other.find(now.key(i, keys));
    if (found == other.end()) {
      ++m.alone;
      continue;
    }
    ++m.common;
    m.equal += now.key(i, counts) == earlier.key(found->second, counts) ? 1 : 0;
    const Timing a = timing(now, i);
    const Timing b = timing(earlier, found->second);
    if (!(a.seconds > 0.0) || !(b.seconds > 0.0)) continue;
    ratios.push_back(a.seconds / b.seconds / m.pace);
    distances.push_back(std::abs(std::log(ratios.back())));
    m.apart += distances.back() > std::log(same_class) ? 1 : 0;
    for (const double spread : {a.spread, b.spread}) {
      if (std::isfinite(spread)) spreads.push_back(spread);
    }
  }
  m.alone += static_cast<int>(earlier.size()) - m.common;
  m.time_ratio = shifted_geometric_mean(ratios, 0.0);
  m.typical = median(distances);
  m.spread = quantile(spreads, 0.9);
  for (const double spread : {pace.spread, earlier_pace.spread}) {
    if (std::isfinite(spread)) m.spread += spread;
  }
  return m;
}

struct Place {
  std::string contestant;
  double time = 0.0;  ///< ms
};

std::vector<Place> ranking(const Json& report) {
  const Rows rows(report, "solvers", "solvers_ranking");
  std::vector<Place> places;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json& time = rows.at(i, "time (ms)");
    places.push_back({rows.at(i, "contestant"), time.is_number() ? time.get<double>() : std::nan("")});
  }
  return places;
}

std::string words(const std::vector<Place>& places) {
  std::string text;
  for (const Place& place : places) text += (text.empty() ? "" : ", ") + place.contestant;
  return text;
}

/// Whether two rankings agree, as far as times within a factor of `same_class` say anything.
std::string verdict(const std::vector<Place>& now, const std::vector<Place>& earlier) {
  std::map<std::string, std::size_t> rank;
  for (std::size_t i = 0; i < earlier.size(); ++i) rank[earlier[i].contestant] = i;
  const auto apart = [](double a, double b) { return std::max(a, b) > same_class * std::min(a, b); };
  int swapped = 0;
  int contradicting = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    for (std::size_t k = i + 1; k < now.size(); ++k) {
      const auto a = rank.find(now[i].contestant);
      const auto b = rank.find(now[k].contestant);
      if (a == rank.end() || b == rank.end() || a->second < b->second) continue;
      ++swapped;
      const bool clear = apart(now[i].time, now[k].time) && apart(earlier[a->second].time, earlier[b->second].time);
      contradicting += clear ? 1 : 0;
    }
  }
  if (swapped == 0) return "The ranking of the solvers is the same.";
  if (contradicting == 0) {
    return fmt::format(
        "The ranking of the solvers is the same but for {} pairs whose times lie within a factor of {:g}, which is no "
        "difference.",
        swapped, same_class);
  }
  return "The ranking of the solvers differs. Now: " + words(now) + ". Earlier: " + words(earlier) + ".";
}

Section compared(const Json& now, const Json& earlier) {
  Section section;
  section.name = "against";
  section.title = "Beside an earlier report";
  if (now.at("machine") != earlier.at("machine")) {
    section.prose.emplace_back("WARNING: the machines differ. Times cannot be compared; counts and verdicts can.");
    for (const auto& [name, value] : now.at("machine").items()) {
      const std::string other = earlier.at("machine").value(name, "unknown");
      if (value != other)
        section.prose.push_back(fmt::format("{}: now {}, earlier {}.", name, value.get<std::string>(), other));
    }
  }
  const std::string commit = now.at("versions").at("commit");
  const std::string other = earlier.at("versions").at("commit");
  section.prose.push_back(commit == other ? "Both are of commit " + commit + "."
                                          : "Now commit " + commit + ", earlier " + other + ".");
  if (now.at("extent") != earlier.at("extent")) {
    section.prose.emplace_back("The two were measured to different extents: only what both hold is compared.");
  }
  section.prose.push_back(verdict(ranking(now), ranking(earlier)));
  const std::vector<Match> matches{
      match("models", {now, "accuracy", "accuracy"}, {earlier, "accuracy", "accuracy"},
            {"scene", "plugin", "option", "value", "split"}, {"solves", "iterations", "evaluations"}, model_timing,
            pace_of(now, "accuracy"), pace_of(earlier, "accuracy")),
      match("runs of solvers", {now, "solvers", "solvers"}, {earlier, "solvers", "solvers"},
            {"scene", "contestant", "limit_Nm", "target_x_m", "target_y_m", "start"},
            {"status", "solves", "iterations", "evaluations"}, run_timing, pace_of(now, "solvers"),
            pace_of(earlier, "solvers"))};
  Table table{
      "against",
      "Rows of the same name in both reports. Time: geometric mean of now over earlier. Typical: half of the "
      "rows' times differ by less. Spread: nine in ten rows have their quartiles this close in one report",
      {"what", "in both", "same status, iterations and evaluations", "in one only", "time, now / earlier",
       "typical difference (%)", "stated spread (%)", fmt::format("differ by more than a factor of {:g}", same_class)},
      {}};
  for (const Match& m : matches) {
    table.rows.push_back({m.what, std::int64_t{m.common}, std::int64_t{m.equal}, std::int64_t{m.alone}, m.pace,
                          m.time_ratio, 100.0 * std::expm1(m.typical), 100.0 * m.spread, std::int64_t{m.apart}});
    section.prose.push_back(
        fmt::format("Times of {} {} the stated spread: at the same pace their mean changed by a factor of {:.3f} and "
                    "half of them by less than {:.2g} %, with a spread of {:.2g} %. The machine's pace changed by a "
                    "factor of {:.3f}.",
                    m.what, m.within() ? "agree within" : "do NOT agree within", m.time_ratio,
                    100.0 * std::expm1(m.typical), 100.0 * m.spread, m.pace));
  }
  section.tables = {table};
  return section;
}

}  // namespace

Section against_section(const std::string& now, const std::filesystem::path& earlier) {
  const std::filesystem::path file = earlier / "report.json";
  const std::string text = app::read_input(file, "report");
  try {
    return compared(Json::parse(now), Json::parse(text));
  } catch (const Json::exception& error) {
    throw app::InputError(file.string() + ": found something else, expected a report of tendril-bench (" +
                          error.what() + ")");
  } catch (const std::out_of_range&) {
    throw app::InputError(file.string() + ": found a report without the columns of this version");
  }
}

}  // namespace tendril::bench
