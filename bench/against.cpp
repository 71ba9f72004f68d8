#include "against.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "statistics.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::bench {

namespace {

using Json = nlohmann::ordered_json;

/// Times within this factor are not told apart, as in the ranking itself.
constexpr double same_class = 1.5;

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
  int common = 0, equal = 0, alone = 0;
  double time_ratio = std::nan("");  ///< geometric mean of now / earlier
};

/// Rows with the same `keys` in both: whether `counts` are equal, and the ratio of `time`.
Match match(const Rows& now, const Rows& earlier, const std::vector<std::string>& keys,
            const std::vector<std::string>& counts, const std::string& time) {
  std::map<std::string, std::size_t> other;
  for (std::size_t i = 0; i < earlier.size(); ++i) other[earlier.key(i, keys)] = i;
  Match m;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const auto found = other.find(now.key(i, keys));
    if (found == other.end()) {
      ++m.alone;
      continue;
    }
    ++m.common;
    m.equal += now.key(i, counts) == earlier.key(found->second, counts) ? 1 : 0;
    const Json& a = now.at(i, time);
    const Json& b = earlier.at(found->second, time);
    if (a.is_number() && b.is_number() && b.get<double>() > 0.0) ratios.push_back(a.get<double>() / b.get<double>());
  }
  m.alone += static_cast<int>(earlier.size()) - m.common;
  m.time_ratio = shifted_geometric_mean(ratios, 0.0);
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
  Table table{"against",
              "Rows of the same name in both reports. Time: geometric mean of now over earlier",
              {"what", "in both", "same status, iterations and evaluations", "in one only", "time, now / earlier"},
              {}};
  const auto row = [&](const std::string& what, const Match& m) {
    table.rows.push_back({what, std::int64_t{m.common}, std::int64_t{m.equal}, std::int64_t{m.alone}, m.time_ratio});
  };
  row("models", match({now, "accuracy", "accuracy"}, {earlier, "accuracy", "accuracy"},
                      {"scene", "plugin", "option", "value", "split"}, {"solves", "iterations", "evaluations"},
                      "seconds_median"));
  row("runs of solvers", match({now, "solvers", "solvers"}, {earlier, "solvers", "solvers"},
                               {"scene", "contestant", "limit_Nm", "target_x_m", "target_y_m", "start"},
                               {"status", "solves", "iterations", "evaluations"}, "seconds"));
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
