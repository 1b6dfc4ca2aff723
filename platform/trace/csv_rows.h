// Writer of CSV rows. Every number is printed so that the same double is read back.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "core/math/types.h"

namespace godobject {

/// Buffers rows for a file, or passes each row to a sink at once. Not for the real-time thread.
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
