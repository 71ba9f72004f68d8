#include "support/reference_table.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace tendril::support {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

}  // namespace

ReferenceTable::ReferenceTable(const std::string& name) {
  const std::string path = std::string(TENDRIL_REFERENCE_DATA) + "/" + name + ".csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::string line;
  std::getline(file, line);
  header_ = split(line);
  while (std::getline(file, line)) {
    if (line.empty()) continue;
    cells_.push_back(split(line));
    if (cells_.back().size() != header_.size()) throw std::runtime_error("ragged row in " + path);
  }
  if (cells_.empty()) throw std::runtime_error("no rows in " + path);
}

const std::string& ReferenceTable::text(std::size_t row, const std::string& column) const {
  const auto it = std::find(header_.begin(), header_.end(), column);
  if (it == header_.end()) throw std::runtime_error("no column " + column);
  return cells_.at(row)[static_cast<std::size_t>(it - header_.begin())];
}

double ReferenceTable::rounding(std::size_t row, const std::string& column) const {
  const std::string& cell = text(row, column);
  const std::size_t point = cell.find('.');
  const std::size_t decimals = point == std::string::npos ? 0 : cell.size() - point - 1;
  return 0.5 * std::pow(10.0, -static_cast<double>(decimals));
}

}  // namespace tendril::support
