#include "platform/scene/text/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <utility>

namespace godobject {
namespace {

constexpr std::size_t max_reported_rows = 20;
constexpr std::size_t max_columns = 1000;
constexpr std::string_view utf8_byte_order_mark = "\xEF\xBB\xBF";
constexpr std::size_t buffer_size = 1 << 16;  // bytes

CsvRows::Sink file_sink(const std::string& path) {
  return [file = std::make_shared<std::ofstream>(path, std::ios::binary)](std::string_view text) {
    file->write(text.data(), static_cast<std::streamsize>(text.size()));
    return !file->flush().fail();
  };
}

}  // namespace

// ---- reading --------------------------------------------------------------------------------------

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns_.begin());
}

CsvTable CsvTable::selected(std::span<const CsvColumn> columns) const {
  CsvTable table;
  for (const CsvColumn& column : columns) table.columns_.push_back(column.name);
  for (std::size_t row = 0; row < num_rows(); ++row) {
    const auto is_finite = [&](const CsvColumn& column) { return std::isfinite(at(row, column.from)); };
    if (!std::ranges::all_of(columns, is_finite)) continue;
    for (const CsvColumn& column : columns) {
      const double x = at(row, column.from);
      if (column.word) table.words_.push_back(column.word(x));
      table.values_.push_back(column.word ? std::numeric_limits<double>::quiet_NaN() : x);
      table.places_.push_back(place(row, column.from));
    }
  }
  return table;
}

/// Parses the text in one pass, line by line.
class CsvParser {
 public:
  CsvParser(const std::string& file, std::string_view word_column, const CsvWanted& keeps)
      : log_(file), word_column_(word_column), keeps_(keeps) {}

  CsvResult parse(std::string_view text) {
    if (text.starts_with(utf8_byte_order_mark)) text.remove_prefix(utf8_byte_order_mark.size());
    while (!text.empty() && num_errors_ < max_reported_rows) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      parse_line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (table_.columns_.empty()) error(1, "the header line is missing");
    if (!log_.ok()) return {std::nullopt, log_.errors(), log_.placed_errors()};
    return {std::move(table_), {}};
  }

 private:
  void parse_line(std::string_view line) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) return;
    if (is_kept_.empty()) {
      for_each_cell(line, [&](std::string_view cell, std::uint32_t column) { add_column(cell, column); });
      return;
    }
    std::size_t num_cells = 0;
    for_each_cell(line, [&](std::string_view cell, std::uint32_t column) {
      if (num_cells++ >= is_kept_.size()) return;  // counted, and rejected below
      if (!is_kept_[num_cells - 1]) return;
      const bool is_word = table_.columns_[table_.values_.size() % table_.columns_.size()] == word_column_;
      is_word ? add_word(cell, column) : add_value(cell, column);
    });
    if (num_cells != is_kept_.size())
      error(1, "has " + std::to_string(num_cells) + " values, the header " + std::to_string(is_kept_.size()));
  }

  template <class F>
  static void for_each_cell(std::string_view line, F use) {
    std::size_t begin = 0;
    while (begin <= line.size()) {
      const std::size_t end = std::min(line.find(',', begin), line.size());
      use(trimmed(line.substr(begin, end - begin)), static_cast<std::uint32_t>(begin + 1));
      begin = end + 1;
    }
  }

  static std::string_view trimmed(std::string_view cell) {
    while (cell.starts_with(' ')) cell.remove_prefix(1);
    while (cell.ends_with(' ')) cell.remove_suffix(1);
    return cell;
  }

  void add_column(std::string_view name, std::uint32_t column) {
    is_kept_.push_back(!keeps_ || keeps_(name));
    if (!is_kept_.back()) return;
    if (table_.columns_.size() == max_columns)
      error(column, "more than " + std::to_string(max_columns) + " columns");
    if (table_.columns_.size() >= max_columns) return;
    if (name.empty()) error(column, "a column has no name");
    if (table_.find(name)) error(column, "column " + excerpt(name) + " occurs twice: remove one");
    table_.columns_.emplace_back(name);
  }

  void add_value(std::string_view cell, std::uint32_t column) {
    double x = 0;
    const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
    if (status != std::errc{} || end != cell.data() + cell.size()) {
      error(column, excerpt(cell) + " is not a number");
    }
    table_.values_.push_back(x);
    table_.places_.push_back({line_, column});
  }

  void add_word(std::string_view cell, std::uint32_t column) {
    table_.words_.emplace_back(cell);
    table_.values_.push_back(std::numeric_limits<double>::quiet_NaN());
    table_.places_.push_back({line_, column});
  }

  void error(std::uint32_t column, const std::string& what) {
    ++num_errors_;
    log_.error({std::max(line_, 1u), column}, what);
  }

  Diagnostics log_;
  std::string_view word_column_;
  const CsvWanted& keeps_;
  std::vector<bool> is_kept_;  // for each column of the file
  CsvTable table_;
  std::uint32_t line_ = 0;
  std::size_t num_errors_ = 0;
};

CsvResult parse_csv(std::string_view text, const std::string& file, std::string_view word_column,
                    const CsvWanted& keeps) {
  return CsvParser(file, word_column, keeps).parse(text);
}

CsvResult read_csv(const std::string& path, std::string_view word_column, std::size_t max_bytes) {
  const FileText file = read_file(path, max_bytes);
  if (!file.text) return {std::nullopt, {printable(path) + ": " + file.why_not}};
  return parse_csv(*file.text, path, word_column);
}

// ---- writing --------------------------------------------------------------------------------------

CsvRows::CsvRows(const std::string& path) : CsvRows(file_sink(path)) { gathered_ = buffer_size; }

CsvRows::CsvRows(Sink sink) : sink_(std::move(sink)) { buffer_.reserve(2 * buffer_size); }

void CsvRows::header(std::span<const std::string> columns) {
  for (const std::string& column : columns) text(column);
  end_row();
}

void CsvRows::header(std::initializer_list<std::string_view> columns) {
  for (const std::string_view column : columns) text(column);
  end_row();
}

void CsvRows::number(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  buffer_.append(text.data(), end);
  buffer_ += ',';
}

void CsvRows::vector(const Vec3& a) {
  for (int i = 0; i < 3; ++i) number(a[i]);
}

void CsvRows::text(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    buffer_.append(text);
  } else {
    buffer_ += '"';
    for (const char c : text) buffer_.append(c == '"' ? 2 : 1, c);
    buffer_ += '"';
  }
  buffer_ += ',';
}

void CsvRows::end_row() {
  buffer_.back() = '\n';
  if (buffer_.size() > gathered_) flush();
}

bool CsvRows::close() {
  flush();
  return all_taken_;
}

void CsvRows::flush() {
  if (!buffer_.empty()) all_taken_ = sink_(buffer_) && all_taken_;
  buffer_.clear();
}

}  // namespace godobject
