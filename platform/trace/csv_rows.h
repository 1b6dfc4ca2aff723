// Rows of a CSV file on their way to it. Every number reads back as the same double.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "core/math/types.h"

namespace godobject {

/// Gathers rows for a file, and hands each row to a sink at once. Not for the real-time thread.
class CsvRows {
 public:
  /// Takes text; false: not all of it got where it is to go.
  using Sink = std::function<bool(std::string_view)>;

  /// Into a file.
  CsvRows(const std::string& path);  // NOLINT(google-explicit-constructor): a path stands for its file
  CsvRows(Sink sink);                // NOLINT(google-explicit-constructor)

  void header(std::span<const std::string> columns);
  void header(std::initializer_list<std::string_view> columns);
  void number(double x);
  void vector(const Vec3& a);
  /// In quotes where it has a comma, a quote or a line end in it.
  void text(std::string_view text);
  void end_row();
  /// Writes what is left. False when anything did not get there.
  [[nodiscard]] bool close();

 private:
  void flush();

  Sink sink_;
  bool all_taken_ = true;
  std::size_t gathered_ = 0;  // bytes that are gathered before the sink gets them
  std::string buffer_;
};

}  // namespace godobject
