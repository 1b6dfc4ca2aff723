// Comma-separated numbers below a header line, and one column of words, for motions and traces: read and
// written.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/types.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {

/// A column of one table that becomes a column of another.
struct CsvColumn {
  std::size_t from = 0;                               // index of the column
  std::string name;                                   // name in the new table
  std::function<std::string(double)> word = nullptr;  // makes it the column of words
};

class CsvTable {
 public:
  /// Returns these columns in this order, without rows in which one of their numbers is not finite.
  CsvTable selected(std::span<const CsvColumn> columns) const;
  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t num_rows() const { return columns_.empty() ? 0 : values_.size() / columns_.size(); }
  std::optional<std::size_t> find(std::string_view column) const;
  double at(std::size_t row, std::size_t column) const { return values_[row * columns_.size() + column]; }
  /// Returns this row's word of the column of words.
  const std::string& word(std::size_t row) const { return words_[row]; }
  /// Returns the place of the number in the file.
  TextPosition place(std::size_t row, std::size_t column) const {
    return places_[row * columns_.size() + column];
  }

 private:
  friend class CsvParser;
  std::vector<std::string> columns_;
  std::vector<double> values_;        // row by row
  std::vector<TextPosition> places_;  // place of each value
  std::vector<std::string> words_;    // words of that column, whose values are NaN
};

struct CsvResult {
  std::optional<CsvTable> table;            // absent if there are errors
  std::vector<std::string> errors;          // "file:line:column: text", the first 20
  std::vector<PlacedText> placed_errors{};  // the errors with their places
};

/// word_column: name of the one column that holds words instead of numbers, if the table has it.
CsvResult read_csv(const std::string& path, std::string_view word_column = {},
                   std::size_t max_bytes = max_csv_bytes);
/// Parses a text as read_csv() parses a file.
/// file: name in messages.
/// keeps: returns true for names of columns to keep; others are not counted. Null: all are kept.
using CsvWanted = std::function<bool(std::string_view)>;
CsvResult parse_csv(std::string_view text, const std::string& file, std::string_view word_column = {},
                    const CsvWanted& keeps = nullptr);

/// Writer of rows: buffers them for a file, or passes each row to a sink at once. Every number is printed so
/// that the same double is read back. Not for the real-time thread.
class CsvRows {
 public:
  /// Receives text; returns false if some of it was not written.
  using Sink = std::function<bool(std::string_view)>;

  /// Writes into a file.
  CsvRows(const std::string& path);  // NOLINT(google-explicit-constructor): a path stands for its file
  CsvRows(Sink sink);                // NOLINT(google-explicit-constructor)

  void header(std::span<const std::string> columns);
  void header(std::initializer_list<std::string_view> columns);
  void number(double x);
  void vector(const Vec3& a);
  /// Writes text, in quotes if it contains a comma, a quote or a line end.
  void text(std::string_view text);
  void end_row();
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close();

 private:
  void flush();

  Sink sink_;
  bool all_taken_ = true;
  std::size_t gathered_ = 0;  // bytes to buffer before the sink is called
  std::string buffer_;
};

}  // namespace godobject
