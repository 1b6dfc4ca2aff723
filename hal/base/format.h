// printf into a string, for what people read.
#pragma once

#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace godobject {

/// At most 159 characters. Allocates.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  std::array<char, 160> text{};
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace godobject
