// Text files that somebody else may have written: how they are read, and errors and warnings about them, each with
// its place.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
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

/// With \xNN for every byte that is no UTF-8 or has no picture, so that no file writes to a terminal.
std::string printable(std::string_view text);
/// printable(), and not more than some 40 bytes of it: keys and words of a file may be megabytes long.
std::string shortened(std::string_view text);
/// The same in quotes.
std::string excerpt(std::string_view text);

/// Most that is read of a file. Scenes, profiles and faults are written by hand; an hour of motion is some 250 MB.
inline constexpr std::size_t max_toml_bytes = std::size_t{16} << 20;
inline constexpr std::size_t max_csv_bytes = std::size_t{512} << 20;

struct FileText {
  std::optional<std::string> text;
  std::string why_not;  // completes a sentence about the path where there is no text
};

/// The whole of a regular file, or all that comes through a pipe.
FileText read_file(const std::string& path, std::size_t max_bytes);
/// A file of a few pages; nothing where it cannot be read.
std::optional<std::string> read_text(const std::string& path);

struct FilePath {
  std::string path;     // absolute, without links
  std::string why_not;  // completes a sentence about the name where there is no path
};

/// Where the file is that a scene in `folder` names. A scene may come from anybody, and has no business with the
/// files of who runs it: only regular files below its folder are found, links included.
FilePath path_below(const std::string& folder, const std::string& name);

class Diagnostics {
 public:
  explicit Diagnostics(std::string file) : file_(std::move(file)) {}

  void error(TextPosition at, std::string what) { add(errors_, at, std::move(what)); }
  void warning(TextPosition at, std::string what) { add(warnings_, at, std::move(what)); }

  bool has_error(TextPosition at) const;

  const std::string& file() const { return file_; }
  bool ok() const { return errors_.kept.empty(); }
  /// No more of them are kept.
  bool full() const { return errors_.kept.size() >= max_entries; }
  /// Formatted, in the order of the file.
  std::vector<std::string> errors() const { return format(errors_); }
  std::vector<std::string> warnings() const { return format(warnings_); }

 private:
  static constexpr std::size_t max_entries = 100;

  struct Entry {
    TextPosition at;
    std::string what;
  };
  struct Entries {
    std::vector<Entry> kept{};
    std::size_t num_left_out = 0;
  };

  static void add(Entries& entries, TextPosition at, std::string what);
  std::vector<std::string> format(Entries entries) const;

  std::string file_;
  Entries errors_{}, warnings_{};
};

}  // namespace godobject
