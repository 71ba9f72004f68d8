#pragma once

#include <string>
#include <vector>

namespace tendril::support {

/// A table of reference numbers with a header line, as printed.
class ReferenceTable {
 public:
  /// Reads `<name>.csv` of the reference data. Throws std::runtime_error if it is missing, empty or ragged.
  explicit ReferenceTable(const std::string& name);

  std::size_t rows() const { return cells_.size(); }
  double value(std::size_t row, const std::string& column) const { return std::stod(text(row, column)); }
  /// Half a unit of the last digit printed: all that the number promises.
  double rounding(std::size_t row, const std::string& column) const;
  const std::string& text(std::size_t row, const std::string& column) const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> cells_;
};

}  // namespace tendril::support
