// Comma-separated numbers under a header line, and one column of words: motions in, traces out and in again.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/text/diagnostics.h"

namespace godobject {

/// A column of one table that becomes one of another.
struct CsvColumn {
  std::size_t from = 0;                               // its index
  std::string name;                                   // in the new table
  std::function<std::string(double)> word = nullptr;  // makes it the column of words
};

class CsvTable {
 public:
  /// These columns alone, in this order; rows with a number among them that is not finite are left out.
  CsvTable selected(std::span<const CsvColumn> columns) const;
  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t num_rows() const { return columns_.empty() ? 0 : values_.size() / columns_.size(); }
  std::optional<std::size_t> find(std::string_view column) const;
  double at(std::size_t row, std::size_t column) const { return values_[row * columns_.size() + column]; }
  /// The word of this row in the column of words.
  const std::string& word(std::size_t row) const { return words_[row]; }
  /// Where that number stands in the file.
  TextPosition place(std::size_t row, std::size_t column) const {
    return places_[row * columns_.size() + column];
  }

 private:
  friend class CsvParser;
  std::vector<std::string> columns_;
  std::vector<double> values_;        // row by row
  std::vector<TextPosition> places_;  // of each value
  std::vector<std::string> words_;    // of the column of words, which has NaN for values
};

struct CsvResult {
  std::optional<CsvTable> table;    // absent where there are errors
  std::vector<std::string> errors;  // "file:line:column: what", the first 20
};

/// word_column: the one column, if the table has it, that holds words instead of numbers.
CsvResult read_csv(const std::string& path, std::string_view word_column = {},
                   std::size_t max_bytes = max_csv_bytes);
/// As read_csv for a text; file is what messages call it.
/// wanted: takes a column's name; the others are left out, and do not count as columns. Null: all are wanted.
using CsvWanted = std::function<bool(std::string_view)>;
CsvResult parse_csv(std::string_view text, const std::string& file, std::string_view word_column = {},
                    const CsvWanted& wanted = nullptr);

}  // namespace godobject
