#include "platform/scene/text/diagnostics.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <tuple>
#include <vector>

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_excerpt = 40;
constexpr std::size_t max_message = 1000;
constexpr std::size_t read_at_a_time = std::size_t{1} << 20;

/// Returns the length of the printable UTF-8 character at the start of the text; 0 if there is none.
std::size_t printable_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : static_cast<unsigned char>(0);
  };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7F ? 1 : 0;
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  const bool too_long = (byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xF0 && byte(1) < 0x90);
  const bool no_character = (byte(0) == 0xED && byte(1) > 0x9F) || (byte(0) == 0xF4 && byte(1) > 0x8F);
  const bool control = byte(0) == 0xC2 && byte(1) < 0xA0;
  return too_long || no_character || control ? 0 : length;
}

std::string megabytes(std::size_t bytes) { return std::to_string(bytes >> 20) + " MB"; }

/// Returns why a file is not opened: it is neither a file nor a pipe, or too large. The size of a pipe is
/// unknown here.
std::string why_not_opened(const std::string& path, std::size_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  switch (status.type()) {
    case fs::file_type::regular: break;
    case fs::file_type::fifo: return "";
    case fs::file_type::directory: return "cannot be read, because it is a directory";
    case fs::file_type::not_found:
    case fs::file_type::none: return "cannot be read: check the path";
    default: return "cannot be read, because it is neither a file nor a pipe";
  }
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return "cannot be read: " + error.message();
  return size > max_bytes ? "is larger than " + megabytes(max_bytes) + ", the limit of this program" : "";
}

constexpr std::size_t resemblance = 2;  // characters

/// Returns the smallest number of characters to insert, delete or replace.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    if (const std::size_t length = printable_length(text)) {
      out += text.substr(0, length);
      text.remove_prefix(length);
      continue;
    }
    std::array<char, 5> escaped{};
    std::snprintf(escaped.data(), escaped.size(), "\\x%02X",
                  static_cast<unsigned>(static_cast<unsigned char>(text.front())));
    out += escaped.data();
    text.remove_prefix(1);
  }
  return out;
}

std::string shortened(std::string_view text) {
  if (text.size() <= max_excerpt) return printable(text);
  return printable(text.substr(0, max_excerpt)) + "... (" + std::to_string(text.size()) + " bytes)";
}

std::string excerpt(std::string_view text) { return "'" + shortened(text) + "'"; }

FileText read_file(const std::string& path, std::size_t max_bytes) {
  const auto failed = [&](const std::string& why_not) { return FileText{std::nullopt, why_not}; };
  const std::string why_not = why_not_opened(path, max_bytes);
  if (!why_not.empty()) return failed(why_not);
  std::ifstream file(path, std::ios::binary);
  if (!file) return failed("cannot be read: check the path");
  std::string text;
  while (file && text.size() <= max_bytes) {
    const std::size_t end = text.size();
    text.resize(end + read_at_a_time);
    file.read(text.data() + end, read_at_a_time);
    text.resize(end + static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return failed("cannot be read to its end");
  if (text.size() > max_bytes)
    return failed("is larger than " + megabytes(max_bytes) + ", the limit of this program");
  return {std::move(text), ""};
}

std::optional<std::string> read_text(const std::string& path) { return read_file(path, max_toml_bytes).text; }

FilePath path_below(const std::string& folder, const std::string& name) {
  constexpr const char* where = ": put files of a scene into its folder or a folder below";
  const auto failed = [](const std::string& why_not) { return FilePath{"", why_not}; };
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.is_absolute()) return failed("is an absolute path" + std::string(where));
  if (!relative.empty() && *relative.begin() == "..")
    return failed("leads out of the scene's folder" + std::string(where));
  std::error_code error;
  const fs::path base = fs::canonical(folder.empty() ? "." : folder, error);
  const fs::path path = error ? fs::path() : fs::canonical(base / relative, error);
  if (error)
    return failed("cannot be read: check the path " + shortened(name) +
                  ", which is relative to the scene file");
  if (std::ranges::mismatch(base, path).in1 != base.end())
    return failed("is a link that leads out of the scene's folder" + std::string(where));
  if (!fs::is_regular_file(path, error)) return failed("cannot be read, because it is not a file");
  return {path.string(), ""};
}

void Diagnostics::add(Entries& entries, TextPosition at, std::string what) {
  if (entries.kept.size() < max_entries) entries.kept.push_back({at, std::move(what)});
  else ++entries.num_left_out;
}

bool Diagnostics::has_error(TextPosition at) const {
  return std::ranges::any_of(
      errors_.kept, [&](const Entry& e) { return e.at.line == at.line && e.at.column == at.column; });
}

std::vector<PlacedText> Diagnostics::placed(Entries entries) const {
  std::ranges::stable_sort(entries.kept, {},
                           [](const Entry& e) { return std::tuple(e.at.line, e.at.column); });
  const std::string file = printable(file_);
  std::vector<PlacedText> placed;
  for (const Entry& e : entries.kept) {
    const bool is_long = e.what.size() > max_message;
    const std::string what = is_long ? e.what.substr(0, max_message) + "..." : e.what;
    placed.push_back({.file = file, .at = e.at, .text = printable(what)});
  }
  if (entries.num_left_out > 0)
    placed.push_back(
        {.file = file, .at = {}, .text = "and " + std::to_string(entries.num_left_out) + " more"});
  return placed;
}

std::vector<std::string> Diagnostics::format(const std::vector<PlacedText>& entries) {
  std::vector<std::string> lines;
  for (const PlacedText& e : entries)
    lines.push_back(e.at ? format_diagnostic(e.file, *e.at, e.text) : e.file + ": " + e.text);
  return lines;
}

std::optional<std::string_view> nearest_name(std::string_view typed,
                                             std::span<const std::string_view> names) {
  std::optional<std::string_view> nearest;
  std::size_t least = resemblance + 1;
  for (const std::string_view name : names) {
    const std::size_t away = distance(typed, name);
    if (away >= least) continue;
    least = away;
    nearest = name;
  }
  return nearest;
}

}  // namespace godobject
