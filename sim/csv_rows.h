// Rows of a CSV file on their way to it. Every number reads back as the same double.
#pragma once

#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "core/types.h"

namespace godobject {

/// Writes into a buffer and the buffer to the file when it is full. Not for the real-time thread.
class CsvRows {
 public:
  explicit CsvRows(const std::string& path);

  void header(std::span<const std::string> columns);
  void header(std::initializer_list<std::string_view> columns);
  void number(double x);
  void vector(const Vec3& a);
  /// In quotes where it has a comma, a quote or a line end in it.
  void text(std::string_view text);
  void end_row();
  /// Writes what is left. False when anything did not reach the file.
  [[nodiscard]] bool close();

 private:
  void flush();

  std::ofstream file_;
  std::string buffer_;
};

}  // namespace godobject
