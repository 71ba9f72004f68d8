#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tendril/app/units.hpp"

namespace tendril::app {

/// A column that a file may have.
struct ColumnSpec {
  std::string name;                 ///< as messages call it, in lower case
  Dimension dimension;              ///< of its numbers
  std::vector<std::string> also{};  ///< other names for it, in lower case
  bool text = false;                ///< it holds words
};

/// What is read of a file with one point, pose, ... on each line.
struct TableFileSpec {
  std::string what;                 ///< the file, in messages, and the table of the scene that it belongs to
  std::vector<ColumnSpec> columns;  ///< in the order of the values that are given back
  /// Columns that may stand together, each by its place in `columns`, in ascending order. A file without names is read
  /// by how many it has. None: any of them, with names.
  std::vector<std::vector<std::size_t>> forms;
  /// Those that may stand beside a form, with names; where their first value cannot be read they are others.
  std::vector<std::size_t> besides{};
  std::size_t most_rows = 0;  ///< more are refused
  std::size_t example = 0;    ///< the column that messages show with a unit
  double pixel = 0.0;         ///< m; what lengths without a unit, or in px, are multiples of. 0: they are in m
};

/// The numbers of such a file.
struct TableFile {
  std::vector<std::size_t> form;                ///< columns that it has
  std::vector<bool> with_unit;                  ///< for each of them whether the file says its unit
  std::vector<std::vector<double>> rows;        ///< SI, in the order of `form`; NaN: nothing was written there
  std::vector<std::vector<std::string>> texts;  ///< likewise, of columns of words; empty where there are none
  std::vector<int> lines;                       ///< of the file, for each row
  std::vector<bool> blank;                      ///< for each row whether every cell is empty
  std::vector<std::string> unread;              ///< names of its other columns
};

/// Reads a table as spreadsheets and cameras write it. Values stand between commas, semicolons, tabs or blanks, perhaps
/// in quotes; a first line of names may give units in brackets, or a second line the units alone; a decimal comma is
/// read where it can be nothing else. Lines without any value, and lines that begin with #, are skipped. Throws
/// InputError with line and column.
TableFile read_table_file(const std::filesystem::path& path, const TableFileSpec& spec, const Units& units);

}  // namespace tendril::app
