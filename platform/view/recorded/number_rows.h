// Reads rows of numbers, as in traces, one at a time, because long runs are not stored as a whole.
#pragma once

#include <charconv>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace godobject {

inline std::vector<std::string> split_at_commas(std::string_view line) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t comma = line.find(',');
    parts.emplace_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    line.remove_prefix(comma + 1);
  }
}

/// Returns false unless the line has exactly numbers.size() numbers.
inline bool read_numbers(std::string_view line, std::span<double> numbers) {
  const char *at = line.data(), *const end = at + line.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const bool is_last = i + 1 == numbers.size();
    if (error != std::errc() || (is_last ? next != end : next == end || *next != ',')) return false;
    at = next + 1;
  }
  return true;
}

/// Reads a file: passes its first line to begin(names) and each row to add(line). Both return empty or an
/// error. Returns empty or the first error.
template <class Begin, class Add>
std::string read_rows(const std::string& path, Begin begin, Add add) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!in || !std::getline(in, line)) return path + ": cannot be read, or is empty";
  if (std::string why_not = begin(split_at_commas(line)); !why_not.empty()) return why_not;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (in.eof()) break;  // without a line end: cut off when the run was killed
    if (const std::string why_not = add(line); !why_not.empty())
      return path + ":" + std::to_string(number) + ": " + why_not;
  }
  return "";
}

}  // namespace godobject
