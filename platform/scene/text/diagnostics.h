// Reading of untrusted text files, and errors and warnings with their places and the nearest known name.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace godobject {

/// Place in a text, counted from 1.
struct TextPosition {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

/// Returns "file:line:column: text".
inline std::string format_diagnostic(const std::string& file, TextPosition at, const std::string& what) {
  return file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + what;
}

/// Appends `from` to `to`.
inline void append(std::vector<std::string>& to, const std::vector<std::string>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// An error or a warning with its place in a file.
struct PlacedText {
  std::string file;
  std::optional<TextPosition> at;  // none: of the whole file
  std::string text;
};

/// Escapes every byte that is not printable UTF-8 as \xNN, so that no file can control a terminal.
std::string printable(std::string_view text);
/// Returns printable() of at most 40 bytes or so, since keys and words of a file may be megabytes long.
std::string shortened(std::string_view text);
/// Returns shortened() in quotes.
std::string excerpt(std::string_view text);

/// Largest files to read. Scenes, profiles and faults are written by hand; an hour of motion is some 250 MB.
inline constexpr std::size_t max_toml_bytes = std::size_t{16} << 20;
inline constexpr std::size_t max_csv_bytes = std::size_t{512} << 20;

struct FileText {
  std::optional<std::string> text;
  std::string why_not;  // completes a sentence about the path if there is no text
};

/// Reads the whole of a regular file, or all bytes of a pipe.
FileText read_file(const std::string& path, std::size_t max_bytes);
/// Reads a file of a few pages; none if it cannot be read.
std::optional<std::string> read_text(const std::string& path);

struct FilePath {
  std::string path;     // absolute, links resolved
  std::string why_not;  // completes a sentence about the name if there is no path
};

/// Resolves the name of a file in a scene in `folder`. Only regular files below this folder are accepted,
/// links resolved, because a scene may be untrusted and must not read other files of the user.
FilePath path_below(const std::string& folder, const std::string& name);

class Diagnostics {
 public:
  explicit Diagnostics(std::string file) : file_(std::move(file)) {}

  void error(TextPosition at, std::string what) { add(errors_, at, std::move(what)); }
  void warning(TextPosition at, std::string what) { add(warnings_, at, std::move(what)); }

  bool has_error(TextPosition at) const;

  const std::string& file() const { return file_; }
  bool ok() const { return errors_.kept.empty(); }
  /// True if no more errors are kept.
  bool full() const { return errors_.kept.size() >= max_entries; }
  /// Return the entries formatted, in the order of the file.
  std::vector<std::string> errors() const { return format(placed(errors_)); }
  std::vector<std::string> warnings() const { return format(placed(warnings_)); }
  /// Return the same with their places.
  std::vector<PlacedText> placed_errors() const { return placed(errors_); }
  std::vector<PlacedText> placed_warnings() const { return placed(warnings_); }

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
  std::vector<PlacedText> placed(Entries entries) const;
  static std::vector<std::string> format(const std::vector<PlacedText>& entries);

  std::string file_;
  Entries errors_{}, warnings_{};
};

/// Returns the name with the smallest Levenshtein distance to `typed`; none if all are more than two away.
std::optional<std::string_view> nearest_name(std::string_view typed, std::span<const std::string_view> names);

}  // namespace godobject
