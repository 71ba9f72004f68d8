#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tendril/app/chart.hpp"
#include "tendril/plan.hpp"

namespace tendril::bench {

/// What a table holds. Numbers that are not finite are printed as a dash and become null in JSON.
using Cell = std::variant<std::string, double, std::int64_t>;

struct Table {
  std::string name;  ///< of its file, without ending
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  bool printed = true;  ///< in the report; false: too long for people, a CSV file beside it only
};

struct Figure {
  std::string name;  ///< of its files, without ending
  std::string caption;
  app::Chart chart;
};

/// What one part of the bench found.
struct Section {
  std::string name;  ///< of its files: "accuracy", ...
  std::string title;
  std::vector<std::string> prose;  ///< paragraphs of plain text
  std::vector<Table> tables;
  std::vector<Figure> figures;
  std::vector<LeftOut> left_out;  ///< what could have been compared and was not
};

/// Quartiles of the machine's pace (see Pace) while something was measured, in a table of this name.
Table pace_table(const std::string& name, const std::vector<double>& seconds);

/// Three significant digits, integers as they are.
std::string text_of(const Cell& cell);

std::string markdown(const Table& table);
/// RFC 4180, all digits.
std::string csv(const Table& table);
/// Figures as links to the pictures beside it.
std::string markdown(const Section& section);
/// Figures from `pictures`: (name, SVG) each.
std::string html(const Section& section, const std::vector<std::pair<std::string, std::string>>& pictures);
/// Text for a page: < > & and quotes are written as entities.
std::string escaped(const std::string& text);
/// Tables with all digits, as one JSON object.
std::string json(const Section& section);

/// Tables as CSV and JSON, figures as SVG and PNG with script and data. Returns (name, SVG) of each figure.
std::vector<std::pair<std::string, std::string>> write_files(const Section& section, app::StagedFiles& files);

}  // namespace tendril::bench
