// Formats numbers and printf patterns as strings for users, and cuts texts without exceptions.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <string_view>

namespace godobject {

/// Returns at most `size` characters from `first` on; fewer where the text ends. substr() throws instead, so
/// the loop cannot call it (core/nonblocking.h).
constexpr std::string_view part_of(std::string_view text, std::size_t first,
                                   std::size_t size = std::string_view::npos) noexcept {
  first = std::min(first, text.size());
  return {text.data() + first, std::min(size, text.size() - first)};
}

/// Formats like printf; at most 159 characters. Allocates.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  std::array<char, 160> text{};
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

/// Returns the shortest decimal text that parses to the same double: "3", "0.1".
inline std::string shortest_plain(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  return {text.data(), end};
}

/// Returns the text of shortest_plain() with a decimal point or an exponent: "3.0".
inline std::string shortest(double x) {
  std::string text = shortest_plain(x);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

}  // namespace godobject
