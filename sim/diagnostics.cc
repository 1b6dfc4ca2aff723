#include "sim/diagnostics.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>

namespace godobject {

std::optional<std::string> read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

bool Diagnostics::has_error(TextPosition at) const {
  return std::ranges::any_of(
      errors_, [&](const Entry& e) { return e.at.line == at.line && e.at.column == at.column; });
}

std::vector<std::string> Diagnostics::format(std::vector<Entry> entries) const {
  std::ranges::stable_sort(entries, {}, [](const Entry& e) { return std::tuple(e.at.line, e.at.column); });
  std::vector<std::string> lines;
  for (const Entry& e : entries) lines.push_back(format_diagnostic(file_, e.at, e.what));
  return lines;
}

}  // namespace godobject
