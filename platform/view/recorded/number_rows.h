// Rows of numbers, as traces have them, one at a time: those of a long run are not all wanted at once.
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

/// False: not as many numbers as there is room for.
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

/// The file: its line of names to begin(names), each row to add(line); both say what is wrong, or nothing. Empty, or that.
template <class Begin, class Add>
std::string read_rows(const std::string& path, Begin begin, Add add) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!in || !std::getline(in, line)) return path + ": cannot be read, or is empty";
  if (std::string why_not = begin(split_at_commas(line)); !why_not.empty()) return why_not;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (in.eof()) break;  // without a line end: a run that was killed was about to write it
    if (const std::string why_not = add(line); !why_not.empty())
      return path + ":" + std::to_string(number) + ": " + why_not;
  }
  return "";
}

}  // namespace godobject
