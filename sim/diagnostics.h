// Errors and warnings about a text file, each with its place.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace godobject {

/// Counted from 1.
struct TextPosition {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

/// "file:line:column: what"
inline std::string format_diagnostic(const std::string& file, TextPosition at, const std::string& what) {
  return file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + what;
}

/// At the end of `to`.
inline void append(std::vector<std::string>& to, const std::vector<std::string>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// The whole file; nothing where it cannot be read.
std::optional<std::string> read_text(const std::string& path);

class Diagnostics {
 public:
  explicit Diagnostics(std::string file) : file_(std::move(file)) {}

  void error(TextPosition at, std::string what) { errors_.push_back({at, std::move(what)}); }
  void warning(TextPosition at, std::string what) { warnings_.push_back({at, std::move(what)}); }

  bool has_error(TextPosition at) const;

  const std::string& file() const { return file_; }
  bool ok() const { return errors_.empty(); }
  /// Formatted, in the order of the file.
  std::vector<std::string> errors() const { return format(errors_); }
  std::vector<std::string> warnings() const { return format(warnings_); }

 private:
  struct Entry {
    TextPosition at;
    std::string what;
  };

  std::vector<std::string> format(std::vector<Entry> entries) const;

  std::string file_;
  std::vector<Entry> errors_, warnings_;
};

}  // namespace godobject
